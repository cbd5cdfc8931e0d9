"""Stated deviations of recorded logs on records of an own generator: coverage and squared errors, class by class."""

import numpy as np
import pytest
from tests.offline.motions import CLASSES, record_of, score

pytestmark = pytest.mark.heavy

RECORDS = 600
SHORT = [[kind + len(CLASSES) * turn for turn in (0, 9, 18, 27)] for kind in range(len(CLASSES))]
"""60 of them, four of each class."""
COVERED = 0.9
"""Least share of rows within two deviations."""
CONFIDENT = {"stop": 0.02, "missed": 0.1}
"""Largest share of rows beyond four deviations and 30 % of the speed, 0.01 of other classes: between two edges nothing
tells of the first milliseconds of a stop, and where many edges are missed a multiple of the sector passes for it."""
SQUARES = {"stop": 100.0}
"""Largest mean square of errors of the speed over the stated variance, 3 of other classes, for the same reason."""
COUNT_IN_DOUBT = {"missed"}
"""With many edges missed some turns are lost: the angle is not compared."""


def scores(estimated, numbers, fits):
    """Of a class: its name, and the scores of its records, with fitted settings or without."""
    names, found = set(), []
    for number, fit in zip(numbers, fits, strict=True):
        record = record_of(number)
        rate = min(1000.0, 4000.0 / record.times[-1])
        keys = {"sensor__sectors": record.sectors, "output__rate": f"{rate:.6g} Hz", "filter__fit": fit or None}
        kept = estimated({"edge": (record.edges, "s")}, sensor__edges="edge", **keys)
        columns = ("time", "piece", "angle", "speed", "angle_deviation", "speed_deviation")
        found.append(score(record, {name: kept.column(name) for name in columns}))
        names.add(record.name)
    (name,) = names
    return name, found


def mean(found, name):
    return float(np.mean([getattr(each, name) for each in found]))


def check(name, found):
    assert mean(found, "speed_covered") > COVERED
    assert mean(found, "speed_nees") < SQUARES.get(name, 3.0)
    assert max(each.confident for each in found) < CONFIDENT.get(name, 0.01)
    if name not in COUNT_IN_DOUBT:
        assert mean(found, "angle_covered") > COVERED
        assert mean(found, "angle_nees") < 3.0


@pytest.mark.parametrize("numbers", SHORT, ids=[kind.__name__ for kind in CLASSES])
def test_stated_deviations_cover_the_errors_of_each_class(estimated, numbers):
    """Two records as they are, two with fitted settings."""
    check(*scores(estimated, numbers, (False, True, False, True)))


@pytest.mark.slow
@pytest.mark.parametrize("fit", [False, True])
@pytest.mark.parametrize("kind", range(len(CLASSES)), ids=[kind.__name__ for kind in CLASSES])
def test_stated_deviations_cover_the_errors_of_600_records(estimated, kind, fit):
    numbers = range(kind, RECORDS, len(CLASSES))
    check(*scores(estimated, numbers, [fit] * len(numbers)))
