"""A long line in pieces, for its waves, and the compliance of its wall.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.conservation import Stored
from vvdp.base.kinds import BulkModulus, Compliance, Count, Fraction, Length, Ratio
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.line import line_volume
from vvdp.hydraulics.volume import closed_volume_contents


class LinePipe(Params):
    """A line whose waves count: it is divided into `pieces`, each a volume between two halves of a column.

    `hose_compliance` is the relative growth of its volume over pressure; 0 is rigid, `wall_compliance` gives that of a
    tube. `wall_friction` multiplies the friction of a smooth wall; 0 has none. `damping` takes swings from piece to
    piece: 0.3 leaves a sudden change no overshoot, and its effect on long waves vanishes with their number.
    """

    length: Length
    diameter: Length
    hose_compliance: Compliance
    wall_friction: Ratio = 1.0
    pieces: Count = 5.0
    damping: Fraction = 0.0

    def check(self) -> None:
        require_positive(self, "length", "diameter")
        if self.pieces < 1.0 or self.pieces % 1.0:
            refuse(self, "pieces", "must be a whole number of at least 1")


class TubeWall(Params):
    """Wall of a round tube."""

    diameter: Length
    wall_thickness: Length
    youngs_modulus: BulkModulus

    def check(self) -> None:
        require_positive(self, "wall_thickness", "diameter")


class PipePiece(NamedTuple):
    """A column of a pipe's oil between two of its volumes, or between one and an end."""

    length: Length
    diameter: Length
    wall_friction: Ratio


def wall_compliance(wall: TubeWall) -> float:
    """Relative growth of a thin tube's volume over pressure [1/Pa]: d/(E t), of its circumference alone.

    Source  merritt1967, ch. 2
    """
    return wall.diameter / (wall.youngs_modulus * wall.wall_thickness)


def inner_piece(pipe: LinePipe) -> PipePiece:
    """The column between two volumes of a pipe of n pieces: l/n long."""
    return PipePiece(pipe.length / pipe.pieces, pipe.diameter, pipe.wall_friction)


def end_piece(pipe: LinePipe) -> PipePiece:
    """The column between an end of a pipe and its next volume: l/(2n) long."""
    return PipePiece(0.5 * pipe.length / pipe.pieces, pipe.diameter, pipe.wall_friction)


def piece_volume(pressure: float, pipe: LinePipe, reference_pressure: float) -> float:
    """Volume of oil in one of a pipe's volumes [m^3]: V (1 + (P - ref)/B).

    pressure            absolute [Pa]
    reference_pressure  at which the hose is unstretched, absolute [Pa]
    """
    return line_volume(inner_piece(pipe)) * (1.0 + pipe.hose_compliance * (pressure - reference_pressure))


def piece_rate(net_flow: float, fluid: FluidState, pipe: LinePipe, reference_pressure: float) -> float:
    """Rate of the pressure in one of a pipe's volumes [Pa/s]: P' = nu sum(q) / (V (1 + (P - ref)/B)/beta + V/B).

    As `pressure_rate` of a vessel without gas.

    net_flow            sum of the flows in [tank volumes, m^3/s]
    fluid               oil in the volume
    reference_pressure  at which the hose is unstretched, absolute [Pa]
    """
    oil = piece_volume(fluid.pressure, pipe, reference_pressure)
    wall = line_volume(inner_piece(pipe)) * pipe.hose_compliance
    return fluid.volume_ratio * net_flow / (oil / fluid.bulk_modulus + wall)


def piece_stored(fluid: FluidState, oil: Oil, pipe: LinePipe) -> Stored:
    """Energy [J] and tank volumes [m^3] in one of a pipe's volumes, its stretched wall's included.

    fluid  oil in the volume
    """
    inside = closed_volume_contents(fluid, piece_volume(fluid.pressure, pipe, oil.reference_pressure), oil)
    wall = line_volume(inner_piece(pipe)) * pipe.hose_compliance
    return Stored(inside.energy + 0.5 * wall * (fluid.pressure - oil.reference_pressure) ** 2, inside.volume)


def sound_speed(density: float, fluid: FluidState, hose_compliance: float) -> float:
    """Speed of waves in a line [m/s]: sqrt(nu/(rho (1/beta + 1/B))).

    density          of the oil at the tank [kg/m^3]
    fluid            oil in the line
    hose_compliance  1/B, relative growth of the line's volume over pressure [1/Pa]

    Source  merritt1967, ch. 2, with the wall
    Holds   for waves that are long against the diameter, without friction

    >>> print(round(sound_speed(870.0, FluidState(1e5, 1.0, 1.5e9, 0.0), 0.0)))
    1313
    """
    speed: float = np.sqrt(fluid.volume_ratio / (density * (1.0 / fluid.bulk_modulus + hose_compliance)))
    return speed


def damping_flow(a: FluidState, b: FluidState, density: float, pipe: LinePipe) -> float:
    """Flow that passes beside the column between two pieces of a pipe [m^3/s], signed like their drop: d (P_a - P_b)/Z.

    Z = rho c/A, impedance of the line, c the mean of both sides.

    a, b     oil on either side
    density  of the oil at the tank [kg/m^3]
    """
    c = 0.5 * (sound_speed(density, a, pipe.hose_compliance) + sound_speed(density, b, pipe.hose_compliance))
    return pipe.damping * 0.25 * np.pi * pipe.diameter**2 / (density * c) * (a.pressure - b.pressure)


def damping_flow_compiled(a: FluidState, b: FluidState, density: float, pipe: LinePipe) -> float:
    """The same as `damping_flow`, which it replaces in compiled code: none is calculated where there is none.

    Arguments as there.
    """
    if pipe.damping == 0.0:
        return 0.0
    c = 0.5 * (sound_speed(density, a, pipe.hose_compliance) + sound_speed(density, b, pipe.hose_compliance))
    return pipe.damping * 0.25 * np.pi * pipe.diameter**2 / (density * c) * (a.pressure - b.pressure)
