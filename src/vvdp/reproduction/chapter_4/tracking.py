"""Section 4.5: the spool under the estimators of chapter 4, in simulation and as the experiment has it."""

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import FRACTION, FREQUENCY, NUMBER, POSITION, RATIO, SIGNED_FRACTION, TIME
from vvdp.reproduction.chapter_4.gerotor import (
    CONSTANT,
    GENERATOR,
    IDEAL,
    LUMPED,
    NOISY,
    OFF_BY_HALF,
    Samples,
    experiment,
    late,
    peak,
)
from vvdp.reproduction.chapter_4.noise import rms
from vvdp.reproduction.drawings import circuit_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, digit_statement

DRIVE = "dead band, lag and periodic sensor error of the drive are in no table of the text"
POLLUTION = "amplitudes of the periodic sensor error's harmonics"


def _table(found: Samples) -> Table:
    columns = {
        "time_s": Column(found.time, TIME, "time"),
        "true_m": Column(found.true, POSITION, "spool"),
        "reference_m": Column(found.reference, POSITION, "reference"),
        "estimate_m": Column(found.estimate, POSITION, "estimate"),
        "error_m": Column(found.true - found.reference, POSITION, "tracking error"),
        "estimate_error_m": Column(found.estimate - found.reference, POSITION, "error of the estimate"),
        "command": Column(found.command, SIGNED_FRACTION, "command"),
        "pollution_m": Column(found.pollution, POSITION, "pollution"),
        "pollution_error_m": Column(found.pollution_error, POSITION, "error of the believed periodic sensor error"),
    }
    return Table(title="Samples", columns=columns, axes=("time_s",), is_data=True)


def _panel(label: str, *columns: str, right: float | None = None, left: float | None = None) -> Lines:
    return over("time_s", *columns, label=label, width=0.9, left=left, right=right)


def _figure_of(
    name: str, caption: str, found: Samples, statements: tuple[Statement, ...], *panels: Lines
) -> Reproduction:
    return figure_of(name, caption, {"samples": _table(found)}, statements, *panels, height=1.0 + 1.3 * len(panels))


def figure_4_8() -> Reproduction:
    """Reference, tracking error and command with the signal generator of 20 states."""
    found = late(experiment(GENERATOR, IDEAL))
    return _figure_of(
        "figure-4.8",
        "Trapezoid, tracking error and command with the signal generator at 25 Hz.",
        found,
        (
            bound_statement(
                "largest tracking error over the stroke",
                peak(found.true - found.reference),
                RATIO,
                high=0.01,
                source="the tracking is satisfactory",
                because="a hundredth of the stroke (ours)",
            ),
        ),
        _panel("position", "reference_m"),
        _panel("error", "error_m"),
        _panel("command", "command"),
    )


def figure_4_9() -> Reproduction:
    """The periodic sensor error, and what the signal generator leaves of it."""
    found = late(experiment(GENERATOR, IDEAL, NOISY))
    return _figure_of(
        "figure-4.9",
        "Periodic sensor error at 25 Hz and the error of its estimate.",
        found,
        (
            bound_statement(
                "error of the believed periodic sensor error over the periodic sensor error, rms",
                rms(found.pollution_error) / rms(found.pollution),
                RATIO,
                high=0.05,
                source="the position can be distinguished from the noise",
                because="a twentieth (ours)",
                note=f"{1e6 * rms(found.pollution_error):.1f} µm rms with white noise of 20 µm",
            ),
        ),
        _panel("pollution", "pollution_m", right=6.4, left=6.0),
        _panel("error", "pollution_error_m", right=6.4, left=6.0),
    )


def _both(lumped: Samples, periodic: Samples) -> dict[str, Table]:
    return {"lumped": _table(lumped), "periodic": _table(periodic)}


def _beside(column: str, label: str) -> Lines:
    lines = (
        Line(x="time_s", y=column, table="lumped", label="lumped", colour=Colour.INLET, width=0.9),
        Line(x="time_s", y=column, table="periodic", label="periodic", colour=Colour.LOAD, width=0.9),
    )
    return Lines(lines=lines, label=label)


def figure_4_10() -> Reproduction:
    """Tracking error with the lumped filter and with the periodic one."""
    lumped, periodic = (late(experiment(IDEAL, *more)) for more in ((LUMPED,), ()))
    errors = [peak(each.true - each.reference) for each in (lumped, periodic)]
    chart = Chart(
        name="figure-4.10",
        caption="Tracking error with the lumped filter and with the basis functions, drive known.",
        table="periodic",
        panels=(_beside("error_m", "error"),),
        height=2.6,
    )
    return Reproduction(
        statements=(
            bound_statement(
                "largest error with the basis functions over that with the lumped filter",
                errors[1] / errors[0],
                RATIO,
                high=0.2,
                source="the oscillation stops",
                because="a fifth (ours)",
                note=f"{100 * errors[0]:.2f} % and {100 * errors[1]:.3f} % of the stroke",
            ),
        ),
        tables=_both(lumped, periodic),
        charts=(chart,),
    )


