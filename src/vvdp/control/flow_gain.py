"""Error of a flow that is looked up in a map, estimated from where the flow goes: into the swept volume and the
pressure.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Count, Flow, Kind, Pressure, Ratio, Time
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import POSITIVE, refuse_together, require_positive
from vvdp.base.select import clip
from vvdp.control.reference import Rate

VOLUME_PER_PRESSURE = Kind("volume per pressure", "m^3/Pa", 0.0, 1.0, "1e-12 m^3/Pa")

VolumePerPressure = Annotated[float, VOLUME_PER_PRESSURE]


class FlowGain(Params):
    """Parameters for the learned gain of a flow map.

    Flows are compared through a first-order filter of the `filter_rate`, which spares a derivative of the pressure;
    the gain follows at the `gain_rate`, within `lowest` and `highest`. It rests below `least_flow`, and for
    `settling_time` after the directional valve has moved. A `gain_rate` of 0 keeps it at 1.
    """

    filter_rate: Rate
    gain_rate: Rate
    lowest: Ratio
    highest: Ratio
    least_flow: Flow
    settling_time: Time

    def check(self) -> None:
        require_positive(self, "filter_rate", "least_flow")
        if not 0.0 < self.lowest <= 1.0 <= self.highest:
            refuse_together(
                self,
                f"1 must lie between lowest, {self.lowest:g}, and highest, {self.highest:g}, and lowest {POSITIVE}",
            )


class FlowGainMemory(NamedTuple):
    """The gain, flows and pressure as filtered, and for how long the valve has rested; `started` 0 before a sample."""

    gain: Ratio
    mapped: Flow
    swept: Flow
    pressure: Pressure
    rested: Time
    started: Count


class FlowBalance(NamedTuple):
    """Flows into and out of the line at a sample.

    `mapped` is the flow by the map, `swept` that of the piston; `pressure` that of the volume between, which takes up
    its `capacity` per pressure. `rests` is 1 while the directional valve stands.
    """

    mapped: Flow
    swept: Flow
    pressure: Pressure
    capacity: VolumePerPressure
    rests: Count


def flow_gain_start() -> FlowGainMemory:
    """The memory before the first sample: a gain of 1."""
    return FlowGainMemory(gain=1.0, mapped=0.0, swept=0.0, pressure=0.0, rested=0.0, started=0.0)


def flow_gain_step(memory: FlowGainMemory, seen: FlowBalance, interval: float, settings: FlowGain) -> FlowGainMemory:
    """The gain a sample later.

    g Q = q + C P' holds of means; through a/(s + a) it is g Q_f = q_f + a C (P - P_f), without a derivative. The gain
    goes down the slope of the error's square: g' = k Q_f (q_f + a C (P - P_f) - g Q_f)/(Q_f^2 + Q_0^2).

    interval  since the last sample [s]
    """
    s = settings
    if memory.started == 0.0:
        return FlowGainMemory(
            gain=memory.gain,
            mapped=seen.mapped,
            swept=seen.swept,
            pressure=seen.pressure,
            rested=0.0,
            started=1.0,
        )
    share = -expm1(-s.filter_rate * interval)
    mapped = memory.mapped + share * (seen.mapped - memory.mapped)
    swept = memory.swept + share * (seen.swept - memory.swept)
    pressure = memory.pressure + share * (seen.pressure - memory.pressure)
    rested = memory.rested + interval if seen.rests > 0.0 else 0.0
    gain = memory.gain
    if rested > s.settling_time and mapped > s.least_flow:
        told = swept + s.filter_rate * seen.capacity * (seen.pressure - pressure)
        slope = mapped * (told - gain * mapped) / (mapped * mapped + s.least_flow * s.least_flow)
        gain = clip(gain + interval * s.gain_rate * slope, s.lowest, s.highest)
    return FlowGainMemory(gain=gain, mapped=mapped, swept=swept, pressure=pressure, rested=rested, started=1.0)
