"""The compensator of a variable pump, as a part of its own that gives a setting."""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Kink
from vvdp.base.modes import side
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.pump_compensator import PumpCompensator, compensated_share, torque_distance
from vvdp.hydraulics.variable_pump import SwivelState, held_level, swivel_side
from vvdp.network.component import Component


class Compensation(NamedTuple):
    """The setting that a compensator demands, the rate of its control, and the limit that decides."""

    setting: Fraction
    rates: SwivelState
    side: Kink
    limited: Kink


def pump_compensator(
    inlet: FluidState, outlet: FluidState, pilot: FluidState, state: SwivelState, values: PumpCompensator
) -> Compensation:
    """Control of a variable pump that holds a margin over its pilot, up to a pressure and a torque.

    No oil flows at its ports. With the pilot at the load it senses the load; behind a fixed throttle it holds a flow;
    with a margin as large as the highest pressure it holds that pressure.
    """
    load = pilot.pressure
    shortfall = held_level(values, load, load, load) - outlet.pressure
    rise = outlet.pressure - inlet.pressure
    setting = compensated_share(shortfall, rise, state.swivel, values)
    return Compensation(
        setting=setting,
        rates=SwivelState((setting - state.swivel) / values.reset_time),
        side=swivel_side(shortfall, state.swivel, values),
        limited=side(torque_distance(shortfall, rise, state.swivel, values)),
    )


PUMP_COMPENSATOR = Component(pump_compensator, symbol="compensator", averages=("setting",))
