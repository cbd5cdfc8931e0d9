"""Digital flow control unit: on/off valves in parallel, each opened by the unit's code."""

from collections.abc import Mapping
from typing import NamedTuple

from vvdp.base.kinds import COUNT, Count, Flow, Kink, Power
from vvdp.base.modes import between
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.flow_control_unit import (
    FlowControlUnit,
    PoppetState,
    UnitValve,
    poppet_flow,
    poppet_opening,
    poppet_rate,
    valve_command,
)
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Source


class UnitPassage(NamedTuple):
    """Flow through a valve of a unit, the rate of its poppet, and whether it is closed, on its way or open."""

    flow: Flow
    loss: Power
    rates: PoppetState
    side: Kink


def unit_valve(a: FluidState, b: FluidState, code: Count, state: PoppetState, values: UnitValve) -> UnitPassage:
    """On/off valve between a and b that opens and closes by the `code` of its unit."""
    flow, loss = passage(poppet_flow(a.pressure - b.pressure, state.travel, values), a, b)
    rates = PoppetState(poppet_rate(valve_command(code, values), state.travel, values))
    return UnitPassage(flow, loss, rates, between(poppet_opening(state.travel, values)))


UNIT_VALVE = Component(unit_valve, symbol="switching_valve_2_2")


def add_flow_control_unit(
    net: Network, name: str, unit: FlowControlUnit, joints: Mapping[str, Source], start: None = None
) -> None:
    """Digital flow control unit between a and b: on/off valves in parallel, of which its `code` opens some.

    Its valves are `name_1` and so on, the smallest first.
    """
    for number, valve in enumerate(unit.parts, 1):
        net.add(f"{name}_{number}", UNIT_VALVE, valve, **joints)


FLOW_CONTROL_UNIT = Assembly(
    "flow_control_unit",
    FlowControlUnit,
    ("a", "b"),
    "switching_valve_2_2",
    add_flow_control_unit,
    inputs={"code": COUNT},
    holds_oil=False,
)
