"""Commands killed at random instants, again and again, and what their results are held against."""

import csv
import json
import multiprocessing
import random
import shutil
import signal
import time
from collections.abc import Sequence
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple

from tests.resuming.ready import call

TIMES = frozenset({"seconds", "wall_time_s", "written", "cost_s", "cost_se_s", "relative_cost"})
"""Keys and columns that say when a command ran and how long what took."""
ASIDE = ("index.sqlite", "steps.csv", "report.html", "vvdp.json")
"""Files that are not held against others, as the folder `case` of a solver: an index, times, and sums over them."""
PATIENCE = 300.0
"""Longest time that any command may take here, on a machine that others use as well [s]."""

_server = multiprocessing.get_context("forkserver")
_server.set_forkserver_preload(["pytest", "tests.resuming.ready"])


class Verb(NamedTuple):
    """The words of a call that writes `out`, and how long after it has begun to write it is killed at most [s].

    goes_on  whether a later call takes up what is there, or begins again
    kept     the files that hold finished work, as a pattern: a call is killed after it has added one
    """

    words: tuple[str, ...]
    longest: float
    goes_on: bool = False
    kept: str = ""


def begin(words: Sequence[str], place: Path) -> BaseProcess:
    """A process that carries out a command in `place`."""
    process = _server.Process(target=call, args=(words, place))
    process.start()
    return process


def carried_out(verb: Verb, place: Path) -> dict[str, Any]:
    """The content of `out` after a call that is left alone."""
    process = begin(verb.words, place)
    process.join(PATIENCE)
    said = (place.parent / "said").read_text()
    assert process.exitcode == 0, said[-2000:]
    assert "Traceback" not in said
    assert [path.name for path in place.iterdir()] == ["out"]
    assert not list(place.rglob(".*"))
    return content(place / "out")


def kill_again_and_again(verb: Verb, place: Path, seed: int, kills: int) -> list[dict[str, Any]]:
    """Kills as many calls, each after it has kept or begun something; the content of every `out` that was finished.

    What one call has kept, no other may lose. A call that is done before it can be killed begins anew.
    """
    rng, whole, done = random.Random(seed), list[dict[str, Any]](), 0
    while done < kills:
        before = kept(verb, place)
        process = begin(verb.words, place)
        until = time.monotonic() + PATIENCE
        while process.is_alive() and not has_begun(verb, place, before) and time.monotonic() < until:
            time.sleep(0.001)
        process.join(rng.uniform(0.0, verb.longest))
        process.kill()
        process.join()
        assert before.items() <= kept(verb, place).items()
        assert process.exitcode in (0, -signal.SIGKILL)
        done += process.exitcode != 0
        if process.exitcode == 0 or (not verb.goes_on and (place / "out").exists()):
            whole.append(content(place / "out"))
            shutil.rmtree(place / "out")
    return [*whole, carried_out(verb, place)]


def kept(verb: Verb, place: Path) -> dict[str, bytes]:
    """The files with work that goes on, by their paths."""
    return {str(path): path.read_bytes() for path in place.glob(verb.kept)} if verb.kept else {}


def has_begun(verb: Verb, place: Path, before: dict[str, bytes]) -> bool:
    """Whether a call has kept more than was there `before`, or has begun to write where it keeps nothing on the way."""
    return kept(verb, place).keys() > before.keys() if verb.kept else any(place.iterdir())


def content(folder: Path) -> dict[str, Any]:
    """What files hold but for times: bytes, JSON and CSV as values; the cases of all batches, whatever these were."""
    found: dict[str, Any] = {"cases": {}}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.is_dir() or path.name in ASIDE or name.is_relative_to("case"):
            continue
        if path.name.startswith("cases-"):
            for case in json.loads(path.read_text())["cases"]:
                assert found["cases"].setdefault(case["key"], timeless(case)) == timeless(case)
        elif path.suffix == ".json":
            found[str(name)] = timeless(json.loads(path.read_text()))
        elif path.suffix == ".csv":
            found[str(name)] = timeless(list(csv.DictReader(path.read_text().splitlines())))
        else:
            found[str(name)] = path.read_bytes()
    return found


def timeless(value: Any) -> Any:
    """A value of JSON, or the rows of a table, without `TIMES`."""
    if isinstance(value, dict):
        return {key: timeless(each) for key, each in value.items() if key not in TIMES}
    return [timeless(each) for each in value] if isinstance(value, list) else value
