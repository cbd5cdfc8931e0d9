"""The clock of a log that is named as the edges is reported, even if some of its samples are damaged."""

import numpy as np
import pytest

CLOCK = np.arange(2000) * 1.3e-4


def nan(t):
    t[[300, 301, 900]] = np.nan


def far_ahead(t):
    t[700] = 1e6


def another_digit(t):
    t[1200] += 1.23456e-5


def cut_out(t):
    t[400:800] = np.nan


def written_coarsely_and_damaged(t):
    t[:] = np.round(t, 5)
    t[50] += 3.21e-7


@pytest.mark.sampled(5)
@pytest.mark.parametrize("damage", [nan, far_ahead, another_digit, cut_out, written_coarsely_and_damaged])
def test_a_damaged_clock_is_reported(estimated, damage):
    times = CLOCK.copy()
    damage(times)
    kept = estimated({"time": (times, "s"), "diode": (np.sin(300.0 * CLOCK), "V")}, sensor__edges="time")
    (finding,) = [each for each in kept.findings if each.title == "An even clock in place of edges"]
    assert "0.00013 s apart" in finding.text and "'diode'" in finding.remedy


def test_edges_that_only_scatter_are_no_clock(estimated):
    times = CLOCK + np.random.default_rng(1).normal(0.0, 3e-6, CLOCK.size)
    kept = estimated({"time": (times, "s")}, sensor__edges="time")
    assert "An even clock in place of edges" not in [each.title for each in kept.findings]
