"""At which spool speeds an axial sensor whose noise repeats itself with every turn can show the position."""

import time
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from vvdp.base import kinds
from vvdp.base.arrays import Array
from vvdp.base.display import number, plain, with_unit
from vvdp.base.kinds import Kind
from vvdp.estimation.observability import (
    FREEZE_BELOW,
    WARN_BELOW,
    check_noise,
    is_observable,
    margin_with_pressure,
    natural_frequency,
    numeric_grammian,
    observability_margin,
    rank,
    scaled_dynamics,
    unobservable_speeds,
)
from vvdp.evaluation.axial_plant import AxialPlant
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Finding, Grade, Result, Table, numbers_of

TURN = 2.0 * np.pi
SPOOL_SPEED = Kind("spool speed", "rad/s", 0.0, 1e5, "22.5 rev/s", units=kinds.SPEED_UNITS)
TURNS = Kind("turns of the spool per time", "rev/s", 0.0, 1e4, "22.5 rev/s", units=("rev/s",))
OTHER_HARMONICS = (1, 3, 10)
DRAWN, DRAWN_BESIDE = 600, 150
"""Spool speeds of the curves; those by quadrature have fewer."""
LEAST_DRAWN = 1e-5
KNOWN_RATE = 2.0
"""The margin of a position whose velocity is known: (2/T) times the integral of 1 over a turn."""
MANNER = (
    "The position is measured with a noise that may be any sum of the first harmonics of the spool's turn. The margin "
    "is what the Grammian over one turn then leaves of the plant without damping: the smallest eigenvalue of "
    "(2/T)(Psi - (2/T) L L'), with the velocity divided by the natural frequency. 1 is as good as without the noise, "
    "0 is lost."
)
LEFT_OUT = (
    "How large the noise is: the margin says how well it can be distinguished from the position, not how far "
    "off one is.",
    "More turns than one: they add up in an observer, but for what is lost in each.",
    "A noise that changes with the position.",
)
QUANTITIES: dict[str, tuple[Kind, str]] = {
    "observability_margin": (kinds.RATIO, "observability margin"),
    "observable": (kinds.FLAG, "observable"),
    "natural_frequency_Hz": (kinds.FREQUENCY, "natural frequency"),
    "spool_speed_rad_s": (SPOOL_SPEED, "spool speed"),
    "harmonics": (kinds.COUNT, "harmonics of the noise"),
    "observable_states": (kinds.COUNT, "rank of the Grammian"),
    "states": (kinds.COUNT, "states of plant and noise"),
    "mass_kg": (kinds.MASS, "moved mass"),
    "stiffness_N_m": (kinds.STIFFNESS, "stiffness"),
    "damping_N_s_m": (kinds.VISCOUS_FRICTION, "viscous friction"),
    "observability_margin_damped": (kinds.RATIO, "margin with the friction"),
    "observability_margin_with_pressure": (kinds.RATIO, "margin with measured pressure"),
}


class Margins(NamedTuple):
    """The tables of the margin: over spool speed, beside it, unobservable speeds, and stretches below a limit."""

    margin: Table
    beside: Table
    lost: Table
    windows: Table


class Window(NamedTuple):
    """A stretch of spool speeds [rad/s] in which the margin is below a limit."""

    limit: float
    low: float
    high: float


