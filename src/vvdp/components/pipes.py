"""A pipe or hose whose waves count, as one component: a chain of its oil's columns and volumes."""

from collections.abc import Mapping

from vvdp.base.conservation import Stored
from vvdp.components.lines import (
    LayeredEffect,
    LineEffect,
    LineState,
    column_effect,
    layered_effect,
)
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import Passage, passage
from vvdp.hydraulics.line import line_energy
from vvdp.hydraulics.pipe import LinePipe, damping_flow, end_piece, inner_piece
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.unsteady_friction import LayeredState, layered_energy
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Start


def _beside(a: FluidState, b: FluidState, medium: Medium, values: LinePipe) -> Passage:
    """Flow that the damping of a pipe lets pass beside a column."""
    return passage(damping_flow(a, b, medium.density, values), a, b)


def _damped_line(a: FluidState, b: FluidState, column: LineEffect, medium: Medium, values: LinePipe) -> LineEffect:
    """A column of a pipe with its damping."""
    beside = _beside(a, b, medium, values)
    return LineEffect(column.flow + beside.flow, column.loss + beside.loss, column.rates)


def _damped_layers(
    a: FluidState, b: FluidState, column: LayeredEffect, medium: Medium, values: LinePipe
) -> LayeredEffect:
    """As `_damped_line`, with layers."""
    beside = _beside(a, b, medium, values)
    return LayeredEffect(column.flow + beside.flow, column.loss + beside.loss, column.rates)


def pipe_end(a: FluidState, b: FluidState, state: LineState, medium: Medium, values: LinePipe) -> LineEffect:
    """The column between an end of a pipe and its next volume; see `column_effect`."""
    return _damped_line(a, b, column_effect(a, b, state, medium, end_piece(values)), medium, values)


def pipe_end_stored(state: LineState, medium: Medium, values: LinePipe) -> Stored:
    """Kinetic energy of that column."""
    return Stored(line_energy(state.flow, medium.density, end_piece(values)), 0.0)


def pipe_piece(a: FluidState, b: FluidState, state: LineState, medium: Medium, values: LinePipe) -> LineEffect:
    """The column between two volumes of a pipe; see `column_effect`."""
    return _damped_line(a, b, column_effect(a, b, state, medium, inner_piece(values)), medium, values)


def pipe_piece_stored(state: LineState, medium: Medium, values: LinePipe) -> Stored:
    """Kinetic energy of that column."""
    return Stored(line_energy(state.flow, medium.density, inner_piece(values)), 0.0)


def layered_end(a: FluidState, b: FluidState, state: LayeredState, medium: Medium, values: LinePipe) -> LayeredEffect:
    """As `pipe_end`, with wall friction that rises with frequency."""
    return _damped_layers(a, b, layered_effect(a, b, state, medium, end_piece(values)), medium, values)


def layered_end_stored(state: LayeredState, medium: Medium, values: LinePipe) -> Stored:
    """Kinetic energy of that column and of its layers."""
    return Stored(layered_energy(state, medium.density, end_piece(values)), 0.0)


def layered_piece(a: FluidState, b: FluidState, state: LayeredState, medium: Medium, values: LinePipe) -> LayeredEffect:
    """As `pipe_piece`, with wall friction that rises with frequency."""
    return _damped_layers(a, b, layered_effect(a, b, state, medium, inner_piece(values)), medium, values)


def layered_piece_stored(state: LayeredState, medium: Medium, values: LinePipe) -> Stored:
    """Kinetic energy of that column and of its layers."""
    return Stored(layered_energy(state, medium.density, inner_piece(values)), 0.0)


PIPE_END = Component(pipe_end, symbol="line", stored=pipe_end_stored, offered=False)
PIPE_PIECE = Component(pipe_piece, symbol="line", stored=pipe_piece_stored, offered=False)
LAYERED_END = Component(layered_end, symbol="line", stored=layered_end_stored, offered=False)
LAYERED_PIECE = Component(layered_piece, symbol="line", stored=layered_piece_stored, offered=False)


def add_pipe(net: Network, name: str, values: LinePipe, nodes: Mapping[str, str], start: Start) -> None:
    """Add a pipe between the nodes at its ports a and b; the pressure in it is at first `start` [Pa, absolute]."""
    net.add_chain(name, PIPE, values, nodes, (PIPE_END, PIPE_PIECE), start)


def add_layered_pipe(net: Network, name: str, values: LinePipe, nodes: Mapping[str, str], start: Start) -> None:
    """Add a pipe whose wall friction rises with frequency; see `add_pipe`."""
    net.add_chain(name, LAYERED_PIPE, values, nodes, (LAYERED_END, LAYERED_PIECE), start)


PIPE = Assembly("pipe", LinePipe, ("a", "b"), "line", add_pipe)
LAYERED_PIPE = Assembly("layered_pipe", LinePipe, ("a", "b"), "line", add_layered_pipe)
