"""Variables of a system in an FMU: inputs, parameters that are free, outputs, and what is fixed with the reason."""

import re
from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from typing import Any

import numpy as np

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import Kind
from vvdp.base.signal import Signal
from vvdp.base.tables import nearest
from vvdp.export.c_guest import indicator_count
from vvdp.export.c_machine import CMachine, c_machine
from vvdp.export.c_tangent import Tangent, tangent_of
from vvdp.simulation.guest import ENTRIES, EVENTS
from vvdp.simulation.parts import example_outputs
from vvdp.simulation.symbols import Untraceable
from vvdp.simulation.values import leaves
from vvdp.systems.changeable import Changeable, Follower, changeable_values
from vvdp.systems.system import System

FIXED, TUNABLE, INPUT = "fixed", "tunable", "input"
IDENTITY = ("+", 0.0)
NAME = re.compile(r"[\w.\[\]-]+")


@dataclass(frozen=True)
class Settable:
    """A variable that can be set [SI].

    role  FIXED before the first step only, TUNABLE between steps, INPUT at each communication point
    """

    name: str
    key: str
    kind: Kind
    start: float
    low: float
    high: float
    role: str
    about: str
    followers: tuple[Follower, ...]


@dataclass(frozen=True)
class Output:
    """A number that an FMU shows: in which vector of the machine, and where."""

    name: str
    key: str
    kind: Kind | None
    vector: str
    place: int

    @property
    def is_discrete(self) -> bool:
        """Whether it changes at samples only."""
        return self.vector == "command"


@dataclass(frozen=True)
class Guest:
    """An FMU that the integrator of a host carries; `has_books`: with the energy and mass balance among its states."""

    has_books: bool = False


@dataclass(frozen=True)
class FmuModel:
    """A machine with the variables of an FMU; `fixed` are values that stay, each with the reason.

    carried  of a guest, the states that the integrator of the host carries, in its order
    inner    of a guest, what the host needs besides: states that are no output, rates of all states, indicators
    tangent  of a guest, its directional derivatives; None where the circuit cannot be traced
    """

    machine: CMachine
    settables: tuple[Settable, ...]
    outputs: tuple[Output, ...]
    fixed: tuple[tuple[str, str], ...]
    carried: tuple[Output, ...] = ()
    inner: tuple[Output, ...] = ()
    tangent: Tangent | None = None

    @property
    def system(self) -> System:
        """The system."""
        return self.machine.system

    @property
    def variables(self) -> tuple[Settable | Output, ...]:
        """All variables in the order of their references, which begin with 1."""
        return (*self.settables, *self.outputs, *self.inner)

    @property
    def inputs(self) -> list[str]:
        """The names of the inputs."""
        return [each.name for each in self.settables if each.role == INPUT]


def fmu_model(
    system: System, inputs: Sequence[str] = (), outputs: Sequence[str] = (), guest: Guest | None = None
) -> FmuModel:
    """The variables of an FMU of a system.

    inputs   keys of signals, or KEY=NAME; by default all signals that the file keeps constant
    outputs  paths of states, commands and outputs, or PATH=NAME; by default all of them
    guest    of an FMU that the integrator of a host carries

    A parameter is free if what follows it is known: it is changed, the case is built again, and what changes in its
    vectors is a product or a sum, to the last bit. Raises ConfigError where a key is unknown, or no constant signal.
    """
    chosen, renamed = _names_of("--input", inputs), _names_of("--output", outputs)
    for key in chosen:
        _require_signal(system, key)
    values = changeable_values(system, _outside_vectors)
    for each in values:
        if each.why_not and each.row.setting in chosen:
            why = f"cannot change while the system runs: {each.why_not}"
            raise ConfigError([Fault("--input", 0, each.row.setting, why)])
    settables = [_settable(each, chosen) for each in values if not each.why_not]
    fixed = [(each.row.setting, each.why_not) for each in values if each.why_not]
    known = {each.row.setting for each in values}
    fixed += [(row.setting, _why_fixed(row)) for row in system.rows if row.setting not in known]
    shown = _outputs(system, {each.name for each in settables})
    for key in renamed:
        if key not in shown:
            raise ConfigError([Fault("--output", 0, key, f"unknown{nearest(key, tuple(shown))}")])
    if renamed:
        shown = {key: Output(name, *_place(shown[key])) for key, name in renamed.items()}
    machine = c_machine(system, EVENTS if guest is None else ENTRIES)
    states = () if guest is None else tuple(_states(machine, shown.values(), guest))
    found = FmuModel(
        machine=machine,
        settables=tuple(settables),
        outputs=tuple(shown.values()),
        fixed=tuple(fixed),
        carried=states,
        inner=() if guest is None else tuple(_inner(machine, states, shown.values())),
        tangent=None if guest is None else _tangent(machine, settables),
    )
    _refuse_same_names(found)
    return found


def _tangent(machine: CMachine, settables: Sequence[Settable]) -> Tangent | None:
    followed = {own.place for each in settables if each.role == INPUT for own in each.followers}
    try:
        return tangent_of(machine, frozenset(followed))
    except Untraceable:
        return None


