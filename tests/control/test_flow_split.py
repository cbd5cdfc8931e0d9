"""The split between pump and return valve: variance and flow against the filter's own differential equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.displacement_case import LPM, settings_of_chapter_6

from vvdp.base.errors import ParameterError
from vvdp.control.flow_split import (
    Authority,
    FlowSplit,
    SplitMemory,
    sensitivity,
    split_start,
    split_step,
    steady_variance,
)

SPLIT = settings_of_chapter_6().split
MEANS = Authority(per_flow=1.2e9, per_opening=7e8 * 1.3e-4, full_return=1.3e-4)


def published_rates(effort, expected, settings=SPLIT, means=MEANS):
    """Q' and P_e' of eqs. 6.28 and 6.31 as they stand, with Qbar."""
    ratio, rate = means.per_flow / means.per_opening, settings.flow_rate
    QJ, RJ = settings.flow_deviation**2, settings.opening_deviation**2
    nu = (effort - means.per_opening * settings.mean_opening) / means.per_opening

    def rates(t, y):
        flow, Pe = y
        gain = Pe * ratio / RJ
        return [
            -rate * (flow - expected) + gain * (nu - ratio * flow),
            -2 * rate * Pe + rate**2 * QJ - ratio**2 * Pe**2 / RJ,
        ]

    return rates


def test_sensitivity_by_hand():
    """(1.5e-4/0.2)^2 (1.2e9/9.1e4)^2 = 5.625e-7 1.73892e8 = 97.814."""
    assert sensitivity(MEANS, SPLIT) == pytest.approx(97.814, rel=1e-4)


def test_steady_gain_is_the_closed_form():
    """L H/(G Psi) = lambda_Q c p = sqrt(lambda_Q^2 + lambda_Q^2 c) - lambda_Q, and the variance stays there."""
    c = sensitivity(MEANS, SPLIT)
    p = steady_variance(c)
    assert SPLIT.flow_rate * c * p == pytest.approx(
        np.sqrt(SPLIT.flow_rate**2 * (1.0 + c)) - SPLIT.flow_rate, rel=1e-14
    )
    assert split_step(SplitMemory(1e-4, p), 2e5, 1e-4, MEANS, 0.3, SPLIT).variance == pytest.approx(p, rel=1e-14)
    assert split_step(split_start(), 2e5, 1e-4, MEANS, 100.0, SPLIT).variance == pytest.approx(p, rel=1e-12)


def test_variance_and_flow_follow_the_published_equations():
    """Exact while nothing changes: the variance in one step, the flow in steps during which the variance hardly moves.

    The flow holds the variance of the end of a sample: its error falls with the sample, 1e-3 of it at 1 ms.
    """
    effort, expected = 2.2e5, 5.0 * LPM
    norm = SPLIT.flow_rate * SPLIT.flow_deviation**2
    exact = solve_ivp(published_rates(effort, expected), (0.0, 0.4), [0.0, 0.5 * norm], rtol=1e-10, atol=1e-30)
    once = split_step(split_start(), effort, expected, MEANS, 0.4, SPLIT)
    assert once.variance * norm == pytest.approx(exact.y[1, -1], rel=1e-7)
    memory = split_start()
    for _ in range(400):
        memory = split_step(memory, effort, expected, MEANS, 1e-3, SPLIT)
    assert memory.variance == pytest.approx(once.variance, rel=1e-10)
    assert memory.flow == pytest.approx(exact.y[0, -1], rel=1e-3)


def test_signs_of_both_directions_give_the_same_flow():
    """Retracting, H, G and U* all change sign."""
    back = Authority(-MEANS.per_flow, -MEANS.per_opening, MEANS.full_return)
    one = split_step(split_start(), 2e5, 1e-4, MEANS, 0.01, SPLIT)
    assert split_step(split_start(), -2e5, 1e-4, back, 0.01, SPLIT) == one


def test_split_settles_where_opening_and_flow_share_what_is_left():
    """u = (U* - H Q)/(G Psi) settles at ubar + (lambda_Q/L)(Q - Qbar)."""
    effort, expected, memory = 2.2e5, 5.0 * LPM, split_start()
    for _ in range(20_000):
        memory = split_step(memory, effort, expected, MEANS, 1e-3, SPLIT)
    opening = (effort - MEANS.per_flow * memory.flow) / MEANS.per_opening
    gain = SPLIT.flow_rate * sensitivity(MEANS, SPLIT) * memory.variance * MEANS.per_opening / MEANS.per_flow
    left = SPLIT.flow_rate / gain * (memory.flow - expected)
    assert abs(left) > 0.01
    assert opening == pytest.approx(SPLIT.mean_opening + left, rel=1e-9)


def test_flow_stays_within_the_pump():
    assert split_step(split_start(), 9e9, 0.0, MEANS, 10.0, SPLIT).flow == SPLIT.largest_flow
    assert split_step(split_start(), -9e9, 0.0, MEANS, 10.0, SPLIT).flow == 0.0


@pytest.mark.parametrize(
    "name", ["flow_rate", "flow_deviation", "opening_deviation", "largest_flow", "least_return_flow"]
)
def test_splits_that_divide_by_nothing_are_refused(name):
    values = {field: getattr(SPLIT, field) for field in SPLIT.__dataclass_fields__}
    with pytest.raises(ParameterError, match=name):
        FlowSplit(**{**values, name: 0.0})


def test_estimate_costs_least():
    """(6.29): the flow at the end of the cheapest w and u that explain the effort, by least squares in 500 steps of
    0.4 ms; the variance at the beginning is that of the filter."""
    steps, h, expected, effort = 500, 4e-4, 5.0 * LPM, 2.2e5
    rate, ratio = SPLIT.flow_rate, MEANS.per_flow / MEANS.per_opening
    nu = effort / MEANS.per_opening - SPLIT.mean_opening
    # Unknown: the flow at the beginning, over its deviation, then w of each step, over its own
    start = np.sqrt(split_start().variance * rate) * SPLIT.flow_deviation
    powers = (1.0 - rate * h) ** np.arange(steps + 1)
    spread = rate * h * SPLIT.flow_deviation / np.sqrt(h)
    flows = np.zeros((steps + 1, steps + 1))
    flows[:, 0] = start * powers
    for k in range(steps):
        flows[k + 1 :, k + 1] = spread * powers[: steps - k]
    known = expected * (1.0 - powers)
    weight = np.sqrt(h) / SPLIT.opening_deviation
    matrix = np.vstack([np.eye(steps + 1), weight * ratio * flows[1:]])
    target = np.concatenate([np.zeros(steps + 1), weight * (nu - ratio * known[1:])])
    cheapest = np.linalg.lstsq(matrix, target, rcond=None)[0]
    memory = split_start()
    for _ in range(steps):
        memory = split_step(memory, effort, expected, MEANS, h, SPLIT)
    assert known[-1] + flows[-1] @ cheapest == pytest.approx(memory.flow, rel=2e-3)
