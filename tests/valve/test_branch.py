from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from vvdp.valve.branch import (
    branch_drops,
    branch_flow,
    branch_law,
    choking_ratio,
    law_flow,
    power_near_one,
    throttled_flow,
    turbulent_drops,
)

RHO = 876.0
LPM = 1.0 / 6e4

flows = st.floats(-7.0, np.log10(2e-3)).map(lambda power: 10.0**power)
openings = st.floats(-4.0, 0.0).map(lambda power: 10.0**power)
signs = st.sampled_from([-1.0, 1.0])


def with_exponent(valve, m):
    """The valve with another exponent but the same drop at 40 lpm."""
    factor = (40.0 * LPM) ** (m - valve.centre_flow_exponent)
    return replace(valve, centre_flow_exponent=m, centre_coefficient=valve.centre_coefficient * factor)


@pytest.mark.parametrize(
    ("lpm", "nozzle", "centre", "outlet", "total"),
    [
        (10.0, 0.2454, 0.0574, 0.1212, 0.4240),
        (20.0, 0.9817, 0.2157, 0.4848, 1.6822),
        (26.7, 1.7496, 0.3745, 0.8640, 2.9881),
        (30.0, 2.2089, 0.4678, 1.0908, 3.7675),
        (40.0, 3.9269, 0.8105, 1.9392, 6.6765),
        (60.0, 8.8355, 1.7582, 4.3632, 14.9568),
        (80.0, 15.7075, 3.0458, 7.7568, 26.5101),
    ],
)
def test_drops_of_the_open_valve(prototype, lpm, nozzle, centre, outlet, total):
    # at 40 lpm: 438 (6.6667e-4 / (0.61 * 36.5e-6))^2 = 438 * 29.942^2 = 3.9269e5 Pa;
    # 6.6667e-4^1.91 / (1.45e-6 * 0.0254^3.22) = 8.5852e-7 / 1.0593e-11 = 8.105e4 Pa;
    # 438 (6.6667e-4 / (0.677 * 46.8e-6))^2 = 438 * 21.041^2 = 1.9392e5 Pa
    drops = turbulent_drops(lpm * LPM, 1.0, RHO, prototype)
    # to half a unit of the last printed digit
    assert [1e-5 * drop for drop in drops] == pytest.approx([nozzle, centre, outlet], abs=0.6e-4)
    assert 1e-5 * sum(drops) == pytest.approx(total, abs=0.6e-4)


@given(flows, openings, signs, st.floats(1.76, 2.0))
def test_flow_inverts_the_drop(prototype, flow, opening, sign, m):
    valve = with_exponent(prototype, m)
    drops = branch_drops(sign * flow, opening, RHO, valve)
    found = branch_flow(sum(drops), opening, RHO, valve)
    assert found.flow == pytest.approx(sign * flow, rel=1e-12)
    assert sum(branch_drops(found.flow, opening, RHO, valve)) == pytest.approx(sum(drops), rel=2e-12)


@given(flows.map(lambda flow: max(flow, 1e-6)), openings, signs, st.floats(1.7, 2.0))
def test_flow_inverts_the_drop_for_the_smallest_exponent(prototype, flow, opening, sign, m):
    valve = with_exponent(prototype, m)
    drop = sum(branch_drops(sign * flow, opening, RHO, valve))
    assert branch_flow(drop, opening, RHO, valve).flow == pytest.approx(sign * flow, rel=1e-12)


@given(flows, openings, signs)
def test_shares_divide_the_drop_as_the_law_does(prototype, flow, opening, sign):
    drops = branch_drops(sign * flow, opening, RHO, prototype)
    found = branch_flow(sum(drops), opening, RHO, prototype)
    shares = (found.nozzle_share, found.centre_share, found.outlet_share)
    assert sum(shares) == pytest.approx(1.0, rel=4e-16)
    assert [share * sum(drops) for share in shares] == pytest.approx(list(drops), rel=1e-12)


def test_flow_against_a_root_finder(prototype):
    # The law without smoothing, solved by other means; at 20 bar smoothing changes the flow by (5e3/2e6)^2/4 = 1.6e-6.
    for opening in (0.05, 0.4, 1.0):
        expected = brentq(lambda q, a=opening: sum(turbulent_drops(q, a, RHO, prototype)) - 2e6, 1e-9, 1e-2, xtol=1e-16)
        assert branch_flow(2e6, opening, RHO, prototype).flow == pytest.approx(expected, rel=2e-6)


def test_smooth_law_becomes_the_turbulent_one_far_above_the_transition_pressure(prototype):
    # dp^2 / sqrt(dp^2 + eps^2) = s  gives  dp = s (1 + eps^2 / (2 s^2) + ...)
    s = sum(turbulent_drops(40.0 * LPM, 1.0, RHO, prototype))
    dp = sum(branch_drops(40.0 * LPM, 1.0, RHO, prototype))
    assert dp / s - 1.0 == pytest.approx(0.5 * (5e3 / s) ** 2, rel=1e-3)


