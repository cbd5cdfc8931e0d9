"""The two test benches: the supply against a load line with an orifice, and against a pressure source."""

from typing import NamedTuple

from vvdp.base.books import Books, Stored
from vvdp.base.kinds import (
    AreaSignal,
    Duration,
    Energy,
    Flow,
    Fraction,
    Power,
    Pressure,
    PressureSignal,
    PressureTime,
    TankVolume,
)
from vvdp.base.params import Params
from vvdp.base.select import minimum
from vvdp.base.signal import signal_stop, signal_value
from vvdp.circuits.supply import (
    Command,
    Supplied,
    Supply,
    SupplyParams,
    SupplyState,
    ValveSpent,
    pwm_periods,
    supply,
    supply_stop,
)
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.volume import Vessel, closed_volume_stored, pressure_rate, stored
from vvdp.valve.torque import spool_inertia


class Spent(NamedTuple):
    """Where the energy of a bench goes; `load` is what the bench is there for."""

    valve: ValveSpent
    load: Energy


class Totals(NamedTuple):
    """Integrals from which means are taken; pressures absolute, flows in tank volumes."""

    inlet_pressure: PressureTime
    load_pressure: PressureTime
    load_flow: TankVolume
    tank_flow: TankVolume
    relief_flow: TankVolume
    leakage_flow: TankVolume
    load_opening: Duration


class BenchOutputs(NamedTuple):
    """What a bench shows besides its state. Flows are counted in tank volumes."""

    load_pressure: Pressure
    pump_flow: Flow
    load_flow: Flow
    tank_flow: Flow
    relief_flow: Flow
    leakage_flow: Flow
    load_opening: Fraction
    tank_opening: Fraction
    input_power: Power


def bench_outputs(flows: Supply, load_pressure: float) -> BenchOutputs:
    """The outputs common to both benches."""
    return BenchOutputs(
        load_pressure=load_pressure,
        pump_flow=flows.pump_flow,
        load_flow=flows.load_flow,
        tank_flow=flows.tank_flow,
        relief_flow=flows.relief_flow,
        leakage_flow=flows.leakage,
        load_opening=flows.openings.load,
        tank_opening=flows.openings.tank,
        input_power=flows.supplied.pump_shaft,
    )


def net_supplied(flows: Supply, given_out: float, tank: FluidState) -> Supplied:
    """What comes in, less the energy of the oil `given_out` [tank volumes per second], which ends in the tank."""
    s = flows.supplied
    return Supplied(s.pump_shaft, s.spool_motor, s.tank_oil - tank.enthalpy * given_out)


def totals(flows: Supply, inlet_pressure: float, load_pressure: float) -> Totals:
    """What is averaged over a run, at this instant."""
    return Totals(
        inlet_pressure=inlet_pressure,
        load_pressure=load_pressure,
        load_flow=flows.load_flow - flows.leakage,
        tank_flow=flows.tank_flow,
        relief_flow=flows.relief_flow,
        leakage_flow=flows.leakage,
        load_opening=flows.openings.load,
    )


def supply_stored(s: SupplyState, p: SupplyParams) -> Stored:
    """What the inlet volume and the turning spool hold."""
    oil = closed_volume_stored(s.inlet_pressure, p.inlet.volume, p.oil)
    return Stored(oil.energy + 0.5 * spool_inertia(p.valve) * s.spool.speed**2, oil.volume)


class OrificeLoad(Orifice):
    """The load: an orifice to the tank whose area may be prescribed over time."""

    area: AreaSignal


class OrificeBenchParams(Params):
    """Supply, load line with or without accumulator, and load orifice."""

    supply: SupplyParams
    load_line: Vessel
    load: OrificeLoad


class OrificeBenchState(NamedTuple):
    """State of the bench with an orifice load."""

    supply: SupplyState
    load_pressure: Pressure
    books: Books


