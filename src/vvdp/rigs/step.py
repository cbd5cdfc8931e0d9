"""Step and frequency response of the delivered flow to the duty ratio, in the manner of ISO 17559."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.signal import Signal, sine, step
from vvdp.rigs.conditions import LPM, conditions, gauge
from vvdp.rigs.result import Column, RigResult, Sheet
from vvdp.rigs.ripple import line_capacity
from vvdp.simulation.link import quiet
from vvdp.simulation.model import Case
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import Stand
from vvdp.steady.waveform import whole_run
from vvdp.systems.bench import BenchSeries

STEPS = (0.4, 0.6)
PHASES = 8
"""Instants within a PWM period at which a step begins."""
SHOWN, BEFORE = 0.25, 0.04
"""What is recorded of a step, after it and before it [s]; after it is longer where load line or switching is slow."""
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
"""Of the PWM frequency: above half of it the flow cannot tell a frequency from its mirror image."""
FOLDED = 1.0 / 3.0
"""Of the PWM frequency: there the second harmonic, folded back by the switching, falls upon the frequency itself."""
NEAR = 1.0 / 36.0
"""Of the PWM frequency: closer to the folding the window cannot tell both apart."""
COUNT = 14
LOWEST, LOWEST_SHARE = 1.0, 0.02
"""Lowest frequency of the response at most [Hz], and over the PWM frequency: of a slow spool it is lower."""
WINDOW_CYCLES, WINDOW_PERIODS = 3, 24.0
"""Cycles of a frequency and PWM periods that its window holds at least: enough to tell the sine from the switching."""
MANNER = (
    "Dynamic characteristics in the manner of ISO 17559: delivered flow after a step of the duty ratio, and its gain "
    "and phase against a sinusoidal duty ratio. Flow is the mean over the last turn through one PWM period at "
    f"every instant of a step, over {PHASES} phases of the step within a PWM period; gain and phase come from the "
    "delivered volume itself through a Hann window. Gain is over the static gain between the two duty ratios of "
    "the step."
)
LEFT_OUT = (
    "The actuator that moves the spool axially: the duty ratio is changed at once, so the response shown is the bound "
    "that the switching itself sets.",
    "The pump's own flow ripple and the flow meter's own dynamics.",
)


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
    bench = state.stand.at(state.point, state.area).changed(operation={"duty_ratio": signal})
    return replace(bench.case, state=state.periodic.case.state)


def step_response(state: Steady, after: float, *, length: float = SHOWN, cache: Path | None = None) -> Steps:
    """Delivered flow when the duty ratio of a steady state steps to `after`, over phases of the step.

    Source  ours, docs/rigs.md, in the manner of iso17559
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
            stand.stepping, until=until, record_interval=INTERVAL, window=until, window_interval=INTERVAL
        )
        run = whole_run(stand.model, case, stepping, cache)
        series = stand.bench.run_series(run)
        flows.append(np.interp(times + begin, run.times, period_mean_flow(run.times, series, sections)))
        loads.append(np.interp(times + begin, run.times, series.through_load))
    all_ = np.array(flows)
    late = times > times[-1] - 0.2 * length
    mean = all_.mean(axis=0)
    return Steps(
        np.asarray(times, float), mean, all_.min(axis=0), all_.max(axis=0), np.array(loads).mean(axis=0),
        float(mean[times < 0.0].mean()), float(mean[late].mean()),
    )  # fmt: skip


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
    state: Steady, frequencies: Sequence[float], amplitude: float = AMPLITUDE, *, cache: Path | None = None
) -> tuple[Array, Array]:
    """Delivered flow, and flow through an orifice load, over a sinusoidal duty ratio: complex amplitudes [m^3/s].

    Both have the shape (frequencies,), per unit of duty ratio; the second is nan where a source is the load.

    Source  ours, docs/rigs.md, in the manner of iso17559
    """
    assert state.periodic is not None
    stand, delivered, load = state.stand, [], []
    for f in frequencies:
        start = max(0.15, 2.0 / f, LINE_TIMES * line_time(state))
        window = max(WINDOW_CYCLES, int(np.ceil(f * WINDOW_PERIODS * state.periodic.period))) / f  # whole cycles
        until = start + window
        interval = min(max(INTERVAL, INTERVAL_SHARE * state.periodic.period), 1.0 / (200.0 * f))
        stepping = replace(
            stand.stepping, until=until, record_interval=interval, window=until, window_interval=interval
        )
        case = _with_duty(state, sine(state.point.duty_ratio, amplitude, f))
        run = whole_run(stand.model, case, stepping, cache)
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


