"""What an FMU holds besides its description and code: terminals, icon, and a reference result."""

import io
import re
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree
from PIL import Image
from tests.export.builds import built, model_of
from tests.export.fmi_host import OK, Host
from tests.export.test_fmu import pytestmark

from vvdp.export.fmu_extras import REFERENCE_SAMPLES, Extras, reference_text, terminals
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
from vvdp.report.raster import icon_png
from vvdp.systems.system import shipped_systems

__all__ = ["pytestmark"]
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"


@cache
def whole(name, fmi):
    model = model_of(name)
    drawn = diagram(graph_of(model.system.circuit.network, model.system.title))
    return built(model, fmi, extras=Extras(drawn, icon_png(drawn), reference_text(model)))


@pytest.mark.parametrize("name", ["prototype", "transmission-speed-control"])
def test_terminals_follow_the_schema_and_have_known_variables(name):
    made = whole(name, 3)
    schema = etree.XMLSchema(etree.parse(Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"))
    root = etree.fromstring(made.entries[TERMINALS])
    schema.assertValid(root)
    members = [(each.getparent().get("name"), each.get("memberName")) for each in root.iter("TerminalMemberVariable")]
    assert len(set(members)) == len(members) > 20
    variables = {each.get("variableName") for each in root.iter("TerminalMemberVariable")}
    assert variables <= {each.name for each in made.model.variables}


def test_a_terminal_is_a_node_or_a_part():
    found = terminals(model_of("prototype"))
    assert found["load"] == {"area": "load.area", "flow": "load_flow"}
    assert found["inlet"] == {"pressure": "inlet"}
    assert found["pump_shaft"] == {"angle": "pump_shaft", "speed": "pump_shaft_speed", "torque": "output.pump_shaft"}
    assert "operation" not in found


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*shipped_systems(), *shipped_systems("practice")])
def test_no_two_numbers_are_one_member(name):
    """More than 0.6 of the outputs are members; others are shown twice, or belong to no part."""
    model = model_of(name)
    shown = [each for members in terminals(model).values() for each in members.values()]
    assert len(set(shown)) == len(shown)
    assert len(shown) > 0.6 * len(model.outputs)


def test_the_icon_is_a_small_picture():
    """900 by 397 pixels of the drawing at 0.4 dots each; in FMI 2 it has another name."""
    icon = whole("prototype", 3).entries["terminalsAndIcons/icon.png"]
    assert len(icon) < 5000
    assert Image.open(io.BytesIO(icon)).size == (360, 158)
    entries = whole("prototype", 2).entries
    assert entries["model.png"] == icon
    assert TERMINALS not in entries


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_reference_result_has_the_bits_of_the_binary(fmi, tmp_path):
    made = whole("prototype", fmi)
    head, *rows = made.entries["documentation/reference.csv"].decode().splitlines()
    names = head.split(",")
    assert names[:2] == ["time", "load_line"]
    expected = np.array([[float(word) for word in row.split(",")] for row in rows])
    assert expected.shape == (REFERENCE_SAMPLES + 1, 1 + 7)
    host = Host(made, tmp_path)
    assert host.begin() == OK
    found = [host.get(*names[1:])]
    for number in range(REFERENCE_SAMPLES):
        assert host.step(expected[number + 1, 0] - host.time) == OK, host.said
        found.append(host.get(*names[1:]))
    host.close()
    assert np.array(found).tobytes() == expected[:, 1:].tobytes()


def test_what_runs_seldom_is_told_to_the_compiler():
    """The rates and the explicit stepper are made fast, sampled programs and the stiff method short."""
    source = whole("prototype", 3).entries["sources/prototype_machine_core.c"].decode()
    heads = re.findall(r"^(SELDOM )?static (?!inline|const)[\w ]+?\*?(\w+?)_f\d+\(", source, re.M)
    seldom = {name: bool(mark) for mark, name in heads}
    assert not any(seldom[name] for name in ("rates", "circuit", "rotary_valve", "explicit_step"))
    assert all(seldom[name] for name in ("step", "event_filter_step", "stiff_step", "conditions", "first_change"))
