"""The circuits that a system file can name, and how each takes its tables."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from vvdp.base.books import Books
from vvdp.base.kinds import Angle, DutySignal, Power, Pressure, PressureSignal, Speed, SpeedSignal, TemperatureSignal
from vvdp.base.params import Params
from vvdp.base.signal import Signal, signal_value
from vvdp.circuits.bench import (
    OrificeBenchParams,
    OrificeBenchState,
    OrificeLoad,
    PressureLoad,
    SourceBenchParams,
    SourceBenchState,
    Spent,
    Totals,
    orifice_bench,
    orifice_bench_mark,
    orifice_bench_stop,
    orifice_bench_stored,
    source_bench,
    source_bench_mark,
    source_bench_stop,
    source_bench_stored,
)
from vvdp.circuits.supply import (
    Command,
    Inlet,
    Operation,
    Spool,
    Supplied,
    SupplyParams,
    SupplyState,
    ValveSpent,
    conditions,
    supply_program,
)
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.simulation.model import Case, Model
from vvdp.systems.watching import watched
from vvdp.valve.rotary import RotaryValve


class Motor(Params):
    """The motor that turns the pump."""

    rated_power: Power


class Limits(Params):
    """Bounds that are watched and reported."""

    cavitation_pressure: Pressure


class DutyOperation(Params):
    """What is prescribed from outside, with the spool's axial position given as a duty ratio."""

    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    duty_ratio: DutySignal
    spool_motor_speed: SpeedSignal
    tank_pressure: PressureSignal


class InitialSupply(Params):
    """Where a run starts."""

    inlet_pressure: Pressure
    spool_speed: Speed
    spool_angle: Angle


class InitialBench(InitialSupply):
    """Where a run with a load line starts."""

    load_pressure: Pressure


SUPPLY_TABLES: Mapping[str, type[Params]] = {
    "oil": Oil,
    "pump": Pump,
    "motor": Motor,
    "inlet": Inlet,
    "relief_valve": ReliefValve,
    "valve": RotaryValve,
    "spool_drive": SpoolDrive,
    "check_valve": CheckPoppet,
    "operation": DutyOperation,
    "limits": Limits,
}


@dataclass(frozen=True)
class Bench:
    """A circuit as system files know it: the tables it reads, and the case that they make."""

    model: Model
    tables: Mapping[str, type[Params]]
    case: Callable[[Mapping[str, Any]], Case]

    def built(self, tables: Mapping[str, Any]) -> tuple[Model, Case]:
        """The model and the case that `tables` make; its spool is watched where they have an encoder."""
        case = self.case(tables)
        if "encoder" not in tables:
            return self.model, case
        return watched(self.model, case, tables["encoder"], tables["spool_filter"])


def operation(table: DutyOperation | Operation, helix_length: float) -> Operation:
    """The operation with the duty ratio turned into the axial position that gives it, x = d L."""
    if isinstance(table, Operation):
        return table
    duty = table.duty_ratio
    axial = replace(
        duty,
        base=duty.base * helix_length,
        change=tuple(c * helix_length for c in duty.change),
        amplitude=tuple(a * helix_length for a in duty.amplitude),
    )
    return Operation(
        pump_speed=table.pump_speed,
        oil_temperature=table.oil_temperature,
        axial_position=axial,
        spool_motor_speed=table.spool_motor_speed,
        tank_pressure=table.tank_pressure,
    )


def _supply(tables: Mapping[str, Any]) -> SupplyParams:
    return SupplyParams(
        **{name: tables[name] for name in SUPPLY_TABLES if name not in ("motor", "operation", "limits")},
        operation=operation(tables["operation"], tables["valve"].helix_length),
    )


def _supply_start(initial: InitialSupply) -> SupplyState:
    return SupplyState(initial.inlet_pressure, 0.0, 1.0, 0.0, Spool(initial.spool_angle, initial.spool_speed))


def _blank_books() -> Books:
    spent = Spent(ValveSpent(*(0.0 for _ in ValveSpent._fields)), 0.0)
    return Books(Supplied(0.0, 0.0, 0.0), spent, 0.0, 0.0, Totals(*(0.0 for _ in Totals._fields)))


def _orifice_case(tables: Mapping[str, Any]) -> Case:
    supply, initial = _supply(tables), tables["initial"]
    params = OrificeBenchParams(supply=supply, load_line=tables["load_line"], load=tables["load"])
    state = OrificeBenchState(_supply_start(initial), initial.load_pressure, _blank_books())
    return Case(state, params, command=Command(conditions(0.0, supply)), settings=supply)


def _source_case(tables: Mapping[str, Any]) -> Case:
    supply = _supply(tables)
    params = SourceBenchParams(supply=supply, load=tables["load"])
    state = SourceBenchState(_supply_start(tables["initial"]), _blank_books())
    return Case(state, params, command=Command(conditions(0.0, supply)), settings=supply)


BENCHES: Mapping[str, Bench] = {
    "orifice-load": Bench(
        Model(orifice_bench, orifice_bench_stored, supply_program, orifice_bench_mark, orifice_bench_stop),
        {**SUPPLY_TABLES, "load_line": Vessel, "load": OrificeLoad, "initial": InitialBench},
        _orifice_case,
    ),
    "constant-load": Bench(
        Model(source_bench, source_bench_stored, supply_program, source_bench_mark, source_bench_stop),
        {**SUPPLY_TABLES, "load": PressureLoad, "initial": InitialSupply},
        _source_case,
    ),
}


def load_pressure_at(case: Case, t: float) -> float | None:
    """The prescribed load pressure [Pa, absolute] at time `t` [s]; None where the load makes its own."""
    load = getattr(case.params, "load", None)
    pressure = getattr(load, "pressure", None)
    return float(signal_value(t, pressure)) if isinstance(pressure, Signal) else None
