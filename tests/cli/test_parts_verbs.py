"""Shipped parts in `vvdp list`, files of parts in `vvdp new`."""

import json

PART = """title = "A leak"
[nodes]
a = { type = "port" }
b = { type = "port" }
[components]
gap = { type = "laminar-gap", a = "a", b = "b", conductance = "1e-12 m^3/(s*Pa)" }
[values]
conductance = "components.gap.conductance"
"""
WHOLE = """title = "A leak in a part"
[nodes]
a = { type = "port" }
b = { type = "port" }
[parts.leak]
file = "deeper/leak.toml"
a = "a"
b = "b"
"""
MAIN = """title = "A leaking accumulator"
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "100 bar" }
[parts.outer]
file = "parts/whole.toml"
a = "line"
b = "tank"
[run]
until = "10 ms"
"""


def test_shipped_parts_are_listed_with_ports_and_values(vvdp):
    found = json.loads(vvdp("list", "--components", "--json").out)
    assert {"nodes", "components", "programs", "parts"} <= found.keys()
    unit = found["parts"]["pump-unit"]
    assert unit["ports"] == ["load", "tank", "shaft (shaft)"]
    assert 'relief_pressure = "100 bar" [120 bar]' in unit["values"]
    assert found["parts"]["cylinder-load"]["ports"] == ["a", "b"]
    assert "[parts.NAME]" in vvdp("list", "--components").out


def test_new_copies_the_files_of_parts(vvdp, here):
    source = here / "elsewhere" / "parts"
    (source / "deeper").mkdir(parents=True)
    (source / "deeper" / "leak.toml").write_text(PART)
    (source / "whole.toml").write_text(WHOLE)
    (source.parent / "main.toml").write_text(MAIN)
    answer = vvdp("new", "mine", "--from", "elsewhere/main.toml", "--json")
    assert json.loads(answer.out)["parts"] == ["parts/whole.toml", "parts/deeper/leak.toml"]
    assert (here / "parts" / "deeper" / "leak.toml").read_text() == PART
    assert vvdp("show", "mine.toml").code == 0
    assert "already exists" in vvdp("new", "other", "--from", "elsewhere/main.toml").err


def test_show_names_parts_with_their_values(vvdp):
    shown = vvdp("show", "two-cylinders").out
    assert "parts.lift_unit.displacement" in shown and "load: lift_line" in shown


def test_new_copies_a_shipped_part(vvdp, here):
    assert 'file = "mine.toml"' in vvdp("new", "mine", "--from", "pump-unit").out
    assert 'title = "mine"' in (here / "mine.toml").read_text()
