"""What a drawn network lacks to contain another one."""

import pytest

from vvdp.base.tables import parsed_table
from vvdp.network.likeness import lacks
from vvdp.systems.system import built_system

RIG = """
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "0.5 l", start = "20 bar" }

[components]
supply = { type = "flow-source", a = "tank", b = "line", flow = "10 lpm" }
drain = { type = "orifice", a = "line", b = "tank", area = "2 mm^2", discharge_coefficient = "0.6" }

[run]
until = "0.1 s"
"""
ORIFICE = 'type = "orifice", a = "line", b = "tank", area = "2 mm^2", discharge_coefficient = "0.6"'
GAP = 'type = "laminar-gap", a = "line", b = "tank", conductance = "3e-9 m^3/(s*Pa)"'


def network(text):
    return built_system(parsed_table(text, "rig.toml"), "rig").circuit.network


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("", "", []),
        ("10 lpm", "20 lpm", []),  # an input may follow anything
        ('"0.6"', '"0.7"', ["drain.discharge_coefficient is another one: 0.7 instead of 0.6"]),
        ("drain =", "other =", ["there is no component 'drain'", "'other' is joined to 'line' as well"]),
        (
            ORIFICE,
            GAP,
            ["component 'drain' is of another type"],
        ),
        (
            "[run]",
            '[components.leak]\ntype = "orifice"\na = "line"\nb = "tank"\narea = "1 mm^2"\n\n[run]',
            ["'leak' is joined to 'line' as well"],
        ),
        (
            "line = {",
            'pipe = { type = "volume", volume = "0.5 l", start = "20 bar" }\nline = {',
            [],
        ),
        (
            'tank = { type = "tank" }',
            'tank = { type = "pressure-source", pressure = "0 bar" }',
            ["node 'tank' is of another type"],
        ),
    ],
)
def test_the_sentences_say_what_is_missing(old, new, expected):
    assert list(lacks(network(RIG.replace(old, new)), network(RIG))) == expected


def test_a_node_that_is_missing_is_named():
    renamed = RIG.replace("line", "pipe")
    assert list(lacks(network(renamed), network(RIG))) == [
        "there is no node 'line'",
        "port 'b' of 'supply' is joined to 'pipe' instead of 'line'",
        "port 'a' of 'drain' is joined to 'pipe' instead of 'line'",
    ]
