"""Meters: powers that no part of a circuit has by itself, added up with its books, without effect on the circuit."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Force, Power
from vvdp.base.select import maximum
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.ports import RodState
from vvdp.network.component import Component


class MeteredPower(NamedTuple):
    """What a meter shows."""

    power: Power


def supply_meter(a: FluidState, b: FluidState, to_a: Flow, to_b: Flow) -> MeteredPower:
    """What an ideal variable pump would give for the same motion: what flows into either chamber, at its pressure."""
    return MeteredPower(maximum(to_a, 0.0) * a.enthalpy + maximum(to_b, 0.0) * b.enthalpy)


def actuator_meter(rod: RodState, force: Force) -> MeteredPower:
    """The power that the oil gives to a rod while it drives it; none while the rod drives the oil."""
    return MeteredPower(maximum(force * rod.velocity, 0.0))


SUPPLY_METER = Component(supply_meter, symbol="sensor", averages=("power",))
ACTUATOR_METER = Component(actuator_meter, symbol="sensor", averages=("power",))
