"""What the tests of computed flows share: the OpenFOAM of this machine, and cases of a second."""

import io
from contextlib import redirect_stderr, redirect_stdout
from typing import NamedTuple

import pytest
from tests.slurm import own_slurm  # noqa: F401

from vvdp.cfd.case import Fluid
from vvdp.cfd.engine import MissingProgramError, OpenFoam, find_openfoam
from vvdp.cfd.quality import Quality, WallDistance
from vvdp.cfd.verification import Cylinders, Pipe, pipe_case
from vvdp.cli.main import main

OIL = Fluid(density=876.0, viscosity=0.0387)
PAIR = Cylinders(inner=10e-3, outer=20e-3, length=1e-3, speed=0.05)
QUALITY = Quality((WallDistance("rail", 30, 0.5, 4.0, 14.0),), {"U": 2e-3, "p": 5e-3})
"""Of a run that has never been: y+ at one patch of 30 faces, a residual twice its criterion and one half of it."""
PIPE = Pipe(radius=2e-3, length=20e-3, velocity=1.0)


class Said(NamedTuple):
    code: int
    out: str
    err: str


def say(*words: str, verb: str = "rail") -> Said:
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as ended:
        main(["cfd", verb, *words])
    return Said(ended.value.code or 0, out.getvalue(), err.getvalue())


@pytest.fixture(scope="session")
def openfoam(not_tested) -> OpenFoam:
    """OpenFOAM; where it is missing, the test is skipped, or fails if `VVDP_REQUIRE` names openfoam."""
    try:
        return find_openfoam()
    except MissingProgramError as problem:
        not_tested(str(problem), "openfoam")


@pytest.fixture
def pipe():
    """A laminar flow in a pipe that is solved within a second."""
    return pipe_case(PIPE, OIL, 8)
