"""Each type of the palette, dropped into an empty circuit with a node at each port, can be drawn."""

import re
import xml.etree.ElementTree as ET

import pytest

import vvdp
from vvdp.components.library import COMPONENTS
from vvdp.systems.drawing import NODES
from vvdp.systems.part_files import shipped_parts
from vvdp.workbench.palette import palette
from vvdp.workbench.schematic import drawing

NODE_OF = {"oil": "volume", "shaft": "shaft", "rod": "rod"}
ORIFICE = ["[components.other]", *(line for each in palette() if each["type"] == "orifice" for line in each["lines"])]


def node(name, word):
    """The table of a node with the values that the palette gives it."""
    (values,) = (each["lines"] for each in palette() if (each["table"], each["type"]) == ("nodes", word))
    return [f"[nodes.{name}]", f'type = "{word}"', *values]


def dropped(entry):
    """The text of a circuit of one entry, each of its ports at a node of its own."""
    lines = ['title = "dropped"', "[run]", 'until = "1 s"', f"[{entry['table']}.part]", f'type = "{entry["type"]}"']
    lines += [f'{port} = "part_{port}"' for port in entry["ports"]] + entry["lines"]
    for port, joins in entry["ports"].items():
        lines += node(f"part_{port}", NODE_OF[joins])
    if not entry["ports"]:  # a circuit has a component
        lines += [*ORIFICE, 'type = "orifice"', 'a = "one"', 'b = "two"', *node("one", "tank"), *node("two", "volume")]
    return "\n".join(lines)


def test_nothing_is_missing():
    assert [each["type"] for each in palette()] == [*NODES, *COMPONENTS, *shipped_parts()]


@pytest.mark.parametrize("entry", palette(), ids=lambda entry: entry["type"])
def test_a_dropped_part_is_drawn(entry):
    svg = drawing(vvdp.loads(dropped(entry)))
    assert re.search('data-(part|node)="part(_1)?"', svg)  # a flow control unit is drawn as its valves
    ET.fromstring(entry["symbol"])
