"""The list of the files that vvdp wrote into a directory: by it a directory is opened, replaced and cleaned.

    vvdp.json   {"vvdp_files": 1, "files": {PATH: {"bytes": N, "sha256": TEXT, "rows": N, "page": BOOL}}}

A directory comes from anywhere, so nothing in it is believed: names are plain, links are refused, and every file is
compared with the list before anything of it is used. A *page* is made from the other files and may be made again, so it
may differ or be absent. A file without a sum is being written, or was when its command was interrupted. A folder with a
list of its own is a directory of its own. `base.files` writes the list.
"""

import hashlib
import json
import os
import re
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from vvdp.base.errors import VvdpError, unusable

LIST = "vvdp.json"
FORMAT = 1
NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")
"""The names that tables, charts, files and folders of a result may have: no path, and nothing hidden."""
MOST_NAMED = 8
"""Files that one message names."""


class Entry(NamedTuple):
    """A file as it was written; without `sha256` it is not whole yet."""

    size: int = 0
    sha256: str = ""
    rows: int | None = None
    """Of a table: lines below its head."""
    is_page: bool = False


@dataclass(frozen=True)
class Directory:
    """A directory whose files are as vvdp wrote them; only what is listed can be read."""

    path: Path
    files: Mapping[str, Entry]

    def file(self, name: str) -> Path:
        """The path of a listed file. Raises ConfigError for any other."""
        if name not in self.files:
            raise unusable(self.path, f"is not a result directory of this kind: {name} missing from its list, {LIST}")
        return self.path / name

    def text(self, name: str) -> str:
        """The text of a listed file. Raises ConfigError where there is none."""
        try:
            return self.file(name).read_text("utf-8")
        except (OSError, UnicodeDecodeError) as problem:
            raise unusable(self.path / name, f"is damaged: {problem}") from None

    def json(self, name: str) -> dict[str, Any]:
        """The object in a listed JSON file. Raises ConfigError where it holds none."""
        return parsed_json(self.text(name), self.path / name)


def parsed_json(text: str, path: Path) -> dict[str, Any]:
    """The object that a JSON `text` holds. Raises ConfigError, naming `path`, where it holds none."""
    try:
        found = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as problem:
        raise unusable(path, f"is damaged: {problem}") from None
    if not isinstance(found, dict):
        raise unusable(path, "is damaged: expected a JSON object")
    return found


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a number in JSON")


def open_directory(place: Path | Directory, *, resuming: bool = False) -> Directory:
    """The directory at `place`, every file of it compared with its list; one that is open already stays as it is.

    With `resuming`, files that are missing, or that an interrupted command left unfinished, are passed over: they are
    about to be written. Raises ConfigError where there is no list, and for the first file that is a link, missing,
    incomplete or changed.
    """
    if isinstance(place, Directory):
        return place
    if not place.is_dir():
        raise unusable(place, "is not a directory" if os.path.lexists(place) else "no such directory")
    files = read_list(place)
    if resuming:
        files = {name: entry for name, entry in files.items() if entry.sha256 and os.path.lexists(place / name)}
    if not has_list(place):
        raise unusable(
            place, f"is not a result directory: it holds no result, or one of an earlier version; {LIST} missing"
        )
    for name, entry in files.items():
        fault = kind_fault(place, name) if entry.is_page else _fault(place, name, entry)
        if fault:
            raise unusable(place / name, f"{fault}; restore it, or make the result again")
    return Directory(place, files)


@contextmanager
def as_damaged(directory: Path) -> Iterator[None]:
    """While something is made from a directory that may come from anyone: what does not fit becomes a ConfigError."""
    try:
        yield
    except VvdpError:
        raise
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RuntimeError) as problem:
        raise unusable(directory, f"is damaged or not complete: {type(problem).__name__}: {problem}") from None


def has_list(directory: Path) -> bool:
    """Whether vvdp has listed its files in `directory`."""
    return os.path.lexists(directory / LIST)


def read_list(directory: Path) -> dict[str, Entry]:
    """The files that vvdp listed in `directory`, by path; none where there is no list.

    Raises ConfigError where the list is no plain file, damaged, or names what lies elsewhere.
    """
    path = directory / LIST
    if not has_list(directory):
        return {}
    if fault := kind_fault(directory, LIST):
        raise unusable(path, fault)
    content = parsed_json(path.read_text("utf-8", "replace"), path)
    if content.get("vvdp_files") != FORMAT:
        raise unusable(path, f"is not a list of this version of vvdp, which reads format {FORMAT}; run it again")
    files = content.get("files")
    if not isinstance(files, dict):
        raise unusable(path, "is damaged: it lists no files")
    return {name: _read_entry(path, name, each) for name, each in files.items()}