def test_a_shut_port_passes_nothing_and_stays_finite(prototype):
    shut = branch_flow(2e6, 0.0, RHO, prototype)
    assert shut.flow == 0.0
    assert (shut.nozzle_share, shut.centre_share, shut.outlet_share) == (pytest.approx(1.0, rel=1e-15), 0.0, 0.0)
    # C_d A sqrt(2 dp / rho) = 0.61 * 36.5e-6 * sqrt(4e6 / 876) = 2.2265e-5 * 67.574 = 1.50454e-3 m3/s
    assert shut.full_section_flow == pytest.approx(1.50454e-3, rel=1e-5)
    assert branch_flow(2e6, 1e-9, RHO, prototype).full_section_flow == pytest.approx(shut.full_section_flow, rel=1e-12)


def test_law_is_smooth_and_odd_through_zero(prototype):
    assert branch_flow(0.0, 0.5, RHO, prototype).flow == 0.0
    dp = np.linspace(-100.0, 100.0, 2001)
    flow = branch_flow(dp, 0.5, RHO, prototype).flow
    assert np.all(np.isfinite(flow))
    assert flow == pytest.approx(-flow[::-1], rel=1e-11, abs=1e-25)
    assert np.all(np.diff(flow) > 0.0)


@given(st.floats(1e2, 4e7), st.floats(1e2, 4e7), openings, openings)
def test_flow_grows_with_drop_and_opening(prototype, one, other, narrow, wide):
    low, high = sorted((one, other))
    a, b = sorted((narrow, wide))
    least = branch_flow(low, a, RHO, prototype).flow
    assert branch_flow(high, a, RHO, prototype).flow >= least * (1.0 - 1e-14)
    assert branch_flow(low, b, RHO, prototype).flow >= least * (1.0 - 1e-14)


def test_outlet_rail_adds_its_own_drop(prototype):
    # 1 bar at 40 lpm: 1e5 / (6.66667e-4)^2 = 2.25e11
    valve = replace(prototype, rail_coefficient=2.25e11)
    Q = 40.0 * LPM
    extra = turbulent_drops(Q, 1.0, RHO, valve).outlet_turbine - turbulent_drops(Q, 1.0, RHO, prototype).outlet_turbine
    assert extra == pytest.approx(1e5, rel=1e-12)


positive = st.floats(0.5, 2.0)


@given(positive, positive, positive)
def test_branch_law_is_free_of_units(prototype, m, kg, s):
    Pa, flow = kg / (m * s**2), m**3 / s
    # drop = Q^m_c / (k D^n): k carries (m3/s)^m_c m^-n / Pa
    k = flow**prototype.centre_flow_exponent / m**prototype.centre_diameter_exponent / Pa
    scaled = replace(
        prototype,
        spool_radius=prototype.spool_radius * m,
        inlet_radius=0.0,
        outlet_radius=0.0,
        helix_length=prototype.helix_length * m,
        nozzle_area=prototype.nozzle_area * m**2,
        outlet_area=prototype.outlet_area * m**2,
        centre_coefficient=prototype.centre_coefficient * k,
        transition_pressure=prototype.transition_pressure * Pa,
        radial_clearance=prototype.radial_clearance * m,
    )
    Q = branch_flow(3e5, 0.4, RHO, prototype).flow
    # The still flow of 1e-11 m3/s is not scaled: (1e-11 / 1e-4)^2 is far below the tolerance.
    assert branch_flow(3e5 * Pa, 0.4, RHO * kg / m**3, scaled).flow == pytest.approx(Q * flow, rel=1e-12)


