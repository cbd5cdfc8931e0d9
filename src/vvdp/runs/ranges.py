"""Ranges of the numbers of a run: the run repeated at both ends of each value that has a range."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from vvdp.base.errors import RunError
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.overview import node_lines
from vvdp.evaluation.ranges import Ranges, at_ends, ranges_of, read_ranges
from vvdp.evaluation.summary import simulated_summary
from vvdp.runs.run import RecordedRun
from vvdp.simulation.batch import case_shape, simulate_batch
from vvdp.simulation.crew import Crew, never
from vvdp.simulation.link import quiet
from vvdp.simulation.outcome import Outcome, outcome
from vvdp.simulation.run import simulate
from vvdp.systems.system import System

MOST_EVALUATIONS = 1.5e7
"""Evaluations of a circuit that runs at the ends may take by default: about a second."""


def run_ranges(
    run: RecordedRun, *, stop: Callable[[], bool] = never, say: Callable[[str], None] = quiet
) -> Ranges | None:
    """The headline of a run at both ends of each value of its system that has a range; None where it was stopped.

    What cannot be simulated at an end is left out, and the ranges say why.
    """
    system = run.system
    try:
        variants = list(at_ends(system))
        ready = iter(_outcomes(system, [each for each, _ in variants if each is not None], stop, say))
        found = [reason if variant is None else _numbers(variant, next(ready)) for variant, reason in variants]
    except KeyboardInterrupt:  # by whatever stops, or at any moment by Ctrl-C
        return None
    return ranges_of(system, headline(run), run.summary, found)


def headline(run: RecordedRun) -> tuple[str, ...]:
    """The numbers of a run whose ranges are reported: those that the system names, else the pressures and speeds."""
    extras = additions(run.system)
    if extras is not None and extras.HEADLINE:
        return extras.HEADLINE
    names = {line.name for line in node_lines(run.system, run.summary) if line.low != line.high}
    quantities = ("pressure_mean", "pressure_max", "speed_mean", "speed_max")
    ends = tuple(f"{quantity}_{name}_" for quantity in quantities for name in names)
    return tuple(key for key in run.summary if key.startswith(ends))


def expected_evaluations(run: RecordedRun) -> float:
    """Evaluations of the circuit that the runs at all ends take, by those of the run itself."""
    return 2.0 * len(run.system.uncertainties) * run.number("evaluations")


def with_ranges(run: RecordedRun, ranges: Ranges) -> RecordedRun:
    """The run with its ranges, which are then kept and shown with it."""
    return replace(run, meta={**run.meta, "ranges": ranges.flat, "ranges_left_out": dict(ranges.left_out)})


def kept_ranges(run: RecordedRun) -> Ranges | None:
    """The ranges that a run was given; None where it has none."""
    flat = run.meta.get("ranges")
    return read_ranges(run.system, run.summary, flat, run.meta.get("ranges_left_out", {})) if flat else None


def _outcomes(
    system: System, variants: Sequence[System], stop: Callable[[], bool], say: Callable[[str], None]
) -> list[Outcome | str]:
    """Results of the runs of all variants, or why they do not end; those of another shape run alone.

    Raises KeyboardInterrupt where the user stops.
    """
    shape = (system.circuit.digest, case_shape(system.case))
    alike = [(variant.circuit.digest, case_shape(variant.case)) == shape for variant in variants]
    cases = [variant.case for variant, together in zip(variants, alike, strict=True) if together]
    if not cases:
        return [_alone(variant, stop) for variant in variants]
    # Compiling the loop for lanes takes longer than the ends of a few values without it.
    batch = simulate_batch(system.model, cases, system.stepping, Crew(stop=stop), lanes=False, say=say)
    if batch.stopped:
        raise KeyboardInterrupt
    rows = iter(range(len(cases)))
    found: list[Outcome | str] = []
    for variant, together in zip(variants, alike, strict=True):
        row = next(rows) if together else None
        done = None if row is None else batch.reasons[row] or batch.outcome(row)
        found.append(_alone(variant, stop) if done is None else done)
    return found


def _numbers(variant: System, done: Outcome | str) -> Mapping[str, float | bool] | str:
    """The summary of a run at an end, or why there is none."""
    return done if isinstance(done, str) else simulated_summary(done, variant)


def _alone(variant: System, stop: Callable[[], bool]) -> Outcome | str:
    """Result of one run, or why it does not end."""
    try:
        done = simulate(variant.model, variant.case, variant.stepping, stop=stop)
    except RunError as problem:
        return str(problem)
    if not done.finished:
        raise KeyboardInterrupt
    return outcome(done)
