"""Ideal source of flow."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Power
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow_source import FlowSource, source_flow
from vvdp.network.component import Component


class Delivery(NamedTuple):
    """Flow that a source takes from its first port and gives to its second, and the power that this needs."""

    flow: Flow
    supplied: Power


def flow_source(a: FluidState, b: FluidState, flow: Flow, values: FlowSource) -> Delivery:
    """Source that takes `flow` [m^3/s] at a and gives it at b, with the power q (h_b - h_a)."""
    q = source_flow(flow, b.volume_ratio, values)
    return Delivery(q, q * (b.enthalpy - a.enthalpy))


FLOW_SOURCE = Component(flow_source, symbol="flow_source")
