"""Common laws of passages between two volumes: the root law near zero drop, tank volumes, and the power lost.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple, Protocol

import numpy as np

from vvdp.base.kinds import Flow, FlowCoefficient, Power, PressureDifference
from vvdp.base.modes import side
from vvdp.base.select import clip, select
from vvdp.fluid.mixture import FluidState

LAMINAR_SHARE = 0.01
"""Share of its rated drop below which the flow of a rated valve turns from root to straight line."""


SEEN_FLOW = 1e-4
"""Flow whose approach to zero is followed [m^3/s]: 6 lpm."""

STILL_FLOW = 1e-12
"""Flow up to which oil stands still [m^3/s]: at rest it would else turn about at every step."""


class Passage(NamedTuple):
    """Passage of oil: `flow` in tank volumes per second, signed, and the power `loss` that it dissipates."""

    flow: Flow
    loss: Power


class RatedEdge(Protocol):
    """An edge that is known by a rated point."""

    @property
    def rated_flow(self) -> Flow: ...
    @property
    def rated_drop(self) -> PressureDifference: ...


class RootEdge(Protocol):
    """An edge of known conductance."""

    @property
    def conductance(self) -> FlowCoefficient: ...
    @property
    def transition_pressure(self) -> PressureDifference: ...


def passage(flow: float, upstream: FluidState, downstream: FluidState) -> Passage:
    """Flow [tank volumes, m^3/s] and loss [W] of an actual volume flow between two volumes.

    q = flow / nu(side it comes from), loss = q (h_up - h_down); never negative while the flow runs down the pressure.

    flow        actual, at the pressure of the side it comes from; positive from upstream to downstream [m^3/s]
    upstream    oil on the first-named side
    downstream  oil on the second-named side
    """
    # One of the two is 0. In compiled code all passages of a volume share the division, as they could not in a choice.
    forward = select(flow > 0.0, flow, 0.0)
    q = forward * (1.0 / upstream.volume_ratio) + (flow - forward) * (1.0 / downstream.volume_ratio)
    return Passage(q, q * (upstream.enthalpy - downstream.enthalpy))


def flow_side(flow: float) -> float:
    """The direction of a flow as the side of a kink [1], see `base.modes.side`: a flow that counts in one direction
    only has a kink at 0.

    flow  either sign [m^3/s]
    """
    return side((flow - clip(flow, -STILL_FLOW, STILL_FLOW)) / SEEN_FLOW)


def signed_root(pressure_drop: float, transition_pressure: float) -> float:
    """Root of a pressure drop with its sign [Pa^0.5], a straight line through zero.

    dp / (dp^2 + eps^2)^(1/4): within (eps/dp)^2/4 of the root for dp >> eps, dp/sqrt(eps) for dp << eps.

    pressure_drop        dp, either sign [Pa]
    transition_pressure  eps, greater than zero [Pa]

    >>> print(round(signed_root(-100.0, 1e-3), 6))
    -10.0
    """
    dp, eps = pressure_drop, transition_pressure
    # Two square roots are several times faster than a power.
    root: float = np.sqrt(np.sqrt(dp * dp + eps * eps))
    return dp / root


def rated_root(pressure_drop: float, rated_drop: float) -> float:
    """Flow of a rated resistance as a ratio of its rated flow [1]: signed root, exactly 1 at the rated drop.

    pressure_drop  either sign [Pa]
    rated_drop     greater than zero [Pa]
    """
    return signed_root(pressure_drop / rated_drop, LAMINAR_SHARE) / signed_root(1.0, LAMINAR_SHARE)


def rated_edge_flow(rated_flow: float, opening: float, pressure_drop: float, rated_drop: float) -> float:
    """Volume flow over an edge that is known by a rated point [m^3/s]: Q_r y root(dp)/root(dp_r), signed like the drop.

    rated_flow     Q_r, fully open at the rated drop [m^3/s]
    opening        y [1]
    pressure_drop  dp, first-named side less the second [Pa]
    rated_drop     dp_r, greater than zero [Pa]

    >>> print(rated_edge_flow(1e-3, 0.5, -5e5, 5e5))
    -0.0005
    """
    return rated_flow * opening * rated_root(pressure_drop, rated_drop)


def root_edge_flow(conductance: float, opening: float, pressure_drop: float, transition_pressure: float) -> float:
    """Volume flow over an edge of known conductance [m^3/s]: K y root(dp), signed like the drop.

    conductance          K, fully open [m^3/(s Pa^0.5)]
    opening              y [1]
    pressure_drop        dp, first-named side less the second [Pa]
    transition_pressure  below about which the flow is linear in the drop, greater than zero [Pa]
    """
    return conductance * opening * signed_root(pressure_drop, transition_pressure)


def rated_passage(upstream: FluidState, downstream: FluidState, opening: float, edge: RatedEdge) -> Passage:
    """Flow [m^3/s] and loss [W] over an edge that is known by a rated point; see `passage` and `rated_edge_flow`.

    upstream, downstream  oil on the first-named and on the second-named side
    opening               [1]
    """
    drop = upstream.pressure - downstream.pressure
    return passage(rated_edge_flow(edge.rated_flow, opening, drop, edge.rated_drop), upstream, downstream)


def root_passage(upstream: FluidState, downstream: FluidState, opening: float, edge: RootEdge) -> Passage:
    """Flow [m^3/s] and loss [W] over an edge of known conductance; see `passage` and `root_edge_flow`.

    upstream, downstream  oil on the first-named and on the second-named side
    opening               [1]
    """
    drop = upstream.pressure - downstream.pressure
    return passage(root_edge_flow(edge.conductance, opening, drop, edge.transition_pressure), upstream, downstream)
