"""A case carried out in a folder: mesh, check, phases; gone on with where it was left, never repeated once finished.

state.json       the case's identity, which steps are done, and how long each took
log.PROGRAM      what each program said
postProcessing/  what was watched
"""

import fcntl
import json
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import RunError, unusable
from vvdp.base.files import write_whole
from vvdp.cfd.case import Case, phase_files, start_files, write_files
from vvdp.cfd.convergence import History, Judgement, judge, require_sane, until_settled
from vvdp.cfd.engine import OpenFoam
from vvdp.cfd.monitor import MeshCheck, forget_from, patch_faces, read_mesh_check, states, times
from vvdp.cfd.numerics import INTERVAL, STEADY, STOP, Phase, parts_text, solver
from vvdp.cfd.programs import PATIENCE, log_path, run_program
from vvdp.cfd.quality import Quality, read_quality
from vvdp.cfd.snapping import ORDERING

STATE, LOCK = "state.json", "lock"
LOOK = 1.0
"""Seconds between two readings of what a solver has written, at least."""
PAUSE = 100.0
"""Times as long as a reading takes the next one waits: those of a long run are long."""


class Progress(NamedTuple):
    """How far a run is: words of what is at work, iterations done of those at most, how it stands."""

    words: str
    done: int
    most: int
    judgement: Judgement | None


class Solved(NamedTuple):
    """A run that has ended. `settled` is whether its last phase has, and not only used up its iterations."""

    history: History
    judgement: Judgement
    mesh: MeshCheck
    quality: Quality
    settled: bool
    since: int
    seconds: dict[str, float]

    @property
    def took(self) -> float:
        """Time that all its programs have taken [s]."""
        return sum(self.seconds.values())


Hear = Callable[[Progress], None]


def solve(case: Case, folder: Path, openfoam: OpenFoam, cores: int, hear: Hear, mesh_of: Path | None = None) -> Solved:
    """Computes a case in `folder`, from where an earlier call was interrupted; `hear` is given how far it is.

    The mesh is copied from the folder `mesh_of` of another case with the same one, and made where there is none.

    At Ctrl-C the solver writes what it has reached, and KeyboardInterrupt goes on. Raises ConfigError where the folder
    belongs to another case or is at work; RunError where mesh or run fail: then all files are kept.
    """
    with _at_work(folder):
        state = _State(folder, case)
        _make_mesh(case, folder, openfoam, (state, hear), mesh_of)
        check = _check_mesh(case, folder, openfoam, state)
        for phase in case.phases:
            _Solver(case, folder, openfoam, cores, (state, hear)).run(phase)
        last = case.phases[-1]
        since = state.begun[last.name]
        history = until_settled(_history(case, folder), since, last.window, last.tolerance)
        judgement = judge(history, since, last.window)
        assert judgement is not None
        return Solved(
            history=history,
            judgement=judgement,
            mesh=check,
            quality=read_quality(folder, judgement.iteration * case.step, last.window),
            settled=judgement.has_settled(last.tolerance),
            since=since,
            seconds=state.seconds,
        )


def _history(case: Case, folder: Path) -> History:
    """The watched quantities, over the iterations or steps."""
    found = case.read_history(folder)
    return found._replace(iterations=np.round(found.iterations / case.step))


class _State:
    """Progress of a case, kept in its folder."""

    def __init__(self, folder: Path, case: Case) -> None:
        self.path = folder / STATE
        kept: dict[str, Any] = json.loads(self.path.read_text("utf-8")) if self.path.is_file() else {}
        if kept and kept["identity"] != case.identity:
            raise unusable(folder, "holds another case; choose another directory or use --force")
        self.identity = case.identity
        self.done: list[str] = kept.get("done", [])
        self.begun: dict[str, int] = kept.get("begun", {})
        self.seconds: dict[str, float] = kept.get("seconds", {})
        self.cores: list[int] = kept.get("cores", [])

    def write(self) -> None:
        """Keeps the state."""
        kept = {
            "identity": self.identity,
            "done": self.done,
            "begun": self.begun,
            "seconds": self.seconds,
            "cores": self.cores,
        }
        write_whole(self.path, json.dumps(kept, indent=1) + "\n")

    def spend(self, step: str, seconds: float) -> None:
        """Counts time that a step has taken."""
        self.seconds[step] = self.seconds.get(step, 0.0) + seconds

    def finish(self, step: str) -> None:
        """Notes that a step is done."""
        self.done.append(step)
        self.write()


def used_cores(directory: Path) -> tuple[int, ...]:
    """On how many cores solvers have worked in the folders of a directory: each number that there was."""
    states = [json.loads(path.read_text("utf-8")) for path in directory.glob(f"*/{STATE}")]
    return tuple(sorted({cores for state in states for cores in state.get("cores", ())}))


def _make_mesh(case: Case, folder: Path, openfoam: OpenFoam, told: tuple["_State", Hear], mesh_of: Path | None) -> None:
    """Makes or copies the mesh unless all of it is there. Raises RunError where a patch has vanished."""
    state, hear = told
    if "mesh" in state.done:
        return
    for leftover in ("constant", "system", "0"):
        shutil.rmtree(folder / leftover, ignore_errors=True)
    state.write()
    write_files(folder, {**start_files(case), **phase_files(case, case.phases[0], 0)})
    if mesh_of:
        shutil.copytree(mesh_of / "constant" / "polyMesh", folder / "constant" / "polyMesh")
        if case.step != STEADY:
            words = ("mapFields", str(mesh_of.resolve()), "-consistent", "-sourceTime", "latestTime")
            state.spend(words[0], run_program(words, folder, openfoam))
    else:
        write_files(folder, case.mesh_files)
        for program in case.mesh_programs:
            if program == ORDERING:  # it stumbles over a patch that has no conditions
                _require_patches(case, folder)
            hear(Progress(program[0], 0, _most(case), None))
            state.spend(program[0], run_program(program, folder, openfoam))
    _require_patches(case, folder)
    state.finish("mesh")


