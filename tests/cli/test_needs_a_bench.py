"""Verbs about the rotary valve refuse a system without one by name, and leave nothing behind."""

import pytest
from tests.words import wording

VERBS = [
    "map", "rig pressure-drop", "rig derived-capacity", "rig ripple", "rig step", "rig pump", "rig claims",
    "design optimum", "design pareto", "design tolerance", "design temperature", "valve",
]  # fmt: skip
DRAWN = """
nodes.line = { type = "volume", volume = "1 l", start = "50 bar" }
nodes.tank = { type = "tank" }
[components.drain]
type = "orifice"
a = "line"
b = "tank"
area = "1 mm^2"
discharge_coefficient = 0.6
transition_pressure = "0.1 bar"
[run]
until = "0.1 s"
"""


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_says_what_it_needs(vvdp, here, verb):
    (here / "drain.toml").write_text(DRAWN)
    refused = vvdp(*verb.split(), "drain.toml")
    assert refused.code == 2
    assert f"`vvdp {verb}` {wording.rig.needs_rotary_valve}" in " ".join(refused.err.split())
    assert [path.name for path in here.iterdir()] == ["drain.toml"]


@pytest.mark.parametrize("verb", [*VERBS, "geometry"])
def test_a_verb_asks_which_of_several_valves(vvdp, here, verb):
    refused = vvdp(*verb.split(), "two-cylinders")
    assert refused.code == 2
    assert wording.rig.several.format(names="lift_unit, swing_unit") in " ".join(refused.err.split())
    assert list(here.iterdir()) == []


def test_geometry_needs_one_rotary_valve(vvdp, here):
    (here / "drain.toml").write_text(DRAWN)
    refused = vvdp("geometry", "drain.toml")
    assert refused.code == 2
    assert wording.geometry.needs_one_valve in " ".join(refused.err.split())
    assert [path.name for path in here.iterdir()] == ["drain.toml"]
