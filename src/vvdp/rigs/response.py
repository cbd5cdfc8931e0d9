"""Delivered flow after a step of the duty ratio, and its complex amplitude against a sinusoidal one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.signal import Signal, sine, step
from vvdp.evaluation.bench import BenchSeries
from vvdp.rigs.ripple import line_capacity
from vvdp.simulation.model import Case
from vvdp.steady.steady_states import Steady
from vvdp.steady.waveform import whole_run

PHASES = 8
"""Instants within a PWM period at which a step begins."""
SHOWN, BEFORE = 0.25, 0.04
"""Recorded time of a step, after it and before it [s]; longer after it if load line or switching is slow."""
LINE_TIMES = 4.0
STEP_PERIODS = 2.5
"""PWM periods that are recorded after a step at least: within one the mean over a period has all of it, and the last
fifth of what is recorded is taken for the flow after it."""
INTERVAL, INTERVAL_SHARE = 2e-4, 0.01
"""Between recorded instants [s]; longer in the frequency response of a slow spool: this share of the PWM period."""
BAND = 0.05
"""Of a step: within it the flow has settled."""
AMPLITUDE = 0.05
"""Of the duty ratio in the frequency response."""
HIGHEST = 0.45
"""Of the PWM frequency: above half of it the flow cannot distinguish a frequency from its mirror image."""
FOLDED = 1.0 / 3.0
"""Of the PWM frequency: there the second harmonic, folded back by the switching, falls onto the frequency itself."""
NEAR = 1.0 / 36.0
"""Of the PWM frequency: closer to the folding the window cannot show both apart."""
COUNT = 14
LOWEST, LOWEST_SHARE = 1.0, 0.02
"""Lowest frequency of the response at most [Hz], and over the PWM frequency: of a slow spool it is lower."""
WINDOW_CYCLES, WINDOW_PERIODS = 3, 24.0
"""Cycles of a frequency and PWM periods that its window holds at least: enough to distinguish the sine from the
switching.
"""


@dataclass(frozen=True)
class Steps:
    """Delivered flow around a step, over `times` [s] from it: mean, lowest and highest of all phases [m^3/s]."""

    times: Array
    flow: Array
    lowest: Array
    highest: Array
    load_flow: Array  # through the load, mean of the phases; nan where a source is the load
    before: float
    after: float


def period_mean_flow(times: Array, series: BenchSeries, sections: float) -> Array:
    """Delivered flow at the recorded times, averaged over the PWM period that ends there [m^3/s].

    nan within the first period.
    """
    volume, angle = series.delivered_volume, series.spool_angle
    earlier = angle - 2.0 * np.pi / sections
    whole = earlier >= angle[0]
    flow: Array = np.full(angle.shape, np.nan)
    passed = volume[whole] - np.interp(earlier[whole], angle, volume)
    flow[whole] = passed / (times[whole] - np.interp(earlier[whole], angle, times))
    return flow


def _with_duty(state: Steady, signal: Signal) -> Case:
    """The case of a periodic state with a duty ratio that changes over time; it starts in that state."""
    assert state.periodic is not None
    bench = state.stand.at(state.point, state.area).with_tables(operation={"duty_ratio": signal})
    return replace(bench.case, state=state.periodic.case.state)


def step_response(state: Steady, after: float, *, length: float = SHOWN) -> Steps:
    """Delivered flow when the duty ratio of a steady state steps to `after`, over phases of the step.

    Source  ours, docs/rigs.md, based on iso17559
    """
    assert state.periodic is not None
    stand, period = state.stand, state.periodic.period
    sections = stand.bench.valve.sections
    times = np.arange(-round(BEFORE / INTERVAL), round(length / INTERVAL) + 1) * INTERVAL
    flows, loads = [], []
    for phase in range(PHASES):
        begin = BEFORE + period * (1.5 + phase / PHASES)
        case = _with_duty(state, step(state.point.duty_ratio, after, begin))
        until = begin + length + INTERVAL
        stepping = replace(
            stand.stepping, until=until, average_from=None,
            record_interval=INTERVAL, window=until, window_interval=INTERVAL,
        )  # fmt: skip
        run = whole_run(stand.model, case, stepping)
        series = stand.bench.run_series(run)
        flows.append(np.interp(times + begin, run.times, period_mean_flow(run.times, series, sections)))
        loads.append(np.interp(times + begin, run.times, series.through_load))
    all_ = np.array(flows)
    late = times > times[-1] - 0.2 * length
    mean = all_.mean(axis=0)
    return Steps(
        times=np.asarray(times, float),
        flow=mean,
        lowest=all_.min(axis=0),
        highest=all_.max(axis=0),
        load_flow=np.array(loads).mean(axis=0),
        before=float(mean[times < 0.0].mean()),
        after=float(mean[late].mean()),
    )


def crossing_time(times: Array, flow: Array, before: float, after: float, share: float) -> float:
    """First time after the step at which the flow has come `share` of the way [s]; nan where it does not."""
    progress = (flow - before) / (after - before)
    there = np.flatnonzero((times >= 0.0) & (progress >= share))
    return float(times[there[0]]) if there.size else np.nan


def settling_time(times: Array, flow: Array, before: float, after: float, band: float = BAND) -> float:
    """Time after the step from which the flow stays within `band` of the step around its end [s]."""
    outside = np.flatnonzero((times >= 0.0) & (np.abs(flow - after) > band * abs(after - before)))
    if not outside.size:
        return 0.0
    return float(times[outside[-1] + 1]) if outside[-1] + 1 < times.size else np.nan


def frequency_response(
    state: Steady, frequencies: Sequence[float], amplitude: float = AMPLITUDE
) -> tuple[Array, Array]:
    """Delivered flow, and flow through an orifice load, over a sinusoidal duty ratio: complex amplitudes [m^3/s].

    Both have the shape (frequencies,), per unit of duty ratio; the second is nan where a source is the load.

    Source  ours, docs/rigs.md, based on iso17559
    """
    assert state.periodic is not None
    stand, delivered, load = state.stand, [], []
    for f in frequencies:
        start = max(0.15, 2.0 / f, LINE_TIMES * line_time(state))
        window = max(WINDOW_CYCLES, int(np.ceil(f * WINDOW_PERIODS * state.periodic.period))) / f  # whole cycles
        until = start + window
        interval = min(max(INTERVAL, INTERVAL_SHARE * state.periodic.period), 1.0 / (200.0 * f))
        stepping = replace(
            stand.stepping, until=until, average_from=None,
            record_interval=interval, window=until, window_interval=interval,
        )  # fmt: skip
        case = _with_duty(state, sine(state.point.duty_ratio, amplitude, f))
        run = whole_run(stand.model, case, stepping)
        series = stand.bench.run_series(run)
        delivered.append(_of_volume(run.times, series.delivered_volume, start, until, f) / amplitude)
        load.append(_of_value(run.times, series.through_load, start, until, f) / amplitude)
    return np.array(delivered), np.array(load)


def line_time(state: Steady) -> float:
    """Time constant of an orifice load with its line, 2 C (P - P_T)/q [s]; 0 where a source is the load."""
    if not state.stand.makes_pressure:
        return 0.0
    summary = state.summary
    pressure = float(summary["pressure_mean_load_line_Pa"]) + state.stand.reference
    rise, capacity = pressure - state.stand.tank_pressure, line_capacity(pressure, state.stand)
    return float(2.0 * capacity * rise / summary["mean_load_flow_m3_s"])


def _window(t: Array, begin: float, end: float) -> tuple[Array, Array]:
    """Hann window over a stretch of time and its rate."""
    x = 2.0 * np.pi * (t - begin) / (end - begin)
    return 0.5 - 0.5 * np.cos(x), 0.5 * np.sin(x) * 2.0 * np.pi / (end - begin)


def _of_volume(times: Array, volume: Array, begin: float, end: float, f: float) -> complex:
    """Complex amplitude of the flow against sin(2 pi f t), by parts from the volume that has passed.

    2 int w q e^(-i w t) dt / int w dt with q = dV/dt: the window vanishes at both ends, so only -V times the rate of
    what q is multiplied with is left. The pulses of the flow itself need not be resolved.
    """
    inside = (times >= begin) & (times <= end)
    t, v = times[inside], volume[inside] - volume[inside].mean()
    w, rate = _window(t, begin, end)
    turning = np.exp(-2j * np.pi * f * t)
    integrand = -v * (rate - 2j * np.pi * f * w) * turning
    return complex(2j * np.trapezoid(integrand, t) / (0.5 * (end - begin)))


def _of_value(times: Array, values: Array, begin: float, end: float, f: float) -> complex:
    """Complex amplitude of a value against sin(2 pi f t)."""
    inside = (times >= begin) & (times <= end)
    t = times[inside]
    w, _ = _window(t, begin, end)
    x = values[inside] - np.mean(values[inside])
    return complex(2j * np.trapezoid(w * x * np.exp(-2j * np.pi * f * t), t) / (0.5 * (end - begin)))


def response_frequencies(pwm: float, lag: float) -> list[float]:
    """Frequencies for the response of a spool that switches at `pwm` [Hz], increasing [Hz].

    lag  time constant of the load line; 0 where a source is the load [s]

    Source  ours, docs/rigs.md
    """
    lowest = min(LOWEST, LOWEST_SHARE * pwm, 0.1 / lag if lag > 0.0 else np.inf)
    return [float(f) for f in np.geomspace(lowest, HIGHEST * pwm, COUNT) if abs(f / pwm - FOLDED) > NEAR]
