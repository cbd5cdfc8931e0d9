"""Chapter 6: displacement control of a cylinder."""

from vvdp.reproduction.chapter_6 import experiment, laws, modes

ITEMS = (*experiment.ITEMS, *laws.ITEMS, *modes.ITEMS)