def observability(name: str, moved: AxialPlant, spool_speed: float, harmonics: int) -> Result:
    """How well what moves in the system `name` is seen at a spool speed [rad/s] under a noise of so many harmonics.

    Raises ParameterError where speed or harmonics cannot be.

    Source  wang2017, section 5.5 and appendix A, corrected; the margin is ours, docs/models/observability.md
    """
    began = time.perf_counter()
    check_noise(spool_speed, harmonics)
    numbers = _numbers(moved, spool_speed, harmonics)
    gamma = TURN * numbers["natural_frequency_Hz"]
    speeds = _speeds(gamma, spool_speed, harmonics)
    tables = Margins(
        margin=_margins(moved, gamma, speeds, harmonics),
        beside=_margins_beside(moved, gamma, np.linspace(speeds[0], speeds[-1], DRAWN_BESIDE), harmonics),
        lost=_lost_table(gamma, harmonics),
        windows=_windows_table(_windows(moved, gamma, speeds, harmonics)),
    )
    return Result(
        verb="observability",
        title="Observability of the position under a periodic noise",
        system=name,
        manner=MANNER,
        references=("wang2017",),
        conditions=_conditions(moved, spool_speed, harmonics),
        left_out=LEFT_OUT,
        tables=tables._asdict(),
        charts={"margin-over-speed": _chart(tables, gamma, harmonics)},
        numbers=numbers_of(numbers, QUANTITIES),
        findings=tuple(_findings(moved, numbers, tables)),
        seconds=time.perf_counter() - began,
    )


def _margin(moved: AxialPlant, gamma: float, spool_speed: float, harmonics: int) -> float:
    return observability_margin(gamma, spool_speed, harmonics) if moved.plant else KNOWN_RATE


def _numbers(moved: AxialPlant, spool_speed: float, harmonics: int) -> dict[str, float]:
    """Margin, rank and plant at one speed."""
    gamma = natural_frequency(moved.plant) if moved.plant else 0.0
    rates = np.zeros((1, 1))
    if moved.plant:
        rates = scaled_dynamics(moved.plant._replace(damping=0.0), spool_speed)
    found = {
        "observability_margin": _margin(moved, gamma, spool_speed, harmonics),
        "observable": float(is_observable(gamma, spool_speed, harmonics)),
        "natural_frequency_Hz": gamma / TURN,
        "spool_speed_rad_s": spool_speed,
        "harmonics": float(harmonics),
        "observable_states": float(rank(numeric_grammian(rates, spool_speed, harmonics))),
        "states": float(len(rates) + 2 * harmonics),
    }
    if moved.plant:
        found |= {
            "mass_kg": moved.plant.mass,
            "stiffness_N_m": moved.plant.stiffness,
            "damping_N_s_m": moved.plant.damping,
            "observability_margin_damped": margin_with_pressure(moved.plant, spool_speed, harmonics),
        }
        if moved.chambers:
            found["observability_margin_with_pressure"] = _margin_with_pressure(moved, harmonics, spool_speed)
    return found


def _margin_with_pressure(moved: AxialPlant, harmonics: int, spool_speed: float) -> float:
    assert moved.plant is not None
    undamped = moved.plant._replace(damping=0.0)
    return margin_with_pressure(undamped, spool_speed, harmonics, moved.oil_stiffnesses)


def _conditions(moved: AxialPlant, spool_speed: float, harmonics: int) -> dict[str, str]:
    found = {
        "spool speed": with_unit(spool_speed, SPOOL_SPEED),
        "noise": f"{harmonics} harmonics" if harmonics > 1 else "1 harmonic",
        "moved": moved.name + ("" if moved.plant else ", its velocity known"),
    }
    if moved.plant:
        for word, value, kind in zip(
            ("mass", "stiffness", "friction"), moved.plant, (kinds.MASS, kinds.STIFFNESS, kinds.VISCOUS_FRICTION),
            strict=True,
        ):  # fmt: skip
            found[word] = with_unit(value, kind)
    for chamber, stiffness in zip(moved.chambers, moved.oil_stiffnesses, strict=True):
        found[f"oil in {chamber}"] = with_unit(stiffness, kinds.STIFFNESS)
    return found


def _speeds(gamma: float, spool_speed: float, harmonics: int) -> Array:
    """Spool speeds to be drawn [rad/s]: among them the chosen one, the lost ones, and one between any two of these."""
    low = min(0.6 * gamma / harmonics, 0.5 * spool_speed) if gamma > 0.0 else 0.1 * spool_speed
    high = max(2.2 * gamma, 1.3 * spool_speed)
    lost = unobservable_speeds(gamma, max(harmonics, *OTHER_HARMONICS))
    lost = lost[lost > low]
    return np.unique([*np.linspace(low, high, DRAWN), *lost, *(0.5 * (lost[1:] + lost[:-1])), spool_speed])


