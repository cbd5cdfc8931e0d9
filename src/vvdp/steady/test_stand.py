"""A system on a virtual test rig: everything prescribed held constant, so that operating points can be run one by
one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import SPEED, DutyRatio, Pressure, Speed, Temperature
from vvdp.base.rules import require_positive_value
from vvdp.evaluation.bench import RotaryBench, rotary_bench
from vvdp.evaluation.unit_rig import STIFF_COUPLING, unit_on_rig
from vvdp.fluid.oil import density, film_viscosity
from vvdp.hydraulics.orifice import orifice_area_for
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Stepping
from vvdp.steady.cycle_means import SLOWEST, CycleMeans, CyclePoint, cycle_means
from vvdp.systems.system import System
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.torque import friction_coefficient

SMALLEST_SHARE = 2e-3
"""Of the pump flow: less is taken for nothing when the load is an orifice that has to hold a pressure."""


class SetPoint(NamedTuple):
    """Setpoint of a test rig: the pressure is the mean at the load, absolute."""

    duty_ratio: DutyRatio
    load_pressure: Pressure
    pump_speed: Speed
    oil_temperature: Temperature


@dataclass(frozen=True)
class Stand:
    """A bench whose operating point can be chosen; made by `stand`.

    All that is prescribed is constant, the pump does not pulsate and nothing is watched: only what repeats itself with
    the valve has a periodic state.
    """

    bench: RotaryBench

    @property
    def name(self) -> str:
        """The name of the system."""
        return self.bench.system.name

    @property
    def model(self) -> Model:
        """The plain functions of the circuit."""
        return self.bench.system.model

    @property
    def stepping(self) -> Stepping:
        """How the system is stepped."""
        return self.bench.system.stepping

    @property
    def makes_pressure(self) -> bool:
        """Whether the load is an orifice that makes its own pressure; else a source holds it."""
        return self.bench.makes_pressure

    @property
    def reference(self) -> float:
        """Zero of gauge pressures [Pa]."""
        return self.bench.reference

    @property
    def tank_pressure(self) -> float:
        """Pressure at the tank, absolute [Pa]."""
        return self.bench.tank_pressure

    @property
    def relief_pressure(self) -> float:
        """Cracking pressure of the relief valve, absolute [Pa]."""
        return self.bench.relief_valve.cracking_pressure

    @property
    def is_driven(self) -> bool:
        """Whether a motor turns the spool."""
        return self.bench.is_driven

    @property
    def set_point(self) -> SetPoint:
        """The operating point of the system itself, at the start of its run."""
        bench, operation = self.bench, self.bench.operation
        return SetPoint(
            bench.duty_ratio.base, bench.load_pressure, operation.pump_speed.base, operation.oil_temperature.base
        )

    def pump_flow(self, point: SetPoint) -> float:
        """Flow that the pump displaces [m^3/s]."""
        flow: float = self.bench.pump.displacement * point.pump_speed
        return flow

    def with_tables(self, **tables: Mapping[str, object]) -> "Stand":
        """The same stand with some values of its tables replaced. Raises ParameterError where they contradict."""
        return Stand(self.bench.with_tables(**tables))

    def with_motor(self, pwm_frequency: float) -> "Stand":
        """The same stand with a motor that turns the spool so that it switches at `pwm_frequency` [Hz]."""
        speed = 2.0 * np.pi * pwm_frequency / self.bench.valve.sections
        return self.with_tables(spool_drive={"coupling": STIFF_COUPLING}, operation={"spool_motor_speed": speed})

    def at(self, point: SetPoint, area: float | None = None) -> RotaryBench:
        """The bench at a operating point, an orifice load with an `area` [m^2], that of the system unless given."""
        operation = {name: value for name, value in point._asdict().items() if name != "load_pressure"}
        load = {"area": area} if self.makes_pressure else {"pressure": point.load_pressure}
        return self.bench.with_tables(operation=operation, load={} if load.get("area", 1.0) is None else load)

    def case(self, point: SetPoint, means: CycleMeans, area: float | None = None) -> Case:
        """The case of a operating point from a guess of its periodic state, at a mark: load port in the middle of
        its phase.

        means  the quasi-steady averages there
        area   of an orifice load; that of the table unless given [m^2]
        """
        bench = self.at(point, area)
        return bench.starting(
            inlet_pressure=min(point.load_pressure + 5e5, self.relief_pressure + bench.relief_valve.override_pressure),
            load_pressure=point.load_pressure,
            spool_speed=guessed_speed(means, self),
            spool_angle=0.0,
        ).case

    def film_viscosity(self, point: SetPoint) -> float:
        """Viscosity of the oil in the spool's clearance [Pa s]; arrays of many points pass through as well."""
        return film_viscosity(point.oil_temperature, point.load_pressure, self.tank_pressure, self.bench.oil)

    def cycle_point(self, point: SetPoint) -> CyclePoint:
        """A operating point as the quasi-steady averages take it; arrays of many points pass through as well."""
        oil, relief = self.bench.oil, self.bench.relief_valve
        return CyclePoint(
            duty_ratio=point.duty_ratio,
            load_pressure=point.load_pressure,
            tank_pressure=self.tank_pressure,
            relief_pressure=relief.cracking_pressure,
            relief_override=relief.override_pressure,
            relief_rated_flow=relief.rated_flow,
            flow=self.pump_flow(point),
            pump_leakage=self.bench.pump.leakage_conductance,
            density=density(point.oil_temperature, oil),
            viscosity=self.film_viscosity(point),
            vapour_pressure=oil.vapour_pressure,
        )

    def means(self, point: SetPoint) -> CycleMeans:
        """The quasi-steady averages at a operating point, in plain Python."""
        return cycle_means(self.cycle_point(point), self.bench.valve)

    def leakage(self, point: SetPoint) -> float:
        """Flow from the load region to the tank [m^3/s]; arrays of many points pass through as well."""
        conductance = leakage_conductance(self.film_viscosity(point), self.bench.valve)
        return conductance * (point.load_pressure - self.tank_pressure)


