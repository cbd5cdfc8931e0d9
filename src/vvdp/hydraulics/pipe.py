"""A long line in pieces, for its waves, and the stretch of its wall."""

from typing import NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import BulkModulus, Compliance, Count, Length, Ratio
from vvdp.base.params import Params
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.line import Line, line_volume
from vvdp.hydraulics.volume import Vessel


class LinePipe(Params):
    """A line whose waves count: it is divided into `pieces`, each a volume between two halves of a column.

    `hose_compliance` is the relative growth of its volume over pressure; 0 is rigid, `wall_compliance` gives that of a
    tube. `wall_friction` multiplies the friction of a smooth wall; 0 has none.
    """

    length: Length
    diameter: Length
    hose_compliance: Compliance
    wall_friction: Ratio = 1.0
    pieces: Count = 5.0

    def check(self) -> None:
        if self.length <= 0.0 or self.diameter <= 0.0:
            raise ParameterError(
                f"LinePipe: length {self.length:g} m, diameter {self.diameter:g} m; expected both above 0"
            )
        if self.pieces < 1.0 or self.pieces % 1.0:
            raise ParameterError(f"LinePipe.pieces: {self.pieces:g}; expected a whole number from 1 on")


class TubeWall(Params):
    """Wall of a round tube."""

    diameter: Length
    wall_thickness: Length
    youngs_modulus: BulkModulus

    def check(self) -> None:
        if self.wall_thickness <= 0.0 or self.diameter <= 0.0:
            raise ParameterError(
                f"TubeWall: diameter {self.diameter:g} m, wall {self.wall_thickness:g} m; expected both above 0"
            )


class PipeParts(NamedTuple):
    """A pipe divided: end, vessel, inner, vessel, inner ... vessel, end, from port to port."""

    end: Line
    inner: Line
    vessel: Vessel


def wall_compliance(wall: TubeWall) -> float:
    """Relative growth of a thin tube's volume over pressure [1/Pa]: d/(E t), of its circumference alone.

    Source  merritt1967, ch. 2
    """
    return wall.diameter / (wall.youngs_modulus * wall.wall_thickness)


def pipe_parts(pipe: LinePipe) -> PipeParts:
    """The columns and the volume of which a pipe of n pieces consists: l/(2n) at both ends, l/n between two volumes.

    Source  ours, docs/models/components.md
    """
    step = pipe.length / pipe.pieces
    inner = Line(length=step, diameter=pipe.diameter, wall_friction=pipe.wall_friction)
    end = Line(length=0.5 * step, diameter=pipe.diameter, wall_friction=pipe.wall_friction)
    vessel = Vessel(
        oil_volume=line_volume(inner),
        hose_compliance=pipe.hose_compliance,
        gas_volume=0.0,
        precharge_pressure=0.0,
        gas_exponent=1.4,
    )
    return PipeParts(end, inner, vessel)


def sound_speed(density: float, fluid: FluidState, hose_compliance: float) -> float:
    """Speed of waves in a line [m/s]: sqrt(nu/(rho (1/beta + 1/B))).

    density          of the oil at the tank [kg/m^3]
    fluid            oil in the line
    hose_compliance  1/B, relative growth of the line's volume over pressure [1/Pa]

    Source  merritt1967, ch. 2, with the wall
    """
    speed: float = np.sqrt(fluid.volume_ratio / (density * (1.0 / fluid.bulk_modulus + hose_compliance)))
    return speed
