"""The result of a run: what its page, its screen and a comparison show."""

from collections.abc import Collection, Iterator

from vvdp.evaluation.bench import RotaryBench
from vvdp.evaluation.bench_parts import is_bench
from vvdp.evaluation.bench_report import BenchReport, additions
from vvdp.evaluation.overview import loss_lines, power_lines
from vvdp.evaluation.quantities import quantities
from vvdp.evaluation.range_display import result_with_ranges
from vvdp.results.chart import Chart
from vvdp.results.result import Finding, Grade, Listing, Result, Section, Table, sentences
from vvdp.runs.bench import (
    analytic_words,
    bench_loss_listings,
    bench_series,
    causes,
    components,
    cycle_table,
    harmonic_listing,
    limit_findings,
    loss_table_columns,
    spectrum_table,
)
from vvdp.runs.bench_charts import CYCLE, CYCLE_CHART, SPECTRUM, SPECTRUM_CHART, bench_charts
from vvdp.runs.charts import SERIES, loss_chart, run_charts, with_faults
from vvdp.runs.findings import badges, bench_in_words, bench_warnings, in_words, warnings
from vvdp.runs.lead import lead
from vvdp.runs.ranges import kept_ranges
from vvdp.runs.run import RecordedRun
from vvdp.runs.tables import (
    bar_table,
    circuit_loss_listings,
    component_listing,
    computation,
    loss_listing,
    node_listing,
    overview,
    series_table,
    valve_listings,
)
from vvdp.systems.assumed import assumed_words

LEAD = "lead"
"""The listing at the head of the page."""


def run_result(run: RecordedRun) -> Result:
    """Everything that is to be said and drawn of a run."""
    report = _report(run)
    shown, tables = course(run)
    drawn = list(_losses(run) if report is None else _bench_losses(run))
    tables |= {chart.table: table for chart, table in drawn}
    losses = [chart for chart, _ in drawn]
    of_losses = loss_listings(run)
    harmonics = {"harmonics": harmonic_listing(tables[SPECTRUM])} if SPECTRUM in tables else {}
    result = Result(
        verb="run",
        title=run.system.title,
        system=run.system.name,
        numbers=run.numbers,
        listings={LEAD: lead(run)} | number_listings(run) | of_losses | harmonics,
        tables=tables,
        charts={chart.name: chart for chart in (*shown, *losses)},
        badges=tuple(badges(run)),
        findings=_findings(run, report),
        sections=_sections(run, report, shown, losses, tuple(of_losses), tuple(harmonics)),
        references=tuple(sorted({row.source for row in run.system.rows if row.source})),
        seconds=float(run.meta.get("seconds", 0.0)),
        finished=run.has("finished"),
    )
    ranges = kept_ranges(run)
    return result if ranges is None else result_with_ranges(result, ranges, quantities(run.system), "Computation")


def course(run: RecordedRun, shown: Collection[str] | None = None) -> tuple[list[Chart], dict[str, Table]]:
    """The charts of the course of a run, without losses and findings, and the tables that they show.

    Of charts whose names are not among `shown`, nothing is calculated.
    """
    extras, bench = additions(run.system), _bench(run)
    tables = {SERIES: recorded_series(run)}
    if bench is not None:
        tables |= _bench_tables(run, bench, tables[SERIES], shown)
    charts = list(run_charts(run, tables[SERIES])) if bench is None else []
    if bench is not None and run.times.size > 1:
        charts = list(bench_charts(run, bench, tables[SERIES], tables))
    for place, (chart, table) in enumerate(() if extras is None else extras.charts(run.record)):
        tables[chart.table or f"own-{place}"] = table
        charts.append(chart)
    charts = [chart for chart in charts if shown is None or chart.name in shown]
    return [with_faults(chart, run.system.faults) for chart in charts], tables


def recorded_series(run: RecordedRun) -> Table:
    """What is looked at over time, in the order of the record's rows."""
    bench = _bench(run)
    return series_table(run) if bench is None else bench_series(run, bench)


def _report(run: RecordedRun) -> BenchReport | None:
    own = additions(run.system)
    return own if isinstance(own, BenchReport) else None


def _bench(run: RecordedRun) -> RotaryBench | None:
    return RotaryBench(run.system) if is_bench(run.system) else None


def number_listings(run: RecordedRun) -> dict[str, Listing]:
    """The numbers of a summary but for losses: the system's own, nodes, components, and how it was computed."""
    found = {"nodes": node_listing(run), "components": component_listing(run), "computation": computation(run)}
    return key_listings(run) | found


