"""The tables of docs/comparison.md are those that their command writes."""

import re

import pytest

from vvdp.comparison.estimators import contenders
from vvdp.comparison.scenarios import scenarios

ANY_NUMBER = re.compile(r"(?<=[|/ ])(?:< )?\d[\d.]*(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?(?= [|/])")
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def value(text: str) -> float:
    if text.startswith("<"):
        return 0.0
    mantissa, _, power = text.partition("·10")
    return float(mantissa) * 10.0 ** int(power.translate(RAISED) or "0")


def timeless(page: str) -> str:
    """A page without what a sample costs on a machine."""
    return re.sub(r"\| \d+ (?=\| [^|]*\|$)", "| ns ", page, flags=re.M)


def test_every_scenario_and_estimator_has_its_column_and_row():
    import comparison

    page = comparison.PAGE.read_text("utf-8")
    heads = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("|  | ")]
    names = [each.name for each in scenarios()]
    assert [name for head in heads for name in head] == 3 * names
    for each in contenders():
        assert page.count(f"\n| {each.name} | ") == len(heads) + 1, each.name


def test_numbers_are_written_short():
    import comparison

    written = [comparison.short(each) for each in (0.2, 18.4, 1380.0, 8.72e-5, 3e-9, 0.0, float("nan"), float("inf"))]
    assert written == ["0.20", "18", "1400", "8.7·10⁻⁵", "< 10⁻⁶", "0.0", "–", "–"]
    assert [value(each) for each in written[:5]] == pytest.approx([0.2, 18.0, 1400.0, 8.7e-5, 0.0])
    assert comparison.percent(0.954) == "95" and comparison.percent(float("nan")) == "–"


@pytest.mark.slow
def test_the_tables_are_what_their_command_writes(tmp_path):
    """To the letter but for the numbers, which may differ in their last digit on another machine."""
    import comparison

    comparison.main(tmp_path / "comparison.md")
    made, kept = (timeless(path.read_text("utf-8")) for path in (tmp_path / "comparison.md", comparison.PAGE))
    assert ANY_NUMBER.sub("~", made) == ANY_NUMBER.sub("~", kept)
    numbers = [[value(each) for each in ANY_NUMBER.findall(text)] for text in (made, kept)]
    assert len(numbers[0]) > 600
    assert numbers[0] == pytest.approx(numbers[1], rel=0.06, abs=1e-6)
