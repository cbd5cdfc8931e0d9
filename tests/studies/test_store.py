"""What a study keeps: files that count, an index that only helps; batches kept by whoever can."""

import math
import os
import sqlite3
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from vvdp.base.errors import ConfigError
from vvdp.studies import store, work
from vvdp.studies.engine import HERE, ThisProcess
from vvdp.studies.index import NAME, read_index
from vvdp.studies.store import Finished, finished_cases, keep_finished, opened_store, write_finished
from vvdp.studies.work import Batching, kept_batches


def finished(key: str) -> Finished:
    return Finished(key, {"a.x": "1 bar", "a.u": {"step": ["0", "1"]}}, None, {"power_W": 3.5, "trusted": True})


def asked(directory: Path, question: str) -> list[tuple[object, ...]]:
    base = sqlite3.connect(directory / NAME)
    try:
        return base.execute(question).fetchall()
    finally:
        base.close()


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A store with the batches ab and c, and a case that failed."""
    assert opened_store(tmp_path / "s", {}) == {}
    keep_finished(tmp_path / "s", [finished("a"), finished("b")])
    keep_finished(tmp_path / "s", [Finished("c", {}, "no end", {"power_W": math.nan})])
    return tmp_path / "s"


def test_the_index_has_every_case_and_answers_questions(place: Path) -> None:
    assert asked(place, "select key, failure from cases order by key") == [("a", None), ("b", None), ("c", "no end")]
    question = (
        "select json_extract(summary, '$.power_W'), json_extract(settings, '$.\"a.x\"') from cases where key = 'a'"
    )
    assert asked(place, question) == [(3.5, "1 bar")]
    assert sorted(read_index(place)) == sorted(path.name for path in place.glob("cases-*.json"))


def test_what_the_index_has_is_not_read_again(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = finished_cases(place)
    assert math.isnan(before["c"].summary["power_W"]) and before["a"] == finished("a")
    monkeypatch.setattr(store, "_read", lambda path: pytest.fail(f"{path} was read"))
    assert finished_cases(place).keys() == opened_store(place, {}).keys() == before.keys()
    assert finished_cases(place)["a"] == before["a"]


@pytest.mark.parametrize("harm", ["missing", "damaged", "another database", "not JSON", "locked", "of another version"])
def test_an_index_that_is_of_no_use_costs_nothing(place: Path, harm: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vvdp.studies.index.WAITING", 0.05)
    path, held = place / NAME, None
    match harm:
        case "missing":
            path.unlink()
        case "damaged":
            path.write_bytes(b"no database at all" * 100)
        case "another database":
            path.unlink()
            asked(place, "create table cases (x)")
        case "not JSON":
            held = sqlite3.connect(path)
            held.execute("update cases set summary = '{'")
            held.commit()
        case "locked":
            held = sqlite3.connect(path)
            held.execute("begin exclusive")
        case "of another version":
            asked(place, "pragma user_version = 99")
    assert sorted(finished_cases(place)) == ["a", "b", "c"]
    assert sorted(opened_store(place, {})) == ["a", "b", "c"]
    keep_finished(place, [finished("d")])
    if held:
        held.close()
    assert sorted(opened_store(place, {})) == ["a", "b", "c", "d"]
    assert [key for (key,) in asked(place, "select key from cases order by key")] == ["a", "b", "c", "d"]


def test_the_files_count_and_not_the_index(place: Path) -> None:
    one, other = sorted(place.glob("cases-*.json"), key=lambda path: path.stat().st_size)
    one.unlink()
    assert sorted(finished_cases(place)) == ["a", "b"]
    opened_store(place, {})
    assert asked(place, "select count(*) from cases") == [(2,)]
    other.write_text(other.read_text()[:-10])
    with pytest.raises(ConfigError, match="is damaged"):
        finished_cases(place)


def test_reading_writes_nothing(place: Path) -> None:
    (place / NAME).unlink()
    before = {path: path.stat().st_mtime_ns for path in place.iterdir()}
    finished_cases(place)
    assert {path: path.stat().st_mtime_ns for path in place.iterdir()} == before


def test_what_another_process_wrote_is_found_and_indexed(place: Path) -> None:
    """A worker whose caller was killed writes its batch all the same."""
    write_finished(place, [finished("d")])
    assert asked(place, "select count(*) from cases") == [(3,)]
    assert sorted(opened_store(place, {})) == ["a", "b", "c", "d"]
    assert asked(place, "select count(*) from cases") == [(4,)]


def done(batch: Sequence[str], cores: int) -> list[Finished]:
    return [finished(key) for key in batch]


def carried_out(cases: Sequence[str], directory: Path, engine=HERE, **options) -> list[list[str]]:
    found = kept_batches(done, cases, directory, engine, threading.Event(), **options)
    return [[case.key for case in batch] for batch in found]


def test_a_batch_is_kept_by_the_worker_or_else_by_the_caller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    monkeypatch.setattr(work, "write_finished", lambda *given: written.append("worker") or write_finished(*given))
    monkeypatch.setattr(store, "write_finished", lambda *given: written.append("caller") or write_finished(*given))
    for name, sees, expected in (("near", True, "worker"), ("far", False, "caller")):
        opened_store(tmp_path / name, {})
        monkeypatch.setattr(work, "is_store", lambda directory, sees=sees: sees)
        assert carried_out("ab", tmp_path / name) == [["a", "b"]]
        assert written.pop() == expected and not written
        assert sorted(finished_cases(tmp_path / name)) == ["a", "b"]


def test_a_worker_that_may_not_write_leaves_it_to_the_caller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*given: object) -> None:
        raise PermissionError(13, "read-only")

    opened_store(tmp_path, {})
    monkeypatch.setattr(work, "write_finished", refuse)
    carried_out("ab", tmp_path)
    assert sorted(finished_cases(tmp_path)) == ["a", "b"]


class Counting:
    """An engine with so many workers that works on one item after the other."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def run_all(self, task, items) -> Iterator:
        return ThisProcess(1).run_all(task, items)


