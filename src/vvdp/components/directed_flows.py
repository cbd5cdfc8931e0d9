"""A pump and a meter-out throttle behind an ideal directional valve: it switches at once and loses nothing."""

from typing import NamedTuple

from vvdp.base.kinds import ExchangedPower, Flow, FlowCoefficient, Fraction, Power, PressureDifference, SignedFraction
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import root_passage
from vvdp.hydraulics.flow_source import LaggingSource, SourceState, source_flow, source_rate
from vvdp.network.component import Component


class ReturnThrottle(Params):
    """A throttle of `conductance` fully open; its flow turns linear in the drop below about `transition_pressure`."""

    conductance: FlowCoefficient
    transition_pressure: PressureDifference

    def check(self) -> None:
        require_positive(self, "conductance", "transition_pressure")


class DirectedDelivery(NamedTuple):
    """Flows of a directed source into its nodes, the power that it needs, and the rate of its flow."""

    tank: Flow
    a: Flow
    b: Flow
    supplied: ExchangedPower
    rates: SourceState


class DirectedReturn(NamedTuple):
    """Flows of a directed return into its nodes, and its loss."""

    tank: Flow
    a: Flow
    b: Flow
    loss: Power


def directed_source(
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    command: Flow,
    direction: SignedFraction,
    state: SourceState,
    values: LaggingSource,
) -> DirectedDelivery:
    """Pump whose flow follows `command` with a lag and goes to a in `direction` 1, to b in -1, back to tank in 0."""
    to_a = clip(direction, 0.0, 1.0) * source_flow(state.flow, a.volume_ratio, values)
    to_b = clip(-direction, 0.0, 1.0) * source_flow(state.flow, b.volume_ratio, values)
    return DirectedDelivery(
        tank=-to_a - to_b,
        a=to_a,
        b=to_b,
        supplied=to_a * (a.enthalpy - tank.enthalpy) + to_b * (b.enthalpy - tank.enthalpy),
        rates=SourceState(source_rate(command, state.flow, values)),
    )


def directed_return(
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    opening: Fraction,
    direction: SignedFraction,
    values: ReturnThrottle,
) -> DirectedReturn:
    """Throttle, open by `opening`, from b to tank in `direction` 1, from a in -1; enclosed 0."""
    y = clip(opening, 0.0, 1.0)
    from_a = root_passage(a, tank, y * clip(-direction, 0.0, 1.0), values)
    from_b = root_passage(b, tank, y * clip(direction, 0.0, 1.0), values)
    return DirectedReturn(
        tank=from_a.flow + from_b.flow, a=-from_a.flow, b=-from_b.flow, loss=from_a.loss + from_b.loss
    )


DIRECTED_SOURCE = Component(directed_source, symbol="flow_source")
DIRECTED_RETURN = Component(directed_return, symbol="directional_valve")
