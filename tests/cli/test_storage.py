"""What stays on a disk that is full or read-only, and of a verb that is ended: all that is finished, nothing else."""

import fcntl
import json
import os
import pty
import re
import resource
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.words import wording

import vvdp as package
from vvdp.base.files import UNFINISHED

pytestmark = pytest.mark.thorough

SOURCE = str(Path(package.__file__).parents[1])
STUDY = """
title = "Two cases"
system = "prototype-constant-load"
until = "0.05 s"
outputs = ["pwm_frequency_Hz"]
[grid]
"operation.duty_ratio" = [0.4, 0.6]
"""


class Verb(NamedTuple):
    """The words of a call, and whether it goes on from what an earlier one kept rather than starting anew."""

    words: tuple[str, ...]
    goes_on: bool = False


CONSTANT = "prototype-constant-load"
SMALL = ("--duty", "0.4", "0.8", "4", "--pressure", "40 bar", "80 bar", "4")
QUICK = ("--estimator", "inverse-time", "--estimator", "m-over-t", "--scenario", "constant", "--seeds", "2")
VERBS = {
    "run": Verb(("run", CONSTANT, "--until", "0.1 s")),
    "map": Verb(("map", CONSTANT, *SMALL), goes_on=True),
    "rig": Verb(("rig", "pressure-drop", CONSTANT)),
    "design": Verb(("design", "optimum", "prototype", "--starts", "1", "--no-simulation")),
    "compare": Verb(("compare", "estimators", *QUICK)),
    "estimate": Verb(("estimate", "../edges.csv", "--edges", "edge", "--sectors", "8")),
    "study": Verb(("study", "../study.toml"), goes_on=True),
}


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The current folder, in which verbs write `out`; a log and a study lie above it."""
    edges = 0.2 + np.arange(600) * (np.pi / 4.0) / (2.0 * np.pi * 24.7)
    (tmp_path / "edges.csv").write_text("edge [s]\n" + "\n".join(f"{t:.9g}" for t in edges) + "\n")
    (tmp_path / "study.toml").write_text(STUDY)
    folder = tmp_path / "place"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def small_disk(place, not_tested):
    """`place` on a disk of so many kB."""
    mounted = []

    def mount(size):
        command = ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", str(place)]
        if subprocess.run(command, capture_output=True, check=False).returncode:
            not_tested("a small disk cannot be mounted here; files of limited size stand in for it", "mount")
        mounted.append(place)
        os.chdir(place)

    yield mount
    os.chdir(place.parent)
    for folder in mounted:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.fixture
def small_files():
    """Has every file of this process end at so many kB."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (1000 * size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


COMPILED = set()


@pytest.fixture
def compiled(vvdp, place, name):
    """Has the code of a verb compiled, which needs room of its own on the disk of the cache."""
    if name not in COMPILED:
        vvdp(*VERBS[name].words, "--out", "../compiled")
        COMPILED.add(name)


def unfinished(folder):
    """What should not be there after all is over."""
    return [path for path in folder.rglob(".*") if UNFINISHED.fullmatch(path.name)]


def expect_one_line(answer, name, place):
    """A line that names the place, nothing in pieces; what was finished of many points or cases is kept."""
    assert answer.code in (1, 2), answer
    assert "Traceback" not in answer.err
    assert wording.files.cannot_write in answer.err.splitlines()[-1], answer.err
    assert not unfinished(place)
    if not VERBS[name].goes_on:
        assert not list(place.iterdir())


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("size", [8, 60])
@pytest.mark.parametrize("name", VERBS)
def test_files_that_may_not_grow(vvdp, place, small_files, name, size):
    """A limit on the size of files fails as a full disk does, within a write; it can be set anywhere."""
    small_files(size if name != "study" else 1)
    expect_one_line(vvdp(*VERBS[name].words, "--out", "out"), name, place)


@pytest.mark.parametrize("size", [12, 80])
@pytest.mark.parametrize("name", VERBS)
def test_full_disk(vvdp, place, small_disk, name, size):
    small_disk(size if name != "study" else 4)
    expect_one_line(vvdp(*VERBS[name].words, "--out", "out"), name, place)


def test_a_process_on_a_full_disk_ends_in_order(place, small_disk):
    """HDF5 that cannot be closed ends in a segmentation fault, which only the end of the process shows."""
    small_disk(300)
    for name in ("run", "estimate"):
        ended = run_process(name)
        assert ended.returncode == 1, ended.stderr
        assert ended.stderr.splitlines()[-1] == "out: " + wording.files.cannot_write + " (No space left on device)"
        assert not list(place.iterdir())


def test_a_place_that_cannot_be_written_is_told_before_the_work(vvdp, place, monkeypatch):
    def refuse(*_, **__):
        raise OSError(30, "Read-only file system", "out")

    monkeypatch.setattr(Path, "mkdir", refuse)
    for name, verb in VERBS.items():
        answer = vvdp(*verb.words, "--out", "out")
        assert answer.code == 2, name
        assert "out: " + wording.files.cannot_write + " (Read-only file system" in answer.err.splitlines()[-1]
    assert not list(place.iterdir())


