"""Result directories after accidents and with traps in them, opened by the commands that read any directory."""

import hashlib
import json
import os
import shutil
import sqlite3
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from tests.attack import trees
from tests.attack.cage import Reading
from tests.attack.fields import changed_table, command, seeded
from tests.logs import hostile
from tests.logs.files import mutate

TABLE = "flow [lpm],pressure drop [bar]\n10,0.51\n20,1.9\n40,7.2\n60,15.8\n"
MAP = ("--analytic", "--duty", "0.4", "0.6", "2", "--pressure", "20 bar", "40 bar", "2")
PAYLOAD = "from pathlib import Path\nPath({place!r}).write_text('ran')\ndef network(): pass\n"
CHANGED = "has changed since it was written"
"""What a command says of a directory that does not match its own list of files."""
REMADE = ("report.html", "figures")
"""What a report makes anew."""
LIST = "vvdp.json"
"""The list of files, which has no data of its own."""
Harm = Callable[[Path, Path, np.random.Generator], None]


@dataclass(frozen=True)
class Directories:
    """Directories of a run, a fit and a map, each with one accident or trap."""

    name: str = "result directories"
    files: int = 300

    def warm(self, folder: Path) -> None:
        """Makes the sound directories."""
        made = _sound(folder)
        made.mkdir()
        (made / "table.csv").write_text(TABLE)
        for words in (
            ("run", "buck-converter", "--until", "0.02 s"),
            ("fit", str(made / "table.csv"), "--law", "drop"),
            ("map", "prototype", *MAP),
        ):
            assert command(*words, "--no-report", "--out", str(made / words[0])) == 0

    def attack(self, seed: int, folder: Path) -> Reading:
        """Opens a harmed directory; nothing beside it may change, and what was changed in it must be noticed."""
        random = seeded(seed, self.name)
        verb = str(random.choice(("run", "fit", "map")))
        directory, outside = folder / verb, _outside(folder)
        for each in (directory, outside):
            shutil.rmtree(each, ignore_errors=True)
        shutil.copytree(_sound(folder) / verb, directory)
        outside.mkdir()
        (outside / "keep.svg").write_text("<svg/>")
        (outside / "secret.csv").write_text("a_Pa\n4242.125\n")
        before = _sums(directory)
        HARMS[int(random.integers(len(HARMS)))](directory, outside, random)
        after, others = _sums(directory), _sums(outside)
        return _opened(
            directory, any(before[name] != after.get(name) for name in before if name != LIST), outside, others
        )


def _opened(directory: Path, is_changed: bool, outside: Path, others: dict[str, str]) -> Reading:
    """What the commands say; the worst of their exit codes."""
    copy = directory.parent / "copy.csv"
    codes = [
        command("export", "data", str(directory), "--csv", str(copy), "--force"),
        command("plot", str(directory), "--list"),
        command("report", str(directory)),
    ]
    if _sums(outside) != others:
        return Reading(0, "files outside of the directory changed")
    if (directory / "thesis.tex").name in others and not (directory / "thesis.tex").is_file():
        return Reading(0, "a foreign file is gone")
    if copy.is_file() and "4242.125" in copy.read_text("utf-8"):
        return Reading(0, "foreign numbers were exported")
    if is_changed and 0 in codes and CHANGED not in (directory.parent / ".said").read_text("utf-8", "replace"):
        return Reading(0, "changed files were read without a word")
    return Reading(max(codes, key=lambda code: (code not in (0, 1, 2, 3), code)))


def _sound(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}-sound")


def _outside(folder: Path) -> Path:
    return folder / "outside"


