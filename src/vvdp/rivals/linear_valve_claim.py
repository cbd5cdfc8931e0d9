"""Claim: no linear on/off valve passes much flow at a small drop, switches fast and takes little power at once."""

from collections.abc import Callable

import numpy as np

from vvdp.base.display import number, with_unit
from vvdp.base.kinds import DURATION, EFFICIENCY, FLOW, FREQUENCY, MEAN_POWER, NUMBER, PRESSURE_DIFFERENCE
from vvdp.results.chart import Chart, Level, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Finding, Number, Table
from vvdp.rivals.claim import Claim
from vvdp.rivals.linear_valves import (
    VALVES,
    LinearValve,
    equal_loss_frequency,
    highest_frequency,
    rotary_drop,
    switched_loss,
    valves_for,
)
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import steady_states
from vvdp.steady.test_stand import Stand

FREQUENCIES = (25.0, 50.0, 100.0, 200.0, 300.0, 400.0)
"""Pulsed at these, as far as a valve reaches them [Hz]."""
UNKNOWN = [0.0], [float("nan")]
"""The curve of a valve whose drop the source does not show."""


def linear_valve_claim(stand: Stand, *, cores: int | None = None, say: Callable[[str], None] = quiet) -> Claim:
    """Published linear valves instead of the rotary one, at the stand's load pressure and duty ratio 0.5."""
    point = stand.set_point._replace(duty_ratio=0.5)
    known = [valve for valve in VALVES if np.isfinite(valve.drop)]
    sweeps = {valve.name: _sweep(stand, valve) for valve in known}
    (rotary,) = steady_states([(stand, point)], cores=cores, say=say)
    loss = float(rotary.summary.get("loss_total_W", np.nan))
    frequency = float(rotary.summary.get("pwm_frequency_Hz", np.nan))
    curves = {valve.name: (sweeps[valve.name][0], sweeps[valve.name][1]) for valve in known}
    valves, switching = _valve_table(stand, curves, loss, frequency), _sweep_table(stand, sweeps)
    numbers = {
        "rotary_valve_loss_W": Number(loss, MEAN_POWER, "loss with the rotary valve, duty ratio 0.5"),
        "rotary_valve_pwm_frequency_Hz": Number(frequency, FREQUENCY, "PWM frequency of the rotary valve"),
    }
    return Claim(
        tables={"linear_valves": valves, "linear_switching": switching},
        charts=(_chart(switching, loss, frequency),),
        numbers=numbers,
        findings=(Finding(text=_words(stand, valves, loss, frequency)),),
    )


Sweep = tuple[list[float], list[float], list[float]]
"""PWM frequencies [Hz], losses [W] and delivered flows [m^3/s]."""


def _sweep(stand: Stand, valve: LinearValve) -> Sweep:
    frequencies = [each for each in FREQUENCIES if each <= highest_frequency(valve)]
    found = [switched_loss(stand, valve.switching_time, each) for each in frequencies]
    return frequencies, [each.loss for each in found], [each.delivered for each in found]


def _valve_table(
    stand: Stand, curves: dict[str, tuple[list[float], list[float]]], loss: float, frequency: float
) -> Table:
    flow, drop = stand.pump_flow(stand.set_point), rotary_drop(stand)
    at_rotary = [float(np.interp(frequency, *curves.get(valve.name, UNKNOWN))) for valve in VALVES]
    equal = [equal_loss_frequency(*curves.get(valve.name, UNKNOWN), loss) for valve in VALVES]
    columns = {
        "valve": Column(np.array([valve.name for valve in VALVES]), None, "valve"),
        "rated_flow_m3_s": Column(np.array([valve.flow for valve in VALVES]), FLOW, "flow"),
        "rated_drop_Pa": Column(np.array([valve.drop for valve in VALVES]), PRESSURE_DIFFERENCE, "at a drop"),
        "switching_time_s": Column(np.array([valve.switching_time for valve in VALVES]), DURATION, "switches in"),
        "highest_pwm_frequency_Hz": Column(
            np.array([highest_frequency(valve) for valve in VALVES]), FREQUENCY, "full strokes up to"
        ),
        "parallel_valves": Column(
            np.array([valves_for(valve, flow, drop) for valve in VALVES]), NUMBER, "valves in parallel"
        ),
        "loss_W": Column(np.array(at_rotary), MEAN_POWER, "loss at the rotary's frequency"),
        "equal_loss_pwm_frequency_Hz": Column(np.array(equal), FREQUENCY, "break-even frequency"),
    }
    return Table(title="Published linear on/off valves", columns=columns)


def _sweep_table(stand: Stand, sweeps: dict[str, Sweep]) -> Table:
    rows = [(name, *row) for name, sweep in sweeps.items() for row in zip(*sweep, strict=True)]
    names, frequencies, losses, flows = (np.array(each) for each in zip(*rows, strict=True))
    columns = {
        "valve": Column(names, None, "valve"),
        "pwm_frequency_Hz": Column(frequencies, FREQUENCY, "PWM frequency"),
        "loss_W": Column(losses, MEAN_POWER, "loss"),
        "delivered_share": Column(flows / stand.pump_flow(stand.set_point), EFFICIENCY, "delivered flow / pump flow"),
    }
    return Table(title="Linear valves over the PWM frequency", columns=columns)


def _words(stand: Stand, table: Table, loss: float, frequency: float) -> str:
    told = [
        f"{table['valve'][row]}: {number(table['parallel_valves'][row], 3)} valves, "
        f"{with_unit(table['loss_W'][row], MEAN_POWER, 3)}"
        for row in range(table.rows)
        if np.isfinite(table["loss_W"][row])
    ]
    return (
        f"At {with_unit(frequency, FREQUENCY, 3)}, where the rotary valve loses {with_unit(loss, MEAN_POWER, 3)}, "
        f"linear valves that drop as much lose, what moves them left out: {'; '.join(told)}."
    )


def _chart(table: Table, loss: float, frequency: float) -> Chart:
    names = list(dict.fromkeys(table["valve"].tolist()))
    lines = tuple(
        Line(
            x="pwm_frequency_Hz",
            y="loss_W",
            label=name,
            rows=tuple(int(row) for row in np.flatnonzero(table["valve"] == name)),
            colour=colour,
            stroke=Stroke.MARKED,
        )
        for name, colour in zip(names, shades(len(names)), strict=True)
    )
    levels = [Level(value=loss, label="rotary valve")] if np.isfinite(loss) else []
    if np.isfinite(frequency):
        levels.append(Level(value=frequency, upright=True))
    return Chart(
        name="linear-valves",
        caption="Loss of published linear valves versus PWM frequency, enough in parallel for the same pressure drop "
        "as the rotary valve; dashed: that one, at its own frequency. What moves the spools is left out.",
        table="linear_switching",
        panels=(Lines(lines=lines, levels=tuple(levels), low=0.0, left=0.0, legend="valve"),),
        height=2.8,
    )
