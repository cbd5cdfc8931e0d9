"""Additions of a test rig of the rotary valve to other systems, and values that verbs about it need."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.signal import Signal, constant, map_signal, signal_value
from vvdp.evaluation.bench_overview import ANALYTIC, OVERVIEW, OVERVIEW_NOTE, QUANTITIES
from vvdp.evaluation.bench_validity import bench_bounds, bench_warnings, efficiency, transition_loss
from vvdp.evaluation.bench_values import BenchValues
from vvdp.evaluation.port_cavitation import lowest_cavitation_number
from vvdp.evaluation.valve_forms import unit_forms, unit_limits
from vvdp.evaluation.valve_unit import ValveUnit
from vvdp.fluid.oil import Oil, density
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.programs.estimate_report import shaft_watch
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.simulation.model import Case
from vvdp.simulation.outcome import Outcome
from vvdp.simulation.record import Record
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat, leaves
from vvdp.systems.bench_tables import AxialOperation, DriveMotor, DutyOperation, Limits, OrificeLoad, PressureLoad
from vvdp.systems.bound import Bound
from vvdp.systems.extras import Extras, Summary
from vvdp.systems.program_reports import reported_programs
from vvdp.systems.system import System
from vvdp.valve.losses import full_open_loss
from vvdp.valve.rotary import RotaryValve

SOFTENING = ("bypass", "mouth")
"""Components of soft switching that lose power beside the valve."""


@dataclass(frozen=True)
class BenchSeries:
    """Quantities of a bench over time, each of shape (rows,): pressures absolute [Pa], flows [tank volumes, m^3/s].

    `load_flow` and `tank_flow` go through the ports of the valve; its leakage goes from the load to the tank.
    `through_load` is nan where a source is the load, `delivered_volume` what has come from the valve [m^3].
    """

    inlet_pressure: Array
    load_pressure: Array
    spool_angle: Array
    spool_speed: Array
    pump_flow: Array
    load_flow: Array
    tank_flow: Array
    relief_flow: Array
    leakage_flow: Array
    through_load: Array
    delivered_volume: Array
    load_opening: Array
    tank_opening: Array


class RotaryBench(Extras):
    """A pump unit with its load, as a system's tables give it; `load_line` is None where a source is the load."""

    PERIOD = "PWM period"
    OVERVIEW = OVERVIEW
    OVERVIEW_NOTE = OVERVIEW_NOTE
    HEADLINE = ("efficiency", "pwm_frequency_Hz", "pressure_max_inlet_Pa", "loss_total_W")
    QUANTITIES = QUANTITIES

    INLET_TOTAL = "books.totals.inlet_pressure"
    LOAD_TOTAL = "books.totals.load_line_pressure"
    LOAD_FLOW_TOTAL = "books.totals.valve_load_flow"
    """Integrals from which means of inlet pressure, load pressure and load flow are taken, by their paths."""

    CLOSED_FORMS = ANALYTIC

    system: System

    def __init__(self, system: System, tables: Mapping[str, Any] | None = None) -> None:
        super().__init__(system)
        self.tables = given = system.tables if tables is None else tables
        self.oil: Oil = given["oil"]
        self.pump: Pump = given["pump"]
        self.motor: DriveMotor = given["motor"]
        self.relief_valve: ReliefValve = given["relief_valve"]
        self.valve: RotaryValve = given["valve"]
        self.spool_drive: SpoolDrive = given["spool_drive"]
        self.limits: Limits = given["limits"]
        self.operation: DutyOperation | AxialOperation = given["operation"]
        self.load: OrificeLoad | PressureLoad = given["load"]
        self.load_line: Vessel | None = given.get("load_line")
        self.programs = reported_programs(system, system.stepping.sample_period) or Extras(system)
        self.watch = shaft_watch(system.circuit.network, "spool")
        self.QUANTITIES = {**QUANTITIES, **self.programs.QUANTITIES}
        self.OVERVIEW = (*OVERVIEW, *self.programs.OVERVIEW)

    @property
    def makes_pressure(self) -> bool:
        """Whether the load makes its own pressure; else a source holds it."""
        return isinstance(self.load, OrificeLoad)

    @property
    def inlet_volume(self) -> float:
        """Volume between pump, relief valve and nozzles [m^3]."""
        return float(self.tables["inlet"].volume)

    @property
    def tank_pressure(self) -> float:
        """Pressure at the tank at the start [Pa, absolute]."""
        return float(signal_value(0.0, self.operation.tank_pressure))

    @property
    def reference(self) -> float:
        """Zero of gauge pressures [Pa]."""
        return self.oil.reference_pressure

    @property
    def is_placed(self) -> bool:
        """Whether the axial position is prescribed, not the duty ratio."""
        return isinstance(self.operation, AxialOperation)

    @property
    def duty_ratio(self) -> Signal:
        """The duty ratio, or the axial position over the helix length."""
        if isinstance(self.operation, DutyOperation):
            return self.operation.duty_ratio
        return map_signal(self.operation.axial_position, lambda x: x / self.valve.helix_length)

    @property
    def axial_position(self) -> Signal:
        """The axial position of the spool [m]."""
        if isinstance(self.operation, DutyOperation):
            return map_signal(self.operation.duty_ratio, lambda d: d * self.valve.helix_length)
        return self.operation.axial_position

    @property
    def unit(self) -> ValveUnit:
        """Its valve with pump and relief valve, and where it works at the start, as its tables have it."""
        return ValveUnit(
            valve=self.valve,
            oil=self.oil,
            pump=self.pump,
            relief_valve=self.relief_valve,
            inlet_volume=self.inlet_volume,
            pump_speed=float(signal_value(0.0, self.operation.pump_speed)),
            temperature=float(signal_value(0.0, self.operation.oil_temperature)),
            duty_ratio=float(signal_value(0.0, self.duty_ratio)),
            load_pressure=self.load_pressure,
            tank_pressure=self.tank_pressure,
            makes_pressure=self.makes_pressure,
            is_softened=self.is_softened,
        )

    @property
    def load_pressure(self) -> float:
        """The load pressure at the start, prescribed or initial [Pa, absolute]."""
        if isinstance(self.load, PressureLoad):
            return float(signal_value(0.0, self.load.pressure))
        return float(self.tables["initial"].load_pressure)

    @property
    def is_driven(self) -> bool:
        """Whether a motor turns the spool."""
        return self.spool_drive.coupling > 0.0

    @property
    def is_softened(self) -> bool:
        """Whether a check valve past the load port or a chamber switches it softly."""
        return any(self.tables.get(name) is not None for name in ("bypass", "chamber"))

    @property
    def values(self) -> BenchValues:
        """What its checks read."""
        return BenchValues(
            valve=self.valve,
            oil=self.oil,
            load_line=self.load_line,
            duty_ratio=self.duty_ratio,
            axial_position=self.axial_position,
            is_placed=self.is_placed,
            temperature=float(signal_value(0.0, self.operation.oil_temperature)),
            reference=self.reference,
            tank_pressure=self.tank_pressure,
            cavitation_pressure=self.limits.cavitation_pressure,
            inlet_volume=self.inlet_volume,
            ripple_amplitude=self.pump.ripple_amplitude,
        )

    @property
    def is_steady(self) -> bool:
        """Whether all that is prescribed stays as it is."""
        parts = (self.operation, self.load)
        prescribed = [getattr(part, field.name) for part in parts for field in fields(part)]
        return all(value.is_constant for value in prescribed if isinstance(value, Signal))

    @property
    def case(self) -> Case:
        """The case of its tables, without drawing the network again."""
        params = self.system.case.params
        known = {field.name for field in fields(params)}
        given = {name: table for name, table in self.tables.items() if name in known}
        return self.system.circuit.case_of(replace(params, **given))

    def with_tables(self, **tables: Mapping[str, Any]) -> "RotaryBench":
        """The same bench with some values of its tables replaced. Raises ParameterError where they contradict."""
        new = {name: replace(self.tables[name], **values) for name, values in tables.items()}
        return RotaryBench(self.system, {**self.tables, **new})

    def starting(
        self, *, inlet_pressure: float, load_pressure: float, spool_speed: float, spool_angle: float
    ) -> "RotaryBench":
        """The same bench with another start; pressures absolute, that of the load only where it makes its own."""
        values = {"inlet_pressure": inlet_pressure, "spool_speed": spool_speed, "spool_angle": spool_angle}
        if self.makes_pressure:
            values["load_pressure"] = load_pressure
        return self.with_tables(initial=values)

    def hold(self) -> "RotaryBench":
        """The same bench with all that is prescribed held at its first value, the axial position as a duty ratio.

        The pump does not pulsate: only what repeats itself with the valve is left.
        """
        tables = {name: _hold_table(table) for name, table in self.tables.items()}
        operation = tables["operation"]
        tables["operation"] = DutyOperation(
            pump_speed=operation.pump_speed,
            oil_temperature=operation.oil_temperature,
            duty_ratio=constant(signal_value(0.0, self.duty_ratio)),
            spool_motor_speed=operation.spool_motor_speed,
            tank_pressure=operation.tank_pressure,
        )
        tables["pump"] = replace(tables["pump"], ripple_amplitude=0.0)
        return RotaryBench(self.system.with_tables(tables))

    def with_load(self, case: Case, area: Signal, pressure: float) -> Case:
        """The case with an orifice load of another `area` [m^2], from a load `pressure` [Pa, absolute]."""
        params = replace(case.params, load=replace(case.params.load, area=area))
        return replace(case, params=params, state=case.state._replace(load_line=pressure))

    def series(self, state: Callable[[str], Array], output: Callable[[str], Array]) -> BenchSeries:
        """Quantities of a recorded run; `state` and `output` give a series by its path."""
        leakage = output("valve_leakage")
        return BenchSeries(
            inlet_pressure=state("inlet"),
            load_pressure=state("load_line") if self.makes_pressure else output("load_line_pressure"),
            spool_angle=state("spool.angle"),
            spool_speed=state("spool.speed"),
            pump_flow=output("pump_flow"),
            load_flow=output("valve_load_flow") + leakage,
            tank_flow=output("valve_tank_flow") - leakage,
            relief_flow=output("relief_valve_flow"),
            leakage_flow=leakage,
            through_load=output("load_flow") if self.makes_pressure else np.full(leakage.shape, np.nan),
            delivered_volume=state(self.LOAD_FLOW_TOTAL),
            load_opening=output("valve_load_opening"),
            tank_opening=output("valve_tank_opening"),
        )

    def run_series(self, run: Run) -> BenchSeries:
        """Quantities of a run in memory."""
        columns = {path: run.states[:, i] for i, (path, _, _) in enumerate(leaves(run.case.state))}
        outputs = run.outputs
        return self.series(columns.__getitem__, lambda name: np.asarray(getattr(outputs, name), float))

    def mean(self, run: Outcome, total: str) -> float:
        """Mean over the window of what an integral adds up, by its path."""
        window, paths = run.window, [path for path, _, _ in leaves(run.case.state)]
        place = paths.index(total)
        return float((window.last[place] - window.first[place]) / (window.end - window.begin))

    def simulation_numbers(self, run: Outcome, found: Summary) -> Summary:
        """The numbers of a bench that its simulation gives, beside those that any circuit has."""
        window = run.window
        span = window.end - window.begin
        mean = as_value(run.case.state.books, (window.last - window.first)[-flat(run.case.state.books).size :] / span)
        totals, valve, supplied = mean.totals, mean.spent.valve, mean.supplied
        pump_flow = totals.pump_flow + totals.pump_leakage_flow
        rho = density(signal_value(0.0, self.operation.oil_temperature), self.oil)
        delivered = totals.pump_flow
        open_loss = full_open_loss(delivered, rho, self.valve) if delivered > 0.0 else 0.0
        shaft, motor = supplied.pump_shaft, supplied.spool_motor
        load_power = mean.spent.load if self.makes_pressure else -supplied.load_line - supplied.tank
        drops = valve.nozzle + valve.centre_section + valve.outlet_turbine + _beside(mean.spent)
        place = [path for path, _, _ in leaves(run.case.state)].index("spool.angle")
        return {
            "pwm_frequency_Hz": float(found["speed_mean_spool_rad_s"]) * self.valve.sections / (2.0 * np.pi),
            "mean_pump_flow_m3_s": pump_flow,
            "mean_load_flow_m3_s": _load_flow(totals),
            "mean_tank_flow_m3_s": totals.valve_tank_flow - totals.valve_leakage,
            "mean_leakage_flow_m3_s": totals.valve_leakage,
            "load_flow_fraction": _ratio(_load_flow(totals), pump_flow),
            "mean_load_opening": totals.valve_load_opening,
            "cavitation_port_share": min(max(totals.valve_cavitating, 0.0), 1.0),
            "cavitation_number_lowest": lowest_cavitation_number(self.values, found, (run.low[place], run.high[place])),
            "input_power_W": shaft,
            "spool_motor_power_W": motor,
            "load_power_W": load_power,
            "efficiency": efficiency(load_power, shaft + motor, float(found["stored_power_W"])),
            "motor_rated_power_W": self.motor.rated_power,
            "motor_overloaded": bool(shaft > self.motor.rated_power),
            "loss_nozzle_W": valve.nozzle,
            "loss_centre_section_W": valve.centre_section,
            "loss_outlet_turbine_W": valve.outlet_turbine,
            "loss_spool_friction_W": valve.spool_friction,
            "spool_shaft_power_W": -valve.to_spool,
            "loss_full_open_W": open_loss,
            "loss_transition_W": transition_loss(drops + mean.spent.relief_valve - open_loss, shaft + motor),
            "loss_total_W": shaft + motor - load_power,
            "steady": self.is_steady,
            **self.programs.simulation_numbers(run, found),
        }

    def record_numbers(self, run: Run) -> Summary:
        """The numbers of its programs."""
        return self.programs.record_numbers(run)

    def closed_forms(self, found: Mapping[str, float | bool]) -> Summary:
        """The analytic results at the mean load pressure, to stand beside the simulated ones in `found`.

        There are none without flow or load, with anything prescribed that changes over time, with a driven spool, nor
        where `closed_form_limits` says why. They take as long to calculate as a short run.
        """
        if not self._is_analytic(found) or any(self.closed_form_limits(found)):
            return {}
        return unit_forms(self.unit, float(found["pressure_mean_load_line_Pa"]) + self.reference)

    def _is_analytic(self, found: Mapping[str, float | bool]) -> bool:
        """Whether a run is of the kind that closed forms describe: steady, spun by the flow alone, against a load."""
        loaded = found["pressure_mean_load_line_Pa"] + self.reference > self.tank_pressure
        return self.is_steady and not self.is_driven and self.unit.nominal_flow > 0.0 and bool(loaded)

    def closed_form_limits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Why the closed forms do not describe a run of the kind that they could, a sentence each; none where they do.

        found  the numbers of a run
        """
        if self._is_analytic(found):
            load_pressure = float(found["pressure_mean_load_line_Pa"]) + self.reference
            yield from unit_limits(self.unit, load_pressure, self.values, found)

    @property
    def temperature(self) -> Signal:
        """The oil's temperature [K]."""
        return self.operation.oil_temperature

    def bounds(self, found: Mapping[str, float]) -> Iterator[Bound]:
        """The bounds of the laws of valve and spool at what a run has `found`."""
        return bench_bounds(self.values, found)

    def warnings(self, found: Mapping[str, float]) -> Iterator[str]:
        """Warnings to read before the numbers of a bench, in sentences."""
        yield from bench_warnings(self.values, found, self.closed_form_limits(found))
        yield from self.programs.warnings(found)

    def merits(self, found: Mapping[str, float]) -> Iterator[str]:
        """Merits that the numbers of its programs show."""
        return self.programs.merits(found)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """The figures of its programs."""
        return self.programs.charts(record)


def rotary_bench(system: System, verb: str) -> RotaryBench:
    """The bench that a system is. Raises ConfigError, which names `verb`, where it is none."""
    found = (system.counterpart or system).extras
    if isinstance(found, RotaryBench):
        return found
    message = (
        f"`vvdp {verb}` needs a pump unit with a rotary valve on a test rig (circuit = "
        '"orifice-load" or "constant-load"); this circuit has none'
    )
    raise ConfigError([Fault(system.name, 0, "", message)])


def _hold_table(table: Any) -> Any:
    signals = {f.name: value for f in fields(table) if isinstance(value := getattr(table, f.name), Signal)}
    return replace(table, **{name: constant(signal_value(0.0, value)) for name, value in signals.items()})


def _beside(spent: Any) -> float:
    """Losses of the components of soft switching [W]; none without them."""
    return float(sum(getattr(spent, name, 0.0) for name in SOFTENING))


def _load_flow(totals: Any) -> float:
    """Mean flow to the load [m^3/s], with what a check valve past its port carries."""
    return float(totals.valve_load_flow + getattr(totals, "bypass_flow", 0.0))


def _ratio(a: float, b: float) -> float:
    return a / b if b else 0.0
