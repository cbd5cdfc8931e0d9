"""Sections 2.7 and 2.8: the inlet rail's designs, their volumes, drops, shares and force."""

from dataclasses import replace

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import BULK_MODULUS, EFFICIENCY, FORCE, FRACTION, MEAN_POWER, NUMBER, VOLUME
from vvdp.base.units import ATMOSPHERE
from vvdp.cfd.kept import KeptStudy
from vvdp.fluid.mixture import mean_bulk_modulus
from vvdp.geometry.shape import rail_volume
from vvdp.geometry.shape_tables import given_shape
from vvdp.reproduction.chapter_2 import valve as here
from vvdp.reproduction.chapter_2.computed import kept_or_none, kept_table
from vvdp.reproduction.chapter_2.shapes import rail_designs
from vvdp.reproduction.drawings import solid_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of
from vvdp.results.chart import Bars
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, digit_statement, missing_statement, number_statement
from vvdp.valve.bearing import bearing_eccentricity, radial_force

RAIL, THIN, FINAL = 12.7e-6, 4.2e-6, 3.7e-6
"""Volumes of the prototype, of design (d) and of the final design [m^3]."""
DROP, FINAL_DROP = 4.17e5, 4.73e5
DESIGNS = ("a", "b", "c", "d", "final")
PUBLISHED = np.array(
    [[0.355, 0.323, 0.322], [0.328, 0.35, 0.322], [0.386, 0.305, 0.309], [0.341, 0.321, 0.338], [0.31, 0.386, 0.304]]
)
"""Shares of the nozzles, by design: table 2.1."""
STUDY = "rail-designs"
PRESSURE, MODULUS, FREQUENCY = 100e5, 7e8, 72.0
FORCE_PRINTED = 0.93
UNKNOWN_SHAPE = "the shapes, of which the text gives three changes: its (d) holds 4.2 cc, which they do not make"


def computed_shares(study: KeptStudy) -> Array:
    """Shares of the nozzles of every design, (designs, nozzles)."""
    return np.column_stack([study[f"split_{nozzle}"] for nozzle in (1, 2, 3)])


def share_table(study: KeptStudy | None) -> Table:
    """Published and computed shares, a line for each nozzle of each design."""
    found = computed_shares(study) if study else np.full(PUBLISHED.shape, np.nan)
    names = [f"{design}, nozzle {nozzle}" for design in DESIGNS for nozzle in (1, 2, 3)]
    columns = {
        "nozzle": Column(np.array(names), None, "design and nozzle"),
        "published": Column(PUBLISHED.ravel(), FRACTION, "published"),
        "computed": Column(found.ravel(), FRACTION, "computed here"),
    }
    return Table(title="Shares of the nozzles", columns=columns)


def _words(shares: Array) -> str:
    return " / ".join(f"{100.0 * share:.1f}" for share in shares) + " %"


def _share_statements(study: KeptStudy) -> tuple[Statement, ...]:
    return tuple(
        bound_statement(
            f"shares of the nozzles, design ({design})",
            float(np.max(np.abs(own - printed))),
            NUMBER,
            high=0.0,
            tolerance=0.5 * float(np.max(np.abs(printed - 1.0 / 3.0))),
            source=_words(printed),
            result=_words(own),
            because="half of what an even split misses; no share was fitted",
            note="on the medium grid; the largest and smallest share stand in docs/models/cfd.md",
        )
        for design, own, printed in zip(DESIGNS, computed_shares(study), PUBLISHED, strict=True)
    )


def table_2_1() -> Reproduction:
    """How the flow divides in five designs of the rail."""
    study = kept_or_none(STUDY)
    sums = bound_statement(
        "shares of a design, their sum less 1, largest",
        float(np.max(np.abs(PUBLISHED.sum(axis=1) - 1.0))),
        NUMBER,
        high=1.01e-3,
        source="100 %",
        because="digits",
    )
    computed = _share_statements(study) if study else (missing_statement("shares of the nozzles", "15 shares", STUDY),)
    bars = Bars(names="nozzle", values=("published", "computed"), label="share of the flow")
    return figure_of(
        "table-2.1",
        "Shares of the nozzles.",
        {"shares": share_table(study)},
        (sums, *computed),
        bars,
        height=4.5,
    )


