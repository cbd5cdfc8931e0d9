"""Stated deviations of recorded logs on records of an own generator: coverage and squared errors, class by class."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import poisson
from tests.offline.motions import CLASSES, changing, record_of, ripple_uneven, score

pytestmark = pytest.mark.heavy

RECORDS = 600
TURNS = (0, 9, 18, 27)
"""Of the classes: 60 records, four of each class. The short tests take the first two, but for the class whose first two
are much better known than stated by chance."""
TABLED = 150
"""The first so many make the table of the page, ten of each class."""
COVERED = 0.9
"""Least share of rows within two deviations."""
SQUARES = (0.3, 3.0)
"""Bounds of the mean square of errors over the stated variance."""
MISSED = 0.4
"""Largest share of missed edges in a record."""
SELDOM = 1e-3
"""Chance by which a sound record may have more of what is bounded."""
CAUTIOUS = {"uneven": "a ripple may be hidden in the offsets, and none is"}
"""Classes that may state more than they are off, with the reason."""
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


def looks_half(edges):
    """Of a record in which 40 % of the edges are missed, the largest share that looks like a wheel of half the sectors:
    eight sectors in a row of which every other one shows, 0.24^4 of all; the filter needs three sectors to tell."""
    sectors = edges / (1.0 - MISSED)
    return 3.0 * poisson.isf(SELDOM, sectors * (MISSED * (1.0 - MISSED)) ** 4) / sectors


def scores(estimated, numbers, fits):
    """Of a class: its name, the scores of its records, with fitted settings or without, and the shares of each that may
    be far off."""
    names, found, far = set(), [], []
    for number, fit in zip(numbers, fits, strict=True):
        record = record_of(number)
        rate = min(1000.0, 4000.0 / record.times[-1])
        keys = {"sensor__sectors": record.sectors, "output__rate": f"{rate:.6g} Hz", "filter__fit": fit or None}
        kept = estimated({"edge": (record.edges, "s")}, sensor__edges="edge", **keys)
        columns = ("time", "piece", "angle", "speed", "angle_deviation", "speed_deviation")
        found.append(score(record, {name: kept.column(name) for name in columns}))
        names.add(record.name)
        far.append(looks_half(record.edges.size) if record.name == "missed" else changing(record))
    (name,) = names
    return name, found, far


def mean(found, name):
    return float(np.mean([getattr(each, name) for each in found]))


def check(name, found, far):
    least = 0.0 if name in CAUTIOUS else SQUARES[0]
    for quantity in ("speed", "angle"):
        assert mean(found, f"{quantity}_covered") > COVERED, quantity
        assert least < mean(found, f"{quantity}_nees") < SQUARES[1], quantity
    assert all(each.confident <= most for each, most in zip(found, far, strict=True))


@pytest.mark.parametrize("turns", [TURNS[:2], pytest.param(TURNS, marks=pytest.mark.thorough)], ids=["two", "four"])
@pytest.mark.parametrize("kind", range(len(CLASSES)), ids=[kind.__name__ for kind in CLASSES])
def test_stated_deviations_cover_the_errors_of_each_class(estimated, kind, turns):
    """Every other record with fitted settings."""
    turns = TURNS if CLASSES[kind] is ripple_uneven else turns
    numbers = [kind + len(CLASSES) * turn for turn in turns]
    check(*scores(estimated, numbers, (False, True, False, True)[: len(turns)]))


@pytest.mark.slow
@pytest.mark.parametrize("fit", [False, True])
@pytest.mark.parametrize("kind", range(len(CLASSES)), ids=[kind.__name__ for kind in CLASSES])
def test_stated_deviations_cover_the_errors_of_600_records(estimated, kind, fit):
    numbers = range(kind, RECORDS, len(CLASSES))
    check(*scores(estimated, numbers, [fit] * len(numbers)))


def table_row(name, default, fitted):
    """A class in the table of docs/logs.md: coverage of speed and angle, and squares of both, both ways."""
    cells = (
        f"{mean(each, 'speed_covered'):.2f}/{mean(each, 'angle_covered'):.2f}; "
        f"{mean(each, 'speed_nees'):.2g}/{mean(each, 'angle_nees'):.2g}"
        for each in (default, fitted)
    )
    return f"| {name} | {' | '.join(cells)} |"


@pytest.mark.slow
@pytest.mark.parametrize("place", range(len(CLASSES)), ids=[kind.__name__ for kind in CLASSES])
def test_the_table_of_the_page_is_what_ten_records_of_each_class_come_to(estimated, place):
    page = (Path(__file__).parents[2] / "docs" / "logs.md").read_text("utf-8")
    numbers = range(place, TABLED, len(CLASSES))
    name, default, _ = scores(estimated, numbers, [False] * len(numbers))
    _, fitted, _ = scores(estimated, numbers, [True] * len(numbers))
    assert table_row(NAMES.get(name, name), default, fitted) in page
