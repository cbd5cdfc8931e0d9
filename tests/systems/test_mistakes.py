"""Deliberate mistakes in a circuit: each is refused, or its result not trusted, with a sentence of its cause."""

import copy
import re
from typing import Any

import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table
from vvdp.evaluation.overview import warnings
from vvdp.evaluation.summary import summary
from vvdp.evaluation.validity import broken_bounds
from vvdp.network.sense import idle_nodes
from vvdp.simulation.run import simulate
from vvdp.systems.system import System, built_system

CIRCUIT: dict[str, Any] = {
    "nodes": {
        "tank": {"type": "tank"},
        "line": {"type": "volume", "volume": "0.5 l", "start": "0 bar"},
        "motor": {"type": "driven-shaft", "speed": "1500 rpm"},
        "source": {"type": "pressure-source", "pressure": "100 bar"},
    },
    "components": {
        "pump": {
            "type": "pump", "inlet": "tank", "outlet": "line", "shaft": "motor", "displacement": "16 cc/rev",
            "leakage_conductance": "0 m^3/(s*Pa)", "friction_torque": "0 N*m",
        },
        "relief": {
            "type": "relief-valve", "a": "line", "b": "tank", "cracking_pressure": "150 bar",
            "override_pressure": "5 bar", "rated_flow": "40 lpm",
        },
        "load": {"type": "orifice", "a": "line", "b": "tank", "area": "6 mm^2"},
        "feed": {"type": "orifice", "a": "source", "b": "line", "area": "0.1 mm^2"},
    },
    "run": {"until": "0.3 s"},
}  # fmt: skip
"""A pump, a relief valve and a load: 76 bar at 6 mm^2, with nothing wrong."""