def swing(values: Array, samples: int = 200) -> float:
    """How far values swing within the last samples [their unit]."""
    return float(np.ptp(values[-samples:]))


def figure_4_11() -> Reproduction:
    """The command with both filters."""
    lumped, periodic = (late(experiment(IDEAL, *more)) for more in ((LUMPED,), ()))
    chart = Chart(
        name="figure-4.11",
        caption="Command with the lumped filter and with the basis functions, drive known.",
        table="periodic",
        panels=(_beside("command", "command"),),
        height=2.6,
    )
    return Reproduction(
        statements=(
            bound_statement(
                "swing of the command at rest, basis functions over lumped filter",
                swing(periodic.command) / swing(lumped.command),
                RATIO,
                high=0.2,
                source="the command does not respond to the noise",
                because="a fifth (ours)",
            ),
        ),
        tables=_both(lumped, periodic),
        charts=(chart,),
    )


def figure_4_12() -> Reproduction:
    """A constant reference with the lumped filter: the estimate oscillates, and the command with it."""
    found = late(experiment(CONSTANT, LUMPED))
    return _figure_of(
        "figure-4.12",
        "Constant reference with the lumped filter: estimate, spool and command.",
        found,
        (
            digit_statement(
                "largest error of the estimate over the stroke",
                0.02,
                peak(found.estimate - found.reference),
                FRACTION,
                tolerance=0.005,
                assumption=POLLUTION,
            ),
            digit_statement(
                "largest error of the spool over the stroke",
                0.02,
                peak(found.true - found.reference),
                FRACTION,
                tolerance=0.005,
                source="position tracking error of 2 %",
                inconsistency="the 2 % are of the estimate; the dead band keeps most of it from the spool",
            ),
        ),
        _panel("position", "estimate_m", "true_m", "reference_m", right=7.0, left=6.0),
        _panel("command", "command", right=7.0, left=6.0),
    )


def figure_4_13() -> Reproduction:
    """The same with the basis functions: the command stays within the dead band."""
    found = late(experiment(CONSTANT, NOISY))
    return _figure_of(
        "figure-4.13",
        "Constant reference with the basis functions: estimate, spool and command.",
        found,
        (
            bound_statement(
                "largest error of the estimate over the stroke",
                peak(found.estimate - found.reference),
                FRACTION,
                high=0.007,
                source="less than 0.7 %",
            ),
            bound_statement(
                "swing of the command over the dead band",
                float(np.ptp(found.command)) / 0.14,
                RATIO,
                high=1.0,
                source="mainly within the dead zone",
                note=DRIVE,
            ),
        ),
        _panel("position", "estimate_m", "true_m", "reference_m", right=7.0, left=6.0),
        _panel("command", "command", right=7.0, left=6.0),
    )


