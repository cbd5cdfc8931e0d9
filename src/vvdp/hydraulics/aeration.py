"""Free air in a volume of oil: what flows in with the oil, dissolves and comes out of solution.

Source  ours, docs/models/fluid.md.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import ExchangedPower, Flow, Kind
from vvdp.base.select import select
from vvdp.fluid.dissolving import FreeAir, free_air_rate
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.fluid.parts import air_part, vapour_part

AIR_RATE = Kind("rate of free air", "1/s", -1e12, 1e12, "0.1 1/s")
AirRate = Annotated[float, AIR_RATE]


class AirChange(NamedTuple):
    """Rate of the free air of a volume, the tank volumes that would take the same room, and the power loss.

    The power is the work of the volume's pressure on the room of air that dissolves, and a correction of the losses of
    components, which are calculated as if their oil already had the free air of the volume.
    """

    rate: AirRate
    room: Flow
    power: ExchangedPower


def mixed_air(drawn_air: float, drawn_flow: float) -> FreeAir:
    """Free air of the oil that a component gives to some of its ports, per tank volume [1]: the mean of the oil it
    draws.

    drawn_air   sum of the flows that it draws from its ports, each times the free air there [m^3/s]
    drawn_flow  the sum alone [tank volumes, m^3/s]
    """
    return drawn_air / select(drawn_flow > 0.0, drawn_flow, 1.0)


def air_change(air_flow: float, volume: float, fluid: FluidState, free_air: float, oil: Oil) -> AirChange:
    """Rate of the free air of a volume, see `AirChange`.

    With N = V/nu: phi' = sum(q (phi_i - phi))/N + (phi_eq - phi)/tau; the room is N phi' a/nu, and the power
    -N phi' int a dP, with a the volume of air per volume at the reference pressure.

    air_flow  sum of the flows in, each times the free air it has beyond the volume's [m^3/s]
    volume    of oil, now [m^3]
    fluid     oil in the volume
    free_air  in it, per tank volume [1]
    """
    held = volume / fluid.volume_ratio
    rate = air_flow / held + free_air_rate(fluid.pressure, free_air, oil)
    air = air_part(fluid.pressure, oil)
    gained = held * rate
    return AirChange(rate, gained * air.volume / fluid.volume_ratio, -gained * air.enthalpy)


def vapour_volume(volume: float, fluid: FluidState, oil: Oil) -> float:
    """Volume of the vapour in a volume of oil [m^3]: V v/nu, v the vapour per tank volume.

    volume  of oil, now [m^3]
    fluid   oil in the volume
    """
    return volume * vapour_part(fluid.pressure, oil).volume / fluid.volume_ratio