MEASURED = {
    "type": "measured-pump",
    "inlet": "tank",
    "outlet": "line",
    "shaft": "motor",
    "setting": "1",
    "displacement": "16 cc/rev",
    "inertia": "0.002 kg*m^2",
    "coulomb_speed": "1 rpm",
    "response_time": "20 ms",
    "largest_rate": "10 1/s",
    "speeds": ["1000 rpm", "1500 rpm"],
    "pressures": ["100 bar"],
    "settings": ["1"],
    "volumetric_efficiencies": ["0.9", "0.92"],
    "mechanical_efficiencies": ["0.9", "0.92"],
}
ENGINE = {
    "type": "diesel-engine",
    "shaft": "crank",
    "speed": "1800 rpm",
    "inertia": "1 kg*m^2",
    "speed_band": "100 rpm",
    "rack_time": "50 ms",
    "speeds": ["800 rpm", "2000 rpm"],
    "full_torques": ["300 N*m"],
    "shaft_damping": "0 N*m*s",
    "coulomb_torque": "0 N*m",
    "coulomb_speed": "1 rpm",
}
SEAT = {
    "type": "poppet-valve",
    "a": "line",
    "b": "tank",
    "seat_diameter": "8 mm",
    "cone_angle": "45 deg",
    "largest_lift": "1 mm",
    "preload": "500 N",
    "stiffness": "50 kN/m",
}
IDEAL = {"components.relief.override_pressure": "0 bar"}
VOLUME = {"type": "volume", "volume": "0.5 l", "start": "0 bar"}
ROD = {"type": "rod", "mass": "10 kg"}
CHECK = {
    "type": "check-valve",
    "a": "line",
    "b": "tank",
    "cracking_pressure": "0.5 bar",
    "rated_drop": "5 bar",
    "rated_flow": "40 lpm",
}
PIPE = {
    "type": "pipe",
    "a": "source",
    "b": "end",
    "length": "10 m",
    "diameter": "20 mm",
    "pieces": "5",
    "hose_compliance": "0 1/Pa",
    "wall_friction": "0",
    "start": "100 bar",
}
CYLINDER = {
    "type": "cylinder",
    "a": "line",
    "b": "tank",
    "rod": "rod",
    "area_a": "2000 mm^2",
    "area_b": "1000 mm^2",
    "moving_mass": "10 kg",
    "stroke": "50 mm",
    "leakage_conductance": "0 m^3/(s*Pa)",
}
STOP = {
    "type": "end-stop",
    "rod": "rod",
    "lower_end": "0.1 m",
    "upper_end": "0 m",
    "stop_stiffness": "5e7 N/m",
    "stop_damping": "1 s/m",
}
HOLDING = {
    "type": "counterbalance-valve",
    "a": "line",
    "b": "tank",
    "cracking_pressure": "200 bar",
    "override_pressure": "20 bar",
    "rated_flow": "60 lpm",
    "rated_drop": "30 bar",
    "pilot_ratio": "3",
    "reverse_cracking_pressure": "0.5 bar",
    "reverse_override_pressure": "4.5 bar",
}
COMPENSATOR = {
    "type": "upstream-compensator",
    "a": "source",
    "b": "line",
    "pilot": "tank",
    "rated_flow": "60 lpm",
    "cracking_pressure": "7 bar",
    "override_pressure": "2 bar",
    "rated_drop": "5 bar",
}
REDUCING = {
    "type": "reducing-valve",
    "a": "source",
    "b": "line",
    "closing_pressure": "50 bar",
    "override_pressure": "5 bar",
    "rated_flow": "40 lpm",
    "rated_drop": "5 bar",
    "opening_time": "0 ms",
}
FOUR_WAY = {
    "type": "four-way-valve",
    "pressure": "line",
    "tank": "tank",
    "a": "one",
    "b": "other",
    "command": "0",
    "conductance": "2e-7 m^3/(s*Pa^0.5)",
    "overlap_pa": "0.05",
    "overlap_pb": "0.05",
    "overlap_at": "0.05",
    "overlap_bt": "0.05",
    "transition_pressure": "0.1 bar",
    "natural_frequency": "50 Hz",
    "largest_rate": "20 1/s",
}
LEVEL = {
    "type": "tank-with-level",
    "suction": "suction",
    "inlet": "line",
    "base_area": "0.1 m^2",
    "tank_height": "0.6 m",
    "tank_volume": "40 l",
    "suction_height": "50 mm",
    "port_area": "1000 mm^2",
}
CLOSED = {"components.relief": None, "components.load": None, "components.feed": None}
ENDS = {"nodes.one": VOLUME, "nodes.other": VOLUME}
REFUSED = {
    "an ideal relief valve at a source": (
        IDEAL | {"components.relief.a": "source"}, "components.relief", "'source' has a prescribed pressure",
    ),
    "both ports at one node": ({"components.load.b": "line"}, "components.load", "has all its ports at 'line'"),
    "a pump from a node to itself": ({"components.pump.inlet": "line"}, "components.pump", "all its ports at 'line'"),
    "a volume without oil": ({"nodes.line.volume": "0 l"}, "nodes.line", "0 m^3"),
    "a port that is no node": ({"components.load.b": "tnak"}, "components.load", "'tnak', which is no node"),
    "a port left open": ({"components.load.b": None}, "components.load", "port 'b' is open"),
    "an unknown port": ({"components.load.c": "tank"}, "components.load.c", "unknown"),
    "an unknown type": ({"components.load.type": "orifize"}, "components.load", "did you mean 'orifice'"),
    "an unknown key": ({"components.load.aera": "6 mm^2"}, "components.load.aera", "did you mean 'area'"),
    "the unit of another quantity": ({"components.load.area": "6 bar"}, "components.load.area", "bar"),
    "a number without a unit": ({"components.load.area": 6}, "components.load.area", "unit"),
    "a pressure below vacuum": ({"nodes.line.start": "-2 bar"}, "nodes.line.start", "-2"),
    "a shaft at a port for oil": ({"components.load.b": "motor"}, "components.load", "joins a"),
    "oil at a port for a shaft": ({"components.pump.shaft": "line"}, "components.pump", "joins a"),
    "a negative area": ({"components.load.area": "-6 mm^2"}, "components.load.area", "-6"),
    "a negative displacement": ({"components.pump.displacement": "-16 cc/rev"}, "components.pump.displacement", "-16"),
    "an unknown oil": ({"nodes.line.oil": "olive"}, "nodes.line.oil", "'olive' is no oil"),
    "no time to run": ({"run.until": "0 s"}, "run", "until = 0 s"),
    "a table that nothing reads": ({"operation": {"temperature": "40 degC"}}, "operation", "oil_temperature"),
    "a name that is taken": (
        {"components.line": {"type": "orifice", "a": "line", "b": "tank", "area": "1 mm^2"}},
        "components.line", "taken",
    ),
    "a vessel without oil": (
        {"nodes.line": {"type": "vessel", "oil_volume": "0 l", "start": "0 bar"}}, "nodes.line", "must be greater",
    ),
    "two ideal relief valves at one volume": (
        IDEAL | {"components.second": CIRCUIT["components"]["relief"] | {"override_pressure": "0 bar"}},
        "components", "second is ideal (override_pressure 0), as relief at the same volume",
    ),
    "a relief valve without a rated flow": (
        {"components.relief.rated_flow": "0 lpm"}, "components.relief.rated_flow", "greater than 0",
    ),
    "a relief valve that never shuts": (
        {"components.relief.reseat_drop": "200 bar"}, "components.relief.reseat_drop", "less than cracking_pressure",
    ),
    "a check valve rated below its cracking": (
        {"components.one_way": CHECK | {"rated_drop": "0.2 bar"}}, "components.one_way.rated_drop", "cracking_pressure",
    ),
    "half a piece of pipe": (
        {"nodes.end": VOLUME, "components.pipe": PIPE | {"pieces": "2.5"}}, "components.pipe.pieces", "whole number",
    ),
    "a pipe without length": (
        {"nodes.end": VOLUME, "components.pipe": PIPE | {"length": "0 m"}}, "components.pipe.length", "greater than 0",
    ),
    "a frequency for a speed": ({"nodes.motor.speed": "25 Hz"}, "nodes.motor.speed", "write 1500 rpm"),
    "a name that the equations have": ({"nodes.t": VOLUME}, "nodes.t", "is reserved"),
    "a name with a sign": ({"nodes.my-line": VOLUME}, "nodes.my-line", "cannot be a name"),
    "times that go back": (
        {"nodes.source.pressure": {"table": [["0 s", "9 bar"], ["2 s", "8 bar"], ["1 s", "7 bar"]]}},
        "nodes.source.pressure", "must not go backwards",
    ),
    "a step without its time": ({"nodes.source.pressure": {"step": ["9 bar", "5 bar"]}}, "nodes.source", "at = t"),
    "a step from a pressure to a flow": (
        {"nodes.source.pressure": {"step": ["9 bar", "5 lpm"], "at": "1 s"}}, "nodes.source", "not a pressure level",
    ),
    "viscosities the wrong way round": (
        {"oil": {"viscosity_40": "7 mm^2/s", "viscosity_100": "46 mm^2/s"}}, "oil.viscosity_40", "must be greater than",
    ),
    "more air than oil": ({"oil": {"air_fraction": "150 %"}}, "oil.air_fraction", "outside 0 to 50 %"),
    "a bulk modulus in bar": ({"oil": {"liquid_bulk_modulus": "1.4 bar"}}, "oil.liquid_bulk_modulus", "1e+08 bar"),
    "a density in g/cm^3": ({"oil": {"density": "0.876 kg/m^3"}}, "oil.density", "500 to 2000"),
    "a misspelt key of the oil": ({"oil": {"viscosty_40": "46 mm^2/s"}}, "oil", "did you mean 'viscosity_40'"),
    "kelvin for degrees": ({"operation": {"oil_temperature": "313 degC"}}, "operation.oil_temperature", "to 150 degC"),
    "an area from a pressure": (
        {"components.load.area": {"from": "line.pressure"}}, "components.load", "'line.pressure' is a pressure level",
    ),
    "an area from its own flow": (
        {"components.load.area": {"from": "load.flow"}}, "", "these needs the other's result at the same instant",
    ),
    "a component without a type": ({"components.load.type": None}, "components.load", "has no type"),
    "end stops the wrong way round": (
        {"nodes.rod": ROD, "components.stop": STOP}, "components.stop.lower_end", "less than upper_end",
    ),
    "a cylinder without a piston": (
        {"nodes.rod": ROD, "components.cylinder": CYLINDER | {"area_a": "0 mm^2"}},
        "components.cylinder.area_a", "greater than 0",
    ),
    "a discharge coefficient of 6.1": (
        {"components.load.discharge_coefficient": "6.1"}, "components.load.discharge_coefficient", "0.3 to 1",
    ),
    "a negative opening time": ({"components.relief.opening_time": "-2 ms"}, "components.relief.opening_time", "-2 ms"),
    "means from after the end": ({"run.average_from": "1 s"}, "run", "less than until"),
    "a tolerance of 1": ({"run.relative_tolerance": "1"}, "", "relative_tolerance = 1"),
    "a counterbalance valve without a pilot": ({"components.holding": HOLDING}, "components.holding", "port 'pilot'"),
    "a command in percent": (
        ENDS | {"components.valve": FOUR_WAY | {"command": "50"}}, "components.valve.command", "-1 to 1",
    ),
    "a compensator without a spring": (
        {"components.compensator": COMPENSATOR | {"cracking_pressure": "0 bar"}},
        "components.compensator.cracking_pressure", "greater than 0",
    ),
    "a reducing valve that opens below vacuum": (
        {"components.reducing": REDUCING | {"override_pressure": "60 bar"}},
        "components.reducing.override_pressure", "less than closing_pressure",
    ),
    "a tank fuller than full": (
        {"nodes.suction": VOLUME, "components.level": LEVEL | {"tank_volume": "80 l"}},
        "components.level.tank_volume", "room for air",
    ),
    "efficiencies for other points than a table has": (
        {"components.machine": MEASURED | {"settings": ["0.5", "1"]}},
        "components.machine.volumetric_efficiencies", "2 values; expected 4",
    ),
    "an efficiency of 92 for 92 %": (
        {"components.machine": MEASURED | {"volumetric_efficiencies": ["0.9", "92"]}},
        "components.machine.volumetric_efficiencies", "92",
    ),
    "a torque curve with a torque too few": (
        {"nodes.crank": {"type": "shaft", "speed": "1800 rpm"}, "components.engine": ENGINE},
        "components.engine.full_torques", "1 torques for 2 speeds",
    ),
    "a spool of first and of second order": (
        ENDS | {"components.valve": FOUR_WAY | {"response_time": "20 ms"}},
        "components.valve.natural_frequency", "or else 0",
    ),
    "a poppet that rises as high as its seat is wide": (
        {"components.seat": SEAT | {"largest_lift": "10 mm"}},
        "components.seat.largest_lift", "less than seat_diameter",
    ),
    "a closing time of a valve that follows at once": (
        {"components.valve": CHECK | {"closing_time": "2 ms"}}, "components.valve.closing_time", "must be 0",
    ),
    "a misspelt limit": ({"limits": {"largest_presure": "300 bar"}}, "limits", "did you mean 'largest_pressure'"),
    "a state that leads nowhere": (
        {"nodes.source.pressure": {"from": "lien.pressure"}}, "nodes.source", "leads nowhere",
    ),
}  # fmt: skip
"""What is changed, where the message points, and words of it."""

