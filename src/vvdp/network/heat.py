"""Volumes of a network that have a temperature of their own."""

from vvdp.hydraulics.heat import HeatBalance
from vvdp.network.network import Network
from vvdp.network.nodes import OilVolume

TOTALS = ("heat_losses", "heat_outside", "heat_walls")
"""Integrals of the heat that losses gave to the oil, that went to tanks and sources, and through walls and coolers."""


def heat_balance(network: Network) -> HeatBalance | None:
    """The heat balance of a network, where it has one."""
    return next((value for value in network.values.values() if isinstance(value, HeatBalance)), None)


def warm_volumes(network: Network) -> tuple[str, ...]:
    """The volumes whose heat is a state."""
    if heat_balance(network) is None:
        return ()
    return tuple(name for name, node in network.nodes.items() if isinstance(node, OilVolume))
