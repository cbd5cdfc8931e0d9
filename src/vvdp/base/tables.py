"""Parameter tables: TOML in which every value has a unit, a source and a status.

    [pump]
    displacement = { value = "22.8 cc/rev", status = "published", source = "wang2017", where = "section 2.2.2" }
    speed = "1800 rpm"                       # a bare value is the user's own: status "given"
    air_fraction = { value = "1 %", range = ["0.1 %", "5 %"], status = "assumed" }    # where it may lie as well

All faults of a file are collected and reported together, each with its line.
"""

import dataclasses
import math
import re
import stat
import tomllib
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, get_origin

from vvdp.base import signal as signals
from vvdp.base.display import value_text
from vvdp.base.errors import ConfigError, Fault, ParameterError, unusable
from vvdp.base.kinds import ANGLE, FREQUENCY, TIME, Kind
from vvdp.base.params import Params, default_values, field_kinds, field_names, field_types, idle_fields
from vvdp.base.rules import refused_field
from vvdp.base.signal import Signal
from vvdp.base.slots import TableSlot, inner_slots
from vvdp.base.units import parse, parsed_difference

STATUSES = ("measured", "published", "derived", "assumed", "given")
ORIGIN = ("status", "source", "where", "note")
LARGEST_FILE = 1_000_000
SET_BY_OPTION = 0
"""The line of a key that no file holds, but the command line."""

T = TypeVar("T", bound=Params)
V = TypeVar("V")


@dataclasses.dataclass(frozen=True)
class Sourced:
    """One value of a table with its origin, as reports print it."""

    table: str
    key: str
    value: float | Signal | tuple[float, ...]
    kind: Kind
    status: str
    source: str = ""
    where: str = ""
    note: str = ""
    range: tuple[float, float] | None = None
    """Between which values [SI] it lies, where the file states this."""
    idle_at: tuple[str, ...] = ()
    """Settings that make it have no effect while all of them are 0."""

    @property
    def setting(self) -> str:
        """Its table and key, as `--set` takes them."""
        return f"{self.table}.{self.key}"

    @property
    def nominal(self) -> float:
        """The value, where it has one that does not change [SI]; nan elsewhere."""
        value = self.value.base if isinstance(self.value, Signal) and self.value.is_constant else self.value
        return value if isinstance(value, float | int) else float("nan")

    @property
    def remark(self) -> str:
        """The range and the note, for a user."""
        ends = "" if self.range is None else " to ".join(value_text(end, self.kind) for end in self.range)
        return "; ".join(filter(None, (ends, self.note)))

    @property
    def display_text(self) -> str:
        """The value as people read it."""
        if isinstance(self.value, Signal):
            return describe_signal(self.value, self.kind)
        values = self.value if isinstance(self.value, tuple) else (self.value,)
        return ", ".join(value_text(value, self.kind) for value in values) or "none"


@dataclasses.dataclass(frozen=True)
class Table:
    """The parsed content of a file (or of several joined), and where each key stands."""

    place: str
    content: Mapping[str, Any]
    lines: Mapping[str, int]


def read_table(path: Path) -> Table:
    """The content of a TOML file. Raises ConfigError where the file cannot be read as one."""
    try:
        if path.is_dir():
            raise unusable(path, "is a directory; expected a system file (TOML)")
        if not stat.S_ISREG(path.stat().st_mode):  # a device or pipe may never end
            raise unusable(path, "is not a regular file; expected a system file (TOML)")
        if path.stat().st_size > LARGEST_FILE:
            raise unusable(path, f"has {path.stat().st_size} bytes; a system file has at most {LARGEST_FILE}")
        text = path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        raise unusable(path, "no such file") from None
    except OSError as problem:
        raise unusable(path, f"cannot be read ({problem.strerror})") from None
    except UnicodeDecodeError as problem:
        raise unusable(path, f"is not UTF-8 text (byte {problem.start})") from None
    return parsed_table(text, str(path))


