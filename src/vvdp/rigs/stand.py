"""A system on a virtual test stand: everything prescribed held constant, so that set points can be run one by one."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import DutyRatio, Pressure, Speed, Temperature
from vvdp.base.signal import Signal, constant, signal_value
from vvdp.circuits.supply import Operation, SupplyParams
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.hydraulics.orifice import orifice_area_for
from vvdp.rigs.cycle import SLOWEST, CycleMeans, CyclePoint, cycle_means
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Stepping
from vvdp.systems.benches import BENCHES, Bench, DutyOperation
from vvdp.systems.system import System
from vvdp.systems.watching import WATCHING
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.torque import friction_coefficient

ORIFICE_LOAD = "orifice-load"
STIFF_COUPLING = 1.0
"""Of a motor that holds the spool at its own speed [N m s]."""
SMALLEST_SHARE = 2e-3
"""Of the pump flow: less is taken for nothing when the load is an orifice that has to hold a pressure."""


class SetPoint(NamedTuple):
    """What a test stand holds: the pressure is the mean at the load, absolute."""

    duty_ratio: DutyRatio
    load_pressure: Pressure
    pump_speed: Speed
    oil_temperature: Temperature


@dataclass(frozen=True)
class Stand:
    """A system whose set point can be chosen; made by `stand`.

    `tables` are those of the system with constants only, without pump ripple and without encoder: only what repeats
    itself with the valve has a periodic state.
    """

    system: System = field(repr=False)
    tables: Mapping[str, Any] = field(repr=False)

    @property
    def bench(self) -> Bench:
        """The circuit, as system files know it."""
        return BENCHES[self.system.circuit]

    @property
    def model(self) -> Model:
        """The plain functions of the circuit, nothing watched."""
        return self.bench.model

    @property
    def supply(self) -> SupplyParams:
        """Parameters of everything upstream of the load."""
        found: SupplyParams = self.bench.case(self.tables).params.supply
        return found

    @property
    def stepping(self) -> Stepping:
        """How the system is stepped."""
        return self.system.stepping

    @property
    def makes_pressure(self) -> bool:
        """Whether the load is an orifice that makes its own pressure; else a source holds it."""
        return self.system.circuit == ORIFICE_LOAD

    @property
    def reference(self) -> float:
        """What gauge pressures count from [Pa]."""
        return float(self.tables["oil"].reference_pressure)

    @property
    def tank_pressure(self) -> float:
        """Pressure at the tank, absolute [Pa]."""
        return float(self.tables["operation"].tank_pressure.base)

    @property
    def relief_pressure(self) -> float:
        """Cracking pressure of the relief valve, absolute [Pa]."""
        return float(self.tables["relief_valve"].cracking_pressure)

    @property
    def is_driven(self) -> bool:
        """Whether a motor turns the spool."""
        return bool(self.tables["spool_drive"].coupling > 0.0)

    @property
    def set_point(self) -> SetPoint:
        """The set point of the system itself, at the start of its run."""
        operation = self.tables["operation"]
        pressure = self.tables["initial"].load_pressure if self.makes_pressure else self.tables["load"].pressure.base
        return SetPoint(
            operation.duty_ratio.base, float(pressure), operation.pump_speed.base, operation.oil_temperature.base
        )

    def pump_flow(self, point: SetPoint) -> float:
        """Flow that the pump displaces [m^3/s]."""
        flow: float = self.tables["pump"].displacement * point.pump_speed
        return flow

    def changed(self, table: str, **values: Any) -> "Stand":
        """The same stand with some values of a table replaced. Raises ParameterError where they contradict."""
        return replace(self, tables={**self.tables, table: replace(self.tables[table], **values)})

    def driven(self, pwm_frequency: float) -> "Stand":
        """The same stand with a motor that turns the spool so that it switches at `pwm_frequency` [Hz]."""
        speed = 2.0 * np.pi * pwm_frequency / self.tables["valve"].sections
        stiff = self.changed("spool_drive", coupling=STIFF_COUPLING)
        return stiff.changed("operation", spool_motor_speed=constant(speed))

    def at(self, point: SetPoint) -> dict[str, Any]:
        """The tables at a set point; the size of an orifice load stays as it is."""
        operation = replace(
            self.tables["operation"],
            duty_ratio=constant(point.duty_ratio),
            pump_speed=constant(point.pump_speed),
            oil_temperature=constant(point.oil_temperature),
        )
        tables = {**self.tables, "operation": operation}
        if not self.makes_pressure:
            tables["load"] = replace(self.tables["load"], pressure=constant(point.load_pressure))
        return tables

    def case(self, point: SetPoint, means: CycleMeans, area: float | None = None) -> Case:
        """The case of a set point from a guess of its periodic state, at a mark: load port in the middle of its phase.

        means  the quasi-steady averages there
        area   of an orifice load; that of the table unless given [m^2]
        """
        tables = self.at(point)
        spool_speed = self.guessed_speed(means)
        highest = self.relief_pressure + tables["relief_valve"].override_pressure
        initial = {
            "inlet_pressure": min(point.load_pressure + 5e5, highest),
            "spool_speed": spool_speed,
            "spool_angle": 0.0,
        }
        if self.makes_pressure:
            initial["load_pressure"] = point.load_pressure
            if area is not None:
                tables["load"] = replace(tables["load"], area=constant(area))
        tables["initial"] = replace(tables["initial"], **initial)
        return self.bench.case(tables)

    def guessed_speed(self, means: CycleMeans) -> float:
        """The spool's speed as the quasi-steady torques give it, with that of its motor if it has one [rad/s].

        k (omega_m - omega) = b (omega - omega_0), with the resistance b and the speed omega_0 that flow alone gives it.
        """
        if not self.is_driven:
            return means.spool_speed
        k, b = self.tables["spool_drive"].coupling, means.resistance
        speed: float = (k * self.tables["operation"].spool_motor_speed.base + b * means.spool_speed) / (k + b)
        return speed

    def standstill(self, temperature: float, means: CycleMeans) -> str | None:
        """Why the spool has no speed at which it goes on turning, with the numbers; None where it has one.

        temperature  of the oil [K]
        means        the quasi-steady averages
        """
        if self.is_driven or (means.spool_speed > 0.0 and means.slowness <= SLOWEST):
            return None
        if not means.spool_speed > 0.0:
            return "the spool does not turn: the flow drives it backwards or not at all"
        valve = self.tables["valve"]
        friction = friction_coefficient(float(dynamic_viscosity(temperature, self.tables["oil"])), valve)
        return (
            f"the spool does not turn: with a friction of {friction:.3g} N*m*s (valve.friction_area "
            f"{valve.friction_area:.3g} m^2) it stops where both ports are nearly shut"
        )

    def cycle_point(self, point: SetPoint) -> CyclePoint:
        """A set point as the quasi-steady averages take it; arrays of many points pass through as well."""
        oil, relief = self.tables["oil"], self.tables["relief_valve"]
        return CyclePoint(
            point.duty_ratio,
            point.load_pressure,
            self.tank_pressure,
            relief.cracking_pressure,
            # The map's override is the rise at the full pump flow; the valve's belongs to its rated flow.
            relief.override_pressure * self.pump_flow(point) / relief.rated_flow,
            self.pump_flow(point),
            self.tables["pump"].leakage_conductance,
            density(point.oil_temperature, oil),
            dynamic_viscosity(point.oil_temperature, oil),
        )

    def means(self, point: SetPoint) -> CycleMeans:
        """The quasi-steady averages at a set point, in plain Python."""
        return cycle_means(self.cycle_point(point), self.tables["valve"])

    def leakage(self, point: SetPoint) -> float:
        """What the load region loses to the tank [m^3/s]."""
        viscosity = float(dynamic_viscosity(point.oil_temperature, self.tables["oil"]))
        return float(leakage_conductance(viscosity, self.tables["valve"]) * (point.load_pressure - self.tank_pressure))

    def load_area(self, point: SetPoint, means: CycleMeans) -> float | None:
        """Area of an orifice that would hold the load pressure [m^2]; None where nothing is left to hold it with."""
        delivered = means.load_flow - self.leakage(point)
        drop = point.load_pressure - self.tank_pressure
        if delivered < SMALLEST_SHARE * self.pump_flow(point) or drop <= 0.0:
            return None
        rho = float(density(point.oil_temperature, self.tables["oil"]))
        return float(orifice_area_for(delivered, drop, rho, self.tables["load"]))


def stand(system: System) -> Stand:
    """`system` on a test stand. What is prescribed over time is held at its first value.

    Raises ParameterError where the pump does not turn.
    """
    tables = {name: _steady(table) for name, table in system.tables.items() if name not in (*WATCHING, "run")}
    tables["operation"] = _by_duty(tables["operation"], tables["valve"].helix_length)
    tables["pump"] = replace(tables["pump"], ripple_amplitude=0.0)
    speed = tables["operation"].pump_speed.base
    if not speed > 0.0:
        raise ParameterError(f"operation.pump_speed = {speed:g} rad/s; expected more than 0 rad/s on a test stand")
    return Stand(system, tables)


def _steady(table: Any) -> Any:
    signals = {f.name: value for f in fields(table) if isinstance(value := getattr(table, f.name), Signal)}
    return replace(table, **{name: constant(float(signal_value(0.0, value))) for name, value in signals.items()})


def _by_duty(table: Any, helix_length: float) -> DutyOperation:
    """The operation with the axial position turned into the duty ratio that it gives."""
    if isinstance(table, DutyOperation):
        return table
    assert isinstance(table, Operation)
    return DutyOperation(
        pump_speed=table.pump_speed,
        oil_temperature=table.oil_temperature,
        duty_ratio=constant(table.axial_position.base / helix_length),
        spool_motor_speed=table.spool_motor_speed,
        tank_pressure=table.tank_pressure,
    )
