"""Mutated and hostile files are refused or read as they stand: a sixtieth here, all of them among the slow tests."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from tests.attack import cage
from tests.attack.__main__ import FIELDS, GOOD
from tests.attack.cage import Outcome
from tests.attack.meanings import Meaning, misreading
from tests.attack.page import PAGE, filled_in, read_rows

ROOT = Path(__file__).parents[2]


def command(*words):
    return subprocess.run([sys.executable, "-m", "tests.attack", *words], cwd=ROOT, capture_output=True, text=True)


@pytest.mark.thorough
def test_a_sixtieth_of_the_files_is_refused_or_read_as_it_stands():
    done = command("--share", "0.0166")
    assert done.returncode == 0, done.stdout
    assert len(done.stdout.splitlines()) == len(FIELDS)


@pytest.mark.slow
def test_all_files_are_refused_or_read_as_they_stand_and_the_page_has_their_counts():
    done = command("--check")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_page_counts_all_files_and_no_fault():
    page = PAGE.read_text("utf-8")
    rows = read_rows(page)
    assert {name: counts.total() for name, counts in rows.items()} == {each.name: each.files for each in FIELDS}
    assert all(counts[outcome] == 0 for counts in rows.values() for outcome in set(Outcome) - set(GOOD))
    assert all(counts[Outcome.REFUSED] for counts in rows.values())
    assert filled_in(page, rows) == page
    assert sum(each.files for each in FIELDS if "log" not in each.name) >= 2000
    assert [each.files >= least for each, least in zip(FIELDS[-2:], (500, 60), strict=True)] == [True, True]


TRAPS = """
import json, os, subprocess, sys
from pathlib import Path
from tests.attack import cage
from tests.attack.cage import Reading, caged

cage.LONGEST, cage.LARGEST = 0.5, 300_000_000
folder = Path(sys.argv[1], "own")
folder.mkdir()

def refuses():
    print("no such thing", file=sys.stderr)
    return Reading(2)

def spins():
    while True:
        pass

def swells():
    return Reading(len(bytearray(os.urandom(1000)) * 350_000) * 0)

def runs_what_lies_there():
    (folder / "payload.py").write_text("x = 1")
    exec(compile("x = 1", folder / "payload.py", "exec"))
    return Reading(0)

traps = [
    refuses, lambda: Reading(0), lambda: Reading(0, "was ignored"), lambda: 1 / 0, lambda: Reading(2),
    lambda: Reading(70), spins, swells, runs_what_lies_there, lambda: Reading((folder.parent / "x").write_text("") * 0),
    lambda: Reading(subprocess.call(["true"])), lambda: os.abort(), lambda: Reading((folder / "x").write_text("") * 0),
]
print(json.dumps([caged(trap, folder).outcome for trap in traps]))
"""


def test_the_cage_notices_what_it_is_there_for(tmp_path):
    done = subprocess.run([sys.executable, "-c", TRAPS, tmp_path], cwd=ROOT, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [
        Outcome.REFUSED, Outcome.READ, Outcome.MISREAD, Outcome.TRACEBACK, Outcome.TRACEBACK, Outcome.TRACEBACK,
        Outcome.SLOW, Outcome.LARGE, Outcome.TOUCHED, Outcome.TOUCHED, Outcome.TOUCHED, Outcome.TRACEBACK, Outcome.READ,
    ]  # fmt: skip
    assert cage.LONGEST == 10.0 and cage.LARGEST == 1e9


def meaning(length, read="as ever", si=0.01):
    return Meaning({"pipe": {"length": length}}, {"pipe": read}, {"pipe.length": si})


@pytest.mark.parametrize(
    ("other", "complaint"),
    [
        (meaning("10 mm"), ""),
        (meaning("10.0  mm"), ""),
        (meaning("20 mm", "twice", 0.02), ""),
        (meaning("20 mm"), "says something else, and is read the same: pipe.length"),
        (meaning("10 mm", "otherwise"), "it says the same, and is read otherwise: pipe"),
        (meaning("20 mm", "twice", 0.04), "pipe.length is read as 0.04; expected 0.02"),
        (meaning("10 cm", "ten times", 0.1), ""),
        (Meaning({"pipe": {"length": "10 mm"}, "until": "5 s"}, {"pipe": "as ever"}, {}), "says something else"),
    ],
)
def test_what_is_read_otherwise_than_it_stands_is_noticed(other, complaint):
    found = misreading(meaning("10 mm"), other)
    assert found.startswith(complaint) and bool(found) == bool(complaint)
