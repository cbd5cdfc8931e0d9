"""The tables [faults.NAME] of a system file.

[faults.blind]
sensor = "axial.loop.sensor"              # an instrument or encoder of a program, or a field that it reads
lost = true                               # the lower end of its range; or what it shows then: lost = "0 bar"
begin = "6 s"                             # from the start unless it is given
end = "8 s"                               # for good unless it is given

Beside `lost`, a sensor may be `frozen = true`, have a `bias = "5 mm"`, and an encoder `missed = "20 %"` of its edges.
An `actuator = "law.command"`, a field that a program commands, may be `stuck = true`, `lost = "0"`, or have a bias. A
shaft or rod that `jams = "spool"` needs the `torque` or `force` of the friction. A `value = "oil.air_fraction"`
`becomes = "30 %"` for the circuit, and for no program.

Source  ours, docs/models/faults.md, where a function names no other.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, get_type_hints

from vvdp.base.display import value_text
from vvdp.base.errors import Fault, ParameterError
from vvdp.base.kinds import FRACTION, FRICTION_FORCE, FRICTION_TORQUE, TIME, Kind
from vvdp.base.params import Params, field_kinds, field_types
from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced, Table, build, fault_at, nearest, read_sourced, read_values
from vvdp.base.units import parse, parsed_difference
from vvdp.components.library import COMPONENTS
from vvdp.network.network import Network
from vvdp.network.nodes import Rod, Shaft
from vvdp.network.program import ProgramType
from vvdp.sensing.encoder import FOR_GOOD, Encoder
from vvdp.systems.faults import (
    AnyFault,
    Biased,
    CommandFault,
    Disturbance,
    Disturbed,
    Frozen,
    InstrumentFault,
    Jam,
    Lost,
    MissedEdges,
    NamedFault,
    OtherSignal,
    OtherValue,
    ReadingFault,
    Window,
    devices,
)

FAULTS = "faults"
"""Name of the table."""
WHAT = ("sensor", "actuator", "jams", "value")
"""Keys of which a fault has one."""
VALUES = ("oil", "oils", "operation", "nodes", "components")
"""Tables of a file that draws its network whose values can be others."""


class FaultReader:
    """Reads the faults of a file: the network they befall, its tables where a function drew it, and what is wrong."""

    def __init__(
        self, network: Network, tables: Mapping[str, object] | None, origin: Table, wrong: list[Fault]
    ) -> None:
        self.network, self.tables, self.origin, self.wrong = network, tables, origin, wrong
        self.rows: list[Sourced] = []

    def faults(self) -> tuple[NamedFault, ...]:
        """The faults of the file; what is wrong with them is appended to what was wrong before."""
        given = self.origin.content.get(FAULTS, {})
        if not isinstance(given, Mapping):
            self._tell(FAULTS, f"{given!r} is not a table")
            return ()
        found = {name: self._fault(name, part) for name, part in given.items()}
        faults = tuple(NamedFault(name, fault) for name, fault in found.items() if fault is not None)
        self.wrong += _overlaps(faults, self.origin)
        return faults

    def _tell(self, path: str, message: str) -> None:
        self.wrong.append(fault_at(self.origin, path, message))

    def _fault(self, name: str, part: Any) -> AnyFault | None:
        path = f"{FAULTS}.{name}"
        if not isinstance(part, Mapping):
            self._tell(path, f"{part!r} is not a table; expected one of {', '.join(WHAT)}, and what happens to it")
            return None
        window = self._window(path, part)
        rest = {key: value for key, value in part.items() if key not in ("begin", "end")}
        if window is None:
            return None
        try:
            return self._read(name, rest, window)
        except _Unreadable as problem:
            self._tell(f"{path}.{problem.key}" if problem.key else path, str(problem))
        return None

    def _window(self, path: str, part: Mapping[str, object]) -> Window | None:
        before = len(self.wrong)
        readers = {key: partial(read_sourced, path, key, TIME, float) for key in ("begin", "end")}
        rows = read_values(readers, {key: part[key] for key in readers if key in part}, path, self.origin, self.wrong)
        self.rows += rows.values()
        if len(self.wrong) > before:
            return None
        times = {key: row.nominal for key, row in rows.items()}
        window = Window(**times)
        if not 0.0 <= window.begin < window.end:
            self._tell(f"{path}.{'end' if 'end' in times else 'begin'}",
                       f"from {window.begin:g} s to {window.end:g} s; expected an end after the begin")  # fmt: skip
            return None
        return window

    def _read(self, name: str, part: Mapping[str, object], window: Window) -> AnyFault | None:
        match part:
            case {"sensor": str(where), **rest}:
                return _sensor(self.network, where, rest, window)
            case {"actuator": str(where), **rest}:
                return _actuator(self.network, where, rest, window)
            case {"jams": str(node), **rest}:
                return _jam(self.network, name, node, rest, window)
            case {"value": str(where), "becomes": entry, **rest} if not rest:
                return self._value(name, where, entry, window)
        given = ", ".join(part) or "nothing"
        raise _Unreadable("", f"{given} given; expected one of {', '.join(WHAT)} in quotes, and what happens to it")

    def _value(self, name: str, where: str, entry: Any, window: Window) -> OtherSignal | OtherValue | None:
        table, _, key = where.rpartition(".")
        plain = entry["value"] if isinstance(entry, Mapping) and "value" in entry else entry
        words = f"{where} is {plain}"
        if self.tables is None:
            return OtherValue(where, 0.0, _entry(self.origin, where, entry, window), words, window)
        if (values := self.tables.get(table)) is None:
            raise _Unreadable("value", f"{where!r}: no table {table!r}{nearest(table, list(self.tables))}")
        kinds = field_kinds(type(values))
        kind = kinds.get(key)
        if kind is None:
            raise _Unreadable("value", f"[{table}] has no {key!r}{nearest(key, list(kinds))}")
        changes = field_types(type(values))[key] is Signal
        hint = Annotated[float, kind] if changes else get_type_hints(type(values), include_extras=True)[key]
        becomes = type("Becomes", (Params,), {"__annotations__": {"becomes": hint}})
        found, rows = build(becomes, {"becomes": entry}, f"{FAULTS}.{name}", self.origin, self.wrong)
        self.rows += rows
        if found is None:
            return None
        value = getattr(found, "becomes")  # noqa: B009
        _refuse_course(where, getattr(values, key), window)
        return OtherSignal(where, value, words, window) if changes else OtherValue(where, value, plain, words, window)


class _Unreadable(ParameterError):
    """A fault that cannot be, and which key of its table states this."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