def has_clock(model: FmuModel, fmi: int) -> bool:
    """Whether an FMU has the clock of the ends of periods: FMI 3, carried by its own loop alone."""
    return fmi == 3 and not model.machine.is_guest


def _states(machine: CMachine, shown: Iterable[Output], guest: Guest) -> Iterator[Output]:
    """The states that a host carries: those that are shown under their names."""
    names = {each.place: each for each in shown if each.vector == "state"}
    place = 0
    for path, leaf, kind in leaves(machine.system.case.state):
        size = int(np.size(leaf))
        if not path.startswith("books.") or guest.has_books:
            for i in range(size):
                own = f"state.{path}[{i + 1}]" if np.ndim(leaf) else f"state.{path}"
                yield names.get(place + i, Output(own, path, kind, "state", place + i))
        place += size


def _inner(machine: CMachine, carried: Sequence[Output], shown: Iterable[Output]) -> Iterator[Output]:
    known = set(shown)
    yield from (each for each in carried if each not in known)
    for each in carried:
        yield Output(f"der({each.name})", each.key, None, "rate", each.place)
    for place in range(indicator_count(machine)):
        yield Output(f"event_indicator[{place + 1}]", "indicator", None, "indicator", place)


def _place(output: Output) -> tuple[str, Kind | None, str, int]:
    return output.key, output.kind, output.vector, output.place


def _outside_vectors(system: System) -> Any:
    """Properties of a system that must be the same for other values to be set in an FMU."""
    programs = [(name, p.period, p.phase, p.latency, p.trigger is None) for name, p in system.model.programs.items()]
    return system.circuit.text, programs, system.stepping


def _why_fixed(row: Any) -> str:
    if row.table == "run":
        return "it is a setting of the run"
    return "it is a course over time" if isinstance(row.value, Signal) else "it is no single number"


def _names_of(option: str, words: Sequence[str]) -> dict[str, str]:
    """Keys with the names that they have in the FMU."""
    found = {}
    for word in words:
        key, _, name = word.partition("=")
        name = name or key
        if key in found or not NAME.fullmatch(name):
            why = "given twice" if key in found else "a name consists of letters, digits, `_`, `.`, `-` and brackets"
            raise ConfigError([Fault(option, 0, word, why)])
        found[key] = name
    return found


def _require_signal(system: System, key: str) -> None:
    rows = {row.setting: row for row in system.rows if isinstance(row.value, Signal)}
    if key not in rows:
        raise ConfigError([Fault("--input", 0, key, f"no value over time{nearest(key, tuple(rows))}")])
    if not np.isfinite(rows[key].nominal):
        why = f"is prescribed as a course; set it to a number first: --set {key}=..."
        raise ConfigError([Fault("--input", 0, key, why)])


def _settable(value: Changeable, chosen: dict[str, str]) -> Settable:
    row, kind = value.row, value.row.kind
    is_signal = isinstance(row.value, Signal) and all(each.vector == "params" for each in value.followers)
    is_exact = all((each.operation, each.constant) == IDENTITY for each in value.followers)
    ends = (kind.low, kind.high) if is_exact else _tried_ends(value)
    role = TUNABLE if all(each.vector == "params" for each in value.followers) else FIXED
    if is_signal and (row.setting in chosen or not chosen):
        role = INPUT
    return Settable(
        name=chosen.get(row.setting, row.setting),
        key=row.setting,
        kind=kind,
        start=row.nominal,
        low=ends[0],
        high=ends[1],
        role=role,
        about=row.key.replace("_", " "),
        followers=value.followers,
    )


def _tried_ends(value: Changeable) -> tuple[float, float]:
    """Between which values [SI] a product or sum was tried."""
    ends = []
    for number in (value.low, value.high):
        for operation, constant in value.steps:
            number = {"+": number + constant, "*": number * constant, "/": number / constant}[operation]
        ends.append(number)
    return ends[0], ends[1]


def _outputs(system: System, taken: Set[str]) -> dict[str, Output]:
    """All numbers that can be shown, by path: states, commands of programs, and outputs of the circuit.

    A path that is taken begins with what it is: `command.encoder.missed_edges`.
    """
    found: dict[str, Output] = {}
    values = (
        ("state", system.case.state),
        ("command", system.case.command),
        ("output", example_outputs(system.model, system.case)),
    )
    for vector, value in values:
        place = 0
        for path, leaf, kind in leaves(value):
            hidden = vector != "output" and path.partition(".")[0] in ("books", "held", "modes")
            if not np.ndim(leaf) and not hidden:
                name = f"{vector}.{path}" if path in found or path in taken else path
                found[name] = Output(name, name, kind, vector, place)
            place += int(np.size(leaf))
    return found


def _refuse_same_names(model: FmuModel) -> None:
    names = [each.name for each in model.variables]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ConfigError([Fault("--output", 0, twice[0], "two variables have this name; rename one: KEY=NAME")])
