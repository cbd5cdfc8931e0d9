"""Sections 4.1 and 4.2: the drive's map, the periodic sensor error of the sensor, functions that describe it, and
its models.
"""

import math
from functools import cache
from typing import Any

import numpy as np

import vvdp
from vvdp.base.arrays import Array
from vvdp.base.kinds import (
    ANGLE,
    COUNT,
    DURATION,
    FLOW,
    FREQUENCY,
    NUMBER,
    POSITION,
    POWER,
    PRESSURE_DIFFERENCE,
    RATIO,
    SIGNED_FRACTION,
)
from vvdp.estimation.noise_basis import NoiseBasis, fourier_basis, function_count, gaussian_basis, write_basis
from vvdp.hydraulics.gerotor_drive import gerotor_flow
from vvdp.reproduction.chapter_4.gerotor import STROKE
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.chart import Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import (
    Statement,
    bound_statement,
    digit_statement,
    drawing_statement,
    exact_statement,
    number_statement,
)
from vvdp.sensing.axial_sensor import Pollution, pollution_at

TURN = 2.0 * np.pi
POINTS, BELL_WIDTH = 720, TURN / 6.0
SHAPE = "the periodic sensor error's shape, of which five harmonics are assumed"
SYSTEM = "axial-gerotor"
ROUNDING = "rounding"


@cache
def _network() -> Any:
    return vvdp.load(SYSTEM).circuit.network


def pollution() -> Pollution:
    """That of the shipped sensor."""
    found: Pollution = _network().programs["drive_sensor"].settings.near
    return found


def turn_angles(turns: float = 1.0) -> Array:
    """Angles over so many turns [rad]."""
    found: Array = np.linspace(0.0, turns * TURN, int(turns * POINTS), endpoint=False)
    return found


def pollution_over(angles: Array) -> Array:
    """Periodic sensor error at these angles [m]."""
    shape = pollution()
    return np.array([pollution_at(float(angle), shape) for angle in angles])


def figure_4_2() -> Reproduction:
    """The sensor's output while the spool spins at a stop."""
    angles = turn_angles(2.0)
    values = pollution_over(angles)
    columns = {
        "angle_rad": Column(angles, ANGLE, "angle of the spool"),
        "shown_m": Column(values, POSITION, "position shown at a stop"),
    }
    half = values.size // 2
    return figure_of(
        "figure-4.2",
        "What the optical sensor shows over two turns while the spool spins at a stop.",
        {"pollution": Table(title="Pollution", columns=columns, axes=("angle_rad",), is_data=True)},
        (
            bound_statement(
                "mean over a turn, over its swing",
                abs(float(values[:half].mean())) / float(np.ptp(values)),
                RATIO,
                high=1e-9,
                source="zero mean",
                because=ROUNDING,
            ),
            bound_statement(
                "difference of two turns, over its swing",
                float(np.abs(values[:half] - values[half:]).max() / np.ptp(values)),
                RATIO,
                high=1e-9,
                source="periodic",
                because=ROUNDING,
            ),
        ),
        over("angle_rad", "shown_m"),
        height=2.2,
    )


def figure_4_3() -> Reproduction:
    """Flow of the gerotor pump over its command."""
    _, drive = _network().parts["drive_gerotor"].values
    commands: Array = np.linspace(-1.0, 1.0, 401)
    flows = np.array([gerotor_flow(float(u), drive) for u in commands])
    still = commands[np.abs(flows) < 1e-9 * np.abs(flows).max()]
    columns = {
        "command": Column(commands, SIGNED_FRACTION, "command"),
        "flow_m3_s": Column(flows, FLOW, "flow"),
    }
    return figure_of(
        "figure-4.3",
        "Flow of the gerotor pump over its command.",
        {"map": Table(title="Map", columns=columns, axes=("command",), is_data=True)},
        (
            bound_statement(
                "width of the dead band",
                float(np.ptp(still)),
                RATIO,
                low=0.01,
                source="a dead band",
                assumption="its width, 0.14 of a full command to either side",
            ),
            bound_statement(
                "largest flow backward over forward",
                float(-flows.min() / flows.max()),
                RATIO,
                high=0.99,
                source="asymmetry",
                assumption="0.9",
            ),
        ),
        over("command", "flow_m3_s", label="flow"),
    )


def rows_of(basis: NoiseBasis, angles: Array) -> Array:
    """The functions of a basis at angles, (angles, functions)."""
    rows: Array = np.zeros((angles.size, function_count(basis)))
    for row, angle in zip(rows, angles, strict=True):
        write_basis(float(angle), basis, row, 0)
    return rows


