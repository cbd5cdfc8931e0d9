"""Reading a system: from a shipped name or a file to checked values, a model and a case; and writing it out again."""

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import TIME, Ratio, Time
from vvdp.base.params import Params
from vvdp.base.tables import ORIGIN, Sourced, Table, build, parsed_table, read_table, with_settings
from vvdp.base.units import parsed
from vvdp.circuits.supply import Operation
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Method, Stepping
from vvdp.systems.benches import BENCHES, Bench
from vvdp.systems.watching import WATCHING

HEADINGS = ("title", "circuit")


class RunTable(Params):
    """The [run] table: how long, how exactly, what is recorded, from when on means are taken."""

    until: Time
    average_from: Time
    relative_tolerance: Ratio
    sample_period: Time
    record_interval: Time
    window: Time
    window_interval: Time

    def check(self) -> None:
        if not self.average_from < self.until:
            raise ParameterError(f"average_from {self.average_from:g} s; expected less than until = {self.until:g} s")


@dataclass(frozen=True)
class System:
    """A system ready to run: its model and values, and where each value comes from."""

    name: str
    title: str
    circuit: str
    model: Model
    case: Case
    stepping: Stepping
    average_from: float
    tables: Mapping[str, Any]
    rows: tuple[Sourced, ...]
    content: Mapping[str, Any]

    @property
    def assumed(self) -> tuple[Sourced, ...]:
        """The values that are merely assumed."""
        return tuple(row for row in self.rows if row.status == "assumed")


def shipped() -> dict[str, str]:
    """Names of the shipped systems and their texts."""
    folder = resources.files("vvdp.systems") / "data"
    return {f.name.removesuffix(".toml"): f.read_text("utf-8") for f in sorted(folder.iterdir(), key=lambda f: f.name)}


def source_text(name: str) -> str:
    """The text of a system, by shipped name or path. Raises ConfigError where there is none."""
    texts = shipped()
    if name in texts:
        return texts[name]
    read_table(Path(name))
    return Path(name).read_text("utf-8")


def system_table(name: str) -> Table:
    """The parsed text of a system, by shipped name or path. Raises ConfigError where there is none."""
    texts = shipped()
    if name in texts:
        return parsed_table(texts[name], f"{name}.toml")
    path = Path(name)
    if not os.path.lexists(path) and path.suffix != ".toml":
        known = ", ".join(texts)
        raise ConfigError([Fault(name, 0, "", f"neither a shipped system ({known}) nor a file")])
    return read_table(path)


def load_system(name: str, settings: Sequence[str] = (), until: str | None = None) -> System:
    """The system called `name` (shipped, or the path of a file), with `settings` of the form table.key=value.

    Raises ConfigError naming every fault at once: file, line, key, value, and what was expected.
    """
    table = system_table(name)
    if settings:
        table = with_settings(_without_other_position(table, settings), list(settings))
    if until is not None:
        table = lasting(table, until)
    return built_system(table, Path(name).stem)


def _without_other_position(table: Table, settings: Sequence[str]) -> Table:
    """`table` without the duty ratio where a setting gives the axial position instead, and the other way round."""
    operation = table.content.get("operation")
    if not isinstance(operation, Mapping):
        return table
    given = {setting.partition("=")[0].strip() for setting in settings}
    kept = dict(operation)
    for one, other in (("axial_position", "duty_ratio"), ("duty_ratio", "axial_position")):
        if f"operation.{one}" in given and f"operation.{other}" not in given:
            kept.pop(other, None)
    return Table(table.place, {**table.content, "operation": kept}, table.lines)


def lasting(table: Table, until: str) -> Table:
    """`table` with a run of `until`; means are then taken from the same share of the run as before."""
    try:
        seconds = parsed(until, TIME)
    except ParameterError as problem:
        raise ConfigError([Fault("--until", 0, "", str(problem))]) from None
    if not seconds > 0.0:
        raise ConfigError([Fault("--until", 0, "", f"{until!r}; expected more than 0 s")])
    run = table.content.get("run", {})
    if not isinstance(run, Mapping):
        return table
    try:
        share = parsed(run.get("average_from"), TIME) / parsed(run.get("until"), TIME)
    except (ParameterError, ZeroDivisionError):
        share = 0.5
    lasting = {**run, "until": f"{seconds!r} s", "average_from": f"{share * seconds!r} s"}
    return Table(table.place, {**table.content, "run": lasting}, table.lines)


