"""Quantities at the ports of a component: oil at a pressure is `fluid.mixture.FluidState`, the rest is here."""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Angle, Density, DynamicViscosity, Flow, Kind, Position, Speed, Velocity, Volume

SURPLUS = Kind("surplus flow", "m^3/s", -1.0, 1.0, "1 lpm")
EXCHANGED_POWER = Kind("exchanged power", "W", -1e9, 1e9, "5.6 kW")
ExchangedPower = Annotated[float, EXCHANGED_POWER]
"""Power that may go either way, such as that of an external force."""
Surplus = Annotated[float, SURPLUS]
"""Flow into the volume at a component's first port without that component, minus the flow that its walls take up [m^3/s
at the pressure there]."""


class Medium(NamedTuple):
    """An oil at its temperature and reference pressure."""

    density: Density
    viscosity: DynamicViscosity


class ShaftState(NamedTuple):
    """A shaft that turns, where the angle counts."""

    angle: Angle
    speed: Speed


class ShaftSpeed(NamedTuple):
    """A shaft that turns, where only its speed counts."""

    speed: Speed


class RodState(NamedTuple):
    """A rod, or whatever else moves along a line."""

    position: Position
    velocity: Velocity


class Wall(NamedTuple):
    """A wall that moves in a volume: the volume that it has added, and its rate."""

    volume: Volume
    rate: Flow
