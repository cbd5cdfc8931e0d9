"""Sections 5.2, 5.4 and 5.5: reach, gains, certificates, observability."""

import math

import numpy as np

from vvdp.base.kinds import COUNT, FREQUENCY, GAUGE_PRESSURE, NUMBER, POSITION, RATIO
from vvdp.base.units import ATMOSPHERE
from vvdp.control.backstepping import BacksteppingGains
from vvdp.control.chamber import (
    ChamberReading,
    PositionGains,
    desired_pressure,
    desired_rate_sensitivities,
    volume_compliance,
)
from vvdp.control.passivity import exact_feedforward
from vvdp.control.reference import Reference
from vvdp.control.storage import pressure_balance, pressure_storage
from vvdp.control.tuning import backstepping_certificate
from vvdp.estimation.observability import (
    analytic_grammian,
    observability_margin,
    unobservable_speeds,
    without_noise,
)
from vvdp.reproduction.chapter_5.chamber import HELIX, TURN, known_drive, middle_compliance
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, exact_statement, number_statement

GAINS = PositionGains(error_rate=50.0, position_gain=55.0, velocity_gain=4.0)
SUPPLY = 190.0 * 6894.757
DRIVEN = 22.5 * TURN
HARMONICS = 5
ROUNDING = "rounding"


def equation_5_1() -> Reproduction:
    """How far the supply lifts the plunger against its spring."""
    drive = known_drive()
    reach = (SUPPLY * drive.area - drive.preload) / drive.stiffness
    return Reproduction(
        statements=(
            bound_statement(
                "farthest position that 190 psi hold",
                reach,
                POSITION,
                low=HELIX * 1e-3,
                source="the full range of the duty ratio: 20.32 mm (chapter 4)",
                inconsistency="spring, preload and area of 5.2 allow a third of it; 220 psi would do",
                contradiction=("5.7.1: 190 psi and the full range of the duty ratio", "5.2: spring, preload and area"),
            ),
            number_statement(
                "pressure that holds the plunger at 0",
                211.5 / 1.74e-4,
                drive.preload / drive.area,
                GAUGE_PRESSURE,
                share=1e-6,
                because=ROUNDING,
                source="211.5 N on 1.74 cm²",
            ),
        )
    )


def equation_5_25() -> Reproduction:
    """The rate of the pressure's storage by difference quotient, against its balance."""
    drive, flow, h = known_drive(), 2e-6, 1e-7
    reference, P = Reference(3e-3, 0.05, 1.0, 0.0), 13e5 + ATMOSPHERE
    place = ChamberReading(2.9e-3, 0.04, P)
    wanted = desired_pressure(reference, place, GAINS, drive)
    held = exact_feedforward(wanted, place, drive)
    balance = pressure_balance(held + flow, wanted, place, drive)

    def later(sign: float) -> float:
        compliance = volume_compliance(place.position, P, drive)
        rate = (held + flow - drive.area * place.velocity) / compliance
        there = ChamberReading(place.position + sign * h * place.velocity, place.velocity, P + sign * h * rate)
        moved = wanted._replace(pressure=wanted.pressure + sign * h * wanted.rate)
        return pressure_storage(moved, there, drive)

    quotient = (later(1.0) - later(-1.0)) / (2.0 * h)
    return Reproduction(
        statements=(
            number_statement(
                "rate of the storage: difference quotient beside (p + W_V)(Q − Q_d) − p A e_v, W",
                balance.supply,
                quotient,
                NUMBER,
                share=1e-4,
                because="difference quotient",
            ),
        )
    )


def equation_5_31() -> Reproduction:
    """The three factors of the desired pressure's rate, which the text leaves out."""
    alpha = desired_rate_sensitivities(GAINS, known_drive())
    drive = known_drive()
    total = drive.moving_mass * 50.0 + 4.0
    by_hand = (
        (total * (drive.stiffness + 55.0) / drive.moving_mass - 50.0 * (drive.moving_mass * 2500.0 - 55.0))
        / drive.area,
        (total * 4.0 / drive.moving_mass + drive.moving_mass * 2500.0 - 55.0) / drive.area,
        -(50.0 + 4.0 / drive.moving_mass),
    )
    names = ("α_e, Pa/(m s)", "α_ev, Pa/m", "α_P, 1/s")
    return Reproduction(
        statements=tuple(
            exact_statement(name, value, found, NUMBER, note="not printed; from (5.29) by hand")
            for name, value, found in zip(names, by_hand, alpha, strict=True)
        )
    )


