"""Claim: a rotary spool takes less power to switch than a linear one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vvdp.base.display import number, with_unit
from vvdp.base.kinds import FREQUENCY, MEAN_POWER, NUMBER
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Table, numbers_of
from vvdp.results.verdict import Statement, bound_statement, number_statement
from vvdp.rigs.ripple import power_of
from vvdp.rivals.claim import Claim
from vvdp.steady.test_stand import Stand
from vvdp.valve.geometry import nozzle_length, transition_fraction
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import friction_coefficient

LIGHT_MASS = 0.1
"""Moving mass of a light linear spool that the rotary one is compared with, besides one of its own mass [kg]."""
ACTUATION_FREQUENCIES = tuple(float(f) for f in np.round(np.geomspace(5.0, 200.0, 25), 6))
QUANTITIES = {
    "rotary_power_exponent": (NUMBER, "exponent of the PWM frequency in the power of the rotary spool"),
    "linear_power_exponent": (NUMBER, "exponent of the PWM frequency in the power of a linear spool"),
    "equal_power_same_spool_Hz": (FREQUENCY, "PWM frequency of equal power, same spool to and fro"),
    "equal_power_light_spool_Hz": (FREQUENCY, "PWM frequency of equal power, light linear spool"),
}


def rotary_actuation_power(pwm_frequency: float, sections: float, friction: float) -> float:
    """Power that turns a rotary spool against its viscous friction [W]: k_f (2 pi f / N)^2.

    pwm_frequency  [Hz]
    friction       torque over speed [N m s]

    Source  wang2017, chapter 1 and eq. 2.9
    """
    speed = 2.0 * np.pi * pwm_frequency / sections
    return friction * speed * speed


def linear_actuation_power(pwm_frequency: float, mass: float, stroke: float, transition: float) -> float:
    """Power that moves a linear spool to and fro [W]: 4 m x^2 f^3 / kappa^2.

    Constant acceleration over the first half of a stroke, constant braking over the second, within the share kappa of a
    period: the highest speed is 2 x f / kappa, and its kinetic energy is spent in each of two strokes per period.

    pwm_frequency  [Hz]
    mass           moved [kg]
    stroke         [m]
    transition     time of a stroke over the period [1]

    Source  wang2017, chapter 1, f^3; the factor is ours, docs/rigs.md
    """
    highest = 2.0 * stroke * pwm_frequency / transition
    return mass * highest * highest * pwm_frequency


def equal_power_frequency(sections: float, friction: float, mass: float, stroke: float, transition: float) -> float:
    """PWM frequency above which the linear spool takes more power than the rotary one [Hz].

    k_f (2 pi/N)^2 kappa^2 / (4 m x^2)

    Source  ours, docs/rigs.md
    """
    rotary = rotary_actuation_power(1.0, sections, friction)
    return rotary / linear_actuation_power(1.0, mass, stroke, transition)


def annular_stroke(valve: RotaryValve) -> float:
    """Stroke of a linear spool of the same diameter that opens the same area all round, to one side and the other [m].

    2 A_in / (2 pi R): the shortest that there can be.

    Source  ours, docs/rigs.md
    """
    return valve.nozzle_area / (np.pi * valve.spool_radius)


def same_ports_stroke(valve: RotaryValve) -> float:
    """Stroke with which a barrier of the same lap opens the same nozzles axially, from side to side [m].

    (1 + lap) d_a

    Source  ours, docs/rigs.md
    """
    return (1.0 + valve.lap_ratio) * nozzle_length(valve)


def spool_friction(stand: Stand) -> float:
    """Torque over speed of the spool's viscous friction at the stand's operating point [N m s]."""
    return friction_coefficient(float(stand.film_viscosity(stand.set_point)), stand.bench.valve)


def actuation_claim(stand: Stand) -> Claim:
    """Powers that move a rotary and two linear spools over the PWM frequency, and where they meet."""
    table = _table(stand)
    f, rotary, same = (table[name] for name in ("pwm_frequency_Hz", "rotary_power_W", "linear_same_power_W"))
    valve, friction = stand.bench.valve, spool_friction(stand)
    kappa = transition_fraction(valve)
    same_even, light_even = (
        float(equal_power_frequency(valve.sections, friction, mass, stroke, kappa))
        for mass, stroke in ((valve.spool_mass, same_ports_stroke(valve)), (LIGHT_MASS, annular_stroke(valve)))
    )
    numbers = {
        "rotary_power_exponent": power_of(f, rotary),
        "linear_power_exponent": power_of(f, same),
        "equal_power_same_spool_Hz": same_even,
        "equal_power_light_spool_Hz": light_even,
    }
    words = (
        "The actuation power of the rotary spool goes with the PWM frequency to the power "
        f"{number(numbers['rotary_power_exponent'], 3)}, that of a linear one to the power "
        f"{number(numbers['linear_power_exponent'], 3)}. Where they meet is a matter of mass and stroke: the same "
        f"spool moved to and fro past the same nozzles takes more from {with_unit(same_even, FREQUENCY, 3)} on, a "
        f"light one with a port all round only from {with_unit(light_even, FREQUENCY)} on."
    )
    return Claim(
        tables={"actuation": table},
        charts=(_chart(),),
        numbers=numbers_of(numbers, QUANTITIES),
        findings=(Finding(text=words),),
        statements=tuple(("section-1.1", each) for each in _statements(numbers, float(f[-1]))),
    )


def _statements(numbers: Mapping[str, float], highest: float) -> tuple[Statement, ...]:
    """Statements of the source on the powers, up to a `highest` PWM frequency [Hz]."""
    moved = (("same", "the spool itself, past the same nozzles"), ("light", "100 g, with a port all round"))
    return (
        *(
            number_statement(
                f"exponent of the frequency in the power of a {name} valve",
                power,
                numbers[f"{name}_power_exponent"],
                NUMBER,
                tolerance=1e-6,
                because="rounding",
            )
            for name, power in (("rotary", 2.0), ("linear", 3.0))
        ),
        *(
            bound_statement(
                f"PWM frequency from which a linear spool takes more power, {words}",
                numbers[f"equal_power_{name}_spool_Hz"],
                FREQUENCY,
                high=highest,
                source="a rotary valve takes much less power",
                other=numbers[f"equal_power_{second}_spool_Hz"],
                assumption=f"a linear spool of {words}; in the second run the other spool",
            )
            for (name, words), (second, _) in zip(moved, moved[::-1], strict=True)
        ),
    )


def _table(stand: Stand) -> Table:
    f: Any = np.array(ACTUATION_FREQUENCIES)
    valve = stand.bench.valve
    kappa = transition_fraction(valve)
    rotary: Any = rotary_actuation_power(f, valve.sections, spool_friction(stand))
    same: Any = linear_actuation_power(f, valve.spool_mass, same_ports_stroke(valve), kappa)
    light: Any = linear_actuation_power(f, LIGHT_MASS, annular_stroke(valve), kappa)
    return Table(
        title="Actuation power",
        columns={
            "pwm_frequency_Hz": Column(f, FREQUENCY, "PWM frequency"),
            "rotary_power_W": Column(rotary, MEAN_POWER, "rotary spool"),
            "linear_same_power_W": Column(same, MEAN_POWER, "linear, same spool and ports"),
            "linear_light_power_W": Column(light, MEAN_POWER, "linear, light spool, annular port"),
        },
    )


def _chart() -> Chart:
    lines = (
        Line(x="pwm_frequency_Hz", y=f"{name}_power_W", label=label, colour=colour, stroke=stroke)
        for name, label, colour, stroke in (
            ("rotary", "rotary, f²", Colour.LOAD, Stroke.SOLID),
            ("linear_same", "linear, same spool and ports, f³", Colour.INLET, Stroke.SOLID),
            ("linear_light", "linear, light spool and annular port, f³", Colour.INLET, Stroke.DASHED),
        )
    )
    return Chart(
        name="actuation-power",
        caption="Power that moves the spool; the linear ones spend their kinetic energy twice in each period.",
        table="actuation",
        panels=(Lines(lines=tuple(lines), label="power", x_log=True, y_log=True, legend="spool"),),
        height=2.6,
    )
