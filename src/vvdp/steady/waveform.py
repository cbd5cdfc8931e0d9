"""Course of one period of a periodic state, at equal intervals, and its harmonics."""

from dataclasses import dataclass, replace

import numpy as np

from vvdp.base.arrays import Array
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Run, Stepping, simulate
from vvdp.steady.steady_states import Steady

SAMPLES = 512


@dataclass(frozen=True)
class Waveform:
    """One period in `SAMPLES` equal steps, the end left out: times [s], pressures absolute [Pa], flows [m^3/s]."""

    period: float
    times: Array
    inlet_pressure: Array
    load_pressure: Array
    load_flow: Array


def waveform(state: Steady, *, samples: int = SAMPLES) -> Waveform:
    """The waveform of a periodic state. Raises ValueError where the operating point has none."""
    if state.periodic is None or state.periodic.outcome is None:
        raise ValueError(f"no periodic state at {state.point}: {state.reason}")
    period = state.periodic.period
    step = period / samples
    stepping = replace(
        state.stand.stepping, until=period, record_interval=step, window=period, window_interval=step,
        average_from=None, relative_tolerance=min(1e-8, state.stand.stepping.relative_tolerance),
    )  # fmt: skip
    run = whole_run(state.stand.model, state.periodic.case, stepping)
    series = state.stand.bench.run_series(run)
    even = np.arange(samples) * step
    near = np.array([int(np.argmin(np.abs(run.times - t))) for t in even])
    return Waveform(
        period,
        np.asarray(even, float),
        series.inlet_pressure[near],
        series.load_pressure[near],
        series.load_flow[near],
    )


def whole_run(model: Model, case: Case, stepping: Stepping) -> Run:
    """A run to its end; Ctrl-C is raised, since part of it gives no mean and no harmonic."""
    run = simulate(model, case, stepping)
    if not run.finished:
        raise KeyboardInterrupt
    return run


def harmonics(values: Array, count: int) -> Array:
    """Amplitudes of the first `count` harmonics of one period of equally spaced values, in their unit.

    Exact for what is periodic: no window is needed.
    """
    found: Array = 2.0 / values.size * np.abs(np.fft.rfft(values))[1 : count + 1]
    return found