def list_text(files: Mapping[str, Entry]) -> str:
    """The text of a list."""
    entries = {
        name: {
            "bytes": each.size,
            "sha256": each.sha256,
            **({} if each.rows is None else {"rows": each.rows}),
            **({"page": True} if each.is_page else {}),
        }
        for name, each in sorted(files.items())
    }
    return json.dumps({"vvdp_files": FORMAT, "files": entries}, indent=1) + "\n"


def entry_of(path: Path, *, is_page: bool = False) -> Entry:
    """The entry of a file as it is now."""
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        size = file.tell()
        file.seek(0)
        rows = sum(1 for _ in file) - 1 if path.suffix == ".csv" else None
    return Entry(size, digest, rows, is_page)


def kind_fault(directory: Path, name: str) -> str:
    """Why a file below `directory` is not followed: a link on the way, no plain file; empty where it may, or is absent.

    Links are refused since their author would choose what is read or written elsewhere.
    """
    *folders, _ = parts = name.split("/")
    for count in range(1, len(parts) + 1):
        try:
            mode = (directory.joinpath(*parts[:count])).lstat().st_mode
        except FileNotFoundError:
            return ""
        if stat.S_ISLNK(mode):
            return "is a link, which is not followed" if count > len(folders) else "lies behind a link"
        if not (stat.S_ISREG(mode) if count > len(folders) else stat.S_ISDIR(mode)):
            return "is not a plain file"
    return ""


def refuse_links(folder: Path) -> None:
    """Raises ConfigError where anything in `folder`, or itself, is a link or no plain file."""
    for path in (folder, *tree(folder)):
        if path.is_symlink() or not (path.is_dir() or path.is_file()):
            raise unusable(path, "is a link or not a plain file, which is not followed")


def tree(folder: Path) -> Iterator[Path]:
    """Everything below `folder` but folders; links are not followed."""
    for path in sorted(folder.iterdir()):
        if path.is_dir() and not path.is_symlink():
            yield from tree(path)
        else:
            yield path


def never(path: Path) -> bool:
    """Says of no file that vvdp knows it without a list."""
    return False


def refuse_foreign(directory: Path, named: Path, is_own: Callable[[Path], bool] = never) -> None:
    """Raises ConfigError where `directory` holds anything that vvdp did not write, or that has changed since.

    named   what the directory is called in messages
    is_own  reports a file that is not listed whether vvdp wrote it
    """
    foreign = list(_foreign(directory, is_own))
    if foreign:
        more = f" and {len(foreign) - MOST_NAMED} more" if len(foreign) > MOST_NAMED else ""
        words = ", ".join(foreign[:MOST_NAMED]) + more
        raise unusable(
            named, f"holds something else than results of vvdp: {words}; move that away, or choose another directory"
        )


def _foreign(directory: Path, is_own: Callable[[Path], bool]) -> Iterator[str]:
    files = read_list(directory)
    nested = [name.removesuffix(f"/{LIST}") for name in files if name.endswith(f"/{LIST}")]
    for path in tree(directory):
        name = path.relative_to(directory).as_posix()
        if name in (LIST, *nested) or any(name.startswith(f"{folder}/") for folder in nested):
            continue
        if fault := kind_fault(directory, name):
            yield f"{name} ({fault})"
        elif name not in files and not is_own(path):
            yield name
        elif name in files and files[name].sha256 and (fault := _fault(directory, name, files[name])):
            yield f"{name} ({fault})"
    for folder in nested:
        if (directory / folder).is_dir() and not kind_fault(directory, f"{folder}/{LIST}"):
            yield from (f"{folder}/{name}" for name in _foreign(directory / folder, never))


def _fault(directory: Path, name: str, entry: Entry) -> str:
    """Why a file is not what was written; empty where it is."""
    path = directory / name
    if fault := kind_fault(directory, name):
        return fault
    if not entry.sha256:
        return "is not complete: the command that writes it was interrupted"
    if name.endswith(f"/{LIST}"):
        return ""
    if not path.exists():
        return "is missing; the directory has changed since it was written"
    now = entry_of(path)
    if now[:2] == entry[:2]:
        return ""
    rows = "" if entry.rows is None else f" ({now.rows} rows, {entry.rows} when written)"
    return f"has changed since it was written{rows}"


def _read_entry(path: Path, name: str, content: Any) -> Entry:
    fits = (
        all(NAME.fullmatch(part) for part in name.split("/"))
        and isinstance(content, dict)
        and type(content.get("bytes")) is int
        and isinstance(content.get("sha256"), str)
        and isinstance(content.get("rows"), int | None)
        and isinstance(content.get("page", False), bool)
    )
    if not fits:
        raise unusable(path, f"is damaged at {name!r}: no plain name, or no entry of vvdp")
    return Entry(content["bytes"], content["sha256"], content.get("rows"), content.get("page", False))
