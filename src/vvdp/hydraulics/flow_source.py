"""Ideal source of flow: gives what it is told to, whatever the pressures."""

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Fraction
from vvdp.base.params import Params
from vvdp.base.select import select


class FlowSource(Params):
    """What its flow counts: `counted_at_outlet` 0 tank volumes, as a pump does; 1 volume at the outlet's pressure."""

    counted_at_outlet: Fraction = 0.0

    def check(self) -> None:
        if self.counted_at_outlet not in (0.0, 1.0):
            raise ParameterError(
                f"FlowSource.counted_at_outlet: {self.counted_at_outlet:g}; expected 0 (tank volumes) "
                "or 1 (volume at the outlet's pressure)"
            )


def source_flow(flow: float, outlet_volume_ratio: float, source: FlowSource) -> float:
    """Flow of an ideal source [tank volumes, m^3/s]: the flow, or flow/nu(outlet) where it is counted there.

    flow                 as it is counted; negative from outlet to inlet [m^3/s]
    outlet_volume_ratio  nu of the oil at the outlet [1]

    Source  ours, docs/models/components.md
    """
    counted: float = select(source.counted_at_outlet > 0.5, flow / outlet_volume_ratio, flow)
    return counted