def test_batches_leave_something_for_every_worker_and_grow_with_speed(tmp_path: Path) -> None:
    """The first are of 16 cases at most; then by time, which is nothing here: an equal share of what is left."""
    opened_store(tmp_path, {})
    cases = [f"{number:04}" for number in range(3000)]
    sizes = [len(batch) for batch in carried_out(cases, tmp_path, Counting(4))]
    assert sum(sizes) == 3000
    assert sizes[:3] == [16, 746, 560]  # 16, then ceil(2984/4), ceil(2238/4)
    assert [len(batch) for batch in carried_out(cases, tmp_path)][:3] == [16, 1000, 1000]
    assert [len(batch) for batch in carried_out(cases[:10], tmp_path, Counting(4))] == [3, 3, 3, 1]


def test_a_batch_has_one_group_and_an_interruption_ends_the_batches(tmp_path: Path) -> None:
    opened_store(tmp_path, {})
    assert carried_out(["a1", "a2", "b1", "a3"], tmp_path, batching=Batching(group=lambda case: case[0])) == [
        ["a1", "a2"],
        ["b1"],
        ["a3"],
    ]
    stop = threading.Event()
    found = kept_batches(done, [str(number) for number in range(40)], tmp_path, Counting(2), stop)
    assert len(next(found)) == 16
    stop.set()
    assert list(found) == []


def test_temporary_files_have_names_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes of different machines may have the same number."""
    names: list[str] = []
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda self, target: names.append(self.name) or replace(self, target))
    monkeypatch.setattr(os, "getpid", lambda: 7)
    opened_store(tmp_path, {})
    for _ in range(2):
        write_finished(tmp_path, [finished("a")])
    assert len(set(names)) == 3
