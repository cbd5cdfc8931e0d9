"""What vvdp adds to OpenFOAM: the small rail solved by `vvdp.cfd.solve`, and by the bare solver on the same mesh."""

import resource
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from benchmarks.measure import report, run_as_command
from vvdp.cfd.case import Case, Fluid, phase_files, write_files
from vvdp.cfd.engine import MissingProgramError, OpenFoam, find_openfoam
from vvdp.cfd.rail import RailOrder, rail_case, turned_rail
from vvdp.cfd.solve import solve
from vvdp.cfd.verification import Pipe, pipe_case
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system

OIL = Fluid(density=876.0, viscosity=0.0387)
TARGET = 2.0
"""Percent of the solver's time that vvdp may take, in runs over a minute."""
GRID, ITERATIONS = 8.0, 400


class Spent(NamedTuple):
    """Processor time of this process and of the programs that it has started [s]."""

    own: float
    programs: float


def spent() -> Spent:
    """So far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return Spent(time.process_time(), used.ru_utime + used.ru_stime)


def rail() -> Case:
    """The rail of the prototype at 40 lpm, so many iterations however soon it has settled."""
    system = load_system("prototype")
    valve = system.case.params.valve
    order = RailOrder(valve, given_shape(valve, None, [], system.lengths)[0], OIL, 40.0 / 60e3, GRID)
    order = order._replace(phases=tuple(phase._replace(tolerance=0.0) for phase in order.phases))
    case = rail_case(order, turned_rail(order))
    return case._replace(phases=(case.phases[0], case.phases[1]._replace(most=ITERATIONS)))


def pipe() -> Case:
    """A slice of a pipe, solved in a second."""
    case = pipe_case(Pipe(radius=2e-3, length=20e-3, velocity=1.0), OIL, 8)
    return case._replace(phases=(case.phases[0]._replace(most=ITERATIONS, tolerance=0.0),))


def bare(case: Case, made: Path, folder: Path, openfoam: OpenFoam) -> None:
    """The same phases by the solver alone, nothing watched."""
    for name in ("constant", "system", "0"):
        shutil.copytree(made / name, folder / name)
    end = 0
    for phase in case.phases:
        end += phase.most
        write_files(folder, phase_files(case._replace(monitors={}), phase, end))
        with (folder / "log").open("ab") as log:
            subprocess.run(["simpleFoam"], cwd=folder, env=openfoam.environment, stdout=log, check=True)


def main(short: bool) -> None:
    """Processor time of vvdp, of the programs that it starts, and of the bare solver."""
    try:
        openfoam = find_openfoam()
    except MissingProgramError as problem:
        report("vvdp beside OpenFOAM", str(problem))
        return
    case = pipe() if short else rail()
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "made")
        solve(case._replace(phases=(case.phases[0]._replace(most=20),)), made, openfoam, 1, lambda progress: None)
        start = spent()
        solve(case, Path(folder, "vvdp"), openfoam, 1, lambda progress: None, made)
        watched = spent()
        bare(case, made, Path(folder, "bare"), openfoam)
        alone = spent()
    own, programs, solver = (
        watched.own - start.own,
        watched.programs - start.programs,
        alone.programs - watched.programs,
    )
    share = 100.0 * own / solver
    report("vvdp itself over the bare solver", f"{share:.2g} % of {solver:.0f} s", f"{TARGET:g} %", share < TARGET)
    report("programs of the run over the bare solver, with what is watched", f"{programs / solver:.3f}", listed=True)


if __name__ == "__main__":
    run_as_command(main)