def equation_5_41() -> Reproduction:
    """Whether the gains of table 5.1 satisfy the author's own condition."""
    gains = BacksteppingGains(
        error_rate=50.0, position_gain=550.0, velocity_gain=45.0, pressure_weight=3e-12, flow_gain=4e-10
    )
    own, soft = (backstepping_certificate(each, gains, known_drive()) for each in (middle_compliance(), 3e-12))
    inverse = 1e12
    return Reproduction(
        statements=(
            bound_statement(
                "margin of the gains of table 5.1, V/β = 3e-12 m³/Pa, 1e-12 m³/(s Pa)",
                inverse * soft.margin,
                NUMBER,
                low=0.0,
                source="positive definite",
                inconsistency="with the text's λ₂ = V/β the damping α_P λ₂ outweighs λ₃; sufficient, not necessary",
            ),
            bound_statement(
                "the same, V/β of 10 % air at 12 bar",
                inverse * own.margin,
                NUMBER,
                low=0.0,
                source="positive definite",
            ),
        )
    )


def equation_5_47() -> Reproduction:
    """The entry of the Grammian that belongs to the velocity."""
    gamma = math.sqrt(known_drive().stiffness / known_drive().moving_mass)
    T = TURN / DRIVEN
    printed = (0.5 * T + math.sin(2.0 * gamma * T) / (4.0 * gamma)) / gamma**2
    found = analytic_grammian(gamma, DRIVEN, HARMONICS).plant[1, 1]
    times = np.linspace(0.0, T, 20001)
    by_quadrature = float(np.trapezoid((np.sin(gamma * times) / gamma) ** 2, times))
    return Reproduction(
        statements=(
            exact_statement(
                "Ψ₂₂ at 22.5 Hz, 1e-6",
                1e6 * printed,
                1e6 * found,
                NUMBER,
                inconsistency="it is the integral of φ₁₂², with a minus",
                contradiction=("(5.47): Ψ₂₂ = ∫φ₂₂²", "(5.44): the output is the position"),
            ),
            number_statement(
                "the same by quadrature, 1e-6",
                1e6 * by_quadrature,
                1e6 * found,
                NUMBER,
                share=1e-6,
                because="quadrature",
            ),
        )
    )


def margins() -> Table:
    """The observability margin over the spool's speed."""
    gamma = math.sqrt(known_drive().stiffness / known_drive().moving_mass)
    speeds = np.linspace(2.0, 30.0, 561)
    values = [observability_margin(gamma, TURN * f, HARMONICS) for f in speeds.tolist()]
    columns = {
        "speed_Hz": Column(speeds, FREQUENCY, "spool speed"),
        "margin": Column(np.array(values), RATIO, "margin"),
    }
    return Table(title="Observability margin", columns=columns, axes=("speed_Hz",), is_data=True)


def _observability(gamma: float, highest: float, rank: int) -> tuple[Statement, ...]:
    return (
        bound_statement(
            "margin at 22.5 Hz",
            observability_margin(gamma, DRIVEN, HARMONICS),
            RATIO,
            low=1e-3,
            source="observable",
        ),
        exact_statement(
            "highest speed at which position and velocity are lost, over √(K/M)",
            1.0,
            highest / gamma,
            RATIO,
            source="a harmonic of the spool's speed on the plant's frequency",
        ),
        number_statement(
            "directions of the plant that are seen there",
            1,
            rank,
            COUNT,
            source="the Grammian loses a rank",
            inconsistency="position and velocity are both lost: two ranks",
        ),
        bound_statement(
            "plant's frequency within the speeds of chapter 4, 9.8 to 13 Hz",
            gamma / TURN,
            FREQUENCY,
            low=9.8,
            high=13.0,
            source="not spoken of",
            note="with the drive of chapter 5 those speeds would hardly be observable",
        ),
    )


def section_5_5() -> Reproduction:
    """Theorem 5.5.1: when position and periodic sensor error can be distinguished."""
    gamma = math.sqrt(known_drive().stiffness / known_drive().moving_mass)
    lost = unobservable_speeds(gamma, HARMONICS)
    left = without_noise(analytic_grammian(gamma, float(lost[0]), HARMONICS))
    rank = int(np.sum(np.abs(np.linalg.eigvalsh(left * np.outer((1.0, gamma), (1.0, gamma)))) > 1e-9))
    return figure_of(
        "section-5.5",
        "Observability margin over the spool's speed, five harmonics; 1 is as good as without periodic sensor error.",
        {"margins": margins()},
        _observability(gamma, float(lost[0]), rank),
        over("speed_Hz", "margin", label="margin"),
        height=2.4,
    )


ITEMS = (
    Item(ItemKind.EQUATION, "5.1", "Balance of the plunger", equation_5_1),
    Item(ItemKind.EQUATION, "5.25", "Rate of the pressure's storage", equation_5_25),
    Item(ItemKind.EQUATION, "5.31", "Factors of the desired pressure's rate", equation_5_31),
    Item(ItemKind.EQUATION, "5.41", "Condition for the backstepping gains", equation_5_41),
    Item(ItemKind.EQUATION, "5.47", "Grammian of the drive", equation_5_47),
    Item(ItemKind.SECTION, "5.5", "Observability under a periodic noise", section_5_5),
)
