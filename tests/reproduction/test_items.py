"""Every item is named once, every figure, table and equation has one, and each is what is expected."""

import pytest

from vvdp.base.errors import ConfigError
from vvdp.reproduction.expectation import expected_verdicts
from vvdp.reproduction.item import ItemKind
from vvdp.reproduction.items import ITEMS, chosen_items
from vvdp.results.verdict import Verdict

FIGURES = {1: 9, 2: 20, 3: 14, 4: 16, 5: 9, 6: 8, 7: 2}
TABLES = {2: 1, 5: 1}
EQUATIONS = {2: 10, 3: 10}
QUICK = ("section-1.2.4", "equation-2.10", "section-2.8", "figure-3.3", "figure-3.5", "equation-3.4", "equation-3.8")
QUICK += ("section-3.5", "equation-4.6", "equation-5.14", "equation-6.4", "figure-7.1", "equation-2.1", "equation-2.2")
QUICK += ("equation-2.8", "equation-3.1", "equation-3.3", "equation-3.10", "equation-4.12", "equation-4.19")
QUICK += ("equation-4.20", "equation-5.36", "equation-6.3")
"""Some that take a moment; all others are slow tests."""
NAMES = [item.name for item in ITEMS]


CHAPTERS = sorted({item.chapter for item in ITEMS})


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_every_figure_table_and_equation_has_an_item(chapter):
    for kind, counts in ((ItemKind.FIGURE, FIGURES), (ItemKind.TABLE, TABLES), (ItemKind.EQUATION, EQUATIONS)):
        found = {item.name for item in ITEMS if item.chapter == chapter and item.kind is kind}
        assert found >= {f"{kind}-{chapter}.{place}" for place in range(1, counts.get(chapter, 0) + 1)}


def test_no_item_is_named_twice():
    assert len({*NAMES}) == len(NAMES)


def test_the_expectation_knows_every_item_and_no_other():
    expected = expected_verdicts()
    assert {item for item, _ in expected} == {*NAMES}
    assert {*expected.values()} <= {*Verdict}


def test_a_bare_number_is_the_figure_and_all_are_all():
    assert [item.name for item in chosen_items(["3.9", "equation-3.10"])] == ["figure-3.9", "equation-3.10"]
    assert {item.chapter for item in chosen_items(["chapter-3"])} == {3}
    assert chosen_items(["all"]) == ITEMS
    with pytest.raises(ConfigError, match="did you mean 'figure"):
        chosen_items(["figur-3.9"])


def test_items_stand_in_the_order_of_the_chapters_and_by_number():
    assert NAMES.index("figure-3.9") < NAMES.index("figure-3.10") < NAMES.index("equation-3.1")


@pytest.mark.parametrize("name", QUICK)
def test_quick_items(as_expected, name):
    assert as_expected(name) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name not in QUICK])
def test_other_items(as_expected, name):
    assert as_expected(name) == []