def _require_patches(case: Case, folder: Path) -> None:
    """Raises RunError where a patch has vanished from the mesh, or there is one that the surface does not have."""
    faces = patch_faces(folder)
    if missing := sorted(name for name in case.patches if not faces.get(name)):
        raise RunError(
            f"the patch {' and '.join(missing)} has vanished from the mesh: it is hidden by other parts of the "
            f"surface, or too small for the cells; see {folder}"
        )
    if foreign := sorted(name for name, count in faces.items() if count and name not in case.patches):
        raise RunError(f"the mesh has a patch {foreign[0]} that is none of the surface: it is not closed; see {folder}")


def _check_mesh(case: Case, folder: Path, openfoam: OpenFoam, state: _State) -> MeshCheck:
    """The verdict of checkMesh. Raises RunError where it finds a fault."""
    if "check" not in state.done:
        log_path(folder, "checkMesh").unlink(missing_ok=True)
        state.spend("checkMesh", run_program(("checkMesh",), folder, openfoam))
    found = read_mesh_check(log_path(folder, "checkMesh").read_text("utf-8", "replace"))
    if found.faults:
        raise RunError(f"the mesh is not sound: {'; '.join(found.faults)}; see {log_path(folder, 'checkMesh')}")
    if "check" not in state.done:
        state.finish("check")
    return found


def _most(case: Case) -> int:
    return sum(phase.most for phase in case.phases)


class _Solver:
    """The solver at work on one phase after the other."""

    def __init__(self, case: Case, folder: Path, openfoam: OpenFoam, cores: int, told: tuple[_State, Hear]) -> None:
        self.case, self.folder, self.openfoam, self.cores = case, folder, openfoam, cores
        self.state, self.hear = told
        self.next_look = 0.0

    def run(self, phase: Phase) -> None:
        """Runs a phase from the last state until it has settled, or its iterations are used up."""
        if phase.name in self.state.done:
            return
        reached = self.last_state()
        if self.state.begun.setdefault(phase.name, reached) == reached:
            self.state.write()
        # A state is written at multiples of the interval, and the end has to be one.
        end = -(-(self.state.begun[phase.name] + phase.most) // INTERVAL) * INTERVAL
        if reached < end:
            forget_from(self.folder, reached * self.case.step)
            (self.folder / STOP).unlink(missing_ok=True)
            write_files(self.folder, phase_files(self.case, phase, end))
            began = time.monotonic()
            self.work(phase)
            self.state.spend(phase.name, time.monotonic() - began)
            self.look(phase)
        self.state.finish(phase.name)

    def work(self, phase: Phase) -> None:
        """Lets the solver work, on all its cores."""
        self.state.cores = sorted({*self.state.cores, self.cores})
        if self.cores > 1:
            write_files(self.folder, {"system/decomposeParDict": parts_text(self.cores)})
            run_program(("decomposePar", "-force", "-latestTime"), self.folder, self.openfoam)
        run_program((solver(self.case.step),), self.folder, self.openfoam, self.cores, lambda: self.watch(phase), STOP)
        self.gather()

    def watch(self, phase: Phase) -> None:
        """Looks at the run now and then."""
        began = time.monotonic()
        if began > self.next_look:
            self.look(phase)
            ended = time.monotonic()
            self.next_look = ended + max(LOOK, PAUSE * (ended - began))

    def look(self, phase: Phase) -> None:
        """Shows how the run stands, and stops it where it has settled. Raises RunError where it diverges."""
        since = self.state.begun[phase.name]
        history = _history(self.case, self.folder)
        require_sane(history, self.case.largest, log_path(self.folder, solver(self.case.step)))
        history = until_settled(history, since, phase.window, phase.tolerance)
        found = judge(history, since, phase.window)
        if found is None:
            return
        if found.has_settled(phase.tolerance):
            (self.folder / STOP).touch()
        before = sum(each.most for each in self.case.phases[: self.case.phases.index(phase)])
        self.hear(Progress(phase.name, before + found.iteration - since, _most(self.case), found))

    def last_state(self) -> int:
        """The iteration of the last whole state. Earlier ones go, and what a killed solver has left unfinished."""
        self.gather()
        whole = states(self.folder)[-1]
        for reached, path in times(self.folder).items():
            if reached != 0.0 and path != whole:
                shutil.rmtree(path)
        return round(float(whole.name) / self.case.step)

    def gather(self) -> None:
        """Puts the parts of the last state together that several cores have written, and removes them."""
        parts = sorted(self.folder.glob("processor*"))
        if parts and any(times(parts[0])):
            run_program(("reconstructPar", "-latestTime"), self.folder, self.openfoam)
        for part in parts:
            shutil.rmtree(part)


@contextmanager
def _at_work(folder: Path) -> Iterator[None]:
    """Holds a folder for this process and the programs that it starts.

    A solver that has lost its vvdp still holds it: it is asked to write and end. Raises ConfigError where another vvdp
    is at work.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("a+") as file:
        os.set_inheritable(file.fileno(), True)
        deadline = time.monotonic() + PATIENCE
        while not _is_free(file.fileno()):
            file.seek(0)
            owner = file.read().strip()
            if owner.isdigit() and _is_alive(int(owner)):
                raise unusable(folder, f"is at work in process {owner}")
            if time.monotonic() > deadline:
                raise unusable(folder, "holds a solver that does not end; end it and try again")
            (folder / STOP).touch()
            time.sleep(LOOK)
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield


def _is_free(opened: int) -> bool:
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
