"""Lines between two nodes: fluid inertance of a pipe, with or without its compressibility; frequency-dependent
friction."""

from typing import NamedTuple

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Flow, Power
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.line import (
    Line,
    RoundLine,
    flow_scale,
    line_energy,
    line_flow_rate,
    line_friction_power,
    line_volume,
)
from vvdp.hydraulics.ports import Medium, Wall
from vvdp.hydraulics.unsteady_friction import LayeredState, layered_energy, layered_power, layered_rate
from vvdp.network.component import Component


class LineState(NamedTuple):
    """Flow of a line: the geometric mean of that in tank volumes and the actual one; see `flow_scale`."""

    flow: Flow


class LineEffect(NamedTuple):
    """Flow of a line in tank volumes, its loss, and the rate of its state."""

    flow: Flow
    loss: Power
    rates: LineState


class LayeredEffect(NamedTuple):
    """Flow of a line in tank volumes, its loss, and the rates of its states."""

    flow: Flow
    loss: Power
    rates: LayeredState


class LineWalls(NamedTuple):
    """Half a line's volume for the volume at each of its ends; it does not move."""

    a: Wall
    b: Wall


def line_walls(values: Line) -> LineWalls:
    """The oil of a line, half of it at each end."""
    half = 0.5 * line_volume(values)
    return LineWalls(Wall(half, 0.0), Wall(half, 0.0))


def column_effect(a: FluidState, b: FluidState, state: LineState, medium: Medium, line: RoundLine) -> LineEffect:
    """A column of oil from a to b: its inertia and wall friction, *not* its volume."""
    return LineEffect(
        flow=state.flow / flow_scale(a, b),
        loss=line_friction_power(state.flow, a, b, medium.density, medium.viscosity, line),
        rates=LineState(line_flow_rate(state.flow, a, b, medium.density, medium.viscosity, line)),
    )


def column(a: FluidState, b: FluidState, state: LineState, medium: Medium, values: Line) -> LineEffect:
    """Fluid inertance of a pipe between a and b; its compressibility is not included.

    It belongs to the volumes at the ends, whose values have to include it; `line` includes it itself.
    """
    return column_effect(a, b, state, medium, values)


def column_stored(state: LineState, medium: Medium, values: Line) -> Stored:
    """Kinetic energy of the column."""
    return Stored(line_energy(state.flow, medium.density, values), 0.0)


def line(a: FluidState, b: FluidState, state: LineState, medium: Medium, values: Line) -> LineEffect:
    """A short line from a to b in one piece: its inertia, its wall friction, and half its oil at each end.

    Its wall is rigid and it shows no waves: right for frequencies well below c/(4 l), c the speed of sound.
    """
    return column_effect(a, b, state, medium, values)


def layered_effect(a: FluidState, b: FluidState, state: LayeredState, medium: Medium, line: RoundLine) -> LayeredEffect:
    """As `column_effect`, with wall friction that rises with frequency; see `layered_rate`."""
    return LayeredEffect(
        flow=state.flow / flow_scale(a, b),
        loss=layered_power(state, a, b, medium.density, medium.viscosity, line),
        rates=layered_rate(state, a, b, medium.density, medium.viscosity, line),
    )


def layered_column(a: FluidState, b: FluidState, state: LayeredState, medium: Medium, values: Line) -> LayeredEffect:
    """As `column`, with wall friction that rises with frequency."""
    return layered_effect(a, b, state, medium, values)


def layered_column_stored(state: LayeredState, medium: Medium, values: Line) -> Stored:
    """Kinetic energy of the column and of its layers."""
    return Stored(layered_energy(state, medium.density, values), 0.0)


COLUMN = Component(column, symbol="line", stored=column_stored)
LINE = Component(line, symbol="line", stored=column_stored, walls=line_walls)
LAYERED_COLUMN = Component(layered_column, symbol="line", stored=layered_column_stored, offered=False)
