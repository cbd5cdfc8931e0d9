"""Chapter 2: pressure drop, torque and speed of the rotary valve, and its inlet rail."""

from vvdp.reproduction.item import Item

ITEMS: tuple[Item, ...] = ()