def lines_of(command: Array, period: float = 1e-3, count: int = 8000) -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitudes of the last samples of a command."""
    values = command[-count:]
    amplitudes: Array = 2.0 * np.abs(np.fft.rfft(values - values.mean())) / count
    frequencies: Array = np.fft.rfftfreq(count, period).astype(float)
    return frequencies, amplitudes


BIN = 1000.0 / 1024.0
"""Distance of the lines of 1024 samples at 1 kHz, of which the printed 9.766 and 19.53 Hz are multiples [Hz]."""


def _resolution() -> tuple[Statement, ...]:
    """Resolution of the analysis of the measured record."""
    return (
        digit_statement(
            "line 10 of 1024 samples at 1 kHz",
            9.766,
            10.0 * BIN,
            FREQUENCY,
            tolerance=0.5e-3,
            note="the number of samples is not printed",
        ),
        bound_statement(
            "10.5 Hz less 9.766 Hz, over the distance of two lines",
            (10.5 - 9.766) / BIN,
            RATIO,
            low=1.0,
            source="there is a discrepancy between estimate and true frequency (4.5.2)",
            note="the next line is 10.74 Hz: this record cannot show both frequencies apart",
        ),
    )


def figure_4_14() -> Reproduction:
    """The spectrum of the command with both filters."""
    frequencies, lumped = lines_of(late(experiment(CONSTANT, LUMPED)).command)
    _, periodic = lines_of(late(experiment(CONSTANT, NOISY)).command)
    once, twice = (int(np.argmin(np.abs(frequencies - f))) for f in (10.0, 20.0))
    shown = frequencies <= 60.0
    columns = {
        "frequency_Hz": Column(frequencies[shown], FREQUENCY, "frequency"),
        "lumped": Column(lumped[shown], NUMBER, "lumped"),
        "periodic": Column(periodic[shown], NUMBER, "basis functions"),
    }
    return figure_of(
        "figure-4.14",
        "Amplitudes of the command at rest with both filters; the spool turns at 10 Hz.",
        {"spectrum": Table(title="Spectrum", columns=columns, axes=("frequency_Hz",), is_data=True)},
        (
            *_resolution(),
            bound_statement(
                "line at twice the spool's frequency over that at the frequency",
                float(lumped[twice] / lumped[once]),
                RATIO,
                low=1.0,
                source="a significant component at 19.53 Hz, twice the spool's",
                assumption=(
                    "the periodic sensor error's second harmonic, 0.55 of the first here; a loop makes none of its own"
                ),
            ),
            bound_statement(
                "largest line with the basis functions over that with the lumped filter",
                float(periodic.max() / lumped.max()),
                RATIO,
                high=0.1,
                source="the component is gone",
                because="a tenth (ours)",
            ),
        ),
        over("frequency_Hz", "lumped", "periodic", stroke=Stroke.STEMS, label="amplitude"),
    )


def figure_4_15() -> Reproduction:
    """The periodic sensor error as a basis that is 0.5 Hz off believes it."""
    found = late(experiment(IDEAL, OFF_BY_HALF))
    right = late(experiment(IDEAL))
    return _figure_of(
        "figure-4.15",
        "Periodic sensor error at 10 Hz and the error of what a basis at 9.5 Hz believes.",
        found,
        (
            bound_statement(
                "error of the believed periodic sensor error, 0.5 Hz off over right",
                rms(found.pollution_error) / rms(right.pollution_error),
                RATIO,
                low=3.0,
                source="a bias of 0.5 Hz induces an estimation error",
                because="three times (ours)",
            ),
        ),
        _panel("pollution", "pollution_m", right=8.0, left=6.0),
        _panel("error", "pollution_error_m", right=8.0, left=6.0),
    )


def figure_4_16() -> Reproduction:
    """The spool and the command with a basis that is 0.5 Hz off."""
    found, lumped = late(experiment(IDEAL, OFF_BY_HALF)), late(experiment(IDEAL, LUMPED))
    estimated = [peak(each.estimate - each.true) for each in (found, lumped)]
    return _figure_of(
        "figure-4.16",
        "Tracking error and command with a basis at 9.5 Hz and a periodic sensor error at 10 Hz.",
        found,
        (
            bound_statement(
                "error of the estimate, 0.5 Hz off over lumped",
                estimated[0] / estimated[1],
                RATIO,
                high=1.0,
                source="smaller than with the lumped filter",
                note="with less drift allowed to the basis it would be larger (docs/models/gerotor-control.md)",
            ),
            bound_statement(
                "largest tracking error over the stroke",
                peak(found.true - found.reference),
                FRACTION,
                low=1e-3,
                source="the spool can oscillate",
            ),
        ),
        _panel("error", "error_m"),
        _panel("command", "command"),
    )


def figure_4_1() -> Reproduction:
    """Actuation and sensing of the spool's axial position."""
    return circuit_drawing("axial actuation and sensing", "figure-4.1", "axial-gerotor")


def figure_4_7() -> Reproduction:
    """The loop of estimator and controller."""
    return circuit_drawing("block diagram of estimation and control", "figure-4.7", "axial-gerotor")


ITEMS = (
    Item(ItemKind.FIGURE, "4.1", "Valve spool axial actuation and sensing", figure_4_1),
    Item(ItemKind.FIGURE, "4.7", "System block diagram", figure_4_7),
    Item(ItemKind.FIGURE, "4.8", "Trapezoid, tracking error, command", figure_4_8),
    Item(ItemKind.FIGURE, "4.9", "Repetitive noise and its estimation error", figure_4_9),
    Item(ItemKind.FIGURE, "4.10", "Tracking error of both filters", figure_4_10),
    Item(ItemKind.FIGURE, "4.11", "Control input of both filters", figure_4_11),
    Item(ItemKind.FIGURE, "4.12", "Experiment with the lumped filter", figure_4_12),
    Item(ItemKind.FIGURE, "4.13", "Experiment with the periodic filter", figure_4_13),
    Item(ItemKind.FIGURE, "4.14", "FFT of the control input", figure_4_14),
    Item(ItemKind.FIGURE, "4.15", "Noise estimate with a frequency bias", figure_4_15),
    Item(ItemKind.FIGURE, "4.16", "Tracking with a frequency bias", figure_4_16),
)