def _sums(directory: Path) -> dict[str, str]:
    """Sums of all files but those that a report makes anew; "" for what is no file."""
    return {
        str(path.relative_to(directory)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        for path in sorted(directory.rglob("*"))
        if path.relative_to(directory).parts[0] not in REMADE
    }


def _any_file(directory: Path, random: np.random.Generator, pattern: str = "*") -> Path | None:
    found = [path for path in sorted(directory.rglob(pattern)) if path.is_file()]
    return found[int(random.integers(len(found)))] if found else None


def bytes_change(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """A file is damaged."""
    path = _any_file(directory, random)
    assert path is not None
    path.write_bytes(mutate(path.read_bytes(), random))


def entry_changes(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """An entry of a JSON file is another one, or elsewhere."""
    path = _any_file(directory, random, "*.json")
    assert path is not None
    path.write_text(json.dumps(trees.changed(json.loads(path.read_text("utf-8")), random), default=str), "utf-8")


def cell_changes(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """A cell of a table is another one."""
    if path := _any_file(directory, random, "*.csv"):
        path.write_text(changed_table(path.read_text("utf-8"), random), "utf-8")


def system_changes(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """The system is another one."""
    if path := _any_file(directory, random, "system.toml"):
        path.write_text(trees.toml(trees.changed(tomllib.loads(path.read_text("utf-8")), random)), "utf-8")


def file_goes(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """A file is gone, empty, a folder, or a pipe that nobody writes to."""
    path = _any_file(directory, random)
    assert path is not None
    path.unlink()
    match int(random.integers(4)):
        case 0:
            path.touch()
        case 1:
            path.mkdir()
        case 2:
            os.mkfifo(path)


def file_is_a_link(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """A file is a link to one elsewhere, `figures` a link to a folder of other people's pictures."""
    path = _any_file(directory, random)
    assert path is not None
    shutil.copy(path, outside / path.name)
    path.unlink()
    path.symlink_to(outside / path.name)
    (directory / "figures").symlink_to(outside)


def code_lies_there(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """The system names a module that lies in the directory, or elsewhere."""
    place = [directory, outside][int(random.integers(2))]
    (place / "payload.py").write_text(PAYLOAD.format(place=str(outside / "ran")))
    name = "payload" if place == directory else str(outside / "payload")
    if path := _any_file(directory, random, "system.toml"):
        path.write_text(f'circuit = "{name}:network"\n' + path.read_text("utf-8").replace("circuit =", "circuits ="))


def names_are_paths(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """Tables and charts are called like files elsewhere."""
    if path := _any_file(directory, random, "result.json"):
        content = json.loads(path.read_text("utf-8"))
        name = str(random.choice(["../outside/secret", str(outside / "secret"), "..", ".hidden", "a/b", "\x00"]))
        for table in list(content["tables"]):
            content["tables"][name] = {"columns": {"a_Pa": {"kind": "pressure_level", "label": "a", "symbol": "a"}}} | (
                content["tables"].pop(table) if random.integers(2) else {}
            )
        for chart in content["charts"].values():
            chart["name"] = name
        path.write_text(json.dumps(content))


def record_points_elsewhere(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """Series of a record lie in another file, hold themselves, or are of another length."""
    if path := _any_file(directory, random, "result.h5"):
        tricks = (hostile.external_link, hostile.external_storage, hostile.virtual, hostile.to_parent, hostile.nested,
                  hostile.soft_to_root, hostile.empty_giant, hostile.odd_kinds, hostile.bad_names)  # fmt: skip
        with h5py.File(path, "r+") as file:
            group = file[str(random.choice([name for name in file if isinstance(file[name], h5py.Group)] or ["/"]))]
            tricks[int(random.integers(len(tricks)))](group)


def series_is_cut(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """A series of a record has fewer values than its times."""
    if path := _any_file(directory, random, "result.h5"):
        with h5py.File(path, "r+") as file:
            names: list[str] = []
            file.visititems(lambda name, held: names.append(name) if isinstance(held, h5py.Dataset) else None)
            name = str(random.choice(names))
            values = file[name][()]
            del file[name]
            file[name] = values[: len(values) // 2] if np.ndim(values) else 0.0


def foreign_files_lie_there(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """Somebody has put a file and a picture of their own there."""
    (directory / "thesis.tex").write_text("mine")
    (directory / "figures").mkdir()
    (directory / "figures" / "mine.svg").write_text("<svg/>")


def index_is_foreign(directory: Path, outside: Path, random: np.random.Generator) -> None:
    """The index is a link to somebody's data base."""
    with sqlite3.connect(outside / "mine.sqlite") as base:
        base.execute("create table files (name text)")
        base.execute("insert into files values ('mine')")
    (directory / "index.sqlite").unlink(missing_ok=True)
    (directory / "index.sqlite").symlink_to(outside / "mine.sqlite")


HARMS: tuple[Harm, ...] = (
    bytes_change, bytes_change, bytes_change, entry_changes, entry_changes, cell_changes, system_changes, file_goes,
    file_is_a_link, code_lies_there, names_are_paths, record_points_elsewhere, series_is_cut, foreign_files_lie_there,
    index_is_foreign,
)  # fmt: skip
