"""Pump units of drawn circuits and of machines on the test rig: with the values of their circuit, to the bit."""

import copy
import dataclasses
import tomllib
from importlib import resources

import numpy as np
import pytest
from tests.systems.test_valve_numbers import driven, unit
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.unit_rig import unit_on_rig
from vvdp.evaluation.valve_unit import valve_unit
from vvdp.fluid.oil import Oil
from vvdp.simulation.run import simulate
from vvdp.simulation.values import flat, leaves
from vvdp.steady.test_stand import stand
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import built_system, load_system

CIRCUITS = {
    ("two-cylinders", "lift_unit"): {},
    ("two-cylinders", "swing_unit"): {},
    ("shared-supply", ""): {},
    ("transmission-speed-control", ""): {"duty_ratio": 0.5},
    ("vvdp-duty-control", ""): {},
    ("displacement-control", ""): {
        "duty_ratio": 0.5,
        "pump_speed": 60.0 * np.pi,
        "load_pressure": 101325.0 + 30e5,
    },
}
"""Circuits and parts with a pump unit, and what the rig has instead of the start of their run: a closed port as half, a
motor at rest as its 1800 rpm, no load as half the relief setting of 60 bar."""
HELD = ("pump_speed", "temperature", "duty_ratio", "load_pressure", "tank_pressure")


@pytest.mark.parametrize(("name", "part"), CIRCUITS)
def test_the_rig_has_the_values_of_the_circuit(name, part):
    system = load_system(name)
    own, there = valve_unit(system, "map", part), valve_unit(unit_on_rig(system, "map", part), "map")
    instead = CIRCUITS[name, part]
    oil = {field.name: getattr(own.oil, field.name) for field in dataclasses.fields(Oil)}
    assert oil == {key: getattr(there.oil, key) for key in oil}
    assert (there.valve, there.pump, there.relief_valve) == (own.valve, own.pump, own.relief_valve)
    assert there.inlet_volume == own.inlet_volume
    held = {key: instead.get(key, getattr(own, key)) for key in HELD}
    assert {key: getattr(there, key) for key in HELD} == pytest.approx(held, rel=4e-16)


def test_a_rig_is_its_own_rig():
    system = load_system("prototype-constant-load")
    assert unit_on_rig(system, "map") is system
    assert unit_on_rig(system, "map", "valve") is system


@pytest.mark.parametrize("setting", ["operation.duty_ratio=0.4", "operation.axial_position=8 mm"])
def test_a_rig_with_programs_is_drawn_without_them(setting):
    """The same name, title, equations and values as in the file, with its origins and ranges; the same bits."""
    system = load_system("prototype", [setting, "load.area={step=['3 mm^2','4 mm^2'],at='0.1 s'}"])
    rig = unit_on_rig(system, "map")
    assert unit_on_rig(rig, "map") is rig
    assert not rig.circuit.network.programs and system.circuit.network.programs
    assert (rig.name, rig.title) == (system.name, system.title)
    assert np.array_equal(flat(rig.case.state), flat(system.case.state))
    rates = [flat(each.model.circuit(0.0, each.case.state, each.case.command, each.case.params)[0])
             for each in (rig, system)]  # fmt: skip
    assert np.array_equal(*rates)
    programs = {"encoder", "spool_filter"}
    assert {row.setting: row for row in rig.rows} == {
        row.setting: row for row in system.rows if row.table not in programs
    }


def without_rotor(system):
    """The circuit with no inertia on its spool's shaft but that of the spool, as a rig has it."""
    content = copy.deepcopy(dict(system.content))
    content["nodes"]["unit_spool"]["inertia"] = "0 kg*m^2"
    return system.read_from(Table(system.name, content, {}))


def test_a_fault_of_the_file_goes_with_it():
    jam = [f"faults.jam.{key}={value}" for key, value in {"jams": "spool", "torque": "5 N*m", "begin": "0.5 s"}.items()]
    rig = unit_on_rig(load_system("prototype", jam), "map")
    assert [each.name for each in rig.faults] == ["jam"] and "jam" in rig.circuit.network.parts


def test_it_runs_as_the_circuit_does():
    """A drawn unit against a pressure source has all that its rig has: the same equations, the same numbers."""
    drawn = without_rotor(unit(axial_position="8 mm", relief_pressure="90 bar"))
    rig = unit_on_rig(drawn, "map")
    one, other = (
        simulate(each.model, each.case, dataclasses.replace(each.stepping, relative_tolerance=1e-10))
        for each in (drawn, rig)
    )
    paths = {path.removeprefix("unit_"): i for i, (path, _, _) in enumerate(leaves(one.case.state))}
    there = {path: i for i, (path, _, _) in enumerate(leaves(other.case.state))}
    assert one.times.tolist() == other.times.tolist()
    for path, apart in (("inlet", 1.0), ("spool.speed", 1e-6), ("spool.angle", 1e-8)):
        moved = one.states[:, paths[path]] - other.states[:, there[path]]
        assert np.max(np.abs(moved)) < apart, path
    assert np.ptp(one.states[:, paths["inlet"]]) > 20e5


