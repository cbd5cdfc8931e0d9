"""The pressure modes: continuous as blended, with jumps as published."""

from dataclasses import replace

import numpy as np
import pytest
from tests.displacement_case import ATMOSPHERE, BAR, LPM, settings_of_chapter_6

from vvdp.base.errors import ParameterError
from vvdp.control.capacities import Sides, capacities, return_flow
from vvdp.control.flow_split import Authority, authority
from vvdp.control.pressure_modes import (
    Actuation,
    Guards,
    PressureBounds,
    Swept,
    acting_mode,
    guarded_actuation,
    guards,
    limit_actuation,
    make_up,
    mode_ends,
    supply_weight,
    swept_flows,
)
from vvdp.control.printed_modes import first_match, printed_actuation

SETTINGS = settings_of_chapter_6()
CYLINDER, BOUNDS, SPLIT = SETTINGS.cylinder, SETTINGS.bounds, SETTINGS.split
LOW, HIGH, BAND = BOUNDS.lowest_pressure, BOUNDS.highest_pressure, BOUNDS.transition_band
THRESHOLDS = (LOW, LOW + BAND, HIGH - BAND, HIGH)
NUDGE = 1e-3
"""Pa, to either side of a threshold."""


def states(rng, count):
    """Direction, position, velocity, effort in that direction, and what the split asks, as arrays."""
    return (
        rng.uniform(0.05, 0.266, count),
        rng.uniform(-0.1, 0.1, count),
        rng.uniform(0.0, 3e5, count),
        rng.uniform(0.0, 10.0, count) * LPM,
    )


def ask(law, direction, state, supply, returned):
    """Flow and opening within their limits, chambers at two pressures."""
    x, v, effort, flow = state
    a, b = CYLINDER.area_a, CYLINDER.area_b
    at = Sides(*((a, b) if direction > 0.0 else (b, a)), supply, returned)
    full = return_flow(returned, SPLIT.least_return_flow, CYLINDER)
    means = authority(capacities(direction, x, ATMOSPHERE, CYLINDER), full)
    wanted = direction * effort
    asked = law(wanted, flow, swept_flows(direction, v, at), guards(at, BOUNDS), means, BOUNDS)
    return limit_actuation(wanted, asked, means, SPLIT.largest_flow), asked, means


def jumps(law, direction, state, supply, returned, step):
    """How far flow [lpm] and opening [1] change where both pressures go over from -step to +step."""
    before = ask(law, direction, state, supply - step[0], returned - step[1])[0]
    after = ask(law, direction, state, supply + step[0], returned + step[1])[0]
    return abs(after.flow - before.flow) / LPM, abs(after.opening - before.opening)


def anywhere(rng, count):
    """Pressures over the whole range, half of them at a threshold, as precisely as numbers are."""
    spread = rng.uniform(ATMOSPHERE, HIGH + 5.0 * BAR, count)
    return np.where(rng.uniform(size=count) < 0.5, rng.choice(THRESHOLDS, count), spread)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_blended_modes_have_no_jump(direction):
    """Over a threshold of either chamber or of both, 1e5 random states: below 1e-3 lpm, openings within 0 to 1.

    The steepest slope is that of a guard: over 2 mPa of a band of 0.5 bar 4e-8 of 40 lpm. Psi at its floor lets little
    through, so the opening of an effort may be large before it is limited, and moves by 4e-8 of that.
    """
    rng, count = np.random.default_rng(int(direction) + 5), 50_000
    for step in ((NUDGE, 0.0), (0.0, NUDGE), (NUDGE, NUDGE), (NUDGE, -NUDGE)):
        state = states(rng, count)
        supply = np.where(step[0] != 0.0, rng.choice(THRESHOLDS, count), anywhere(rng, count))
        returned = np.where(step[1] != 0.0, rng.choice(THRESHOLDS, count), anywhere(rng, count))
        flow, opening = jumps(guarded_actuation, direction, state, supply, returned, step)
        assert np.max(flow) < 1e-3
        assert np.max(opening) < 1e-4
        limited = ask(guarded_actuation, direction, state, supply, returned)[0]
        assert np.all((limited.opening >= 0.0) & (limited.opening <= 1.0))
        assert np.all((limited.flow >= 0.0) & (limited.flow <= SPLIT.largest_flow))


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_blended_modes_give_the_effort_until_limited(direction):
    rng = np.random.default_rng(3)
    state = states(rng, 10_000)
    supply, returned = anywhere(rng, 10_000), anywhere(rng, 10_000)
    limited, asked, means = ask(guarded_actuation, direction, state, supply, returned)
    wanted = direction * state[2]
    parts = np.abs(means.per_flow * asked.flow) + np.abs(means.per_opening * asked.opening)
    given = means.per_flow * asked.flow + means.per_opening * asked.opening
    assert np.max(np.abs(given - wanted) / parts) < 1e-12
    given = means.per_flow * limited.flow + means.per_opening * limited.opening
    inside = (limited.opening > 0.0) & (limited.opening < 1.0)
    assert np.sum(inside) > 1000
    assert np.max(np.abs(given - wanted)[inside]) < 1e-6 * np.max(wanted * direction)