def orifice_bench(
    t: float, s: OrificeBenchState, command: Command, p: OrificeBenchParams
) -> tuple[OrificeBenchState, BenchOutputs]:
    """Rates and outputs of the supply that feeds a line and, from it, an orifice to the tank."""
    u, oil = command.conditions, p.supply.oil
    line = fluid_state(s.load_pressure, oil)
    flows = supply(t, s.supply, u, s.load_pressure, line, p.supply)
    load = passage(
        orifice_flow(signal_value(t, p.load.area), s.load_pressure - u.tank_pressure, u.density, p.load),
        line,
        u.tank,
    )
    into_line = flows.load_flow - flows.leakage - load.flow
    given_out = flows.pump_leakage + flows.relief_flow + flows.tank_flow + flows.leakage + load.flow
    rates = OrificeBenchState(
        supply=flows.rates,
        load_pressure=pressure_rate(into_line, 0.0, s.load_pressure, line, p.load_line, oil.reference_pressure),
        books=Books(
            supplied=net_supplied(flows, given_out, u.tank),
            spent=Spent(flows.spent, load.loss),
            taken_in=flows.pump_flow,
            given_out=given_out,
            totals=totals(flows, s.supply.inlet_pressure, s.load_pressure),
        ),
    )
    return rates, bench_outputs(flows, s.load_pressure)


def orifice_bench_stored(s: OrificeBenchState, p: OrificeBenchParams) -> Stored:
    """Energy and oil held by the bench with an orifice load."""
    inlet = supply_stored(s.supply, p.supply)
    line = stored(s.load_pressure, p.supply.oil, p.load_line)
    return Stored(inlet.energy + line.energy, inlet.volume + line.volume)


def orifice_bench_mark(t: float, s: OrificeBenchState, p: OrificeBenchParams) -> float:
    """PWM periods passed."""
    return pwm_periods(t, s.supply, p.supply)


def orifice_bench_stop(t: float, p: OrificeBenchParams) -> float:
    """The next corner of anything prescribed [s]."""
    return minimum(supply_stop(t, p.supply), signal_stop(t, p.load.area))


class PressureLoad(Params):
    """The load: a source that holds its pressure whatever flows."""

    pressure: PressureSignal


class SourceBenchParams(Params):
    """Supply and pressure source."""

    supply: SupplyParams
    load: PressureLoad


class SourceBenchState(NamedTuple):
    """State of the bench with a pressure source as load."""

    supply: SupplyState
    books: Books


def source_bench(
    t: float, s: SourceBenchState, command: Command, p: SourceBenchParams
) -> tuple[SourceBenchState, BenchOutputs]:
    """Rates and outputs of the supply that works against a pressure source, which also feeds the valve's leakage."""
    u, load_pressure = command.conditions, signal_value(t, p.load.pressure)
    source = fluid_state(load_pressure, p.supply.oil)
    flows = supply(t, s.supply, u, load_pressure, source, p.supply)
    load_power = (flows.load_flow - flows.leakage) * (source.enthalpy - u.tank.enthalpy)
    given_out = flows.pump_leakage + flows.relief_flow + flows.tank_flow + flows.load_flow
    rates = SourceBenchState(
        supply=flows.rates,
        books=Books(
            supplied=net_supplied(flows, given_out, u.tank),
            spent=Spent(flows.spent, load_power),
            taken_in=flows.pump_flow,
            given_out=given_out,
            totals=totals(flows, s.supply.inlet_pressure, load_pressure),
        ),
    )
    return rates, bench_outputs(flows, load_pressure)


def source_bench_stored(s: SourceBenchState, p: SourceBenchParams) -> Stored:
    """Energy and oil held by the bench with a pressure source."""
    return supply_stored(s.supply, p.supply)


def source_bench_mark(t: float, s: SourceBenchState, p: SourceBenchParams) -> float:
    """PWM periods passed."""
    return pwm_periods(t, s.supply, p.supply)


def source_bench_stop(t: float, p: SourceBenchParams) -> float:
    """The next corner of anything prescribed [s]."""
    return minimum(supply_stop(t, p.supply), signal_stop(t, p.load.pressure))
