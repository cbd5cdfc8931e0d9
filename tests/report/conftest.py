import shutil
from dataclasses import replace

import pytest

from vvdp.base.files import result_directory
from vvdp.runs.simulate import recorded_run, save_run
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

SHORT = ['run.window="0.1 s"']
STANDING = [
    'spool_drive.coupling="50 N*m*s"',
    'initial.spool_speed="0 rpm"',
    'initial.spool_angle="20 deg"',
]


def made(directory, name, settings=(), until="0.2 s", progress=None):
    system = load_system(name, [*SHORT, *settings], until)
    portion = 2e6 if progress is None else 2e3
    done = simulate(system.model, system.case, system.stepping, progress=progress, portion=portion)
    run = recorded_run(system, done, ["vvdp", "run", name])
    with result_directory(directory) as folder:
        save_run(folder, replace(run, meta=run.meta | {"written": "2026-01-02T03:04:05+0000"}))
    return directory


@pytest.fixture(scope="session")
def whole(tmp_path_factory):
    """A result directory of the prototype with an orifice as load; not to be written to."""
    return made(tmp_path_factory.mktemp("whole") / "run", "prototype")


@pytest.fixture
def orifice(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "run")


@pytest.fixture
def constant(tmp_path):
    return made(tmp_path / "run", "prototype-constant-load")


@pytest.fixture
def standing(tmp_path):
    return made(tmp_path / "run", "prototype-constant-load", STANDING, "0.1 s")


@pytest.fixture
def interrupted(tmp_path):
    def stop(reached):
        if reached > 0.02:
            raise KeyboardInterrupt

    return made(tmp_path / "run", "prototype", until="2 s", progress=stop)