def test_power_near_one():
    assert power_near_one(1.0, -0.1) == 1.0
    for e in (-0.15, -0.045, 0.0):
        for base in (0.3, 0.5, 0.8, 1.0):
            assert power_near_one(base, e) == pytest.approx(base**e, rel=2e-3 if base < 0.5 else 1.5e-4)
    # next term of the series: fifth order
    errors = [abs(power_near_one(1.0 + d, -0.1) / (1.0 + d) ** -0.1 - 1.0) for d in (0.04, 0.02)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(5.0, abs=0.1)


def choking(valve, recovery, vapour_pressure=0.0):
    return branch_law(RHO, replace(valve, pressure_recovery=recovery), vapour_pressure)


def test_choked_nozzles_by_hand(prototype):
    # F_L 0.9, 680 kPa, P_v 70.1 kPa: 0.81 * (680 - 0.96 * 70.1) = 496.29 kPa; R_n = 438/(0.61 * 36.5e-6)^2 = 8.8355e11,
    # Q = a sqrt(496290/8.8355e11) = a * 7.4947e-4 m^3/s; the drop left behind the nozzles: 1 - 0.49629/0.68 = 0.270
    law = choking(prototype, 0.9, 70.1e3)
    assert law.nozzle == pytest.approx(8.8355e11, rel=1e-4)
    found = throttled_flow(680e3, 0.0, 0.1, law)
    assert found.flow == pytest.approx(0.1 * 7.4947e-4, rel=1e-4)
    assert choking_ratio(law_flow(680e3, 0.1, law), 680e3, law) == pytest.approx(680.0 / 496.29, rel=0.02)


@given(st.floats(0.02, 1.0), st.floats(1e5, 1.2e7), st.floats(0.3, 0.9))
def test_a_choked_flow_does_not_depend_on_the_pressure_behind_it(prototype, opening, inlet, recovery):
    law = choking(prototype, recovery, 2e4)
    lowest, ratio = throttled_flow(inlet, 0.0, opening, law), choking_ratio(law_flow(inlet, opening, law), inlet, law)
    for behind in (0.1 * inlet, 0.2 * inlet):
        found, free = throttled_flow(inlet, behind, opening, law), law_flow(inlet - behind, opening, law)
        choked = choking_ratio(free, inlet, law)
        assert choked <= ratio
        if choked > 1.0:
            assert found.flow == pytest.approx(lowest.flow, rel=1e-12)
            limit = recovery * recovery * max(inlet - 0.96 * 2e4, 5e3)
            assert law.nozzle * found.full_section_flow**2.0 == pytest.approx(limit, rel=1e-12)
        else:
            assert found == pytest.approx(free, rel=1e-12)


@given(st.floats(0.02, 1.0), st.floats(2e5, 1.2e7), st.floats(0.2, 1.0))
def test_drops_behind_choked_nozzles_are_those_of_the_flow(prototype, opening, inlet, recovery):
    """The shares sum to 1, and centre section and turbine take what their laws say; smoothing is below 1e-3 there."""
    law = choking(prototype, recovery)
    found = throttled_flow(inlet, 0.0, opening, law)
    assert found.nozzle_share + found.centre_share + found.outlet_share == pytest.approx(1.0, rel=1e-14)
    drops = turbulent_drops(found.flow, opening, RHO, prototype)
    assert found.centre_share * inlet == pytest.approx(drops.centre_section, rel=1e-3)
    assert found.outlet_share * inlet == pytest.approx(drops.outlet_turbine, rel=1e-3)
    assert found.nozzle_share * inlet >= drops.nozzle * (1.0 - 1e-3)


@given(st.floats(0.02, 1.0), st.floats(1e5, 1.2e7), st.floats(1.0, 1.2), st.floats(0.0, 1.0), st.floats(0.2, 0.9))
def test_flow_follows_both_pressures(prototype, opening, inlet, more, share, recovery):
    law = choking(prototype, recovery)
    flow = throttled_flow(inlet, share * inlet, opening, law).flow
    assert throttled_flow(more * inlet, share * inlet, opening, law).flow >= flow * (1.0 - 1e-12)
    assert throttled_flow(inlet, share * inlet / more, opening, law).flow >= flow * (1.0 - 1e-12)


@given(st.floats(0.02, 1.0), st.floats(-1e7, 1e7), st.floats(1e5, 1e7))
def test_nozzles_that_regain_nothing_do_not_choke_above_boiling(prototype, opening, drop, behind):
    """F_L = 1: the narrowest section has the pressure behind the nozzles. Nor does any valve choke backwards."""
    free = law_flow((behind + drop) - behind, opening, choking(prototype, 1.0))
    assert throttled_flow(behind + drop, behind, opening, choking(prototype, 1.0)) == pytest.approx(free, rel=1e-12)
    if drop < 0.0:
        assert throttled_flow(behind + drop, behind, opening, choking(prototype, 0.1)) == pytest.approx(free, rel=1e-12)
    assert throttled_flow(behind + drop, behind, opening, choking(prototype, 0.0)) == pytest.approx(free, rel=1e-12)


@pytest.mark.parametrize(("exponent", "error"), [(1.5, 2.3e-5), (1.6, 1.5e-7), (1.7, 1e-10)])
def test_smaller_exponents_are_refused_for_the_error_of_the_inversion(prototype, exponent, error):
    """The same drop at 40 lpm, flows from 1e-7 to 2e-3 m^3/s, all openings: the largest error of the flow."""
    rng = np.random.default_rng(3)
    flow, opening = 10.0 ** rng.uniform(-7.0, np.log10(2e-3), 50000), 10.0 ** rng.uniform(-4.0, 0.0, 50000)
    law = branch_law(RHO, prototype)
    factor = (40.0 * LPM) ** (1.91 - exponent)
    law = law._replace(flow_exponent=exponent, centre_section=law.centre_section * factor)
    centre = law.centre_section * (flow * flow + 1e-22) ** (0.5 * exponent - 1.0)
    s = (law.nozzle / opening**2.0 + law.outlet_turbine + centre) * flow * flow
    drop = np.sqrt(0.5 * s * (s + np.sqrt(s * s + 4.0 * law.transition_pressure**2.0)))
    found = np.max(np.abs(law_flow(drop, opening, law).flow / flow - 1.0))
    assert 0.3 * error < found < 1.2 * error