NOT_TRUSTED = {
    "a relief valve the wrong way round": (
        {"components.relief.a": "tank", "components.relief.b": "line", "components.load.area": "2 mm^2"},
        "pressure at port b of relief, through which nothing flowed: .* its ports the wrong way round",
    ),
    "no relief valve and no load": (
        {"components.relief": None, "components.load": None, "components.feed": None},
        "highest absolute pressure, at line: .* a relief valve missing",
    ),
    "litres for cubic centimetres": (
        {"components.pump.displacement": "16000 cc/rev"}, "highest absolute pressure, at line: .* is a unit wrong",
    ),
    "a pressure source of 100 MPa": ({"nodes.source.pressure": "100 MPa"}, "highest absolute pressure, at source"),
    "a shaft that nothing loads": (
        {"nodes.wheel": {"type": "shaft", "inertia": "1e-4 kg*m^2"},
         "components.spin": {"type": "load-torque", "shaft": "wheel", "torque": "-10 N*m"}},
        "speed of wheel: .* a load missing",
    ),
    "cubic metres an hour for litres a minute": (
        CLOSED | {"components.flow": {"type": "flow-source", "a": "tank", "b": "line", "flow": "10 m^3/h"}},
        "highest absolute pressure, at line: .* is a unit wrong",
    ),
    "a relief valve set in MPa for bar": (
        {"components.relief.cracking_pressure": "150 MPa", "components.load": None, "components.feed": None},
        "highest absolute pressure, at line: .* is a unit wrong",
    ),
    "a pump against a closed centre": (
        CLOSED | ENDS | {"components.valve": FOUR_WAY}, "highest absolute pressure, at line: .* a relief valve missing",
    ),
    "a pump that turns backwards": ({"nodes.motor.speed": "-1500 rpm"}, "lowest absolute pressure, at line"),
    "a throttle that is laminar at any drop": (
        {"components.load.transition_pressure": "500 bar"}, "transition pressure of load: 500 bar, above 20 bar",
    ),
    "a shock in a pipe of few pieces": (
        {"nodes.end": VOLUME | {"volume": "1 cc", "start": "100 bar"}, "components.pipe": PIPE,
         "nodes.source.pressure": {"step": ["100 bar", "150 bar"], "at": "10 ms"}},
        "roughness of the waves in pipe: .* give it more pieces",
    ),
    "a line of 3 mm for 30 mm": (
        {"nodes.end": VOLUME | {"volume": "1 l", "start": "70 bar"}, "components.load.a": "end",
         "components.hose": {"type": "line", "a": "line", "b": "end", "length": "0.2 m", "diameter": "3 mm"}},
        "mean velocity in hose: .* or its diameter",
    ),
    "a cylinder without an end-stop": (
        {"nodes.rod": ROD, "components.cylinder": CYLINDER, "components.load": None, "components.feed": None},
        "position of rod: .* only an end-stop holds the rod",
    ),
    "a pump that draws from a small volume": (
        {"components.pump.inlet": "suction", "nodes.suction": {"type": "volume", "volume": "1 l", "start": "0 bar"},
         "components.strainer": {"type": "orifice", "a": "tank", "b": "suction", "area": "30 mm^2"}},
        "lowest absolute pressure, at suction",
    ),
}  # fmt: skip
"""What is changed, and a pattern of the sentence that is told."""


