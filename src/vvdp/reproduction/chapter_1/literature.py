"""Reports of section 1.2 about other circuits, valves and sensors, and whether their numbers go together."""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import COUNT, FLOW, LENGTH, MEAN_POWER, NUMBER, PRESSURE_DIFFERENCE, RATIO, TIME
from vvdp.reproduction.chapter_1.claims import statements_of
from vvdp.reproduction.chapter_2.valve import LPM, open_drops, open_frequency, valve
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.result import Column, Table
from vvdp.results.verdict import (
    Statement,
    bound_statement,
    digit_statement,
    exact_statement,
    number_statement,
    open_statement,
)
from vvdp.valve.geometry import transition_fraction

PARALLEL = 6
"""Valves of the parallel connection that is tried, sized as powers of two."""
SPOOL, SENSING = 25.4e-3, (3e-2, 6e-2)
"""Diameter of the spool, and the range over which its axial position is to be seen [m]."""
AMPLIFIED = 0.6e-3, 1.5e-3
"""Stroke of the armature and of the spool of winker's valve [m]."""


class OnOffValve(NamedTuple):
    """A valve of section 1.2.2; nan where nothing is stated."""

    name: str
    flow: float  # [m^3/s]
    drop: float  # [Pa]
    time: float  # of switching [s]


VALVES = (
    OnOffValve("Kajima 1994, solenoid spool", 60.0 * LPM, 60e5, 1e-3),
    OnOffValve("Park, two stages", 9.0 * LPM, np.nan, 2e-3),
    OnOffValve("Yokota, piezoelectric poppet", np.nan, np.nan, 100e-6),
    OnOffValve("Lu, piezoelectric", 8.0 * LPM, 100e5, 1.7e-3),
    OnOffValve("Tsuchiya", 0.23 * LPM, np.nan, 1.5e-3),
    OnOffValve("Winker, stroke amplifier", 100.0 * LPM, np.nan, 1e-3),
    OnOffValve("Cui 1990, rotary", 18.0 * LPM, 90e5, 2e-3),
)


def section_1_2_1() -> Reproduction:
    """Parallel valves: how many openings they have; the ripple over the frequency."""
    openings = {sum(1 << place for place in range(PARALLEL) if state >> place & 1) for state in range(1 << PARALLEL)}
    found = number_statement(
        f"openings of {PARALLEL} valves, each twice the last",
        2.0**PARALLEL,
        float(len(openings)),
        COUNT,
        source="2^N",
        note="equal valves have N + 1",
    )
    return Reproduction(statements=(found, *statements_of("section-1.2.1")))


def valve_table() -> Table:
    """The valves of section 1.2.2 beside the rotary one at their flow."""
    flow, drop, time = (np.array([getattr(each, name) for each in VALVES]) for name in ("flow", "drop", "time"))
    own = np.array([sum(open_drops(q)) if np.isfinite(q) else np.nan for q in flow])
    columns = {
        "valve": Column(np.array([each.name for each in VALVES]), None, "valve"),
        "flow_m3_s": Column(flow, FLOW, "flow"),
        "drop_Pa": Column(drop, PRESSURE_DIFFERENCE, "drop"),
        "switching_s": Column(time, TIME, "time of switching"),
        "rotary_drop_Pa": Column(own, PRESSURE_DIFFERENCE, "drop of the rotary valve at this flow"),
    }
    return Table(title="On/off valves of section 1.2.2", columns=columns)


def section_1_2_2() -> Reproduction:
    """Linear on/off valves: none has a small drop, a short time and a low power at once."""
    table = valve_table()
    worst = float(np.nanmax(table["rotary_drop_Pa"] / table["drop_Pa"]))
    transition = transition_fraction(valve()) / open_frequency()
    drop = bound_statement(
        "drop of the rotary valve over that of those whose pressure drop is stated, largest",
        worst,
        RATIO,
        high=1.0,
        source="large drops of linear valves",
    )
    time = bound_statement(
        "transition of the rotary valve at 72 Hz over the slowest of them",
        transition / 2e-3,
        RATIO,
        high=1.0,
        source="rotary valves can have all of it: small drop, fast transitions, low power",
        note="a self-spinning valve turns as fast as its flow lets it; a motor makes it faster, at the cost of power",
    )
    statements = (drop, time, *_consistent_numbers(), _amplifier_power())
    return Reproduction(statements=statements, tables={"valves": table})


def _consistent_numbers() -> tuple[Statement, ...]:
    """Numbers of single valves that have to go together."""
    return (
        exact_statement(
            "electrical power of Kajima's valve", 9e3, 300.0 * 30.0, MEAN_POWER, source="300 V, up to 30 A"
        ),
        bound_statement(
            "two strokes of Yokota's valve over a period at 2 kHz",
            2.0 * 100e-6 * 2e3,
            RATIO,
            high=1.0,
            source="100 µs, follows 2 kHz",
        ),
        number_statement(
            "stroke amplification of Winker's valve",
            2.5,
            AMPLIFIED[1] / AMPLIFIED[0],
            RATIO,
            tolerance=1e-9,
            source="0.6 mm to 1.5 mm",
            because="rounding",
        ),
    )


def _amplifier_power() -> Statement:
    return bound_statement(
        "power of Winker's armature at 72 Hz",
        2.0 * 72.0 * 100.0 * AMPLIFIED[0],
        MEAN_POWER,
        low=30.0,
        source="a high actuation power, 100 N",
        assumption="the force over the armature's stroke, twice a period; the losses of its magnet are not stated",
    )


def section_1_2_4() -> Reproduction:
    """Sensors without contact: which of them fit the spool."""
    low, high = SENSING
    statements = (
        bound_statement(
            "diameter of an inductive sensor over that of the spool",
            10e-2 / SPOOL,
            RATIO,
            low=1.0,
            source="a diameter of 10 cm is not realistic",
        ),
        bound_statement(
            "shortest distance of an ultrasonic sensor over the longest that is needed",
            10e-2 / high,
            RATIO,
            low=1.0,
            source="ultrasonic sensors start at 10 cm",
        ),
        bound_statement(
            "stroke of the spool",
            valve().helix_length,
            LENGTH,
            high=high - low,
            source="a range of 3 cm to 6 cm",
        ),
    )
    return Reproduction(statements=statements)


def section_1_2_5() -> Reproduction:
    """Other controllers' figures."""
    theirs = "an experiment of others, of which the text gives two rates"
    return Reproduction(
        statements=(
            open_statement("bandwidth with sliding mode control", "from 62.5 Hz to 1000 Hz", "a factor of 16", theirs),
        )
    )


def section_1_3() -> Reproduction:
    """Distance of the sensor."""
    return Reproduction(
        statements=(
            digit_statement(
                "distance of the rotary sensor",
                2.54e-2,
                SPOOL,
                LENGTH,
                tolerance=5e-5,
                source="2.54 cm, as in 3.2",
                note="as much as the spool's diameter",
            ),
            bound_statement("the same beside a usual encoder's 3 mm", 2.54e-2 / 3e-3, NUMBER, low=2.0, source="long"),
        )
    )


SECTION = ItemKind.SECTION
ITEMS = (
    Item(SECTION, "1.2.1", "Digital hydraulics", section_1_2_1),
    Item(SECTION, "1.2.2", "On/off valves", section_1_2_2),
    Item(SECTION, "1.2.4", "Non-contact sensing methods", section_1_2_4),
    Item(SECTION, "1.2.5", "Hydraulic actuator position control", section_1_2_5),
    Item(SECTION, "1.3", "Research scope", section_1_3),
)
