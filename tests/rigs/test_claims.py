"""The claims: a number by hand and a law for every formula, an independent check for every simulated comparison."""

from functools import partial

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.base.signal import constant
from vvdp.rigs.ripple import power_of, ripple
from vvdp.rivals import driving_claim, ripple_claim, throttling_claim
from vvdp.rivals.actuation_claim import (
    LIGHT_MASS,
    annular_stroke,
    equal_power_frequency,
    linear_actuation_power,
    rotary_actuation_power,
    same_ports_stroke,
    spool_friction,
)
from vvdp.rivals.claims import claims
from vvdp.rivals.driving_claim import area_scale, best_frequency, scaled_open_loss, self_against_driven
from vvdp.rivals.throttling_claim import against_throttling, break_even_share
from vvdp.steady.steady_states import steady_states
from vvdp.valve.geometry import transition_fraction
from vvdp.valve.losses import full_open_loss
from vvdp.valve.torque import equilibrium_speed, pwm_frequency

pytestmark = pytest.mark.thorough

LPM = 1e-3 / 60.0
SUPPLY = ("supply", "duty_cycles", "supply_assumed", "linear_valves", "linear_switching")
"""Tables of what else there is."""


def test_pwm_valve_loses_less_than_throttling(source_stand):
    """wang2017, chapter 1. At 100 bar and half the flow 1778 W in closed form against 5.1 kW and 3.8 kW."""
    found = against_throttling(source_stand, [0.3, 0.5, 0.7], [100.0 / 120.0])
    assert np.all(found.switched < 0.6 * found.metered)
    middle = found.duty_ratio == 0.5
    # Quasi-steady 1778 W, leakage 26 W; compression between none and 40 W, the oil's yielding 2 %.
    assert found.switched[middle][0] == pytest.approx(1778.0 + 26.0, rel=0.04)
    delivered = 0.43106 * 40 * LPM - 2.6e-6
    assert found.delivered[middle][0] == pytest.approx(delivered, rel=0.02)
    assert found.bled_off[middle][0] == pytest.approx((40 * LPM - delivered) * 100e5, rel=0.02)
    # The loss of the PWM valve does not depend on the duty ratio in between; that of throttling falls with the flow.
    assert np.ptp(found.switched) < 0.02 * found.switched.mean()
    assert np.all(np.diff(found.metered) < 0.0)


def test_friction_of_the_pump_is_in_all_ways_of_control(source_stand):
    """3 N m at 188.50 rad/s: 565.5 W more to lose for each, so what sets them apart stays."""
    rough = source_stand.with_tables(pump={"friction_torque": 3.0})
    smooth, found = (against_throttling(each, [0.5], [0.6]) for each in (source_stand, rough))
    for name in ("switched", "metered", "bled_off"):
        assert getattr(found, name) - getattr(smooth, name) == pytest.approx(565.5, abs=0.1)


def test_bleeding_off_wins_near_full_flow(source_stand):
    """There only the drop of the open valve and its transitions are left to lose, and nothing is bled off."""
    found = against_throttling(source_stand, [0.3, 0.9], [0.4])
    assert found.switched[0] < found.bled_off[0]
    assert found.switched[1] > found.bled_off[1]


def test_break_even_by_hand():
    """Gains 2, 1, -1 at shares 0.2, 0.4, 0.8: zero half-way between the last two."""
    share, switched = np.array([0.2, 0.4, 0.8]), np.array([1.0, 1.0, 1.0])
    assert break_even_share(share, switched, np.array([3.0, 2.0, 0.0])) == pytest.approx(0.6)
    assert break_even_share(share, switched, np.array([0.0, 0.0, 0.0])) == 0.0
    assert np.isnan(break_even_share(share, switched, np.array([3.0, 2.0, 1.5])))


def test_rotary_power_by_hand():
    """k_f = 1.3347e-3 N m s at 72 Hz: 150.8 rad/s, 30.35 W, as published (30 W)."""
    assert rotary_actuation_power(72.0, 3.0, 1.3347e-3) == pytest.approx(30.35, abs=0.02)


