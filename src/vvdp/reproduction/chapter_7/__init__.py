"""Chapter 7: what is proposed for later."""

from vvdp.reproduction.item import Item

ITEMS: tuple[Item, ...] = ()