def changed(changes: dict[str, Any]) -> dict[str, Any]:
    """The circuit with what a path leads to replaced, added or, where it is None, taken out."""
    found = copy.deepcopy(CIRCUIT)
    for path, value in changes.items():
        *outer, key = path.split(".")
        inner = found
        for name in outer:
            inner = inner[name]
        if value is None:
            del inner[key]
        else:
            inner[key] = value
    return found


def drawn(circuit: dict[str, Any]) -> System:
    lines = {f"{table}.{name}": 1 for table, inner in circuit.items() for name in inner}
    return built_system(Table("circuit.toml", circuit, lines), "circuit")


def test_the_table_has_sixty_mistakes():
    assert len(REFUSED) + len(NOT_TRUSTED) >= 60


def test_nothing_is_wrong_with_the_circuit_itself():
    system = drawn(CIRCUIT)
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert found["trusted"] and broken_bounds(system, found) == []


@pytest.mark.parametrize("mistake", REFUSED)
def test_it_is_refused_where_it_stands(mistake):
    changes, place, words = REFUSED[mistake]
    with pytest.raises(ConfigError) as refused:
        drawn(changed(changes))
    told = [(fault.key, fault.message) for fault in refused.value.faults]
    assert any(key.startswith(place) and words in message for key, message in told), told


