"""Chapter 6: displacement control of a cylinder."""

from vvdp.reproduction.item import Item

ITEMS: tuple[Item, ...] = ()