def test_linear_power_against_the_motion_itself():
    """0.2 kg, 5 mm in 3 ms, 100 times a second: force times velocity, where it drives, summed over both strokes."""
    mass, stroke, f, kappa = 0.2, 5e-3, 100.0, 0.3
    time = np.linspace(0.0, kappa / f, 200_001)
    acceleration = np.where(time < 0.5 * kappa / f, 1.0, -1.0) * 4.0 * stroke / (kappa / f) ** 2
    velocity = np.concatenate([[0.0], np.cumsum(0.5 * (acceleration[1:] + acceleration[:-1]) * np.diff(time))])
    assert np.trapezoid(velocity, time) == pytest.approx(stroke, rel=1e-3)
    assert abs(velocity[-1]) < 1e-3 * velocity.max()
    driven = np.trapezoid(np.clip(mass * acceleration * velocity, 0.0, None), time)
    assert linear_actuation_power(f, mass, stroke, kappa) == pytest.approx(2.0 * f * driven, rel=1e-3)


def test_powers_go_with_square_and_cube():
    """wang2017, chapter 1."""
    f = np.array([10.0, 40.0, 160.0])
    rotary, linear = rotary_actuation_power(f, 3.0, 1e-3), linear_actuation_power(f, 0.1, 1e-3, 0.3)
    assert power_of(f, rotary) == pytest.approx(2.0)
    assert power_of(f, linear) == pytest.approx(3.0)
    even = equal_power_frequency(3.0, 1e-3, 0.1, 1e-3, 0.3)
    assert rotary_actuation_power(even, 3.0, 1e-3) == pytest.approx(linear_actuation_power(even, 0.1, 1e-3, 0.3))


def test_friction_of_a_driven_spool_goes_with_the_square(source_stand):
    """Simulated at two speeds: what friction takes is k_f omega^2, by the closed form."""
    here = source_stand.set_point
    states = steady_states([(source_stand.with_motor(f), here) for f in (30.0, 90.0)])
    for state in states:
        f = state.summary["pwm_frequency_Hz"]
        expected = rotary_actuation_power(f, 3.0, spool_friction(source_stand))
        # The mean of omega^2 is above the square of the mean by the speed's ripple, below 1 %.
        assert state.summary["loss_spool_friction_W"] == pytest.approx(expected, rel=0.01)


def test_strokes_by_hand(source_stand):
    """2 x 36.5 mm^2 / (2 pi 12.7 mm) = 0.915 mm; twice the axial diagonal of 6.097 mm at zero lap."""
    valve = source_stand.bench.valve
    assert annular_stroke(valve) == pytest.approx(0.9148e-3, rel=1e-3)
    assert same_ports_stroke(valve) == pytest.approx(2.0 * 6.097e-3, rel=1e-3)
    kappa = transition_fraction(valve)
    even = equal_power_frequency(3.0, spool_friction(source_stand), LIGHT_MASS, annular_stroke(valve), kappa)
    assert even > equal_power_frequency(3.0, spool_friction(source_stand), 0.5, same_ports_stroke(valve), kappa)


def test_best_frequency_of_known_curves():
    """Ripple 100/f, loss least at 20: within 4 it is 25 Hz that loses least, within 10 it is 20; within 0.5 none."""
    f = np.array([5.0, 10.0, 20.0, 40.0, 80.0])
    loss, drive = np.array([9.0, 6.0, 5.0, 7.0, 12.0]), f
    found, least, power = best_frequency(f, loss, 100.0 / f, drive, 4.0)
    assert found == pytest.approx(25.0, rel=2e-3)
    assert least == pytest.approx(5.5, rel=2e-3)
    assert power == pytest.approx(25.0, rel=2e-3)
    assert best_frequency(f, loss, 100.0 / f, drive, 10.0)[0] == pytest.approx(20.0, rel=2e-3)
    assert np.isnan(best_frequency(f, loss, 100.0 / f, drive, 0.5)[0])


