"""The table [programs] of a system file that draws its network."""

import dataclasses
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from vvdp.base.errors import Fault, NetworkError, ParameterError
from vvdp.base.kinds import NUMBER, TIME, Kind, Time
from vvdp.base.params import Params, field_kinds
from vvdp.base.rules import refused_field
from vvdp.base.signal import Signal, signal_value
from vvdp.base.tables import Sourced, Table, fault_at, inner_table, join, nearest, read_sourced, read_values
from vvdp.base.units import parse, parsed_difference
from vvdp.network.network import Network
from vvdp.network.nodes import Source
from vvdp.network.paths import Places
from vvdp.network.program import ProgramType
from vvdp.programs.foreign.program import foreign_program
from vvdp.programs.foreign.table import KEYS as FMU_KEYS
from vvdp.programs.foreign.table import FieldError
from vvdp.programs.generic import GenericProgram
from vvdp.programs.library import PROGRAMS
from vvdp.programs.quantities import INPUTS, LARGEST, PLAIN, written_quantity
from vvdp.sensing.instrument import Instrument, ideal_instrument
from vvdp.systems.own_programs import own_program

PATH = re.compile(r"t|[A-Za-z_]\w*(\.\w*)*")


class ProgramTimes(Params):
    """When a program is called: every `period` (0: the run's), first at `phase`; it acts `latency` later."""

    period: Time = 0.0
    phase: Time = 0.0
    latency: Time = 0.0


class ProgramDrawer(ABC):
    """Draws the programs of a file."""

    content: Mapping[str, object]
    origin: Table
    faults: list[Fault]
    rows: list[Sourced]
    folder: Path

    @abstractmethod
    def _fault(self, path: str, message: str) -> None: ...

    @abstractmethod
    def _table(self, cls: type[Any], path: str, part: Any) -> Any: ...

    @abstractmethod
    def _type(self, path: str, part: Mapping[str, object], types: Mapping[str, object]) -> Any: ...

    @abstractmethod
    def _has_own_keys(self, path: str, part: Mapping[str, object], types: Mapping[str, Any]) -> bool: ...

    @abstractmethod
    def _has_faults(self, path: str) -> bool: ...

    @abstractmethod
    def _try(self, path: str, add: Callable[[], None]) -> None: ...

    def _add_programs(self, net: Network, parts: Mapping[str, Mapping[str, object]]) -> None:
        """Add the programs of the file, each as the kinds of what it reads ask for."""
        written = {name: self._written_part(name, part) for name, part in parts.items()}
        kinds = Kinds(net, {name: each for name, each in written.items() if each})
        for each in kinds.written.values():
            if not self._has_faults(each.path):
                self._add_program(net, each, kinds)
        times = field_kinds(ProgramTimes)
        self.rows[:] = [
            row
            for row in self.rows
            if row.value not in (-LARGEST, LARGEST, ())  # no limit, no list: no value
            and not (row.note == "default" and row.key in times and row.table.startswith("programs."))
        ]

    def _written_part(self, name: str, part: Mapping[str, object]) -> "WrittenPart | None":
        """A program as it stands in the file, with its inputs by name; None where its type or keys are wrong."""
        path, types, word = f"programs.{name}", dict(PROGRAMS), part.get("type")
        try:
            if "fmu" in part:
                types, part = _foreign_type(name, part, self.folder)
            elif isinstance(word, str) and ":" in word:
                types[word] = own_program(word, self.content, self.folder)
        except ParameterError as problem:
            self._fault(f"{path}.{getattr(problem, 'key', 'type')}", str(problem))
            return None
        kind = self._type(path, part, types)
        if kind is None:
            return None
        part = _with_inputs(part, _own_type(kind))
        return WrittenPart(name, kind, part) if self._has_own_keys(path, part, types) else None

    def _add_program(self, net: Network, part: "WrittenPart", kinds: "Kinds") -> None:
        try:
            kind = kinds.type_of(part.name)
        except NetworkError as problem:
            self._fault(part.path, str(problem).removeprefix(f"{part.name}: "))
            return
        reads = read_inputs(part, kind, self.origin, self.faults, self.rows)
        own = field_kinds(kind.settings) if kind.settings else {}
        given = {key: value for key, value in part.values.items() if key in own}
        earlier = len(self.faults)
        settings = self._table(kind.settings, part.path, given) if kind.settings else None
        if isinstance(part.kind, GenericProgram):
            self.faults[earlier:] = map(part.kind.explain, self.faults[earlier:])
        times = {key: part.values[key] for key in field_kinds(ProgramTimes) if key in part.values}
        called = self._table(ProgramTimes, part.path, times)
        previous = part.values.get("previous", False)
        if not isinstance(previous, bool) and (not isinstance(previous, list) or not set(previous) <= set(reads)):
            self._fault(f"{part.path}.previous", f"{previous!r}; expected true or false, or a list of its inputs")
        measured = inner_table(part.values, "sensors", self.origin, self.faults, part.path)
        sensors = read_sensors(kind, f"{part.path}.sensors", measured, self.origin, self.faults)
        if self._has_faults(part.path):
            return
        if kind.instruments is not None:
            sensors = {**kind.instruments(settings), **sensors}
        sampled = getattr(settings, "sample_period", None)
        if sampled and called.period not in (0.0, sampled):
            self._fault(f"{part.path}.period", f"{called.period:g} s must be the sample_period, {sampled:g} s")
            return
        calls = {"period": called.period or sampled or None, "phase": called.phase, "latency": called.latency}

        def add() -> None:
            first = partial(kinds.first_reading, kind, reads)
            own, values = _type_and_settings(part.kind, kind, settings, first)
            net.program(part.name, own, values, reads=reads, sensors=sensors, previous=previous, **calls)

        self._try(part.path, add)