def _windows(moved: AxialPlant, gamma: float, speeds: Array, harmonics: int) -> Iterator[Window]:
    """Where the margin is below both limits, the ends to rounding."""
    from scipy.optimize import brentq

    margins = np.array([_margin(moved, gamma, omega, harmonics) for omega in speeds])
    for limit in (WARN_BELOW, FREEZE_BELOW):
        above = partial(_above, moved, gamma, harmonics, limit)
        below = margins < limit
        ends = [float(brentq(above, speeds[i], speeds[i + 1])) for i in np.flatnonzero(np.diff(below.astype(float)))]
        ends = [*([speeds[0]] if below[0] else []), *ends, *([speeds[-1]] if below[-1] else [])]
        yield from (Window(limit, low, high) for low, high in zip(ends[::2], ends[1::2], strict=True))


def _above(moved: AxialPlant, gamma: float, harmonics: int, limit: float, spool_speed: float) -> float:
    return _margin(moved, gamma, spool_speed, harmonics) - limit


def _windows_table(windows: Iterator[Window]) -> Table:
    rows = np.array([*windows], float).reshape(-1, 3)
    return Table(
        title="Spool speeds with a margin below the limits",
        columns={
            "limit": Column(rows[:, 0], kinds.RATIO, "margin below"),
            "low_rad_s": Column(rows[:, 1], SPOOL_SPEED, "from"),
            "high_rad_s": Column(rows[:, 2], SPOOL_SPEED, "to"),
        },
        note="Below 0.01 an observer is uncertain, below 0.001 it should keep its last estimate of the noise. A "
        "window that ends with the speeds that are drawn may go on beyond.",
    )


def _lost_table(gamma: float, harmonics: int) -> Table:
    speeds = unobservable_speeds(gamma, harmonics)
    return Table(
        title="Lost spool speeds",
        columns={
            "harmonic": Column(np.arange(1.0, len(speeds) + 1.0), kinds.COUNT, "harmonic"),
            "speeds_rev_s": Column(speeds / TURN, TURNS, "spool speed"),
        },
        note=(
            "A harmonic of the noise has the natural frequency there; position and velocity cannot be "
            "distinguished from it."
        ),
    )


def _margins(moved: AxialPlant, gamma: float, speeds: Array, harmonics: int) -> Table:
    """The margin over spool speed with several numbers of harmonics."""
    found = {
        f"with_{k}_harmonics": Column(
            np.array([_margin(moved, gamma, omega, k) for omega in speeds]), kinds.RATIO, f"margin, harmonics: {k}"
        )
        for k in sorted({*OTHER_HARMONICS, harmonics})
    }
    speed = Column(speeds, SPOOL_SPEED, "spool speed")
    return Table(title="Margin over spool speed", columns={"speed_rad_s": speed, **found}, is_data=True)


def _margins_beside(moved: AxialPlant, gamma: float, speeds: Array, harmonics: int) -> Table:
    """The margin over spool speed with the friction, and with measured pressure."""
    columns = {"speed_rad_s": Column(speeds, SPOOL_SPEED, "spool speed")}
    if moved.plant and moved.plant.damping > 0.0:
        damped = [margin_with_pressure(moved.plant, omega, harmonics) for omega in speeds]
        columns["damped"] = Column(np.array(damped), kinds.RATIO, "margin with the friction")
    if moved.chambers:
        measured = [_margin_with_pressure(moved, harmonics, omega) for omega in speeds]
        columns["with_pressure"] = Column(np.array(measured), kinds.RATIO, "margin with measured pressure")
    return Table(title="Margin with friction and with measured pressure", columns=columns, is_data=True)


