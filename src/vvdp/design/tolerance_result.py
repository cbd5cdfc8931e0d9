"""How a valve scatters with its tolerances, as a result: percentiles, shares of the variance, draws, charts."""

import textwrap
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import COUNT, EFFICIENCY, Kind
from vvdp.design.conditions import LEFT_OUT, conditions, sentence
from vvdp.design.quantities import key
from vvdp.design.tolerance import WORDS, Scatter, Tolerance
from vvdp.evaluation.range_display import result_with_ranges
from vvdp.results.chart import Bars, Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Number, Result, Row, Section, Table

BINS, WIDEST_TITLE = 48, 16
CLOSED_FORMS = (
    "All values are analytic: the fully open valve for drop and PWM frequency, the sum of the losses at the operating "
    "point of the system for the efficiency."
)
SIMULATED = (
    "Drop and PWM frequency of the fully open valve are closed forms. Efficiency, switching frequency and highest "
    "pressure are simulated at {runs} evenly spread draws; the draws behind distributions and shares are those of a "
    "smooth curve through these runs (a Gaussian process), which misses {missed} of the variance, as each run compared "
    "with the curve through all others shows. Bars of one value alone are runs."
)
MANNER = (
    "Inputs are taken as even within their spreads, or in their logarithm where the ends lie more than ten times "
    "apart, and as independent. Distributions come from evenly spread draws, shares of the variance from Saltelli's "
    "scheme for Sobol's indices. A sum of the shares below 1 is interaction; a share may come out slightly below zero "
    "by chance."
)
SHARES = {"first": "alone", "total": "with all others"}


def tolerance_result(found: Tolerance) -> Result:
    """The study as a result."""
    charts = (_distribution_chart(found), _share_chart(found))
    manner = f"{_method(found)} {MANNER}"
    known = {key(name, WORDS[name][0]): WORDS[name] for name in drawn_outputs(found)}
    result = Result(
        verb="design tolerance",
        title="Scatter of the valve with its tolerances",
        system=found.system.name,
        manner=manner,
        references=tuple(sorted({each.source for each in found.spreads if each.source})),
        conditions=conditions(found.system),
        left_out=LEFT_OUT[:0] if found.runs else LEFT_OUT,
        numbers=dict(_numbers(found)),
        tables={"shares": _share_table(found), "distribution": _distribution(found)},
        listings={"outputs": _outputs(found), "variance": _variance(found), "spreads": _spreads(found)},
        charts={each.name: each for each in charts},
        findings=tuple(_findings(found)),
        sections=(
            Section(title="Figures", shows=tuple(each.name for each in charts)),
            Section(title="Scatter", shows=("outputs",)),
            Section(title="Inputs", words=(_assumptions(found),), shows=("spreads",)),
            Section(title="Shares of the variance", shows=("shares",)),
            Section(title="How it was done", words=(manner,), shows=("conditions",)),
        ),
    )
    shown = replace(found.ranges, nominal={each: found.ranges.nominal[each] for each in known})
    return result_with_ranges(result, shown, known, "Shares of the variance")


def _method(found: Tolerance) -> str:
    if not found.runs:
        return CLOSED_FORMS
    missed = ", ".join(f"{percent(share)} ({WORDS[name][1]})" for name, share in found.unexplained.items())
    return SIMULATED.format(runs=found.runs, missed=missed)


def _assumptions(found: Tolerance) -> str:
    assumed = sum(each.status == "assumed" for each in found.spreads)
    words = f"{assumed} of {len(found.spreads)} spreads are assumptions; the shares depend on them."
    if found.left_out:
        names = ", ".join(each.label for each in found.left_out)
        words += f" Left out, since no closed form knows them or holds over them: {names}."
    return words


def _numbers(found: Tolerance) -> Iterator[tuple[str, Number]]:
    yield "evaluations", Number(found.evaluations, COUNT, "designs evaluated")
    yield "runs", Number(found.runs, COUNT, "runs simulated")
    for name, share in found.unexplained.items():
        yield f"{name}_unexplained", Number(share, EFFICIENCY, f"{WORDS[name][1]}, variance that the curve misses")
    for name, each in found.scatter.items():
        kind, label = WORDS[name]
        yield key(name, kind), Number(each.nominal, kind, f"{label}, nominal")
        yield key(f"{name}_mean", kind), Number(each.mean, kind, f"{label}, mean")
        yield key(f"{name}_deviation", kind), Number(each.deviation, kind, f"{label}, standard deviation")
        for percentile, value in each.percentiles.items():
            named = key(f"{name}_percentile_{percentile.replace('.', '_')}", kind)
            yield named, Number(value, kind, f"{label}, {percentile} % of the draws are below")


def _share_table(found: Tolerance) -> Table:
    columns = {
        "input": Column(np.array([each.name for each in found.spreads]), None, "key"),
        "label": Column(np.array([each.label for each in found.spreads]), None, "input"),
    }
    for name, each in found.scatter.items():
        for index, words in SHARES.items():
            values, errors = (each.alone, each.alone_error) if index == "first" else (each.whole, each.whole_error)
            for suffix, column, what in (("", values, words), ("_error", errors, "±")):
                share = np.array([column[spread.name] for spread in found.spreads])
                columns[f"{name}_{index}_index{suffix}"] = Column(share, EFFICIENCY, f"{WORDS[name][1]}, {what}")
    return Table(
        title="Shares of the variance",
        columns=columns,
        shown=tuple(each for each in columns if each.endswith(("label", "_total_index"))),
        note="The shares of each input alone and the half widths of the 95 % confidence are there as well.",
    )


