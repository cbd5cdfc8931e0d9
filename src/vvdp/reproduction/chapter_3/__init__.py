"""Chapter 3: angle and speed of the spool from a coarse encoder."""

from vvdp.reproduction.chapter_3 import estimates, experiment, filter_equations, optics

ITEMS = (*optics.ITEMS, *filter_equations.ITEMS, *estimates.ITEMS, *experiment.ITEMS)
