from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.valve.geometry import (
    barrier_width,
    helix_slope,
    jet_skews,
    nozzle_hydraulic_diameter,
    nozzle_length,
    nozzle_width,
    pitch,
    port_openings,
    port_shape,
    transition_fraction,
)


def test_dimensions_of_the_prototype(prototype):
    # pitch 2 pi 12.7 / 3 = 26.599 mm; tan(alpha) = 40.64 / 26.599 = 1.5279;
    # d_c = sqrt(2 * 12.1667 / 1.5279) = 3.9908 mm; d_a = 3.9908 * 1.5279 = 6.0974 mm
    assert pitch(prototype) == pytest.approx(26.599e-3, rel=1e-4)
    assert helix_slope(prototype) == pytest.approx(1.5279, rel=1e-4)
    assert nozzle_width(prototype) == pytest.approx(3.9908e-3, rel=1e-4)
    assert nozzle_length(prototype) == pytest.approx(6.0974e-3, rel=1e-4)
    assert barrier_width(prototype) == pytest.approx(3.9908e-3, rel=1e-4)
    # side sqrt(1.9954^2 + 3.0487^2) = 3.6436 mm; 4 * 12.1667 / (4 * 3.6436) = 3.3392 mm
    assert nozzle_hydraulic_diameter(prototype) == pytest.approx(3.3392e-3, rel=1e-4)


def test_the_nozzles_have_their_area(prototype):
    assert 3.0 * nozzle_width(prototype) * nozzle_length(prototype) / 2.0 == pytest.approx(36.5e-6, rel=1e-14)


@pytest.mark.parametrize("sections", [2.0, 3.0, 5.0])
def test_transition_fraction_does_not_depend_on_the_number_of_sections(prototype, sections):
    # sqrt(2 A / (pi R L)) = sqrt(73e-6 / (pi * 12.7e-3 * 20.32e-3)) = sqrt(0.0900421) = 0.30007
    assert transition_fraction(replace(prototype, sections=sections)) == pytest.approx(0.30007, abs=1e-5)


def sampled_openings(angle, axial_position, valve):
    """Openings by throwing points into one nozzle and asking on which side of the barriers each of them lies."""
    R, L, N = valve.spool_radius, valve.helix_length, valve.sections
    P = 2.0 * np.pi * R / N
    slope = 2.0 * L / P
    area = valve.nozzle_area / N
    half_width = np.sqrt(2.0 * area / slope) / 2.0
    half_length = half_width * slope
    barrier = valve.lap_ratio * 2.0 * half_width
    # two-dimensional golden-ratio sequence: even in every direction, so the edges of the nozzle do not resonate with it
    n = np.arange(30000)
    across = (2.0 * ((n * 0.7548776662466927) % 1.0) - 1.0) * half_width
    along = (2.0 * ((n * 0.5698402909980532) % 1.0) - 1.0) * half_length
    inside = abs(across) / half_width + abs(along) / half_length < 1.0
    arc = angle * R + across[inside]
    height = axial_position + along[inside]
    # The barriers' centre lines rise from the apex at height 0, arc k P, with the slope of the helix on both sides.
    k = np.arange(np.floor(arc.min() / P) - 1.0, np.ceil(arc.max() / P) + 2.0)
    beyond = np.max(height[:, None] / slope - abs(arc[:, None] - k * P), axis=1)
    return np.mean(beyond > barrier / 2.0), np.mean(beyond < -barrier / 2.0)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("lap", [0.3, 0.7, 1.0, 1.3, 2.0])
@pytest.mark.parametrize("length", [6e-3, 20.32e-3, 60e-3])
def test_openings_are_the_area_of_the_nozzle_between_the_barriers(prototype, lap, length):
    valve = replace(prototype, lap_ratio=lap, helix_length=length)  # kappa from 0.11 to 0.83
    kappa = transition_fraction(valve)
    for duty in np.linspace(-kappa, 1.0 + kappa, 13):
        for angle in np.linspace(-1.4, 1.4, 9):
            openings = port_openings(angle, duty * length, valve)
            load, tank = sampled_openings(angle, duty * length, valve)
            assert openings.load == pytest.approx(load, abs=0.005), (duty, angle)
            assert openings.tank == pytest.approx(tank, abs=0.005), (duty, angle)


