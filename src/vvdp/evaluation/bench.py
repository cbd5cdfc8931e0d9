"""The test rig of a rotary valve as a view of its network: values, other values, cases, and series of a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.params import field_names
from vvdp.base.signal import Signal, constant, map_signal, signal_value
from vvdp.evaluation.bench_parts import SOFTENING, asked_duty_ratio, is_bench
from vvdp.evaluation.bench_values import BenchValues
from vvdp.evaluation.rig_drawing import full_path
from vvdp.evaluation.valve_unit import ValveUnit
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.nodes import UNRATED, Connection, Source
from vvdp.programs.estimate_report import ShaftWatch, shaft_watch
from vvdp.simulation.model import Case
from vvdp.simulation.outcome import Outcome
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves
from vvdp.systems.changed import with_numbers
from vvdp.systems.system import System
from vvdp.systems.value_places import changed_values, value_at, value_place
from vvdp.valve.rotary import RotaryValve

UNDRIVEN = SpoolDrive(coupling=0.0)
"""The drive of a spool that has none."""
RATED_POWER = "motor.rated_power"
"""Path of the rated power of the motor that turns the pump."""


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


class Operation(NamedTuple):
    """Prescribed signals, apart from that of the spool's position: speeds [rad/s], oil temperature [K], and the
    pressure of the tank, absolute [Pa]."""

    pump_speed: Signal
    oil_temperature: Signal
    spool_motor_speed: Signal
    tank_pressure: Signal


class RotaryBench:
    """A pump unit on its load, as the network of a system has it; `load_line` is None where a source is the load.

    `changes` are values other than those of the file, by their places among the parameters; `params` are all of them.
    """

    INLET_TOTAL = "books.totals.inlet_pressure"
    LOAD_TOTAL = "books.totals.load_line_pressure"
    LOAD_FLOW_TOTAL = "books.totals.valve_load_flow"
    """Integrals from which means of inlet pressure, load pressure and load flow are taken, by their paths."""

    def __init__(self, system: System, changes: Mapping[str, Any] = MappingProxyType({}), params: Any = None) -> None:
        self.system, self.changes = system, changes
        self.params = params or changed_values(system.case.params, changes)
        self.oil: Oil = self.value("oil")
        self.pump: Pump = self.value("pump")
        self.relief_valve: ReliefValve = self.value("relief_valve")
        self.valve: RotaryValve = self.value("valve")

    def __reduce__(self) -> tuple[Any, ...]:
        return RotaryBench, (self.system, dict(self.changes))

    def value(self, path: str) -> Any:
        """The value or the table at a path of a rig, such as `operation.pump_speed`."""
        return value_at(self.params, self._place(path))

    def _place(self, path: str) -> str:
        circuit = self.system.circuit
        return value_place(circuit, full_path(path, circuit.network))

    @cached_property
    def operation(self) -> Operation:
        """The prescribed signals; without a motor at the spool its speed is 0."""
        driven = "spool_motor" in self.system.circuit.network.nodes
        return Operation(
            pump_speed=self.value("operation.pump_speed"),
            oil_temperature=self.value("operation.oil_temperature"),
            spool_motor_speed=self.value("operation.spool_motor_speed") if driven else constant(0.0),
            tank_pressure=self.value("operation.tank_pressure"),
        )

    @cached_property
    def watch(self) -> ShaftWatch | None:
        """The event filter that watches the spool; None where there is none."""
        return shaft_watch(self.system.circuit.network, "spool")

    @property
    def spool_drive(self) -> SpoolDrive:
        """The drive of the spool beside the flow."""
        found: SpoolDrive = self.value("spool_drive") if self._has("coupling") else UNDRIVEN
        return found

    @property
    def load(self) -> Orifice | None:
        """The orifice behind the load line; None where a source is the load."""
        found: Orifice | None = self.value("load") if self.makes_pressure else None
        return found

    @property
    def load_line(self) -> Vessel | None:
        """The load line; None where a source is the load."""
        found: Vessel | None = self.value("load_line") if self.makes_pressure else None
        return found

    @property
    def makes_pressure(self) -> bool:
        """Whether the load makes its own pressure; else a source holds it."""
        return self._has("load")

    @property
    def inlet_volume(self) -> float:
        """Volume between pump, relief valve and nozzles [m^3]."""
        return float(self.value("inlet.volume"))

    @property
    def rated_power(self) -> float:
        """Rated power of the motor that turns the pump [W]."""
        return float(getattr(self.system.circuit.network.nodes["pump_shaft"], "rated_power", UNRATED))

    @property
    def cavitation_pressure(self) -> float:
        """The pressure below which the oil is held to cavitate in the ports [Pa, absolute]."""
        return float(signal_value(0.0, self.value("limits.cavitation_pressure")))

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
        return isinstance(self._position_source, Signal)

    @property
    def duty_ratio(self) -> Signal:
        """The duty ratio, or the axial position over the helix length."""
        if self.is_placed:
            return map_signal(self.value("operation.axial_position"), lambda x: x / self.valve.helix_length)
        if isinstance(self._position_source, Connection):
            found: Signal = self.value("operation.duty_ratio")
            return found
        asked = asked_duty_ratio(self.system)
        assert asked is not None
        return asked

    @property
    def axial_position(self) -> Signal:
        """The axial position of the spool [m]."""
        if self.is_placed:
            found: Signal = self.value("operation.axial_position")
            return found
        return map_signal(self.duty_ratio, lambda d: d * self.valve.helix_length)

    @property
    def load_pressure(self) -> float:
        """The load pressure at the start, prescribed or initial [Pa, absolute]."""
        if self.makes_pressure:
            return float(self.value("initial.load_pressure"))
        return float(signal_value(0.0, self.value("load.pressure")))

    @property
    def is_driven(self) -> bool:
        """Whether a motor turns the spool."""
        return self.spool_drive.coupling > 0.0

    @property
    def is_softened(self) -> bool:
        """Whether a check valve past the load port or a chamber switches it softly."""
        return any(map(self._has, SOFTENING))

    @property
    def unit(self) -> ValveUnit:
        """Its valve with pump and relief valve, and where it works at the start."""
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
            cavitation_pressure=self.cavitation_pressure,
            inlet_volume=self.inlet_volume,
            ripple_amplitude=self.pump.ripple_amplitude,
        )

    @property
    def signals(self) -> dict[str, Signal]:
        """What is prescribed over time, by its path."""
        position = "axial_position" if self.is_placed else "duty_ratio"
        found = {f"operation.{name}": signal for name, signal in self.operation._asdict().items()}
        found[f"operation.{position}"] = self.axial_position if self.is_placed else self.duty_ratio
        load = "load.area" if self.makes_pressure else "load.pressure"
        return found | {load: self.value(load)}

    @property
    def is_steady(self) -> bool:
        """Whether all that is prescribed stays as it is."""
        return all(signal.is_constant for signal in self.signals.values())

    @property
    def case(self) -> Case:
        """The case of its values, without drawing the network again."""
        return self.system.circuit.case_of(self.params)

    @property
    def own_system(self) -> System:
        """The system with its values in place of those of the file; its text and rows stay."""
        return replace(self.system, circuit=replace(self.system.circuit, case=self.case))

    def with_values(self, values: Mapping[str, Any]) -> "RotaryBench":
        """The same bench with other values by their paths. Raises ParameterError where they contradict."""
        network = self.system.circuit.network
        placed = {full_path(path, network): value for path, value in values.items()}
        rated = placed.pop(full_path(RATED_POWER, network), None)  # stands in no equation
        own = {value_place(self.system.circuit, path): value for path, value in placed.items()}
        system = self.system if rated is None else with_numbers(self.system, {RATED_POWER: rated})
        return RotaryBench(system, {**self.changes, **own}, changed_values(self.params, own))

    def with_tables(self, **tables: Mapping[str, Any]) -> "RotaryBench":
        """The same bench with some values of its tables replaced. Raises ParameterError where they contradict."""
        return self.with_values({f"{name}.{key}": table[key] for name, table in tables.items() for key in table})

    def drawn_as(self, system: System) -> "RotaryBench":
        """The same values in another drawing of the circuit."""
        return RotaryBench(system, {name: getattr(self.params, name) for name in field_names(type(self.params))})

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
        held = {path: signal_value(0.0, each) for path, each in self.signals.items() if not each.is_constant}
        if self.is_placed:
            held.pop("operation.axial_position", None)
            held["operation.duty_ratio"] = signal_value(0.0, self.duty_ratio)
        if self.pump.ripple_amplitude > 0.0:
            held["pump.ripple_amplitude"] = 0.0
        return RotaryBench(with_numbers(self.system, held)) if held else self

    def with_load(self, case: Case, area: Signal, pressure: float) -> Case:
        """The case with an orifice load of another `area` [m^2], from a load `pressure` [Pa, absolute]."""
        params = changed_values(case.params, {self._place("load.area"): area})
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

    @property
    def _position_source(self) -> Source:
        return self.system.circuit.network.parts["valve"].inputs["axial_position"]

    def _has(self, name: str) -> bool:
        return name in self.system.circuit.network.parts


def rotary_bench(system: System, verb: str) -> RotaryBench:
    """The bench that a system is. Raises ConfigError, which names `verb`, where it is none."""
    if is_bench(system):
        return RotaryBench(system)
    message = f"`vvdp {verb}` needs a pump unit with a rotary valve on a test rig; this circuit has none"
    raise ConfigError([Fault(system.name, 0, "", message)])
