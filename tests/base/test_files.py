"""What is written is whole or absent, whatever ends the process that writes it."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.words import wording

import vvdp
from vvdp.base import files
from vvdp.base.errors import ConfigError, WriteError
from vvdp.base.files import HOST, clear_unfinished, list_all, result_directory, write_whole
from vvdp.base.manifest import LIST

SOURCE = str(Path(vvdp.__file__).parents[1])
TOKEN = "0123456789abcdef"


@pytest.fixture(scope="module")
def dead():
    """The number of a process that is no more."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def make_results(directory, text):
    directory.mkdir(parents=True)
    (directory / "meta.json").write_text(text)
    list_all(directory)


def write_results(directory, text, *, force=False):
    with result_directory(directory, force=force) as folder:
        (folder / "meta.json").write_text(text)


def content(folder):
    """All files below a folder but lists of files, by their path in it."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != LIST)
    return {str(path.relative_to(folder)): path.read_text() for path in files}


def test_a_file_replaces_another_and_leaves_nothing_beside(tmp_path):
    write_whole(tmp_path / "a", "first\n")
    write_whole(tmp_path / "a", b"second\r\n")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"second\r\n"


@pytest.mark.parametrize("where", ["fsync", "replace"])
def test_a_file_that_cannot_be_written_leaves_the_earlier_one(tmp_path, monkeypatch, where):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    write_whole(tmp_path / "a", "first")
    monkeypatch.setattr(*{"fsync": (os, "fsync"), "replace": (Path, "replace")}[where], full)
    with pytest.raises(WriteError) as refused:
        write_whole(tmp_path / "a", "second")
    assert str(refused.value) == f"{tmp_path / 'a'}: {wording.files.cannot_write} (No space left on device)"
    assert refused.value.errno == errno.ENOSPC
    assert content(tmp_path) == {"a": "first"}


def test_a_directory_is_absent_until_it_is_whole(tmp_path):
    with result_directory(tmp_path / "x" / "out") as folder:
        (folder / "meta.json").write_text("new")
        assert not (tmp_path / "x" / "out").exists()
    assert content(tmp_path) == {"x/out/meta.json": "new"}
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "x" / "out").stat().st_mode & 0o777 == 0o777 & ~umask


@pytest.mark.parametrize("end", [KeyboardInterrupt, ValueError, MemoryError])
def test_what_ends_early_leaves_nothing_and_what_was_there(tmp_path, end):
    make_results(tmp_path / "out", "old")
    with pytest.raises(end), result_directory(tmp_path / "out", force=True) as folder:
        (folder / "meta.json").write_text("new")
        raise end
    assert content(tmp_path) == {"out/meta.json": "old"}


def test_a_disk_that_fails_is_told_with_the_name_that_was_asked_for(tmp_path):
    with pytest.raises(WriteError) as refused, result_directory(tmp_path / "out") as folder:
        raise OSError(errno.ENOSPC, "No space left on device", str(folder / "figure.png"))
    assert str(refused.value) == f"{tmp_path / 'out'}: {wording.files.cannot_write} (No space left on device)"
    assert content(tmp_path) == {}


def test_force_replaces_results_and_nothing_else(tmp_path):
    make_results(tmp_path / "out", "old")
    with pytest.raises(ConfigError, match=wording.files.already_exists):
        write_results(tmp_path / "out", "new")
    write_results(tmp_path / "out", "new", force=True)
    assert content(tmp_path) == {"out/meta.json": "new"}
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("keep")
    for force in (False, True):
        with pytest.raises(ConfigError, match=rf"{wording.files.already_exists}|{wording.files.holds_something_else}"):
            write_results(tmp_path / "mine", "new", force=force)
    assert content(tmp_path) == {"out/meta.json": "new", "mine/notes.txt": "keep"}


def test_what_came_in_between_is_not_replaced_without_force(tmp_path):
    with pytest.raises(ConfigError, match=wording.files.already_exists), result_directory(tmp_path / "out") as folder:
        (folder / "meta.json").write_text("late")
        make_results(tmp_path / "out", "first")
    assert content(tmp_path) == {"out/meta.json": "first"}
    with result_directory(tmp_path / "two", force=True) as folder:
        (folder / "meta.json").write_text("late")
        make_results(tmp_path / "two", "first")
    assert content(tmp_path / "two") == {"meta.json": "late"}
    with (
        pytest.raises(ConfigError, match=wording.files.holds_something_else),
        result_directory(tmp_path / "x", force=True),
    ):
        (tmp_path / "x").mkdir()
        (tmp_path / "x" / "notes.txt").write_text("keep")
    assert content(tmp_path / "x") == {"notes.txt": "keep"}


def test_two_processes_do_not_work_on_one_directory(tmp_path):
    code = f"""
from pathlib import Path
from vvdp.base.files import result_directory
with result_directory(Path({str(tmp_path / "out")!r})) as folder:
    (folder / "meta.json").write_text("first")
    print("at work", flush=True)
    input()