@dataclasses.dataclass(frozen=True)
class WrittenPart:
    """A program of a file: its type, and what stands under its keys."""

    name: str
    kind: ProgramType | GenericProgram
    values: Mapping[str, Any]

    @property
    def path(self) -> str:
        """Where it stands in the file."""
        return f"programs.{self.name}"


class Kinds:
    """The programs of a file as their units follow from what they read, which may be one another."""

    def __init__(self, net: Network, written: Mapping[str, WrittenPart]) -> None:
        self.net, self.written = net, written
        self.known: dict[str, ProgramType] = {}

    def type_of(self, name: str, above: tuple[str, ...] = ()) -> ProgramType:
        """The program of that name. Raises NetworkError where what it reads is nothing, or asks for its own unit."""
        if name not in self.known:
            part = self.written[name]
            if name in above:
                loop = " -> ".join([name, *reversed(above[above.index(name) :])])
                raise NetworkError(
                    f"{above[0]}: the unit of each of these programs follows from another's: {loop}; let one of "
                    "them read a quantity of the circuit, or take a program whose values have units, such as `pi`"
                )
            if isinstance(part.kind, ProgramType):
                return part.kind
            read = [self._read(part, kind, (*above, name)) for kind in INPUTS]
            self.known[name] = part.kind.for_quantities(read, part.kind.output(read, part.values))
        return self.known[name]

    def _read(self, part: WrittenPart, of: Kind, above: tuple[str, ...]) -> Kind:
        """The kind of what is read by the first input of this kind, one of INPUTS."""
        kinds = field_kinds(_own_type(part.kind).reading)
        entry = next((part.values[name] for name, kind in kinds.items() if kind == of and name in part.values), None)
        path = _path(entry)
        if path is None:
            return written_quantity(entry)
        other, _, key = path.partition(".")
        if path == "t":
            return TIME
        if other in self.written:
            kinds = field_kinds(type(self.type_of(other, above).command))
            if key not in kinds:
                raise NetworkError(f"{part.name}: {other!r} has no {key!r}{nearest(key, list(kinds))}")
            return kinds[key] or PLAIN
        return Places(self.net).quantity(path, part.name).kind

    def first_reading(self, kind: ProgramType, reads: Mapping[str, Source]) -> Any:
        """Reading at the start of the run, of signals and other programs; 0 for all other inputs."""
        found = dict.fromkeys(reads, 0.0)
        for name, source in reads.items():
            other, _, key = source.partition(".") if isinstance(source, str) else ("", "", "")
            if isinstance(source, Signal):
                found[name] = signal_value(0.0, source)
            elif other in self.written:
                found[name] = getattr(self.type_of(other).command, key, 0.0)
        return kind.reading(**found)


def read_inputs(
    part: WrittenPart, kind: ProgramType, origin: Table, faults: list[Fault], rows: list[Sourced]
) -> dict[str, Source]:
    """Connection of each input: a path, or a value over time."""
    found: dict[str, Source] = {}
    for name, of in field_kinds(kind.reading).items():
        entry = part.values.get(name)
        if (path := _path(entry)) is not None:
            found[name] = path
        elif name == "time" and entry is None:
            found[name] = "t"
        elif entry is not None:
            try:
                row = read_sourced(part.path, name, of or NUMBER, Signal, entry)
            except ParameterError as problem:
                faults.append(fault_at(origin, f"{part.path}.{name}", str(problem)))
                continue
            assert isinstance(row.value, Signal)
            rows.append(row)
            found[name] = row.value
        elif name not in kind.defaults:
            message = 'missing; expected what it reads, such as "inlet.pressure"'
            faults.append(fault_at(origin, f"{part.path}.{name}", message))
    return found


