"""Chapter 4: the axial position under a periodic measurement noise."""

from vvdp.reproduction.chapter_4 import noise, observer, tracking

ITEMS = (*noise.ITEMS, *observer.ITEMS, *tracking.ITEMS)
