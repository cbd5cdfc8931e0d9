"""Sections 6.2 to 6.4: the equations of chapter 6 as printed and as they have to be."""

import math
from dataclasses import replace

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, FLOW, FORCE, FRACTION, NUMBER, POWER, RATE, STIFFNESS
from vvdp.control.capacities import capacities
from vvdp.control.cylinder_force import Motion, desired_force, total_effort
from vvdp.control.cylinder_storage import cylinder_balance, force_distance, force_measure
from vvdp.control.pressure_modes import Swept, mode_ends
from vvdp.control.reference import Reference, reference_at_rest
from vvdp.reproduction.chapter_6.cylinder import model_run, nominal_settings, printed_run
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.result import Column, Table
from vvdp.results.verdict import bound_statement, exact_statement, number_statement

PLACE = 0.1
"""Of the piston, where equations are calculated [m]."""
REFERENCE, MOTION, OIL_FORCE = Reference(0.1, 0.05, 0.2, 0.0), Motion(0.103, 0.04, -700.0, 100.0), 1500.0
ROUNDING = "rounding"


def _tank() -> float:
    return nominal_settings().cylinder.tank_pressure


def equation_6_3() -> Reproduction:
    """Rates of the pressures: what is pumped in between two closed ports, by the oil's compression."""
    cylinder = nominal_settings().cylinder
    found = capacities(1.0, PLACE, _tank(), cylinder)
    by_hand = cylinder.bulk_modulus * cylinder.area_a / (cylinder.oil_volume_a + cylinder.area_a * PLACE)
    return Reproduction(
        statements=(
            number_statement(
                "force per volume pumped in, extending: β A₁/(V₁ + A₁ x)",
                by_hand,
                found.supply_gain,
                NUMBER,
                share=1e-12,
                because=ROUNDING,
                note="N/m³ at 0.1 m",
            ),
        )
    )


def equation_6_4() -> Reproduction:
    """The stiffness of the oil counts the bulk modulus once."""
    cylinder = nominal_settings().cylinder
    found = capacities(1.0, PLACE, _tank(), cylinder).stiffness
    return Reproduction(
        statements=(
            exact_statement(
                "stiffness of the oil at 0.1 m",
                cylinder.bulk_modulus * found,
                found,
                STIFFNESS,
                inconsistency="the brace holds β, which (6.15), (6.16) and (6.19) have beside L",
                contradiction=("(6.4): β within the brace of L", "(6.15): β beside L"),
            ),
        )
    )


def equation_6_10() -> Reproduction:
    """A disturbance enters the rate of the storage with the sign it has in (6.1)."""
    settings, push = nominal_settings(), 50.0
    found = desired_force(REFERENCE, MOTION, OIL_FORCE, settings.gains, settings.cylinder)
    acceleration = push / settings.cylinder.moving_mass
    rate = settings.cylinder.moving_mass * found.velocity_error * acceleration
    return Reproduction(
        statements=(
            exact_statement(
                "rate of the storage by a force of 50 N",
                -found.velocity_error * push,
                rate,
                POWER,
                inconsistency="d enters (6.1) with +, and so + e_v d; (6.18), (6.20) and (6.21) likewise",
                contradiction=("(6.10): −e_v d", "(6.1): d with +"),
            ),
        )
    )


def measure_slopes() -> Table:
    """Slope of h over a stroke of 0.3 m between two chambers alike, as printed and with the other sign."""
    x: Array = np.linspace(0.0, 0.3, 301)
    a, volume = 10.77e-4, 1.2e-3
    left, right = a**2 / (volume + a * x), a**2 / (volume + a * (0.3 - x))
    columns = {
        "position_mm": Column(1e3 * x, NUMBER, "position, mm"),
        "printed": Column(1e4 * (left - right), NUMBER, "printed"),
        "built": Column(1e4 * (left + right), NUMBER, "built"),
    }
    return Table(title="Slope of h", columns=columns, axes=("position_mm",))


def equation_6_11() -> Reproduction:
    """The measure of the force has to rise with the position."""
    table, cylinder = measure_slopes(), nominal_settings().cylinder
    step = 1e-6
    slope = (force_measure(PLACE + step, cylinder) - force_measure(PLACE - step, cylinder)) / (2.0 * step)
    stiffness = capacities(1.0, PLACE, _tank(), cylinder).stiffness
    return figure_of(
        "equation-6.11",
        "Slope of h over the stroke, for two chambers alike; h has to rise to have an inverse.",
        {"slopes": table},
        (
            bound_statement(
                "least slope of h as printed, chambers alike, 10⁻⁴ m",
                float(table["printed"].min()),
                NUMBER,
                low=0.0,
                source="h has an inverse",
                inconsistency="with + the slope changes its sign at mid stroke; A₁ ln(·) − A₂ ln(·) rises",
                contradiction=("(6.11): h with +", "(6.12): the inverse of h"),
            ),
            number_statement(
                "β times the slope of h as built",
                stiffness,
                cylinder.bulk_modulus * slope,
                STIFFNESS,
                share=1e-6,
                because="difference quotient",
                source="β L(x)",
            ),
        ),
        over("position_mm", "printed", "built", label="h', cm²/m"),
        height=2.4,
    )


