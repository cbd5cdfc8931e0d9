"""A result on disk and back.

    result.json   what it is: title, manner, conditions, findings, numbers, listings, charts, columns of the tables
    NAME.csv      each table, a row for every point, SI; the names of the columns end with their units
    system.toml   the system as it was resolved
    meta.json     version, time, seconds, the command
    vvdp.json     the list of these files, with their sums (`base.manifest`)

Every number stands once: those of tables in their CSV files, all others in result.json.
"""

import csv
import io
import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from vvdp.base.errors import ConfigError, unusable
from vvdp.base.files import write_listed, write_whole
from vvdp.base.kinds import GAUGE_PRESSURE, Kind, kind_named
from vvdp.base.manifest import NAME, Directory, open_directory
from vvdp.base.version import VERSION
from vvdp.results.result import Column, Result, Table, plain_values

FORMAT = 1
DESCRIPTION = "result.json"
META = "meta.json"
GAUGE = " [gauge]"
T = TypeVar("T")


def write_result(
    folder: Path,
    result: Result,
    system: str,
    command: Sequence[str] = (),
    more: Mapping[str, object] = MappingProxyType({}),
) -> None:
    """Writes a result into `folder`, with the text of the resolved `system`; every file is complete or not there.

    `command` is what was typed, word by word; `more` is added to meta.json.
    """
    tables = {f"{name}.csv": table for name, table in result.tables.items()}
    with write_listed(folder, [*tables, *(["system.toml"] if system else []), DESCRIPTION, META]):
        for name, table in tables.items():
            write_whole(folder / name, table_text(table))
        if system:
            write_whole(folder / "system.toml", system)
        write_json(folder / DESCRIPTION, {"format": FORMAT, **_content(result)})
        meta = {"vvdp": VERSION, "written": time.strftime("%Y-%m-%dT%H:%M:%S%z"), "command": list(command)}
        write_json(folder / META, meta | dict(more))


def is_result(directory: Path) -> bool:
    """Whether a study has left its result in `directory`."""
    return (directory / DESCRIPTION).is_file()


def read_result(place: Path | Directory) -> Result:
    """The content of a directory that a study has written. Raises ConfigError where it is none, changed, or damaged."""
    directory = open_directory(place)
    content = directory.json(DESCRIPTION)
    if content.get("format") != FORMAT:
        raise unusable(directory.path, f"was written in format {content.get('format')}; this version reads {FORMAT}")
    try:
        _check_names(content["tables"], content["charts"])
        for name, table in content["tables"].items():
            table["columns"] = _columns(directory.file(f"{name}.csv"), table["columns"])
        result: Result = _value(Result, content)
        _check_names([chart.name for chart in result.charts.values()])
        return result
    except ConfigError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError, StopIteration, csv.Error) as problem:
        raise unusable(directory.path, f"is damaged: {problem}") from None


def _check_names(*groups: Iterable[str]) -> None:
    """Raises ValueError where a table or chart has a name that could not be the name of a file in its directory."""
    for name in (name for group in groups for name in group):
        if not NAME.fullmatch(name):
            raise ValueError(f"{name!r} names a table or chart; expected letters, digits, '_', '-' and '.'")


def read_meta(place: Path | Directory) -> Mapping[str, object]:
    """When, by what version and by which command a directory was written. Raises ConfigError where it does not say."""
    directory = open_directory(place)
    meta = directory.json(META)
    command = meta.get("command", [])
    if not isinstance(command, list) or not all(isinstance(word, str) for word in command):
        raise unusable(directory.path / META, "is damaged: command is not a list of words")
    return meta


def add_labels(directory: Path, labels: Mapping[str, str]) -> None:
    """Adds what is known of a result besides its numbers, such as project and customer; empty ones change nothing.

    Raises ConfigError where the directory holds no result.
    """
    meta = {**read_meta(directory), **{name: text for name, text in labels.items() if text}}
    with write_listed(directory, [META]):
        write_json(directory / META, meta)


