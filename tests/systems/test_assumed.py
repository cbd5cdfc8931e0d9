"""Assumed values in words, by the table in which they stand."""

import pytest

from vvdp.base.kinds import LENGTH
from vvdp.base.tables import Sourced
from vvdp.systems.assumed import assumed_words


def rows(counts):
    return [
        Sourced(table, f"key_{n}", 1.0, LENGTH, "assumed", note=note)
        for (table, note), count in counts.items()
        for n in range(count)
    ]


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ({}, "no assumed values"),
        (
            {("oil", "default"): 16, ("components.load", "default"): 1},
            "17 assumed values: 16 of the default oil, 1 of load",
        ),
        ({("oil", "a data sheet"): 1}, "1 assumed value: 1 of the oil"),
        (
            {("components.a", ""): 4, ("components.b", ""): 3, ("nodes.c", ""): 2, ("initial", ""): 1},
            "10 assumed values: 4 of a, 3 of b, 2 of c, 1 of initial",
        ),
        (
            {("pilot_oil", "default"): 5, ("a", ""): 4, ("b", ""): 3, ("c", ""): 2, ("d", ""): 1},
            "15 assumed values: 5 of the default pilot oil, 4 of a, 3 of b, 3 of 2 other tables",
        ),
    ],
)
def test_values_are_counted_by_their_table(counts, words):
    assert assumed_words(rows(counts)) == words