def equation_6_12() -> Reproduction:
    """The distance by which the piston is off where the oil gives another force."""
    cylinder, error = nominal_settings().cylinder, 5e3
    distance = force_distance(error, PLACE, cylinder)
    measured = force_measure(PLACE + distance, cylinder) - force_measure(PLACE, cylinder)
    return Reproduction(
        statements=(
            exact_statement(
                "β (h(x + d) − h(x)) for a force error of 5 kN", error, cylinder.bulk_modulus * measured, FORCE
            ),
        )
    )


def equation_6_19() -> Reproduction:
    """The total effort, and the robust term in it."""
    settings = nominal_settings()
    desired = desired_force(REFERENCE, MOTION, OIL_FORCE, settings.gains, settings.cylinder)
    stiffness = capacities(1.0, MOTION.position, _tank(), settings.cylinder).stiffness
    robust = replace(settings.gains, robust_rate=0.7)
    alone = total_effort(stiffness, desired, OIL_FORCE, 1.0, settings.gains)
    error = OIL_FORCE - desired.force
    by_hand = stiffness * desired.reference_velocity + desired.rate - settings.gains.pressure_rate * error
    added = total_effort(stiffness, desired, OIL_FORCE, 1.0, robust) - alone
    return Reproduction(
        statements=(
            exact_statement("U* = β L r + rate of F_v − λ₃ β (F_H − F_v)", by_hand, alone, NUMBER),
            exact_statement(
                "what u_rob adds, K_rob β = 0.7 1/s",
                -0.7 * settings.cylinder.bulk_modulus * error,
                added,
                NUMBER,
                inconsistency="(6.19) multiplies u_rob by β, so u_rob itself has none",
                contradiction=("below (6.20): u_rob = −K_rob β F̃", "(6.19): u_rob times β"),
            ),
        )
    )


def equation_6_21() -> Reproduction:
    """How fast the storage of the force falls, and whether the robust gain is needed for it."""
    settings, speed = nominal_settings(), 0.1
    cylinder = settings.cylinder
    x: Array = np.linspace(cylinder.lowest_position, cylinder.highest_position, 301)
    Va, Vb = cylinder.oil_volume_a + cylinder.area_a * x, cylinder.oil_volume_b - cylinder.area_b * x
    bend = np.abs(-(cylinder.area_a**3) / Va**2 + cylinder.area_b**3 / Vb**2).max()
    slenderness = cylinder.area_a**2 / Va + cylinder.area_b**2 / Vb
    needed = float(bend / slenderness.min()) * speed
    still = desired_force(reference_at_rest(PLACE), MOTION, 0.0, settings.gains, cylinder)
    balance = cylinder_balance(still.rate, still, MOTION, still.force, settings.gains, cylinder)
    return Reproduction(
        statements=(
            bound_statement(
                "γ_F β |r| at 0.1 m/s, beside λ₃ β",
                needed,
                RATE,
                high=settings.gains.pressure_rate,
                source="λ₃ + K_rob > γ_F",
                note="(6.21) has γ_F alone, (6.20) the term with r and L; K_rob may be 0",
            ),
            bound_statement(
                "storage where position and speed are off and the force is right",
                balance.storage,
                NUMBER,
                low=0.0,
                source="positive",
            ),
        )
    )


def equation_6_25() -> Reproduction:
    """The direction as the bare sign of the effort."""
    return Reproduction(
        statements=(
            number_statement(
                "switches in 16 s with the bare sign",
                model_run().number("directional_switches"),
                printed_run().number("directional_switches"),
                COUNT,
                source="no chattering: 3, one at each reversal",
                inconsistency="on a switch the delivered flow changes sides in H Q and moves U* back",
            ),
        )
    )


def equation_6_28() -> Reproduction:
    """The estimate of the flow with and without the flow that is expected."""
    found, printed = (run.number("return_opening_mean") for run in (model_run(), printed_run()))
    return Reproduction(
        statements=(
            number_statement(
                "mean opening without the expected flow",
                found,
                printed,
                FRACTION,
                tolerance=0.02,
                because="0.02 (ours): the same law otherwise",
                source="that of (6.30), with the expected flow",
                inconsistency="(6.28) leaves out the flow that (6.30) has, and two names stand for one estimate",
                contradiction=("(6.28): −λ_Q Q̂", "(6.30): with the expected flow"),
            ),
        )
    )


