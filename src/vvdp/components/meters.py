"""Meters: powers that no part of a circuit has by itself, added up with its books, without effect on the circuit.

Source  ours, docs/models/whole-machine.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Force, Fraction, Power
from vvdp.base.select import maximum
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.ports import Medium, RodState
from vvdp.network.component import Component
from vvdp.valve.losses import throttling_power
from vvdp.valve.rotary import RotaryValve


class MeteredPower(NamedTuple):
    """Reading of a meter."""

    power: Power


def supply_meter(a: FluidState, b: FluidState, to_a: Flow, to_b: Flow) -> MeteredPower:
    """Power that an ideal variable pump would deliver for the same motion: the flow into either chamber, at its
    pressure."""
    return MeteredPower(maximum(to_a, 0.0) * a.enthalpy + maximum(to_b, 0.0) * b.enthalpy)


def actuator_meter(rod: RodState, force: Force) -> MeteredPower:
    """The power that the oil gives to a rod while it drives it; none while the rod drives the oil."""
    return MeteredPower(maximum(force * rod.velocity, 0.0))


def transition_meter(
    inlet: FluidState,
    to_load: Flow,
    to_tank: Flow,
    leakage: Flow,
    load_opening: Fraction,
    tank_opening: Fraction,
    medium: Medium,
    valve: RotaryValve,
) -> MeteredPower:
    """Loss of the nozzles of a rotary valve beyond that of fully open ones; see `throttling_power`.

    to_load, to_tank, leakage  as the valve shows them: the leakage goes from load to tank past the nozzles
    """
    nu = inlet.volume_ratio
    load = throttling_power(nu * (to_load + leakage), load_opening, medium.density, valve)
    tank = throttling_power(nu * (to_tank - leakage), tank_opening, medium.density, valve)
    return MeteredPower(load + tank)


SUPPLY_METER = Component(supply_meter, symbol="sensor", averages=("power",))
ACTUATOR_METER = Component(actuator_meter, symbol="sensor", averages=("power",))
TRANSITION_METER = Component(transition_meter, symbol="sensor", averages=("power",))
