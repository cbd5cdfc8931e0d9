"""Gas accumulator whose gas exchanges heat with its shell, behind an inlet that throttles.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.conservation import Stored
from vvdp.base.kinds import (
    Area,
    DischargeCoefficient,
    Fraction,
    Kind,
    Length,
    Mass,
    Power,
    Pressure,
    PressureDifference,
    Time,
    Volume,
)
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import maximum, select
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.real_gas import (
    GasProperties,
    GasTemperature,
    Quantity,
    gas_internal_energy,
    gas_state,
    molar_volume,
)

SEAT = 0.005
"""Share of its volume by which the gas is let go beyond its seat while the oil's pressure falls to zero."""
COMPRESSION = Kind("compression of a gas", "1", 1.0 / (1.0 + SEAT), 1e3, "1.5", scale=1e-2)
Compression = Annotated[float, COMPRESSION]


class NitrogenCharge(Params):
    """Nitrogen of a volume at its precharge (absolute), when both it and the shell have the `shell_temperature`.

    Its heat goes to the shell with the time constant `heat_time`. With `real_gas` 1 it is no ideal gas.
    """

    gas_volume: Volume
    precharge_pressure: Pressure
    heat_time: Time
    shell_temperature: GasTemperature = 293.15
    real_gas: Fraction = 1.0

    def check(self) -> None:
        require_positive(self, "gas_volume", "precharge_pressure", "heat_time")


class GasAccumulator(NitrogenCharge):
    """Its bladder leaves `oil_volume` of oil below it at the precharge. All oil passes the `inlet_area`.

    It is filled at first to `start_pressure` (absolute) with the gas as warm as the shell.
    """

    oil_volume: Volume
    inlet_area: Area
    start_pressure: Pressure
    discharge_coefficient: DischargeCoefficient = 0.61
    transition_pressure: PressureDifference = 5e4

    def check(self) -> None:
        require_positive(self, "inlet_area", "transition_pressure")
        least = 2.0 * SEAT * self.gas_volume
        if self.oil_volume < least:
            refuse(
                self, "oil_volume", f"must be at least {1e6 * least:g} cc, into which the bladder yields on its seat"
            )


class PistonCharge(NitrogenCharge):
    """The charge behind a piston of `piston_area`, which is at position 0 where the gas has its volume."""

    piston_area: Area
    moving_mass: Mass

    def check(self) -> None:
        require_positive(self, "piston_area")


class SpringAccumulator(Params):
    """A piston of `piston_area` that a spring pushes into the oil, with `spring_pressure` at position 0 and more by
    `pressure_rise` over `stroke`.
    """

    piston_area: Area
    stroke: Length
    spring_pressure: PressureDifference
    pressure_rise: PressureDifference
    moving_mass: Mass

    def check(self) -> None:
        require_positive(self, "piston_area", "stroke")


class ChargeState(NamedTuple):
    """Volume of the gas at its precharge over that now, and its temperature."""

    compression: Compression
    gas_temperature: GasTemperature


class ChargeAmount(NamedTuple):
    """Amount of the gas [mol]."""

    amount: Quantity


class ChargeRates(NamedTuple):
    """Response of an accumulator to a flow: rates of its state, and the power that the shell gives to the gas."""

    rates: ChargeState
    heat: Power


def charge_amount(charge: NitrogenCharge) -> ChargeAmount:
    """Amount of the gas at its precharge [mol]."""
    volume = molar_volume(charge.precharge_pressure, charge.shell_temperature, charge.real_gas)
    return ChargeAmount(charge.gas_volume / volume)


def charge_volume(state: ChargeState, charge: NitrogenCharge) -> float:
    """Volume of the gas of an accumulator now [m^3]."""
    return charge.gas_volume / state.compression


def charge_gas(state: ChargeState, amount: ChargeAmount, charge: NitrogenCharge) -> GasProperties:
    """The gas of an accumulator now."""
    return gas_state(charge_volume(state, charge) / amount.amount, state.gas_temperature, charge.real_gas)


def shell_heat(temperature: float, heat_capacity: float, charge: NitrogenCharge) -> float:
    """Power that the shell gives to the gas [W]: C_v (T_s - T)/tau.

    temperature    T of the gas [K]
    heat_capacity  of all of it, C_v [J/K]

    Source  pourmovahed1990
    """
    return heat_capacity * (charge.shell_temperature - temperature) / charge.heat_time


def seat_depth(gas_volume: float, accumulator: GasAccumulator) -> float:
    """Volume by which the gas has pressed its bladder into the seat [m^3].

    gas_volume  now [m^3]
    """
    return maximum(gas_volume - accumulator.gas_volume, 0.0)


def seat_side(gas_volume: float, accumulator: GasAccumulator) -> float:
    """Whether the bladder is on its seat [1], see `base.modes.side`.

    gas_volume  now [m^3]
    """
    return side((gas_volume - accumulator.gas_volume) / accumulator.gas_volume)


def seat_stiffness(accumulator: GasAccumulator) -> float:
    """Pressure that the seat takes from the gas over the depth of the bladder in it [Pa/m^3]."""
    return accumulator.precharge_pressure / (SEAT * accumulator.gas_volume)


