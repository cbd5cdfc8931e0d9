"""Edges of independent metering: conductances, speeds and codes in closed form."""

import pytest

from vvdp.control.duty_cycle import DutyCycle
from vvdp.control.reference import ReferenceFilter
from vvdp.hydraulics.flow_control_unit import OnOffValve
from vvdp.machines.duties import shipped_duties
from vvdp.programs.metering_edges import (
    EdgeLoop,
    Edges,
    Sides,
    best_codes,
    edge_speed,
    edge_start,
    edge_step,
    metered_edges,
)
from vvdp.programs.position_loop import CylinderReading, LoopTable, PositionLoop
from vvdp.rivals.rival_account import system_for
from vvdp.rivals.rival_circuits import CIRCUITS

LEVEL = 101325.0
CYCLE = DutyCycle(times=(0.0, 1.0, 2.0), positions=(0.1, 0.2, 0.1), forces=(-1000.0,) * 3)
OUT = Sides(supply_area=2e-3, return_area=1e-3, force=4e3, feed=40e5, fed=30e5)


def settings(highest=1.0, supply=1e-6, back=3e-7):
    loop = PositionLoop(
        cycle=CYCLE,
        reference=ReferenceFilter(filter_rate=25.0),
        table=LoopTable(gain_margin=2.0, sample_period=1e-3, pressure_rate=50.0),
        position_gain=10.0,
        area_a=2e-3,
        area_b=1e-3,
        reference_pressure=LEVEL,
        largest_flow=6e-4,
        valve_conductance=3e-7,
    )
    return EdgeLoop(
        loop=loop,
        supply_step=supply / highest,
        return_step=back / highest,
        highest=highest,
        is_coded=float(highest > 1.0),
    )


def test_a_rod_goes_as_fast_as_both_edges_let_it():
    """40 bar 20 cm^2 - 4 kN = 4 kN; 8e-9/(4e-7)^2 + 1e-9/(2e-7)^2 = 75000: v = root(4000/75000) = 0.23094 m/s.

    Then P_s = 40 bar - (2e-3 v/4e-7)^2 = 26.67 bar and P_r = 13.33 bar: 5333 N - 1333 N hold 4 kN.
    """
    speed = edge_speed(4e-7, 2e-7, OUT)
    assert speed == pytest.approx(0.230940, rel=1e-5)
    supply, back = 40e5 - (2e-3 * speed / 4e-7) ** 2, (1e-3 * speed / 2e-7) ** 2
    assert supply * 2e-3 - back * 1e-3 == pytest.approx(4e3, rel=1e-12)
    assert edge_speed(0.0, 2e-7, OUT) == edge_speed(4e-7, 0.0, OUT) == 0.0
    assert edge_speed(4e-7, 2e-7, OUT._replace(force=9e3)) == 0.0


def test_an_edge_into_a_chamber_meters_the_flow():
    """2e-4 m^3/s at 10 bar: 2e-4/(1e-6 1000) = 0.2; the return opens by the law of all throttles, here 0.5."""
    assert metered_edges(2e-4, 0.5, OUT, settings()) == pytest.approx((0.2, 0.5), rel=1e-12)
    assert metered_edges(2e-4, 0.5, OUT, settings(31.0)) == pytest.approx((6.2, 15.5), rel=1e-12)
    assert metered_edges(2e-2, 0.5, OUT, settings()).into == 1.0


def test_nothing_falls_back_into_the_line():
    assert metered_edges(2e-4, 0.5, OUT._replace(fed=41e5), settings()).into == 0.0


def test_codes_are_the_pair_whose_speed_is_closest():
    """6.2 and 15.5 of 31: of the pairs (6 or 7, 15 or 16) none is closer to what is wanted."""
    unit, edges = settings(31.0), Edges(6.2, 15.5)
    speed = edge_speed(6.2 * unit.supply_step, 15.5 * unit.return_step, OUT)
    speeds = {
        (i, o): edge_speed(i * unit.supply_step, o * unit.return_step, OUT) for i in (6.0, 7.0) for o in (15.0, 16.0)
    }
    found = best_codes(speed, edges, OUT, unit)
    assert found == min(speeds, key=lambda pair: abs(speeds[pair] - speed))
    assert abs(speeds[tuple(found)] / speed - 1.0) < 0.03
    assert best_codes(0.0, Edges(0.4, 0.4), OUT, unit) == (0.0, 0.0)
    assert best_codes(9.0, Edges(31.0, 31.0), OUT, unit) == (31.0, 31.0)


@pytest.mark.parametrize("highest", [1.0, 31.0])
def test_edges_of_the_other_side_are_closed(highest):
    """20 mm too far: back, B is fed, its pressure told to the pump; codes are whole numbers."""
    loop = settings(highest)
    seen = CylinderReading(0.12, LEVEL + 20e5, LEVEL + 6e5, LEVEL + 16e5)
    _, command = edge_step(0.0, edge_start(loop), seen, loop)
    assert command.supply_a == command.return_b == 0.0 and min(command.supply_b, command.return_a) > 0.0
    assert (command.supply_b % 1.0 == 0.0) == (highest > 1.0)
    assert command.load_pressure == seen.pressure_b and command.reference == 0.1


def test_conductance_of_an_on_off_valve():
    """1 lpm at 35 bar: 1.6667e-5/root(35e5) = 8.909e-9."""
    valve = OnOffValve(rated_flow=1.0 / 6e4, rated_drop=35e5, opening_time=5e-3, closing_time=8e-3)
    assert valve.conductance == pytest.approx(8.9087e-9, rel=1e-4)


def test_units_out_of_the_chambers_are_as_large_as_the_throttle_of_others():
    """31 times the smallest; so are valves."""
    heavy = next(each for each in shipped_duties() if each.name == "heavy")
    circuits = {each.name: each for each in CIRCUITS}
    for name, valve, count in (
        ("independent-units", "return_{}_1", 31.0),
        ("independent-valves", "return_valve_{}", 1.0),
    ):
        network = system_for(circuits[name], heavy).circuit.network
        parts = [network.parts[valve.format(side)].values[0] for side in "ab"]
        steps = [*(each.conductance for each in parts), network.programs["loop"].settings.return_step]
        assert [count * each for each in steps] == pytest.approx([heavy.return_conductance] * 3, rel=1e-12)
