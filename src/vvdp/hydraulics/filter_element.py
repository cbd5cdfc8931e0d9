"""Filter whose element clogs with the dirt that it takes out, with a bypass valve.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Conductance, Flow, Kind, Mass, PressureDifference
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import maximum, select

DIRT_CONTENT = Kind("dirt content", "kg/m^3", 0.0, 10.0, "0.005 kg/m^3")
DirtContent = Annotated[float, DIRT_CONTENT]
DIRT_LOAD = Kind("dirt load", "1", 0.0, 1.0, "0.5", scale=1e-4)
DirtLoad = Annotated[float, DIRT_LOAD]


class FilterElement(Params):
    """An element that passes `clean_conductance` while new and nothing once it holds `dirt_capacity`.

    `dirt_content` is that of the oil; all of it stays. From the drop `bypass_pressure` on, a bypass opens with
    `bypass_conductance`.
    """

    clean_conductance: Conductance
    dirt_capacity: Mass
    dirt_content: DirtContent
    bypass_pressure: PressureDifference
    bypass_conductance: Conductance

    def check(self) -> None:
        require_positive(self, "clean_conductance", "dirt_capacity")


class FilterState(NamedTuple):
    """Dirt in the element over its capacity."""

    clogging: DirtLoad


class FilterFlows(NamedTuple):
    """Flow through the element and past it."""

    element: Flow
    bypass: Flow


def filter_flows(drop: float, clogging: float, element: FilterElement) -> FilterFlows:
    """Flows through a filter's element and past it [m^3/s]: G (1 - c) dP and G_by max(dP - dP_by, 0).

    drop      dP from the inlet to the outlet [Pa]
    clogging  c, dirt over capacity [1]

    >>> new = FilterElement(
    ...     clean_conductance=2e-8, dirt_capacity=0.02, dirt_content=5e-3, bypass_pressure=3e5, bypass_conductance=1e-8
    ... )
    >>> [round(6e4 * q, 2) for q in filter_flows(4e5, 0.75, new)]  # l/min
    [120.0, 60.0]
    """
    open_fraction = maximum(1.0 - clogging, 0.0)
    through = element.clean_conductance * open_fraction * drop
    return FilterFlows(through, element.bypass_conductance * maximum(drop - element.bypass_pressure, 0.0))


def clogging_rate(flow: float, element: FilterElement) -> float:
    """Rate of clogging of a filter's element [1/s]: C max(Q, 0)/M; flow back washes nothing out.

    flow  Q through the element [m^3/s]
    """
    return element.dirt_content * select(flow > 0.0, flow, 0.0) / element.dirt_capacity


def bypass_side(drop: float, element: FilterElement) -> float:
    """Whether the bypass of a filter is open [1], see `base.modes.side`.

    drop  from the inlet to the outlet [Pa]
    """
    return side((drop - element.bypass_pressure) / (element.bypass_pressure + 1e5))
