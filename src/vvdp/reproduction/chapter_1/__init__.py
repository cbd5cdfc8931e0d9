"""Chapter 1: what is claimed of digital hydraulics and of on/off valves."""

from vvdp.reproduction.chapter_1 import circuits, claims, literature

ITEMS = (*circuits.ITEMS, *claims.ITEMS, *literature.ITEMS)
