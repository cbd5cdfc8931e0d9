"""Chapter 1: what is claimed of digital hydraulics and of on/off valves."""

from vvdp.reproduction.item import Item

ITEMS: tuple[Item, ...] = ()