def built_system(table: Table, name: str) -> System:
    """The system that a parsed table describes. Raises ConfigError with all its faults."""
    faults: list[Fault] = []
    bench = _bench(table, faults)
    content = dict(table.content)
    classes: dict[str, type[Params]] = {**bench.tables, "run": RunTable} if bench else {}
    if bench and not WATCHING.keys().isdisjoint(content):
        classes |= WATCHING
    method = Method.AUTOMATIC
    if isinstance(content.get("run"), Mapping):
        content["run"] = run = dict(content["run"])
        method = _method(run.pop("method", "automatic"), table, faults)
    if isinstance(content.get("operation"), Mapping) and "axial_position" in content["operation"]:
        if "duty_ratio" in content["operation"]:
            line = table.lines.get("operation.axial_position", 0)
            message = "contradicts operation.duty_ratio; give one of the two"
            faults.append(Fault(table.place, line, "operation.axial_position", message))
        classes["operation"] = Operation
        content["operation"] = {k: v for k, v in content["operation"].items() if k != "duty_ratio"}
    if bench:
        for key in content:
            if key not in classes and key not in HEADINGS:
                message = f"unknown table; expected {', '.join({**classes, **WATCHING})}"
                faults.append(Fault(table.place, table.lines.get(key, 0), key, message))
    values: dict[str, Any] = {}
    rows: list[Sourced] = []
    for key, cls in classes.items():
        part = content.get(key)
        if not isinstance(part, Mapping):
            what = "missing table" if part is None else f"{part!r} is not a table"
            faults.append(Fault(table.place, table.lines.get(key, 0), key, what))
            continue
        values[key], found = build(cls, part, key, table, faults)
        rows += found
    model = case = stepping = None
    if not faults and bench:
        try:
            model, case = bench.built(values)
            r = values["run"]
            stepping = Stepping(
                until=r.until,
                relative_tolerance=r.relative_tolerance,
                sample_period=r.sample_period,
                record_interval=r.record_interval,
                window=r.window,
                window_interval=r.window_interval,
                method=method,
            )
        except ParameterError as problem:
            faults.append(Fault(table.place, 0, "", str(problem)))
    if faults or model is None or case is None or stepping is None:
        raise ConfigError(faults)
    title = str(table.content.get("title", name))
    kept = {k: v for k, v in table.content.items() if k not in HEADINGS}
    circuit = str(table.content["circuit"])
    return System(name, title, circuit, model, case, stepping, values["run"].average_from, values, tuple(rows), kept)


def resolved_text(system: System) -> str:
    """The system as TOML that loads to the same case: every entry with its origin, settings included."""
    return "\n".join(_resolved_lines(system)) + "\n"


def _resolved_lines(system: System) -> Iterator[str]:
    origin = {(row.table, row.key): row for row in system.rows}
    yield f"title = {_toml(system.title)}"
    yield f"circuit = {_toml(system.circuit)}"
    for name, part in system.content.items():
        yield ""
        yield f"[{_toml_key(name)}]"
        for key, entry in part.items():
            row = origin.get((name, key))
            if row is None:
                continue
            given = dict(entry) if isinstance(entry, Mapping) else {"value": entry}
            value = {word: content for word, content in given.items() if word not in ORIGIN}
            words = {word: getattr(row, word) for word in ORIGIN if getattr(row, word)}
            yield f"{_toml_key(key)} = {_toml(value | words)}"
        if name == "run":
            yield f"method = {_toml(system.stepping.method.name.lower())}"


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


def _bench(table: Table, faults: list[Fault]) -> Bench | None:
    circuit = table.content.get("circuit")
    if isinstance(circuit, str) and circuit in BENCHES:
        return BENCHES[circuit]
    what = "missing" if circuit is None else f"{circuit!r} is not a circuit"
    message = f"{what}; expected {', '.join(BENCHES)}"
    faults.append(Fault(table.place, table.lines.get("circuit", 0), "circuit", message))
    return None


def _method(word: object, table: Table, faults: list[Fault]) -> Method:
    names = {method.name.lower(): method for method in Method}
    if isinstance(word, str) and word in names:
        return names[word]
    line = table.lines.get("run.method", 0)
    faults.append(Fault(table.place, line, "run.method", f"{word!r}; expected one of {', '.join(names)}"))
    return Method.AUTOMATIC