def table_text(table: Table) -> str:
    """A table as CSV; an empty cell stands for what is not known."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([key + GAUGE * (column.kind is GAUGE_PRESSURE) for key, column in table.columns.items()])
    for row in zip(*map(plain_values, table.columns.values()), strict=True):
        writer.writerow(map(_cell, row))
    return text.getvalue()


def _cell(value: float | str) -> str:
    if isinstance(value, str):
        return value
    return "" if math.isnan(value) else repr(value)


def write_json(path: Path, content: Mapping[str, object]) -> None:
    """Writes JSON; a number that is not finite becomes null."""
    write_whole(path, json.dumps(finite(content), indent=1, allow_nan=False) + "\n")


def finite(value: Any) -> Any:
    """`value` as JSON can hold it: a number that is not finite becomes null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value


def _content(value: Any) -> Any:
    """A record as JSON holds it; kinds by name, columns without their values."""
    if isinstance(value, Kind):
        return {field.name: getattr(value, field.name) for field in fields(value)} if _is_own(value) else value.name
    if isinstance(value, Column):
        return {"kind": _content(value.kind), "label": value.label, "symbol": value.symbol}
    if is_dataclass(value):
        return {field.name: _content(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {key: _content(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_content(item) for item in value]
    return value


def _is_own(kind: Kind) -> bool:
    return kind_named(kind.name) is not kind


def _columns(path: Path, described: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a table from its CSV file, beside the description of their columns."""
    with path.open(encoding="utf-8", newline="") as file:
        heads, *rows = csv.reader(file)
    cells = dict(zip((head.removesuffix(GAUGE) for head in heads), zip(*rows, strict=True), strict=bool(rows)))
    return {key: column | {"values": cells.get(key, ())} for key, column in described.items()}


def _value(wanted: Any, content: Any) -> Any:
    """Value of the type `wanted`, from the content that `_content` made of it."""
    origin, inner = get_origin(wanted), get_args(wanted)
    if wanted is Kind:
        return kind_named(content) if isinstance(content, str) else Kind(**content | {"units": tuple(content["units"])})
    if wanted is Column:
        return _column(content)
    if origin in (Union, UnionType):
        return _choose_type(inner, content)
    if origin is tuple:
        return tuple(_value(inner[0], item) for item in content)
    if origin is not None and issubclass(origin, Mapping):
        return {key: _value(inner[1], item) for key, item in content.items()}
    if isinstance(wanted, type) and is_dataclass(wanted):
        hints = get_type_hints(wanted)
        return wanted(**{f.name: _value(hints[f.name], content[f.name]) for f in fields(wanted) if f.init})
    if isinstance(wanted, type) and issubclass(wanted, StrEnum):
        return wanted(content)
    return _plain(wanted, content)


def _plain(wanted: Any, content: Any) -> Any:
    """A number, flag or text of the type `wanted`, nan for a number that is not known. Raises ValueError."""
    if wanted is float and content is None:
        return math.nan
    fitting = (int, float) if wanted is float else wanted
    if wanted in (bool, int, float, str) and (
        not isinstance(content, fitting) or isinstance(content, bool) != (wanted is bool)
    ):
        raise ValueError(f"{content!r} is given; expected a value of type {wanted.__name__}")
    return content


def _choose_type(types: Sequence[Any], content: Any) -> Any:
    """The one of several types that fits: None, a plain value, or the record that has all of these fields."""
    if content is None:
        return None if type(None) in types else math.nan
    if isinstance(content, str | float | int) and Kind not in types:
        return content
    if Kind in types:
        return _value(Kind, content)
    fitting = (each for each in types if is_dataclass(each) and {f.name for f in fields(each)} == content.keys())
    return _value(next(fitting), content)


def _column(content: Mapping[str, Any]) -> Column:
    kind = None if content["kind"] is None else _value(Kind, content["kind"])
    cells = content["values"]
    values = np.array(cells, str) if kind is None else np.array([float(cell or "nan") for cell in cells])
    return Column(values, kind, content["label"], content["symbol"])
