"""Items that an earlier, stopped run has calculated: a run into the same directory goes on from there."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import vvdp
from vvdp.base.kinds import Kind
from vvdp.base.manifest import Directory, as_damaged, open_directory
from vvdp.reproduction.item import Item, Reproduction
from vvdp.results.store import is_result, read_meta, read_result, write_json
from vvdp.results.verdict import Statement

FILE = "statements.json"
NUMBERS = ("low", "high", "found", "other", "tolerance")
"""Fields of a statement that may be infinite or nan, and stand as text for that."""


def write_statements(folder: Path, statements: Sequence[Statement]) -> None:
    """Writes what the statements of an item hold, so that a later run can take them over."""
    write_json(folder / FILE, {"statements": [_content(each) for each in statements]})


def stopped_items(directory: Path, items: Sequence[Item]) -> Mapping[str, Reproduction]:
    """Results of the `items`, by name, that a stopped run of this version into `directory` has calculated.

    Raises ConfigError if a file of it was changed or damaged.
    """
    if not is_result(directory) or read_result(directory).finished or read_meta(directory)["vvdp"] != vvdp.__version__:
        return {}
    folders = {item.name: directory / item.name for item in items if (directory / item.name / FILE).is_file()}
    return {name: Reproduction(statements=_read_statements(open_directory(path))) for name, path in folders.items()}


def take_over(directory: Path, folder: Path, names: Sequence[str]) -> None:
    """Copies the folders of items that were calculated already."""
    for name in names:
        shutil.copytree(directory / name, folder / name)


def _read_statements(directory: Directory) -> tuple[Statement, ...]:
    with as_damaged(directory.path):
        return tuple(_statement(each) for each in directory.json(FILE)["statements"])


def _content(statement: Statement) -> dict[str, Any]:
    content = {field.name: getattr(statement, field.name) for field in fields(statement)}
    numbers = {name: None if content[name] is None else repr(float(content[name])) for name in NUMBERS}
    kind = {field.name: getattr(statement.kind, field.name) for field in fields(statement.kind)}
    kind |= {"low": repr(statement.kind.low), "high": repr(statement.kind.high)}
    return content | numbers | {"kind": kind}


def _statement(content: Mapping[str, Any]) -> Statement:
    numbers = {name: None if content[name] is None else float(content[name]) for name in NUMBERS}
    kind = Kind(**content["kind"])
    kind = replace(kind, low=float(kind.low), high=float(kind.high), units=tuple(kind.units))
    pair = content["contradiction"]
    return Statement(
        **{**content, **numbers, "kind": kind, "contradiction": None if pair is None else (pair[0], pair[1])}
    )