LINE = """
nodes.tank = { type = "tank" }
nodes.motor = { type = "driven-shaft", speed = "1450 rpm" }
nodes.line = { type = "vessel", oil_volume = "0.5 l", start = "60 bar" }
parts.unit = { type = "pump-unit", load = "line", tank = "tank", shaft = "motor", axial_position = "12 mm" }
components.throttle = { type = "orifice", a = "line", b = "tank", area = "2 mm^2", discharge_coefficient = "0.6" }
run = { until = "0.2 s" }
"""


def test_a_line_and_its_orifice_go_with_the_unit():
    """They have the pressures of the circuit; the throttle is that of the file, though no name says what it is."""
    drawn = without_rotor(built_system(Table("line", tomllib.loads(LINE), {}), "line"))
    rig = unit_on_rig(drawn, "rig ripple")
    assert rotary_bench(rig, "rig").load.discharge_coefficient == 0.6
    one, other = (
        simulate(each.model, each.case, dataclasses.replace(each.stepping, relative_tolerance=1e-10))
        for each in (drawn, rig)
    )
    assert np.max(np.abs(one.state.line - other.state.load_line)) < 1.0
    assert np.ptp(one.state.line) > 20e5


def test_an_orifice_is_sized_where_the_circuit_has_none():
    """Half of 22.8 cc/rev at 1800 rpm, 3.42e-4 m^3/s, at 50 bar: A = Q/(0.61 sqrt(2*50e5/876)) = 5.25 mm^2."""
    rig = unit_on_rig(load_system("two-cylinders"), "map", "lift_unit")
    bench = rotary_bench(rig, "rig")
    assert bench.value("load.area").base == pytest.approx(5.247e-6, rel=1e-3)
    assert bench.load_line.oil_volume == pytest.approx(0.4e-3)


def test_its_text_is_a_system_with_origins_and_ranges():
    system = load_system("vvdp-duty-control")
    rig = unit_on_rig(system, "map")
    again = built_system(Table("rig", tomllib.loads(resolved_text(rig)), {}), "rig")
    assert again.case == rig.case
    ranges = {f"{row.table}.{row.key}" for row in system.uncertainties if row.table in rig.content}
    assert {f"{row.table}.{row.key}" for row in again.uncertainties} == ranges
    assert "valve.radial_clearance" in ranges


def test_its_points_can_be_chosen():
    """With the duty ratio prescribed, a unit whose spool a control moves has set points like any other."""
    held = stand(load_system("vvdp-duty-control"), "map")
    point = held.set_point._replace(duty_ratio=0.25)
    assert held.at(point).duty_ratio.base == 0.25
    assert not held.is_driven


def test_a_spool_whose_speed_is_prescribed_keeps_it():
    """A stiff motor holds 1500 rpm against the torque of the flow, up to torque over coupling."""
    rig = unit_on_rig(driven("1500 rpm"), "map")
    run = simulate(rig.model, rig.case, rig.stepping)
    speed = run.states[-1, [path for path, _, _ in leaves(run.case.state)].index("spool.speed")]
    assert speed == pytest.approx(50.0 * np.pi, abs=1.0)


DRAIN = {"type": "orifice", "a": "inlet", "b": "tank", "area": "1 mm^2"}
BRAKE = {"type": "rotor", "shaft": "spool", "inertia": "1e-5 kg*m^2", "shaft_damping": "1e-4 N*m*s"}


def joined(**more):
    """A drawn unit with more at its inlet or spool than a rig has."""
    part = tomllib.loads(resources.files("vvdp.systems").joinpath("parts", "pump-unit.toml").read_text("utf-8"))
    nodes = {
        "tank": {"type": "tank"},
        "load": {"type": "pressure-source", "pressure": "70 bar"},
        "shaft": {"type": "driven-shaft", "speed": "1800 rpm"},
    }
    content = {"nodes": part["nodes"] | nodes, "components": part["components"] | more, "run": {"until": "0.1 s"}}
    return built_system(Table("joined", content, {}), "joined")


@pytest.mark.parametrize("more", [{"drain": DRAIN}, {"brake": BRAKE}], ids=lambda more: next(iter(more)))
def test_more_at_inlet_or_spool_than_a_rig_has_is_refused_by_name(more):
    with pytest.raises(ConfigError, match=wording.rig.no_place.format(others=next(iter(more)))):
        unit_on_rig(joined(**more), "map")
