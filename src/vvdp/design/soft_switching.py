"""Soft switching of a valve: what it takes, as assumed for every valve, and its means over a PWM period.

A check valve past the load port carries the flow while that port is partly open; a chamber, released while the tank
port is, takes it at low pressure. Derived in docs/models/soft-switching.md.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import PRESSURE_LEVEL, Flow, Frequency, Power, Volume
from vvdp.base.tables import Table, copy_tables
from vvdp.design.quantities import Quantities, Setup, quantities, switching_condition
from vvdp.evaluation.rig_drawing import COMPONENTS
from vvdp.fluid.oil import density, film_viscosity
from vvdp.hydraulics.check_valve import CheckValve, check_flow
from vvdp.hydraulics.orifice import orifice_flow
from vvdp.hydraulics.soft_switching import Mouth, SwitchChamber, released_area
from vvdp.systems.changed import entries, exact_text
from vvdp.systems.system import System
from vvdp.valve.branch import BranchFlow, BranchLaw, branch_law, throttled_flow
from vvdp.valve.flow_map import highest_inlet_pressure, static_relief_flow
from vvdp.valve.geometry import EVEN, Openings, port_shape, shape_openings
from vvdp.valve.torque import friction_coefficient, pwm_frequency, spool_torque

ANGLES = 400
COARSE = 100
"""Equally spaced over a PWM period, and as many as a search takes."""
FINER = 16
"""Pieces of an angle in which the chamber is released or locked, which takes only a part of it."""
PERIODS = 4
"""Until the oil in the chamber comes back: it empties in each of them, where it can."""
CLOSED = BranchFlow(0.0, 0.0, 1.0, 0.0, 0.0)


class Softening(NamedTuple):
    """A check valve past the load port, the chamber beside it (None without one) and its mouth."""

    bypass: CheckValve
    chamber: SwitchChamber | None
    mouth: Mouth = Mouth()


class SoftMeans(NamedTuple):
    """Means over a PWM period: power lost in valve, check valve and at the chamber's mouth without leakage, flow to
    the load, PWM frequency, and the most oil that the chamber held."""

    loss: Power
    load_flow: Flow
    pwm_frequency: Frequency
    held: Volume


class _Instant(NamedTuple):
    """The circuit at one angle; `load_flow` with what the check valve passes [Pa, m^3/s]."""

    inlet_pressure: float
    load: BranchFlow
    tank: BranchFlow
    load_flow: float
    chamber_flow: float


def usual_bypass(flow: float) -> CheckValve:
    """A check valve for a pump flow [m^3/s]: 0.5 bar to crack, 5 bar at that flow; assumed."""
    return CheckValve(cracking_pressure=5e4, rated_drop=5e5, rated_flow=flow)


def soft_rig(rig: System, soft: Softening) -> System:
    """A test rig with the check valve and the chamber drawn into its file. Raises ConfigError with all faults."""
    content = copy_tables(rig.table.content)
    content["components"]["bypass"] = {**COMPONENTS["bypass"], **entries(soft.bypass)}
    if soft.chamber is not None:
        start = exact_text(soft.chamber.precharge_pressure, PRESSURE_LEVEL)
        content["nodes"]["chamber"] = {"type": "vessel", "start": start, **entries(soft.chamber)}
        opening = {"from": "valve.tank_opening"}
        content["components"]["mouth"] = {**COMPONENTS["mouth"], "opening": opening, **entries(soft.mouth)}
    content["components"] = {name: content["components"][name] for name in COMPONENTS if name in content["components"]}
    return rig.read_from(Table(rig.name, content, {}))


def soft_means(at: Setup, soft: Softening, angles: int = ANGLES) -> SoftMeans:
    """Quasi-steady means with soft switching: stiff oil, constant pressures at load and tank, a spool of even speed.

    What the chamber holds follows from the flow at its mouth from one of the `angles` to the next, over periods of the
    frequency at which the torques balance. What it keeps from period to period counts as lost, at the load's pressure.
    """
    circuit = _circuit(at, soft)
    parts = _parts(at, soft, angles)
    held, first, most, frequency = 0.0, 0.0, 0.0, float(quantities(at).pwm_frequency)
    rows = np.zeros((len(parts), 5))
    for _ in range(PERIODS):
        last, first, most = None, held, 0.0
        for number, part in enumerate(parts):
            duration = part.share / frequency
            middle = max(held + 0.5 * duration * rows[number - 1][4], 0.0)
            if (part.openings, middle) != last:
                rows[number], last = circuit.row(part.openings, middle, held / duration), (part.openings, middle)
            else:
                rows[number] = rows[number - 1]
            held = max(held + duration * rows[number][4], 0.0)
            most = max(most, held)
        pressure, load_flow, at_rest, lost, _ = np.average(rows, axis=0, weights=[part.share for part in parts])
        speed = (at_rest + at.coupling * at.spool_motor_speed) / (lost + at.coupling)
        frequency = float(pwm_frequency(speed, at.valve))
    rise = at.load_pressure - at.tank_pressure
    kept = frequency * max(held - first, 0.0) * rise
    loss = at.flow * (pressure - at.tank_pressure) - load_flow * rise + kept
    return SoftMeans(float(loss), float(load_flow), frequency, most)


def soft_quantities(at: Setup, soft: Softening) -> Quantities:
    """`quantities` with what soft switching makes of transitions, load flow and efficiency."""
    hard, means = quantities(at), soft_means(at, soft)
    transition = means.loss - hard.loss_full_open
    passed = (at.load_pressure - at.tank_pressure) * means.load_flow
    put_in = passed + means.loss + hard.spool_drive_power
    return hard._replace(
        loss_transition=transition,
        loss_total=hard.loss_total - hard.loss_transition + transition,
        load_flow=means.load_flow,
        input_power=passed + means.loss,
        efficiency=(passed - hard.loss_leakage - hard.loss_compressibility) / put_in,
    )


def best_chamber(at: Setup, bypass: CheckValve) -> SwitchChamber:
    """The chamber whose precharge loses least, sought from 1.1 to 4 times the drop of the open valve.

    It hardly depends on the load: the chamber stands between the inlet and the tank port.
    """
    from scipy.optimize import minimize_scalar

    drop = float(quantities(at).pressure_drop_total)

    def loss(over_drop: float) -> float:
        chamber = SwitchChamber(precharge_pressure=at.tank_pressure + over_drop * drop)
        return soft_means(at, Softening(bypass, chamber), COARSE).loss

    found = minimize_scalar(loss, bounds=(1.1, 4.0), method="bounded", options={"xatol": 0.05})
    return SwitchChamber(precharge_pressure=at.tank_pressure + float(found.x) * drop)


class _Part(NamedTuple):
    """A share of a period, and the open fractions in its middle."""

    share: float
    openings: Openings


def _parts(at: Setup, soft: Softening, count: int) -> list[_Part]:
    """A period from the middle of the load phase on, in `count` even parts; those in which the chamber is released or
    locked in `FINER` each."""
    shape, place = port_shape(at.valve), at.duty_ratio * at.valve.helix_length
    turn = 2.0 * np.pi / at.valve.sections

    def openings(share: float) -> Openings:
        return Openings(*map(float, shape_openings(turn * share, place, shape)))

    release = 0.0 if soft.chamber is None else soft.mouth.release_opening
    found = []
    for number in range(count):
        ends = [openings((number + end) / count).tank for end in (0, 1)]
        pieces = FINER if min(ends) < release and max(ends) > 0.0 else 1
        found += [_Part(1.0 / (count * pieces), openings((number + (k + 0.5) / pieces) / count)) for k in range(pieces)]
    return found


@dataclass(frozen=True)
class _Circuit:
    """The parts that join at the inlet: pump, both branches of the valve, relief valve, check valve and chamber."""

    at: Setup
    soft: Softening
    density: float
    law: BranchLaw

    def row(self, openings: Openings, held: float, emptying_flow: float) -> Array:
        """Inlet pressure, flow to the load, torque at rest, torque lost per speed and flow into the chamber; where that
        would give more than `emptying_flow` [m^3/s], what is left is given in a part of the time."""
        now = self._instant(openings, held)
        row = np.array([now.inlet_pressure, now.load_flow, *_torques(now, openings, self.at), now.chamber_flow])
        if now.chamber_flow >= -emptying_flow:
            return row
        share = emptying_flow / -now.chamber_flow
        return share * row + (1.0 - share) * self.row(openings, 0.0, 0.0)

    def _instant(self, openings: Openings, held: float) -> _Instant:
        """The instant at which everything takes the pump flow, `held` the oil in the chamber [m^3]."""
        from scipy.optimize import brentq

        at, (_, chamber, mouth) = self.at, self.soft
        relief = (at.relief_pressure, at.relief_override, at.relief_rated_flow)
        area = 0.0 if chamber is None else float(released_area(openings.tank, mouth))
        behind = 0.0 if chamber is None else _gas_pressure(held, chamber)

        def flows(pressure: float) -> tuple[BranchFlow, BranchFlow, float, float]:
            load = self._branch(pressure, at.load_pressure, openings.load)
            tank = self._branch(pressure, at.tank_pressure, openings.tank)
            taken = 0.0 if area == 0.0 else float(orifice_flow(area, pressure - behind, self.density, mouth))
            passed = float(check_flow(pressure - at.load_pressure, self.soft.bypass))
            return load, tank, passed, taken if held > 0.0 else max(taken, 0.0)

        def surplus(pressure: float) -> float:
            load, tank, passed, taken = flows(pressure)
            opens = pressure > at.relief_pressure
            spilled = static_relief_flow(pressure, *relief, at.tank_pressure) if opens else 0.0
            return float(load.flow + tank.flow + passed + taken + spilled - at.flow)

        highest = highest_inlet_pressure(at.flow, *relief)
        is_relieved = surplus(highest) <= 0.0
        pressure = highest if is_relieved else float(brentq(surplus, 0.5 * at.tank_pressure, highest, xtol=1e-3))
        load, tank, passed, taken = flows(pressure)
        return _Instant(pressure, load, tank, float(load.flow) + passed, taken)

    def _branch(self, pressure: float, behind: float, opening: float) -> BranchFlow:
        """Flow of a branch; none where its port is closed."""
        return throttled_flow(pressure, behind, opening, self.law) if opening > 0.0 else CLOSED


def _circuit(at: Setup, soft: Softening) -> _Circuit:
    condition = switching_condition(at)
    law = branch_law(condition.density, at.valve, condition.vapour_pressure)
    return _Circuit(at, soft, float(condition.density), law)


def _gas_pressure(held: float, chamber: SwitchChamber) -> float:
    """Pressure of the gas behind so much oil [Pa, absolute]."""
    left = 1.0 - min(held / chamber.gas_volume, 0.99)
    return float(chamber.precharge_pressure * left**-chamber.gas_exponent)


def _torques(now: _Instant, openings: Openings, at: Setup) -> tuple[float, float]:
    """Torque on the spool at rest [N m], and what it loses per speed [N m s]."""
    rho = density(at.temperature, at.oil)
    mu = film_viscosity(at.temperature, at.load_pressure, at.tank_pressure, at.oil)
    k_f = friction_coefficient(mu, at.valve)
    still = spool_torque(now.load, now.tank, openings, EVEN, 0.0, rho, k_f, at.valve)
    moving = spool_torque(now.load, now.tank, openings, EVEN, 1.0, rho, k_f, at.valve)
    return float(still.turbine), float(still.turbine - moving.turbine + moving.friction)
