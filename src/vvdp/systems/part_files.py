"""Files of parts: where one is found, and what it offers to the file that uses it: ports and values."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.tables import Table, nearest, parsed_table, read_table, suggestion

NODES, COMPONENTS, PROGRAMS = GROUPS = "nodes", "components", "programs"
"""Tables whose names share one space: no two entries have the same one."""
PARTS, VALUES, DRAWN = "parts", "values", "drawn"
PORT = "port"
"""Type of a node that the using file provides."""
TABLES_OF_A_PART = ("title", *GROUPS, PARTS, VALUES)
WORDS = ("file", "type", "at", DRAWN)
"""Keys of a use that are neither ports nor values."""


@dataclass(frozen=True)
class PartFile:
    """The text of a part and what it is called; `path` is None where it is shipped."""

    name: str
    table: Table
    path: Path | None = None

    @property
    def folder(self) -> Path:
        """The folder from which files that it names are found."""
        return Path() if self.path is None else self.path.parent

    @property
    def identity(self) -> str:
        """What distinguishes it from all other files."""
        return self.name if self.path is None else str(self.path.resolve())

    @property
    def ports(self) -> tuple[str, ...]:
        """Names of its ports."""
        return ports_of(self.table.content)

    @property
    def values(self) -> Mapping[str, tuple[str, ...]]:
        """What each of its values sets: paths in the file."""
        given = self.table.content.get(VALUES, {})
        return {name: targets_of(entry) for name, entry in given.items()} if isinstance(given, Mapping) else {}


def ports_of(content: Mapping[str, object]) -> tuple[str, ...]:
    """Names of the nodes of a file that are ports."""
    nodes = content.get("nodes", {})
    given = nodes.items() if isinstance(nodes, Mapping) else ()
    return tuple(name for name, node in given if isinstance(node, Mapping) and node.get("type") == PORT)


def targets_of(entry: Any) -> tuple[str, ...]:
    """The paths that an entry of [values] sets; empty where it gives none."""
    sets = entry.get("sets", ()) if isinstance(entry, Mapping) else entry
    found = (sets,) if isinstance(sets, str) else sets
    return tuple(found) if isinstance(found, list | tuple) and all(isinstance(each, str) for each in found) else ()


def shipped_parts() -> dict[str, str]:
    """Names of the shipped parts and their texts."""
    folder = resources.files("vvdp.systems") / PARTS
    files = sorted((each for each in folder.iterdir() if each.name.endswith(".toml")), key=lambda each: each.name)
    return {each.name.removesuffix(".toml"): each.read_text("utf-8") for each in files}


def shipped_part(name: str) -> PartFile:
    """The shipped part of that name. Raises ParameterError where there is none."""
    texts = shipped_parts()
    if name not in texts:
        raise ParameterError(f"{name!r} is no shipped part{nearest(name, texts)}")
    return PartFile(name, parsed_table(texts[name], f"{name}.toml"))


def find_part(entry: Mapping[str, object], folder: Path) -> PartFile:
    """The file of a part that an entry of [parts] names, by type or by a path from `folder`.

    Raises ParameterError where it names none or there is none, ConfigError where the file cannot be read.
    """
    match entry:
        case {"file": str(name), **rest} if "type" not in rest:
            path = folder / name
            if not path.is_file():
                raise ParameterError(f"no file {name!r} in {folder}{_other_files(path)}")
            return PartFile(name, read_table(path), path)
        case {"type": str(name), **rest} if "file" not in rest:
            return shipped_part(name)
    example = next(iter(shipped_parts()), "pump-unit")
    raise ParameterError(f'expected one of file = "....toml" and type = "{example}"')


def _other_files(path: Path) -> str:
    """The end of a message about a `path` that leads nowhere: a file beside it, or a shipped part, perhaps meant."""
    near = suggestion(path.name, [each.name for each in path.parent.glob("*.toml")])
    shipped = suggestion(path.stem, shipped_parts()).removeprefix("; did you mean ")
    return near or (f"; did you mean the shipped part, type = {shipped}" if shipped else "")


def used_files(content: Mapping[str, object], folder: Path) -> Iterator[tuple[Path, Path]]:
    """The files of parts that a circuit in `folder` needs: each as it is named from there, and where it is.

    Raises ParameterError, ConfigError where one cannot be read.
    """
    uses = content.get(PARTS, {})
    for entry in uses.values() if isinstance(uses, Mapping) else ():
        file = find_part(entry, folder)
        if file.path is not None:
            named = Path(file.name)
            yield named, file.path
            yield from ((named.parent / each, path) for each, path in used_files(file.table.content, file.folder))


def read_used_part(entry: Mapping[str, object], folder: Path) -> PartFile:
    """As `find_part`, with unreadable files as ParameterError too: the place of the use is then what counts."""
    try:
        return find_part(entry, folder)
    except ConfigError as problem:
        raise ParameterError(str(problem)) from None
