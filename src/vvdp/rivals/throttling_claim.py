"""Claim: the PWM valve loses less than throttling the same pump to the same flow."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import display_unit, percent, with_unit
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import DUTY_RATIO, EFFICIENCY, FLOW, GAUGE_PRESSURE, MEAN_POWER, Kind
from vvdp.hydraulics.pump import pump_friction_power
from vvdp.hydraulics.supply_losses import bled_off_loss, metered_loss
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table, numbers_of, sentences
from vvdp.results.verdict import Statement, bound_statement
from vvdp.rivals.claim import Claim
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import Stand

DUTY_RATIOS = (0.15, 0.25, 0.35, 0.5, 0.65, 0.75, 0.85, 1.0)
PRESSURE_SHARES = (0.4, 0.6, 0.8)
"""Load pressures, over the relief setting."""


@dataclass(frozen=True)
class Throttling:
    """Losses of the PWM valve and of throttling the same pump at the same delivered flow and load pressure."""

    load_pressure: Array  # gauge [Pa]
    duty_ratio: Array
    delivered: Array  # [m^3/s]
    share: Array  # of the pump flow [1]
    switched: Array  # [W]
    metered: Array  # [W]
    bled_off: Array  # [W]


def against_throttling(
    stand: Stand,
    duty_ratios: Sequence[float] = DUTY_RATIOS,
    pressure_shares: Sequence[float] = PRESSURE_SHARES,
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Throttling:
    """Loss of the PWM valve, simulated, beside two ways of throttling the same pump to the same flow.

    The pump turns as fast in all three, so its friction T_f |omega| is in all of them.

    Source  wang2017, chapter 1
    """
    here = stand.set_point
    rise = stand.relief_pressure - stand.tank_pressure
    points = [
        here._replace(duty_ratio=float(d), load_pressure=float(stand.tank_pressure + share * rise))
        for share in pressure_shares
        for d in duty_ratios
    ]
    states = _with_periodic_state(steady_states([(stand, p) for p in points], cores=cores, say=say))
    flow, friction = stand.pump_flow(here), pump_friction_power(here.pump_speed, stand.bench.pump)
    delivered = np.array([float(state.summary["mean_load_flow_m3_s"]) for state in states])
    load = np.array([state.point.load_pressure - stand.tank_pressure for state in states])
    loss = np.array([float(state.summary["loss_total_W"]) for state in states])
    return Throttling(
        load_pressure=np.array([state.point.load_pressure - stand.reference for state in states]),
        duty_ratio=np.array([state.point.duty_ratio for state in states]),
        delivered=delivered,
        share=delivered / flow,
        switched=loss,
        metered=np.array([metered_loss(flow, q, p, rise) for q, p in zip(delivered, load, strict=True)]) + friction,
        bled_off=np.array([bled_off_loss(flow, q, p) for q, p in zip(delivered, load, strict=True)]) + friction,
    )


def _with_periodic_state(states: Sequence[Steady]) -> list[Steady]:
    """Those that have a periodic state. Raises ParameterError where none has."""
    found = [state for state in states if state.reason is None]
    if not found:
        raise ParameterError(f"no operating point has a steady state; the first: {states[0].reason}")
    return found


def break_even_share(share: Array, switched: Array, throttled: Array) -> float:
    """Delivered share above which the PWM valve loses more than throttling [1]; nan where it never does.

    By straight lines between rows; 0 where it always loses more.
    """
    gain = throttled - switched
    if gain[-1] >= 0.0:
        return np.nan
    better = np.flatnonzero(gain > 0.0)
    if not better.size:
        return 0.0
    k = int(better[-1])
    return float(share[k] + (share[k + 1] - share[k]) * gain[k] / (gain[k] - gain[k + 1]))


def throttling_claim(stand: Stand, *, cores: int | None = None, say: Callable[[str], None] = quiet) -> Claim:
    """The comparison with throttling, and the share of the pump flow up to which the PWM valve loses less."""
    found = against_throttling(stand, cores=cores, say=say)
    saving = 1.0 - found.switched / found.metered
    numbers = {"least_saving_over_metering": float(saving.min()), "largest_saving_over_metering": float(saving.max())}
    quantities: dict[str, tuple[Kind, str]] = {
        "least_saving_over_metering": (EFFICIENCY, "least saving over metering at the relief setting"),
        "largest_saving_over_metering": (EFFICIENCY, "largest saving over metering at the relief setting"),
    }
    words = [
        f"Against metering at the relief setting the PWM valve loses {percent(float(saving.min()), 0)} to "
        f"{percent(float(saving.max()), 0)} less, over all points."
    ]
    for key, pressure, even in _break_evens(found):
        numbers[key] = even
        quantities[key] = (
            EFFICIENCY,
            f"share of the pump flow up to which it loses less than bleeding off, {pressure}",
        )
        words.append(_break_even_words(pressure, even))
    return Claim(
        tables={"throttling": _table(found)},
        charts=(_chart(found),),
        numbers=numbers_of(numbers, quantities),
        findings=tuple(sentences(words)),
        statements=(("section-1.1", _statement(float(saving.min()))),),
    )


def _table(found: Throttling) -> Table:
    return Table(
        title="PWM valve and throttling",
        columns={
            "load_pressure_Pa": Column(found.load_pressure, GAUGE_PRESSURE, "load pressure"),
            "duty_ratio": Column(found.duty_ratio, DUTY_RATIO, "duty ratio"),
            "delivered_flow_m3_s": Column(found.delivered, FLOW, "delivered flow"),
            "delivered_share": Column(found.share, EFFICIENCY, "over pump flow"),
            "loss_switched_W": Column(found.switched, MEAN_POWER, "loss, PWM valve"),
            "loss_metered_W": Column(found.metered, MEAN_POWER, "loss, metered at relief setting"),
            "loss_bled_off_W": Column(found.bled_off, MEAN_POWER, "loss, bled off at load pressure"),
        },
        axes=("load_pressure_Pa", "duty_ratio"),
    )


def _statement(saving: float) -> Statement:
    return bound_statement(
        "least saving over metering from a fixed pump",
        saving,
        EFFICIENCY,
        low=0.0,
        source="throttle-less control of a fixed pump",
    )


def _break_evens(found: Throttling) -> Iterator[tuple[str, str, float]]:
    """For each load pressure a key, the pressure in words, and the share at which both ways lose as much."""
    for pressure in np.unique(found.load_pressure):
        rows = found.load_pressure == pressure
        even = break_even_share(found.share[rows], found.switched[rows], found.bled_off[rows])
        level = round(display_unit(GAUGE_PRESSURE).from_si(pressure))
        yield f"break_even_share_at_{level}_bar", f"{level} bar", even


def _break_even_words(pressure: str, even: float) -> str:
    if even == 0.0:
        return f"At {pressure} it loses more than bleeding off at load pressure would, at every flow."
    if not np.isfinite(even):
        return f"At {pressure} it loses less than bleeding off at load pressure at every flow."
    return (
        f"At {pressure} it loses less than bleeding off at load pressure up to {percent(even, 0)} of the pump flow, "
        "more above."
    )


def _chart(found: Throttling) -> Chart:
    panels = []
    for level in np.unique(found.load_pressure):
        rows = tuple(int(row) for row in np.flatnonzero(found.load_pressure == level))
        lines = (
            Line(
                x="delivered_flow_m3_s", y=f"loss_{name}_W", label=label, rows=rows, colour=colour, stroke=Stroke.MARKED
            )
            for name, label, colour in (
                ("metered", "metered", Colour.RELIEF),
                ("bled_off", "bled off", Colour.TANK),
                ("switched", "PWM valve", Colour.INLET),
            )
        )
        title = f"load {with_unit(float(level), GAUGE_PRESSURE)}"
        panels.append(Lines(lines=tuple(lines), label="power lost", title=title, low=0.0, left=0.0))
    return Chart(
        name="throttling-losses",
        caption="Power lost at three load pressures by the PWM valve, by metering at the relief setting and by "
        "bleeding off at load pressure without any further drop, the least that throttling can lose.",
        table="throttling",
        panels=tuple(panels),
        side_by_side=True,
        share=True,
        height=2.7,
    )
