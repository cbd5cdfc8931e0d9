"""What every test rig leaves: tables, the conditions they were made under, and what was left out; on disk and back.

rig.json      what it is: title, manner, conditions, what was left out, findings, columns
NAME.csv      each table, a row for every point; the names of the columns end with their units
numbers.json  the figures that it comes to, flat, SI
system.toml   the system as it was resolved
meta.json     version, time, seconds
"""

import csv
import io
import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import vvdp
from vvdp.base.errors import ConfigError, unusable
from vvdp.base.files import write_whole

FORMAT = 1


@dataclass(frozen=True)
class Column:
    """One quantity over all rows of a table; `label` is what a person reads."""

    values: npt.NDArray[np.float64] | npt.NDArray[np.str_]
    unit: str
    label: str


@dataclass(frozen=True)
class Sheet:
    """A table: columns of one length."""

    title: str
    columns: Mapping[str, Column]

    def __getitem__(self, name: str) -> Any:
        """The values of a column."""
        return self.columns[name].values

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())).values) if self.columns else 0


@dataclass(frozen=True)
class RigResult:
    """What a rig found. `references` are keys of the bibliography, `findings` whole sentences."""

    rig: str
    title: str
    system: str
    manner: str
    references: tuple[str, ...]
    conditions: Mapping[str, str]
    left_out: tuple[str, ...]
    sheets: Mapping[str, Sheet]
    numbers: Mapping[str, float] = field(default_factory=dict)
    findings: tuple[str, ...] = ()
    seconds: float = 0.0
    finished: bool = True

    @property
    def flat(self) -> dict[str, Any]:
        """All numbers as one flat table: the figures, then every column, prefixed where there are several sheets."""
        found: dict[str, Any] = {"rig": self.rig, "system": self.system, **self.numbers}
        for name, sheet in self.sheets.items():
            prefix = f"{name}_" if len(self.sheets) > 1 else ""
            found |= {f"{prefix}{key}": column.values.tolist() for key, column in sheet.columns.items()}
        return found


def write_rig(folder: Path, result: RigResult, system: str) -> None:
    """Writes a result into `folder`, with the text of the resolved `system`; every file is whole or absent."""
    for name, sheet in result.sheets.items():
        write_whole(folder / f"{name}.csv", sheet_text(sheet))
    write_whole(folder / "system.toml", system)
    write_whole(folder / "numbers.json", _json(dict(result.numbers)))
    content = {
        "format": FORMAT,
        "rig": result.rig,
        "title": result.title,
        "system": result.system,
        "manner": result.manner,
        "references": result.references,
        "conditions": result.conditions,
        "left_out": result.left_out,
        "findings": result.findings,
        "finished": result.finished,
        "sheets": {
            name: {
                "title": sheet.title,
                "columns": {
                    key: {"unit": c.unit, "label": c.label, "values": c.values.tolist()}
                    for key, c in sheet.columns.items()
                },
            }
            for name, sheet in result.sheets.items()
        },
    }
    write_whole(folder / "rig.json", _json(content))
    meta = {
        "format": FORMAT,
        "vvdp": vvdp.__version__,
        "rig": result.rig,
        "written": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "seconds": result.seconds,
    }
    write_whole(folder / "meta.json", _json(meta))


def read_rig(directory: Path) -> RigResult:
    """The content of a directory that a rig has written. Raises ConfigError where it is none, or damaged."""
    if not directory.is_dir():
        raise unusable(directory, "is not a directory" if directory.exists() else "no such directory")
    if not (directory / "rig.json").is_file():
        raise unusable(directory, "is not the result of a rig: rig.json missing")
    try:
        content = json.loads((directory / "rig.json").read_text("utf-8"))
        numbers = json.loads((directory / "numbers.json").read_text("utf-8"))
        meta = json.loads((directory / "meta.json").read_text("utf-8"))
        if content["format"] != FORMAT:
            raise unusable(directory, f"was written in format {content['format']}; this version reads {FORMAT}")
        sheets = {
            name: Sheet(
                sheet["title"],
                {key: Column(_array(c["values"]), c["unit"], c["label"]) for key, c in sheet["columns"].items()},
            )
            for name, sheet in content["sheets"].items()
        }
        return RigResult(
            rig=content["rig"],
            title=content["title"],
            system=content["system"],
            manner=content["manner"],
            references=tuple(content["references"]),
            conditions=content["conditions"],
            left_out=tuple(content["left_out"]),
            sheets=sheets,
            numbers={key: math.nan if value is None else value for key, value in numbers.items()},
            findings=tuple(content["findings"]),
            seconds=meta["seconds"],
            finished=content["finished"],
        )
    except ConfigError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as problem:
        raise unusable(directory, f"is damaged: {problem}") from None


def _array(values: list[Any]) -> Any:
    if any(isinstance(value, str) for value in values):
        return np.array([str(value) for value in values])
    return np.array([np.nan if value is None else value for value in values], float)


def _json(content: Mapping[str, Any]) -> str:
    return json.dumps(_finite(content), indent=1, allow_nan=False) + "\n"


def _finite(value: Any) -> Any:
    """`value` as JSON can hold it: a number that is not finite becomes null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def sheet_text(sheet: Sheet) -> str:
    """A table as CSV; an empty cell stands for what is not known."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name} [gauge]" if c.unit == "Pa gauge" else name for name, c in sheet.columns.items()])
    for row in zip(*(c.values for c in sheet.columns.values()), strict=True):
        writer.writerow([_written(value) for value in row])
    return text.getvalue()


def _written(value: Any) -> str:
    if isinstance(value, str):
        return str(value)
    return "" if math.isnan(value) else repr(float(value))
