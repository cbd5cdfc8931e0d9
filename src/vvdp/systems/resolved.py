"""A system written out again: TOML that loads to the same case, every entry with its origin, settings included."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from vvdp.base.tables import ORIGIN, Sourced
from vvdp.systems.drawing import TABLES
from vvdp.systems.system import System


def resolved_text(system: System) -> str:
    """The system as TOML that loads to the same case: every entry with its origin, settings included."""
    rows = {f"{row.table}.{row.key}": row for row in system.rows}
    headings = {"title": system.title, **{k: v for k, v in system.content.items() if not isinstance(v, Mapping)}}
    lines = [f"{key} = {_toml(value)}" for key, value in headings.items()]
    for name, part in system.content.items():
        if isinstance(part, Mapping):
            lines += _table_lines(name, part, rows)
            if name == "run" and "method" not in part:
                lines.append(f"method = {_toml(system.stepping.method.name.lower())}")
    return "\n".join(lines) + "\n"


def _table_lines(path: str, part: Mapping[str, object], rows: Mapping[str, Sourced]) -> Iterator[str]:
    """A table, its own entries first, then the tables in it."""
    inner = {k: v for k, v in part.items() if isinstance(v, Mapping) and f"{path}.{k}" not in rows and "." not in k}
    inner = {key: value for key, value in inner.items() if _is_table(f"{path}.{key}", rows)}
    own = {key: value for key, value in part.items() if key not in inner}
    if own or not inner:
        yield ""
        yield f"[{'.'.join(map(_toml_key, path.split('.')))}]"
    for key, entry in own.items():
        yield f"{_toml_key(key)} = {_toml(_with_origin(entry, rows.get(f'{path}.{key}')))}"
    for key, value in inner.items():
        yield from _table_lines(f"{path}.{key}", value, rows)


def _is_table(path: str, rows: Mapping[str, Sourced]) -> bool:
    """Whether a mapping is a table of its own: nodes, components and the like all are, for they keep their order."""
    above, _, name = path.partition(".")
    return (above in TABLES and "." not in name) or any(row.startswith(f"{path}.") for row in rows)


def _with_origin(entry: Any, row: Sourced | None) -> Any:
    if row is None:
        return entry
    given = dict(entry) if isinstance(entry, Mapping) else {"value": entry}
    value = {word: content for word, content in given.items() if word not in ORIGIN}
    return value | {word: getattr(row, word) for word in ORIGIN if getattr(row, word)}


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml(key)


def _toml(value: Any) -> str:
    """One TOML value: text, number, list or inline table."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_toml_key(key)} = {_toml(content)}" for key, content in value.items()) + " }"
    return "[" + ", ".join(_toml(content) for content in value) + "]"
