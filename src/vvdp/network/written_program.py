"""A program of a network as it is written: what it measures, the instruments in between, its trigger."""

import types
from collections.abc import Callable
from functools import cached_property
from typing import Any, get_type_hints

from vvdp.base.conservation import NOTHING
from vvdp.base.errors import NetworkError
from vvdp.base.params import field_kinds
from vvdp.network.classes import named_tuple, params_class
from vvdp.network.network import ProgramPart
from vvdp.network.paths import check_unit
from vvdp.network.text import Text
from vvdp.sensing.instrument import Instrument, InstrumentMemory, instrument_start, instrument_step
from vvdp.simulation.model import Program
from vvdp.simulation.values import names


class WrittenProgram:
    """One program of a network: the functions that it needs, as text, and the record that the model takes."""

    def __init__(self, part: ProgramPart, text: Text) -> None:
        self.part, self.text, self.name = part, text, part.name

    @property
    def blocks(self) -> list[list[str]]:
        """Its functions: `measure_`, `trigger_` if events call it, `step_` and `begin_` where instruments measure."""
        found = [
            [
                f"def measure_{self.name}(t, s, outputs, p):",
                f"    return {reading_text(self.part, self.text, sample_text)}",
            ]
        ]
        if self.part.type.level:
            reading = reading_text(self.part, self.text, event_text)
            if "outputs." in reading:
                raise NetworkError(
                    f"{self.name} is called by events, which can read states alone; {reading} reads more"
                )
            level, settings = self.text.use(self.part.type.level), "z.program" if self._has_instruments else "z"
            found.append([f"def trigger_{self.name}(t, s, u, p, z):", f"    return {level}({reading}, {settings})"])
        return [*found, *(self._with_instruments() if self._has_instruments else [])]

    @property
    def _has_instruments(self) -> bool:
        return bool(self.part.sensors or self.part.actuators)

    @property
    def _instruments(self) -> dict[str, Instrument]:
        """All instruments, before the step and behind it, by what they are called in its memory."""
        before, behind = self.part.sensors, self.part.actuators
        return {f"{n}_sensor": before[n] for n in before} | {f"{n}_actuator": behind[n] for n in behind}

    @cached_property
    def memory(self) -> type:
        """The NamedTuple of what step and instruments remember: the step's own fields first."""
        if twice := self._instruments.keys() & set(names(self._own_memory)):
            raise NetworkError(f"{self.name}: its memory has a field {min(twice)!r}, as that of an instrument")
        own = get_type_hints(self._own_memory, include_extras=True)
        hints = {**own, **dict.fromkeys(self._instruments, InstrumentMemory)}
        return named_tuple(f"{self.name.title().replace('_', '')}Memory", hints)

    @cached_property
    def _own_memory(self) -> type:
        """The NamedTuple of what the step itself remembers."""
        return type(self.part.type.start(self.part.settings))

    @cached_property
    def settings(self) -> Any:
        """Settings of its step, beside those of the instruments where there are any."""
        own = NOTHING if self.part.settings is None else self.part.settings
        if not self._has_instruments:
            return own
        hints = {**dict.fromkeys(self._instruments, Instrument), "program": type(own)}
        values: dict[str, Any] = {**self._instruments, "program": own}
        return params_class("ProgramSettings", hints)(**values)

    def _with_instruments(self) -> list[list[str]]:
        """A step that takes readings through their instruments first and its command last, and where it begins."""
        step, start = self.text.use(self.part.type.step), self.text.use(self.part.type.start)
        instrument, begin = self.text.use(instrument_step), self.text.use(instrument_start)
        memory, reading = self.text.use(self.memory), self.text.use(self.part.type.reading)
        lines = [f"{n}_sensor, {n} = {instrument}(m.{n}_sensor, t, r.{n}, z.{n}_sensor)" for n in self.part.sensors]
        fields = ", ".join(f"{n}={n if n in self.part.sensors else f'r.{n}'}" for n in self.part.reads)
        own = f"{self.text.use(self._own_memory)}({', '.join(f'm.{n}' for n in names(self._own_memory))})"
        lines.append(f"program, command = {step}(t, {own}, {reading}({fields}), z.program)")
        if self.part.actuators:
            lines += acting_lines(self.part, self.text.use(type(self.part.type.command)), instrument)
        after = [*(f"program.{n}" for n in names(self._own_memory)), *self._instruments]
        lines.append(f"return {memory}({', '.join(after)}), command")
        starts = [*(f"program.{n}" for n in names(self._own_memory)), *(f"{begin}(z.{n})" for n in self._instruments)]
        made = f"{memory}({', '.join(starts)})"
        return [
            [f"def step_{self.name}(t, m, r, z):", *(f"    {line}" for line in lines)],
            [f"def begin_{self.name}(z):", f"    program = {start}(z.program)", f"    return {made}"],
        ]

    def assemble(self, module: types.ModuleType) -> Program:
        """The program as the model takes it, from the module that its text has become."""
        kind, through = self.part.type, self._has_instruments
        return Program(
            measure=getattr(module, f"measure_{self.name}"),
            step=getattr(module, f"step_{self.name}") if through else kind.step,
            command=kind.command,
            start=getattr(module, f"begin_{self.name}") if through else kind.start,
            trigger=getattr(module, f"trigger_{self.name}", None),
            period=self.part.period,
            phase=self.part.phase,
            latency=self.part.latency,
            partner=kind.partner,
            is_bounded=kind.is_bounded and not through,
        )


def reading_text(part: ProgramPart, text: Text, read: Callable[[ProgramPart, Text, str], str]) -> str:
    """The text that makes a reading, each connected field as `read` says; what is not connected has its usual value."""
    fields = {name: read(part, text, name) for name in part.reads}
    fields |= {name: repr(value) for name, value in part.type.defaults.items() if name not in fields}
    return f"{text.use(part.type.reading)}({', '.join(f'{name}={value}' for name, value in fields.items())})"


def sample_text(part: ProgramPart, text: Text, field: str) -> str:
    """Where a field comes from at a sample: a state, a result of the circuit, or a value over time."""
    source = part.reads[field]
    if source == "t":
        return "t"
    if not isinstance(source, str):
        return text.source(source, part.name)
    found = text.places.quantity(source, part.name)
    if not found.recorded:
        raise NetworkError(f"{part.name} reads {source!r}, which no sensor measures")
    check_unit(f"{part.name}.{field}", field_kinds(part.type.reading)[field], source, found.kind)
    return found.recorded


def event_text(part: ProgramPart, text: Text, field: str) -> str:
    """The same between samples, where the commands of programs are at hand but no results of the circuit."""
    source, sampled = part.reads[field], sample_text(part, text, field)
    is_command = isinstance(source, str) and source.partition(".")[0] in text.network.programs
    return text.source(source, part.name) if is_command else sampled


def acting_lines(part: ProgramPart, command: str, instrument: str) -> list[str]:
    """Lines that take fields of a program's command through what stands behind it.

    command     name of the command's class in the text
    instrument  name of the step of an instrument there
    """
    acting = part.actuators
    calls = [f"{n}_actuator, {n}_act = {instrument}(m.{n}_actuator, t, command.{n}, z.{n}_actuator)" for n in acting]
    fields = {n: f"{n}_act" if n in acting else f"command.{n}" for n in names(part.type.command)}
    return [*calls, f"command = {command}(", *(f"    {n}={text}," for n, text in fields.items()), ")"]