@pytest.fixture(scope="module")
def driving(orifice_stand):
    return self_against_driven(orifice_stand, [10 * LPM, 40 * LPM], [10.0, 20.0, 60.0, 120.0])


def test_drive_power_is_friction_less_what_the_flow_gives(driving):
    """More frequency takes more power; more flow gives more torque, so less is taken; without flow all is friction."""
    assert np.all(np.diff(driving.drive_power[0]) > 0.0)
    assert np.all(driving.drive_power[1] < driving.drive_power[0])
    assert np.all(driving.drive_power < driving.friction_power)
    # The coupling of 1 N m s lets 0.17 N m of turbine torque slip by 0.17 of 20.9 rad/s: twice 0.8 % in power.
    np.testing.assert_allclose(driving.friction_power[0], driving.friction_power[1], rtol=0.02)


def test_drive_does_nothing_at_the_speed_the_spool_has_anyway(driving):
    """At 40 lpm the drive power crosses zero where the spool spins by itself."""
    crossing = np.interp(0.0, driving.drive_power[1][2:], driving.frequencies[2:])
    assert crossing == pytest.approx(driving.self_frequency[1], rel=0.06)


def test_driven_spool_keeps_the_ripple_at_low_flow(driving):
    """wang2017, section 2.1: where the flow varies, driving pays; a self-spun spool ripples more as the flow falls."""
    assert driving.self_ripple[0] > 2.0 * driving.self_ripple[1]
    assert driving.limit == driving.self_ripple[1]
    assert driving.best_frequency[0] > 2.0 * driving.self_frequency[0]
    assert 0.0 < driving.best_drive_power[0] < 10.0
    assert driving.best_loss[0] < 1.05 * driving.self_loss[0]


def test_flows_of_the_comparison_are_those_of_the_system(orifice_stand, monkeypatch):
    """A quarter to all of the prototype's 40 lpm; at half the speed 10 and 20 lpm are half and all of it."""
    np.testing.assert_allclose([share * 40.0 for share in driving_claim.FLOW_SHARES], [10, 15, 20, 25, 30, 35, 40])
    monkeypatch.setattr(driving_claim, "FLOW_SHARES", (0.5, 1.0))
    slow = orifice_stand.with_tables(operation={"pump_speed": constant(0.5 * orifice_stand.set_point.pump_speed)})
    found = self_against_driven(slow, frequencies=[30.0, 60.0])
    np.testing.assert_allclose(found.flows, [10 * LPM, 20 * LPM], rtol=1e-3)
    assert np.all(np.isfinite(found.self_frequency))


def test_areas_for_self_spinning(source_stand):
    """Half the areas give twice the torque, so twice the speed, and four times the quadratic drops."""
    valve = source_stand.bench.valve
    half = source_stand.with_tables(
        valve={"nozzle_area": 0.5 * valve.nozzle_area, "outlet_area": 0.5 * valve.outlet_area,
               "outlet_effective_area": 0.5 * valve.outlet_effective_area}
    ).bench.valve  # fmt: skip
    q, rho, mu = 40 * LPM, 876.0, 0.0387
    fast = pwm_frequency(equilibrium_speed(q, rho, mu, half), half)
    assert area_scale(q, fast, rho, mu, valve) == pytest.approx(0.5, rel=1e-12)
    assert scaled_open_loss(0.5, q, rho, valve) == pytest.approx(full_open_loss(q, rho, half), rel=1e-9)


def test_ripple_falls_with_frequency_and_volume(orifice_stand):
    """wang2017, chapter 1: other things equal, the faster the smaller; and the more gas, the smaller."""
    found = ripple(orifice_stand, [0.5], [30.0, 60.0], [1.0, 2.0])
    fast, large = found.tables["frequency"]["load_ripple_Pa"], found.tables["accumulator"]["load_ripple_Pa"]
    assert fast[1] == pytest.approx(0.5 * fast[0], rel=0.05)
    assert 0.5 * large[0] < large[1] < 0.7 * large[0]


