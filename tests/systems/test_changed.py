"""A system with other numbers at the paths of its file, and with copies of what it draws."""

import pytest

from vvdp.base.errors import ConfigError
from vvdp.systems.changed import with_copies, with_numbers
from vvdp.systems.system import load_system

OWN = ("chamber_a", "chamber_b", "rod", "cylinder", "friction", "end_stops", "load_force", "directional_valve", "loop")


@pytest.fixture(scope="module")
def throttle():
    return load_system("throttle-control")


def test_numbers_are_si_and_pressures_absolute(throttle):
    """60 bar are 61.01325 bara; a list and a number without a unit are set as well."""
    found = with_numbers(throttle, {
        "components.relief_valve.cracking_pressure": 6101325.0,
        "programs.loop.positions": (0.05, 0.1, 0.05),
        "programs.loop.gain_margin": 3.0,
    })  # fmt: skip
    network = found.circuit.network
    assert network.parts["relief_valve"].values == throttle.circuit.network.parts["relief_valve"].values
    settings = network.programs["loop"].settings
    assert settings.cycle.positions == (0.05, 0.1, 0.05)
    assert settings.position_gain == pytest.approx(2000.0 / (100.0 * 3.0))


def test_a_number_that_cannot_be_is_refused(throttle):
    with pytest.raises(ConfigError, match=r"programs\.loop\.positions: row 2 is at 400 mm"):
        with_numbers(throttle, {"programs.loop.positions": (0.05, 0.4, 0.05)})


def test_copies_are_joined_to_one_another_and_to_what_is_shared(throttle):
    network = with_copies(throttle, OWN, ("_second", "_third")).circuit.network
    before = throttle.circuit.network
    assert list(network.nodes)[: len(before.nodes)] == list(before.nodes)
    assert len(network.parts) == len(before.parts) + 2 * 5 and len(network.programs) == 3
    valve = network.parts["directional_valve_third"]
    assert valve.nodes == {"pressure": "supply", "tank": "tank", "a": "chamber_a_third", "b": "chamber_b_third"}
    assert valve.inputs == {"command": "loop_third.valve"}
    assert network.programs["loop_third"].reads["position"] == "rod_third.position"
    assert network.parts["load_force_third"].values == before.parts["load_force"].values


def test_components_of_copies_stand_behind_the_originals():
    """What all share and what stands last stays there: the pump of load sensing sums what its cylinders take."""
    system = load_system("load-sensing")
    network = with_copies(system, (*OWN, "supply", "flow_valve"), ("_second",)).circuit.network
    assert list(network.parts)[-3:] == ["directional_valve_second", "pump", "relief_valve"]
