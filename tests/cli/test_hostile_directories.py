"""A result directory is data: whatever is in it, opening it runs nothing, starts nothing and writes nowhere else."""

import json
import os
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.cli.hostile_directories import FOREIGN, RESULTS, RUNS, Hostile, Place, sign
from tests.cli.test_drawn import MODULE, OWN
from tests.words import wording

import vvdp as package
from vvdp.base.errors import ConfigError
from vvdp.base.files import list_all, result_directory, write_listed, write_whole
from vvdp.base.kinds import LENGTH
from vvdp.base.manifest import LIST, open_directory, read_list
from vvdp.results.chart import Chart, Line, Lines
from vvdp.results.result import Column, Result, Table
from vvdp.results.store import write_result
from vvdp.studies.index import APPLICATION, NAME, read_index
from vvdp.studies.store import Finished, finished_cases, keep_finished, opened_store, set_aside

WRITES = {"os.remove": (0,), "os.rename": (0, 1), "os.rmdir": (0,), "os.mkdir": (0,), "os.link": (1,),
          "os.symlink": (1,), "os.truncate": (0,), "os.chmod": (0,)}  # fmt: skip
"""Events of Python that change files, and which of their arguments are paths."""
STARTS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.forkpty", "socket.connect")
CHANGING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


class Guard:
    """Listens to what this process does to files, and whether it starts others, while it is `on`."""

    def __init__(self) -> None:
        self.on = False
        self.clear()

    def clear(self) -> None:
        """Forgets what was heard."""
        self.written: set[Path] = set()
        self.read_as_code: set[Path] = set()
        self.started: list[str] = []

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Notes an event."""
        if not self.on:
            return
        if event == "open" and isinstance(arguments[0], str | bytes):
            _, mode, flags = arguments
            if (isinstance(mode, str) and set(mode) & set("wax+")) or (isinstance(flags, int) and flags & CHANGING):
                self.note(arguments[0])
        elif event in WRITES:
            for place in WRITES[event]:
                self.note(arguments[place])
        elif event in STARTS:
            self.started.append(f"{event} {arguments}")
        elif event == "exec" and getattr(arguments[0], "co_name", "") == "<module>":
            self.read_as_code.add(Path(arguments[0].co_filename))

    def note(self, path: Any) -> None:
        """Notes a path that is written to."""
        if isinstance(path, str | bytes | os.PathLike):
            self.written.add(Path(os.path.normpath(Path.cwd() / os.fsdecode(path))))


GUARD = Guard()
sys.addaudithook(GUARD.hear)


@contextmanager
def guarded(root: Path, *allowed: Path) -> Iterator[None]:
    """Fails where the block writes below `root` but not in `allowed`, runs a module from there, or starts a process."""
    GUARD.clear()
    GUARD.on = True
    try:
        yield
    finally:
        GUARD.on = False
    outside = [path for path in GUARD.written if not any(path.is_relative_to(each) for each in (*allowed, *NEUTRAL))]
    assert outside == []
    assert GUARD.started == []
    assert [path for path in GUARD.read_as_code if path.is_relative_to(root)] == []


BYTECODE = sorted({path.parent / "__pycache__" for path in Path(package.__file__).parent.rglob("*.py")})
NEUTRAL = (Path("/dev"), Path(os.environ.get("VVDP_CACHE") or Path.home() / ".cache"), Path(sys.prefix), *BYTECODE)
"""Where caches of compiled code, of fonts and of vvdp's own modules are."""


def content(folder: Path) -> dict[str, bytes | str]:
    """All that is below a folder, links as where they lead."""
    return {
        str(path.relative_to(folder)): str(path.readlink()) if path.is_symlink() else path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or path.is_file()
    }


def a_result() -> Result:
    """A table of two lengths and a chart of it."""
    lengths = {key: Column(np.arange(40.0), LENGTH, key) for key in ("x_m", "y_m")}
    panel = Lines(lines=(Line(x="x_m", y="y_m"),), table="curve")
    chart = Chart(name="line", caption="A line.", table="curve", panels=(panel,))
    return Result(verb="fit", title="A line", system="", tables={"curve": Table(title="", columns=lengths)},
                  charts={"line": chart})  # fmt: skip