def best_fit(basis: NoiseBasis, angles: Array, values: Array) -> Array:
    """The combination of the functions that is closest to values."""
    rows = rows_of(basis, angles)
    found: Array = rows @ np.linalg.lstsq(rows, values, rcond=None)[0]
    return found


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def figure_4_4() -> Reproduction:
    """The periodic sensor error described by six functions of either kind."""
    angles = turn_angles()
    values = pollution_over(angles)
    fourier = best_fit(fourier_basis(3), angles, values)
    bells = best_fit(gaussian_basis(6, BELL_WIDTH), angles, values)
    columns = {
        "angle_rad": Column(angles, ANGLE, "angle of the spool"),
        "true_m": Column(values, POSITION, "pollution"),
        "fourier_m": Column(fourier, POSITION, "6 Fourier functions"),
        "bells_m": Column(bells, POSITION, "6 bells"),
    }
    return figure_of(
        "figure-4.4",
        "The periodic sensor error of a turn, and the best that six functions of either kind make of it.",
        {"fits": Table(title="Fits", columns=columns, axes=("angle_rad",), is_data=True)},
        (
            bound_statement(
                "rms of what bells leave over that of Fourier functions",
                rms(bells - values) / rms(fourier - values),
                RATIO,
                high=1.0,
                source="the Gaussian model is slightly better",
                assumption=SHAPE,
            ),
        ),
        over("angle_rad", "true_m", "fourier_m", "bells_m", label="pollution"),
    )


def figure_4_5() -> Reproduction:
    """The functions themselves."""
    angles = turn_angles()
    fourier, bells = rows_of(fourier_basis(3), angles), rows_of(gaussian_basis(6, BELL_WIDTH), angles)
    columns = {"angle_rad": Column(angles, ANGLE, "angle of the spool")}
    for kind, rows in (("fourier", fourier), ("bell", bells)):
        for k in range(rows.shape[1]):
            columns[f"{kind}_{k + 1}"] = Column(rows[:, k], NUMBER, f"{k + 1}")
    panels = tuple(
        over("angle_rad", *(f"{kind}_{k + 1}" for k in range(rows.shape[1])), label=label, width=0.9)
        for kind, rows, label in (("fourier", fourier, "Fourier"), ("bell", bells, "Gaussian"))
    )
    return figure_of(
        "figure-4.5",
        "Six Fourier functions and six bells.",
        {"bases": Table(title="Basis functions", columns=columns, axes=("angle_rad",), is_data=True)},
        (drawing_statement("basis functions", "six of either kind, the bells without their means"),),
        *panels,
        height=4.0,
    )


COUNTS = (2, 4, 6, 8, 10, 20, 40)
SCATTER = 20e-6
"""Of the sensor's white noise [m]."""
MEASURED_TURNS = 4.0