def checked_steps(steps: tuple[float, float]) -> tuple[float, float]:
    """The two duty ratios of a step, the lower one first.

    Raises ParameterError where they are equal or outside 0 to 1.
    """
    low, high = sorted(steps)
    if not 0.0 <= low < high <= 1.0:
        a, b = steps
        raise ParameterError(f"a step from duty ratio {a:g} to {b:g}; expected two different ones from 0 to 1")
    return low, high


def dynamics(
    stand: Stand,
    steps: tuple[float, float] = STEPS,
    frequencies: Sequence[float] | None = None,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> RigResult:
    """Response of the delivered flow to the duty ratio between two values: steps up and down, gain and phase.

    Raises ParameterError where the two are equal or outside 0 to 1, or one of them has no steady state. In which order
    they are given does not matter.

    Source  ours, docs/rigs.md, in the manner of iso17559
    """
    began = time.perf_counter()
    low, high = checked_steps(steps)
    here = stand.set_point
    states = _states(stand, low, high, cores, cache, say)
    down, up, middle = states
    assert middle.periodic is not None
    slowest = max(state.periodic.period for state in states if state.periodic is not None)
    length = max(SHOWN, STEP_PERIODS * slowest, LINE_TIMES * max(line_time(state) for state in states))
    rising = step_response(down, high, length=length, cache=cache)
    falling = step_response(up, low, length=length, cache=cache)
    pwm = 1.0 / middle.periodic.period
    if frequencies is None:
        frequencies = response_frequencies(pwm, line_time(middle))
    asked = np.array(list(frequencies), float)
    if not asked.size or np.any(asked <= 0.0) or np.any(asked > 0.5 * pwm):
        raise ParameterError(
            f"frequencies {', '.join(f'{f:g}' for f in asked)} Hz; expected some above 0 and up to half the PWM "
            f"frequency, {0.5 * pwm:.4g} Hz"
        )
    amplitude = min(AMPLITUDE, 0.5 * (high - low))
    delivered, load = frequency_response(middle, frequencies, amplitude, cache=cache)
    static = (rising.after - rising.before) / (high - low)
    said = conditions(stand) | {
        "duty ratio": f"{low:g} to {high:g} and back; {0.5 * (low + high):g} ± {amplitude:g} in the frequency response",
        "load pressure": f"{gauge(here.load_pressure)} bar"
        + (
            ", mean at the duty ratio that delivers more; the orifice then stays as it is"
            if stand.makes_pressure
            else ""
        ),
    }
    sheets = {
        "step_up": Sheet(f"Step from duty ratio {low:g} to {high:g}", _step_columns(rising)),
        "step_down": Sheet(f"Step from duty ratio {high:g} to {low:g}", _step_columns(falling)),
        "frequency": Sheet("Frequency response", _frequency_columns(asked, delivered, load, static)),
    }
    numbers = _numbers(rising, falling, asked, delivered / static, pwm, static, line_time(middle))
    return RigResult(
        rig="step",
        title="Response of the delivered flow to the duty ratio",
        system=stand.name,
        manner=MANNER,
        references=("iso17559",),
        conditions=said,
        left_out=LEFT_OUT,
        sheets=sheets,
        numbers=numbers,
        findings=_findings(numbers),
        seconds=time.perf_counter() - began,
    )


def _states(
    stand: Stand, low: float, high: float, cores: int | None, cache: Path | None, say: Callable[[str], None]
) -> list[Steady]:
    """The steady states at both duty ratios and in the middle.

    An orifice load is sized at the one that delivers more and stays as it is, so that the pressure stays below the set
    point. Raises ParameterError where there is no steady state.
    """
    here = stand.set_point
    found: dict[float, Steady] = {}
    area = None
    for duty in (high, low, 0.5 * (low + high)):
        pressure = here.load_pressure
        if stand.makes_pressure:  # flows through an orifice go with the root of the drop
            pressure = stand.tank_pressure + (pressure - stand.tank_pressure) * (max(duty, 0.1) / max(high, 0.1)) ** 2
        point = here._replace(duty_ratio=float(duty), load_pressure=float(pressure))
        (state,) = steady_states([(stand, point)], area, cores=cores, cache=cache, say=say)
        if state.reason is not None or state.periodic is None:
            raise ParameterError(f"no steady state at duty ratio {duty:g}: {state.reason}")
        if stand.makes_pressure:
            area = state.area
        found[duty] = state
    return [found[low], found[high], found[0.5 * (low + high)]]


def _step_columns(found: Steps) -> dict[str, Column]:
    columns = {
        "time_s": Column(found.times, "s", "time"),
        "delivered_flow_m3_s": Column(found.flow, "m^3/s", "delivered flow"),
        "delivered_flow_lowest_m3_s": Column(found.lowest, "m^3/s", "lowest of the phases"),
        "delivered_flow_highest_m3_s": Column(found.highest, "m^3/s", "highest of the phases"),
    }
    if np.isfinite(found.load_flow).all():
        columns["load_flow_m3_s"] = Column(found.load_flow, "m^3/s", "flow through the load")
    return columns


def _frequency_columns(frequencies: Array, delivered: Array, load: Array, static: float) -> dict[str, Column]:
    columns = {"frequency_Hz": Column(frequencies, "Hz", "frequency")}
    for name, values, words in (("delivered_flow", delivered, "delivered"), ("load_flow", load, "through the load")):
        if np.isfinite(values).all():
            columns[f"{name}_gain"] = Column(np.abs(values) / abs(static), "", f"gain, {words}")
            phase = np.unwrap(np.angle(values / static))
            columns[f"{name}_phase_rad"] = Column(np.asarray(phase, float), "rad", f"phase, {words}")
    return columns


def _numbers(
    rising: Steps, falling: Steps, frequencies: Array, response: Array, pwm: float, static: float, lag: float
) -> dict[str, float]:
    found = {"pwm_frequency_Hz": pwm, "static_gain_m3_s": static, "load_line_time_constant_s": lag}
    for name, s in (("up", rising), ("down", falling)):
        reached = [crossing_time(s.times, s.flow, s.before, s.after, share) for share in (0.1, 0.63, 0.9)]
        found |= {
            f"step_{name}_flow_before_m3_s": s.before,
            f"step_{name}_flow_after_m3_s": s.after,
            f"step_{name}_to_63_s": reached[1],
            f"step_{name}_rise_s": reached[2] - reached[0],
            f"step_{name}_settling_s": settling_time(s.times, s.flow, s.before, s.after),
        }
    gain, phase = np.abs(response), np.unwrap(np.angle(response))
    below = np.flatnonzero(gain < 10.0 ** (-3.0 / 20.0))
    behind = np.flatnonzero(phase < -0.5 * np.pi)
    found["bandwidth_3_dB_Hz"] = float(frequencies[below[0]]) if below.size else np.nan
    found["bandwidth_90_degrees_Hz"] = float(frequencies[behind[0]]) if behind.size else np.nan
    found["highest_frequency_Hz"] = float(frequencies.max())
    found["gain_at_highest_frequency"] = float(gain[np.argmax(frequencies)])
    return found


def _findings(n: dict[str, float]) -> tuple[str, ...]:
    period = 1e3 / n["pwm_frequency_Hz"]
    sentences = [
        f"After the step up the delivered flow, averaged over a PWM period of {period:.3g} ms, has come 63 % of the "
        f"way after {1e3 * n['step_up_to_63_s']:.3g} ms and stays within 5 % after "
        f"{1e3 * n['step_up_settling_s']:.3g} ms; after the step down, {1e3 * n['step_down_to_63_s']:.3g} and "
        f"{1e3 * n['step_down_settling_s']:.3g} ms.",
        f"The static gain is {n['static_gain_m3_s'] / LPM:.4g} lpm per unit of duty ratio.",
    ]
    if np.isfinite(n["bandwidth_3_dB_Hz"]):
        sentences.append(f"The gain falls below -3 dB at {n['bandwidth_3_dB_Hz']:.3g} Hz.")
    else:
        share = 100.0 * n["highest_frequency_Hz"] / n["pwm_frequency_Hz"]
        sentences.append(
            f"Up to {n['highest_frequency_Hz']:.3g} Hz, {share:.0f} % of the PWM frequency, the gain stays above "
            f"-3 dB; it is {n['gain_at_highest_frequency']:.3g} there."
        )
    if n["load_line_time_constant_s"] > 0.0:
        sentences.append(
            f"The load line with its accumulator lets the flow through the load follow with a time constant of about "
            f"{1e3 * n['load_line_time_constant_s']:.3g} ms."
        )
    return tuple(sentences)