@pytest.fixture(scope="session")
def sound_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run with a page, whose list has two figures that no page draws any more."""
    from vvdp.report.report import write_report
    from vvdp.runs.simulate import run_system, save_run
    from vvdp.systems.system import load_system

    directory = tmp_path_factory.mktemp("sound") / "run"
    with result_directory(directory) as folder:
        run = run_system(load_system("buck-converter", (), "0.02 s"))
        save_run(folder, run)
        write_report(folder, run)
    return directory


@pytest.fixture(scope="session")
def sound_result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small result with a page."""
    from vvdp.report.result_page import write_result_report

    directory = tmp_path_factory.mktemp("sound") / "result"
    with result_directory(directory) as folder:
        write_result(folder, a_result(), "")
        write_result_report(folder)
    return directory


@pytest.fixture
def outside(here: Path) -> Path:
    """A folder with what must stay as it is."""
    folder = here / "outside"
    folder.mkdir()
    for name in ("keep.svg", "photo.png", "thesis.tex"):
        (folder / name).write_text("keep")
    return folder


def spoiled(hostile: Hostile, sound: Path, here: Path) -> Place:
    place = Place(here / "R", here / "outside")
    shutil.copytree(sound, place.directory)
    hostile.spoil(place)
    if hostile.signed:
        sign(place.directory)
    return place


UNTOLD = ("package beside", "code on record in it", "an installed function", "a built-in function")
ALL = [*((name, "run") for name in RUNS), *((name, "result") for name in RESULTS)]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "kind"), ALL, ids=[name for name, _ in ALL])
def test_no_command_runs_or_writes_what_a_hostile_directory_asks_for(
    vvdp, here, outside, sound_run, sound_result, name, kind
):
    hostile = (RUNS if kind == "run" else RESULTS)[name]
    place = spoiled(hostile, sound_run if kind == "run" else sound_result, here)
    before, out = content(outside), here / "out"
    out.mkdir()
    calls = {
        "report": (("report", "R", "--project", "P"), place.directory),
        "plot": (("plot", "R", "--list"), out),
        "figure": (("plot", "R", "line" if kind == "result" else "run", "--out", "out/f.svg"), out),
        "compare": (("compare", "runs", "R", str(sound_run), "--out", "out/c", "--no-report"), out),
        "export": (("export", "data", "R", "--csv", "out/x.csv"), out),
    }
    if not hostile.refused and name != "code beside":  # a page takes long, and those without a circuit are alike
        calls = {call: calls[call] for call in (("plot",) if name in UNTOLD else ("report", "plot"))}
    codes = {}
    for call, (words, allowed) in calls.items():
        with guarded(here, allowed):
            answer = vvdp(*words)
        codes[call] = answer.code
        assert answer.code in (0, 2), answer.err
        assert answer.code == 0 or len(answer.err.splitlines()) <= 2, answer.err
        assert str(FOREIGN) not in answer.out
    assert codes.get("report", codes["plot"]) == (2 if hostile.refused else 0)
    assert not place.marker.exists()
    assert content(outside) == before
    assert not any(str(FOREIGN) in path.read_text() for path in out.glob("*.csv"))


def test_there_are_enough_of_them():
    assert len(ALL) >= 30


@pytest.mark.parametrize("name", RUNS)
def test_force_replaces_only_what_the_list_names(here, outside, sound_run, name):
    place = spoiled(RUNS[name], sound_run, here)
    before = content(outside)
    found = {path for path in place.directory.rglob("*") if not path.name.startswith(".")}
    try:
        with result_directory(place.directory, force=True) as folder:
            (folder / "new").write_text("new")
    except ConfigError as refused:
        assert wording.files.holds_something_else in str(refused) or LIST in str(refused)
        assert found <= set(place.directory.rglob("*"))
    else:
        assert RUNS[name].signed or name in ("file gone", "page is a folder") or "dead" in name
        assert sorted(content(place.directory)) == ["new", LIST]
    assert content(outside) == before