angles = st.floats(-20.0, 20.0)
duties = st.floats(-0.6, 1.6)
laps = st.floats(0.1, 2.0)


@given(angles, duties, laps)
def test_load_and_tank_change_places_with_the_duty_ratio_and_half_a_period(prototype, angle, duty, lap):
    valve = replace(prototype, lap_ratio=lap)
    one = port_openings(angle, duty * valve.helix_length, valve)
    other = port_openings(angle + np.pi / valve.sections, (1.0 - duty) * valve.helix_length, valve)
    assert other.load == pytest.approx(one.tank, abs=1e-11)
    assert other.tank == pytest.approx(one.load, abs=1e-11)


@given(angles, duties, laps)
def test_openings_repeat_with_the_pitch_and_mirror_at_the_apex(prototype, angle, duty, lap):
    valve = replace(prototype, lap_ratio=lap)
    x = duty * valve.helix_length
    one = port_openings(angle, x, valve)
    assert port_openings(angle + 2.0 * np.pi / 3.0, x, valve) == pytest.approx(one, abs=1e-11)
    assert port_openings(-angle, x, valve) == pytest.approx(one, abs=1e-11)


@given(angles, duties, laps)
def test_openings_are_fractions_and_the_barrier_takes_the_rest(prototype, angle, duty, lap):
    valve = replace(prototype, lap_ratio=lap)
    load, tank = port_openings(angle, duty * valve.helix_length, valve)
    assert 0.0 <= load <= 1.0
    assert 0.0 <= tank <= 1.0
    assert load + tank <= 1.0 + 1e-12


@given(angles, duties, st.floats(1.0, 2.0))
def test_no_port_short_circuits_another_without_underlap(prototype, angle, duty, lap):
    valve = replace(prototype, lap_ratio=lap)
    load, tank = port_openings(angle, duty * valve.helix_length, valve)
    # both factors are rounded, hence not exactly zero
    assert min(load, tank) < 1e-12


@pytest.mark.parametrize(("duty", "peak"), [(0.05, 0.028), (0.1, 0.111), (0.2, 0.444), (0.3, 1.0)])
def test_peak_opening_below_the_transition_fraction(prototype, duty, peak):
    # (d_0 / kappa)^2: both edges cut the nozzle to the same fraction
    opening = port_openings(0.0, duty * prototype.helix_length, prototype).load
    assert opening == pytest.approx((duty / 0.3000701) ** 2, rel=1e-6)
    assert opening == pytest.approx(peak, abs=5e-4)


@pytest.mark.parametrize("duty", [0.31, 0.5, 0.69])
def test_zero_lap_gives_the_load_its_duty_ratio_of_every_period(prototype, duty):
    angle = 2.0 * np.pi / 3.0 * (np.arange(20000) + 0.5) / 20000
    openings = port_openings(angle, duty * prototype.helix_length, prototype)
    assert np.mean(openings.load > 0.0) == pytest.approx(duty, abs=2e-4)
    assert np.mean(openings.tank > 0.0) == pytest.approx(1.0 - duty, abs=2e-4)