def _foreign_type(name: str, part: Mapping[str, object], folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The type of program that an FMU is, by a word, and the keys of the program with this type. Raises FieldError."""
    file = part["fmu"]
    if not isinstance(file, str) or "type" in part:
        raise FieldError("fmu", f'{file!r}; expected the path of an FMU in quotes ("arm.fmu"), and no type')
    kind = foreign_program(name, (folder / file).resolve(), part)
    return {"fmu": kind}, {"type": "fmu", **{key: value for key, value in part.items() if key not in FMU_KEYS}}


def _own_type(kind: ProgramType | GenericProgram) -> ProgramType:
    return kind.type if isinstance(kind, GenericProgram) else kind


def _with_inputs(part: Mapping[str, object], kind: ProgramType) -> Mapping[str, object]:
    """The keys of a program, where `reads` gives several inputs with these: a list in their order, by name, or all."""
    reads, inputs = part.get("reads"), kind.reading._fields  # type: ignore[attr-defined]
    rest = {key: value for key, value in part.items() if key != "reads"}
    open_inputs = [name for name in inputs if name != "time"]
    match reads:
        case list() if len(reads) <= len(open_inputs):
            return dict(zip(open_inputs, reads, strict=False)) | rest
        case Mapping() if reads and set(reads) <= set(inputs):
            return {**reads, **rest}
        case str() if "reads" not in inputs and len(open_inputs) == 1:
            return {open_inputs[0]: reads, **rest}
        case str() if "reads" not in inputs and "." not in reads:
            return {name: f"{reads}.{name}" for name in open_inputs if name not in kind.defaults} | rest
    return part


def _path(entry: Any) -> str | None:
    """The path that an input names, as text or as `{ from = ... }`; None for a value."""
    match entry:
        case {"from": str() as source, **rest} if not rest:
            return source
        case str() if PATH.fullmatch(entry):
            return entry
    return None


def _type_and_settings(
    kind: ProgramType | GenericProgram, own: ProgramType, settings: Any, first: Callable[[], Any]
) -> tuple[ProgramType, Any]:
    """The program and its settings, as its step takes them, with the command that holds before it is called.

    first  gives what it reads at first
    """
    if not isinstance(kind, GenericProgram):
        return own, settings
    if kind.made is not None:
        settings = kind.made(settings)
        own = kind.suited(settings) if kind.suited else own
        own = dataclasses.replace(own, settings=type(settings))
    if kind.first is not None:
        own = dataclasses.replace(own, command=kind.first(settings, first()))
    return own, settings


def read_sensors(
    kind: ProgramType, path: str, given: Mapping[str, object], origin: Table, faults: list[Fault]
) -> dict[str, Instrument]:
    """The instruments through which a program reads; each value has the unit of what is read."""
    kinds, found = field_kinds(kind.reading), {}
    for name, entries in given.items():
        measured = kinds.get(name)
        if measured is None or not isinstance(entries, Mapping):
            message = f"not read by the program{nearest(name, list(kinds))}"
            faults.append(fault_at(origin, f"{path}.{name}", message))
            continue
        readers = {key: partial(_instrument_value, key, measured) for key in field_kinds(Instrument)}
        values = read_values(readers, entries, f"{path}.{name}", origin, faults)
        ideal = ideal_instrument(values.get("range_low", measured.low), measured.high)
        try:
            found[name] = dataclasses.replace(ideal, **values)
        except ParameterError as problem:
            key, message = refused_field(problem, Instrument)
            faults.append(fault_at(origin, join(f"{path}.{name}", key), message))
    return found


def _instrument_value(key: str, measured: Kind, entry: object) -> float:
    """One value of an instrument for a quantity of a kind [SI]. Raises ParameterError."""
    if key in ("range_low", "range_high", "dropout_reading"):
        return parse(entry, measured)
    if key in ("resolution", "offset", "noise", "bias"):
        return parsed_difference(entry, measured)
    kind = field_kinds(Instrument)[key]
    assert kind is not None
    return parse(entry, kind)
