"""Whether a run has settled: what its means would still change by if it went on."""

from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.conservation import NOTHING
from vvdp.base.kinds import Angle, Energy, Pressure, TankVolume
from vvdp.simulation.model import Case
from vvdp.simulation.outcome import SETTLED, is_paced, is_settled, kept_marks, remaining_change


class Books(NamedTuple):
    volume: TankVolume
    energy: Energy
    little: Energy


class State(NamedTuple):
    pressure: Pressure
    angle: Angle
    books: Books


CASE = Case(State(1e5, 0.0, Books(0.0, 0.0, 0.0)), NOTHING)
TIMES = np.array([1.0, 2.0, 3.0, 4.0])


def lag_means(tau: float, spans: float = 1.0) -> np.ndarray:
    """Means of 1 + e^(-t/tau) over three spans from t = 0, shape (3, 1)."""
    ends = spans * np.arange(4.0)
    return (1.0 - tau * np.diff(np.exp(-ends / tau)) / spans)[:, np.newaxis]


@pytest.mark.parametrize("tau", [0.1, 1.0, 3.0, 9.0])
def test_what_is_left_of_a_lag_is_extrapolated_exactly(tau):
    """Its final value is 1: what is missing from the mean over the window is that mean less 1."""
    means = lag_means(tau)
    assert remaining_change(means) == pytest.approx(np.abs(means.mean(axis=0) - 1.0), rel=1e-9)


def test_a_straight_drift_is_never_near_its_end():
    """By hand: spans of 1, 2, 3 and what remains at the ratio 0.9: 3 + 1 * 0.9/0.1 - 2 = 10."""
    assert remaining_change(np.array([[1.0], [2.0], [3.0]])) == pytest.approx([10.0])


def test_a_swing_to_and_fro_counts_as_it_is():
    assert remaining_change(np.array([[1.0], [2.0], [1.5]])) == pytest.approx([0.0])
    assert remaining_change(np.array([[1.0], [1.0], [4.0]])) == pytest.approx([29.0])


def run_states(**rates: tuple[float, float, float]) -> np.ndarray:
    """States at four times whose integrals grow at these rates, shape (4, 5)."""
    given = {"angle": (9.0,) * 3, "volume": (2.0,) * 3, "energy": (500.0,) * 3, "little": (1.0,) * 3} | rates
    integrals = np.array([np.cumsum((0.0, *given[name])) for name in ("angle", "volume", "energy", "little")])
    return np.vstack([[1e5, 2e5, 3e5, 4e5], integrals]).T


@pytest.mark.parametrize("name", ["angle", "volume", "energy"])
def test_any_mean_that_drifts_by_more_than_the_limit_is_seen(name):
    steady = run_states()
    assert is_settled(CASE, TIMES, steady)
    mean = {"angle": 9.0, "volume": 2.0, "energy": 500.0}[name]
    for share, settled in ((0.9, True), (1.1, False)):
        drift = share * SETTLED * mean / 10.0  # of a straight drift the tenfold is to come
        assert is_settled(CASE, TIMES, run_states(**{name: (mean, mean + drift, mean + 2.0 * drift)})) is settled


def test_a_small_power_is_judged_against_a_tenth_of_the_largest():
    """1 W beside 500 W may drift by 0.1 % of 50 W: by a straight drift of a tenth of that in a span."""
    assert is_settled(CASE, TIMES, run_states(little=(1.0, 1.004, 1.008)))
    assert not is_settled(CASE, TIMES, run_states(little=(1.0, 1.006, 1.012)))


def test_spans_that_grow_longer_are_not_settled():
    """By 0.1 % each: the rate falls in a straight line, and a tenth of that is the limit."""
    assert is_paced(np.array([0.0, 1.0, 2.00009, 3.00027]))
    assert not is_paced(np.array([0.0, 1.0, 2.00011, 3.00033]))


@pytest.mark.parametrize(
    ("marks", "kept"), [(1, [0] * 5), (2, [0, 1, 1, 1, 1]), (4, [0, 0, 1, 2, 3]), (31, [0, 0, 10, 20, 30]),
                        (33, [0, 2, 12, 22, 32])]
)  # fmt: skip
def test_the_kept_marks_end_three_spans_of_as_many_periods(marks, kept):
    assert kept_marks(marks).tolist() == kept
