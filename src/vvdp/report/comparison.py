"""The report of a comparison of estimators: one page, from the files that it left."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from vvdp.base.display import fixed, number
from vvdp.comparison.results import Comparison, read_comparison
from vvdp.comparison.scores import Measured
from vvdp.report.comparison_figures import comparison_figures
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, group, row, table, text
from vvdp.report.page import opening, write_page

HEAD = (
    "", "speed rms<br>rad/s", "95 %", "worst", "mean", "angle rms<br>rad", "95 %", "worst", "settles<br>ms",
    "delay<br>ms", "lost", "NIS",
)  # fmt: skip
TINY = 1e-6
"""Errors below this are the rounding of the arithmetic [rad, rad/s]."""
TIE = 1.05
"""Errors that differ by a factor of less count as the same."""


def write_comparison_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of a comparison and gives the path of the page.

    Raises ConfigError where the directory holds no comparison.
    """
    found = read_comparison(directory)
    meta = json.loads((directory / "meta.json").read_text("utf-8"))
    drawn = tuple(comparison_figures(found))
    return write_page(directory, _page(found, meta, drawn), drawn)


def _page(found: Comparison, meta: Mapping[str, str], drawn: tuple[Drawn, ...]) -> Iterator[str]:
    title = "Estimators of angle and speed on a coarse encoder"
    yield f"{opening(title)}\n<h1>{title}</h1>"
    facts = [
        f"{found.sectors} sectors sampled at {number(found.rate)} Hz",
        f"{sum(played.runs for played in found.scenarios.values())} runs of {len(found.estimators)} estimators",
        text(meta["written"][:10]),
        f"vvdp {text(meta['vvdp'])}",
    ]
    yield f'<p class="facts">{" &middot; ".join(facts)}</p>'
    if not found.finished:
        words = f"<p>It was interrupted; {found.seeds} runs of each scenario were asked for.</p>"
        yield f'<div class="notice"><strong>Not all runs were made</strong>{words}</div>'
    yield f'<p class="lead">{text(LEAD)}</p>'
    yield "<h2>Error of the speed</h2>"
    yield (
        '<p class="small">Root mean square over all runs, in rad/s. Bold: the least, and what comes within 5 % of it, '
        "of the estimators that work as the samples come.</p>"
    )
    yield _speed_table(found)
    for count, each in enumerate(drawn, 1):
        yield figure(each.svg, each.name, count, text(each.caption))
    yield '<h2 class="page">Scenario by scenario</h2>'
    yield f'<p class="small">{DEFINITIONS}</p>'
    yield table(HEAD, list(_rows(found)), range(1, len(HEAD)))
    yield "<h2>Cost</h2>"
    yield table(("estimator", "what it is", "ns per sample", "relative"), list(_cost_rows(found)), (2, 3))
    yield "</body>\n</html>"


LEAD = (
    "A wheel of bright and dark sectors turns past a photodiode. Every scenario is run many times, each time with "
    "another phase of the clock, another position of the wheel and other noise; in each run all estimators get the "
    "same edges."
)
DEFINITIONS = (
    "Errors are estimate less truth, from 0.5 s on. 95 %: exceeded in 5 % of a run, mean over the runs; worst: of all "
    "runs; mean: the bias. The angle counts modulo a turn, relative to the unknown index. Settling: from the step on "
    "until the speed stays within 5 % of the step of its final value, median over the runs; a dash where it does not. "
    "Delay: the shift of the true speed that comes closest to the estimate. Lost: sectors gained or lost in a run, on "
    "average. NIS: mean normalised innovation squared, 1 where the stated uncertainty is right. After &plusmn;: a "
    "standard error. All of it, with all standard errors, is in comparison.csv."
)


def _speed_table(found: Comparison) -> str:
    """Estimators against scenarios."""
    scenarios = [name for name, played in found.scenarios.items() if played.runs]
    lines = []
    best = {scenario: _least(found, scenario) for scenario in scenarios}
    for name, entered in found.estimators.items():
        errors = [found.scores[scenario, name]["speed_error_rms_rad_s"].value for scenario in scenarios]
        cells = [
            f"<b>{size(error, 2)}</b>"
            if entered.causal and error <= TIE * max(best[scenario], TINY)
            else size(error, 2)
            for scenario, error in zip(scenarios, errors, strict=True)
        ]
        lines.append(row([text(name), *cells], ("u", *("n",) * len(cells))))
    head = (text(name).replace("-", "-<br>") for name in scenarios)
    return table(("", *head), lines, range(1, len(scenarios) + 1))


def _least(found: Comparison, scenario: str) -> float:
    rivals = [name for name, entered in found.estimators.items() if entered.causal]
    return min((found.scores[scenario, name]["speed_error_rms_rad_s"].value for name in rivals), default=0.0)


def _rows(found: Comparison) -> Iterator[str]:
    for scenario, played in found.scenarios.items():
        if not played.runs:
            continue
        yield group(f"{text(scenario)}: {text(played.title)}, {played.runs} runs", len(HEAD))
        for estimator in found.estimators:
            cells = list(_cells(found.scores[scenario, estimator]))
            yield row([text(estimator), *cells], ("u", *("n",) * len(cells)))


def _cells(figures: Mapping[str, Measured]) -> Iterator[str]:
    def shown(key: str, scale: float = 1.0, digits: int = 3) -> str:
        return size(scale * figures[key].value, digits)

    for name, unit in (("speed", "rad_s"), ("angle", "rad")):
        root = figures[f"{name}_error_rms_{unit}"]
        yield size(root.value) + (f" &plusmn;{size(root.error, 1)}" if root.value >= TINY else "")
        yield shown(f"{name}_error_95_{unit}")
        yield shown(f"{name}_error_worst_{unit}")
        if name == "speed":
            yield shown("speed_error_mean_rad_s", 1.0, 2)
    yield shown("settling_median_s", 1e3)
    yield shown("delay_s", 1e3)
    yield shown("lost_sectors", 1.0, 2)
    yield shown("nis")


def size(value: float, digits: int = 3) -> str:
    """A figure as people write it, 0.049, 12.0, 122; a dash where there is none, < 10⁻⁶ for what rounding leaves."""
    return "< 10⁻⁶" if 0.0 < abs(value) < TINY else number(value, digits)


def _cost_rows(found: Comparison) -> Iterator[str]:
    first = next(iter(found.costs.values())).value
    for name, entered in found.estimators.items():
        cost = found.costs[name].value
        cells = [text(name), text(entered.title), fixed(1e9 * cost, 0), number(cost / first, 3)]
        yield row(cells, ("u", "q", "n", "n"))
