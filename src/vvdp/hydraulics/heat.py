"""Heat of the oil in volumes: what flow carries, what losses give, what goes through walls.

Heat counts from the temperature at the start, so that it is zero then.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Kind, SpecificHeat, Temperature
from vvdp.base.params import Params
from vvdp.base.select import maximum
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil, dynamic_viscosity
from vvdp.hydraulics.ports import Medium

HEAT_CONDUCTANCE = Kind("thermal conductance", "W/K", 0.0, 1e6, "20 W/K")
HeatConductance = Annotated[float, HEAT_CONDUCTANCE]
STILL = 1e-12
"""Flow below which a loss is shared among all nodes at a component [m^3/s]."""


class Coolant(NamedTuple):
    """Receiver of the heat of a cooler: its conductance, and the temperature of what flows on the other side."""

    conductance: HeatConductance
    temperature: Temperature


class HeatBalance(Params):
    """All oil is at `start_temperature` at first; each volume loses heat through its walls to the surroundings."""

    start_temperature: Temperature
    specific_heat: SpecificHeat = 1900.0
    wall_conductance: HeatConductance = 0.0
    ambient_temperature: Temperature = 293.15


def warmth(heat: float, volume: float, fluid: FluidState) -> float:
    """Heat per tank volume [J/m^3].

    heat    of a node [J]
    volume  of its oil [m^3]
    fluid   oil in it
    """
    return heat * fluid.volume_ratio / volume


def supplied_warmth(temperature: float, oil: Oil, balance: HeatBalance) -> float:
    """Heat per tank volume of oil at a temperature [J/m^3]: rho c (T - T_0).

    temperature  T [K]
    """
    return oil.density * balance.specific_heat * (temperature - balance.start_temperature)


def warm_temperature(content: float, oil: Oil, balance: HeatBalance) -> float:
    """Temperature of oil [K]: T_0 + w/(rho c).

    content  heat per tank volume, w [J/m^3]
    """
    return balance.start_temperature + content / (oil.density * balance.specific_heat)


def warm_medium(medium: Medium, temperature: float, oil: Oil) -> Medium:
    """The oil with the viscosity at another temperature; its density stays.

    temperature  [K]
    """
    return Medium(medium.density, dynamic_viscosity(temperature, oil))


def carried_heat(flow: float, own: float, carried: float, entering: float) -> float:
    """Heat that a component's flow brings to a node [W]: its share of the heat that the component takes out, minus the
    heat of the oil that it draws from the node.

    flow      into the node [tank volumes, m^3/s]
    own       heat per tank volume of the node [J/m^3]
    carried   heat that the component takes out of all nodes [W]
    entering  flow that it gives to all nodes [tank volumes, m^3/s]
    """
    inward, outward = maximum(flow, 0.0), maximum(-flow, 0.0)
    return inward / (entering + 1e-30) * carried - outward * own


def loss_share(flow: float, entering: float, nodes: float) -> float:
    """Share of a component's loss that a node gets [1]: as its share of the flow that enters; alike without flow.

    flow      into the node [tank volumes, m^3/s]
    entering  flow that the component gives to all nodes [tank volumes, m^3/s]
    nodes     how many nodes it joins [1]
    """
    return (maximum(flow, 0.0) + STILL) / (entering + nodes * STILL)


def wall_heat(temperature: float, balance: HeatBalance) -> float:
    """Heat that goes through the walls of a volume [W]: G (T - T_a).

    temperature  T of its oil [K]
    """
    return balance.wall_conductance * (temperature - balance.ambient_temperature)


def coolant_heat(temperature: float, coolant: Coolant) -> float:
    """Heat that a cooler takes from the oil behind it [W]: G (T - T_c).

    temperature  T of the oil [K]

    >>> coolant_heat(333.0, Coolant(conductance=500.0, temperature=293.0))
    20000.0
    """
    return coolant.conductance * (temperature - coolant.temperature)
