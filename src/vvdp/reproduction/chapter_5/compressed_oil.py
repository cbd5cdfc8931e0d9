"""Section 5.3: the bulk modulus of oil with air, its mean, and the energy of compression."""

import math
from functools import cache

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import BULK_MODULUS, ENERGY_DENSITY, GAUGE_PRESSURE, NUMBER, RATIO
from vvdp.fluid.mixture import compression_energy_per_mass, compression_energy_per_volume, fluid_density
from vvdp.fluid.modulus import YuAir, mean_modulus, specific_volume_exponent, yu_bulk_modulus
from vvdp.fluid.modulus import compression_energy_per_volume as energy_of_law
from vvdp.reproduction.chapter_5.chamber import known_drive
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of
from vvdp.results.chart import Chart, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Table
from vvdp.results.verdict import bound_statement, exact_statement, number_statement

BAR, ATMOSPHERE = 1e5, 1e5
AIR = (0.01, 0.1, 0.3)
LOW, HIGH, POINTS = 1.1, 350.0, 121
WARM = 313.15


def aerated_oil(air: float) -> YuAir:
    """The oil of Yu's law with a volume of air per oil."""
    return YuAir(
        liquid_bulk_modulus=1.7e9,
        reference_pressure=ATMOSPHERE,
        air_fraction=air,
        polytropic_exponent=1.4,
        dissolving_rate=0.0,
    )


@cache
def moduli() -> Table:
    """Bulk modulus and mean bulk modulus against the atmosphere, for three shares of air."""
    pressures: Array = np.geomspace(LOW, HIGH, POINTS) * BAR
    columns = {"pressure_Pa": Column(pressures, GAUGE_PRESSURE, "pressure, absolute")}
    for air in AIR:
        oil = aerated_oil(air)
        beta = [yu_bulk_modulus(float(P), oil) for P in pressures]
        mean = [mean_modulus(float(P), ATMOSPHERE, yu_bulk_modulus, oil) for P in pressures]
        name = f"{100 * air:.0f}"
        columns[f"modulus_{name}_Pa"] = Column(np.array(beta), BULK_MODULUS, f"{name} % air")
        columns[f"mean_{name}_Pa"] = Column(np.array(mean), BULK_MODULUS, f"{name} %, mean")
    return Table(title="Bulk moduli", columns=columns, axes=("pressure_Pa",), is_data=True)


def _at(column: str, bar: float) -> float:
    table = moduli()
    return float(np.interp(bar * BAR, table["pressure_Pa"], table[column]))


def _modulus_chart() -> Chart:
    lines = tuple(
        Line(x="pressure_Pa", y=f"{kind}_{100 * air:.0f}_Pa", colour=colour, stroke=stroke)
        for air, colour in zip(AIR, shades(len(AIR)), strict=True)
        for kind, stroke in (("modulus", Stroke.SOLID), ("mean", Stroke.DOTTED))
    )
    return Chart(
        name="figure-5.3",
        caption="Bulk modulus (solid) and mean bulk modulus against 0.1 MPa (dotted), by Yu's law.",
        table="moduli",
        panels=(Lines(lines=lines, label="bulk modulus", x_log=True, y_log=True),),
        height=3.4,
    )


def figure_5_3() -> Reproduction:
    """The mean modulus lies below the modulus, the more so the more air there is; both rise with the pressure."""
    table = moduli()
    ratios = [table[f"modulus_{100 * air:.0f}_Pa"] / table[f"mean_{100 * air:.0f}_Pa"] for air in AIR]
    rises = [np.diff(table[name]).min() for name in table.columns if name != "pressure_Pa"]
    statements = (
        bound_statement(
            "least ratio of the modulus to its mean",
            float(np.min(ratios)),
            RATIO,
            low=1.0,
            source="the mean lies below the modulus",
        ),
        bound_statement("least rise of any curve", float(min(rises)), BULK_MODULUS, low=0.0, source="non-decreasing"),
        bound_statement(
            "ratio at 50 bar with 10 % of air",
            _at("modulus_10_Pa", 50.0) / _at("mean_10_Pa", 50.0),
            RATIO,
            low=2.0,
            source="much smaller",
            because="a factor of two (ours)",
        ),
        bound_statement(
            "the same at 350 bar with 1 %",
            _at("modulus_1_Pa", 350.0) / _at("mean_1_Pa", 350.0),
            RATIO,
            low=2.0,
            source="much smaller",
            because="a factor of two (ours)",
            inconsistency="only at low pressure or with much air: 1.03 here",
        ),
    )
    return Reproduction(statements=statements, tables={"moduli": table}, charts=(_modulus_chart(),))


DESIRED = (1.0, 10.0, 50.0, 100.0, 350.0)


@cache
def energy_shares() -> Table:
    """W_V over the pressure error, for several desired pressures and 30 % of air."""
    oil = aerated_oil(0.3)
    pressures: Array = np.geomspace(1.0, HIGH, 71) * BAR
    columns = {"pressure_Pa": Column(pressures, GAUGE_PRESSURE, "pressure, absolute")}
    for desired in DESIRED:
        values = []
        for P in pressures:
            error = float(P) - desired * BAR
            energy = energy_of_law(float(P), desired * BAR, yu_bulk_modulus, oil) if abs(error) > 1.0 else 0.0
            values.append(energy / error if abs(error) > 1.0 else 0.0)
        columns[f"from_{desired:g}_bar"] = Column(np.array(values), NUMBER, f"desired {desired:g} bar")
    return Table(title="Energy over the pressure error", columns=columns, axes=("pressure_Pa",), is_data=True)


