"""A result on disk and back.

    result.json   what it is: title, manner, conditions, findings, numbers, listings, charts, columns of the tables
    NAME.csv      each table, a row for every point, SI; the names of the columns end with their units
    system.toml   the system as it was resolved
    meta.json     version, time, seconds, the command

Every number stands once: those of tables in their CSV files, all others in result.json.
"""

import csv
import io
import json
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

import vvdp
from vvdp.base.errors import ConfigError, unusable
from vvdp.base.files import write_whole
from vvdp.base.kinds import GAUGE_PRESSURE, Kind, kind_named
from vvdp.results.result import Column, Result, Table, plain_values

FORMAT = 1
DESCRIPTION = "result.json"
GAUGE = " [gauge]"
T = TypeVar("T")


def write_result(
    folder: Path,
    result: Result,
    system: str,
    command: Sequence[str] = (),
    more: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Writes a result into `folder`, with the text of the resolved `system`; every file is whole or absent.

    `command` is what was typed, word by word; `more` is added to meta.json.
    """
    for name, table in result.tables.items():
        write_whole(folder / f"{name}.csv", table_text(table))
    if system:
        write_whole(folder / "system.toml", system)
    write_json(folder / DESCRIPTION, {"format": FORMAT, **_content(result)})
    meta = {"vvdp": vvdp.__version__, "written": time.strftime("%Y-%m-%dT%H:%M:%S%z"), "command": list(command)}
    write_json(folder / "meta.json", meta | dict(more))


def is_result(directory: Path) -> bool:
    """Whether a study has left its result in `directory`."""
    return (directory / DESCRIPTION).is_file()


def read_result(directory: Path) -> Result:
    """The content of a directory that a study has written. Raises ConfigError where it is none, or damaged."""
    if not directory.is_dir():
        raise unusable(directory, "is not a directory" if directory.exists() else "no such directory")
    if not is_result(directory):
        raise unusable(directory, f"holds no result: {DESCRIPTION} missing")
    try:
        content = json.loads((directory / DESCRIPTION).read_text("utf-8"))
        if content["format"] != FORMAT:
            raise unusable(directory, f"was written in format {content['format']}; this version reads {FORMAT}")
        for name, table in content["tables"].items():
            table["columns"] = _columns(directory / f"{name}.csv", table["columns"])
        result: Result = _value(Result, content)
        return result
    except ConfigError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as problem:
        raise unusable(directory, f"is damaged: {problem}") from None


def read_meta(directory: Path) -> Mapping[str, Any]:
    """When, by what version and by which command a directory was written. Raises ConfigError where it does not say."""
    try:
        meta: Mapping[str, Any] = json.loads((directory / "meta.json").read_text("utf-8"))
        return meta
    except (OSError, ValueError) as problem:
        raise unusable(directory, f"is damaged: meta.json: {problem}") from None


def add_labels(directory: Path, labels: Mapping[str, str]) -> None:
    """Adds what is known of a result besides its numbers, such as project and customer; empty ones change nothing.

    Raises ConfigError where the directory holds no result.
    """
    write_json(
        directory / "meta.json", {**read_meta(directory), **{name: text for name, text in labels.items() if text}}
    )


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


def write_json(path: Path, content: Mapping[str, Any]) -> None:
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
    """What `_content` had of the type `wanted`."""
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
    return math.nan if content is None and wanted is float else content


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
