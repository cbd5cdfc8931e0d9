"""Accumulators: gas that exchanges heat behind a bladder or a piston, and a spring behind a piston."""

from typing import NamedTuple

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Flow, Force, Kink, Power, Pressure
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.gas_accumulator import (
    ChargeAmount,
    ChargeState,
    GasAccumulator,
    PistonCharge,
    SpringAccumulator,
    accumulator_pressure,
    charge_amount,
    charge_at_rest,
    charge_energy,
    charge_gas,
    charge_rates,
    charge_stored,
    charge_volume,
    inlet_flow,
    seat_side,
    shell_heat,
    spring_accumulator_energy,
    spring_accumulator_force,
)
from vvdp.hydraulics.ports import ExchangedPower, Medium, RodState, Wall
from vvdp.hydraulics.real_gas import GasTemperature
from vvdp.network.component import Component


class AccumulatorFlow(NamedTuple):
    """Flow out of an accumulator, loss at its inlet, heat from its shell, its state's rates, gas, and its seat."""

    a: Flow
    loss: Power
    supplied: ExchangedPower
    rates: ChargeState
    gas_pressure: Pressure
    seat: Kink


class PistonTemperature(NamedTuple):
    """Temperature of the gas behind a piston."""

    gas_temperature: GasTemperature


class PistonEffect(NamedTuple):
    """Force of oil and gas on a piston, heat from the shell, and how fast the gas warms."""

    rod: Force
    supplied: ExchangedPower
    rates: PistonTemperature
    gas_pressure: Pressure


class SpringEffect(NamedTuple):
    """Force of oil and spring on a piston."""

    rod: Force


class AccumulatorWalls(NamedTuple):
    """Volume that the piston has added to the oil's, and its rate."""

    a: Wall


def gas_accumulator(
    a: FluidState, state: ChargeState, held: ChargeAmount, oil: Oil, medium: Medium, values: GasAccumulator
) -> AccumulatorFlow:
    """A gas accumulator behind an inlet at the node a; compressed gas warms, and gives heat to its shell."""
    gas = charge_gas(state, held, values)
    V = charge_volume(state, values)
    inside = fluid_state(accumulator_pressure(gas.pressure, V, values), oil)
    drop = a.enthalpy - inside.enthalpy
    flow = inlet_flow(drop, medium.density, values)
    charged = charge_rates(flow, state, held, inside, values)
    return AccumulatorFlow(
        a=-flow,
        loss=flow * drop,
        supplied=charged.heat,
        rates=charged.rates,
        gas_pressure=gas.pressure,
        seat=seat_side(V, values),
    )


def gas_accumulator_start(values: GasAccumulator) -> ChargeState:
    """Filled to its pressure at first, the gas as warm as the shell."""
    return charge_at_rest(values.start_pressure, values)


def piston_accumulator(
    a: FluidState,
    rod: RodState,
    state: PistonTemperature,
    held: ChargeAmount,
    values: PistonCharge,
) -> PistonEffect:
    """A piston between oil and gas that gives heat to its shell; friction and end stops are components."""
    charge = _behind(rod, state, values)
    gas = charge_gas(charge, held, values)
    capacity = held.amount * gas.heat_capacity
    heat = shell_heat(state.gas_temperature, capacity, values)
    growth = -values.piston_area * rod.velocity
    warming = (heat - state.gas_temperature * gas.per_temperature * growth) / capacity
    force = values.piston_area * (a.pressure - gas.pressure)
    return PistonEffect(force, heat, PistonTemperature(warming), gas.pressure)


def _behind(rod: RodState, state: PistonTemperature, values: PistonCharge) -> ChargeState:
    """The gas behind the piston."""
    volume = values.gas_volume - values.piston_area * rod.position
    return ChargeState(values.gas_volume / volume, state.gas_temperature)


def piston_accumulator_start(values: PistonCharge) -> PistonTemperature:
    """As warm as the shell."""
    return PistonTemperature(values.shell_temperature)


def piston_accumulator_stored(rod: RodState, state: PistonTemperature, oil: Oil, values: PistonCharge) -> Stored:
    """Energy of its gas."""
    charge = _behind(rod, state, values)
    return Stored(charge_energy(charge, charge_amount(values), oil.reference_pressure, values), 0.0)


def piston_accumulator_walls(rod: RodState, values: PistonCharge) -> AccumulatorWalls:
    """The wall of the oil's volume."""
    return AccumulatorWalls(Wall(values.piston_area * rod.position, values.piston_area * rod.velocity))


def piston_accumulator_mass(values: PistonCharge) -> float:
    """Mass that its piston adds to the rod [kg]."""
    return values.moving_mass


def spring_accumulator(a: FluidState, rod: RodState, oil: Oil, values: SpringAccumulator) -> SpringEffect:
    """A piston between oil and a spring, whose back is open; friction and end stops are components."""
    pushed = values.piston_area * (a.pressure - oil.reference_pressure)
    return SpringEffect(pushed + spring_accumulator_force(rod.position, values))


def spring_accumulator_stored(rod: RodState, values: SpringAccumulator) -> Stored:
    """Energy in its spring."""
    return Stored(spring_accumulator_energy(rod.position, values), 0.0)


def spring_accumulator_walls(rod: RodState, values: SpringAccumulator) -> AccumulatorWalls:
    """The wall of the oil's volume."""
    return AccumulatorWalls(Wall(values.piston_area * rod.position, values.piston_area * rod.velocity))


def spring_accumulator_mass(values: SpringAccumulator) -> float:
    """Mass that its piston adds to the rod [kg]."""
    return values.moving_mass


GAS_ACCUMULATOR = Component(
    gas_accumulator,
    symbol="accumulator",
    held=charge_amount,
    start=gas_accumulator_start,
    stored=charge_stored,
)
PISTON_ACCUMULATOR = Component(
    piston_accumulator,
    symbol="piston_accumulator",
    held=charge_amount,
    start=piston_accumulator_start,
    stored=piston_accumulator_stored,
    walls=piston_accumulator_walls,
    inertia=piston_accumulator_mass,
)
SPRING_ACCUMULATOR = Component(
    spring_accumulator,
    symbol="spring_accumulator",
    stored=spring_accumulator_stored,
    walls=spring_accumulator_walls,
    inertia=spring_accumulator_mass,
)
