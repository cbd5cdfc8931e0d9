"""Stated deviations of recorded logs on records of an own generator: coverage and squared errors, class by class."""

from pathlib import Path

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
NAMES = {
    "uneven": "uneven sectors",
    "stop": "stop and start",
    "creep": "creep to a halt",
    "ripple": "ripple (2, 3 or 5)",
    "ripple, uneven": "ripple 3, uneven",
    "missed": "2 to 40 % missed",
    "double": "double edges",
    "drift": "clock that drifts by 0.2 %",
}
"""Of classes that the page of logs calls otherwise."""
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


def table_row(name, default, fitted):
    """A class in the table of docs/logs.md: coverage of speed and angle, and squares of the speed, both ways."""
    cells = (
        f"{mean(each, 'speed_covered'):.2f}/{mean(each, 'angle_covered'):.2f}; {mean(each, 'speed_nees'):.2g}"
        for each in (default, fitted)
    )
    return f"| {name} | {' | '.join(cells)} |"


@pytest.mark.slow
@pytest.mark.parametrize("place", range(len(CLASSES)), ids=[kind.__name__ for kind in CLASSES])
def test_the_table_of_the_page_is_what_four_records_of_each_class_come_to(estimated, place):
    page = (Path(__file__).parents[2] / "docs" / "logs.md").read_text("utf-8")
    name, default = scores(estimated, SHORT[place], [False] * 4)
    _, fitted = scores(estimated, SHORT[place], [True] * 4)
    assert table_row(NAMES.get(name, name), default, fitted) in page