def test_drives_need_a_load_line(source_stand):
    with pytest.raises(ParameterError, match=wording.rig.expected_load_line):
        self_against_driven(source_stand)


def test_claims_without_a_load_line_say_what_is_missing(source_stand):
    found = claims(source_stand)
    assert set(found.tables) == {"throttling", *SUPPLY, "actuation", "verdicts"}
    assert any(wording.rig.need_load_line in sentence for sentence in found.left_out)
    assert found.numbers["rotary_power_exponent"].value == pytest.approx(2.0)
    assert found.numbers["linear_power_exponent"].value == pytest.approx(3.0)
    assert found.numbers["least_saving_over_metering"].value > 0.3


@pytest.fixture
def quick_claims(monkeypatch):
    """The claims with few points in each of their sweeps."""
    monkeypatch.setattr(throttling_claim, "against_throttling", partial(against_throttling, duty_ratios=[0.4, 0.9]))
    few = partial(self_against_driven, flows=[20 * LPM, 40 * LPM], frequencies=[30.0, 60.0])
    monkeypatch.setattr(driving_claim, "self_against_driven", few)
    monkeypatch.setattr(ripple_claim, "FREQUENCIES", (30.0, 60.0))
    monkeypatch.setattr(ripple_claim, "SIZES", (0.5, 1.0))
    return claims


def test_driven_spool_that_the_flow_cannot_turn(orifice_stand, quick_claims):
    """Twenty times the friction of 1.3349e-3 N m s, 0.0267: beside it there is no self-spinning spool, all else is."""
    area = orifice_stand.bench.valve.friction_area
    found = quick_claims(orifice_stand.with_tables(valve={"friction_area": 20.0 * area}).with_motor(60.0))
    assert set(found.tables) == {"throttling", *SUPPLY, "ripple_frequency", "ripple_volume", "actuation", "verdicts"}
    words = wording.rig.does_not_turn.format(friction="0.0267 N*m*s")
    assert any(sentence.startswith(words) for sentence in found.left_out)
    assert "largest_drive_power_W" not in found.numbers


def test_line_without_gas_has_claims(orifice_stand, quick_claims, monkeypatch):
    """The gas volume is then varied around 50 cm^3, precharged to half the load's 101 bar. Gas takes in
    50e-6 x 0.5^(1/1.3) / (1.3 x 101e5) = 2.23e-12 m^3/Pa, oil and hose 4.1e-13: 84.5 % are the gas's.
    """
    few = partial(self_against_driven, flows=[40 * LPM], frequencies=[60.0])
    monkeypatch.setattr(driving_claim, "self_against_driven", few)
    rigid = orifice_stand.with_tables(load_line={"gas_volume": 0.0, "precharge_pressure": 0.0})
    found = quick_claims(rigid)
    assert {"driving", "best", "ripple_frequency", "ripple_volume"} < set(found.tables)
    np.testing.assert_allclose(found.tables["ripple_volume"]["gas_volume_m3"], [25e-6, 50e-6])
    assert found.numbers["gas_share_of_line_capacity"].value == pytest.approx(0.845, abs=0.005)


def test_system_that_delivers_nothing_has_claims(orifice_stand, quick_claims):
    """At duty ratio 0.005 no orifice holds the pressure: what runs at other duty ratios is there still."""
    found = quick_claims(orifice_stand.with_tables(operation={"duty_ratio": constant(0.005)}))
    assert {"throttling", "actuation"} < set(found.tables)
    words = wording.rig.no_steady_state
    assert any(finding.text == words for finding in found.findings)
    assert any(
        sentence.startswith(wording.rig.no_periodic_state.format(system="prototype")) for sentence in found.left_out
    )
    assert "largest_drive_power_W" not in found.numbers
