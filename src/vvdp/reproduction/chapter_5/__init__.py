"""Chapter 5: passivity-based control of the axial position."""

from vvdp.reproduction.chapter_5 import compressed_oil, experiment, laws

ITEMS = (*compressed_oil.ITEMS, *laws.ITEMS, *experiment.ITEMS)
