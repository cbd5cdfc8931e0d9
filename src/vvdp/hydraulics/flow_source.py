"""Sources that give the flow that is commanded, whatever the pressures: at once, or with a lag."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Fraction, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import select


class FlowSource(Params):
    """Reference of the flow: `counted_at_outlet` 0 counts tank volumes, as a pump does; 1 volume at the outlet's
    pressure."""

    counted_at_outlet: Fraction = 0.0

    def check(self) -> None:
        if self.counted_at_outlet not in (0.0, 1.0):
            refuse(self, "counted_at_outlet", "must be 0 (tank volumes) or 1 (volume at the outlet's pressure)")


class LaggingSource(FlowSource):
    """A source whose flow follows its command with the time constant `lag`, as a pump with its stroking."""

    lag: Time

    def check(self) -> None:
        require_positive(self, "lag")


class SourceState(NamedTuple):
    """Present flow of a source with a lag."""

    flow: Flow


def source_rate(command: float, flow: float, source: LaggingSource) -> float:
    """Rate of the flow of a source with a lag [m^3/s^2]: (command - Q)/lag.

    command  commanded flow [m^3/s]
    flow     Q, now [m^3/s]

    Source  wang2017, ch. 6 (the pump as a first-order lag)
    """
    return (command - flow) / source.lag


def source_flow(flow: float, outlet_volume_ratio: float, source: FlowSource) -> float:
    """Flow of an ideal source [tank volumes, m^3/s]: the flow, or flow/nu(outlet) where it is counted there.

    flow                 as counted; negative from outlet to inlet [m^3/s]
    outlet_volume_ratio  nu of the oil at the outlet [1]

    Source  ours, docs/models/components.md
    """
    counted: float = select(source.counted_at_outlet > 0.5, flow / outlet_volume_ratio, flow)
    return counted