def printed_jumps(law, rng, count, places):
    """Largest jump of flow and opening over random states; `places` gives pressures and the step of each."""
    found = []
    for _ in range(count):
        direction = float(rng.choice((-1.0, 1.0)))
        state = tuple(float(each[0]) for each in states(rng, 1))
        found.append(jumps(law, direction, state, *places(rng)))
    return np.max(found, axis=0)


def at_return_bound(rng):
    """Mode 3 against 3.5, the supply in its normal range."""
    return float(rng.uniform(LOW + BAND, HIGH - BAND)), LOW, (0.0, NUDGE)


def at_supply_thresholds(rng):
    """Where a guard of the supply begins, and one of the return acts."""
    returned = float(rng.choice((rng.uniform(ATMOSPHERE, LOW + BAND), rng.uniform(HIGH - BAND, HIGH + 5.0 * BAR))))
    return float(rng.choice((LOW + BAND, HIGH - BAND))), returned, (NUDGE, 0.0)


def repaired(effort, flow, swept, acting, authority, bounds):
    """The published modes with mode 3.5 going over to the opening of mode 3."""
    ends = mode_ends(swept, authority.full_return, 0.0, bounds)
    return first_match(effort, flow, ends, acting, authority, ends.holding)


def test_printed_mode_3_5_jumps_to_mode_3():
    """By the whole stroke of the valve, in flow that is Psi G/H: retracting at 5 cm 2.97 lpm, and 4.46 lpm with K_v of
    1.2e-7. With the opening of mode 3 cited instead, not at all."""
    rng = np.random.default_rng(11)
    flow, opening = printed_jumps(printed_actuation, rng, 3000, at_return_bound)
    capacity = capacities(-1.0, 0.05, ATMOSPHERE, CYLINDER)
    stroke = return_flow(LOW, 1e-5, CYLINDER) * capacity.return_gain / capacity.supply_gain / LPM
    assert stroke == pytest.approx(2.97, abs=0.01)
    assert 1.5 * stroke == pytest.approx(4.46, abs=0.01)
    assert flow == pytest.approx(stroke, rel=0.02)
    assert opening == pytest.approx(1.0, abs=0.01)
    flow, opening = printed_jumps(repaired, rng, 3000, at_return_bound)
    assert flow < 1e-3
    assert opening < 1e-3


def test_printed_modes_jump_where_both_chambers_leave_their_range():
    rng = np.random.default_rng(12)
    flow, opening = printed_jumps(repaired, rng, 5000, at_supply_thresholds)
    assert flow > 20.0
    assert opening == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("supply", "returned", "mode"),
    [
        (40.0, 40.0, 1.0),
        (0.9, 40.0, 2.0),
        (1.2, 40.0, 2.5),
        (40.0, 0.9, 3.0),
        (40.0, 1.2, 3.5),
        (80.1, 40.0, 4.0),
        (79.8, 40.0, 4.5),
        (40.0, 80.1, 5.0),
        (40.0, 79.8, 5.5),
        (1.4, 79.9, 5.5),
        (79.9, 1.4, 4.5),
        (0.5, 80.5, 2.0),
        (1.25, 1.25, 2.5),
    ],
)
def test_modes_are_named_by_what_acts(supply, returned, mode):
    """Bounds 1 and 80 bar, bands of 0.5 bar; where two act the greater, the supply's of equals."""
    at = Sides(1e-3, 1e-3, supply * BAR + ATMOSPHERE, returned * BAR + ATMOSPHERE)
    assert acting_mode(guards(at, BOUNDS)) == mode


def test_guards_act_by_hand():
    """0.2 bar above the lower bound of 1 bar with a band of 0.5 bar: 0.6; 0.1 bar below the upper one of 80: 0.8."""
    at = Sides(1e-3, 1e-3, 1.2 * BAR + ATMOSPHERE, 79.9 * BAR + ATMOSPHERE)
    assert guards(at, BOUNDS) == pytest.approx((0.6, 0.0, 0.0, 0.8))


def test_ends_of_the_modes_by_hand():
    """q_s = 10 lpm, q_r = -6 lpm, Psi = 20 lpm: 10 + 3 + 0.5, 10 - 3, (-6 - 1.8)/20, (-6 + 7.2)/20."""
    ends = mode_ends(Swept(10.0 * LPM, -6.0 * LPM), 20.0 * LPM, 0.5 * LPM, BOUNDS)
    assert (ends.filling, ends.draining) == pytest.approx((13.5 * LPM, 7.0 * LPM))
    assert (ends.holding, ends.letting) == pytest.approx((-0.39, 0.06))


def test_a_chamber_whose_piston_stands_is_filled_all_the_same():
    """Published, mode 2 would ask for no flow at all."""
    at_rest = Swept(0.0, 0.0)
    assert mode_ends(at_rest, 1e-4, BOUNDS.boost_flow, BOUNDS).filling == BOUNDS.boost_flow
    assert mode_ends(at_rest, 1e-4, 0.0, BOUNDS).filling == 0.0