def equation_6_30() -> Reproduction:
    """Flow and opening give the same effort in any proportion: the sum of the pressures is left open."""
    cylinder, psi, speed = nominal_settings().cylinder, 1e-4, 0.05
    capacity = capacities(1.0, PLACE, _tank(), cylinder)
    Va, Vb = cylinder.oil_volume_a + cylinder.area_a * PLACE, cylinder.oil_volume_b - cylinder.area_b * PLACE

    def rates(flow: float, opening: float) -> tuple[float, float]:
        a, b = flow - cylinder.area_a * speed, cylinder.area_b * speed - psi * opening
        return cylinder.bulk_modulus / Va * a, cylinder.bulk_modulus / Vb * b

    more = 0.3 * capacity.return_gain * psi / capacity.supply_gain
    one, other = rates(1e-4, 0.5), rates(1e-4 + more, 0.2)
    force = [cylinder.area_a * a - cylinder.area_b * b for a, b in (one, other)]
    return Reproduction(
        statements=(
            number_statement(
                "rate of the force, more flow and less opening, over that with less flow and more opening",
                1.0,
                force[1] / force[0],
                NUMBER,
                tolerance=1e-9,
                because=ROUNDING,
                source="the same effort",
            ),
            number_statement(
                "difference of the rates of both pressures' sum, Pa/s",
                0.0,
                sum(other) - sum(one),
                NUMBER,
                tolerance=1.0,
                because=ROUNDING,
                source="the law controls the cylinder (6.3.3)",
                inconsistency="one of its two pressures only; split and modes alone hold the sum",
            ),
        )
    )


def equation_6_34() -> Reproduction:
    """Mode 2 beside a piston that stands."""
    bounds = nominal_settings().bounds
    still = mode_ends(Swept(0.0, 0.0), 1e-4, 0.0, bounds).filling
    moving = Swept(10.77e-4 * 0.05, 20.26e-4 * 0.05)
    return Reproduction(
        statements=(
            bound_statement(
                "flow into an empty chamber whose piston stands",
                still,
                FLOW,
                low=1e-9,
                source="the pressure rises again",
                inconsistency="(6.34) asks for none there; a boost of 0.5 lpm is built in",
                contradiction=("6.4, mode 2: the pressure rises again", "(6.34): no flow where the piston stands"),
            ),
            bound_statement(
                "flow less what the piston sweeps, moving at 5 cm/s",
                mode_ends(moving, 1e-4, 0.0, bounds).filling - moving.supply,
                FLOW,
                low=0.0,
                source="Q above −A₂ x' (6.34); the words have Q below it",
            ),
        )
    )


def equation_6_40() -> Reproduction:
    """Mode 5 is a lower bound of the opening, and its margin has to be above 1 for either way."""
    bounds, psi = nominal_settings().bounds, 1e-4
    way_out, way_back = (
        mode_ends(Swept(0.0, q), psi, 0.0, bounds).letting * psi for q in (math.copysign(8e-5, s) for s in (1.0, -1.0))
    )
    half = mode_ends(Swept(0.0, -8e-5), psi, 0.0, replace(bounds, return_margin=0.5)).letting * psi
    return Reproduction(
        statements=(
            bound_statement(
                "what the valve lets out beyond what the piston brings",
                way_out - 8e-5,
                FLOW,
                low=0.0,
                source="the pressure falls",
                note="printed as an upper bound of u, and to reduce the pressure",
            ),
            bound_statement(
                "what it lets out while the piston goes the other way, ζ_u = 1.2",
                way_back,
                FLOW,
                low=0.0,
                source="the pressure falls",
            ),
            bound_statement(
                "the same, ζ_u = 0.5",
                half,
                FLOW,
                high=0.0,
                source="ζ_u > 1: with less it does not fall",
            ),
        )
    )


ITEMS = (
    Item(ItemKind.EQUATION, "6.3", "Rates of the chamber pressures", equation_6_3),
    Item(ItemKind.EQUATION, "6.4", "Rate of the hydraulic force", equation_6_4),
    Item(ItemKind.EQUATION, "6.10", "Rate of the mechanical storage", equation_6_10),
    Item(ItemKind.EQUATION, "6.11", "The measure h of the force", equation_6_11),
    Item(ItemKind.EQUATION, "6.12", "Distance that stands for a force error", equation_6_12),
    Item(ItemKind.EQUATION, "6.19", "The total effort", equation_6_19),
    Item(ItemKind.EQUATION, "6.21", "Decay of the storage", equation_6_21),
    Item(ItemKind.EQUATION, "6.25", "Direction of the flow", equation_6_25),
    Item(ItemKind.EQUATION, "6.28", "Estimate of the flow", equation_6_28),
    Item(ItemKind.EQUATION, "6.30", "Distribution of the effort", equation_6_30),
    Item(ItemKind.EQUATION, "6.34", "Mode 2", equation_6_34),
    Item(ItemKind.EQUATION, "6.40", "Mode 5", equation_6_40),
)