def arguments(name, *more):
    return {
        "args": [sys.executable, "-m", "vvdp", *VERBS[name].words, "--out", "out", *more],
        "env": {**os.environ, "PYTHONPATH": SOURCE},
        "text": True,
    }


def run_process(name, *more, **options):
    return subprocess.run(**arguments(name, *more), capture_output=True, check=False, **options)


def kept_points(place):
    return {path.name: path.read_bytes() for path in place.glob("out/**/cases-*.json")}


def test_a_killed_map_goes_on_from_what_it_kept(vvdp, place):
    """Points are kept in batches of a few: 14 of 14 kills of a map of 16 points lost them all when they were one.
    Five points more for each of the four duty ratios give their derived capacity."""
    with subprocess.Popen(**arguments("map"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        while process.poll() is None and not kept_points(place):
            time.sleep(0.001)
        process.kill()
    kept = kept_points(place)
    again = vvdp(*VERBS["map"].words, "--out", "out")
    assert again.code == 0
    assert kept and kept_points(place).items() >= kept.items()
    assert len(kept_points(place)) > 1
    assert wording.progress.finished_already.format(done="", all=36, what="points") in again.err


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGINT, 130)])
def test_a_signal_that_ends_it_keeps_what_was_reached(place, number, code):
    words = ("--until", "500 s", "--set", "run.window=0.01 s", "--no-report")
    with subprocess.Popen(**arguments("run", *words), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        for line in process.stderr:
            if line.startswith("t = "):  # under way
                break
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
    assert process.returncode == code
    assert wording.progress.interrupted_at in err
    assert [path.name for path in place.iterdir()] == ["out"]
    assert not (place / "out" / "report.html").exists()


def test_a_terminal_that_is_closed_keeps_what_was_reached(place):
    """Nothing can be written to it any more, which must not end what is still to be done."""
    words = ("--until", "500 s", "--set", "run.window=0.01 s", "--no-report")
    ours, theirs = pty.openpty()
    lead = {"start_new_session": True, "preexec_fn": lambda: fcntl.ioctl(2, termios.TIOCSCTTY, 0)}
    with subprocess.Popen(**arguments("run", *words), stdin=theirs, stdout=theirs, stderr=theirs, **lead) as process:
        os.close(theirs)
        while not re.search(rb"t = [1-9]", os.read(ours, 10_000)):
            pass
        os.close(ours)
        assert process.wait(60) == 129
    assert [path.name for path in place.iterdir()] == ["out"]
    assert json.loads((place / "out" / "summary.json").read_text())["finished"] is False


def test_signals_that_are_ignored_stay_so(place):
    """As `nohup` has it."""
    with subprocess.Popen(
        **arguments("run"), preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN), stdout=subprocess.DEVNULL
    ) as process:
        while process.poll() is None and not any(place.iterdir()):
            time.sleep(0.002)
        process.send_signal(signal.SIGHUP)
        process.wait()
    assert process.returncode == 0
    assert (place / "out" / "report.html").exists()


UNEXPECTED = "vvdp: unexpected error, a mistake of vvdp: "


@pytest.mark.parametrize(
    ("problem", "code", "words"),
    [
        (MemoryError("Unable to allocate 8 GiB"), 1, wording.progress.not_enough_memory + ". Unable to allocate 8 GiB"),
        (MemoryError(), 1, wording.progress.not_enough_memory),
        (ZeroDivisionError("float division by zero"), 70, UNEXPECTED + "ZeroDivisionError: float division by zero (/"),
        (RecursionError("too deep"), 70, UNEXPECTED + "RecursionError: too deep (/"),
    ],
)
def test_what_nobody_expected_is_one_line(vvdp, place, monkeypatch, problem, code, words):
    def fail(*_, **__):
        raise problem

    monkeypatch.setattr("vvdp.runs.simulate.simulate", fail)
    answer = vvdp(*VERBS["run"].words, "--out", "out")
    assert answer.code == code
    (line,) = answer.err.splitlines()
    assert line.startswith(words)
    assert not list(place.iterdir())


def test_too_little_memory_is_one_line_and_leaves_nothing(place):
    """A hundred seconds recorded finely take 1.4 GB at once."""
    words = ("--until", "300 s", "--set", "run.window=100 s", "--no-report")
    limit = 1_500_000_000
    ended = run_process("run", *words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    assert ended.returncode == 1, ended.stderr
    assert ended.stderr.splitlines()[-1].startswith(wording.progress.not_enough_memory)
    assert not list(place.iterdir())


def test_a_reader_that_leaves_early_ends_a_verb_quietly(place):
    with subprocess.Popen(**arguments("run", "--json"), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        err = process.stderr.read()
        process.wait()
    assert process.returncode == 1
    assert "Traceback" not in err and "BrokenPipe" not in err
    assert (place / "out" / "report.html").exists()