def test_swept_flows_count_towards_the_supply():
    """2 and 1 cm^2 at 0.1 m/s: extending 20 and 10 cm^3/s; retracting with the same motion, sides exchanged, less."""
    at = Sides(2e-4, 1e-4, 1e6, 1e6)
    assert swept_flows(1.0, 0.1, at) == pytest.approx((2e-5, 1e-5))
    assert swept_flows(-1.0, 0.1, Sides(1e-4, 2e-4, 1e6, 1e6)) == pytest.approx((-1e-5, -2e-5))


def means_of_units(full_return=1.0):
    """One newton a second for each unit of flow and of opening."""
    return Authority(1.0, 1.0, full_return)


def test_limits_hand_over():
    """H = G Psi = 1, flows up to 2. Effort 2.5 with flow 1: the opening of 1.5 ends at 1, the flow makes 1.5 of it.
    Effort 2.5 with flow 3: the opening of -0.5 ends at 0, the flow would be 2.5 and ends at 2, the opening is 0.5."""
    assert limit_actuation(2.5, Actuation(1.0, 1.5), means_of_units(), 2.0) == pytest.approx((1.5, 1.0))
    assert limit_actuation(2.5, Actuation(3.0, -0.5), means_of_units(), 2.0) == pytest.approx((2.0, 0.5))
    assert limit_actuation(9.0, Actuation(3.0, 6.0), means_of_units(), 2.0) == pytest.approx((2.0, 1.0))


def test_the_opening_makes_up_for_missing_flow_but_not_against_a_guard_of_the_return():
    means = means_of_units()
    assert make_up(0.5, 0.2, Guards(0.0, 0.0, 0.0, 0.0), means) == pytest.approx(0.7)
    assert make_up(0.5, 0.2, Guards(1.0, 0.0, 0.0, 0.0), means) == pytest.approx(0.7)
    assert make_up(0.5, 0.2, Guards(0.0, 0.0, 1.0, 0.0), means) == pytest.approx(0.5)
    assert make_up(0.5, 0.2, Guards(0.0, 0.0, 0.25, 0.0), means) == pytest.approx(0.65)
    assert make_up(0.9, 0.2, Guards(0.0, 0.0, 0.0, 0.0), means) == 1.0


def test_weights_of_supply_and_return_add_up():
    assert supply_weight(Guards(0.0, 0.0, 0.0, 0.0)) == 1.0
    assert supply_weight(Guards(0.0, 0.3, 0.1, 0.0)) == pytest.approx(0.75)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"transition_band": 0.0}, "transition_band"),
        ({"highest_pressure": 1.5e5}, "highest_pressure"),
    ],
)
def test_bounds_without_room_are_refused(change, word):
    values = {
        "lowest_pressure": 1e5,
        "highest_pressure": 8e6,
        "transition_band": 5e4,
        "low_margin": 0.3,
        "supply_margin": 0.3,
        "return_margin": 1.2,
        "boost_flow": 0.0,
    }
    with pytest.raises(ParameterError, match=word):
        PressureBounds(**{**values, **change})


WANTED, SWEPT = 1.0, Swept(0.2, 0.4)
"""With H = G Psi = Psi = 1 and a split of 0.5 and 0.5; ends 0.2 + 0.06, 0.2 - 0.06, 0.4 - 0.12, 0.4 + 0.48."""


@pytest.mark.parametrize(
    ("acting", "flow"),
    [
        (Guards(0.0, 0.0, 0.0, 0.0), 0.5),
        (Guards(1.0, 0.0, 0.0, 0.0), 0.5),  # the flow fills already
        (Guards(0.0, 1.0, 0.0, 0.0), 0.14),
        (Guards(0.0, 0.5, 0.0, 0.0), 0.32),
        (Guards(0.0, 0.0, 1.0, 0.0), 0.72),
        (Guards(0.0, 0.0, 0.5, 0.0), 0.61),  # an opening of 0.39
        (Guards(0.0, 0.0, 0.0, 1.0), 0.12),
        (Guards(0.0, 1.0, 1.0, 0.0), 0.43),  # half of 0.14 and half of 0.72
    ],
)
def test_each_guard_by_hand(acting, flow):
    asked = guarded_actuation(WANTED, 0.5, SWEPT, acting, means_of_units(), replace(BOUNDS, boost_flow=0.0))
    assert asked == pytest.approx((flow, 1.0 - flow))


def test_a_supply_that_is_low_is_filled_by_hand():
    """Filling 2 + 0.6 = 2.6 against a split of 0.5, half way: 1.55."""
    asked = guarded_actuation(
        WANTED, 0.5, Swept(2.0, 0.4), Guards(0.5, 0.0, 0.0, 0.0), means_of_units(), replace(BOUNDS, boost_flow=0.0)
    )
    assert asked == pytest.approx((1.55, -0.55))
