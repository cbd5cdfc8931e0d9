"""Values of a drawn circuit under short paths: tables by the name of what they belong to, and those of [values]."""

import numpy as np
import pytest
from tests.systems.drawn_orifice import ORIFICE
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table, copy_tables, parsed_table
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.bench_parts import is_bench
from vvdp.evaluation.overview import warnings
from vvdp.evaluation.summary import summary
from vvdp.evaluation.unit_rig import unit_on_rig
from vvdp.simulation.run import simulate
from vvdp.simulation.values import flat
from vvdp.systems.system import built_system, load_system, source_text

SHORT = """title = "A pump with an orifice"

[nodes]
tank = { type = "tank" }
line = { type = "volume" }
motor = { type = "driven-shaft" }

[components]
pump = { type = "pump", inlet = "tank", outlet = "line", shaft = "motor" }
load = { type = "orifice", a = "line", b = "tank" }

[values]
operation.speed = "nodes.motor.speed"
first.pressure = "nodes.line.start"
edges = "components.load"

[operation]
speed = { value = "1500 rpm", range = ["1400 rpm", "1600 rpm"], status = "assumed" }
oil_temperature = "50 degC"

[first]
pressure = "20 bar"

[line]
volume = "100 cc"

[pump]
displacement = "10 cc/rev"
leakage_conductance = "0 m^3/(s*Pa)"
ripple_amplitude = "0"
ripple_count = "9"
friction_torque = "0 N*m"

[load]
area = "3 mm^2"

[edges]
discharge_coefficient = "0.6"
transition_pressure = "0.05 bar"

[run]
until = "50 ms"
"""
FULL = (
    """title = "A pump with an orifice"

[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "100 cc", start = "20 bar" }
motor = { type = "driven-shaft", speed = "1500 rpm" }

[components.pump]
type = "pump"
inlet = "tank"
outlet = "line"
shaft = "motor"
displacement = "10 cc/rev"
leakage_conductance = "0 m^3/(s*Pa)"
ripple_amplitude = "0"
ripple_count = "9"
friction_torque = "0 N*m"

"""
    + ORIFICE
    + """
[operation]
oil_temperature = "50 degC"

[run]
until = "50 ms"
"""
)


def built(text):
    return built_system(parsed_table(text, "own.toml"), "own")


def faults_of(text):
    with pytest.raises(ConfigError) as refused:
        built(text)
    return [str(fault) for fault in refused.value.faults]


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(SHORT)
    return str(path)


def test_it_is_the_circuit_with_full_paths():
    """The same equations and the same numbers: only the places in the file differ."""
    short, full = built(SHORT), built(FULL)
    assert short.circuit.text == full.circuit.text
    assert np.array_equal(flat(short.case.state), flat(full.case.state))
    assert short.case.params == full.case.params


def test_values_are_listed_where_they_stand_in_the_order_of_the_file():
    rows = [row.setting for row in built(SHORT).rows if row.note != "default"]
    told = ["operation.oil_temperature", "operation.speed", "first.pressure", "line.volume", "pump.displacement"]
    assert [row for row in rows if row in told] == ["operation.oil_temperature", *told[1:]]
    assert rows.index("edges.discharge_coefficient") > rows.index("load.area")
    (ranged,) = built(SHORT).uncertainties
    assert ranged.setting == "operation.speed"


@pytest.mark.parametrize("setting", ["edges.discharge_coefficient", "components.load.discharge_coefficient"])
def test_a_setting_may_have_either_path(own, setting):
    system = load_system(own, [f"{setting}=0.7"])
    assert system.circuit.network.parts["load"].values[0].discharge_coefficient == 0.7
    assert system.content["edges"]["discharge_coefficient"] == "0.7"


def test_a_setting_may_leave_out_the_group_of_a_full_path(tmp_path):
    path = tmp_path / "full.toml"
    path.write_text(FULL)
    system = load_system(str(path), ["load.area=5 mm^2", "line.start=30 bar"])
    assert system.content["components"]["load"]["area"] == "5 mm^2"
    assert system.content["nodes"]["line"]["start"] == "30 bar"


def test_a_fault_finds_the_value(own):
    system = load_system(own, ["faults.worn.value=edges.discharge_coefficient", "faults.worn.becomes=0.8"])
    assert system.circuit.network.parts["load"].values[0].discharge_coefficient == 0.8


def test_a_fault_of_a_misspelt_value_names_the_paths_of_the_file():
    text = SHORT + '\n[faults.worn]\nvalue = "edges.discharge_coeficient"\nbecomes = "0.8"\n'
    (told,) = faults_of(text)
    assert told.endswith("did you mean 'edges.discharge_coefficient'?")


