"""Faults of a system and their times: sensors and actuators of programs, what turns or slides, values that are others.

A fault changes the circuit alone. What programs know and believe stays as the tables without faults have it.

Source  ours, docs/models/faults.md, where a function names no other.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Protocol, TypeAlias

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import FRACTION, Kind
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal, constant, pulse
from vvdp.base.tables import copy_tables
from vvdp.components.rods import ROD_BRAKE
from vvdp.components.shafts import SHAFT_BRAKE
from vvdp.network.network import Network, ProgramPart
from vvdp.network.nodes import Connection, Shaft
from vvdp.network.paths import signals_of, sources_of
from vvdp.sensing.axial_sensor import AxialSensor
from vvdp.sensing.encoder import FOR_GOOD, Encoder
from vvdp.sensing.instrument import MEASURED, Instrument, ideal_instrument

Redraw: TypeAlias = Callable[[Sequence["OtherValue"]], Network | None]
"""Draws the same network with other values."""


@dataclass(frozen=True)
class Window:
    """When a fault is there: from `begin` on until `end` [s]."""

    begin: float = 0.0
    end: float = FOR_GOOD


class Disturbance(Protocol):
    """The fault of a signal."""

    @property
    def words(self) -> str:
        """The fault in words, for a user."""
        ...

    def on(self, healthy: Instrument, window: Window) -> Instrument:
        """The instrument with it."""
        ...


@dataclass(frozen=True)
class Frozen:
    """The signal stays as it is."""

    words: str = "stays as it is"

    def on(self, healthy: Instrument, window: Window) -> Instrument:
        """The instrument with it."""
        return replace(healthy, freeze_begin=window.begin, freeze_end=window.end)


@dataclass(frozen=True)
class Biased:
    """The signal is off by a `bias` [SI]."""

    bias: float
    words: str

    def on(self, healthy: Instrument, window: Window) -> Instrument:
        """The instrument with it."""
        return replace(healthy, bias=self.bias, bias_begin=window.begin, bias_end=window.end)


@dataclass(frozen=True)
class Lost:
    """The signal has a `value` whatever it should have [SI]; None: the lower end of the instrument's range."""

    value: float | None
    words: str

    def on(self, healthy: Instrument, window: Window) -> Instrument:
        """The instrument with it."""
        value = healthy.range_low if self.value is None else self.value
        return replace(healthy, dropout_reading=value, dropout_begin=window.begin, dropout_end=window.end)


@dataclass(frozen=True)
class ReadingFault:
    """A program's reading is disturbed, before or in the instrument through which it is measured."""

    program: str
    field: str
    disturbance: Disturbance
    window: Window

    @property
    def words(self) -> str:
        """The fault in words, for a user."""
        return f"what {self.program} reads as {self.field} {self.disturbance.words}"

    def apply(self, network: Network) -> None:
        """Put it into a network."""
        part = network.programs[self.program]
        sensor = self.disturbance.on(part.sensors.get(self.field, UNDISTURBED), self.window)
        network.programs[self.program] = replace(part, sensors={**part.sensors, self.field: sensor})


@dataclass(frozen=True)
class CommandFault:
    """A program's command is disturbed on its way to the circuit."""

    program: str
    field: str
    disturbance: Disturbance
    window: Window

    @property
    def words(self) -> str:
        """The fault in words, for a user."""
        return f"what {self.program} commands as {self.field} {self.disturbance.words}"

    def apply(self, network: Network) -> None:
        """Put it into a network."""
        part = network.programs[self.program]
        actuator = self.disturbance.on(part.actuators.get(self.field, UNDISTURBED), self.window)
        network.programs[self.program] = replace(part, actuators={**part.actuators, self.field: actuator})


UNDISTURBED = ideal_instrument(MEASURED.low, MEASURED.high)
"""Instrument before and behind a program if there is no other."""


@dataclass(frozen=True)
class InstrumentFault:
    """An instrument among the values of a program is disturbed; `path` leads to it."""

    program: str
    path: str
    disturbance: Disturbance
    window: Window

    @property
    def words(self) -> str:
        """The fault in words, for a user."""
        return f"what {self.program}.{self.path} shows {self.disturbance.words}"

    def apply(self, network: Network) -> None:
        """Put it into a network."""
        _change_settings(network, self.program, self.path, lambda each: self.disturbance.on(each, self.window))


@dataclass(frozen=True)
class MissedEdges:
    """An encoder among the values of a program does not see a `share` of its edges."""

    program: str
    path: str
    share: float
    window: Window

    @property
    def words(self) -> str:
        """The fault in words, for a user."""
        return f"{self.program}.{self.path} misses {100.0 * self.share:.3g} % of the edges"

    def apply(self, network: Network) -> None:
        """Put it into a network."""
        _change_settings(network, self.program, self.path, self._miss)

    def _miss(self, encoder: Encoder) -> Encoder:
        changed = replace(
            encoder.faults, missed_edges=self.share, missed_begin=self.window.begin, missed_end=self.window.end
        )
        return replace(encoder, faults=changed)


@dataclass(frozen=True)
class Jam:
    """Dry friction seizes what turns or slides, with a torque [N m] or a force [N]."""

    name: str
    node: str
    friction: float
    words: str
    window: Window

    def apply(self, network: Network) -> None:
        """Put it into a network. Raises NetworkError where the fault's name is taken."""
        held = pulse(0.0, self.friction, self.window.begin, self.window.end)
        if isinstance(network.nodes[self.node], Shaft):
            network.add(self.name, SHAFT_BRAKE, shaft=self.node, torque=held)
        else:
            network.add(self.name, ROD_BRAKE, rod=self.node, force=held)


