"""Split of a demanded effort between a slow pump and a fast return valve: a Kalman filter of one state.

The pump's flow is the state, the effort is measured, and the opening of the valve beyond its mean is the noise.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Flow, Fraction, Ratio
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.control.capacities import Capacities, ForcePerVolume
from vvdp.control.cylinder_force import ForceRate
from vvdp.control.reference import Rate


class FlowSplit(Params):
    """The return valve opens by `mean_opening` and deviates by `opening_deviation`, the pump by `flow_deviation`.

    The flow follows at `flow_rate` lambda_Q, the pump gives at most `largest_flow`. It deviates about
    `expected_flow`, or if `feeds_forward` is 1, about the flow for the reference. `uses_delivered_flow` 1: the valve
    compensates flow that the pump does not deliver. `least_return_flow` is a floor for Psi.
    """

    mean_opening: Fraction
    flow_rate: Rate
    flow_deviation: Flow
    opening_deviation: Fraction
    largest_flow: Flow
    least_return_flow: Flow
    expected_flow: Flow = 0.0
    feeds_forward: Fraction = 1.0
    uses_delivered_flow: Fraction = 1.0

    def check(self) -> None:
        require_positive(self, "flow_rate", "flow_deviation", "opening_deviation", "largest_flow", "least_return_flow")


class SplitMemory(NamedTuple):
    """The pump's flow as estimated, and its variance over lambda_Q Q_J."""

    flow: Flow
    variance: Ratio


class Authority(NamedTuple):
    """Authority of pump and return valve over the force rate: H [N/m^3] per unit of flow, G Psi [N/s] for a full
    opening, which passes Psi."""

    per_flow: ForcePerVolume
    per_opening: ForceRate
    full_return: Flow


def authority(capacity: Capacities, full_return: float) -> Authority:
    """H, G Psi and Psi.  full_return: Psi [m^3/s]."""
    return Authority(capacity.supply_gain, capacity.return_gain * full_return, full_return)


def split_start() -> SplitMemory:
    """The memory before the first sample: no flow, the variance that it has where the effort shows nothing."""
    return SplitMemory(0.0, 0.5)


def sensitivity(authority: Authority, settings: FlowSplit) -> float:
    """c = Q_J/R_J (H/(G Psi))^2 [1]: how well the effort shows the flow."""
    ratio = settings.flow_deviation * authority.per_flow / (settings.opening_deviation * authority.per_opening)
    return ratio * ratio


def steady_variance(c: float) -> float:
    """Steady state of the variance, over lambda_Q Q_J [1]: 1/(1 + sqrt(1 + c)).  c: see `sensitivity` [1]."""
    settled: float = 1.0 / (1.0 + np.sqrt(1.0 + c))
    return settled


def split_step(
    memory: SplitMemory, effort: float, expected: float, authority: Authority, interval: float, settings: FlowSplit
) -> SplitMemory:
    """The estimated flow and its variance a sample later, exact while effort and gains are held.

    Q' = -lambda_Q (Q - Qbar) + L (nu - H/(G Psi) Q), which is lambda_Q (1 + c p) times the distance to
    (Qbar + c p Q_0)/(1 + c p), Q_0 = (U* - G Psi ubar)/H; p' = lambda_Q (1 - 2 p - c p^2).

    effort    U* [N/s]
    expected  Qbar [m^3/s]
    interval  [s]

    Source  wang2017, eqs. 6.26 to 6.31, with Qbar: docs/errata.md
    """
    c, time = sensitivity(authority, settings), settings.flow_rate * interval
    root = np.sqrt(1.0 + c)
    t = np.tanh(root * time) / root
    p = (memory.variance + (1.0 - memory.variance) * t) / (1.0 + (1.0 + c * memory.variance) * t)
    at_mean = (effort - authority.per_opening * settings.mean_opening) / authority.per_flow
    settled = (expected + c * p * at_mean) / (1.0 + c * p)
    flow = memory.flow + (memory.flow - settled) * expm1(-(1.0 + c * p) * time)
    return SplitMemory(clip(flow, 0.0, settings.largest_flow), p)