def test_what_stands_twice_is_refused_with_its_line():
    text = SHORT.replace('b = "tank" }', 'b = "tank", transition_pressure = "1 bar" }')
    (told,) = faults_of(text)
    line = text.splitlines().index('transition_pressure = "0.05 bar"') + 1
    assert told.startswith(f"own.toml:{line}: edges.transition_pressure: ")
    assert wording.systems.given_twice.format(other="components.load.transition_pressure") in told
    (told,) = faults_of(SHORT.replace('area = "3 mm^2"', 'area = "3 mm^2"\ntransition_pressure = "1 bar"'))
    assert wording.systems.given_twice.format(other="load.transition_pressure") in told


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ("\nspeed = {", "\nsped = {", "operation.sped: unknown key; did you mean 'speed'"),
        ("[first]\npressure", "[first]\npresure", "first.presure: unknown key; did you mean 'pressure'"),
        ('discharge_coefficient = "0.6"', 'discharge = "0.6"', "edges.discharge: unknown key"),
        ('"nodes.motor.speed"', '"nodes.moter.speed"', "leads to nothing that is drawn; did you mean 'nodes.motor'"),
        ('edges = "components.load"', 'edges = "components.load.area"', "leads to nothing that is drawn"),
        ("[line]", "[lime]", "lime: unknown table"),
        ('displacement = "10 cc/rev"', 'displacement = "10 bar"', "pump.displacement: '10 bar' is not a displacement"),
    ],
)  # fmt: skip
def test_a_slip_is_told_at_the_path_of_the_file(before, after, told):
    assert before in SHORT
    assert any(told in fault for fault in faults_of(SHORT.replace(before, after))), faults_of(
        SHORT.replace(before, after)
    )


def test_a_drive_beyond_its_rated_power_is_told():
    """10 cc/rev at 1500 rpm against 20 bar and more take above 0.5 kW."""
    text = SHORT.replace(
        'motor = { type = "driven-shaft" }', 'motor = { type = "driven-shaft", rated_power = "0.1 kW" }'
    )
    for own, expected in ((text, 1), (text.replace("0.1 kW", "50 kW"), 0), (SHORT, 0)):
        system = built(own)
        found = summary(system, simulate(system.model, system.case, system.stepping))
        said = [words for words in warnings(system, found) if "rated" in words]
        assert len(said) == expected
    assert found["power_motor_W"] > 100.0


PROTOTYPE = source_text("prototype")
LEAK = """type = "orifice"
a = "{node}"
b = "tank"
area = "0.1 mm^2"
discharge_coefficient = "0.6"
transition_pressure = "1 bar"
"""


def with_leak(node):
    """The prototype with an orifice between a node and the tank."""
    text = PROTOTYPE.replace(
        "[components]\n", 'other = { type = "pressure-source", pressure = "5 bar" }\n\n[components]\n', 1
    )
    return text.replace("[programs]\n", f"[components.leak]\n{LEAK.format(node=node)}\n[programs]\n", 1)


def test_what_is_joined_to_no_node_of_the_rig_leaves_it_one():
    assert is_bench(built(PROTOTYPE)) and is_bench(built(with_leak("other")))
    leaking = built(with_leak("inlet"))
    assert not is_bench(leaking)
    found = summary(leaking, simulate(leaking.model, leaking.case, leaking.stepping))
    assert "valve_pwm_frequency_Hz" in found and "pwm_frequency_Hz" not in found


def with_another_tank(content):
    content["nodes"]["end"] = {"type": "tank"}
    content["components"]["load"]["b"] = "end"


def with_a_speed_that_follows(content):
    content["nodes"]["pump_shaft"]["speed"] = {"from": "spool.speed"}
    del content["values"]["operation"]["pump_speed"], content["operation"]["pump_speed"]


def with_another_name(content):
    content["components"]["throttle"] = content["components"].pop("load")
    content["throttle"] = content.pop("load")


def with_an_elastic_inlet(content):
    content["nodes"]["inlet"] = {"type": "vessel", "oil_volume": "12.7 cc"}
    del content["inlet"]


@pytest.mark.parametrize(
    "change", [with_another_tank, with_a_speed_that_follows, with_another_name, with_an_elastic_inlet]
)
def test_another_drawing_is_no_rig(change):
    content = copy_tables(parsed_table(PROTOTYPE, "mine.toml").content)
    change(content)
    assert not is_bench(built_system(Table("mine", content, {}), "mine"))


def test_a_changed_prototype_still_goes_onto_a_rig():
    """With a leak behind the load line its values are found in the tables by which the file has them."""
    rig = rotary_bench(unit_on_rig(built(with_leak("load_line")), "map"), "map")
    expected = rotary_bench(load_system("prototype"), "map")
    for name in ("pump", "valve", "relief_valve", "check_valve", "load_line"):
        assert rig.value(name) == expected.value(name), name
