"""Effect of scatter of parts and oil, and of assumed values, on drop, frequency and efficiency, and the share of each.

The drop and the frequency of the fully open valve are closed forms. Efficiency, running frequency and highest pressure
rest on lag, lap and jet, which these do not hold for: they are simulated at evenly spread draws, and a smooth curve
through these runs is drawn from. Distributions come from evenly spread draws, the shares of the variance from
Saltelli's scheme for Sobol's indices.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent
from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.extras import require
from vvdp.base.kinds import EFFICIENCY, FREQUENCY, GAUGE_PRESSURE, Kind
from vvdp.design.problem import require_flow
from vvdp.design.quantities import KINDS, LABELS, Quantities, Setup, key, quantities, setup, switching_condition
from vvdp.design.spreads import Spread, with_inputs
from vvdp.design.tolerance_runs import SimulatedDraws, as_rows, simulated_draws
from vvdp.evaluation.ranges import Ranges
from vvdp.numerics.gaussian_process import Surrogate, fit_surrogate
from vvdp.systems.system import System
from vvdp.valve.losses import range_warnings

CLOSED = ("pressure_drop_total", "pwm_frequency", "efficiency")
"""Outputs by closed forms; the last one only where nothing is simulated."""
SIMULATED = {
    "efficiency": "efficiency",
    "running_pwm_frequency": "pwm_frequency_Hz",
    "highest_inlet_pressure": "pressure_max_inlet_Pa",
}
"""Outputs that are simulated, and their keys in the summary of a run."""
WORDS: Mapping[str, tuple[Kind, str]] = {name: (KINDS[name], LABELS[name]) for name in CLOSED} | {
    "efficiency": (EFFICIENCY, "efficiency"),
    "running_pwm_frequency": (FREQUENCY, "PWM frequency, switching"),
    "highest_inlet_pressure": (GAUGE_PRESSURE, "inlet pressure, highest"),
}
"""Kind and label of each output."""
SAMPLES, RUNS = 1024, 256
COARSE = 0.15
"""Half width of the 95 % confidence of a share of the variance from which on a note says that samples are few."""
ROUGH = 0.05
"""Share of the variance that a curve through runs misses, from which on a note says that runs are few."""


@dataclass(frozen=True)
class Scatter:
    """How an output spreads: nominal, mean, standard deviation, percentiles by number, and the share of its variance
    that each input explains alone and with all others, with the half widths of their 95 % confidence."""

    nominal: float
    mean: float
    deviation: float
    percentiles: Mapping[str, float]
    alone: Mapping[str, float]
    alone_error: Mapping[str, float]
    whole: Mapping[str, float]
    whole_error: Mapping[str, float]


@dataclass(frozen=True)
class Tolerance:
    """A tolerance study: its spreads, the scatter of every output, and the draws of the distributions.

    `unexplained` is the part of the variance that the curve through the `runs` misses, of each simulated output;
    `failed` says why runs gave no result. `ranges` has every output at both ends of each input alone.
    """

    system: System
    spreads: tuple[Spread, ...]
    scatter: Mapping[str, Scatter]
    inputs: Mapping[str, Array]
    outputs: Mapping[str, Array]
    ranges: Ranges
    evaluations: int
    samples: int
    runs: int = 0
    unexplained: Mapping[str, float] = field(default_factory=dict)
    failed: tuple[str, ...] = ()

    @property
    def left_out(self) -> tuple[Spread, ...]:
        """The spreads that no closed form knows or holds over, where nothing is simulated."""
        return tuple(each for each in self.spreads if not (self.runs or each.in_closed_forms))

    @property
    def warnings(self) -> list[str]:
        """Warnings to read before the numbers are used, a sentence each: the closed form of the losses does not hold at
        the nominal values, runs failed, or runs or samples are few."""
        at = setup(self.system)
        told = [] if self.runs else list(range_warnings(at.duty_ratio, switching_condition(at), at.valve))
        if self.failed:
            told.append(f"{len(self.failed)} of {self.runs} runs gave no result, the first because: {self.failed[0]}")
        rough = {name: share for name, share in self.unexplained.items() if share > ROUGH}
        told += [
            f"the curve through {self.runs} runs misses {percent(share, 0)} of the variance of the {WORDS[name][1]}; "
            f"give more --runs"
            for name, share in rough.items()
        ]
        worst = max(max(each.whole_error.values()) for each in self.scatter.values())
        if worst > COARSE:
            told.append(
                f"with {self.samples} samples the shares of the variance are uncertain by up to {percent(worst, 0)} "
                f"of the whole (95 % confidence) and need not sum to 100 %; give more --samples, for example {SAMPLES}"
            )
        return told


PERCENTILES = ("2.5", "16", "50", "84", "97.5")


class Outputs(NamedTuple):
    """Outputs as a function of rows of shares, each between 0 and 1, in the order of the spreads."""

    at: Setup
    spreads: tuple[Spread, ...]
    closed: tuple[str, ...]
    curves: Mapping[str, Surrogate]

    def __call__(self, shares: Array) -> dict[str, Array]:
        """The outputs of each row."""
        values = {each.setting: each.quantile(shares[:, k]) for k, each in enumerate(self.spreads)}
        known = {each.setting: values[each.setting] for each in self.spreads if each.in_closed_forms}
        found = quantities(with_inputs(self.at, known))
        closed = {name: np.broadcast_to(np.asarray(getattr(found, name)), len(shares)).copy() for name in self.closed}
        return closed | {name: curve(shares) for name, curve in self.curves.items()}


def tolerance(
    system: System, taken: Sequence[Spread], *, samples: int = SAMPLES, runs: int = RUNS, seed: int = 1
) -> Tolerance:
    """The study of a system with the spreads `taken`; `samples` and `runs` are powers of two, `runs` or 0 for closed
    forms alone.

    Raises ParameterError where a number is none of these, ConfigError where nothing flows through the valve or to the
    load, and KeyboardInterrupt where the runs are stopped.
    """
    require("SALib", "opt", "a tolerance study")
    require_flow(system)
    _check_count("samples", samples, 8, SAMPLES)
    if runs:
        _check_count("runs", runs, 16, RUNS)
    at = setup(system)
    nominal = quantities(at)
    if not nominal.efficiency > 0.0:
        raise ConfigError([Fault(system.name, 0, "operation.duty_ratio", _nothing_left(at, nominal))])
    drawn = simulated_draws(system, taken, tuple(SIMULATED.values()), runs, seed) if runs else None
    curves = {} if drawn is None else _curves(system, drawn)
    closed = CLOSED if drawn is None else tuple(name for name in CLOSED if name not in SIMULATED)
    outputs = Outputs(at, tuple(taken), closed, curves)
    first = {name: float(getattr(nominal, name)) for name in closed}
    if drawn is not None:
        first |= {name: drawn.nominal[each] for name, each in SIMULATED.items()}
    scatter, even, values, evaluations = _scatters(outputs, first, samples, seed)
    return Tolerance(
        system=system,
        spreads=tuple(taken),
        scatter=scatter,
        inputs={each.name: each.quantile(even[:, k]) for k, each in enumerate(taken)},
        outputs=values,
        ranges=_ranges(outputs, first, drawn),
        evaluations=evaluations,
        samples=samples,
        runs=runs,
        unexplained={name: curve.unexplained for name, curve in curves.items()},
        failed=() if drawn is None else drawn.failed,
    )


def _check_count(word: str, count: int, least: int, example: int) -> None:
    if count < least or count & (count - 1):
        raise ParameterError(f"{count} {word}; expected a power of two from {least} on, for example {example}")


def _curves(system: System, drawn: SimulatedDraws) -> dict[str, Surrogate]:
    """A curve through each simulated output. Raises ConfigError where one does not scatter."""
    try:
        return {name: fit_surrogate(drawn.points, drawn.outputs[each]) for name, each in SIMULATED.items()}
    except ValueError as problem:
        raise ConfigError([Fault(system.name, 0, "", f"nothing to scatter: {problem}")]) from None


def _scatters(
    outputs: Outputs, nominal: Mapping[str, float], samples: int, seed: int
) -> tuple[dict[str, Scatter], Array, dict[str, Array], int]:
    """The scatter of each output, the evenly spread shares it comes from, the outputs there, and how many were made."""
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as sampling
    from scipy.stats import qmc

    names = [each.name for each in outputs.spreads]
    cube = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    shares = sampling.sample(cube, samples, calc_second_order=False, seed=seed)
    drawn = outputs(shares)
    even: Array = qmc.Sobol(len(names), seed=seed).random(max(4096, 2 * samples))
    values = outputs(even)
    scatter = {}
    for name, column in drawn.items():
        # Sobol's estimators lose digits where the mean is large against the scatter.
        centred = (column - np.mean(column)) / (np.std(column) or 1.0)
        found = analysis.analyze(cube, centred, calc_second_order=False, seed=seed)
        indices = [dict(zip(names, map(float, found[each]), strict=True)) for each in INDICES]
        scatter[name] = _scatter(nominal[name], values[name], indices)
    return scatter, even, values, shares.shape[0] + even.shape[0]


def _ranges(outputs: Outputs, nominal: Mapping[str, float], drawn: SimulatedDraws | None) -> Ranges:
    """Every output at both ends of each input alone."""
    spreads = outputs.spreads
    ends = {}
    for name in outputs.closed:
        pairs = [
            [getattr(quantities(with_inputs(outputs.at, {each.setting: end})), name) for end in (each.low, each.high)]
            if each.in_closed_forms
            else [nominal[name]] * 2
            for each in spreads
        ]
        ends[name] = np.array(pairs, float)
    if drawn is not None:
        ends |= {name: drawn.ends[each] for name, each in SIMULATED.items()}
    return Ranges(
        rows=as_rows(spreads),
        nominal={key(name, WORDS[name][0]): nominal[name] for name in ends},
        ends={key(name, WORDS[name][0]): pairs for name, pairs in ends.items()},
        left_out={},
    )


INDICES = ("S1", "S1_conf", "ST", "ST_conf")
"""Names in SALib of the shares of an input alone and with all others, and of their half widths."""


def _scatter(nominal: float, column: Array, indices: Sequence[Mapping[str, float]]) -> Scatter:
    """The scatter of an output from its draws and the `INDICES` of its inputs."""
    alone, alone_error, whole, whole_error = indices
    return Scatter(
        nominal=nominal,
        mean=float(np.mean(column)),
        deviation=float(np.std(column, ddof=1)),
        percentiles={each: float(np.percentile(column, float(each))) for each in PERCENTILES},
        alone=alone,
        alone_error=alone_error,
        whole=whole,
        whole_error=whole_error,
    )


def _nothing_left(at: Setup, nominal: Quantities) -> str:
    """Why there is no efficiency to scatter, and from which duty ratio on there is."""
    through = at.flow * (at.load_pressure - at.tank_pressure)
    lost = at.duty_ratio - nominal.load_flow / at.flow + (nominal.loss_leakage + nominal.loss_compressibility) / through
    return (
        f"{at.duty_ratio:g}: analytically, transitions, leakage and compression take all that the load would get, "
        f"so there is no efficiency to scatter; expected more than {lost:.4g}"
    )