def _drop_change(study: KeptStudy | None, row: int) -> float:
    return float(study["drop_change"][row]) if study else float("nan")


def _drawn_volume(design: str, printed: float, *, note: str = "", calibration: str = "") -> Statement:
    """Volume of a rail as drawn here, with its nozzles, compared with the printed volume."""
    shape = given_shape(here.valve(), f"rail-{design}", ()).shape
    return digit_statement(
        f"volume of the rail as drawn here, design ({design})",
        printed,
        rail_volume(shape, here.valve()),
        VOLUME,
        tolerance=0.05e-6,
        note=note,
        calibration=calibration,
    )


def figure_2_19() -> Reproduction:
    """The prototype's rail and three changes of it: what they hold, and what (d) costs."""
    study = kept_or_none(STUDY)
    prototype = _drawn_volume("a", RAIL, calibration="the rail's diameter")
    thin = _drawn_volume("d", THIN, note="its section is 30 % thinner, as printed, and nothing else is changed")
    volume = digit_statement(
        "volume of (d), its section thinner by 30 %",
        THIN,
        0.7**2 * RAIL,
        VOLUME,
        tolerance=0.05e-6,
        inconsistency="0.7² of 12.7 cc are 6.2 cc, 5.2 cc on a ring 16 % smaller; 4.2 cc would take 42 %",
        contradiction=("2.7: a section thinner by 30 %", "2.7: 4.2 cc of 12.7 cc"),
    )
    drop = digit_statement(
        "drop of (d) over that of the prototype, less 1",
        0.136,
        _drop_change(study, 3),
        EFFICIENCY,
        tolerance=5e-4,
        assumption=UNKNOWN_SHAPE,
    )
    tables = {"computed": kept_table(study)} if study else {}
    made = solid_drawing(
        "four designs of the inlet rail",
        "figure-2.19",
        lambda: rail_designs(DESIGNS[:4]),
        prototype,
        thin,
        volume,
        drop,
    )
    return Reproduction(statements=made.statements, tables=tables, pictures=made.pictures)


def figure_2_20() -> Reproduction:
    """The final rail: what it holds, and its drop beside that of the prototype."""
    study = kept_or_none(STUDY)
    volume = _drawn_volume("final", FINAL, note="the three printed changes together")
    drop = number_statement(
        "drop of the final rail over that of the prototype, less 1",
        FINAL_DROP / DROP - 1.0,
        _drop_change(study, 4),
        EFFICIENCY,
        tolerance=0.005e5 / DROP * (1.0 + FINAL_DROP / DROP),
        because="half of the last digit of both drops",
        assumption=UNKNOWN_SHAPE,
    )
    return solid_drawing("optimised rail", "figure-2.20", lambda: rail_designs(DESIGNS[4:]), volume, drop)


def equation_2_10() -> Reproduction:
    """The loss by compression: the number of periods counted once."""
    energy = RAIL * PRESSURE**2 / (2.0 * MODULUS)
    return Reproduction(
        statements=(
            number_statement(
                "loss at 72 Hz, 12.7 cc, 100 bar and 0.7 GPa",
                3.0 * FREQUENCY * energy,
                FREQUENCY * energy,
                MEAN_POWER,
                share=0.05 / 12.7 + 0.5 / 72.0,
                because="half of the last digit of 12.7 cc and of 72 Hz",
                inconsistency="N ω_pwm/(2π) with ω_pwm = N ω counts N twice; f V P²/(2β) is the energy of one filling",
                contradiction=("(2.10): f = N ω_pwm/(2π)", "(2.10): ω_pwm = N ω"),
            ),
        )
    )


def section_2_7() -> Reproduction:
    """Volumes, mismatch and force of the designs, and the modulus."""
    return Reproduction(statements=(*_saving_statements(), *_force_statements(), _modulus_statement()))