def _overlaps(faults: Sequence[NamedFault], origin: Table) -> Iterator[Fault]:
    """Errors for two faults that do the same to the same thing: the second would hide the first."""
    seen: dict[Any, str] = {}
    for each in faults:
        if (first := seen.setdefault(_target(each.fault), each.name)) != each.name:
            yield fault_at(origin, f"{FAULTS}.{each.name}", f"does the same to the same thing as {first!r}")


def _target(fault: AnyFault) -> Any:
    """Target of a fault, and the kind of its effect."""
    match fault:
        case Jam():
            return fault.name
        case MissedEdges():
            return fault.program, fault.path
        case InstrumentFault():
            return fault.program, fault.path, type(fault.disturbance)
        case ReadingFault() | CommandFault():
            return type(fault), fault.program, fault.field, type(fault.disturbance)
    return fault.path


def _refuse_course(where: str, before: Any, window: Window) -> None:
    """Raises ParameterError where a value cannot become another one at the time of a fault."""
    if not isinstance(before, Signal):
        if window != Window():
            raise _Unreadable("value", f"{where} cannot change during a run; leave out begin and end, so that it is "
                              "another one all the time")  # fmt: skip
    elif not before.is_constant:
        raise _Unreadable("value", f"{where} changes already; expected a constant")


def _program(network: Network, key: str, where: str) -> tuple[str, str, ProgramType]:
    """Program, rest of the path, and type."""
    name, _, rest = where.partition(".")
    programs = network.programs
    if name not in programs:
        raise _Unreadable(key, f"{where!r}: no program {name!r}{_choice(name, list(programs), 'program')}")
    return name, rest, programs[name].type


def _sensor(network: Network, where: str, rest: Mapping[str, object], window: Window) -> Disturbed:
    name, path, kind = _program(network, "sensor", where)
    measured = field_kinds(kind.reading)
    if path in measured:
        return ReadingFault(name, path, _disturbance(rest, measured[path], "frozen"), window)
    found = list(devices(network.programs[name].settings))
    met = [each for each in found if not path or each[0] == path or each[0].startswith(f"{path}.")]
    if len(met) != 1:
        several = f"; it has {', '.join(each[0] for each in met)}" if met else ""
        known = [*measured, *(each[0] for each in found)]
        raise _Unreadable("sensor", f"{where!r} is no sensor of {name}{several or nearest(path, known)}")
    place, device, unit = met[0]
    if isinstance(device, Encoder):
        return MissedEdges(name, place, _missed_share(rest), window)
    return InstrumentFault(name, place, _disturbance(rest, unit, "frozen", has_range=True), window)


def _actuator(network: Network, where: str, rest: Mapping[str, object], window: Window) -> Disturbed:
    name, path, kind = _program(network, "actuator", where)
    commanded = field_kinds(type(kind.command))
    if path not in commanded:
        raise _Unreadable("actuator", f"{name} commands no {path!r}{nearest(path, list(commanded))}")
    return CommandFault(name, path, _disturbance(rest, commanded[path], "stuck"), window)


