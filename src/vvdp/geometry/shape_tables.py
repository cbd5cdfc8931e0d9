"""Shapes as tables [geometry]: the prototype's, shipped variants of it, those of a file, of a system, of settings."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import LENGTH
from vvdp.base.params import field_kinds
from vvdp.base.tables import Sourced, Table, build, parsed_table, read_table, refuse_unknown, suggestion, with_settings
from vvdp.geometry.makeable import contradictions
from vvdp.geometry.shape import ValveShape
from vvdp.valve.rotary import RotaryValve

NAME = "geometry"
"""Name of the table of a shape, in a file of its own as in a system's."""
PROTOTYPE_RADIUS = 12.7e-3
"""The spool radius [m] that the shipped lengths belong to."""


class SourcedShape(NamedTuple):
    """A shape, and where each of its values comes from."""

    shape: ValveShape
    rows: tuple[Sourced, ...]


def shipped_shapes() -> dict[str, str]:
    """Names of the shipped variants of the prototype's shape, and their texts."""
    folder = resources.files("vvdp.geometry") / "shapes"
    return {f.name.removesuffix(".toml"): f.read_text("utf-8") for f in sorted(folder.iterdir(), key=lambda f: f.name)}


@cache
def prototype_table() -> Table:
    """The shipped table of shapes, with the origin of each value."""
    text = (resources.files("vvdp.geometry") / "prototype.toml").read_text("utf-8")
    return parsed_table(text, "prototype.toml")


def read_shape(
    valve: RotaryValve, given: Mapping[str, object], origin: Table, faults: list[Fault]
) -> SourcedShape | None:
    """The shape for a valve, makeable or not: values `given` as a table holds them, all others as shipped.

    Shipped lengths are in proportion to the spool radius. Faults are appended; the shape is None where there are any.
    """
    shape, rows = build(ValveShape, {**prototype_table().content[NAME], **given}, NAME, origin, faults)
    if shape is None:
        return None
    factor = valve.spool_radius / PROTOTYPE_RADIUS
    if abs(factor - 1.0) > 1e-12:
        scaled = {key for key, kind in field_kinds(ValveShape).items() if kind is LENGTH and key not in given}
        shape = replace(shape, **{key: factor * getattr(shape, key) for key in scaled})
        rows = [_scale(row, factor) if row.key in scaled else row for row in rows]
    return SourcedShape(shape, tuple(rows))


def _scale(row: Sourced, factor: float) -> Sourced:
    assert isinstance(row.value, float)
    note = f"{row.note}; " if row.note else ""
    return replace(row, value=factor * row.value, note=f"{note}{factor:.4g} times the prototype's")


def valve_shape(
    valve: RotaryValve, given: Mapping[str, object] | None = None, origin: Table | None = None
) -> SourcedShape:
    """The shape for a valve as `read_shape` has it. Raises ConfigError with all faults, and where none can be made."""
    faults: list[Fault] = []
    origin = origin or prototype_table()
    found = read_shape(valve, given or {}, origin, faults)
    if found is not None:
        faults = [Fault(NAME, 0, "", message) for message in contradictions(found.shape, valve)]
    if found is None or faults:
        raise ConfigError(faults)
    return found


def given_shape(
    valve: RotaryValve, file: str | None, settings: Sequence[str], own: Mapping[str, object] | None = None
) -> SourcedShape:
    """The shape for a valve: its `own` table, over it a shape by shipped name or path, over it `geometry.key=value`.

    Raises ConfigError with all faults.
    """
    table = with_settings(Table(NAME, {}, {}) if file is None else shape_table(file), list(settings))
    given = table.content.get(NAME, {})
    if not isinstance(given, Mapping):
        raise ConfigError([Fault(table.place, table.lines.get(NAME, 0), NAME, "is not a table")])
    return valve_shape(valve, {**(own or {}), **given}, table)


def shape_settings(name: str) -> tuple[str, ...]:
    """A shape by shipped name or path as settings of a system, each with its origin."""

    def text(entry: Any) -> str:
        if not isinstance(entry, Mapping):
            return json.dumps(entry, ensure_ascii=False)
        return f"{{{', '.join(f'{word} = {json.dumps(each, ensure_ascii=False)}' for word, each in entry.items())}}}"

    return tuple(f"{NAME}.{key}={text(entry)}" for key, entry in shape_table(name).content.get(NAME, {}).items())


def shape_table(name: str) -> Table:
    """The parsed text of a shape, by shipped name or path. Raises ConfigError where there is none, or more in it."""
    texts = shipped_shapes()
    if name not in texts and Path(name).suffix != ".toml" and not Path(name).exists():
        meant = suggestion(name, texts)
        raise ConfigError([Fault(name, 0, "", f"neither a shipped shape ({', '.join(texts)}) nor a file{meant}")])
    table = parsed_table(texts[name], f"{name}.toml") if name in texts else read_table(Path(name))
    faults: list[Fault] = []
    refuse_unknown(table.content, (NAME,), "", table, faults)
    if faults:
        raise ConfigError(faults)
    return table


def shape_text(rows: Sequence[Sourced]) -> str:
    """The lengths as a file that `given_shape` reads, with their origin; given thus, none follows the spool radius."""
    lines = [f"[{NAME}]"]
    for each in rows:
        unit = "" if each.kind.unit == "1" else f" {each.kind.unit}"
        words = {word: getattr(each, word) for word in ("status", "source", "where", "note") if getattr(each, word)}
        more = "".join(f", {word} = {json.dumps(text, ensure_ascii=False)}" for word, text in words.items())
        lines.append(f'{each.key} = {{ value = "{each.value!r}{unit}"{more} }}')
    return "\n".join(lines) + "\n"