def figure_4_6() -> Reproduction:
    """The periodic sensor error of some noisy turns described by 10, 20 and 40 Fourier functions."""
    angles = turn_angles(MEASURED_TURNS)
    values = pollution_over(angles) + np.random.default_rng(0).normal(0.0, SCATTER, angles.size)
    left = [rms(best_fit(fourier_basis(count // 2), angles, values) - values) for count in COUNTS]
    with_10, with_20, with_40 = left[-3:]
    columns = {
        "count": Column(np.array(COUNTS, float), COUNT, "functions"),
        "left_m": Column(np.array(left), POSITION, "what is left, rms"),
    }
    return figure_of(
        "figure-4.6",
        "What 2 to 40 Fourier functions leave of the periodic sensor error, with white noise of 20 um.",
        {"counts": Table(title="Number of functions", columns=columns, axes=("count",))},
        (
            bound_statement(
                "what 40 functions leave over what 20 leave",
                with_40 / with_20,
                RATIO,
                high=1.0,
                source="40 functions have the least error",
            ),
            bound_statement(
                "what 20 functions leave over what 10 leave",
                with_20 / with_10,
                RATIO,
                low=0.9,
                source="no significant difference between 10 and 20",
                assumption=SHAPE,
            ),
        ),
        over("count", "left_m", stroke=Stroke.MARKED, label="left, rms", y_log=True),
        height=2.2,
    )


def equation_4_12() -> Reproduction:
    """The Grammian of position and ten Fourier functions over a turn of 0.1 s."""
    T = 0.1
    times: Array = np.arange(1000.0) * 1e-4
    rows = np.column_stack([np.ones(times.size), rows_of(fourier_basis(5), TURN * times / T)])
    M = rows.T @ rows * 1e-4
    return Reproduction(
        statements=(
            exact_statement(
                "first entry",
                1.0,
                float(M[0, 0]),
                DURATION,
                inconsistency="the integral of 1 over a turn is T",
                contradiction=("(4.12): M₁₁ = 1", "(4.11): the integral over T"),
                source="1",
            ),
            exact_statement(
                "determinant, 1e-15",
                1e15 * (0.5 * T) ** 10,
                1e15 * float(np.linalg.det(M)),
                NUMBER,
                inconsistency="T (T/2)^n",
                contradiction=("(4.12): det M = (T/2)^n", "(4.11): the integral over T"),
            ),
        )
    )


def section_4_1() -> Reproduction:
    """Pressure and hydraulic power of the drive."""
    run = vvdp.load(SYSTEM).run(until="8 s")
    series = run.to_pandas()
    drop = np.abs(series["outputs.drive_gerotor_pressure_difference_Pa"].to_numpy())
    power = drop * np.abs(series["states.drive_gerotor.flow_m3_s"].to_numpy())
    return Reproduction(
        statements=(
            bound_statement(
                "largest pressure over the pump",
                drop.max(),
                PRESSURE_DIFFERENCE,
                high=2.76e5,
                source="less than 2.76 bar",
                assumption="the spool's friction and the passages",
            ),
            bound_statement("largest hydraulic power", power.max(), POWER, high=200.0, source="below 200 W"),
        )
    )


def _period_samples() -> tuple[Statement, ...]:
    """The samples that a period of 10 Hz has, of which a lumped model takes a state each (4.2.2)."""
    return tuple(
        number_statement(
            f"samples of a period of 10 Hz at {1e3 * interval:g} ms, N",
            printed,
            1.0 / (10.0 * interval),
            COUNT,
            tolerance=0.5,
            because="a whole number",
        )
        for interval, printed in ((2e-3, 50.0), (1e-3, 100.0))
    )


def section_4_2() -> Reproduction:
    """The speed of the spool with 40 lpm, and the stroke."""
    spool = vvdp.load("prototype-constant-load").run(until="0.6 s").number("pwm_frequency_Hz") / 3.0
    helix = vvdp.load("prototype-constant-load").case.params.valve.helix_length
    return Reproduction(
        statements=(
            digit_statement(
                "speed of the spool with 40 lpm",
                13.0,
                spool,
                FREQUENCY,
                tolerance=0.5,
                note="oil of 27 °C would give 13 Hz, by the balance of torques; section 2.5 has 24 Hz",
            ),
            exact_statement("stroke of the duty ratio, from (4.16)", STROKE, helix, POSITION, source="0.8 in"),
            *_period_samples(),
            exact_statement(
                "period of 10 Hz as 1/(2π ω), as printed in 4.3.2",
                1.0 / (TURN * TURN * 10.0),
                TURN / (TURN * 10.0),
                DURATION,
                inconsistency="T = 2π/ω",
            ),
        )
    )


def equation_4_9() -> Reproduction:
    """Bells beside the position: whether their mean competes with it."""
    angles = turn_angles()
    condition = {}
    for name, rows in (
        ("Fourier", rows_of(fourier_basis(3), angles)),
        ("bells as printed", rows_of(gaussian_basis(6, BELL_WIDTH), angles) + _bell_mean()),
        ("bells without their means", rows_of(gaussian_basis(6, BELL_WIDTH), angles)),
    ):
        both = np.column_stack([np.ones(angles.size), rows])
        condition[name] = float(np.linalg.cond(both.T @ both))
    return Reproduction(
        statements=(
            number_statement(
                "condition of the Grammian with Fourier functions",
                2.0,
                condition["Fourier"],
                NUMBER,
                share=1e-6,
                because=ROUNDING,
                source="T and T/2",
            ),
            bound_statement(
                "the same with bells as printed",
                condition["bells as printed"],
                NUMBER,
                high=100.0,
                source="any basis will do",
                because="two digits lost (ours)",
                inconsistency="a bell has a mean, which competes with the position",
            ),
        )
    )


def _bell_mean() -> float:
    """The mean that `gaussian_basis` takes off each bell."""
    z = turn_angles() - math.pi
    return float(np.mean(np.exp(-((z / BELL_WIDTH) ** 2))))


ITEMS = (
    Item(ItemKind.FIGURE, "4.2", "Sensor output at a fixed axial position", figure_4_2),
    Item(ItemKind.FIGURE, "4.3", "Control input and gerotor pump flow", figure_4_3),
    Item(ItemKind.FIGURE, "4.4", "A periodic signal by different basis functions", figure_4_4),
    Item(ItemKind.FIGURE, "4.5", "Fourier and Gaussian basis functions", figure_4_5),
    Item(ItemKind.FIGURE, "4.6", "Sensitivity to the number of basis functions", figure_4_6),
    Item(ItemKind.EQUATION, "4.9", "Gaussian basis", equation_4_9),
    Item(ItemKind.EQUATION, "4.12", "Grammian of the periodic model", equation_4_12),
    Item(ItemKind.SECTION, "4.1", "Pressure and power of the drive", section_4_1),
    Item(ItemKind.SECTION, "4.2", "Speed of the spool, stroke, period", section_4_2),
)