def test_code_in_the_working_folder_is_not_imported_by_python_m(here, sound_run):
    for name in ("h5py", "numpy", "vvdp", "payload"):
        (here / f"{name}.py").write_text("from pathlib import Path\nPath('ran').write_text('ran')\n")
    place = Place(here / "R", here)
    shutil.copytree(sound_run, place.directory)
    place.circuit("payload:network")
    sign(place.directory)
    (here / "vvdp.py").unlink()  # Python itself would take it for the program
    environment = {**os.environ, "PYTHONPATH": str(Path(package.__file__).parents[1])}
    done = subprocess.run(
        [sys.executable, "-m", "vvdp", "plot", "R", "--list"], env=environment, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert not (here / "ran").exists()


ALONE = f"""
import os, sys
sys.addaudithook(lambda event, arguments: event in {STARTS!r} and (print(event, arguments), os._exit(99)))
from vvdp.cli.main import main
main(["export", "data", "R", "--csv", "x.csv"])
"""


def test_a_command_that_loads_all_its_libraries_starts_no_process(here, sound_run):
    """In this process they are loaded already."""
    shutil.copytree(sound_run, here / "R")
    environment = {**os.environ, "PYTHONPATH": str(Path(package.__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", ALONE], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (here / "x.csv").is_file()


TOLD, TRUST = wording.directories.code_not_run, wording.directories.trust.format(module="my_pump")

# A module of one's own: what is recorded, what is shown without it, and how it is let run again.


@pytest.fixture
def own_run(vvdp, here) -> Path:
    """A run whose circuit a module beside its system file has drawn, with a chart of its own."""
    (here / "my_pump.py").write_text(MODULE)
    (here / "mine.toml").write_text(OWN)
    answer = vvdp("run", "mine.toml", "--out", "M", "--no-report")
    assert answer.code == 0, answer.err
    return here / "M"


def test_a_module_of_ones_own_is_recorded_and_runs_again_as_it_was(vvdp, here, own_run):
    module = json.loads((own_run / "meta.json").read_text())["module"]
    assert module["name"] == "my_pump" and module["path"] == str(here / "my_pump.py") and len(module["sha256"]) == 64
    answer = vvdp("plot", "M", "--list")
    assert answer.code == 0 and TOLD not in answer.err and "Our own figure" in answer.out


@pytest.mark.parametrize("how", ["changed", "gone", "elsewhere", "never run here"])
def test_a_module_that_differs_is_told_and_runs_only_when_trusted(vvdp, here, own_run, how, monkeypatch):
    module, option = here / "my_pump.py", "my_pump"
    match how:
        case "changed":
            module.write_text(module.read_text() + "\nimport pathlib; pathlib.Path('ran').write_text('ran')\n")
        case "gone":
            module.unlink()
        case "elsewhere":
            (here / "lib").mkdir()
            module.rename(here / "lib" / "my_pump.py")
            option = "lib/my_pump.py"
        case "never run here":
            monkeypatch.setenv("VVDP_CACHE", str(here / "cache"))
    answer = vvdp("plot", "M", "--list")
    assert answer.code == 0
    assert TOLD in answer.err and TRUST in answer.err
    assert "states.rail" in answer.out and "Our own figure" not in answer.out
    if how == "changed":
        reported = vvdp("report", "M")
        assert reported.code == 0 and TRUST in reported.err
        page = (own_run / "report.html").read_text("utf-8")
        assert wording.directories.no_circuit in page and "duration_s" in page
    assert vvdp("export", "data", "M", "--csv", "m.csv").code == 0
    compared = vvdp("compare", "runs", "M", "M", "--no-report", "--out", "c")
    assert compared.code == 2 and TRUST in compared.err
    assert not (here / "ran").exists()
    trusted = vvdp("plot", "M", "--list", "--trust", option)
    assert trusted.code == 0
    assert ("Our own figure" in trusted.out) == (how != "gone")


OWN_PROGRAM = """
from typing import NamedTuple

from vvdp.base.kinds import Pressure
from vvdp.network.program import ProgramType


class Seen(NamedTuple):
    pressure: Pressure


def show(t, memory, reading, settings):
    return memory, reading


SHOW = ProgramType(show, Seen, Seen(1e5))
"""
PROGRAMMED = """
[nodes]
tank = { type = "tank" }
rail = { type = "volume", volume = "100 cc", start = "0 bar" }
[components]
pump = { type = "flow-source", a = "tank", b = "rail", flow = "20 lpm" }
load = { type = "orifice", a = "rail", b = "tank", area = "4 mm^2" }
[programs.shown]
type = "my_pump:SHOW"
reads = "rail.pressure"
[run]
until = "10 ms"
"""


def test_a_module_with_a_program_is_under_the_same_rule(vvdp, here):
    module = here / "my_pump.py"
    module.write_text(OWN_PROGRAM)
    (here / "mine.toml").write_text(PROGRAMMED)
    answer = vvdp("run", "mine.toml", "--out", "M", "--no-report")
    assert answer.code == 0, answer.err
    assert json.loads((here / "M" / "meta.json").read_text())["module"]["name"] == "my_pump"
    assert TOLD not in vvdp("plot", "M", "--list").err
    module.write_text(OWN_PROGRAM + "\nimport pathlib; pathlib.Path('ran').write_text('ran')\n")
    answer = vvdp("plot", "M", "--list")
    assert answer.code == 0 and TOLD in answer.err and TRUST in answer.err
    assert not (here / "ran").exists()
    assert vvdp("plot", "M", "--list", "--trust", "my_pump").code == 0
    assert (here / "ran").exists()


def test_a_system_file_in_a_result_directory_runs_no_code_beside_it(vvdp, here, own_run):
    (here / "my_pump.py").rename(here / "other.py")
    assert (own_run / "my_pump.py").is_file()  # the copy that says how it was
    answer = vvdp("run", "M/system.toml", "--out", "again")
    assert answer.code == 2 and wording.directories.lies_in_results in answer.err


# What is replaced, deleted and kept.


@pytest.fixture
def run_here(here, sound_run) -> Path:
    shutil.copytree(sound_run, here / "R")
    return here / "R"


def test_force_refuses_a_foreign_file_by_name_and_keeps_it(vvdp, here, run_here):
    (run_here / "thesis.tex").write_text("thesis")
    before = content(run_here)
    answer = vvdp("run", "buck-converter", "--until", "0.02 s", "--out", "R", "--force")
    assert answer.code == 2
    assert "thesis.tex" in answer.err and wording.files.holds_something_else in answer.err
    assert content(run_here) == before


def test_force_refuses_a_folder_with_a_file_of_a_common_name(vvdp, here):
    (here / "d").mkdir()
    (here / "d" / "meta.json").write_text("{}")
    (here / "d" / "thesis.tex").write_text("thesis")
    answer = vvdp("run", "buck-converter", "--until", "0.02 s", "--out", "d", "--force")
    assert answer.code == 2 and "thesis.tex" in answer.err
    assert sorted(content(here / "d")) == ["meta.json", "thesis.tex"]


def test_force_refuses_what_was_edited_and_replaces_what_was_not(vvdp, here, run_here):
    text = (run_here / "system.toml").read_text()
    (run_here / "system.toml").write_text(text + "# mine\n")
    call = ("run", "buck-converter", "--until", "0.02 s", "--out", "R", "--force", "--no-report")
    refused = vvdp(*call)
    assert refused.code == 2 and wording.directories.edited.format(name="system.toml") in refused.err
    (run_here / "system.toml").write_text(text)
    assert vvdp(*call).code == 0
    assert not (run_here / "report.html").exists()


def test_report_of_a_changed_directory_names_the_file(vvdp, here, sound_result):
    shutil.copytree(sound_result, here / "R")
    text = (here / "R" / "curve.csv").read_text()
    (here / "R" / "curve.csv").write_text(text[: len(text) // 2])
    for words in (("report", "R"), ("plot", "R", "--list"), ("export", "data", "R", "--csv", "x.csv")):
        answer = vvdp(*words)
        assert answer.code == 2
        assert answer.err.startswith(f"R/curve.csv: {wording.directories.has_changed} (")
        assert wording.directories.rows.format(rows=40) in answer.err
    assert not (here / "x.csv").exists()


def test_report_deletes_only_figures_that_it_drew(vvdp, here, run_here):
    (run_here / "figures" / "mine.svg").write_text("mine")
    for name in ("old", "edited"):
        with write_listed(run_here, [f"figures/{name}.svg"], pages=True):
            write_whole(run_here / "figures" / f"{name}.svg", "drawn")
    (run_here / "figures" / "edited.svg").write_text("edited")
    assert vvdp("report", "R").code == 0
    left = {path.name for path in (run_here / "figures").iterdir()}
    assert {"mine.svg", "edited.svg"} < left and "old.svg" not in left
    assert "figures/edited.svg" not in read_list(run_here)
    assert vvdp("report", "R").code == 0  # what is left beside does not count


def test_report_does_not_write_over_a_page_that_is_not_its_own(vvdp, here, sound_run):
    shutil.copytree(sound_run, here / "R", ignore=shutil.ignore_patterns("report.html", "figures"))
    listed = json.loads((here / "R" / LIST).read_text())
    listed["files"] = {name: entry for name, entry in listed["files"].items() if "page" not in entry}
    (here / "R" / LIST).write_text(json.dumps(listed))
    (here / "R" / "report.html").write_text("mine")
    answer = vvdp("report", "R")
    assert answer.code == 2 and f"report.html: {wording.directories.in_the_way}" in answer.err
    assert (here / "R" / "report.html").read_text() == "mine"


def test_pages_may_be_edited_or_gone_and_are_made_again(vvdp, here, run_here):
    before = content(run_here)
    (run_here / "report.html").write_text("edited")
    (run_here / "figures" / "run.svg").unlink()
    assert vvdp("report", "R").code == 0
    assert content(run_here) == before


def test_a_directory_without_a_list_is_told_as_such(vvdp, here, run_here):
    (run_here / LIST).unlink()
    answer = vvdp("report", "R")
    assert answer.code == 2 and wording.directories.earlier_version.format(list=LIST) in answer.err


def test_a_write_that_was_interrupted_is_told_and_can_be_repeated(tmp_path):
    with pytest.raises(KeyboardInterrupt), write_listed(tmp_path, ["a", "b"]):
        (tmp_path / "a").write_text("part")
        raise KeyboardInterrupt
    with pytest.raises(ConfigError, match=wording.directories.is_incomplete):
        open_directory(tmp_path)
    assert open_directory(tmp_path, resuming=True).files == {}
    with write_listed(tmp_path, ["a", "b"]):
        for name in "ab":
            (tmp_path / name).write_text("whole")
    assert sorted(open_directory(tmp_path).files) == ["a", "b"]
    (tmp_path / "a").unlink()
    with pytest.raises(ConfigError, match=wording.directories.is_missing):
        open_directory(tmp_path)
    assert sorted(open_directory(tmp_path, resuming=True).files) == ["b"]


def test_results_in_results_are_directories_of_their_own(tmp_path):
    with result_directory(tmp_path / "all") as folder:
        write_result(folder, a_result(), "")
        (folder / "3.9").mkdir()
        write_result(folder / "3.9", a_result(), "")
    with write_listed(tmp_path / "all" / "3.9", ["report.html"], pages=True):
        (tmp_path / "all" / "3.9" / "report.html").write_text("page")
    assert "3.9/curve.csv" not in open_directory(tmp_path / "all").files
    (tmp_path / "all" / "3.9" / "mine").write_text("mine")
    with (
        pytest.raises(ConfigError, match=wording.directories.foreign.format(name="3.9/mine")),
        result_directory(tmp_path / "all", force=True),
    ):
        pass
    (tmp_path / "all" / "3.9" / "mine").unlink()
    with result_directory(tmp_path / "all", force=True) as folder:
        (folder / "new").write_text("new")
    assert sorted(content(tmp_path / "all")) == ["new", LIST]


@pytest.mark.parametrize("verb", ["map", "study"])
def test_force_of_a_store_refuses_foreign_files(vvdp, here, verb):
    directory = here / "d"
    directory.mkdir()
    (directory / ("result.json" if verb == "map" else "study.json")).write_text("{}")
    (directory / "thesis.tex").write_text("thesis")
    (here / "s.toml").write_text('system = "buck-converter"\nuntil = "0.02 s"\n[grid]\n"supply.pressure" = ["1 bar"]\n')
    words = {
        "map": ("map", "prototype", "--analytic", "--duty", "0.25", "1", "2", "--pressure", "40 bar", "100 bar", "2"),
        "study": ("study", "s.toml"),
    }[verb]
    answer = vvdp(*words, "--out", "d", "--force")
    assert answer.code == 2, answer.err
    assert verb == "study" or "thesis.tex" in answer.err
    assert (directory / "thesis.tex").read_text() == "thesis"


# What a study keeps.


@pytest.fixture
def store(tmp_path: Path) -> Path:
    opened_store(tmp_path / "s", {})
    keep_finished(tmp_path / "s", [Finished("a", {}, None, {"power_W": 3.5})])
    return tmp_path / "s"


def test_a_study_is_set_aside_only_where_all_of_it_is_its_own(store):
    with set_aside(store, force=True):
        opened_store(store, {})
    assert finished_cases(store) == {}
    (store / "thesis.tex").write_text("thesis")
    with pytest.raises(ConfigError, match=r"thesis\.tex"), set_aside(store, force=True):
        pytest.fail("it was set aside")
    assert (store / "thesis.tex").is_file()


def test_a_kept_batch_that_was_edited_is_refused(store):
    (path,) = store.glob("cases-*.json")
    path.write_text(path.read_text().replace("3.5", "777.0"))
    with pytest.raises(ConfigError, match=wording.directories.has_changed):
        finished_cases(store)
    with pytest.raises(ConfigError, match=path.name), set_aside(store, force=True):
        pytest.fail("it was set aside")


@pytest.mark.parametrize("linked", [False, True])
def test_a_foreign_data_base_is_never_emptied(store, tmp_path, linked):
    foreign = tmp_path / "foreign.sqlite"
    base = sqlite3.connect(foreign)
    base.execute("create table files (mine text)")
    base.execute("insert into files values ('row')")
    base.commit()
    base.close()
    before = foreign.read_bytes()
    (store / NAME).unlink()
    if linked:
        (store / NAME).symlink_to(foreign)
        assert sorted(finished_cases(store)) == ["a"]
        with pytest.raises(ConfigError, match=wording.directories.is_link):
            opened_store(store, {})
    else:
        shutil.copy(foreign, store / NAME)
        assert sorted(opened_store(store, {})) == ["a"]
        assert (store / f"aside-{NAME}").read_bytes() == before
        assert read_index(store)
        assert (store / NAME).read_bytes()[68:72] == APPLICATION.to_bytes(4, "big")
    assert foreign.read_bytes() == before


def test_an_index_is_not_opened_with_a_journal_that_others_made(store):
    journal = store / f"{NAME}-journal"
    journal.write_bytes(b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7" + b"x" * 600)
    assert read_index(store) == {}
    os.utime(journal, (0, 0))
    assert sorted(opened_store(store, {})) == ["a"]
    assert (store / f"aside-{journal.name}").is_file() and not journal.exists()
    assert read_index(store)


def test_all_is_listed_with_rows_and_sums(sound_result):
    listed = json.loads((sound_result / LIST).read_text())["files"]
    assert listed["curve.csv"]["rows"] == 40 and len(listed["curve.csv"]["sha256"]) == 64
    assert listed["report.html"]["page"] is True
    assert set(listed) == {name for name in content(sound_result) if name != LIST}


def test_listing_passes_over_what_has_a_list_of_its_own(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "x").write_text("x")
    list_all(tmp_path / "in")
    list_all(tmp_path)
    assert sorted(read_list(tmp_path)) == [f"in/{LIST}"]


def test_a_computed_flow_is_replaced_only_where_all_of_it_is_known(tmp_path):
    from vvdp.cfd.series import make_place

    directory, outside = tmp_path / "flow", tmp_path / "outside"
    for name in ("case/state.json", "case/0/U", "case/12.5/U", "case-2/state.json", "case/log.simpleFoam", "case/stop"):
        (directory / name).parent.mkdir(parents=True, exist_ok=True)
        (directory / name).write_text("{}")
    outside.mkdir()
    (outside / "keep").write_text("keep")
    for name in ("thesis.tex", "case/thesis.tex", "case-old/log"):
        (directory / name).parent.mkdir(exist_ok=True)
        (directory / name).write_text("mine")
        make_place(directory, "cfd rail", force=False)
        with pytest.raises(ConfigError, match=wording.directories.foreign.format(name=name)):
            make_place(directory, "cfd rail", force=True)
        (directory / name).unlink()
    (directory / "case" / "constant").symlink_to(outside, target_is_directory=True)
    for force in (False, True):
        with pytest.raises(ConfigError, match=wording.directories.is_link):
            make_place(directory, "cfd rail", force=force)
    (directory / "case" / "constant").unlink()
    make_place(directory, "cfd rail", force=True)
    assert content(directory) == {} and content(outside) == {"keep": b"keep"}
