"""Sections 3.1 and 3.2: code wheel, light spot, photodiode and threshold."""

from dataclasses import replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import ANGLE, COUNT, FRACTION, LENGTH, NUMBER
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, drawing_statement, number_statement
from vvdp.sensing.photodiode import LightSpot, photodiode_signal, ramp_width
from vvdp.sensing.wheel import TURN, equal_wheel

SECTORS, SECTOR_LENGTH, SPOT_DIAMETER, SPOOL_DIAMETER = 8, 8e-3, 5e-3, 25.4e-3
WHEEL = equal_wheel(SECTORS)
SPOT = LightSpot(width=SPOT_DIAMETER, track_radius=SECTORS * SECTOR_LENGTH / TURN, roundness=1.0)
SHARP = replace(SPOT, width=1e-6)
TRUE, LOW, HIGH = 0.5, 0.35, 0.65
"""Thresholds: that at which half of the spot is bright, and two wrong ones."""
POINTS = 4001
LEAST_DELAY = 1e-3
"""A shift of an edge that counts [rad]."""


def light_table() -> Table:
    """The photodiode's signal over half a turn: of a point of light, and of the spot, with its comparator's output."""
    angle: Any = np.linspace(-0.25, SECTORS / 2 - 0.25, POINTS) * TURN / SECTORS
    ideal: Array = np.asarray(photodiode_signal(angle, WHEEL, SHARP))
    light: Array = np.asarray(photodiode_signal(angle, WHEEL, SPOT))
    columns = {
        "angle_rad": Column(angle, ANGLE, "angle of the spool"),
        "ideal": Column(ideal, FRACTION, "point of light"),
        "light": Column(light, FRACTION, "photodiode"),
    }
    for name, threshold in (("true", TRUE), ("low", LOW), ("high", HIGH)):
        columns[name] = Column((light > threshold).astype(float), FRACTION, f"output, threshold {threshold}")
    return Table(title="Light on the photodiode", columns=columns, axes=("angle_rad",), is_data=True)


def edges(table: Table, column: str) -> tuple[Array, Array]:
    """Angles at which an output rises and at which it falls [rad]."""
    change = np.diff((table[column] > TRUE).astype(float))
    middle = table["angle_rad"][:-1] + 0.5 * np.diff(table["angle_rad"])
    return middle[change > 0.5], middle[change < -0.5]


def _chart(name: str, caption: str, *panels: tuple[str, tuple[Line, ...]], levels: tuple[Level, ...] = ()) -> Chart:
    drawn = tuple(
        Lines(lines=lines, label=label, low=-0.05, high=1.05, levels=() if k else levels)
        for k, (label, lines) in enumerate(panels)
    )
    return Chart(name=name, caption=caption, table="light", panels=drawn, height=0.8 + 1.3 * len(panels))


def _line(y: str, label: str = "", colour: str = "", stroke: Stroke = Stroke.SOLID) -> Line:
    return Line(x="angle_rad", y=y, label=label, colour=colour, stroke=stroke)


def figure_3_1() -> Reproduction:
    """Where the code wheel sits: a drawing."""
    return Reproduction(
        statements=(drawing_statement("sensing mechanism", "the wheel and the spot of docs/models/encoder.md"),)
    )


def figure_3_2() -> Reproduction:
    """A point of light that crosses the edges of the wheel."""
    table = light_table()
    chart = _chart("figure-3.2", "Light of a point on the wheel of eight sectors.", ("bright share", (_line("ideal"),)))
    return Reproduction(
        statements=(drawing_statement("an edge crosses the light", "light of a point over half a turn"),),
        tables={"light": table},
        charts=(chart,),
    )


def figure_3_3() -> Reproduction:
    """The output of an ideal encoder: a square wave with an edge at every sector."""
    table = light_table()
    rising, falling = edges(table, "ideal")
    return Reproduction(
        statements=(
            number_statement(
                "edges in half a turn", SECTORS / 2, rising.size + falling.size, COUNT, source="8 sectors a turn"
            ),
            bound_statement(
                "share of the turn between dark and bright",
                float(np.mean((table["ideal"] % 1.0) > 0.0)),
                FRACTION,
                high=1e-3,
                source="a binary signal",
                because="a spot of 1 µm",
            ),
        ),
        tables={"light": table},
        charts=(_chart("figure-3.3", "Output of an ideal encoder.", ("output", (_line("ideal"),))),),
    )


def figure_3_4() -> Reproduction:
    """The encoder's light with a spot of 5 mm, and the output of a comparator."""
    table = light_table()
    ramp = float(np.mean((table["light"] > 0.0) & (table["light"] < 1.0)))
    return Reproduction(
        statements=(
            bound_statement(
                "share of the time in which the light goes over",
                ramp,
                FRACTION,
                low=0.1,
                high=0.9,
                source="no perfect square wave",
                because="neither sharp edges nor edges without a level between them",
            ),
            number_statement(
                "the same share",
                SPOT_DIAMETER / SECTOR_LENGTH,
                ramp,
                FRACTION,
                tolerance=0.01,
                because="a hundredth (ours): points of the curve",
                source="5 mm of light on sectors of 8 mm: 0.625",
            ),
        ),
        tables={"light": table},
        charts=(
            _chart(
                "figure-3.4",
                "Light on the photodiode from a spot of 5 mm on sectors of 8 mm, and the comparator's output.",
                ("photodiode", (_line("light"),)),
                ("output", (_line("true", colour=Colour.INLET),)),
                levels=(Level(value=TRUE),),
            ),
        ),
    )


