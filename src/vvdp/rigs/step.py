"""Step and frequency response of the delivered flow to the duty ratio, based on ISO 17559."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, with_unit
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import ANGLE, FLOW, FREQUENCY, LEVEL, NUMBER, PRESSURE_LEVEL, TIME, Kind
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Result, Table, numbers_of
from vvdp.rigs.conditions import conditions
from vvdp.rigs.response import (
    AMPLITUDE,
    LINE_TIMES,
    PHASES,
    SHOWN,
    STEP_PERIODS,
    Steps,
    crossing_time,
    frequency_response,
    line_time,
    response_frequencies,
    settling_time,
    step_response,
)
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import Stand

STEPS = (0.4, 0.6)
MANNER = (
    "Dynamic characteristics, based on ISO 17559: delivered flow after a step of the duty ratio, and its gain "
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
STEP_QUANTITIES = {
    "flow_before_m3_s": (FLOW, "delivered flow before the step"),
    "flow_after_m3_s": (FLOW, "delivered flow long after the step"),
    "to_63_s": (TIME, "time until 63 % of the way"),
    "rise_s": (TIME, "time from 10 to 90 % of the way"),
    "settling_s": (TIME, "time from which on the flow stays within 5 %"),
}
QUANTITIES: Mapping[str, tuple[Kind, str]] = {
    "pwm_frequency_Hz": (FREQUENCY, "PWM frequency"),
    "static_gain_m3_s": (FLOW, "delivered flow per unit of duty ratio, through the same orifice"),
    "load_line_time_constant_s": (TIME, "time constant of the load line"),
    **{
        f"step_{name}_{key}": (kind, f"step {name}: {label}")
        for name in ("up", "down")
        for key, (kind, label) in STEP_QUANTITIES.items()
    },
    "bandwidth_3_dB_Hz": (FREQUENCY, "frequency at which the gain falls below -3 dB"),
    "bandwidth_90_degrees_Hz": (FREQUENCY, "frequency at which the phase falls below -90°"),
    "highest_frequency_Hz": (FREQUENCY, "highest frequency of the response"),
    "gain_at_highest_frequency": (NUMBER, "gain there, over the static one"),
}


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
    say: Callable[[str], None] = quiet,
) -> Result:
    """Response of the delivered flow to the duty ratio between two values: steps up and down, gain and phase.

    Raises ParameterError where the two are equal or outside 0 to 1, or one of them has no steady state. In which order
    they are given does not matter.

    Source  ours, docs/rigs.md, based on iso17559
    """
    began = time.perf_counter()
    low, high = checked_steps(steps)
    down, up, middle = states = _states(stand, low, high, cores, say)
    periods = [state.periodic.period for state in states if state.periodic is not None]
    length = max(SHOWN, STEP_PERIODS * max(periods), LINE_TIMES * max(line_time(state) for state in states))
    rising, falling = step_response(down, high, length=length), step_response(up, low, length=length)
    pwm, amplitude = 1.0 / periods[-1], min(AMPLITUDE, 0.5 * (high - low))
    chosen = response_frequencies(pwm, line_time(middle)) if frequencies is None else frequencies
    asked = _checked_frequencies(chosen, pwm)
    delivered, load = frequency_response(middle, asked.tolist(), amplitude)
    static = (rising.after - rising.before) / (high - low)
    up_table = _step_table(f"Step from duty ratio {low:g} to {high:g}", rising)
    down_table = _step_table(f"Step from duty ratio {high:g} to {low:g}", falling)
    gains = Table(title="Frequency response", columns=_gains(asked, delivered, load, static))
    numbers = {"pwm_frequency_Hz": pwm, "static_gain_m3_s": static, "load_line_time_constant_s": line_time(middle)}
    numbers |= _step_numbers("up", rising) | _step_numbers("down", falling) | _bandwidths(asked, delivered / static)
    return Result(
        verb="rig step",
        title="Response of the delivered flow to the duty ratio",
        system=stand.name,
        manner=MANNER,
        references=("iso17559",),
        conditions=_conditions(stand, low, high, amplitude),
        left_out=LEFT_OUT,
        tables={"step_up": up_table, "step_down": down_table, "frequency": gains},
        charts={each.name: each for each in (_step_chart(up_table), _bode_chart(gains, pwm))},
        numbers=numbers_of(numbers, QUANTITIES),
        findings=tuple(_findings(stand, numbers)),
        seconds=time.perf_counter() - began,
    )


def _checked_frequencies(frequencies: Sequence[float], pwm: float) -> Array:
    asked = np.array(list(frequencies), float)
    if not asked.size or np.any(asked <= 0.0) or np.any(asked > 0.5 * pwm):
        raise ParameterError(
            f"frequencies {', '.join(f'{f:g}' for f in asked)} Hz; expected some greater than 0 Hz and up to half the "
            f"PWM frequency, {0.5 * pwm:.4g} Hz"
        )
    return asked


def _conditions(stand: Stand, low: float, high: float, amplitude: float) -> dict[str, str]:
    orifice = ", mean at the duty ratio that delivers more; the orifice then stays as it is"
    pressure = with_unit(stand.set_point.load_pressure, PRESSURE_LEVEL)
    return conditions(stand) | {
        "duty ratio": f"{low:g} to {high:g} and back; {0.5 * (low + high):g} ± {amplitude:g} in the frequency response",
        "load pressure": pressure + (orifice if stand.makes_pressure else ""),
    }


def _states(stand: Stand, low: float, high: float, cores: int | None, say: Callable[[str], None]) -> list[Steady]:
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
        (state,) = steady_states([(stand, point)], area, cores=cores, say=say)
        if state.reason is not None or state.periodic is None:
            raise ParameterError(f"no steady state at duty ratio {duty:g}: {state.reason}")
        if stand.makes_pressure:
            area = state.area
        found[duty] = state
    return [found[low], found[high], found[0.5 * (low + high)]]


def _step_table(title: str, found: Steps) -> Table:
    columns = {
        "time_s": Column(found.times, TIME, "time after the step"),
        "delivered_flow_m3_s": Column(found.flow, FLOW, "delivered"),
        "delivered_flow_lowest_m3_s": Column(found.lowest, FLOW, "lowest of the phases"),
        "delivered_flow_highest_m3_s": Column(found.highest, FLOW, "highest of the phases"),
    }
    if np.isfinite(found.load_flow).all():
        columns["load_flow_m3_s"] = Column(found.load_flow, FLOW, "through the load")
    return Table(title=title, columns=columns, is_data=True)


FLOWS = {
    "delivered_flow": ("delivered", Colour.LOAD, Stroke.MARKED),
    "load_flow": ("through the load", Colour.INLET, Stroke.DASHED),
}
"""Flows of the frequency response: what they are called and how they are drawn."""


def _gains(frequencies: Array, delivered: Array, load: Array, static: float) -> dict[str, Column]:
    columns = {"frequency_Hz": Column(frequencies, FREQUENCY, "frequency")}
    for (name, (words, _, _)), values in zip(FLOWS.items(), (delivered, load), strict=True):
        if np.isfinite(values).all():
            gain, phase = np.abs(values) / abs(static), np.unwrap(np.angle(values / static))
            columns[f"{name}_gain"] = Column(gain, NUMBER, f"gain, {words}")
            columns[f"{name}_gain_dB"] = Column(20.0 * np.log10(gain), LEVEL, f"gain, {words}")
            columns[f"{name}_phase_rad"] = Column(np.asarray(phase, float), ANGLE, f"phase, {words}")
    return columns


def _step_numbers(name: str, s: Steps) -> dict[str, float]:
    reached = [crossing_time(s.times, s.flow, s.before, s.after, share) for share in (0.1, 0.63, 0.9)]
    return {
        f"step_{name}_flow_before_m3_s": s.before,
        f"step_{name}_flow_after_m3_s": s.after,
        f"step_{name}_to_63_s": reached[1],
        f"step_{name}_rise_s": reached[2] - reached[0],
        f"step_{name}_settling_s": settling_time(s.times, s.flow, s.before, s.after),
    }


def _bandwidths(frequencies: Array, response: Array) -> dict[str, float]:
    gain, phase = np.abs(response), np.unwrap(np.angle(response))
    below = np.flatnonzero(gain < 10.0 ** (-3.0 / 20.0))
    behind = np.flatnonzero(phase < -0.5 * np.pi)
    return {
        "bandwidth_3_dB_Hz": float(frequencies[below[0]]) if below.size else np.nan,
        "bandwidth_90_degrees_Hz": float(frequencies[behind[0]]) if behind.size else np.nan,
        "highest_frequency_Hz": float(frequencies.max()),
        "gain_at_highest_frequency": float(gain[np.argmax(frequencies)]),
    }


def _step_chart(rising: Table) -> Chart:
    caption = (
        "Delivered flow after a step of the duty ratio, averaged over the last PWM period; band: all phases of the "
        "step within a PWM period."
    )
    lines = [
        Line(
            x="time_s",
            y="delivered_flow_m3_s",
            colour=Colour.LOAD,
            low="delivered_flow_lowest_m3_s",
            high="delivered_flow_highest_m3_s",
        )
    ]
    if "load_flow_m3_s" in rising.columns:
        lines.append(Line(x="time_s", y="load_flow_m3_s", colour=Colour.INLET, stroke=Stroke.DASHED))
        caption += (
            " Dashed: flow through the load, behind the load line, as it is at each instant; where the load pressure "
            "is below the precharge the accumulator takes nothing in, and this flow shows the switching."
        )
    begin = Level(value=0.0, upright=True, stroke=Stroke.DOTTED)
    panels = (Lines(table=name, lines=tuple(lines), label="flow", levels=(begin,)) for name in ("step_up", "step_down"))
    return Chart(
        name="step", caption=caption, table="step_up", panels=tuple(panels), side_by_side=True, share=True, height=2.6
    )


def _bode_chart(table: Table, pwm: float) -> Chart:
    return Chart(
        name="frequency-response",
        caption="Gain and phase of the delivered flow over a sinusoidal duty ratio, relative to the static gain; "
        "dotted: half the PWM frequency, beyond which no frequency can be distinguished from its mirror image. "
        "Near a third of "
        "the PWM frequency, left out, the second harmonic of the flow folds back onto the frequency itself.",
        table="frequency",
        panels=(
            _bode_panel(table, pwm, "gain_dB", "gain", (-6.0, 3.0)),
            _bode_panel(table, pwm, "phase_rad", "phase", (-0.25 * np.pi, np.pi / 12.0)),
        ),
        height=3.2,
    )


def _bode_panel(table: Table, pwm: float, ending: str, label: str, ends: tuple[float, float]) -> Lines:
    """Gain or phase of all flows over the frequency; `ends` of the axis give way to the values."""
    keys = [f"{name}_{ending}" for name in FLOWS if f"{name}_{ending}" in table.columns]
    values = np.concatenate([table[key] for key in keys])
    return Lines(
        lines=tuple(
            Line(x="frequency_Hz", y=key, label=words, colour=colour, stroke=stroke)
            for key, (words, colour, stroke) in zip(keys, FLOWS.values(), strict=False)
        ),
        label=label,
        levels=(Level(value=0.5 * pwm, upright=True, stroke=Stroke.DOTTED),),
        low=min(ends[0], 1.05 * float(values.min())),
        high=max(ends[1], 1.05 * float(values.max())),
        x_log=True,
    )


def _findings(stand: Stand, n: Mapping[str, float]) -> Iterator[Finding]:
    period, *times = (
        with_unit(value, TIME, 3)
        for value in (1.0 / n["pwm_frequency_Hz"], *(n[f"step_{name}"] for name in (
            "up_to_63_s", "up_settling_s", "down_to_63_s", "down_settling_s"
        )))
    )  # fmt: skip
    yield Finding(
        text=f"After the step up the delivered flow, averaged over a PWM period of {period}, has come 63 % of the way "
        f"after {times[0]} and stays within 5 % after {times[1]}; after the step down, {times[2]} and {times[3]}."
    )
    yield Finding(text=_gain_words(stand, n["static_gain_m3_s"]))
    if np.isfinite(n["bandwidth_3_dB_Hz"]):
        yield Finding(text=f"The gain falls below -3 dB at {with_unit(n['bandwidth_3_dB_Hz'], FREQUENCY, 3)}.")
    else:
        share = percent(n["highest_frequency_Hz"] / n["pwm_frequency_Hz"], 0)
        yield Finding(
            text=f"Up to {with_unit(n['highest_frequency_Hz'], FREQUENCY, 3)}, {share} of the PWM frequency, the gain "
            f"stays above -3 dB; it is {number(n['gain_at_highest_frequency'], 3)} there."
        )
    if n["load_line_time_constant_s"] > 0.0:
        lag = with_unit(n["load_line_time_constant_s"], TIME, 3)
        yield Finding(
            text="The load line with its accumulator lets the flow through the load follow with a time constant of "
            f"about {lag}."
        )


def _gain_words(stand: Stand, gain: float) -> str:
    """The static gain, and through an orifice why it is not that of a map at constant load pressure."""
    words = f"The static gain is {with_unit(gain, FLOW)} per unit of duty ratio"
    if not stand.makes_pressure:
        return f"{words}, at a load pressure that stays."
    flow = with_unit(stand.pump_flow(stand.set_point), FLOW)
    return (
        f"{words}, through an orifice that stays as it is: more flow raises the load pressure, which takes some of the "
        f"flow away again. At a constant load pressure it is about the pump flow, {flow}."
    )