def figure_5_4() -> Reproduction:
    """W_V over the error lies between -0.5 and 1, in fact within half of that."""
    table = energy_shares()
    values = np.concatenate([table[name] for name in table.columns if name != "pressure_Pa"])
    statements = (
        bound_statement("least of W_V over the error", values.min(), NUMBER, low=-0.5, source="from -0.5 on"),
        bound_statement(
            "largest of W_V over the error",
            values.max(),
            NUMBER,
            high=1.0,
            source="up to 1",
            note="the axes of the figure; the curves fill a fifth of them (docs/errata.md)",
        ),
    )
    names = [name for name in table.columns if name != "pressure_Pa"]
    lines = tuple(
        Line(x="pressure_Pa", y=name, colour=colour) for name, colour in zip(names, shades(len(names)), strict=True)
    )
    return figure_of(
        "figure-5.4",
        "Energy of compression per volume over the pressure error, with 30 % of air.",
        {"shares": table},
        statements,
        Lines(lines=lines, label="energy over error", x_log=True),
        height=2.8,
    )


def equation_5_14() -> Reproduction:
    """Energy per volume and per mass."""
    oil = known_drive().oil
    P, from_P = 14 * BAR, 10 * BAR
    per_volume = compression_energy_per_volume(P, from_P, oil)
    per_mass = compression_energy_per_mass(P, from_P, WARM, oil)
    rho = fluid_density(P, WARM, oil)
    return Reproduction(
        statements=(
            exact_statement(
                "energy per mass times the density, 14 bar from 10",
                per_volume,
                rho * per_mass,
                ENERGY_DENSITY,
                source="W_m = W_V/ρ",
            ),
            exact_statement(
                "energy per mass as printed, ρ W_V",
                rho * per_volume,
                per_mass,
                NUMBER,
                inconsistency="a mass ρV fills the volume V, so W_m is W_V over the density",
                contradiction=("below (5.14): W_m = ρ W_V", "5.3: W_V = W/V and W_m = W/m"),
            ),
        )
    )


def equation_5_19() -> Reproduction:
    """Proposition 1 for a constant modulus: the mean over the modulus lies between exp(-z) and 1."""
    z = 0.1
    mean = z * z / (2.0 * (math.expm1(z) - z))
    return Reproduction(
        statements=(
            bound_statement(
                "mean over modulus at a compression of 0.1, upper bound as printed",
                mean,
                RATIO,
                high=math.exp(-z),
                inconsistency="the exponent belongs inside max and min, where it varies with the pressure",
            ),
            bound_statement(
                "the same, bounds as proved", mean, RATIO, low=math.exp(-z), high=1.0, source="exp(-0.1) to 1"
            ),
        )
    )


def equation_5_36() -> Reproduction:
    """The lower bound of the storage has one square of the pressure error."""
    oil, P, from_P = aerated_oil(0.1), 14 * BAR, 10 * BAR
    energy = energy_of_law(P, from_P, yu_bulk_modulus, oil)
    mean = mean_modulus(P, from_P, yu_bulk_modulus, oil)
    g = specific_volume_exponent(P, from_P, yu_bulk_modulus, oil)
    soft = (P - from_P) / math.expm1(g)
    return Reproduction(
        statements=(
            number_statement(
                "2 β̄ times W_V over the error squared",
                1.0,
                2.0 * mean * energy / (P - from_P) ** 2,
                RATIO,
                share=1e-6,
                because="quadrature",
            ),
            number_statement(
                "the same with another square, as printed",
                1.0,
                2.0 * mean * energy / (P - from_P) ** 4,
                NUMBER,
                share=1e-6,
                inconsistency="ε is W_V over the error squared, 1/(2 β̄)",
                contradiction=("(5.36): ε P̃² ≥ W_V/P̃²", "(5.36): W_V/P̃² = 1/(2 β̄)"),
                because="quadrature",
            ),
            bound_statement(
                "softness 1/B between the ends' moduli",
                soft,
                BULK_MODULUS,
                low=yu_bulk_modulus(from_P, oil),
                high=yu_bulk_modulus(P, oil),
                source="between β(10 bar) and β(14 bar)",
            ),
        )
    )


ITEMS = (
    Item(ItemKind.FIGURE, "5.3", "Bulk modulus and mean bulk modulus", figure_5_3),
    Item(ItemKind.FIGURE, "5.4", "Energy of compression over the pressure error", figure_5_4),
    Item(ItemKind.EQUATION, "5.14", "Energy per volume and per mass", equation_5_14),
    Item(ItemKind.EQUATION, "5.19", "Mean bulk modulus, proposition 1", equation_5_19),
    Item(ItemKind.EQUATION, "5.36", "Bound of the storage", equation_5_36),
)