def guessed_speed(means: CycleMeans, stand: Stand) -> float:
    """The spool's speed as the quasi-steady torques give it, with that of its motor if it has one [rad/s].

    k (omega_m - omega) = b (omega - omega_0), with the resistance b and the speed omega_0 that flow alone gives it.
    """
    if not stand.is_driven:
        return means.spool_speed
    k, b = stand.bench.spool_drive.coupling, means.resistance
    speed: float = (k * stand.bench.operation.spool_motor_speed.base + b * means.spool_speed) / (k + b)
    return speed


def standstill(point: SetPoint, means: CycleMeans, stand: Stand) -> str | None:
    """Why the spool has no speed at which it goes on turning, with the numbers; None where it has one."""
    if stand.is_driven or (means.spool_speed > 0.0 and means.slowness <= SLOWEST):
        return None
    if not means.spool_speed > 0.0:
        return "the spool does not turn: the flow drives it backwards or not at all"
    valve = stand.bench.valve
    friction = friction_coefficient(float(stand.film_viscosity(point)), valve)
    return (
        f"the spool does not turn: with a friction of {friction:.3g} N*m*s (valve.friction_area "
        f"{valve.friction_area:.3g} m^2) it stops where both ports are nearly closed"
    )


def load_area(point: SetPoint, means: CycleMeans, stand: Stand) -> float | None:
    """Area of an orifice that would hold the load pressure [m^2]; None where nothing is left to hold it with."""
    delivered = means.load_flow - stand.leakage(point)
    drop = point.load_pressure - stand.tank_pressure
    if delivered < SMALLEST_SHARE * stand.pump_flow(point) or drop <= 0.0:
        return None
    rho, load = float(density(point.oil_temperature, stand.bench.oil)), stand.bench.load
    assert load is not None
    return float(orifice_area_for(delivered, drop, rho, load))


def stand(system: System, verb: str = "rig") -> Stand:
    """The pump unit of `system` on a test rig. What is prescribed over time is held at its first value.

    Raises ConfigError, which names `verb`, if it has none or several, ParameterError if the pump does not turn.
    """
    bench = rotary_bench(unit_on_rig(system, verb), verb).hold()
    speed = bench.operation.pump_speed.base
    require_positive_value("operation.pump_speed", speed, SPEED)
    return Stand(bench)