def _distribution(found: Tolerance) -> Table:
    columns = {}
    for name, values in found.outputs.items():
        counts, edges = np.histogram(values, bins=BINS)
        columns[key(name, WORDS[name][0])] = Column(edges, WORDS[name][0], WORDS[name][1])
        columns[f"{name}_count"] = Column(np.append(counts, 0).astype(float), COUNT, "draws per bin")
    return Table(title="Distributions", columns=columns, is_data=True)


def draws(found: Tolerance) -> Table:
    """All draws of inputs and outputs, a row each."""
    inputs: dict[str, tuple[Kind, str]] = {each.name: (each.kind, each.label) for each in found.spreads}
    known = inputs | {name: WORDS[name] for name in found.outputs}
    columns = {
        key(name, known[name][0]): Column(values, *known[name])
        for name, values in {**found.inputs, **found.outputs}.items()
    }
    return Table(title="Draws", columns=columns, is_data=True)


def _findings(found: Tolerance) -> Iterator[Finding]:
    labels = {each.name: each.label for each in found.spreads}
    for name, each in found.scatter.items():
        main = max(each.whole, key=each.whole.__getitem__)
        low, high = _middle(name, each)
        yield Finding(
            text=f"The {WORDS[name][1]} lies between {low} and {high} in 95 % of the cases, mostly through the "
            f"{labels[main]} ({percent(each.whole[main], 0)} of the variance)."
        )
    yield from (Finding(text=sentence(text), grade=Grade.WARNING, title="In doubt") for text in found.warnings)


def _middle(name: str, each: Scatter) -> tuple[str, str]:
    """The ends of the middle 95 % in words."""
    low, high = (with_unit(each.percentiles[p], WORDS[name][0]) for p in ("2.5", "97.5"))
    return low, high


def _outputs(found: Tolerance) -> Listing:
    rows = []
    for name, each in found.scatter.items():
        kind, label = WORDS[name]
        rows.append(Row(label, kind, (each.nominal, each.mean, each.deviation, *map(each.percentiles.get, PERCENTS))))
    heads = ("nominal", "mean", "deviation", "2.5 %", "median", "97.5 %")
    return Listing(title="Outputs", heads=heads, rows=tuple(rows))


PERCENTS = ("2.5", "50", "97.5")


def _variance(found: Tolerance) -> Listing:
    rows = (
        Row(each.label, EFFICIENCY, tuple(scatter.whole[each.name] for scatter in found.scatter.values()))
        for each in found.spreads
    )
    heads = tuple(WORDS[name][1] for name in found.scatter)
    return Listing(title="Share of the variance, with all others", heads=heads, rows=tuple(rows))


def _spreads(found: Tolerance) -> Listing:
    rows = []
    for each in found.spreads:
        ends = (with_unit(end, each.kind) for end in (each.low, each.high))
        rows.append(Row(each.label, None, (*ends, each.status, each.source), note=each.note))
    return Listing(title="Spreads taken", heads=("from", "to", "status", "source"), rows=tuple(rows))


def drawn_outputs(found: Tolerance) -> list[str]:
    """The outputs that have room in a figure: the frequency of the switching valve in place of that of the open one."""
    return [name for name in found.scatter if not (found.runs and name == "pwm_frequency")]


def _distribution_chart(found: Tolerance) -> Chart:
    panels: list[Lines] = []
    for name in drawn_outputs(found):
        each = found.scatter[name]
        ends = (Level(value=each.percentiles[p], upright=True, colour=Colour.RELIEF) for p in ("2.5", "97.5"))
        nominal = Level(value=each.nominal, upright=True, stroke=Stroke.SOLID)
        column = key(name, WORDS[name][0])
        line = Line(x=column, y=f"{name}_count", label="draws", colour=Colour.LOAD, stroke=Stroke.STEPS)
        panels.append(
            Lines(
                lines=(line,),
                label="draws" if not panels else " ",
                x_label=textwrap.fill(WORDS[name][1], WIDEST_TITLE),
                title="95 %: {} to {}".format(*_middle(name, each)),
                levels=(*ends, nominal),
                low=0.0,
            )
        )
    return Chart(
        name="distributions",
        caption="How the outputs scatter. Solid: nominal; dashed: the ends of the middle 95 %.",
        table="distribution",
        panels=tuple(panels),
        side_by_side=True,
        height=2.6,
    )


def _share_chart(found: Tolerance) -> Chart:
    panels = tuple(
        Bars(
            names="label",
            values=tuple(f"{name}_{index}_index" for index in SHARES),
            labels=tuple(SHARES.values()),
            colours=(Colour.LOAD, Colour.TANK),
            title=textwrap.fill(WORDS[name][1], WIDEST_TITLE),
            label="share of\nthe variance",
        )
        for name in drawn_outputs(found)
    )
    return Chart(
        name="indices",
        caption="Share of the variance of each output that an input explains by itself, and together with all others. "
        "Where the two are alike, inputs act independently.",
        table="shares",
        panels=panels,
        side_by_side=True,
        share=True,
        height=1.2 + 0.36 * len(found.spreads),
    )
