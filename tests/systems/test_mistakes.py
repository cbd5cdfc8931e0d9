"""Deliberate mistakes in a circuit: each is refused, or its result not trusted, with a sentence of its cause."""

import copy
import re
from typing import Any

import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table
from vvdp.network.sense import idle_nodes
from vvdp.simulation.run import simulate
from vvdp.systems.overview import warnings
from vvdp.systems.summary import summary
from vvdp.systems.system import System, built_system
from vvdp.systems.validity import broken_bounds

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

IDEAL = {"components.relief.override_pressure": "0 bar"}
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
