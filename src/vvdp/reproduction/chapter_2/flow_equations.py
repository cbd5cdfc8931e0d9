"""Sections 2.2 and 2.3: the flow's equations, the oil, the pump and its motor."""

from vvdp.base.kinds import DYNAMIC_VISCOSITY, FLOW, KINEMATIC_VISCOSITY, NUMBER, POWER, PRESSURE_LEVEL
from vvdp.base.known_units import known_unit
from vvdp.base.units import ATMOSPHERE
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.reproduction.chapter_2 import valve as here
from vvdp.reproduction.chapter_2.computed import kept_or_none
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.verdict import Statement, bound_statement, digit_statement, missing_statement, number_statement

INERTIA = "kg/(m^2*s^2)"
"""Unit of rho (v . grad) v."""
WARM = 313.15
PUMP, PUMP_SPEED, MOTOR = 22.8e-6, 1800.0 / 60.0, 5.6e3


def equation_2_1() -> Reproduction:
    """The momentum of the flow: its terms have one dimension, the Laplacian of a pressure has another."""
    inertia, *pressures = (known_unit(unit) for unit in (INERTIA, "Pa/m", "Pa/m^2"))
    gradient, laplacian = (float(bool(inertia and each and inertia.powers == each.powers)) for each in pressures)
    return Reproduction(
        statements=(
            number_statement("rho (v · ∇) v and ∇P have one dimension", 1.0, gradient, result="yes", source="−∇P"),
            number_statement(
                "rho (v · ∇) v and ΔP have one dimension",
                1.0,
                laplacian,
                result="no",
                source="−ΔP",
                inconsistency="∇P is in N/m³ as the other terms, ΔP in Pa/m²: −∇P is meant",
                contradiction=("(2.1): ρ (v · ∇) v, in N/m³", "(2.1): −ΔP, in Pa/m²"),
            ),
        )
    )


def equation_2_2() -> Reproduction:
    """Continuity: what leaves a computed rail is what enters it."""
    study = kept_or_none("rail-designs")
    what, source = "flow out of five computed rails less flow in, over it", "∇ · v = 0"
    if study is None:
        return Reproduction(statements=(missing_statement(what, source, "the study rail-designs"),))
    worst = float(abs(study["mass_imbalance"]).max())
    return Reproduction(
        statements=(bound_statement(what, worst, NUMBER, high=1e-3, source=source, because="residuals of the solver"),)
    )


def section_2_2() -> Reproduction:
    """Pump, motor and flow of the apparatus."""
    flow = PUMP * PUMP_SPEED
    drop = sum(here.open_drops())
    return Reproduction(
        statements=(
            digit_statement(
                "flow of 22.8 cc at 1800 rpm",
                here.FLOW,
                flow,
                FLOW,
                tolerance=0.5 * here.LPM,
                note="both hold with a volumetric efficiency of 97.5 %, which is not printed",
            ),
            bound_statement(
                "mean inlet pressure that the motor can hold at 40 lpm",
                MOTOR / here.FLOW + ATMOSPHERE,
                PRESSURE_LEVEL,
                low=drop + ATMOSPHERE,
                source="a motor of 5.6 kW",
                because="the open valve alone, against no load",
                note="100 bar at duty ratio 1 is beyond it",
            ),
            number_statement(
                "rated power of the motor",
                MOTOR,
                here.stand().bench.rated_power,
                POWER,
                share=1e-9,
                because="as printed",
            ),
        )
    )


def section_2_3() -> Reproduction:
    """The oil at 40 degC; the cells of the grids stand with Figs. 2.7 to 2.9."""
    oil = here.stand().bench.oil
    viscosity = float(dynamic_viscosity(WARM, oil))
    return Reproduction(
        statements=(
            digit_statement("dynamic viscosity at 40 °C", here.VISCOSITY, viscosity, DYNAMIC_VISCOSITY, tolerance=5e-5),
            digit_statement(
                "kinematic viscosity that density and viscosity make",
                44.2e-6,
                here.VISCOSITY / here.DENSITY,
                KINEMATIC_VISCOSITY,
                tolerance=5e-8,
                source="DTE 25: 44.2 mm²/s (data sheets of such oils)",
            ),
            _density_statement(float(density(WARM, oil))),
        )
    )


def _density_statement(found: float) -> Statement:
    return digit_statement(
        "density at 40 °C [kg/m³]",
        here.DENSITY,
        found,
        NUMBER,
        tolerance=0.5,
        other=861.0,
        assumption="that 876 kg/m³ belong to 40 °C, as is stated; in the second run to 15 °C, as in data sheets",
    )


EQUATION, SECTION = ItemKind.EQUATION, ItemKind.SECTION
ITEMS = (
    Item(EQUATION, "2.1", "Momentum of the flow", equation_2_1),
    Item(EQUATION, "2.2", "Continuity of the flow", equation_2_2),
    Item(SECTION, "2.2", "Pump, motor and flow of the apparatus", section_2_2),
    Item(SECTION, "2.3", "Oil of the computed flows", section_2_3),
)
