"""An exported program in a process of its own, in the loop with its system."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.export.test_fmu import pytestmark
from tests.generator.c_way import compilers

from vvdp.base.errors import ConfigError, RunError
from vvdp.export.c_folder import exported_folder
from vvdp.export.closed_loop import loop_difference
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

__all__ = ["pytestmark"]


@pytest.fixture
def build(tmp_path):
    """A function that exports a program, with a change of its C where one is given, and compiles its process."""

    def make(name, part, old="", new=""):
        made = exported_folder(load_system(name), part, 3)
        for file, text in made.files.items():
            (tmp_path / file).write_text(text.replace(old, new) if old else text, "utf-8")
        goal = f"loop_{made.name}"
        done = subprocess.run(
            ["make", "-s", "-C", str(tmp_path), goal, f"CC={compilers()[0]}"],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        assert not done.stderr
        return tmp_path / goal

    return make


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("prototype", "estimate"),
        ("linear-valves", "loop"),
        ("displacement-chapter6", "control"),
        pytest.param("axial-chamber", "drive_law", marks=pytest.mark.thorough),
        pytest.param("vvdp-duty-control", "axial_observer", marks=pytest.mark.thorough),
    ],
)
def test_no_number_of_the_closed_loop_differs(name, part, build, capfd):
    """A fifth of a second at 1 ms; the process names the sample that took longest."""
    found = loop_difference(load_system(name), part, [str(build(name, part))], 200)
    assert found.differing == 0
    assert found.numbers > 200 * 10
    assert found.samples >= 200
    words = r"(\d+) samples\ntime of a step: minimum (\S+) us, mean (\S+) us, maximum (\S+) us \(sample (\d+)\)"
    said = re.search(words, capfd.readouterr().err)
    assert int(said[1]) == found.samples > int(said[5])
    assert 0.0 <= float(said[2]) <= float(said[3]) <= float(said[4])


def test_a_process_that_calculates_otherwise_is_found(build):
    """The command of the loop is doubled before it is sent."""
    change = ("fwrite(&command", "*(double *)&command *= 2.0; fwrite(&command")
    process = build("linear-valves", "loop", *change)
    assert loop_difference(load_system("linear-valves"), "loop", [str(process)], 100).differing > 100


def test_a_process_that_ends_or_does_not_begin_is_reported():
    system = load_system("linear-valves")
    with pytest.raises(ConfigError, match="cannot be started"):
        loop_difference(system, "loop", ["./no-such-process"], 10)
    with pytest.raises(ConfigError, match="unknown"):
        loop_difference(system, "lop", [sys.executable], 10)
    with pytest.raises(RunError, match="the process ended at t = 0 s"):
        loop_difference(system, "loop", [sys.executable, "-c", "pass"], 10)


def test_the_page_states_counts_and_what_a_float_resolves():
    """The encoder over a second; between 2048 and 4096 s neighbouring floats are 2^-12 s apart."""
    page = (Path(__file__).parents[2] / "docs" / "c-export.md").read_text("utf-8")
    system = load_system("prototype")
    stepping = replace(system.stepping, until=1.0, record_interval=1e-3, window=0.0, average_from=None)
    run = simulate(system.model, system.case, stepping)
    marks = run.mark_times.size + run.mark_states.size
    numbers = run.times.size + run.states.size + run.commands.size + run.memories.size + marks
    assert f"1001 samples by the process: 0 of {numbers} numbers differ from vvdp run" in page
    resolution = f"{np.spacing(np.float32(3600.0)):.1e}".replace("e-0", "e-")
    assert f"resolves the time since the beginning to {resolution} s after an hour" in " ".join(page.split())


def test_the_command_prints_one_sentence(build):
    process = build("linear-valves", "loop")
    words = [sys.executable, "-m", "vvdp.export.closed_loop", "--samples", "20", "linear-valves"]
    done = subprocess.run([*words, "loop", str(process)], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert re.fullmatch(r"\d+ samples by the process: 0 of \d+ numbers differ from vvdp run\n", done.stdout)
    done = subprocess.run([*words, "lop", str(process)], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "did you mean 'loop'" in done.stderr
    assert "Traceback" not in done.stderr
