"""Oil under one pressure: chamber, elastic hose and gas accumulator in any combination, and what they store.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, TypeAlias

import numpy as np

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Compliance, Polytropic, Pressure, Volume
from vvdp.base.params import Params, without_effect
from vvdp.base.powers import power
from vvdp.base.rules import field_text, refuse
from vvdp.base.select import select
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil

SEATING = 0.01
"""Share of the precharge over which the bladder of an accumulator leaves its seat."""
NODES, WEIGHTS = (tuple(map(float, 0.5 * column)) for column in np.polynomial.legendre.leggauss(16))
NODES = tuple(0.5 + node for node in NODES)


GasPressure: TypeAlias = Annotated[Pressure, without_effect("gas_volume")]
GasExponent: TypeAlias = Annotated[Polytropic, without_effect("gas_volume")]


class VesselSize(Params):
    """Oil at the reference pressure, 1/B of its elastic walls, gas behind a bladder, each of which may be none.

    `hose_compliance` 0 is rigid; `gas_volume` 0 is without accumulator, whose other two values are then unused.
    `precharge_pressure` is absolute, and `gas_volume` is the volume at that pressure.
    """

    oil_volume: Volume
    hose_compliance: Compliance
    gas_volume: Volume
    precharge_pressure: GasPressure
    gas_exponent: GasExponent

    def check(self) -> None:
        if self.gas_volume > 0.0 and self.precharge_pressure <= 0.0:
            gas = field_text(self, "gas_volume")
            refuse(self, "precharge_pressure", f"must be greater than 0 bara with a gas_volume of {gas}")


class Vessel(VesselSize):
    """Everything at one pressure; there is oil."""

    def check(self) -> None:
        if self.oil_volume <= 0.0:
            refuse(self, "oil_volume", "must be greater than 0: below precharge nothing else would hold the pressure")


def pressure_rate(
    net_flow: float,
    volume_rate: float,
    fluid: FluidState,
    vessel: Vessel,
    reference_pressure: float,
    swept_volume: float = 0.0,
) -> float:
    """Rate of the pressure in a vessel [Pa/s].

    P' = (nu sum(q) - dV/dt) / (V/beta + dV_hose/dP + dV_gas/dP), V the oil held at this pressure

    net_flow            sum of the flows in [tank volumes, m^3/s]
    volume_rate         dV/dt of a moving wall, the rate of `swept_volume` [m^3/s]
    reference_pressure  of the oil, absolute [Pa]
    swept_volume        what a moving wall adds to the vessel [m^3]

    Holds   for changes that are slow against a wave through the vessel: one pressure throughout

    >>> vessel = Vessel(
    ...     oil_volume=1e-3, hose_compliance=0.0, gas_volume=0.0, precharge_pressure=0.0, gas_exponent=1.2
    ... )
    >>> print(round(pressure_rate(1e-4, 0.0, FluidState(1e5, 1.0, 1.4e9, 0.0), vessel, 1e5) / 1e5))  # bar/s
    1400
    """
    pressure = fluid.pressure
    gas = gas_volume(pressure, vessel)
    V = oil_beside(gas, pressure, vessel, reference_pressure) + swept_volume
    capacity = V / fluid.bulk_modulus + capacity_beside(gas, pressure, vessel)
    return (fluid.volume_ratio * net_flow - volume_rate) / capacity


def closed_volume_rate(net_flow: float, volume_rate: float, volume: float, fluid: FluidState) -> float:
    """Rate of the pressure in a rigid volume without gas [Pa/s]: P' = beta/V (nu sum(q) - dV/dt).

    net_flow     sum of the flows in [tank volumes, m^3/s]
    volume_rate  dV/dt of a moving wall [m^3/s]
    volume       of oil, now [m^3]
    """
    return fluid.bulk_modulus / volume * (fluid.volume_ratio * net_flow - volume_rate)


def vessel_contents(fluid: FluidState, oil: Oil, vessel: Vessel, swept_volume: float = 0.0) -> Stored:
    """Energy [J] and tank volumes [m^3] in a vessel: 0 and V0 + swept at the reference pressure without gas.

    energy = V w/nu + V0 (P - ref)^2 / (2 B) + gas, volume = V/nu, with w the strain energy per tank volume.

    fluid         oil in the vessel
    swept_volume  what a moving wall adds to the vessel [m^3]
    """
    pressure = fluid.pressure
    excess = pressure - oil.reference_pressure
    oil_inside = closed_volume_contents(fluid, oil_held(pressure, vessel, oil.reference_pressure) + swept_volume, oil)
    hose = 0.5 * vessel.oil_volume * vessel.hose_compliance * excess**2
    return Stored(oil_inside.energy + hose + gas_energy(pressure, vessel, oil.reference_pressure), oil_inside.volume)


def closed_volume_contents(fluid: FluidState, volume: float, oil: Oil) -> Stored:
    """Energy [J] and tank volumes [m^3] of the oil in a rigid volume: V w/nu and V/nu.

    fluid   oil in the volume
    volume  of oil, now [m^3]
    """
    tank_volumes = volume / fluid.volume_ratio
    strain = fluid.enthalpy - (fluid.pressure - oil.reference_pressure) * fluid.volume_ratio
    return Stored(tank_volumes * strain, tank_volumes)


def oil_held(pressure: float, vessel: Vessel, reference_pressure: float) -> float:
    """Volume of oil in a vessel at its pressure [m^3]: V0 (1 + (P - ref)/B) + Vg0 - Vg(P).

    pressure            absolute [Pa]
    reference_pressure  at which the hose is unstretched, absolute [Pa]
    """
    return oil_beside(gas_volume(pressure, vessel), pressure, vessel, reference_pressure)


def oil_beside(gas: float, pressure: float, vessel: Vessel, reference_pressure: float) -> float:
    """Volume of oil in a vessel whose gas takes a known volume [m^3]; see `oil_held`.

    gas                 its volume now [m^3]
    pressure            absolute [Pa]
    reference_pressure  at which the hose is unstretched, absolute [Pa]
    """
    hose = vessel.oil_volume * (1.0 + vessel.hose_compliance * (pressure - reference_pressure))
    return hose + vessel.gas_volume - gas


def wall_capacity(pressure: float, vessel: VesselSize) -> float:
    """Room that a vessel's hose and gas give per pressure [m^3/Pa]: V0/B - dVg/dP.

    pressure  absolute [Pa]
    """
    return capacity_beside(gas_volume(pressure, vessel), pressure, vessel)


def capacity_beside(gas: float, pressure: float, vessel: VesselSize) -> float:
    """Room that a vessel whose gas takes a known volume gives per pressure [m^3/Pa]; see `wall_capacity`.

    gas       its volume now [m^3]
    pressure  absolute [Pa]
    """
    return vessel.oil_volume * vessel.hose_compliance + gas_yielding(gas, pressure, vessel)


def capacity_beside_compiled(gas: float, pressure: float, vessel: VesselSize) -> float:
    """The same as `capacity_beside`, which it replaces in compiled code: no gas law for a vessel without gas.

    gas       its volume now [m^3]
    pressure  absolute [Pa]
    """
    hose = vessel.oil_volume * vessel.hose_compliance
    return hose if gas == 0.0 else hose + gas_yielding(gas, pressure, vessel)


def gas_yielding(gas: float, pressure: float, vessel: VesselSize) -> float:
    """Room that the gas of a vessel gives per pressure of the oil [m^3/Pa]: -dVg/dP.

    gas       its volume now [m^3]
    pressure  of the oil, absolute [Pa]
    """
    p0 = vessel.precharge_pressure
    d, width = pressure - p0, SEATING * p0 + select(p0 > 0.0, 0.0, 1.0)
    carried = 0.5 + 0.5 * d / np.sqrt(d * d + width * width)
    inside = p0 + gas_excess(pressure, vessel)
    yielding: float = gas * carried / (vessel.gas_exponent * inside)
    return yielding


def gas_excess(pressure: float, vessel: VesselSize) -> float:
    """Pressure of the gas above its precharge [Pa]: (d + sqrt(d^2 + s^2))/2, d the oil's above the precharge.

    Far above, the gas carries the oil's pressure; far below, the shell carries the gas. In between the bladder lifts
    off its seat over a share `SEATING` of the precharge, so that the vessel's capacity has no jump there.

    pressure  of the oil, absolute [Pa]
    """
    p0 = vessel.precharge_pressure
    d, width = pressure - p0, SEATING * p0 + select(p0 > 0.0, 0.0, 1.0)
    reach = np.sqrt(d * d + width * width) + abs(d)
    # Below the precharge the sum of the two cancels; its product with the difference is the width squared.
    excess: float = 0.5 * select(d > 0.0, reach, width * width / reach)
    return excess


def gas_volume(pressure: float, vessel: VesselSize) -> float:
    """Volume of the gas in a vessel [m^3]: Vg0 (p0/p)^(1/k), p the precharge p0 and `gas_excess`.

    pressure  of the oil, absolute [Pa]

    Holds   for an ideal gas that changes at one exponent

    >>> vessel = Vessel(
    ...     oil_volume=1e-3, hose_compliance=0.0, gas_volume=1e-3, precharge_pressure=50e5, gas_exponent=1.0
    ... )
    >>> print(round(1e3 * gas_volume(100e5, vessel), 3))  # litres
    0.5
    """
    p0 = vessel.precharge_pressure
    ratio = 1.0 + gas_excess(pressure, vessel) / select(p0 > 0.0, p0, 1.0)
    expansion: float = power(ratio, -1.0 / vessel.gas_exponent)
    return vessel.gas_volume * expansion


def gas_volume_compiled(pressure: float, vessel: VesselSize) -> float:
    """The same as `gas_volume`, which it replaces in compiled code: no gas law for a vessel without gas.

    pressure  of the oil, absolute [Pa]
    """
    if vessel.gas_volume == 0.0:
        return 0.0
    ratio = 1.0 + gas_excess(pressure, vessel) / vessel.precharge_pressure
    expansion: float = power(ratio, -1.0 / vessel.gas_exponent)
    return vessel.gas_volume * expansion


def gas_energy(pressure: float, vessel: Vessel, reference_pressure: float) -> float:
    """Energy that the oil has put into the gas of a vessel and its seat from the reference pressure on [J].

    int (P - ref) d(-Vg) with P = p - s^2/(4 (p - p0)): the gas's own work in closed form, that of the seat by its
    logarithm and Gauss points for the smooth rest.

    pressure            absolute [Pa]
    reference_pressure  outside, absolute [Pa]
    """
    p0, Vg0 = vessel.precharge_pressure, vessel.gas_volume
    unit = select(p0 > 0.0, p0, 1.0)
    v = gas_excess(pressure, vessel) / unit
    v0 = gas_excess(reference_pressure, vessel) / unit
    gas = p0 * Vg0 * (_gas_work(v, vessel.gas_exponent) - _gas_work(v0, vessel.gas_exponent))
    seat = -0.25 * SEATING * SEATING * p0 * Vg0 * (_seat_work(v, vessel) - _seat_work(v0, vessel))
    outside = reference_pressure * (gas_volume(reference_pressure, vessel) - gas_volume(pressure, vessel))
    return gas + seat - outside


def _gas_work(excess: float, exponent: float) -> float:
    """Work on a gas compressed to 1 + excess of its first pressure, over that pressure and volume [1]."""
    k, L = exponent, np.log1p(excess)
    growth: float = select(k > 1.0, np.expm1((k - 1.0) / k * L) / select(k > 1.0, k - 1.0, 1.0), L)
    return growth


def _seat_work(excess: float, vessel: Vessel) -> float:
    """int dv / (k v (1 + v)^(1 + 1/k)) up to the excess, from an arbitrary start [1]."""
    k = vessel.gas_exponent
    a, L = 1.0 + 1.0 / k, np.log1p(excess)
    rest = 0.0
    for i in range(16):
        x = NODES[i] * L
        rest = rest - WEIGHTS[i] * L * np.expm1(-a * x) * np.exp(x) / select(x > 0.0, np.expm1(x), 1.0)
    work: float = (np.log(excess) - rest) / k
    return work