def _jam(network: Network, name: str, node: str, rest: Mapping[str, object], window: Window) -> Disturbed:
    movers = [each for each, held in network.nodes.items() if isinstance(held, Shaft | Rod)]
    if node not in movers:
        raise _Unreadable("jams", f"{node!r}{_choice(node, movers, 'shaft or rod that moves freely')}")
    turns = isinstance(network.nodes[node], Shaft)
    key, kind = ("torque", FRICTION_TORQUE) if turns else ("force", FRICTION_FORCE)
    if set(rest) != {key}:
        given = ", ".join(rest) or "nothing"
        raise _Unreadable("", f"{given} given beside jams; expected the friction: {key} = {kind.example!r}")
    friction = _parse(key, rest[key], kind)
    words = f"{value_text(friction, kind)} of dry friction hold {node}"
    return Jam(name, node, friction, words, window)


def _entry(origin: Table, where: str, entry: Any, window: Window) -> Any:
    """Replacement for a value in a file that draws its network."""
    before: Any = origin.content
    for word in where.split("."):
        before = before.get(word) if isinstance(before, Mapping) else None
    _refuse_wiring(where, origin)
    if before is None or where.partition(".")[0] not in VALUES:
        known = [key for key in origin.lines if key.partition(".")[0] in VALUES and "." in key]
        raise _Unreadable("value", f"{where!r} does not stand in the file{nearest(where, known)}")
    if window == Window():
        return entry
    plain = before.get("value") if isinstance(before, Mapping) else before
    if not isinstance(plain, str) or not isinstance(entry, str):
        raise _Unreadable("value", f"{where} changes already; expected a constant for a fault that begins and ends")
    times = [f"{t!r} s" for t in (window.begin, window.begin, window.end, window.end)]
    points = zip(times, (plain, entry, entry, plain), strict=True)
    return {"table": [list(point) for point in points][: 4 if window.end < FOR_GOOD else 3]}


def _refuse_wiring(where: str, origin: Table) -> None:
    """Raises ParameterError where a path of a drawn file leads to no value, but to what is joined, or to a table."""
    group, _, rest = where.partition(".")
    name, _, key = rest.partition(".")
    if group not in ("nodes", "components"):
        return
    part = origin.content.get(group, {}).get(name, {})
    kind = COMPONENTS.get(str(part.get("type"))) if group == "components" else None
    joined = {"type", "at", "oil", *(kind.ports if kind is not None else ())}
    if not key or key.partition(".")[0] in joined:
        values = ", ".join(f"{group}.{name}.{each}" for each in part if each not in joined)
        raise _Unreadable(
            "value", f"{where!r} is no value that can be another; expected one of {values or 'oil, operation'}"
        )


def _disturbance(given: Mapping[str, object], kind: Kind | None, still: str, *, has_range: bool = False) -> Disturbance:
    """The fault of a signal of a kind; `still` is the word for one that does not change any more."""
    match given:
        case {"frozen": True, **rest} if still == "frozen" and not rest:
            return Frozen()
        case {"stuck": True, **rest} if still == "stuck" and not rest:
            return Frozen()
        case {"lost": True, **rest} if has_range and not rest:
            return Lost(None, "is lost")
        case {"lost": str(text), **rest} if kind is not None and not rest:
            return Lost(_parse("lost", text, kind), f"is lost and reads {text}")
        case {"bias": str(text), **rest} if kind is not None and not rest:
            return Biased(_parse("bias", text, kind, difference=True), f"is off by {text}")
    example = "0" if kind is None else kind.example
    lost = 'true, or "..."' if has_range else f'"{example}" (what it is then)'
    raise _Unreadable("", f"{', '.join(given) or 'nothing'} given as what happens; expected one of {still} = true, "
                      f'lost = {lost}, bias = "{example}"')  # fmt: skip


def _missed_share(given: Mapping[str, object]) -> float:
    match given:
        case {"lost": True, **rest} if not rest:
            return 1.0
        case {"missed": entry, **rest} if not rest:
            return _parse("missed", entry, FRACTION)
    raise _Unreadable("", f"{', '.join(given) or 'nothing'} given as what happens to an encoder; expected lost = true, "
                      'or missed = "20 %"')  # fmt: skip


def _parse(key: str, entry: Any, kind: Kind, *, difference: bool = False) -> float:
    try:
        return parsed_difference(entry, kind) if difference else parse(entry, kind)
    except ParameterError as problem:
        raise _Unreadable(key, str(problem)) from None


def _choice(word: str, known: Sequence[str], what: str) -> str:
    return nearest(word, known) if known else f"; the circuit has no {what}"
