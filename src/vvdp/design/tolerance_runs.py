"""The runs of a tolerance study: a system simulated at evenly spread draws of its inputs, all in lanes."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.tables import Sourced
from vvdp.design.spreads import Spread, bench_with
from vvdp.evaluation.bench import RotaryBench, rotary_bench
from vvdp.evaluation.summary import simulated_summary
from vvdp.simulation.batch import simulate_batch
from vvdp.systems.changed import with_numbers
from vvdp.systems.system import System

FEWEST = 8
"""Draws that have to give a result."""
NO_PERIOD = "no whole PWM period within the run"


class SimulatedDraws(NamedTuple):
    """Results of runs, by key of the summary: at evenly spread `points` of the unit cube, with the system as it is,
    and at both ends of each input alone, shape (inputs, 2). `failed` says why draws gave nothing; they are left out."""

    points: Array
    outputs: Mapping[str, Array]
    nominal: Mapping[str, float]
    ends: Mapping[str, Array]
    failed: tuple[str, ...]


def simulated_draws(
    system: System, taken: Sequence[Spread], keys: Sequence[str], runs: int, seed: int
) -> SimulatedDraws:
    """The numbers `keys` of `runs` draws of the inputs `taken`.

    Raises ConfigError where inputs contradict other values of the system, or it does not run; KeyboardInterrupt where
    the runs are stopped.
    """
    from scipy.stats import qmc

    points: Array = qmc.Sobol(len(taken), seed=seed).random(runs)
    draws = [{each.setting: float(each.quantile(x)) for each, x in zip(taken, row, strict=True)} for row in points]
    ends = [{each.setting: end} for each in taken for end in (each.low, each.high)]
    values, reasons = _results(_general_form(system, taken), [{}, *ends, *draws], keys)
    begin = 1 + len(ends)
    ran = np.array([not reason for reason in reasons[begin:]])
    if reasons[0] or np.count_nonzero(ran) < FEWEST:
        why = reasons[0] or next(filter(None, reasons[begin:]))
        raise ConfigError([Fault(system.name, 0, "", f"gives no results to spread: {why}")])
    return SimulatedDraws(
        points=points[ran],
        outputs={key: column[begin:][ran] for key, column in values.items()},
        nominal={key: float(column[0]) for key, column in values.items()},
        ends={key: column[1:begin].reshape(-1, 2) for key, column in values.items()},
        failed=tuple(filter(None, reasons[begin:])),
    )


def as_rows(taken: Sequence[Spread]) -> tuple[Sourced, ...]:
    """Spreads as values with a range, as pictures of them take them."""
    return tuple(
        Sourced(
            table=each.setting.rpartition(".")[0],
            key=each.setting.rpartition(".")[2],
            value=each.nominal,
            kind=each.kind,
            status=each.status,
            source=each.source,
            note=each.note,
            range=(each.low, each.high),
        )
        for each in taken
    )


def _general_form(system: System, taken: Sequence[Spread]) -> RotaryBench:
    """The bench, drawn so that it holds for all draws: at the end of a spread a component may have a simpler form."""
    bench = rotary_bench(system, "design tolerance")
    try:
        between = with_numbers(system, {each.setting: float(each.quantile(0.5)) for each in taken})
    except ConfigError:  # what contradicts is reported of each draw
        return bench
    return bench.drawn_as(between)


def _results(
    bench: RotaryBench, variants: Sequence[Mapping[str, float]], keys: Sequence[str]
) -> tuple[dict[str, Array], list[str]]:
    """The numbers of each variant [SI by setting], nan where it has none, and the reason of that."""
    system = bench.own_system
    cases, places, reasons = [], [], [""] * len(variants)
    for place, values in enumerate(variants):
        try:
            cases.append(bench_with(bench, values).case)
            places.append(place)
        except ParameterError as problem:
            reasons[place] = str(problem)
    batch = simulate_batch(system.model, cases, system.stepping)
    if batch.stopped:
        raise KeyboardInterrupt
    found = {key: np.full(len(variants), np.nan) for key in keys}
    for number, place in enumerate(places):
        done = batch.outcome(number)
        if done is None or not done.window.periods:
            reasons[place] = batch.reasons[number] or NO_PERIOD
            continue
        numbers = simulated_summary(done, system)
        for key in keys:
            found[key][place] = numbers[key]
    return found, reasons
