"""Opening of a valve with one edge: its state, how it follows its static value, and what goes through the valve.

Source  ours, docs/models/components.md
"""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Kink, Opening, Power
from vvdp.base.select import select


class OpeningState(NamedTuple):
    """Opening of a valve with one edge; a relief valve is open by 1 at its rated point, and goes beyond."""

    opening: Opening


class OpeningPassage(NamedTuple):
    """Flow through a valve with one edge, the rate of its opening, and where that stands among its modes."""

    flow: Flow
    loss: Power
    rates: OpeningState
    side: Kink


def lagged_rate(static: float, opening: float, opening_time: float, closing_time: float = 0.0) -> float:
    """Rate of an opening [1/s]: (y_static - y)/tau, and 0 without an opening time.

    static        value that it follows [1]
    opening       y [1]
    opening_time  tau, 0 for a valve that follows at once [s]
    closing_time  tau while it closes, 0 where it is that of opening [s]

    >>> lagged_rate(1.0, 0.25, 2e-3), lagged_rate(1.0, 0.25, 0.0), lagged_rate(0.0, 0.25, 2e-3, 1e-3)
    (375.0, 0.0, -250.0)
    """
    closing = select(closing_time > 0.0, closing_time, opening_time)
    tau = select(static < opening, closing, opening_time)
    lag = (static - opening) / select(tau > 0.0, tau, 1.0)
    rate: float = select(tau > 0.0, lag, 0.0)
    return rate