@dataclass(frozen=True)
class OtherValue:
    """A value of the circuit is not the one that stands in its table and that programs believe.

    `value` is what the table's field becomes; `entry` what a file that draws its network has in its place.
    """

    path: str
    value: float | Signal | tuple[float, ...]
    entry: Any
    words: str
    window: Window


@dataclass(frozen=True)
class OtherSignal:
    """Fault of a prescribed value over time: it is `value` for a while [SI], whatever programs make of it."""

    path: str
    value: float
    words: str
    window: Window

    def apply(self, network: Network, tables: Mapping[str, object]) -> None:
        """Put it into a network that was drawn from tables. Raises NetworkError where nothing there follows it."""
        name, _, key = self.path.rpartition(".")
        before: Signal = getattr(tables[name], key)
        after = constant(self.value)
        if self.window != Window():
            after = pulse(before.base, self.value, self.window.begin, self.window.end)
        if not swap_signal(network, before, after):
            raise NetworkError(f"nothing in the circuit follows {self.path} itself")


Disturbed: TypeAlias = ReadingFault | CommandFault | InstrumentFault | MissedEdges | Jam
AnyFault: TypeAlias = Disturbed | OtherSignal | OtherValue


@dataclass(frozen=True)
class NamedFault:
    """A fault by the name that a file gives it."""

    name: str
    fault: AnyFault

    @property
    def window(self) -> Window:
        """When it is there."""
        return self.fault.window

    @property
    def sentence(self) -> str:
        """The fault and its time in words, for a user."""
        window = self.window
        until = f"from {window.begin:g} s" + (f" to {window.end:g} s" if window.end < FOR_GOOD else " on")
        when = "all the time" if window == Window() else until
        return f"{self.name.replace('_', ' ')}: {self.fault.words}, {when}"


def faulty_network(
    network: Network, tables: Mapping[str, object], faults: Sequence[NamedFault], redraw: Redraw
) -> Network | None:
    """The network, drawn from tables, with its faults; None where it cannot be drawn with the values they give it.

    Raises NetworkError where the name of a fault is taken, or nothing in the circuit follows what fails.
    """
    others = [each.fault for each in faults if isinstance(each.fault, OtherValue)]
    found = redraw(others) if others else network
    if found is None:
        return None
    if others:
        found.programs.update(network.programs)
    for each in faults:
        if isinstance(each.fault, OtherSignal):
            each.fault.apply(found, tables)
        elif not isinstance(each.fault, OtherValue):
            each.fault.apply(found)
    return found


def change_tables(tables: Mapping[str, Any], others: Sequence[OtherValue]) -> dict[str, Any]:
    """Tables of values with those that a fault gives them. Raises ParameterError where they cannot have them."""
    found = dict(tables)
    for other in others:
        name, _, key = other.path.rpartition(".")
        found[name] = replace(found[name], **{key: other.value})
    return found


def swap_signal(network: Network, before: Signal, after: Signal) -> bool:
    """Whether anything in a network follows a signal; it then follows another one. Programs keep what they have."""
    swapped: dict[int, Any] = {id(before): after}

    def swap(value: Any) -> Any:
        if id(value) not in swapped and isinstance(value, Params):
            mine = [name for name, signal in signals_of(value) if signal is before]
            swapped[id(value)] = _replace_fields(value, dict.fromkeys(mine, after)) if mine else value
        if isinstance(value, Connection):
            return replace(value, sources=tuple(map(swap, value.sources)))
        return swapped.get(id(value), value)

    network.temperature = swap(network.temperature)
    network.values = {name: swap(value) for name, value in network.values.items()}
    for name, node in network.nodes.items():
        inner = {field.name: swap(getattr(node, field.name)) for field in fields(node)}
        network.nodes[name] = replace(node, **inner)
    for name, part in network.parts.items():
        inputs = {key: swap(source) for key, source in part.inputs.items()}
        network.parts[name] = replace(part, values=tuple(map(swap, part.values)), inputs=inputs)
    return any(path is after for path in _sources(network))


def _sources(network: Network) -> Iterator[Any]:
    """Everything that prescribes something in a network."""
    yield network.temperature
    for node in network.nodes.values():
        yield from sources_of(node)
    for part in network.parts.values():
        for source in part.inputs.values():
            yield from source.sources if isinstance(source, Connection) else (source,)
        yield from (signal for value in part.values for _, signal in signals_of(value))


def change_entries(content: Mapping[str, object], others: Sequence[OtherValue]) -> dict[str, Any]:
    """The content of a file that draws its network, with the values that a fault gives it."""
    found = copy_tables(content)
    for other in others:
        inner, (*above, key) = found, other.path.split(".")
        for word in above:
            inner = inner[word]
        inner[key] = other.entry
    return found


def devices(values: Any, path: str = "") -> Iterator[tuple[str, Instrument | Encoder, Kind]]:
    """The instruments and encoders among the values of a program: path, device, and kind of what is measured."""
    if isinstance(values, Instrument | Encoder):
        yield path, values, MEASURED
        return
    for name in field_kinds(type(values)) if isinstance(values, Params) else ():
        for where, device, kind in devices(getattr(values, name), f"{path}.{name}" if path else name):
            yield where, device, FRACTION if isinstance(values, AxialSensor) else kind


def _replace_fields(values: Any, changes: Mapping[str, object]) -> Any:
    return replace(values, **changes)


def _change_settings(network: Network, program: str, path: str, change: Callable[[Any], Any]) -> None:
    part: ProgramPart = network.programs[program]
    settings = _change_inside(part.settings, path.split("."), change)
    network.programs[program] = replace(part, settings=settings)


def _change_inside(values: Any, path: Sequence[str], change: Callable[[Any], Any]) -> Any:
    if not path:
        return change(values)
    return _replace_fields(values, {path[0]: _change_inside(getattr(values, path[0]), path[1:], change)})