def loss_listings(run: RecordedRun) -> dict[str, Listing]:
    """The losses of a summary by component, by part or by cause, and the numbers of rotary valves."""
    if is_bench(run.system):
        return bench_loss_listings(run)
    return {"losses": loss_listing(run)} | circuit_loss_listings(run) | valve_listings(run)


def key_listings(run: RecordedRun) -> dict[str, Listing]:
    """The overview that the system brings along; none where it brings none."""
    extras = additions(run.system)
    return {} if extras is None or not extras.OVERVIEW else {"overview": overview(run, extras)}


def _findings(run: RecordedRun, report: BenchReport | None) -> tuple[Finding, ...]:
    found, extras = list(warnings(run)), additions(run.system)
    good = () if extras is None else sentences(tuple(extras.merits(run.summary)), Grade.GOOD)
    if report is None:
        own = () if extras is None else extras.warnings(run.summary)
        return (*found, *sentences(tuple(own), Grade.WARNING), *good, Finding(text=in_words(run)))
    limits = limit_findings(run, report)
    return (*found, *bench_warnings(run, report), *limits, *good, Finding(text=bench_in_words(run)))


def _bench_tables(
    run: RecordedRun, bench: RotaryBench, series: Table, shown: Collection[str] | None
) -> dict[str, Table]:
    cycle = cycle_table(run, bench, series) if shown is None or CYCLE_CHART in shown else None
    spectrum = spectrum_table(run, series, bench) if shown is None or SPECTRUM_CHART in shown else None
    return {name: each for name, each in ((CYCLE, cycle), (SPECTRUM, spectrum)) if each is not None}


def _losses(run: RecordedRun) -> Iterator[tuple[Chart, Table]]:
    parts = [line for line in loss_lines(run.system, run.summary) if line.loss > 0.0]
    if not parts:
        return
    put_in = sum(power for _, power in power_lines(run.system, run.summary) if power > 0.0)
    labels = tuple(line.component.replace("_", " ") for line in parts)
    bars = bar_table("component", {"mean": tuple(p.loss for p in parts)}, labels, put_in)
    caption = "Mean power dissipated by each component over the averaging window; shares are of the input power."
    yield loss_chart(bars, caption), bars


def _bench_losses(run: RecordedRun) -> Iterator[tuple[Chart, Table]]:
    whole = run.number("input_power_W") + run.number("spool_motor_power_W")
    for name, losses, caption in (
        ("component", components(run), "Where the simulated power is lost, mean over the averaging window."),
        ("cause", causes(run), "Mean losses by cause, simulated and, where there are formulas, analytic."),
    ):
        labels = tuple(loss.name for loss in losses)
        bars = bar_table(name, loss_table_columns(losses), labels, whole)
        yield loss_chart(bars, caption), bars


def _sections(run: RecordedRun, report: BenchReport | None, course: list[Chart], losses: list[Chart],
              of_losses: tuple[str, ...], harmonics: tuple[str, ...]) -> tuple[Section, ...]:  # fmt: skip
    words = () if report is None else tuple(analytic_words(run, report))
    assumed = f"{assumed_words(run.system.assumptions)}; {len(run.system.rows)} values in all."
    shown = (*(chart.name for chart in course), *harmonics)
    inner = [f"circuit-{part}" for part in run.network.circuits]
    chart = losses[0].name if losses and additions(run.system) is not None else "circuit"
    return (
        Section(title="Result", shows=(LEAD, chart)),
        Section(title="Circuit", words=(f"Circuit: {run.system.circuit_name}.",), shows=("circuit", *inner)),
        Section(title="Key numbers", shows=(*key_listings(run), "nodes", "components")),
        Section(title="Course of the run", shows=shown),
        Section(title="Losses", shows=(*(chart.name for chart in losses), *of_losses), words=()),
        *((Section(title="On the analytic losses", words=words),) if words else ()),
        Section(
            title="Computation",
            words=(
                "Above the limit of a residual the balances do not close, and the numbers are in doubt.",
                *remarks(run),
            ),
            shows=("computation",),
        ),
        Section(title="Assumed values", words=(assumed,), shows=("assumed",) if run.system.assumptions else ()),
        Section(title="Parameters", shows=("parameters",)),
        Section(title="Equations", words=("The network as it is written out and simulated.",), shows=("equations",)),
    )


def remarks(run: RecordedRun) -> tuple[str, ...]:
    """Notes of the simulation itself."""
    failed = [run.meta["failed"]] if "failed" in run.meta else []
    return tuple(map(str, [*run.meta.get("remarks", ()), *failed]))