"""
    arguments = {"env": {**os.environ, "PYTHONPATH": SOURCE}, "stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", code], text=True, **arguments) as first:
        assert first.stdout.readline() == "at work\n"
        for force in (False, True):
            with pytest.raises(ConfigError, match=wording.files.being_written.format(process=first.pid)):
                write_results(tmp_path / "out", "second", force=force)
        write_results(tmp_path / "other", "beside")
        first.communicate("\n")
    assert content(tmp_path) == {"out/meta.json": "first", "other/meta.json": "beside"}


def test_what_a_dead_process_left_is_cleared_away_by_the_next_call(tmp_path, dead):
    make_results(tmp_path / f".out.{HOST}-{dead}-{TOKEN}.new", "part")
    make_results(tmp_path / f".gone.{HOST}-{dead}-{TOKEN}.old", "old")
    (tmp_path / f".study.json.{HOST}-{dead}-{TOKEN}.tmp").write_text("part")
    kept = {
        f".a.other{HOST}-{dead}-{TOKEN}.tmp": "of another host",
        f".a.{HOST}-{os.getpid()}-{TOKEN}.tmp": "of a living process",
        f".a.{HOST}-{dead}-{TOKEN}.txt": "not ours",
        f"a.{HOST}-{dead}-{TOKEN}.tmp": "not ours",
    }
    for name, text in kept.items():
        (tmp_path / name).write_text(text)
    write_results(tmp_path / "out", "new")
    assert content(tmp_path) == {"out/meta.json": "new", **kept}


def test_what_is_locked_is_alive_whatever_its_number_says(tmp_path, dead):
    """A process of another container may have the name of this host, and a number that is nobody's here."""
    locked = tmp_path / f".out.{HOST}-{dead}-{TOKEN}.new"
    make_results(locked, "at work")
    opened = os.open(locked, os.O_RDONLY)
    files._lock(opened)
    clear_unfinished(tmp_path)
    assert locked.exists()
    os.close(opened)
    clear_unfinished(tmp_path)
    assert not locked.exists()


@pytest.mark.parametrize("force", [False, True])
def test_an_exchange_cut_short_between_its_renames_is_finished_by_the_next_call(tmp_path, dead, force):
    make_results(tmp_path / f".out.{HOST}-{dead}-{TOKEN}.new", "new")
    make_results(tmp_path / f".out.{HOST}-{dead}-{TOKEN}.old", "old")
    if force:
        write_results(tmp_path / "out", "newest", force=True)
    else:
        with pytest.raises(ConfigError, match=wording.files.already_exists):
            write_results(tmp_path / "out", "newest")
    assert content(tmp_path) == {"out/meta.json": "newest" if force else "new"}


EXCHANGE = """
import os, sys
from pathlib import Path
from vvdp.base.files import result_directory
left = int(sys.argv[2])
def counted(event, arguments):
    global left
    changes = event in {"os.rename", "os.remove", "os.rmdir", "os.mkdir", "shutil.rmtree"}
    if changes or event == "open" and ".out." in str(arguments[0]):
        left -= 1
        if left < 0:
            os._exit(9)
sys.addaudithook(counted)
with result_directory(Path(sys.argv[1]), force=True) as folder:
    (folder / "meta.json").write_text("new")
    (folder / "more").mkdir()
    (folder / "more" / "page").write_text("new")
print("done")
"""


def test_killed_at_any_of_its_steps_an_exchange_loses_neither(tmp_path):
    """The process ends before its first, its second, ... step that touches the disk: old or new, whole, and no rest."""
    seen = set()
    for step in range(40):
        place = tmp_path / str(step)
        make_results(place / "out", "old")
        ended = subprocess.run(
            [sys.executable, "-c", EXCHANGE, str(place / "out"), str(step)],
            env={**os.environ, "PYTHONPATH": SOURCE}, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert ended.returncode == (0 if ended.stdout else 9), ended.stderr
        seen.add("done" if ended.stdout else "absent" if not (place / "out").exists() else "there")
        clear_unfinished(place)
        assert content(place) in (
            {"out/meta.json": "old"},
            {"out/meta.json": "new", "out/more/page": "new"},
        )
        if ended.stdout:
            break
    assert seen == {"done", "absent", "there"}


def test_every_file_and_folder_is_synced_before_the_directory_has_its_name(tmp_path, monkeypatch):
    """As the system sees it: files by their number, and the renaming after all of them."""
    order = []
    fsync, rename = os.fsync, Path.rename
    monkeypatch.setattr(os, "fsync", lambda opened: order.append(os.fstat(opened).st_ino) or fsync(opened))
    monkeypatch.setattr(Path, "rename", lambda self, target: order.append("renamed") or rename(self, target))
    with result_directory(tmp_path / "out") as folder:
        (folder / "figures").mkdir()
        write_whole(folder / "figures" / "a.svg", "a")
        (folder / "plain").write_text("b")
        assert not order  # not twice
    parts = [tmp_path / "out", *(tmp_path / "out").rglob("*")]
    assert sorted(order[: order.index("renamed")]) == sorted(path.stat().st_ino for path in parts)
    assert order[order.index("renamed") :] == ["renamed", tmp_path.stat().st_ino]
    write_whole(tmp_path / "alone", "c")
    assert order[-2:] == [(tmp_path / "alone").stat().st_ino, tmp_path.stat().st_ino]