@pytest.mark.parametrize("lap", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("duty", [0.4, 0.5, 0.6])
def test_mean_opening_is_the_wedge_less_its_barrier(prototype, duty, lap):
    # Averaged over the angle every point of the nozzle sees the load over (d - b) / pitch, and d is linear in height.
    valve = replace(prototype, lap_ratio=lap)
    angle = 2.0 * np.pi / 3.0 * (np.arange(20000) + 0.5) / 20000
    mean = np.mean(port_openings(angle, duty * valve.helix_length, valve).load)
    assert mean == pytest.approx(duty - barrier_width(valve) / pitch(valve), abs=1e-7)


def test_the_ends_of_the_stroke_are_free_of_transitions(prototype):
    kappa, L = transition_fraction(prototype), prototype.helix_length
    angle = np.linspace(0.0, 2.1, 2001)
    for x in (-kappa * L, -0.4 * L, -2.0 * L):
        assert np.all(port_openings(angle, x, prototype).tank == pytest.approx(1.0, abs=1e-12))
    for x in ((1.0 + kappa) * L, 1.5 * L):
        assert np.all(port_openings(angle, x, prototype).load == pytest.approx(1.0, abs=1e-12))
    # At x = 0 the load port never opens, yet the tank port shuts once per period.
    at_zero = port_openings(angle, 0.0, prototype)
    assert at_zero.load.max() < 1e-12
    assert at_zero.tank.min() < 1e-12


def skew(angle, duty, valve, asymmetry=1.0):
    return jet_skews(angle, duty * valve.helix_length, asymmetry, port_shape(valve))


def test_a_jet_counts_more_while_its_port_closes(prototype):
    """One edge over the nozzle: a (1 - a) more where the load's barrier closes over it, the same less in the opening
    tank port. With d_0 = 0.5 and zero lap the load's edge crosses the nozzle's centre at (0.5 - 0.150)/2 = 0.175."""
    ramp = nozzle_width(prototype) / pitch(prototype)
    for share in (0.1, 0.25, 0.5, 0.9):
        angle = 2.0 * np.pi / 3.0 * (0.5 * (0.5 - ramp) + (0.5 - share) * ramp)
        assert port_openings(angle, 0.5 * prototype.helix_length, prototype) == pytest.approx((share, 0.0), abs=1e-12)
        assert skew(angle, 0.5, prototype) == pytest.approx((share * (1.0 - share), 0.0), abs=1e-12)
        assert skew(-angle, 0.5, prototype, 0.85) == pytest.approx((-0.85 * share * (1.0 - share), 0.0), abs=1e-12)
        behind = angle + 2.0 * np.pi / 3.0 * ramp
        a = port_openings(behind, 0.5 * prototype.helix_length, prototype).tank
        assert a == pytest.approx(1.0 - share, abs=1e-12)
        assert skew(behind, 0.5, prototype) == pytest.approx((0.0, -a * (1.0 - a)), abs=1e-12)


@given(angles, duties, laps, st.sampled_from([4e-3, 6e-3, 20.32e-3, 60e-3]))
def test_skews_are_odd_bounded_and_periodic(prototype, angle, duty, lap, length):
    valve = replace(prototype, lap_ratio=min(lap, 1.8), helix_length=length)
    one, openings = skew(angle, duty, valve), port_openings(angle, duty * valve.helix_length, valve)
    # Not more than the opening, so that a jet's torque never changes its sign, and nothing where it is open or shut.
    for found, a in zip(one, openings, strict=True):
        assert abs(found) <= min(a, 1.0 - a) + 1e-12
    other = skew(-angle, duty, valve)
    assert other == pytest.approx((-one.load, -one.tank), abs=1e-12)
    assert skew(angle + 2.0 * np.pi / 3.0, duty, valve) == pytest.approx(one, abs=1e-11)


@given(duties, laps)
def test_a_port_cut_alike_from_both_sides_has_no_skew(prototype, duty, lap):
    valve = replace(prototype, lap_ratio=lap)
    for angle in (0.0, np.pi / 3.0):  # the middle of the load's wedge and of the tank's
        assert skew(angle, duty, valve) == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("duty", [0.1, 0.2, 0.5, 0.9])
def test_skews_are_continuous(prototype, duty):
    """Their slope is at most that of three ramps; a jump would be far steeper."""
    angle = np.linspace(-np.pi / 3.0, np.pi / 3.0, 20001)
    step = 3.0 * (angle[1] - angle[0]) / (2.0 * np.pi) * pitch(prototype) / nozzle_width(prototype)
    for found in skew(angle, duty, prototype):
        assert np.max(np.abs(np.diff(found))) < 3.0 * step
        assert np.max(np.abs(found)) > 0.01


@given(angles, duties, laps)
def test_load_and_tank_change_places_at_the_other_duty_ratio(prototype, angle, duty, lap):
    """Half a period on, the load's wedges stand where the tank's gaps stood; so do the jets' skews."""
    valve = replace(prototype, lap_ratio=lap)
    one, other = skew(angle, duty, valve), skew(angle + np.pi / 3.0, 1.0 - duty, valve)
    assert (one.load, one.tank) == pytest.approx((other.tank, other.load), abs=1e-11)
