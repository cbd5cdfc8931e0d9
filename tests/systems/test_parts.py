"""Parts: circuits of one file inside of another, by name, nested, with their values, faults and mistakes."""

from pathlib import Path

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table, parsed_table, with_settings
from vvdp.components.library import COMPONENTS
from vvdp.evaluation.quantities import summary_units
from vvdp.evaluation.ranges import with_ends
from vvdp.evaluation.summary import summary
from vvdp.network.component import Component
from vvdp.simulation.run import simulate
from vvdp.simulation.values import flat
from vvdp.studies.run import run_study
from vvdp.studies.study import load_study
from vvdp.systems.part_files import PartFile, shipped_part, shipped_parts
from vvdp.systems.part_offers import part_ports, part_values
from vvdp.systems.part_scopes import UNNAMED, Scope
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import System, built_system, load_system, source_text

BRAKE = """title = "A throttled chamber"

[nodes.line]
type = "port"

[nodes.tank]
type = "port"

[nodes.chamber]
type = "volume"
volume = { value = "40 cc", status = "assumed" }
start = "20 bar"

[components.inlet]
type = "orifice"
a = "line"
b = "chamber"
area = "4 mm^2"

[components.outlet]
type = "orifice"
a = "chamber"
b = "tank"
area = "3 mm^2"

[values]
volume = "nodes.chamber.volume"
inlet_area = "components.inlet.area"
both_areas = ["components.inlet.area", "components.outlet.area"]
outlet_area = { sets = "components.outlet.area", value = "2 mm^2", status = "assumed", note = "of the part" }
"""
PAIR = """title = "Two chambers"

[nodes]
line = { type = "port" }
tank = { type = "port" }

[parts.left]
file = "brake.toml"
line = "line"
tank = "tank"

[parts.right]
file = "brake.toml"
line = "line"
tank = "tank"
volume = "60 cc"

[values]
left_volume = "parts.left.volume"
right_volume = "parts.right.volume"
"""
MAIN = """title = "A pump and its parts"

[nodes]
tank = { type = "tank" }
rail = { type = "volume", volume = "50 cc", start = "30 bar" }

[components.pump]
type = "flow-source"
a = "tank"
b = "rail"
flow = "20 lpm"

[parts.one]
file = "brake.toml"
line = "rail"
tank = "tank"

[parts.pair]
file = "pair.toml"
line = "rail"
tank = "tank"
right_volume = { value = "70 cc", status = "measured" }

[run]
until = "50 ms"
"""
PLAIN = """title = "A pump and its parts"

[nodes]
tank = { type = "tank" }
rail = { type = "volume", volume = "50 cc", start = "30 bar" }
one_chamber = { type = "volume", volume = "40 cc", start = "20 bar" }
pair_left_chamber = { type = "volume", volume = "40 cc", start = "20 bar" }
pair_right_chamber = { type = "volume", volume = "70 cc", start = "20 bar" }

[components]
pump = { type = "flow-source", a = "tank", b = "rail", flow = "20 lpm" }
one_inlet = { type = "orifice", a = "rail", b = "one_chamber", area = "4 mm^2" }
one_outlet = { type = "orifice", a = "one_chamber", b = "tank", area = "2 mm^2" }
pair_left_inlet = { type = "orifice", a = "rail", b = "pair_left_chamber", area = "4 mm^2" }
pair_left_outlet = { type = "orifice", a = "pair_left_chamber", b = "tank", area = "2 mm^2" }
pair_right_inlet = { type = "orifice", a = "rail", b = "pair_right_chamber", area = "4 mm^2" }
pair_right_outlet = { type = "orifice", a = "pair_right_chamber", b = "tank", area = "2 mm^2" }

[run]
until = "50 ms"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "brake.toml").write_text(BRAKE)
    (tmp_path / "pair.toml").write_text(PAIR)
    return tmp_path


def system(folder: Path, text: str, *settings: str) -> System:
    (folder / "main.toml").write_text(text)
    return load_system(str(folder / "main.toml"), settings)


def faults(folder: Path, text: str, *settings: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        system(folder, text, *settings)
    return [str(fault).replace(f"{folder}/", "") for fault in caught.value.faults]


def rows(drawn: System) -> dict[str, float]:
    return {row.setting: row.nominal for row in drawn.rows}


def test_the_same_circuit_without_parts_has_the_same_bits(folder):
    with_parts, plain = system(folder, MAIN), built_system(parsed_table(PLAIN, "plain.toml"), "plain")
    runs = [simulate(each.model, each.case, each.stepping) for each in (with_parts, plain)]
    assert runs[0].steps == runs[1].steps
    assert np.array_equal(runs[0].final, runs[1].final)
    found, expected = (summary(each, run) for each, run in zip((with_parts, plain), runs, strict=True))
    own = {"loss_one_W", "loss_pair_W", "loss_pair_left_W", "loss_pair_right_W"}
    assert found.keys() - expected.keys() == own
    assert {k: v for k, v in found.items() if k in expected and k != "wall_time_s"} == {
        k: v for k, v in expected.items() if k != "wall_time_s"
    }
    assert own <= summary_units(with_parts).keys()


def test_the_loss_of_a_part_is_the_sum_of_what_is_in_it(folder):
    drawn = system(folder, MAIN)
    found = summary(drawn, simulate(drawn.model, drawn.case, drawn.stepping))
    assert found["loss_pair_left_W"] == found["loss_pair_left_inlet_W"] + found["loss_pair_left_outlet_W"]
    assert found["loss_pair_W"] == pytest.approx(found["loss_pair_left_W"] + found["loss_pair_right_W"])
    assert found["loss_one_W"] > 0.0


def test_values_come_from_the_part_its_table_of_values_and_its_use(folder):
    found = system(folder, MAIN)
    values = rows(found)
    assert values["nodes.one_chamber.volume"] == pytest.approx(40e-6)
    assert values["nodes.pair_right_chamber.volume"] == pytest.approx(70e-6)
    assert values["components.one_outlet.area"] == pytest.approx(2e-6)
    by_path = {row.setting: row for row in found.rows}
    assert by_path["nodes.pair_right_chamber.volume"].status == "measured"
    assert by_path["components.one_outlet.area"].note == "of the part"


@pytest.mark.parametrize(
    "setting, path, value",
    [
        ("parts.one.volume=50 cc", "nodes.one_chamber.volume", 50e-6),
        ("parts.pair.left_volume=50 cc", "nodes.pair_left_chamber.volume", 50e-6),
        ("nodes.one.chamber.volume=50 cc", "nodes.one_chamber.volume", 50e-6),
        ("nodes.one_chamber.volume=50 cc", "nodes.one_chamber.volume", 50e-6),
        ("nodes.pair.left.chamber.volume=50 cc", "nodes.pair_left_chamber.volume", 50e-6),
        ("components.pair.left.inlet.area=5 mm^2", "components.pair_left_inlet.area", 5e-6),
    ],
)
def test_a_setting_reaches_what_is_inside(folder, setting, path, value):
    assert rows(system(folder, MAIN, setting))[path] == pytest.approx(value)
    drawn = system(folder, MAIN)
    assert rows(drawn.read_from(with_settings(drawn.table, [setting])))[path] == pytest.approx(value)


def test_a_system_keeps_its_text_when_others_are_read_from_it(folder):
    drawn = system(folder, MAIN)
    before = resolved_text(drawn)
    table = drawn.table
    content = {
        **table.content,
        "parts": {**table.content["parts"], "one": {**table.content["parts"]["one"], "volume": "1 cc"}},
    }
    assert rows(drawn.read_from(Table("", content, {})))["nodes.one_chamber.volume"] == pytest.approx(1e-6)
    assert resolved_text(drawn) == before


def test_one_value_may_set_several(folder):
    values = rows(system(folder, MAIN, "parts.one.both_areas=7 mm^2"))
    assert values["components.one_inlet.area"] == pytest.approx(7e-6)
    assert values["components.one_outlet.area"] == pytest.approx(7e-6)  # in spite of the default of another value


def test_what_is_stored_needs_no_file_of_a_part(folder):
    drawn = system(folder, MAIN, "parts.one.volume=50 cc")
    (folder / "brake.toml").unlink()
    again = built_system(parsed_table(resolved_text(drawn), "system.toml"), drawn.name)
    assert [flat(again.case.params).tolist(), flat(again.case.state).tolist()] == [
        flat(drawn.case.params).tolist(),
        flat(drawn.case.state).tolist(),
    ]
    assert again.circuit.network.circuits == drawn.circuit.network.circuits
    assert resolved_text(again) == resolved_text(drawn)


@pytest.mark.parametrize(
    "before, after",
    [
        ('line = "rail"', 'line = "rial"'),
        ('"nodes.one_chamber.volume"', '"nodes.none.volume"'),
        ('["nodes.one_chamber.volume"]', "5"),
        ('names = ["one_', 'names = [1, "one_'),
        ('source = "brake.toml"', "source = 1"),
    ],
)
def test_a_stored_part_that_was_changed_is_refused(folder, before, after):
    text = resolved_text(system(folder, MAIN))
    assert before in text
    with pytest.raises(ConfigError, match=r"parts.one.drawn: is not what vvdp keeps of a part"):
        built_system(parsed_table(text.replace(before, after, 1), "system.toml"), "main")


def test_names_inside_are_read_with_a_dot(folder):
    text = MAIN + (
        '[programs.watch]\ntype = "unloading"\npilot_pressure = "pair.left.chamber.pressure"\n'
        'cut_out_pressure = "50 bar"\ncut_in_pressure = "40 bar"\n'
        '[faults.leak]\nvalue = "components.pair.left.outlet.area"\nbecomes = "9 mm^2"\n'
        '[faults.grown]\nvalue = "parts.one.volume"\nbecomes = "90 cc"\n'
        '[faults.off]\nsensor = "watch.pilot_pressure"\nfrozen = true\n'
    )
    found = system(folder, text)
    assert found.circuit.network.programs["watch"].reads == {"pilot_pressure": "pair_left_chamber.pressure"}
    assert found.circuit.network.nodes["one_chamber"].values.volume == pytest.approx(90e-6)
    assert [each.fault.path for each in found.faults[:2]] == [
        "components.pair_left_outlet.area",
        "nodes.one_chamber.volume",
    ]


def test_a_fault_jams_what_is_inside():
    text = source_text("two-cylinders") + '[faults.seized]\njams = "lift.rod"\nforce = "50 kN"\nbegin = "0.3 s"\n'
    network = built_system(parsed_table(text, "my.toml"), "my").circuit.network
    assert network.parts["seized"].nodes == {"rod": "lift_rod"}


def test_a_value_may_follow_the_circuit_around_the_part(folder):
    text = MAIN.replace("right_volume =", "# ").replace("[run]", '[components.drive]\ntype = "two-way-valve"\n[run]')
    assert any("drive" in fault for fault in faults(folder, text))
    (folder / "brake.toml").write_text(
        BRAKE.replace(
            'type = "orifice"\na = "line"',
            'type = "proportional-valve"\n'
            'conductance = "3e-7 m^3/(s*Pa^0.5)"\nleakage_conductance = "0 m^3/(s*Pa)"\ntransition_pressure = "1 bar"\n'
            'lag = "1 ms"\na = "line"',
        )
        .replace('area = "4 mm^2"', 'command = "1"')
        .replace('inlet_area = "components.inlet.area"', 'opening = "components.inlet.command"')
        .replace('both_areas = ["components.inlet.area", "components.outlet.area"]\n', "")
    )
    text = MAIN.replace("[parts.pair]", 'opening = { from = "watch.unloaded" }\n[parts.pair]') + (
        '[programs.watch]\ntype = "unloading"\npilot_pressure = "one.chamber.pressure"\n'
        'cut_out_pressure = "50 bar"\ncut_in_pressure = "40 bar"\n'
    )
    assert system(folder, text).circuit.network.parts["one_inlet"].inputs["command"] == "watch.unloaded"


USE = MAIN.index("[parts.one]")
LINE = MAIN[:USE].count("\n") + 1


def changed(before: str, after: str) -> str:
    assert before in MAIN
    return MAIN.replace(before, after, 1)


@pytest.mark.parametrize(
    "text, message",
    [
        (changed('line = "rail"', 'lime = "rail"\nline = "rail"'),
         "main.toml:15: parts.one.lime: brake.toml offers no port 'lime'; did you mean 'line'?"),
        (changed('line = "rail"\n', ""),
         "main.toml:13: parts.one: port 'line' is not connected; join it to one of tank, rail"),
        (changed('line = "rail"', 'line = "rial"'),
         "main.toml:15: parts.one.line: port 'line' ends at 'rial', which is no node; did you mean 'rail'?"),
        (changed('line = "rail"', 'line = "rail"\nvolumes = "1 cc"'),
         "main.toml:16: parts.one.volumes: brake.toml offers no value 'volumes'; did you mean 'volume'?"),
        (changed('line = "rail"', 'line = "rail"\nvolume = "1 bar"'),
         "main.toml:16: parts.one.volume: '1 bar' is not a volume; write for example '12.7 cc'"),
        (changed("[parts.one]", "[parts.pump]"),
         "main.toml:7: components.pump: the name 'pump' is that of a part as well; choose another"),
        (changed('rail = {', 'shaft = { type = "shaft" }\nrail = {').replace('line = "rail"', 'line = "shaft"', 1),
         "main.toml:16: parts.one.line: port 'line' carries oil; 'shaft' is a shaft"),
        (changed('"brake.toml"', '"break.toml"'),
         "main.toml:14: parts.one.file: no file 'break.toml' in FOLDER; did you mean 'brake.toml'?"),
        (changed('file = "brake.toml"', 'type = "pump_unit"'),
         "main.toml:13: parts.one: 'pump_unit' is no shipped part; did you mean 'pump-unit'?"),
        (changed("[components.pump]", "[components.one_inlet]"),
         "brake.toml:14: components.inlet: the name 'one_inlet' is taken by components.one_inlet; choose another "
         "(used as one at main.toml:13)"),
        (MAIN + '[nodes.one.champer]\nvolume = "1 cc"\n',
         "main.toml:26: nodes.one.champer: no such name among the nodes; did you mean 'one_chamber'?"),
        (MAIN + '[components.leak]\ntype = "orifice"\na = "one.chamber"\nb = "tank"\narea = "1 mm^2"\n',
         "main.toml:26: components.leak: port 'a' ends at 'one_chamber', inside of 'one', whose ports are line, tank"),
        (MAIN + '[parts.one]\ntype = "pump-unit"\n',
         "main.toml: is not valid TOML: Cannot declare ('parts', 'one') twice"),
    ],
)  # fmt: skip
def test_a_mistake_in_the_use_has_its_line(folder, text, message):
    found = [fault.replace(str(folder), "FOLDER").replace("main.toml:26: is not", "main.toml: is not")
             for fault in faults(folder, text)]  # fmt: skip
    assert found == [message]


@pytest.mark.parametrize(
    "before, after, message",
    [
        ('area = "4 mm^2"', 'area = "4 bar"', "brake.toml:18: components.inlet.area: '4 bar' is not an area"),
        ('b = "chamber"', 'b = "chambre"', "brake.toml:14: components.inlet: port 'b' ends at 'one_chambre'"),
        ('a = "line"', 'a = "rail"', "brake.toml:14: components.inlet: port 'a' ends at 'one_rail'"),
        ('"nodes.chamber.volume"', '"nodes.chambre.volume"', "brake.toml:27: values.volume: 'nodes.chambre.volume'"),
        ('"nodes.chamber.volume"', '"oil.density"', "brake.toml:27: values.volume: 'oil.density' is no path"),
        ("title", 'circuit = "danger:network"\ntitle', "brake.toml:1: circuit: unknown key"),
        ("[values]", "[limits]", "brake.toml:26: limits: unknown table"),
        ("[nodes.chamber]", "[nodes.third]\ntype = \"port\"\n[nodes.chamber]", "main.toml:13: parts.one: port 'third'"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_part_has_both_lines(folder, before, after, message):
    (folder / "brake.toml").write_text(BRAKE.replace(before, after, 1))
    text = MAIN[: MAIN.index("[parts.pair]")] + MAIN[MAIN.index("[run]") :]
    first = faults(folder, text)[0]
    assert first.startswith(message)
    assert first.endswith("(used as one at main.toml:13)") or "third" in message


def test_a_part_of_itself_is_refused_with_the_chain(folder):
    (folder / "brake.toml").write_text(BRAKE + '[parts.more]\nfile = "pair.toml"\nline = "line"\ntank = "tank"\n')
    assert faults(folder, MAIN[: MAIN.index("[parts.pair]")] + MAIN[MAIN.index("[run]") :]) == [
        "pair.toml:7: parts.left: brake.toml would be a part of itself: main.toml -> brake.toml -> pair.toml -> "
        "brake.toml (used as more at brake.toml:31, used as one at main.toml:13)",
        "pair.toml:12: parts.right: brake.toml would be a part of itself: main.toml -> brake.toml -> pair.toml -> "
        "brake.toml (used as more at brake.toml:31, used as one at main.toml:13)",
    ]


def test_a_part_is_no_system(folder):
    with pytest.raises(ConfigError, match="only a part has this; use the file in another one"):
        load_system(str(folder / "brake.toml"))


@pytest.mark.parametrize("name", ["type", "line"])
def test_a_value_with_the_name_of_another_key_is_refused(folder, name):
    (folder / "brake.toml").write_text(BRAKE.replace('volume = "nodes', f'{name} = "nodes'))
    assert f"brake.toml:27: values.{name}: means something else where the part is used" in str(
        faults(folder, MAIN[: MAIN.index("[parts.pair]")] + MAIN[MAIN.index("[run]") :])
    )


def test_a_study_reaches_the_values_of_a_part(folder):
    (folder / "main.toml").write_text(MAIN)
    (folder / "area.toml").write_text(
        'system = "main.toml"\noutputs = ["loss_one_W", "pressure_mean_pair_left_chamber_Pa"]\n'
        '[grid]\n"parts.one.inlet_area" = ["2 mm^2", "4 mm^2"]\n'
        '"nodes.pair.left.chamber.volume" = ["30 cc", "50 cc"]\n'
    )
    found = run_study(load_study(folder / "area.toml"), folder / "results")
    assert list(found.inputs["parts.one.inlet_area"].values) == pytest.approx([2e-6, 2e-6, 4e-6, 4e-6])
    assert list(found.inputs["nodes.pair.left.chamber.volume"].values) == pytest.approx([30e-6, 50e-6] * 2)
    losses = found.outputs["loss_one_W"].values
    assert len(set(losses)) > 1 and np.all(np.isfinite(losses))


def test_a_range_inside_of_a_part_is_one_of_the_system(folder):
    ranged = 'volume = { value = "40 cc", range = ["30 cc", "50 cc"], status = "assumed" }'
    (folder / "brake.toml").write_text(BRAKE.replace('volume = { value = "40 cc", status = "assumed" }', ranged))
    drawn = system(folder, MAIN)
    assert [row.setting for row in drawn.uncertainties] == [
        f"nodes.{part}_chamber.volume" for part in ("one", "pair_left")
    ]
    low = with_ends(drawn, {drawn.uncertainties[1]: 0})
    assert rows(low)["nodes.pair_left_chamber.volume"] == pytest.approx(30e-6)


def test_a_value_that_is_missing_is_asked_for_at_the_use(folder):
    (folder / "brake.toml").write_text(BRAKE.replace('volume = { value = "40 cc", status = "assumed" }\n', ""))
    assert faults(folder, MAIN[: MAIN.index("[parts.pair]")] + MAIN[MAIN.index("[run]") :]) == [
        "main.toml:13: parts.one.volume: missing key 'volume', for example \"12.7 cc\""
    ]


def test_two_cylinders_need_few_lines_and_are_trusted(ran):
    lines = [line for line in source_text("two-cylinders").splitlines() if line and not line.startswith("#")]
    assert len(lines) <= 90
    found, _ = ran("two-cylinders", until="4 s")
    assert found["trusted"]
    assert found["position_max_lift_rod_m"] > 0.2 and found["position_max_swing_rod_m"] > 0.2
    inside = ("pump", "relief_valve", "valve")
    assert found["loss_lift_unit_W"] == pytest.approx(sum(found[f"loss_lift_unit_{part}_W"] for part in inside))


@pytest.mark.parametrize("name", shipped_parts())
def test_a_shipped_part_offers_ports_and_values_that_exist(name):
    part = shipped_part(name)
    assert all(part_ports(part).values())
    assert all(each.kind is not None and each.default for each in part_values(part).values())


def test_no_port_or_input_has_the_name_of_a_key_that_is_never_a_name():
    inputs = {argument.name for each in COMPONENTS.values() if isinstance(each, Component) for argument in each.inputs}
    ports = {port for each in COMPONENTS.values() for port in each.ports}
    assert not UNNAMED & (inputs | ports)


def test_names_are_those_of_the_drawn_circuit_and_other_texts_stay():
    table = Table("part.toml", {"nodes": {"line": {"type": "port"}, "bowl": {}}, "parts": {"inner": {}}}, {})
    scope = Scope(PartFile("part.toml", table), "outer_", {"line": "rail"})
    entry = {"type": "line", "reads": ["line.pressure", "bowl.pressure", "t"], "gain": "0.5 1/bar", "a": "line"}
    assert scope.rename(entry | {"b": "nowhere", "c": {"from": "other.value"}}, {"outer_inner"}, {"b"}) == {
        "type": "line",
        "reads": ["rail.pressure", "outer_bowl.pressure", "t"],
        "gain": "0.5 1/bar",
        "a": "rail",
        "b": "outer_nowhere",
        "c": {"from": "outer_other.value"},
    }
    assert scope.rename("inner.bowl.pressure", {"outer_inner"}) == "outer_inner_bowl.pressure"
    assert scope.rename({"table": [["0 s", "1"]], "note": "line"}, ()) == {"table": [["0 s", "1"]], "note": "line"}
