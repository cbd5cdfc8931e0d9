"""Chapter 5: passivity-based control of the axial position."""

from vvdp.reproduction.item import Item

ITEMS: tuple[Item, ...] = ()
