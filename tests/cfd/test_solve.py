"""A run in its folder: gone on with, never repeated, refused, and what is told of faults."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import psutil
import pytest
from tests.cfd.conftest import OIL, PIPE
from tests.words import wording

from vvdp.base.errors import ConfigError, RunError
from vvdp.cfd.monitor import states
from vvdp.cfd.rail import RailOrder, rail_case, turned_rail
from vvdp.cfd.solve import solve
from vvdp.cfd.verification import pipe_case
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system


def silent(progress):
    pass


def solver_starts(folder):
    return (folder / "log.simpleFoam").read_text().count("Create time")


@pytest.fixture
def patient(pipe):
    """The pipe, with iterations enough to be interrupted."""
    return pipe._replace(phases=(pipe.phases[0]._replace(most=4000, tolerance=0.0),))


def at_once(monkeypatch):
    """Looks at the solver all the time."""
    monkeypatch.setattr("vvdp.cfd.solve.LOOK", 0.0)
    monkeypatch.setattr("vvdp.cfd.solve.PAUSE", 0.0)
    monkeypatch.setattr("vvdp.cfd.programs.GLANCE", 0.01)


def test_what_is_finished_is_not_repeated(pipe, openfoam, tmp_path):
    first = solve(pipe, tmp_path, openfoam, 1, silent)
    logs = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("log.*")}
    again = solve(pipe, tmp_path, openfoam, 1, silent)
    assert again.judgement == first.judgement
    assert again.seconds == first.seconds
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("log.*")} == logs


def test_readings_that_take_long_are_rare(patient, openfoam, tmp_path, monkeypatch):
    """One that takes 20 ms, and the next after a minute or more: beside it only the one at the end."""
    at_once(monkeypatch)
    monkeypatch.setattr("vvdp.cfd.solve.PAUSE", 3000.0)
    heard = []

    def slow(progress):
        heard.append(progress)
        if progress.judgement:
            time.sleep(0.02)

    solve(patient._replace(phases=(patient.phases[0]._replace(most=400),)), tmp_path, openfoam, 1, slow)
    assert 1 <= len([each for each in heard if each.judgement]) <= 2


def test_the_disk_holds_the_start_and_a_few_states(pipe, openfoam, tmp_path):
    solve(pipe, tmp_path, openfoam, 1, silent)
    assert len(states(tmp_path)) <= 4


def test_an_interrupted_run_goes_on_to_the_same_end(pipe, openfoam, tmp_path, monkeypatch):
    whole = solve(pipe, tmp_path / "whole", openfoam, 1, silent)
    at_once(monkeypatch)

    def interrupt(progress):
        if progress.judgement and progress.judgement.iteration > 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(pipe, tmp_path / "parts", openfoam, 1, interrupt)
    reached = int(states(tmp_path / "parts")[-1].name)
    assert reached > 0
    found = solve(pipe, tmp_path / "parts", openfoam, 1, silent)
    assert found.judgement.value == pytest.approx(whole.judgement.value, rel=1e-6)
    assert solver_starts(tmp_path / "parts") == 2
    assert (tmp_path / "parts" / "postProcessing" / "forces" / str(reached)).is_dir()
    assert found.history.iterations.tolist() == list(range(1, len(found.history.iterations) + 1))


@pytest.mark.thorough
def test_a_killed_solver_is_told_and_its_run_goes_on(patient, openfoam, tmp_path, monkeypatch):
    at_once(monkeypatch)

    def kill(progress):
        if progress.judgement and progress.judgement.iteration > 60:
            (solver,) = [each for each in psutil.Process().children() if each.name() == "simpleFoam"]
            solver.send_signal(signal.SIGKILL)

    with pytest.raises(RunError, match=re.escape(wording.cfd.was_killed.format(program="simpleFoam"))):
        solve(patient, tmp_path, openfoam, 1, kill)
    reached = int(states(tmp_path)[-1].name)
    assert reached >= 20

    seen = []

    def stop(progress):
        if progress.judgement:
            seen.append(progress.judgement.iteration)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(patient, tmp_path, openfoam, 1, stop)
    assert seen[0] >= reached - 1  # a state may be written before the line of its table


def test_another_case_is_not_mixed_in(pipe, openfoam, tmp_path):
    solve(pipe, tmp_path, openfoam, 1, silent)
    thicker = pipe._replace(fluid=pipe.fluid._replace(viscosity=0.05))
    with pytest.raises(ConfigError, match=wording.cfd.holds_another_case):
        solve(thicker, tmp_path, openfoam, 1, silent)


def test_two_do_not_work_on_one_folder(pipe, openfoam, tmp_path):
    def second(progress):
        with pytest.raises(ConfigError, match=wording.cfd.at_work.format(process=os.getpid())):
            solve(pipe, tmp_path, openfoam, 1, silent)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(pipe, tmp_path, openfoam, 1, second)


def test_a_patch_that_vanished_is_named(pipe, openfoam, tmp_path):
    patches = {**pipe.patches, "nozzle": pipe.patches["wall"]}
    with pytest.raises(RunError, match=wording.cfd.patch_vanished.format(patch="nozzle")):
        solve(pipe._replace(patches=patches), tmp_path, openfoam, 1, silent)
    assert (tmp_path / "constant" / "polyMesh").is_dir()


def test_a_patch_of_no_surface_is_named(pipe, openfoam, tmp_path):
    patches = {name: patch for name, patch in pipe.patches.items() if name != "outlet"}
    with pytest.raises(RunError, match=wording.cfd.patch_of_none.format(patch="outlet")):
        solve(pipe._replace(patches=patches), tmp_path, openfoam, 1, silent)


def test_a_diverging_run_is_stopped_and_kept(pipe, openfoam, tmp_path):
    wild = pipe._replace(phases=(pipe.phases[0]._replace(relaxation=(1.0, 1.99, 1.0), most=400),), largest=1.0)
    with pytest.raises(RunError, match="diverged"):
        solve(wild, tmp_path, openfoam, 1, silent)
    assert json.loads((tmp_path / "state.json").read_text())["done"] == ["mesh", "check"]
    assert (tmp_path / "log.simpleFoam").is_file()


def test_a_mesh_is_copied_from_a_case_that_has_it(pipe, openfoam, tmp_path):
    first = solve(pipe, tmp_path / "first", openfoam, 1, silent)
    slower = pipe._replace(fluid=pipe.fluid._replace(viscosity=0.0774))
    found = solve(slower, tmp_path / "second", openfoam, 1, silent, tmp_path / "first")
    assert found.mesh == first.mesh
    assert "blockMesh" not in found.seconds
    assert found.judgement.value == pytest.approx(2.0 * first.judgement.value, rel=1e-3)


@pytest.mark.thorough
def test_two_cores_give_the_same(pipe, openfoam, tmp_path):
    one, two = (solve(pipe, tmp_path / str(cores), openfoam, cores, silent) for cores in (1, 2))
    assert two.judgement.value == pytest.approx(one.judgement.value, rel=1e-6)
    assert not list((tmp_path / "2").glob("processor*"))


ORPHAN = """
import sys
import time
from pathlib import Path
from tests.cfd.conftest import OIL, PIPE
from vvdp.cfd.engine import find_openfoam
from vvdp.cfd.solve import solve
from vvdp.cfd.verification import pipe_case
from vvdp.cfd.verification import pipe_case

