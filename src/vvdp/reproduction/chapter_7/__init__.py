"""Chapter 7: what is proposed for later."""

from vvdp.reproduction.chapter_7 import later

ITEMS = later.ITEMS
