"""Position loops of rival circuits: openings and gains in closed form, how a circuit changes sides."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.control.duty_cycle import DutyCycle, cycle_point
from vvdp.control.reference import ReferenceFilter
from vvdp.programs.position_loop import (
    CylinderReading,
    Joint,
    LoopTable,
    PositionLoop,
    change_side,
    fuller_side,
    loop_gain,
    loop_start,
    one_way_step,
    overcentre_step,
    return_opening,
    throttle_opening,
    throttle_step,
)
from vvdp.programs.position_loops import ValveLoop, position_loop

REFERENCE = 101325.0
CYCLE = DutyCycle(times=(0.0, 1.0, 3.0), positions=(0.1, 0.2, 0.1), forces=(-1000.0, 500.0, -1000.0))


def loop(**changes):
    values = {
        "cycle": CYCLE,
        "reference": ReferenceFilter(filter_rate=25.0),
        "table": LoopTable(gain_margin=2.0, sample_period=1e-3, pressure_rate=50.0),
        "position_gain": 10.0,
        "area_a": 2e-3,
        "area_b": 1e-3,
        "reference_pressure": REFERENCE,
        "largest_flow": 6e-4,
        "valve_conductance": 1e-6,
    }
    return PositionLoop(**(values | changes))


def seen(position=0.1, a=20e5, b=5e5, supply=60e5):
    return CylinderReading(position, REFERENCE + a, REFERENCE + b, REFERENCE + supply)


def test_a_cycle_goes_straight_from_point_to_point_and_begins_again():
    assert cycle_point(0.25, CYCLE) == pytest.approx((0.125, -625.0))
    assert cycle_point(2.0, CYCLE) == pytest.approx((0.15, -250.0))
    assert cycle_point(3.25, CYCLE) == pytest.approx(cycle_point(0.25, CYCLE))
    assert cycle_point(3.0, CYCLE) == pytest.approx((0.1, -1000.0))


@pytest.mark.parametrize(
    "changes", [{"times": (0.5, 1.0, 3.0)}, {"forces": (1.0, 2.0)}, {"positions": (0.1, 0.2, 0.3)}]
)
def test_points_that_are_no_cycle_are_refused(changes):
    values = {"times": CYCLE.times, "positions": CYCLE.positions, "forces": CYCLE.forces}
    with pytest.raises(ParameterError):
        DutyCycle(**(values | changes))


@pytest.mark.parametrize("velocity", [0.08, -0.08])
def test_a_valve_opens_so_that_its_four_edges_give_the_velocity(velocity):
    """The pressures that the two flows over the edges leave hold the force that was asked for."""
    y = abs(throttle_opening(velocity, 1500.0, 60e5, loop()))
    into, out = (2e-3, 1e-3) if velocity > 0.0 else (1e-3, 2e-3)
    inside = 60e5 - (into * 0.08 / (1e-6 * y)) ** 2
    outside = (out * 0.08 / (1e-6 * y)) ** 2
    force = inside * into - outside * out
    assert force * np.sign(velocity) == pytest.approx(1500.0, rel=1e-9)


def test_a_valve_opens_no_further_than_it_can():
    assert throttle_opening(5.0, 0.0, 60e5, loop()) == 1.0
    assert throttle_opening(-5.0, 0.0, 60e5, loop()) == -1.0
    assert throttle_opening(0.05, 1e9, 60e5, loop()) > 0.0  # a load beyond the supply


def test_a_return_is_throttled_only_where_the_supply_would_fall():
    """Back, driven by 10 kN: P_r = (6 bar 10 cm^2 + 10 kN)/20 cm^2 = 53 bar, u = 20 cm^2 v/(K root 53 bar)."""
    settings = loop(valve_conductance=3e-7)
    assert return_opening(0.1, 10e3, settings) == 0.8
    expected = 2e-3 * 0.1 / (3e-7 * np.sqrt(53e5))
    assert return_opening(-0.1, 10e3, settings) == pytest.approx(expected, rel=1e-12)


def test_the_gain_keeps_its_margin():
    """At the margin of 1 the closed loop s (1 + 2 z s/w + s^2/w^2) + K has a pair of poles on the imaginary axis."""
    b, m, w = 2000.0, 100.0, 240.0
    for margin, swings in ((1.0, True), (1.01, False), (2.0, False)):
        K = loop_gain(b, m, margin)
        poles = np.roots([1.0 / w**2, b / (m * w**2), 1.0, K])
        assert (np.max(poles.real) > -1e-9) == swings
    with pytest.raises(ParameterError, match="viscous_friction: 0"):
        loop_gain(0.0, m, 2.0)


def test_a_circuit_goes_over_to_the_fuller_side_in_its_time():
    table = loop().table
    assert [fuller_side(more, 1.0, table) for more in (2e4, 0.0, -0.5e4, -2e4)] == [1.0, 1.0, 1.0, -1.0]
    joint, steps = Joint(1.0, 1.0), 0
    while joint.side > -1.0:
        joint, steps = change_side(1.0, joint, -1.0, loop()), steps + 1
    assert steps in (20, 21)  # ms
    assert change_side(0.0, Joint(1.0, 1.0), -1.0, loop()) == (-1.0, -1.0)


@pytest.mark.parametrize(
    ("is_open", "a", "b", "flow"),
    [(0.0, 20e5, 5e5, 2e-3), (0.0, 5e5, 20e5, 1e-3), (1.0, 20e5, 5e5, 2e-3), (1.0, 5e5, 20e5, -1e-3)],
)
def test_a_pump_over_centre_moves_the_side_that_carries(is_open, a, b, flow):
    """1 cm too far back at the first sample asks for 0.1 m/s out."""
    settings = loop(is_open_circuit=is_open)
    _, command = overcentre_step(0.0, loop_start(settings), seen(position=0.09, a=a, b=b), settings)
    assert command.flow == pytest.approx(0.1 * flow)
    assert command.side == np.sign(a - b)
    assert (command.reference, command.force) == (0.1, -1000.0)


def test_a_one_way_pump_gives_no_flow_backward():
    memory, command = one_way_step(0.0, loop_start(loop()), seen(position=0.11), loop())
    assert command.valve == -1.0 and command.flow == pytest.approx(1e-3 * 0.1)
    _, command = one_way_step(1e-3, memory, seen(position=0.11), loop(largest_flow=5e-5))
    assert command.flow == 5e-5


def test_a_throttle_beside_the_load_lets_what_is_not_asked_for_go():
    """1 cm too far back: 2e-4 of 6e-4 m^3/s go to the cylinder, 4e-4/(1e-6 root(60e5)) = 0.1633 opens the throttle."""
    _, command = one_way_step(0.0, loop_start(loop()), seen(position=0.09), loop(bleed_conductance=1e-6))
    assert (command.flow, command.bleed) == pytest.approx((2e-4, 4e-4 / 2449.4897e-6), rel=1e-6)
    assert one_way_step(0.0, loop_start(loop()), seen(position=0.09), loop())[1].bleed == 0.0


def test_no_flow_is_asked_for_below_the_least_one():
    """2e-4 m^3/s are wanted."""
    for least, flow in ((1.9e-4, 2e-4), (2.1e-4, 0.0)):
        settings = loop(lowest_flow=least)
        _, command = one_way_step(0.0, loop_start(settings), seen(position=0.09), settings)
        assert command.flow == pytest.approx(flow) and command.valve == 1.0


TABLE = {
    "times": CYCLE.times, "positions": CYCLE.positions, "forces": CYCLE.forces, "filter_rate": 25.0,
    "gain_margin": 2.0, "sample_period": 1e-3, "pressure_rate": 50.0, "area_a": 2e-3, "area_b": 1e-3,
    "viscous_friction": 2000.0, "moving_mass": 100.0, "lowest_position": 0.0, "highest_position": 0.3,
    "largest_flow": 6e-4, "valve_conductance": 1e-6,
}  # fmt: skip


def test_a_table_of_a_file_gives_the_settings_of_the_step():
    """K = b/(m margin) = 2000/(100 2) = 10 1/s."""
    assert position_loop(ValveLoop(**TABLE)) == loop()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"highest_position": 0.15}, "row 2 is at 200 mm; the rod travels from 0 to 150 mm"),
        ({"largest_flow": 1.9e-4}, "row 2 asks for 100 mm/s; pump and cylinder reach 95 mm/s"),
        ({"forces": (1.0, 2.0)}, "3 times, 3 positions and 2 forces"),
        ({"viscous_friction": 0.0}, "viscous_friction: .* must be greater than 0"),
        ({"gain_margin": 0.0}, "gain_margin"),
        ({"valve_conductance": 0.0}, "valve_conductance"),
    ],
)
def test_a_cycle_that_a_circuit_cannot_follow_is_refused(changes, words):
    """1.9e-4 m^3/s over 20 cm^2 are 95 mm/s."""
    with pytest.raises(ParameterError, match=words):
        ValveLoop(**(TABLE | changes))


def test_pressures_are_filtered():
    settings = loop()
    memory, _ = throttle_step(0.0, loop_start(settings), seen(), settings)
    assert memory.pressures.a == REFERENCE + 20e5
    for k in range(1, 21):
        memory, _ = throttle_step(k * 1e-3, memory, seen(a=30e5), settings)
    assert memory.pressures.a - REFERENCE == pytest.approx(30e5 - 10e5 * np.exp(-50.0 * 0.02), rel=1e-9)