case = pipe_case(PIPE, OIL, 40)
case = case._replace(phases=(case.phases[0]._replace(most=100000, tolerance=0.0),))
solve(case, Path(sys.argv[1]), find_openfoam(), 1, lambda progress: print(progress.done, flush=True))
"""


def test_a_solver_that_lost_its_vvdp_is_asked_to_end(openfoam, tmp_path, monkeypatch):
    """As after kill -9: the solver works on alone, until the next call finds it."""
    monkeypatch.setattr("vvdp.cfd.solve.LOOK", 0.1)
    words = [sys.executable, "-c", ORPHAN, str(tmp_path)]
    with subprocess.Popen(words, cwd=Path(__file__).parents[2], stdout=subprocess.PIPE, text=True) as first:
        for line in first.stdout:
            if int(line) > 0:
                break
        (solver,) = psutil.Process(first.pid).children()
        first.kill()
    assert solver.is_running()
    case = pipe_case(PIPE, OIL, 40)
    case = case._replace(phases=(case.phases[0]._replace(most=100000, tolerance=0.0),))
    seen = []

    def stop(progress):
        seen.append(progress)
        if progress.judgement:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(case, tmp_path, openfoam, 1, stop)
    assert not solver.is_running() or solver.status() == psutil.STATUS_ZOMBIE
    assert seen[-1].done > 0
    assert solver_starts(tmp_path) == 2


@pytest.mark.slow
def test_a_surface_with_a_hole_is_named(openfoam, tmp_path):
    """The crown of the rail is missing: the mesh leaks out to the background."""
    valve = load_system("prototype").case.params.valve
    order = RailOrder(valve, given_shape(valve, None, [])[0], OIL, 40.0 / 60e3, 4.0)
    domain = turned_rail(order)
    mesh = domain.mesh
    corners = mesh.vertices[mesh.triangles]
    walls = mesh.patch == mesh.names.index("rail")
    kept = ~(walls & (corners[:, :, 2].mean(1) > 0.8 * corners[walls][:, :, 2].max()))
    assert not kept.all()
    holed = replace(mesh, triangles=mesh.triangles[kept], patch=mesh.patch[kept])
    with pytest.raises(RunError, match=wording.cfd.not_closed.format(patch="background")):
        solve(rail_case(order, replace(domain, mesh=holed)), tmp_path, openfoam, 1, silent)
    assert (tmp_path / "log.snappyHexMesh").is_file()
