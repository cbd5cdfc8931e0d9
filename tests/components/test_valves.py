"""Numbers by hand for the valves as components; the laws that they all keep are in test_library.py."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.components.controlled_valves import (
    DUMP_VALVE,
    MeteringValve,
    SeriesThrottles,
    compensated_start,
    compensated_throttle,
    dump_start,
    dump_valve,
    metering_valve,
    proportional_valve,
    series_throttles,
    unloading_valve,
)
from vvdp.components.directional_valves import (
    ThrottledDirectionalState,
    ThrottledDirectionalValve,
    directional_valve,
    throttled_directional_valve,
)
from vvdp.components.flow_sources import flow_source
from vvdp.components.self_acting_valves import (
    CHECK_VALVE,
    FLOW_CONTROL_VALVE,
    check_start,
    check_valve,
    flow_control_valve,
    pilot_check_valve,
    reducing_start,
    reducing_valve,
    relief_valve,
    shock_valve,
)
from vvdp.components.switching_valves import (
    ModulatedThreeWayValve,
    PulsedThreeWayValve,
    PulsedTwoWayValve,
    ThreeWayValve,
    TwoWayValve,
    modulated_stop,
    modulated_switching_valve,
    pulsed_switching_valve,
    pulsed_two_way_valve,
    switching_valve,
    two_way_valve,
)
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.check_valve import CheckValve
from vvdp.hydraulics.compensated_throttle import CompensatedThrottle
from vvdp.hydraulics.directional_valve import DirectionalState, DirectionalValve
from vvdp.hydraulics.flow_control_valve import FlowControlValve
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.opening import OpeningState
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.proportional_valve import ProportionalValve
from vvdp.hydraulics.reducing_valve import ReducingValve
from vvdp.hydraulics.relief_valve import ReliefValve, ShockValve
from vvdp.hydraulics.seat_valve import SeatValve
from vvdp.hydraulics.switching_valve import SpoolState, pulse_stop
from vvdp.programs.unloading import (
    UnloadingMemory,
    UnloadingReading,
    UnloadingSettings,
    unloading_level,
    unloading_start,
    unloading_step,
)

ROOT = 1.0004**-0.25  # signed_root(1e6, 2e4) over 1000
FOUR_WAY = {"conductance": 1e-6, "overlap": 0.05, "transition_pressure": 2e4, "lag": 8e-3}
SPOOL = {"natural_frequency": 200.0, "damping_ratio": 0.7, "stroke": 4e-3, "lap": 1e-3, "full_area": 2e-5}
PORT = {"discharge_coefficient": 0.6, "transition_pressure": 2e4}
PULSES = {"frequency": 10.0}
SEAT = SeatValve(rated_flow=1e-3, rated_drop=5e5, lag=0.01)
MEDIUM = Medium(density=800.0, viscosity=0.03)


@pytest.fixture
def at(oil):
    """Oil at an absolute pressure [Pa]."""
    return lambda pressure: fluid_state(pressure, oil)


def check(time):
    return CheckValve(
        cracking_pressure=0.5e5, rated_flow=6e-4, rated_drop=2.5e5, reverse_opening=0.0, opening_time=time
    )


def relief(override, time=0.0):
    return ReliefValve(cracking_pressure=60e5, override_pressure=override, rated_flow=6e-4, opening_time=time)


def test_check_valve(at):
    a, b = at(10e5), at(7.5e5)
    open_at_once = check_valve(a, b, OpeningState(0.0), check(0.0))
    assert open_at_once.flow == pytest.approx(6e-4 / a.volume_ratio, rel=1e-13)
    assert open_at_once.loss == pytest.approx(open_at_once.flow * (a.enthalpy - b.enthalpy), rel=1e-13)
    assert open_at_once.rates == (0.0,)
    assert check_valve(b, a, OpeningState(0.7), check(0.0)).flow == 0.0
    lags = check_valve(a, b, OpeningState(0.25), check(2e-3))
    assert lags.flow == pytest.approx(1.5e-4 / a.volume_ratio, rel=1e-13)
    assert lags.rates.opening == pytest.approx(375.0, rel=1e-12)  # (1 - 0.25)/2 ms
    back = check_valve(b, a, OpeningState(0.25), check(2e-3))
    assert back.flow == pytest.approx(-1.5e-4 / a.volume_ratio, rel=1e-13)  # oil of the side it comes from
    assert check_start(check(2e-3)) == (0.0,)
    assert CHECK_VALVE.is_passage


def test_pilot_check_valve_lets_oil_back_when_it_is_told_to(at):
    values = PilotCheckValve(
        cracking_pressure=0.5e5,
        rated_flow=6e-4,
        rated_drop=2.5e5,
        reverse_opening=0.0,
        opening_time=0.0,
        pilot_ratio=3.0,
    )
    a, b = at(1e5), at(3.5e5)
    held = pilot_check_valve(a, b, at(1e5), OpeningState(0.0), values)
    assert held.flow == 0.0
    # half lift: 3 (P_x - 1 bar) - 2.5 bar = 1.5 bar
    through = pilot_check_valve(a, b, at(1e5 + 4e5 / 3.0), OpeningState(0.0), values)
    assert -through.flow == pytest.approx(3e-4 / b.volume_ratio, rel=1e-9)
    assert through.loss > 0.0
    assert "pilot" not in through._fields


@pytest.mark.parametrize("inlet", [0.5e5, 0.99e5, 1e5, 17e5, 80e5])
@pytest.mark.parametrize("opening", [0.01, 1.0, 1.5])
def test_lag_of_the_opening_takes_power_only(at, inlet, opening):
    """Whatever the pressure has fallen to: at 0.5 bar against 1 bar oil goes back. A flow that lags would still be
    +6e-4 m^3/s, 30 W out of nothing."""
    found = relief_valve(at(inlet), at(1e5), 0.0, 0.0, OpeningState(opening), relief(5e5, 2e-3))
    assert found.loss >= 0.0
    assert np.sign(found.flow) == np.sign(inlet - 1e5)
    if inlet == 17e5:  # a drop of 16 bar passes half of what 64 bar do, not as much
        assert found.flow == pytest.approx(opening * 6e-4 / 2.0 / at(inlet).volume_ratio, rel=0.01)


def test_relief_valve_in_its_three_limits(at):
    tank = at(1e5)
    over = at(62.5e5)
    dynamic = relief_valve(over, tank, 1.0, 1.0, OpeningState(0.3), relief(5e5, 2e-3))
    # 0.3 Q_r root(61.5/64), next to the transition; (0.5 - 0.3)/2 ms
    assert dynamic.flow == pytest.approx(0.3 * 6e-4 * np.sqrt(61.5 / 64.0) / over.volume_ratio, rel=1e-5)
    assert dynamic.rates.opening == pytest.approx(100.0, rel=1e-12)
    static = relief_valve(over, tank, 1.0, 1.0, OpeningState(0.0), relief(5e5))
    assert static.flow == pytest.approx(dynamic.flow / 0.6, rel=1e-13)
    ideal = relief_valve(at(60e5), tank, 4e-4, 1.0, OpeningState(0.0), relief(0.0))
    assert ideal.flow == pytest.approx(4e-4 / at(60e5).volume_ratio, rel=1e-13)
    for inlet, outlet, surplus in ((at(60e5), tank, -4e-4), (at(59e5), tank, 4e-4), (at(60e5), at(61e5), 4e-4)):
        shut = relief_valve(inlet, outlet, surplus, 0.0, OpeningState(0.0), relief(0.0))
        assert shut.flow == 0.0 and shut.side < 1.0


@pytest.mark.parametrize("time", [0.0, 2e-3])
def test_a_shock_valve_is_a_relief_valve_with_an_override(at, time):
    values = ShockValve(cracking_pressure=60e5, override_pressure=5e5, rated_flow=6e-4, opening_time=time)
    for a, b in ((62.5e5, 1e5), (30e5, 1e5), (62.5e5, 70e5)):
        expected = relief_valve(at(a), at(b), 1.0, 1.0, OpeningState(0.3), relief(5e5, time))
        assert shock_valve(at(a), at(b), 1.0, OpeningState(0.3), values) == expected
    with pytest.raises(ParameterError, match="override_pressure"):
        ShockValve(cracking_pressure=60e5, override_pressure=0.0, rated_flow=6e-4, opening_time=0.0)


def test_reducing_valve(at):
    values = ReducingValve(
        closing_pressure=51e5, override_pressure=5e5, rated_flow=5e-4, rated_drop=4e5, opening_time=0.0
    )
    a, b = at(52.5e5), at(48.5e5)
    assert reducing_valve(a, b, OpeningState(1.0), values).flow == pytest.approx(2.5e-4 / a.volume_ratio, rel=1e-13)
    assert reducing_valve(a, at(51e5), OpeningState(1.0), values).flow == 0.0
    assert reducing_valve(at(1e5), at(70e5), OpeningState(1.0), values).flow == 0.0  # it relieves nothing
    slow = ReducingValve(
        closing_pressure=51e5, override_pressure=5e5, rated_flow=5e-4, rated_drop=4e5, opening_time=5e-3
    )
    late = reducing_valve(a, b, OpeningState(0.9), slow)
    assert late.flow == pytest.approx(4.5e-4 / a.volume_ratio, rel=1e-13)
    assert late.rates.opening == pytest.approx(-80.0, rel=1e-12)
    assert reducing_start(slow) == (1.0,)


def test_flow_control_valve(at):
    values = FlowControlValve(rated_flow=1e-4, minimum_drop=8e5, maximum_drop=50e5, flow_rise=0.05)
    a, b = at(30e5), at(1e5)
    assert flow_control_valve(a, b, values).flow == pytest.approx(1.025e-4 / a.volume_ratio, rel=1e-13)
    assert flow_control_valve(a, b, values, 0.4).flow == pytest.approx(0.41e-4 / a.volume_ratio, rel=1e-13)
    (opening,) = FLOW_CONTROL_VALVE.inputs
    assert opening.default == 1.0


def test_proportional_and_metering_valve(at):
    a, b = at(11e5), at(1e5)
    plain = {"conductance": 1.2e-7, "leakage_conductance": 1e-13, "transition_pressure": 2e4, "lag": 5e-3}
    half = proportional_valve(a, b, 0.8, OpeningState(0.5), ProportionalValve(**plain))
    assert half.flow == pytest.approx((6e-5 * ROOT + 1e-7) / a.volume_ratio, rel=1e-13)
    assert half.rates.opening == pytest.approx(60.0, rel=1e-12)
    values = MeteringValve(**plain, dead_band=0.1, rangeability=100.0)
    metered = metering_valve(a, b, 0.8, OpeningState(0.55), values)
    assert metered.flow == pytest.approx((1.2e-4 / 11.0 * ROOT + 1e-7) / a.volume_ratio, rel=1e-13)
    assert metering_valve(a, b, 0.8, OpeningState(0.1), values).flow == pytest.approx(1e-7 / a.volume_ratio, rel=1e-13)
    for changed in ({"dead_band": 1.0}, {"lag": 0.0}):
        with pytest.raises(ParameterError, match=next(iter(changed))):
            MeteringValve(**({**plain, "dead_band": 0.1, "rangeability": 1.0} | changed))


def test_unloading_and_dump_valve_are_moved_opposite_ways(at):
    a, b = at(6e5), at(1e5)
    unloaded = unloading_valve(a, b, 1.0, OpeningState(0.25), SEAT)
    assert unloaded.flow == pytest.approx(2.5e-4 / a.volume_ratio, rel=1e-13)
    assert unloaded.rates.opening == pytest.approx(75.0, rel=1e-12)
    held = dump_valve(a, b, 1.0, OpeningState(0.25), SEAT)
    assert held.flow == unloaded.flow
    assert held.rates.opening == pytest.approx(-25.0, rel=1e-12)
    assert dump_valve(a, b, 0.0, OpeningState(0.25), SEAT).rates == unloaded.rates
    assert dump_start(SEAT) == (1.0,)
    assert DUMP_VALVE.start is dump_start


def test_throttles_in_series(at):
    a, b = at(11e5), at(1e5)
    values = SeriesThrottles(first_conductance=6e-7, second_conductance=4e-7, transition_pressure=2e4)
    flow, losses = series_throttles(a, b, 0.5, 1.0, values)
    assert flow == pytest.approx(2.4e-4 * ROOT / a.volume_ratio, rel=1e-13)
    assert losses.first / losses.second == pytest.approx(16.0 / 9.0, rel=1e-12)
    assert sum(losses) == pytest.approx(flow * (a.enthalpy - b.enthalpy), rel=1e-13)
    assert series_throttles(a, b, -0.1, 1.0, values).flow == 0.0
    with pytest.raises(ParameterError, match="transition_pressure"):
        SeriesThrottles(first_conductance=6e-7, second_conductance=4e-7, transition_pressure=0.0)


def test_throttle_behind_its_compensator(at):
    """0.5 of 1.2e-6 and 0.5 of 8e-7 share 10 bar as 4 to 9; the compensator shuts from 7 bar on."""
    a, b = at(11e5), at(1e5)
    values = CompensatedThrottle(
        conductance=8e-7, compensator_conductance=1.2e-6, metering_drop=7e5, override_pressure=1e5,
        transition_pressure=2e4, opening_time=5e-3,
    )  # fmt: skip
    found = compensated_throttle(a, b, 0.5, OpeningState(0.5), values)
    assert found.flow == pytest.approx(2.4e-4 / 0.52**0.5 * ROOT / a.volume_ratio, rel=1e-12)
    assert found.losses.compensator / found.losses.metering == pytest.approx(4.0 / 9.0, rel=1e-12)
    assert sum(found.losses) == pytest.approx(found.flow * (a.enthalpy - b.enthalpy), rel=1e-13)
    open_by = (7e5 - 10e5 * 9.0 / 13.0) / 1e5
    assert found.rates.opening == pytest.approx((open_by - 0.5) / 5e-3, rel=1e-9)
    assert compensated_throttle(a, b, 0.0, OpeningState(0.5), values).flow == 0.0
    assert compensated_start(values) == (1.0,)


def test_directional_valve(at):
    p, t, a, b = at(21e5), at(1e5), at(11e5), at(11e5)
    values = DirectionalValve(**FOUR_WAY)
    forward = directional_valve(p, t, a, b, 1.0, DirectionalState(0.525), values)
    q_in, q_out = 5e-4 * ROOT / p.volume_ratio, 5e-4 * ROOT / b.volume_ratio
    assert forward[:4] == pytest.approx((-q_in, q_out, q_in, -q_out), rel=1e-13)
    assert (forward.forward, forward.backward) == pytest.approx((0.5, 0.0), rel=1e-13)
    assert forward.rates.position == pytest.approx(0.475 / 8e-3, rel=1e-12)
    backward = directional_valve(p, t, a, b, 1.0, DirectionalState(-0.525), values)
    assert backward[:4] == pytest.approx((-q_in, q_out, -q_out, q_in), rel=1e-13)
    closed = directional_valve(p, t, a, b, 1.0, DirectionalState(0.04), values)
    assert [abs(q) for q in closed[:4]] == [0.0, 0.0, 0.0, 0.0]


def test_directional_valve_with_a_throttle_in_its_return(at):
    p, t, a, b = at(21e5), at(1e5), at(11e5), at(11e5)

    def flows(position, opening, conductance=1e-6):
        values = ThrottledDirectionalValve(**FOUR_WAY, return_conductance=conductance, return_lag=5e-3)
        state = ThrottledDirectionalState(position, opening)
        return throttled_directional_valve(p, t, a, b, 1.0, 0.8, state, values)

    # edge 0.5e-6 and throttle 0.5e-6 in series: 1/sqrt(2) of one; nothing changes on the way in
    half = flows(0.525, 0.5)
    assert half.tank == pytest.approx(5e-4 / np.sqrt(2.0) * ROOT / b.volume_ratio, rel=1e-12)
    assert half.b == -half.tank
    assert half.a == pytest.approx(5e-4 * ROOT / p.volume_ratio, rel=1e-13)
    assert half.losses.return_throttle == pytest.approx(0.5 * half.tank * (b.enthalpy - t.enthalpy), rel=1e-12)
    assert half.rates.opening == pytest.approx(60.0, rel=1e-12)
    for position in (0.525, -0.8):
        wide = flows(position, 1.0, 1e-2)
        plain = directional_valve(p, t, a, b, 1.0, DirectionalState(position), DirectionalValve(**FOUR_WAY))
        assert wide[:4] == pytest.approx(plain[:4], rel=1e-7)
        assert sum(wide.losses) == pytest.approx(plain.loss, rel=1e-7)
        assert flows(position, 0.0).tank == 0.0
    with pytest.raises(ParameterError, match="return_lag"):
        ThrottledDirectionalValve(**FOUR_WAY, return_conductance=1e-6, return_lag=0.0)


def test_switching_valve(at):
    p, first, second = at(11e5), at(1e5), at(1e5)
    # 0.6 * 1e-5 m^2 * sqrt(2/800) * 1000 = 3e-4
    half_open = switching_valve(
        p, first, second, 0.0, 0.0, 0.0, SpoolState(3.5e-3, 0.0), MEDIUM, ThreeWayValve(**SPOOL, **PORT)
    )
    assert half_open.first == pytest.approx(3e-4 * ROOT / p.volume_ratio, rel=1e-12)
    assert half_open.second == 0.0
    assert half_open.first_area == pytest.approx(1e-5, rel=1e-12)
    assert half_open.rates.velocity == pytest.approx(-((400.0 * np.pi) ** 2) * 3.5e-3, rel=1e-12)
    closed = TwoWayValve(**SPOOL, **PORT, normally_open=0.0)
    opened = TwoWayValve(**SPOOL, **PORT, normally_open=1.0)
    assert two_way_valve(p, first, 0.0, 0.0, 0.0, SpoolState(3.5e-3, 0.0), MEDIUM, closed).flow == half_open.first
    assert two_way_valve(p, first, 0.0, 0.0, 0.0, SpoolState(3.5e-3, 0.0), MEDIUM, opened).flow == 0.0
    assert two_way_valve(p, first, 0.0, 0.0, 0.0, SpoolState(0.0, 0.0), MEDIUM, closed).area == 0.0
    assert two_way_valve(p, first, 0.0, 0.0, 0.0, SpoolState(0.0, 0.0), MEDIUM, opened).area == pytest.approx(
        2e-5, rel=1e-12
    )


def test_pulses_move_the_spool(at):
    p, first, second = at(11e5), at(1e5), at(1e5)
    pulsed = PulsedThreeWayValve(**SPOOL, **PORT, **PULSES, duty_ratio=0.3)
    modulated = ModulatedThreeWayValve(**SPOOL, **PORT, **PULSES)
    plain = ThreeWayValve(**SPOOL, **PORT)
    state = SpoolState(2.5e-3, 0.1)
    for t, command in ((0.0, 1.0), (0.029, 1.0), (0.03, 0.0), (0.099, 0.0), (0.1, 1.0)):
        expected = switching_valve(p, first, second, command, 0.0, 0.0, state, MEDIUM, plain)
        assert pulsed_switching_valve(t, p, first, second, 0.0, 0.0, state, MEDIUM, pulsed) == expected
        assert modulated_switching_valve(t, p, first, second, 0.3, 0.0, 0.0, state, MEDIUM, modulated) == expected
        assert modulated_stop(t, 0.3, modulated) == pulse_stop(t, pulsed)
    assert pulse_stop(0.0, pulsed) == 0.03
    assert modulated_stop(0.0, 0.7, modulated) == 0.7 / 10.0
    two_way = PulsedTwoWayValve(**SPOOL, **PORT, **PULSES, duty_ratio=0.3, normally_open=1.0)
    assert pulse_stop(0.03, two_way) == 0.1
    assert pulsed_two_way_valve(0.03, p, first, 0.0, 0.0, SpoolState(0.0, 0.0), MEDIUM, two_way).area == pytest.approx(
        2e-5
    )


@pytest.mark.parametrize(
    "changed",
    [{"stroke": 0.0}, {"transition_pressure": 0.0}, {"frequency": 0.0}, {"normally_open": 0.5}],
    ids=lambda c: next(iter(c)),
)
def test_values_of_every_part_are_looked_at(changed):
    name = next(iter(changed))
    both = {**SPOOL, **PORT, **PULSES, "duty_ratio": 0.3} | changed
    with pytest.raises(ParameterError, match=name):
        PulsedTwoWayValve(**({"normally_open": 0.0} | both))
    if name != "normally_open":
        with pytest.raises(ParameterError, match=name):
            PulsedThreeWayValve(**both)


def test_flow_source_gives_what_it_is_told_to(at):
    tank, b = at(101325.0), at(200e5)
    pump = flow_source(tank, b, 1e-3, FlowSource(counted_at_outlet=0.0))
    assert pump == pytest.approx((1e-3, 1e-3 * b.enthalpy), rel=1e-13)  # the enthalpy of the tank is 0
    ideal = flow_source(tank, b, 1e-3, FlowSource(counted_at_outlet=1.0))
    assert ideal.flow * b.volume_ratio == pytest.approx(1e-3, rel=1e-13)
    # against stiff oil's Q dp, 19.9 kW: less by about half of 200 bar/1.4 GPa and the air
    assert 0.96 * 1e-3 * 199e5 < pump.supplied < 1e-3 * 199e5


LEVELS = UnloadingSettings(cut_out_pressure=160e5, cut_in_pressure=110e5)


def test_unloading_has_two_levels():
    memory, shown = unloading_start(LEVELS), []
    for bar in (50, 111, 159, 160, 140, 111, 109, 140, 170, 111):
        memory, command = unloading_step(0.0, memory, UnloadingReading(bar * 1e5), LEVELS)
        assert command.unloaded == memory.unloaded
        shown.append(int(command.unloaded))
    assert shown == [0, 0, 0, 1, 1, 1, 0, 0, 1, 1]


def test_unloading_is_called_where_it_acts_and_nowhere_else():
    bar = np.arange(5.0, 250.0, 0.25)
    floors = np.floor(unloading_level(UnloadingReading(bar * 1e5), LEVELS))
    assert bar[1:][np.diff(floors) != 0.0].tolist() == [110.0, 160.0]


@pytest.mark.parametrize(("level", "before", "after"), [(160e5, 0.0, 1.0), (110e5, 1.0, 0.0)])
def test_an_event_that_is_found_to_rounding_counts(level, before, after):
    for pressure in (np.nextafter(level, 0.0), level, np.nextafter(level, np.inf)):
        memory, _ = unloading_step(0.0, UnloadingMemory(before), UnloadingReading(pressure), LEVELS)
        assert memory.unloaded == after


def test_cut_in_is_below_cut_out():
    with pytest.raises(ParameterError, match="cut_in_pressure"):
        UnloadingSettings(cut_out_pressure=110e5, cut_in_pressure=110e5)