def accumulator_pressure(gas_pressure: float, gas_volume: float, accumulator: GasAccumulator) -> float:
    """Pressure of the oil in an accumulator [Pa, absolute]: that of the gas minus the pressure on the seat.

    gas_pressure  absolute [Pa]
    gas_volume    now [m^3]
    """
    return gas_pressure - seat_stiffness(accumulator) * seat_depth(gas_volume, accumulator)


def accumulator_oil(gas_volume: float, accumulator: GasAccumulator) -> float:
    """Volume of oil in an accumulator at its pressure [m^3].

    gas_volume  now [m^3]
    """
    return accumulator.oil_volume + accumulator.gas_volume - gas_volume


def inlet_flow(drop: float, density: float, accumulator: GasAccumulator) -> float:
    """Flow through the inlet of an accumulator [tank volumes, m^3/s], straight about 0: Cd A root(2 drop/rho).

    drop     enthalpy per tank volume outside less that inside [J/m^3]
    density  of the oil [kg/m^3]

    Source  merritt1967, ch. 3 (root law)
    """
    smooth = np.sqrt(drop * drop + accumulator.transition_pressure * accumulator.transition_pressure)
    area = accumulator.discharge_coefficient * accumulator.inlet_area
    flow: float = area * drop / np.sqrt(0.5 * density * smooth)
    return flow


def charge_rates(
    flow: float, state: ChargeState, amount: ChargeAmount, inside: FluidState, accumulator: GasAccumulator
) -> ChargeRates:
    """Rates of gas volume and temperature while oil flows in; the oil inside is compressed with the gas.

    -V' + V_o/beta P' = nu q, C_v T' = -T p_T V' + heat

    flow    q, in tank volumes [m^3/s]
    inside  the oil in it
    """
    n, T, V = amount.amount, state.gas_temperature, charge_volume(state, accumulator)
    gas = charge_gas(state, amount, accumulator)
    capacity = n * gas.heat_capacity
    heat = shell_heat(T, capacity, accumulator)
    seat = select(accumulator.gas_volume < V, seat_stiffness(accumulator), 0.0)
    soft = accumulator_oil(V, accumulator) / inside.bulk_modulus
    cooling = -T * gas.per_temperature / capacity
    slope = gas.per_volume / n - seat + gas.per_temperature * cooling
    growth = (inside.volume_ratio * flow - soft * gas.per_temperature * heat / capacity) / (soft * slope - 1.0)
    return ChargeRates(ChargeState(-state.compression * growth / V, cooling * growth + heat / capacity), heat)


def charge_stored(state: ChargeState, oil: Oil, accumulator: GasAccumulator) -> Stored:
    """Energy [J] and oil [tank volumes, m^3] in an accumulator: of gas, seat and oil, and against the outside."""
    amount, V = charge_amount(accumulator), charge_volume(state, accumulator)
    gas = charge_gas(state, amount, accumulator)
    inside = fluid_state(accumulator_pressure(gas.pressure, V, accumulator), oil)
    held = accumulator_oil(V, accumulator) / inside.volume_ratio
    strain = inside.enthalpy - (inside.pressure - oil.reference_pressure) * inside.volume_ratio
    depth = seat_depth(V, accumulator)
    seat = 0.5 * seat_stiffness(accumulator) * depth * depth
    gas_energy = charge_energy(state, amount, oil.reference_pressure, accumulator)
    return Stored(gas_energy + seat + held * strain, held)


def charge_energy(state: ChargeState, amount: ChargeAmount, reference_pressure: float, charge: NitrogenCharge) -> float:
    """Energy of the gas, and against the outside that it pushes away, over that at its precharge [J].

    reference_pressure  outside, absolute [Pa]
    """
    n, V = amount.amount, charge_volume(state, charge)
    now = gas_internal_energy(V / n, state.gas_temperature, charge.real_gas)
    first = gas_internal_energy(charge.gas_volume / n, charge.shell_temperature, charge.real_gas)
    return n * (now - first) + reference_pressure * (V - charge.gas_volume)


def charge_at_rest(pressure: float, charge: NitrogenCharge) -> ChargeState:
    """State of the gas at a pressure, as warm as the shell; no larger than at its precharge.

    pressure  absolute [Pa]
    """
    reached = maximum(pressure, charge.precharge_pressure)
    volume = molar_volume(reached, charge.shell_temperature, charge.real_gas)
    return ChargeState(charge.gas_volume / (charge_amount(charge).amount * volume), charge.shell_temperature)


def spring_accumulator_force(position: float, accumulator: SpringAccumulator) -> float:
    """Force of the spring of an accumulator on its piston [N]: -A (p_0 + dp x/H).

    position  x [m]

    >>> store = SpringAccumulator(
    ...     piston_area=1e-3, stroke=0.1, spring_pressure=1e6, pressure_rise=2e6, moving_mass=1.0
    ... )
    >>> spring_accumulator_force(0.05, store)
    -2000.0
    """
    rise = accumulator.pressure_rise * position / accumulator.stroke
    return -accumulator.piston_area * (accumulator.spring_pressure + rise)


def spring_accumulator_energy(position: float, accumulator: SpringAccumulator) -> float:
    """Energy in the spring of an accumulator over that at position 0 [J]: A x (p_0 + dp x/(2 H)).

    position  x [m]
    """
    rise = 0.5 * accumulator.pressure_rise * position / accumulator.stroke
    return accumulator.piston_area * position * (accumulator.spring_pressure + rise)
