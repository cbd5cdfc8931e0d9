"""Chapter 2: pressure drop, torque and speed of the rotary valve, and its inlet rail."""

from vvdp.reproduction.chapter_2 import drops, flow_equations, grids, optimum, rail, shapes, torque

ITEMS = (
    *shapes.ITEMS,
    *grids.ITEMS,
    *flow_equations.ITEMS,
    *drops.ITEMS,
    *torque.ITEMS,
    *optimum.ITEMS,
    *rail.ITEMS,
)