def _chart(tables: Margins, gamma: float, harmonics: int) -> Chart:
    keys = [key for key in tables.margin.columns if key != "speed_rad_s"]
    chosen, x = f"with_{harmonics}_harmonics", "speed_rad_s"
    several = tuple(
        Line(x=x, y=key, label=key.split("_")[1], colour=colour, width=2.0 if key == chosen else 1.1)
        for key, colour in zip(keys, shades(len(keys)), strict=True)
    )
    beside = [Line(x=x, y=chosen, label="position alone", colour=Colour.LOAD)]
    styles = {
        "damped": ("position, with friction", Colour.RELIEF),
        "with_pressure": ("position and pressure", Colour.GREEN),
    }
    beside += [
        Line(x=x, y=key, label=label, colour=colour, table="beside")
        for key, (label, colour) in styles.items()
        if key in tables.beside.columns
    ]
    lost = tuple(
        Level(value=float(omega), upright=True, colour=Colour.FAINT, stroke=Stroke.DOTTED)
        for omega in unobservable_speeds(gamma, harmonics)
    )
    limits = (
        Level(value=WARN_BELOW, label="warn", colour=Colour.INLET),
        Level(value=FREEZE_BELOW, label="freeze", colour=Colour.RED),
    )
    panel = partial(Lines, label="margin", levels=limits + lost, low=LEAST_DRAWN, high=3.0, y_log=True)
    panels = (panel(lines=several, legend="harmonics"), panel(lines=tuple(beside), legend="measured"))
    below = (
        f" Below: {harmonics} harmonics, the position alone, with friction of the plant, and with measured pressure."
    )
    return Chart(
        name="margin-over-speed",
        caption="Observability margin over spool speed, with several numbers of harmonics in the noise. Upright: lost "
        f"speeds.{below if len(beside) > 1 else ''}",
        table="margin",
        panels=panels if len(beside) > 1 else panels[:1],
        height=5.0 if len(beside) > 1 else 3.0,
    )


def _findings(moved: AxialPlant, numbers: dict[str, float], tables: Margins) -> Iterator[Finding]:
    margin, speed = numbers["observability_margin"], with_unit(numbers["spool_speed_rad_s"], SPOOL_SPEED)
    if margin < WARN_BELOW:
        fails = margin < FREEZE_BELOW
        yield Finding(
            text=f"At {speed} the margin is {number(margin, 2)}: "
            + ("the sensor scheme fails." if fails else "an observer is uncertain."),
            grade=Grade.BAD if fails else Grade.WARNING,
            title="Position hidden by the noise",
            remedy="Turn the spool at another speed, or measure the chamber's pressure as well.",
        )
    else:
        yield Finding(text=f"At {speed} the margin is {number(margin, 3)}.", grade=Grade.GOOD)
    turns = tables.lost["speeds_rev_s"]
    if not turns.size:
        yield Finding(text="Nothing draws the position back, so that no spool speed loses it.")
        return
    yield Finding(text=f"Position and velocity are lost at {', '.join(plain(f, 4) for f in turns)} rev/s.")
    for limit, words in ((WARN_BELOW, "uncertain"), (FREEZE_BELOW, "the scheme fails")):
        yield Finding(text=f"The margin is below {limit:g} ({words}) {_stretches(tables.windows, limit)}.")
    if "with_pressure" in tables.beside.columns:
        least = float(tables.beside["with_pressure"].min())
        yield Finding(text=f"With measured pressure it is at least {number(least, 2)} at all these speeds.")


def _stretches(windows: Table, limit: float) -> str:
    places = np.flatnonzero(windows["limit"] == limit)
    ends = [[plain(windows[key][i] / TURN, 4) for key in ("low_rad_s", "high_rad_s")] for i in places]
    return "at " + ", ".join(f"{low} to {high}" for low, high in ends) + " rev/s" if ends else "nowhere"
