"""A digital flow control unit: its codes and flows exactly, and what a change of code passes too much."""

import pytest

from vvdp.base.errors import ParameterError
from vvdp.base.params import field_values
from vvdp.base.signal import step
from vvdp.components.flow_control_units import add_flow_control_unit
from vvdp.components.library import UsualOil
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.flow_control_unit import (
    FlowControlUnit,
    OnOffValve,
    UnitValve,
    binary_valves,
    code_count,
    code_flow,
    equal_valves,
    poppet_flow,
    poppet_opening,
    pulse_volume,
    valve_command,
)
from vvdp.network.build import build
from vvdp.network.network import Network
from vvdp.simulation.balance import balance
from vvdp.simulation.run import Stepping, simulate

LPM, DROP = 1e-3 / 60.0, 35e5
SMALLEST = OnOffValve(rated_flow=1.5 * LPM, rated_drop=DROP, opening_time=4e-3, closing_time=7e-3)


@pytest.mark.parametrize("count", [1, 3, 5, 8])
def test_binary_sizes_have_two_to_the_n_flows(count):
    """k times the smallest one for k = 0 to 2^N - 1, each once, to the last digits."""
    valves = binary_valves(count, SMALLEST)
    assert code_count(valves) == 2**count
    flows = [code_flow(float(code), DROP, valves) for code in range(2**count)]
    assert flows == pytest.approx([code * 1.5 * LPM for code in range(2**count)], rel=1e-14)
    patterns = {tuple(valve_command(float(code), valve) for valve in valves) for code in range(2**count)}
    assert len(patterns) == 2**count


@pytest.mark.parametrize("count", [1, 4, 7])
def test_equal_sizes_have_n_plus_one_flows(count):
    """k = 0 to N, though there are 2^N patterns: all with as many open pass the same."""
    valves = equal_valves(count, SMALLEST)
    assert code_count(valves) == count + 1
    flows = [code_flow(float(code), DROP, valves) for code in range(count + 1)]
    assert flows == pytest.approx([code * 1.5 * LPM for code in range(count + 1)], rel=1e-14)
    for code in range(count + 1):
        assert sum(valve_command(float(code), valve) for valve in valves) == code


def test_flow_goes_with_the_root_of_the_drop():
    valves = binary_valves(5, SMALLEST)
    ratio = code_flow(21.0, 4.0 * DROP, valves) / code_flow(21.0, DROP, valves)
    assert ratio == pytest.approx(2.0, rel=1e-4)  # the law turns straight at a hundredth of its rated drop
    assert code_flow(21.0, -DROP, valves) == pytest.approx(-code_flow(21.0, DROP, valves))


def test_pulses_by_hand():
    """15 to 16: 16 units miss 2 ms, 15 stay 3.5 ms: 52.5 - 32 = 20.5 unit-milliseconds too much, 0.51 cm3. Back, 16
    stay and 15 miss: 56 - 30 = 26. One valve more of a unit of equal sizes misses 2 alone."""
    unit = 1.5 * LPM * 1e-3
    binary, equal = binary_valves(5, SMALLEST), equal_valves(31, SMALLEST)
    assert pulse_volume(15.0, 16.0, DROP, binary) == pytest.approx(20.5 * unit, rel=1e-12)
    assert pulse_volume(16.0, 15.0, DROP, binary) == pytest.approx(26.0 * unit, rel=1e-12)
    assert pulse_volume(15.0, 16.0, DROP, equal) == pytest.approx(-2.0 * unit, rel=1e-12)
    assert pulse_volume(16.0, 15.0, DROP, equal) == pytest.approx(3.5 * unit, rel=1e-12)
    assert pulse_volume(15.0, 15.0, DROP, binary) == 0.0


@pytest.mark.parametrize("changes", [{"valves": 2.5}, {"valves": 0.0}, {"equal_sizes": 0.5}])
def test_a_unit_that_is_none_is_refused(changes):
    with pytest.raises(ParameterError, match=next(iter(changes))):
        FlowControlUnit(**(field_values(OnOffValve, SMALLEST) | {"valves": 5.0} | changes))


@pytest.mark.parametrize(("before", "after"), [(15.0, 16.0), (16.0, 15.0), (7.0, 8.0), (0.0, 31.0)])
def test_pulses_as_simulated(before, after):
    """Between two pressures that hold, from 20 ms before the code changes to 50 ms after it."""
    valves, oil = binary_valves(5, SMALLEST), UsualOil()
    net = Network(oil)
    net.pressure_source("high", 135e5)
    net.pressure_source("low", 100e5)
    unit = FlowControlUnit(**field_values(OnOffValve, SMALLEST), valves=5.0)
    add_flow_control_unit(net, "unit", unit, {"a": "high", "b": "low", "code": step(before, after, 0.05)})
    circuit = build(net)
    run = simulate(circuit.model, circuit.case, Stepping(until=0.1))
    assert balance(run).is_trusted
    rows, totals = run.times.searchsorted(0.03 - 1e-9), run.state.books.totals
    flows = [getattr(totals, f"unit_{number}_flow") for number in range(1, 6)]
    volume = fluid_state(135e5, oil).volume_ratio * sum(float(each[-1] - each[rows]) for each in flows)
    steady = 0.02 * code_flow(before, DROP, valves) + 0.05 * code_flow(after, DROP, valves)
    expected = pulse_volume(before, after, DROP, valves)
    assert volume - steady == pytest.approx(expected, rel=1e-4)
    if (before, after) == (15.0, 16.0):
        # 3 ms after: the largest is open since just then, the others have gone 1.25 of their 3.5 ms of shutting.
        row = run.times.searchsorted(0.053 - 1e-9)
        travels = [getattr(run.state, f"unit_{number}").travel[row] for number in range(1, 6)]
        flow = sum(poppet_flow(DROP, float(each), valve) for each, valve in zip(travels, valves, strict=True))
        assert flow / (1.5 * LPM) == pytest.approx(16.0 + 15.0 * (1.0 - 1.25 / 3.5), rel=1e-3)


def test_dead_travel_leaves_the_flow_alone():
    assert poppet_opening(0.25, SMALLEST) == 0.0
    assert poppet_opening(0.5, SMALLEST) == pytest.approx(0.5)
    assert poppet_opening(0.75, SMALLEST) == 1.0


def test_what_is_no_valve_is_refused():
    with pytest.raises(ParameterError, match=r"OnOffValve\.opening_time: 0"):
        OnOffValve(rated_flow=1.0, rated_drop=1e5, opening_time=0.0, closing_time=1e-3)
    with pytest.raises(ParameterError, match=r"dead_travel: 0\.5 must be at least 0\.02 and less than 0\.5"):
        OnOffValve(rated_flow=1.0, rated_drop=1e5, opening_time=1e-3, closing_time=1e-3, dead_travel=0.5)
    with pytest.raises(ParameterError, match="weight: 2 must be at least 1 and less than modulus, 2"):
        UnitValve(rated_flow=1.0, rated_drop=1e5, opening_time=1e-3, closing_time=1e-3, weight=2.0, modulus=2.0)
