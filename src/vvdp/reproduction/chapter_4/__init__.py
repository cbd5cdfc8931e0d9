"""Chapter 4: the axial position of the spool under a periodic noise."""

from vvdp.reproduction.item import Item

ITEMS: tuple[Item, ...] = ()