ALL_EDGES_ALIKE = ("3.2: a low threshold delays the edges", "7.3: the error switches signs for every measurement")
"""Printed statements on edges of both kinds that hold for one kind only."""


def _delay(kind: str, threshold: str, delay: float) -> Statement:
    """The statement on all edges with a wrong threshold, for one kind of edge."""
    low, high, words = (LEAST_DELAY, np.inf, "delayed") if threshold == "low" else (-np.inf, -LEAST_DELAY, "advanced")
    return bound_statement(
        f"{kind} edges with a {threshold} threshold",
        delay,
        ANGLE,
        low=low,
        high=high,
        source=words,
        inconsistency="the sign belongs to one kind of edge; section 7.3 has it alternate, which is right",
        contradiction=ALL_EDGES_ALIKE if kind == "rising" else None,
    )


def figure_3_5() -> Reproduction:
    """A threshold that is too low delays one kind of edge and brings the other forward."""
    table = light_table()
    right = edges(table, "true")
    statements = tuple(
        _delay(kind, threshold, float(np.mean(found - true)))
        for threshold in ("low", "high")
        for kind, found, true in zip(("rising", "falling"), edges(table, threshold), right, strict=True)
    )
    outputs = (
        _line("true", "right", Colour.LOAD),
        _line("high", "too high", Colour.GREEN),
        _line("low", "too low", Colour.RED),
    )
    chart = _chart(
        "figure-3.5",
        "Three thresholds, and what the comparator makes of the light with each.",
        ("photodiode", (_line("light", "light"),)),
        ("output", outputs),
        levels=tuple(Level(value=value) for value in (TRUE, HIGH, LOW)),
    )
    return Reproduction(statements=statements, tables={"light": table}, charts=(chart,))


def edge_errors() -> Table:
    """Error of the angle at each edge with a low threshold."""
    table = light_table()
    (rise, fall), (low_rise, low_fall) = (edges(table, name) for name in ("true", "low"))
    errors, angles = np.concatenate([low_rise - rise, low_fall - fall]), np.concatenate([rise, fall])
    order = np.argsort(angles)
    columns = {
        "angle_rad": Column(angles[order], ANGLE, "angle of the edge"),
        "error_rad": Column(errors[order], ANGLE, "error of the angle"),
    }
    return Table(title="Error of each edge", columns=columns, axes=("angle_rad",))


def figure_3_7() -> Reproduction:
    """The measurement error that a wrong threshold brings: an angle of alternating sign."""
    shown = edge_errors()
    signs = np.sign(shown["error_rad"])
    alternate = bound_statement(
        "neighbouring edges with errors of the same sign",
        float(np.sum(signs[1:] == signs[:-1])),
        COUNT,
        high=0.0,
        source="a bias of the threshold shifts the edges of the discretised wave",
    )
    size = bound_statement(
        "largest error over the width of the light's ramp",
        float(np.abs(shown["error_rad"]).max()) / ramp_width(SPOT),
        FRACTION,
        high=0.5,
        source="within the transition of the light",
        because="half of the ramp",
    )
    return figure_of(
        "figure-3.7",
        "Error of the angle at each edge with a threshold of 0.35 in place of 0.5.",
        {"errors": shown},
        (alternate, size),
        over("angle_rad", "error_rad", stroke=Stroke.STEMS),
        height=2.2,
    )


def section_3_2() -> Reproduction:
    """The measures of wheel and spot: whether they go together."""
    track = SPOT.track_radius
    spool = 0.5 * SPOOL_DIAMETER
    return Reproduction(
        statements=(
            bound_statement(
                "radius of the track on which 8 sectors are 8 mm long",
                track,
                LENGTH,
                high=spool,
                source="the wheel sits on a spool of 25.4 mm",
            ),
            bound_statement(
                "spot over sector",
                ramp_width(SPOT) / (TURN / SECTORS),
                NUMBER,
                high=1.0,
                source="a spot of 5 mm lies completely within a sector of 8 mm",
            ),
            number_statement(
                "diameter of the spool",
                SPOOL_DIAMETER,
                25e-3,
                LENGTH,
                tolerance=0.5e-3,
                because="half of the last digit of the shorter number",
                source="25.4 mm (3.1), 2.5 cm (3.2)",
            ),
            bound_statement(
                "distance of the light over that of a usual encoder",
                25.4 / 3.0,
                NUMBER,
                low=2.0,
                source="2.54 cm is much larger than 3 mm",
            ),
        ),
    )


ITEMS = (
    Item(ItemKind.FIGURE, "3.1", "PWM valve rotary sensing mechanism", figure_3_1),
    Item(ItemKind.FIGURE, "3.2", "Ideal measurement detection", figure_3_2),
    Item(ItemKind.FIGURE, "3.3", "Ideal rotary encoder output", figure_3_3),
    Item(ItemKind.FIGURE, "3.4", "Raw and discretized signal of the photodiode", figure_3_4),
    Item(ItemKind.FIGURE, "3.5", "Effect of a threshold bias on the detection of edges", figure_3_5),
    Item(ItemKind.FIGURE, "3.7", "Measurement noise caused by the threshold error", figure_3_7),
    Item(ItemKind.SECTION, "3.2", "Measures of code wheel and light spot", section_3_2),
)
