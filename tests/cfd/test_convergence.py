"""When a run has settled, and when it diverges."""

from pathlib import Path

import numpy as np
import pytest

from vvdp.base.errors import RunError
from vvdp.cfd.convergence import History, judge, require_sane, until_settled


def history(values, flows=None):
    values = np.asarray(values, float)
    return History(np.arange(1.0, len(values) + 1), values, flows or {})


def test_means_of_a_straight_line():
    """Of 1 to 100, the last ten have the mean 95.5, the ten before 85.5."""
    found = judge(history(np.arange(1.0, 101.0)), 0, 10)
    assert found.value == 95.5
    assert found.change == pytest.approx(1.0 - 85.5 / 95.5)
    assert (found.spread, found.iteration, found.imbalance) == (9.0, 100, 0.0)


def test_a_swing_about_a_constant_has_settled():
    values = 5e5 + 2e4 * np.sin(2.0 * np.pi * np.arange(200) / 25.0)
    found = judge(history(values), 0, 50)
    assert found.has_settled(2e-3)
    assert found.spread == pytest.approx(4e4, rel=0.02)


def test_earlier_schemes_do_not_count():
    values = np.concatenate([np.full(80, 9.0), np.full(15, 5.0)])
    assert judge(history(values), 80, 10).change == np.inf
    assert judge(history(values), 80, 10).value == 5.0
    assert judge(history(values), 95, 10) is None


def test_what_is_found_does_not_depend_on_when_one_looks():
    """A decay towards 5: the run counts up to where it first settles, however far the solver has gone on."""
    values = 5.0 + np.exp(-np.arange(400) / 30.0)
    cut = [until_settled(history(values[:rows]), 0, 20, 2e-3) for rows in (200, 300, 400)]
    assert {len(each.iterations) for each in cut} == {len(cut[0].iterations)}
    assert judge(cut[0], 0, 20).has_settled(2e-3)
    before = History(cut[0].iterations[:-1], cut[0].value[:-1], {})
    assert not judge(before, 0, 20).has_settled(2e-3)
    assert len(until_settled(history(values[:50]), 0, 20, 2e-3).iterations) == 50


def test_flows_that_do_not_balance_have_not_settled():
    flows = {"inlet": np.full(40, -1.0), "one": np.full(40, 0.6), "two": np.full(40, 0.402)}
    found = judge(history(np.full(40, 5.0), flows), 0, 10)
    assert found.imbalance == pytest.approx(2e-3)
    assert found.change == 0.0
    assert not found.has_settled(2e-3)


@pytest.mark.parametrize("last", [np.nan, np.inf, 1e112])
def test_a_run_that_diverges_is_named_with_its_iteration(last):
    log = Path("case", "log.simpleFoam")
    with pytest.raises(RunError, match=r"diverged: at iteration 3.*see case/log\.simpleFoam"):
        require_sane(history([1e5, 2e5, last, 1e5]), 1e9, log)
    require_sane(history([1e5, 2e5]), 1e9, log)
