"""Writes the tables of the page about the comparison of estimators. `python docs/site/comparison.py`"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from vvdp.comparison.estimators import contenders
from vvdp.comparison.figures import Measured
from vvdp.comparison.results import Comparison
from vvdp.comparison.scenarios import scenarios
from vvdp.comparison.score_tables import MOST_COLUMNS
from vvdp.comparison.trials import compare

PAGE = Path(__file__).parents[1] / "comparison.md"
BEGIN, END = "<!-- made by docs/site/comparison.py -->\n", "<!-- to here -->\n"
SEEDS = 200
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
STEP = (
    ("delay [ms]", "delay_s", 1e3), ("settling, median [ms]", "settling_median_s", 1e3),
    ("90 % [ms]", "settling_90_s", 1e3), ("speed, mean 95 % [rad/s]", "speed_error_95_rad_s", 1.0),
)  # fmt: skip


def short(value: float, digits: int = 2) -> str:
    """A value with so many digits, powers of ten below a thousandth, a dash for what is none."""
    if not abs(value) < float("inf"):
        return "–"
    if 0.0 < value < 1e-6:
        return "< 10⁻⁶"
    if 0.0 < value < 1e-3:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        return f"{mantissa}·10{str(int(power)).translate(RAISED)}"
    text = f"{value:#.{digits}g}"
    return f"{float(text):g}" if "e" in text else text.removesuffix(".")


def percent(value: float) -> str:
    """A share, a dash for what is none."""
    return f"{100.0 * value:.0f}" if value == value else "–"


def joined(values: Sequence[str]) -> str:
    """Values beside each other; a dash where there are none."""
    return " / ".join(values) if set(values) != {"–"} else "–"


def markdown(head: Sequence[str], rows: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """A table, a row for each name."""
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    yield from (f"| {name} | {' | '.join(cells)} |" for name, cells in rows.items())
    yield ""


def tables(found: Comparison) -> Iterator[str]:
    """Errors of speed and angle, what lies within two deviations, and the step."""

    def cells(keys: Sequence[str], names: Sequence[str], text: Callable[[float], str]) -> dict[str, list[str]]:
        return {
            each: [joined([text(found.scores[name, each][key].value) for key in keys]) for name in names]
            for each in found.contenders
        }

    for words, keys, text in (
        ("Speed, rms [rad/s]:", ("speed_error_rms_rad_s",), short),
        ("Angle, rms [rad]:", ("angle_error_rms_rad",), short),
        ("Errors of speed / angle within ±2σ as stated [%]:", ("speed_coverage", "angle_coverage"), percent),
    ):
        yield from (words, "")
        names = list(found.scenarios)
        for some in (names[first : first + MOST_COLUMNS] for first in range(0, len(names), MOST_COLUMNS)):
            yield from markdown(["", *some], cells(keys, some, text))
    yield from ("The step, cost and robustness; a dash where most runs do not settle:", "")
    yield from step_table(found)


def step_table(found: Comparison) -> Iterator[str]:
    """How quick each is, what it costs, and where it loses count."""
    rows = {}
    for name in found.contenders:
        score: Mapping[str, Measured] = found.scores["step", name]
        rows[name] = [
            *(short(scale * score[key].value, 3) for _, key, scale in STEP),
            short(found.scores["constant", name]["nis"].value),
            f"{1e9 * found.costs[name].value:.0f}",
            lost_in(found, name),
        ]
    yield from markdown(
        ["estimator", *(head for head, _, _ in STEP), "NIS, constant", "ns per sample", "sectors lost in"], rows
    )


def lost_in(found: Comparison, name: str) -> str:
    """In which scenarios an estimator loses sectors, or in which it does not, whatever is shorter."""
    lost = [each for each in found.scenarios if found.scores[each, name]["lost_sectors"].value > 0.0]
    kept = [each for each in found.scenarios if each not in lost]
    return f"all but {', '.join(kept)}" if len(kept) < len(lost) else ", ".join(lost) or "none"


def main(page: Path = PAGE) -> None:
    """Writes the tables between their marks."""
    head, rest = PAGE.read_text("utf-8").split(BEGIN)
    tail = rest.split(END)[1]
    made = "\n".join(tables(compare(scenarios(), contenders(), SEEDS)))
    page.write_text(f"{head}{BEGIN}\n{made}{END}{tail}", "utf-8")


if __name__ == "__main__":
    main()