@pytest.mark.parametrize("mistake", NOT_TRUSTED)
def test_its_result_is_not_to_be_trusted_and_says_why(mistake):
    changes, sentence = NOT_TRUSTED[mistake]
    system = drawn(changed(changes))
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert not found["trusted"]
    assert any(re.search(sentence, told) for told in broken_bounds(system, found)), broken_bounds(system, found)


@pytest.mark.parametrize(
    "node",
    [{"type": "volume", "volume": "1 l", "start": "0 bar"}, {"type": "shaft", "inertia": "1 kg*m^2"},
     {"type": "rod", "mass": "1 kg"}],
)  # fmt: skip
def test_a_node_that_nothing_joins_is_told(node):
    system = drawn(changed({"nodes.spare": node}))
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert any("spare is joined to nothing" in told for told in warnings(system, found))


@pytest.mark.parametrize(("area", "is_told"), [("6 cm^2", True), ("3 cm^2", True), ("1 cm^2", False)])
def test_an_orifice_that_throttles_nothing_is_told(area, is_told):
    """24 l/min in the laminar part of the law: dp = Q root(eps)/(Cd A root(2/rho)), 0.051 bar at 6 cm^2, below
    eps/root(15) = 0.129 bar; 1 cm^2, 0.19 bar by the root law, may be meant. Valid: so may a wide return line."""
    system = drawn(changed({"components.load.area": area}))
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert any("load throttles nothing" in told for told in warnings(system, found)) is is_told
    assert found["trusted"]


def test_a_tank_may_wait_for_a_study_that_joins_it():
    system = drawn(changed({"nodes.spare": {"type": "tank"}}))
    assert list(idle_nodes(system.circuit.network)) == []


def test_a_relief_valve_between_two_volumes_may_stay_shut_below_a_higher_pressure():
    """A valve for 20 bar guards a volume at rest; behind it the line stands at 70 bar, as its other ports may."""
    guarded = {"type": "relief-valve", "a": "other", "b": "line", "cracking_pressure": "20 bar",
               "override_pressure": "5 bar", "rated_flow": "40 lpm"}  # fmt: skip
    volume = {"type": "volume", "volume": "0.5 l", "start": "0 bar"}
    system = drawn(changed({"nodes.other": volume, "components.guard": guarded}))
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert found["flow_mean_guard_m3_s"] == 0.0 and found["trusted"]