def _saving_statements() -> tuple[Statement, ...]:
    return (
        digit_statement("volume saved by (d)", 0.67, 1.0 - THIN / RAIL, EFFICIENCY, tolerance=0.005),
        digit_statement(
            "volume saved by the final design",
            0.66,
            1.0 - FINAL / RAIL,
            EFFICIENCY,
            tolerance=0.005,
            inconsistency="1 − 3.7/12.7; 66 to 67 % belong to design (d)",
            contradiction=("2.7: 66 %", "2.7: 12.7 cc and 3.7 cc"),
        ),
        digit_statement(
            "mismatch of the final design's shares",
            0.08,
            float(np.ptp(PUBLISHED[4])),
            EFFICIENCY,
            tolerance=0.005,
            note="in points, largest less smallest share; of the mean share it is 24.6 %",
        ),
    )


def _force_statements() -> tuple[Statement, ...]:
    """Radial force of unequal jets, and how far it moves the spool."""
    v = here.valve()
    momentum = float(radial_force(PUBLISHED[4] * here.FLOW, np.full(3, v.nozzle_area / 3.0), here.DENSITY))
    uneven = abs(np.sum(PUBLISHED[4] * np.exp(2j * np.pi * np.arange(3) / 3.0)))
    mean_speed = float(here.DENSITY * uneven * here.FLOW**2 / v.nozzle_area)
    eccentricity = float(bearing_eccentricity(momentum, here.open_speed(), here.VISCOSITY, v))
    return (
        digit_statement(
            "radial force of the final design's shares at 40 lpm",
            FORCE_PRINTED,
            momentum,
            FORCE,
            tolerance=0.005,
            other=mean_speed,
            assumption="each jet brings ρ q²/A through its mouth; in the second run ρ q Q/A, with the mean speed",
        ),
        bound_statement(
            "eccentricity at which the end lands bear it",
            eccentricity,
            FRACTION,
            high=0.05,
            source="negligible, borne by the film",
            because="a twentieth of the clearance (ours)",
        ),
    )


def _modulus_statement() -> Statement:
    oil = here.stand().bench.oil
    found, with_air = float(mean_bulk_modulus(PRESSURE + ATMOSPHERE, oil)), replace(oil, air_fraction=0.05)
    return bound_statement(
        "mean bulk modulus up to 100 bar",
        found,
        BULK_MODULUS,
        low=2e8,
        high=9e8,
        source="several thousand bar",
        other=float(mean_bulk_modulus(PRESSURE + ATMOSPHERE, with_air)),
        assumption="1 % of air; in the second run 5 %",
    )


def section_2_8() -> Reproduction:
    """Summary of the chapter."""
    return Reproduction(
        statements=(
            digit_statement(
                "drop of the final rail over the prototype's, less 1",
                0.067,
                FINAL_DROP / DROP - 1.0,
                EFFICIENCY,
                tolerance=5e-4,
                inconsistency="4.73/4.17 − 1 is 13.4 %, twice the printed 6.7 %",
                contradiction=("2.8: 6.7 %", "2.7: 4.17 and 4.73 bar"),
            ),
            digit_statement(
                "volume saved",
                0.66,
                1.0 - FINAL / RAIL,
                EFFICIENCY,
                tolerance=0.005,
                inconsistency="1 − 3.7/12.7",
                contradiction=("2.8: 66 %", "2.7: 12.7 cc and 3.7 cc"),
            ),
            digit_statement("loss of the open valve saved", 0.625, 1.0 - 2.48 / 6.61, EFFICIENCY, tolerance=5e-4),
        )
    )


SECTION = ItemKind.SECTION
ITEMS = (
    Item(ItemKind.FIGURE, "2.19", "Improvements of the inlet rail", figure_2_19),
    Item(ItemKind.FIGURE, "2.20", "Optimised inlet rail", figure_2_20),
    Item(ItemKind.TABLE, "2.1", "Flow distribution among nozzles", table_2_1),
    Item(ItemKind.EQUATION, "2.10", "Loss by compression", equation_2_10),
    Item(SECTION, "2.7", "Guidance to the inlet rail's design", section_2_7),
    Item(SECTION, "2.8", "Summary of the chapter", section_2_8),
)
