"""The numbers at the head of a run's page, at most twelve: result, power, largest losses, uncertainty."""

from collections.abc import Iterator

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import EFFICIENCY, MEAN_POWER, NUMBER
from vvdp.evaluation.bench_parts import is_bench
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.overview import loss_lines, power_lines
from vvdp.results.result import Listing, Row
from vvdp.runs.bench import components
from vvdp.runs.ranges import headline, kept_ranges
from vvdp.runs.run import RecordedRun

MOST_RESULTS, MOST_LOSSES = 4, 3
POWERS, LOSSES, DOUBT = "Power", "Largest losses", "Uncertainty"


def lead(run: RecordedRun) -> Listing:
    """The lines at the head of the page of a run: at most four results, four powers, three losses, one residual."""
    rows = (*_results(run), *_powers(run), *_losses(run), *_doubts(run))
    return Listing(title="", heads=("value",), rows=rows)


def _results(run: RecordedRun) -> Iterator[Row]:
    """The headline of the system, with its span over the ranges of values where the run has some; then its shares."""
    extras, numbers, ranges = additions(run.system), run.numbers, kept_ranges(run)
    lines = () if extras is None else extras.OVERVIEW
    # The last group of an overview is that of its powers.
    shares = [line.keys[0] for line in lines if line.kind is EFFICIENCY and line.group == lines[-1].group]
    keys = [key for key in dict.fromkeys((*headline(run), *shares)) if key in numbers]
    for key in keys[:MOST_RESULTS]:
        number = numbers[key]
        ends = () if ranges is None or key not in ranges.ends else ranges.ends[key].ravel()
        known = [float(end) for end in ends if end == end]
        note = " to ".join(with_unit(end, number.kind) for end in (min(known), max(known))) if known else ""
        yield Row(number.label, number.kind, (number.value,), "Result", note)


def _powers(run: RecordedRun) -> Iterator[Row]:
    powers = [power for _, power in power_lines(run.system, run.summary)]
    put_in, given = sum(p for p in powers if p > 0.0), -sum(p for p in powers if p < 0.0)
    yield Row("input power", MEAN_POWER, (put_in,), POWERS)
    for label, power in (("output power", given), ("stored power", run.number("stored_power_W"))):
        if put_in > 0.0 and abs(power) > 1e-3 * put_in:
            yield Row(label, MEAN_POWER, (power,), POWERS, percent(power / put_in))


def _losses(run: RecordedRun) -> Iterator[Row]:
    """The whole loss and its largest parts, each with its share; on a test rig without what the load dissipates."""
    lines = [(line.component.replace("_", " "), line.loss) for line in loss_lines(run.system, run.summary)]
    if is_bench(run.system):
        lines = [(loss.name, loss.simulated) for loss in components(run)]
    whole = sum(loss for _, loss in lines)
    yield Row("all losses", MEAN_POWER, (whole,), LOSSES)
    for name, loss in sorted(lines, key=lambda line: -line[1])[:MOST_LOSSES]:
        if loss > 0.0:
            yield Row(name, MEAN_POWER, (loss,), LOSSES, percent(loss / whole))


def _doubts(run: RecordedRun) -> Iterator[Row]:
    if "energy_residual" in run.summary:
        yield Row("energy residual, of the throughput", NUMBER, (run.number("energy_residual"),), DOUBT)