def parsed_table(text: str, place: str) -> Table:
    """The content of TOML `text`; `place` names it in messages. Raises ConfigError."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        found = re.search(r" \(at line (\d+), column \d+\)", str(problem))
        line = int(found[1]) if found else text.count("\n") + 1  # "at end of document"
        words = str(problem).replace(found[0] if found else "", "")
        bare = re.search(r"=\s*([-+.\d][-+.\de]*\s+[A-Za-z%][^\s,}\]]*)", text.splitlines()[line - 1] if line else "")
        meant = f'; a value with a unit stands in quotes: "{bare[1]}"' if bare else ""
        raise ConfigError([Fault(place, line, "", f"is not valid TOML: {words}{meant}")]) from None
    except (ValueError, RecursionError) as problem:  # thousands of digits or of brackets
        raise unusable(place, f"is not valid TOML: {problem}") from None
    if not content:
        raise unusable(place, "is empty; `vvdp new NAME --from prototype` writes a file to start from")
    return Table(place, content, dict(_lines(text)))


def _lines(text: str) -> Iterator[tuple[str, int]]:
    """Dotted key and line number of every assignment and header; tomllib itself keeps no positions."""
    header, counts = "", Counter[str]()
    for number, line in enumerate(text.splitlines(), 1):
        if match := re.match(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]", line):
            header = match[2]
            if match[1] == "[[":  # the first table of an array is `name.1`
                counts[header] += 1
                header = f"{header}.{counts[header]}"
            yield header, number
        elif match := re.match(r"\s*([A-Za-z0-9_.\-]+|\"[^\"]+\")\s*=", line):
            key = match[1].strip('"')
            yield f"{header}.{key}" if header else key, number


def with_settings(table: Table, settings: list[str]) -> Table:
    """`table` with values replaced as on the command line: `pump.speed=1200 rpm`.

    A value in braces is read as TOML (`pump.speed={step=["1200 rpm", "1800 rpm"], at="0.5 s"}`).
    """
    content = copy_tables(table.content)
    lines = dict(table.lines)
    faults = []
    for setting in settings:
        key, equals, text = setting.partition("=")
        key, text = key.strip(), text.strip()
        parts = key.split(".")
        if equals and len(parts) > 1 and all(parts) and not text:
            faults.append(Fault("--set", 0, key, "no value is given"))
            continue
        if not equals or len(parts) < 2 or not all(parts) or not text:
            meant = _full_keys(key, text, content) if equals and text else ""
            faults.append(Fault("--set", 0, setting, f'expected table.key="value with unit"{meant}'))
            continue
        try:
            value = tomllib.loads(f"value = {text}")["value"] if text.startswith(("{", "[")) else text.strip("\"'")
        except (ValueError, RecursionError) as problem:
            faults.append(Fault("--set", 0, key, f"is not valid TOML: {problem}"))
            continue
        inner = content
        for number, part in enumerate(parts[:-1], 1):
            inner = inner.setdefault(part, {})
            if not isinstance(inner, dict):
                faults.append(Fault("--set", 0, key, f"{'.'.join(parts[:number])!r} is not a table"))
                break
        else:
            inner[parts[-1]] = value
            lines[key] = SET_BY_OPTION
    if faults:
        raise ConfigError(faults)
    return Table(table.place, content, lines)


def _full_keys(key: str, text: str, content: Mapping[str, object]) -> str:
    """The end of a message about a `key` that is given without its table: the settings that `content` has for it."""
    found = [f"'{name}.{key}={text}'" for name, part in content.items() if isinstance(part, Mapping) and key in part]
    return f"; did you mean {' or '.join(found)}?" if found else ""


def copy_tables(content: Mapping[str, object]) -> dict[str, Any]:
    """A copy of parsed tables whose inner tables may be changed."""
    return {key: copy_tables(value) if isinstance(value, Mapping) else value for key, value in content.items()}


def read_values(
    readers: Mapping[str, Callable[[Any], V]],
    table: Mapping[str, object],
    name: str,
    origin: Table,
    faults: list[Fault],
) -> dict[str, V]:
    """The values of one TOML table called `name`, by key, each as its reader makes it of what stands there.

    A reader raises ParameterError where it cannot; that, and unknown keys, are appended to `faults`.
    """
    found: dict[str, V] = {}
    for key, entry in table.items():
        if key not in readers:
            refuse_unknown({key: entry}, readers, name, origin, faults)
            continue
        try:
            found[key] = readers[key](entry)
        except ParameterError as problem:
            faults.append(fault_at(origin, f"{name}.{key}", str(problem)))
    return found


def refuse_unknown(
    table: Mapping[str, object],
    known: Collection[str],
    name: str,
    origin: Table,
    faults: list[Fault],
    missing: Collection[str] = (),
) -> None:
    """Append a fault for each key of a TOML table that is not `known`, with the one that was perhaps meant.

    name     of the table; empty for the file itself, whose inner tables are called tables
    known    keys; a dotted one, `run.until`, is not one of this table but may be meant
    missing  those of them that the table must have and has not: they are meant first
    """
    names = {each.rpartition(".")[2]: each for each in reversed(list(known))}
    own = [each for each in known if "." not in each]
    for key, entry in table.items():
        if key not in own:
            what = "table" if not name and isinstance(entry, Mapping) else "key"
            close = names.get(key) or closest_word(key, missing) or names.get(closest_word(key, names), "")
            meant = f"; did you mean {close!r}?" if close else nearest(key, own)
            faults.append(fault_at(origin, join(name, key), f"unknown {what}{meant}"))


def inner_table(
    table: Mapping[str, object], key: str, origin: Table, faults: list[Fault], name: str = ""
) -> Mapping[str, object]:
    """The table under a key of the table `name`, empty if it is not given; anything else there is a fault."""
    found = table.get(key, {})
    if isinstance(found, Mapping):
        return found
    faults.append(fault_at(origin, join(name, key), f"{found!r} is not a table"))
    return {}


def join(name: str, key: str) -> str:
    """The dotted path of a key in the table called `name`; empty names the file itself."""
    return f"{name}.{key}" if name else key


def read_text(entry: Any) -> str:
    """A text that is not blank. Raises ParameterError."""
    if not (isinstance(entry, str) and entry.strip()):
        raise ParameterError(f"{entry!r}; expected a name in quotes")
    return entry


def _example(kind: Kind, of: Any) -> str:
    """How a value is written, or a list of some."""
    return f'["{kind.example}", ...]' if get_origin(of) is tuple else f'"{kind.example}"'


def _setting(table: str, key: str) -> str:
    """A key of this table, or one that names its own."""
    return key if "." in key else f"{table}.{key}"


def read_flag(entry: Any) -> bool:
    """True or false. Raises ParameterError."""
    if not isinstance(entry, bool):
        raise ParameterError(f"{entry!r}; expected true or false")
    return entry


def read_whole(entry: Any, low: int, high: int) -> int:
    """A whole number from `low` to `high`. Raises ParameterError."""
    if isinstance(entry, bool) or not isinstance(entry, int) or not low <= entry <= high:
        raise ParameterError(f"{entry!r}; expected a whole number from {low} to {high}")
    return entry


def build(
    cls: type[T], table: Mapping[str, object], name: str, origin: Table, faults: list[Fault]
) -> tuple[T | None, list[Sourced]]:
    """The parameters of `cls` from one TOML table called `name`, and the origin of each value.

    A field with a default need not be given; one whose type is a parameter class is a table inside of this one. Faults
    are appended to `faults`; the parameters are None when there are any.
    """
    slots, before = inner_slots(cls), len(faults)
    plain = {key: entry for key, entry in table.items() if key not in slots}
    given, rows = _own_values(cls, plain, name, origin, faults)
    values: dict[str, Any] = {key: row.value for key, row in given.items()}
    for key, slot in slots.items():
        if key in table or not slot.optional:
            values[key], inner = build_inner(slot, table.get(key), f"{name}.{key}", origin, faults)
            rows += inner
    if len(faults) > before:
        return None, rows
    try:
        return cls(**values), rows
    except ParameterError as problem:
        key, message = refused_field(problem, cls)
        message = _as_written(table.get(key), message)
        faults.append(fault_at(origin, f"{name}.{key}" if key else name, message))
        return None, rows


def _own_values(
    cls: type[Params], table: Mapping[str, object], name: str, origin: Table, faults: list[Fault]
) -> tuple[dict[str, Sourced], list[Sourced]]:
    """The values of a table that are no tables themselves: those that it gives, and all of them with the usual ones."""
    known, defaults, slots = field_types(cls), default_values(cls), inner_slots(cls)
    kinds = {key: kind for key, kind in field_kinds(cls).items() if key not in slots}
    readers = {key: partial(read_sourced, name, key, kind, known[key]) for key, kind in kinds.items()}
    given = read_values(readers, table, name, origin, faults)
    rows: list[Sourced] = []
    for key, kind in kinds.items():
        if key in given:
            rows.append(given[key])
        elif key in table:
            continue
        elif key not in defaults:
            example = f", for example {_example(kind, known[key])}" if kind else ""
            faults.append(fault_at(origin, name, f"missing key {key!r}{example}", key=f"{name}.{key}"))
        elif kind is not None:
            rows.append(Sourced(name, key, defaults[key], kind, status="assumed", note="default"))
    idle = {key: tuple(_setting(name, each) for each in factors) for key, factors in idle_fields(cls).items()}
    return given, [dataclasses.replace(row, idle_at=idle[row.key]) if row.key in idle else row for row in rows]


def build_inner(
    slot: TableSlot, part: object, name: str, origin: Table, faults: list[Fault]
) -> tuple[Params | None, list[Sourced]]:
    """The parameters of the table called `name`, of the class that its keys show; None with a fault."""
    if not isinstance(part, Mapping):
        what = "missing table" if part is None else f"{part!r} is not a table"
        faults.append(fault_at(origin, name, what))
        return None, []
    cls = chosen_class(slot, name, part, origin, faults)
    others = {field for other in slot.classes if other is not cls for field in field_names(other)}
    foreign = others - set(field_names(cls))
    return build(cls, {key: entry for key, entry in part.items() if key not in foreign}, name, origin, faults)


def chosen_class(
    slot: TableSlot, name: str, part: Mapping[str, object], origin: Table, faults: list[Fault]
) -> type[Params]:
    """The class of the table called `name`; a fault is appended for each of its keys that belongs to another one."""
    cls, table = slot.choice(part), name.rpartition(".")[2]
    own = set(field_names(cls))
    for other in slot.classes:
        theirs = set(field_names(other))
        for key in part.keys() & (theirs - own):
            instead = ", ".join(sorted(own - theirs))
            faults.append(fault_at(origin, f"{name}.{key}", f"contradicts {table}.{instead}; give one of the two"))
    return cls


def _as_written(entry: Any, message: str) -> str:
    """A message that begins with a value, with the text of the file before it if that has another unit."""
    text = entry.get("value") if isinstance(entry, Mapping) else entry
    unit = str(text).strip().partition(" ")[2].strip()
    return f"{text!r} = {message}" if isinstance(text, str) and unit and f" {unit} " not in f"{message} " else message


def read_sourced(name: str, key: str, kind: Kind | None, known: Any, entry: Any) -> Sourced:
    """Value under a key, with its origin. Raises ParameterError."""
    if kind is None:
        raise TypeError(f"{name}.{key} has no kind")
    fields = dict(entry) if isinstance(entry, Mapping) else {"value": entry}
    text = {word: str(fields.pop(word, "")) for word in ORIGIN}
    ends = fields.pop("range", None)
    status = text["status"] or "given"
    if status not in STATUSES:
        raise ParameterError(f"status {status!r}; expected one of {', '.join(STATUSES)}")
    value: float | Signal | tuple[float, ...]
    if known is Signal:
        value = _signal(fields, kind)
        if any(map(kind.fault, value.extremes)):
            low, high = value_text(kind.low, kind), value_text(kind.high, kind)
            raise ParameterError(f"{describe_signal(value, kind)} is outside {low} to {high} for {kind.with_article}")
    elif get_origin(known) is tuple:
        value = _list(fields, kind)
    elif set(fields) == {"value"}:
        value = parse(fields["value"], kind)
    else:
        other = ", ".join(sorted(set(fields) - {"value"})) or "no value"
        raise ParameterError(f"{other}; expected a value that does not change, for example {kind.example!r}")
    found = Sourced(
        table=name,
        key=key,
        value=value,
        kind=kind,
        status=status,
        source=text["source"],
        where=text["where"],
        note=text["note"],
    )
    return found if ends is None else dataclasses.replace(found, range=_range(ends, found))


def _range(ends: Any, of: Sourced) -> tuple[float, float]:
    """The two ends between which a value lies. Raises ParameterError where they are none, or it lies outside."""
    if not isinstance(ends, list) or len(ends) != 2:
        example = f'range = ["{of.kind.example}", ...], the lower end first'
        raise ParameterError(f"{ends!r} as range; expected two ends, {example}")
    low, high = (parse(end, of.kind) for end in ends)
    if not low < high:
        raise ParameterError(f"{ends[0]} to {ends[1]} as range; expected two different ends, the lower one first")
    if math.isnan(of.nominal):
        raise ParameterError(f"range {ends[0]} to {ends[1]} of a value that changes; expected one of a constant")
    if not low <= of.nominal <= high:
        raise ParameterError(f"{of.display_text}; expected a value inside its range, {ends[0]} to {ends[1]}")
    return low, high


def _list(fields: Mapping[str, object], kind: Kind) -> tuple[float, ...]:
    """The numbers of a TOML list."""
    match fields:
        case {"value": [*entries], **rest} if not rest:
            return tuple(parse(entry, kind) for entry in entries)
    raise ParameterError(
        f"{', '.join(map(str, fields.values()))}; expected a list, for example {_example(kind, tuple[float, ...])}"
    )


def _signal(fields: Mapping[str, Any], kind: Kind) -> Signal:
    """The signal of a TOML entry: `value`, `step`, `ramp`, `sine` or `table` with the words that go with it."""
    match fields:
        case {"value": value, **rest} if not rest:
            return signals.constant(parse(value, kind))
        case {"step": [before, after], "at": at, **rest} if not rest:
            return signals.step(parse(before, kind), parse(after, kind), parse(at, TIME))
        case {"ramp": [before, after], "from": begin, "to": end, **rest} if not rest:
            t0, t1 = parse(begin, TIME), parse(end, TIME)
            if t1 < t0:
                raise ParameterError(f"the ramp ends at {t1:g} s, before it begins at {t0:g} s")
            return signals.ramp(parse(before, kind), parse(after, kind), t0, t1)
        case {"sine": mean, "amplitude": amplitude, "frequency": frequency, **rest} if set(rest) <= {"phase"}:
            phase = parse(rest.get("phase", "0 rad"), ANGLE)
            return signals.sine(
                parse(mean, kind), parsed_difference(amplitude, kind), parse(frequency, FREQUENCY), phase
            )
        case {"table": [_, *_] as points, **rest} if not rest and all(
            isinstance(p, list) and len(p) == 2 for p in points
        ):
            times = [parse(t, TIME) for t, _ in points]
            try:
                return signals.table(times, [parse(v, kind) for _, v in points])
            except ValueError as problem:
                raise ParameterError(str(problem)) from None
    raise ParameterError(
        f"{', '.join(fields) or 'nothing'} given; expected {kind.example!r}, or one of {{step = [a, b], at = t}}, "
        "{ramp = [a, b], from = t, to = t}, {sine = mean, amplitude = a, frequency = f}, {table = [[t, a], ...]}"
    )


def describe_signal(value: Signal, kind: Kind) -> str:
    """A signal as people read it."""
    if value.is_constant:
        return value_text(value.base, kind)
    low, high = value.extremes
    corners = sorted({*value.start, *(a + d for a, d in zip(value.start, value.duration, strict=True))})
    parts = [f"between {value_text(low, kind)} and {value_text(high, kind)}"]
    if corners:
        parts.append("corners at " + ", ".join(f"{t:g} s" for t in corners[:6]) + (" ..." if len(corners) > 6 else ""))
    parts += [f"sine of {f:g} Hz" for f in value.frequency]
    return ", ".join(parts)


def fault_at(origin: Table, path: str, message: str, key: str = "") -> Fault:
    """A fault at a dotted `path`; `key` is what is named.

    It has the line of the path, else of the first key below it, else of the table in which it stands. What no file
    holds was set by an option.
    """
    inner = (line for each, line in origin.lines.items() if each.startswith(f"{path}."))
    line, part = origin.lines.get(path, next(inner, None)), path
    while line is None and "." in part:
        part = part.rpartition(".")[0]
        line = origin.lines.get(part)
    return Fault("--set" if line == SET_BY_OPTION else origin.place, line or 0, key or path, message)


def closest_word(word: str, known: Iterable[str]) -> str:
    """The one of `known` that is closest to an unknown `word`; empty if none is close."""
    import difflib

    return next(iter(difflib.get_close_matches(word, sorted(known), 1)), "")


def suggestion(word: str, known: Iterable[str], most: int = 1) -> str:
    """The end of a message about an unknown `word`: up to `most` of `known` that were perhaps meant."""
    import difflib

    close = difflib.get_close_matches(word, list(known), most)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def nearest(word: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown `word`: what was perhaps meant, or all that is `known`."""
    return suggestion(word, known) or f"; expected one of {', '.join(sorted(known))}"


def write_new(path: Path, text: str, *, force: bool) -> None:
    """Writes a file for a user to go on with, never over another without `force`. Raises ConfigError."""
    try:
        with path.open("w" if force else "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise unusable(path, "already exists; choose another name or use --force") from None
    except OSError as problem:
        raise unusable(path, f"cannot be written ({problem.strerror})") from None
