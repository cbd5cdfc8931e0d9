"""Reading a system: from a shipped name or a file to checked values and a circuit that is ready to run."""

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from vvdp.base.display import readable
from vvdp.base.errors import ConfigError, Fault, NetworkError, ParameterError
from vvdp.base.kinds import Ratio, Time
from vvdp.base.manifest import Directory
from vvdp.base.params import Params
from vvdp.base.rules import without_class
from vvdp.base.signal import Signal
from vvdp.base.tables import (
    Sourced,
    Table,
    build,
    fault_at,
    parsed_table,
    read_table,
    refuse_unknown,
    suggestion,
    with_settings,
)
from vvdp.geometry.shape import ValveShape
from vvdp.geometry.shape_tables import NAME as SHAPE
from vvdp.geometry.shape_tables import read_shape
from vvdp.network.build import Circuit
from vvdp.network.build import build as build_circuit
from vvdp.network.network import Network
from vvdp.network.sense import check_sense
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Method, Stepping
from vvdp.systems.assumed import assumed_rows, with_idle_speeds
from vvdp.systems.circuits import (
    NetworkFunction,
    table_slots,
)
from vvdp.systems.drawing import TABLES, Drawing, Temperature, draw_network
from vvdp.systems.expansion import expand
from vvdp.systems.extras import Extras
from vvdp.systems.fault_tables import FAULTS, FaultReader
from vvdp.systems.faults import NamedFault, OtherValue, change_entries, change_tables, faulty_network
from vvdp.systems.function_circuits import (
    DRAWN,
    ReadBefore,
    circuit_function,
    keys_of,
    network_of,
    read_tables,
)
from vvdp.systems.options import duration_of, lasting, option_keys, without_other_position
from vvdp.systems.own_modules import OwnModule, folder_of_saved, own_module
from vvdp.systems.own_programs import absolute_fmus, own_code
from vvdp.systems.part_scopes import as_table
from vvdp.systems.program_reports import reported_programs
from vvdp.systems.short_paths import full_settings, with_full_paths
from vvdp.systems.spool_travel import rotary_valves
from vvdp.valve.rotary import RotaryValve

HEADINGS = ("title", "circuit")

SAMPLES_PER_SWING = 20
"""Samples that a swing of the oil's temperature needs at least."""


class RunTable(Params):
    """The [run] table: how long, how exactly, what is recorded, from when on means are taken."""

    until: Time
    average_from: Time = 0.0
    relative_tolerance: Ratio = 1e-6
    sample_period: Time = 1e-3
    record_interval: Time = 1e-3
    window: Time = 0.25
    window_interval: Time = 2e-5
    longest_step: Time = 1e6

    def check(self) -> None:
        if not self.average_from < self.until:
            raise ParameterError(f"average_from {self.average_from:g} s; expected less than until = {self.until:g} s")

    def stepping(self, method: Method) -> Stepping:
        """How the run is stepped. Raises ParameterError where that cannot be."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Stepping(**values, method=method)


def _check_temperature(temperature: Signal, sample_period: float) -> None:
    """Raises ParameterError where an oil's temperature swings too fast for what depends on it, read once per sample."""
    fastest = max(temperature.frequency, default=0.0)
    if fastest * sample_period * SAMPLES_PER_SWING > 1.0:
        raise ParameterError(
            f"run.sample_period = {sample_period:g} s: the oil's temperature swings at {fastest:g} Hz and is read once "
            f"per sample; expected at most {1.0 / (SAMPLES_PER_SWING * fastest):.2g} s"
        )


@dataclass(frozen=True)
class System:
    """A system ready to run: its circuit with values, and where each value comes from.

    `function` drew the network from the `tables`; None where the file draws it itself. Modules that the file names are
    looked for in `folder`. `lengths` is what the file says of the valve as a solid, `faults` what fails in the circuit.
    `module` is the one that the file names, as it was run.
    """

    name: str
    title: str
    circuit: Circuit
    stepping: Stepping
    tables: Mapping[str, Any]
    rows: tuple[Sourced, ...]
    content: Mapping[str, Any]
    folder: Path = Path()
    function: NetworkFunction | None = None
    lengths: Mapping[str, object] | None = None
    faults: tuple[NamedFault, ...] = ()
    module: OwnModule | None = None

    @property
    def model(self) -> Model:
        """The plain functions of the circuit."""
        return self.circuit.model

    @property
    def case(self) -> Case:
        """The values that the circuit starts from."""
        return self.circuit.case

    @property
    def average_from(self) -> float:
        """When its means begin [s]."""
        return self.stepping.means_from(self.stepping.until)

    @cached_property
    def extras(self) -> Extras | None:
        """The additions of its function or its programs; None where there are none."""
        extras = self.circuit.network.extras
        found: Extras | None = extras and extras(self, self.tables)
        return found or reported_programs(self, self.stepping.sample_period)

    @cached_property
    def shape(self) -> ValveShape | None:
        """The valve as a solid, makeable or not; None where the file has no table [geometry]."""
        if self.lengths is None:
            return None
        valve = rotary_valves(self.circuit.network, self.tables)[0]
        found = read_shape(valve, self.lengths, self.table, [])
        return None if found is None else found.shape

    @property
    def circuit_name(self) -> str:
        """The name of the circuit in the file; where it draws it itself, how many parts it has."""
        network = self.circuit.network
        count = f"{len(network.nodes)} nodes, {len(network.parts)} components"
        return f"drawn, {count}" if self.function is None else str(self.content["circuit"])

    @property
    def assumptions(self) -> tuple[Sourced, ...]:
        """The values that are merely assumed and have an effect."""
        return assumed_rows(self.rows)

    @property
    def uncertainties(self) -> tuple[Sourced, ...]:
        """The values for which a range is given."""
        return tuple(row for row in self.rows if row.range is not None)

    @property
    def table(self) -> Table:
        """The text that it was read from, settings included."""
        return Table(self.name, self.content, {})

    def read_from(self, table: Table) -> "System":
        """The system of another text in the same place: tables that stay are not read again.

        Raises ConfigError with all its faults.
        """
        return built_system(table, self.name, self.folder, self)

    def __reduce__(self) -> tuple[Any, ...]:
        """A system travels to other processes as its text: its functions are written again where it arrives."""
        return built_system, (self.table, self.name, self.folder.absolute())


@cache
def shipped_systems(group: str = "data") -> Mapping[str, str]:
    """Names of the shipped systems and their texts; `group` "practice": circuits from practice, "measured": rigs."""
    folder = resources.files("vvdp.systems") / group
    files = sorted(folder.iterdir(), key=lambda each: each.name)
    return MappingProxyType({each.name.removesuffix(".toml"): each.read_text("utf-8") for each in files})


def named_systems() -> dict[str, str]:
    """All that a name stands for: shipped systems, circuits from practice and measured rigs, with their texts."""
    return {**shipped_systems(), **shipped_systems("practice"), **shipped_systems("measured")}


def source_text(name: str) -> str:
    """The text of a system, by shipped name or path. Raises ConfigError where there is none."""
    texts = named_systems()
    if name in texts:
        return texts[name]
    read_table(Path(name))
    return Path(name).read_text("utf-8")


def system_table(name: str) -> Table:
    """The parsed text of a system, by shipped name or path. Raises ConfigError where there is none."""
    texts = named_systems()
    if name in texts:
        return parsed_table(texts[name], f"{name}.toml")
    path = Path(name)
    if not os.path.lexists(path) and path.suffix != ".toml":
        known = ", ".join(texts)
        meant = suggestion(name, texts)
        raise ConfigError([Fault(name, 0, "", f"neither a shipped system ({known}) nor a file{meant}")])
    return read_table(path)


def load_system(name: str, settings: Sequence[str] = (), until: str | None = None) -> System:
    """The system called `name` (shipped, or the path of a file), with `settings` of the form table.key=value.

    Raises ConfigError naming every fault at once: file, line, key, value, and what was expected.
    """
    plain = system_table(name)
    place = readable(Path(name).stem), Path(name).parent
    if settings:
        settings = full_settings(plain, settings)
    table = with_settings(without_other_position(plain, settings), list(settings)) if settings else plain
    if until is not None:
        if "run.until" in option_keys(settings):
            _check_overridden(table, place, {"run.until"})
        table = lasting(table, until, settings)
    try:
        system = built_system(table, *place)
    except ConfigError as problem:
        raise (_from_options(problem, plain, place) if settings else problem) from None
    if table is not plain:
        _check_overridden(plain, place, {*option_keys(settings), *(("run.until",) if until is not None else ())})
    return system


def _from_options(problem: ConfigError, plain: Table, place: tuple[str, Path]) -> ConfigError:
    """The faults of a system with settings; those that the file alone does not have are placed at the option."""
    try:
        built_system(plain, *place)
        own: set[tuple[str, str]] = set()
    except ConfigError as of_file:
        own = {(fault.key, fault.message) for fault in of_file.faults}
    return ConfigError([
        fault if (fault.key, fault.message) in own or not fault.line else Fault("--set", 0, fault.key, fault.message)
        for fault in problem.faults
    ])  # fmt: skip


def _check_overridden(plain: Table, place: tuple[str, Path], overridden: set[str]) -> None:
    """Raises ConfigError where a value that an option stands in for is none: it would hide there."""
    try:
        built_system(plain, *place)
    except ConfigError as problem:
        hidden = [fault for fault in problem.faults if fault.key in overridden and fault.key in plain.lines]
        if hidden:
            raise ConfigError(hidden) from None


def built_system(table: Table, name: str, folder: Path = Path(), before: System | None = None) -> System:
    """The system that a parsed table describes; modules that it names are looked for in `folder`.

    before  a system that may have some of its tables
    Raises ConfigError with all its faults.
    """
    faults: list[Fault] = []
    expansion = expand(table, folder)
    written = absolute_fmus(expansion.table, folder)
    full = with_full_paths(written, faults)
    table = full.table
    content = dict(table.content)
    run, method = _run_table(content.pop("run", None), table, faults)
    function = circuit_function(table, folder, faults)
    _refuse_unknown_tables(function, table, full.names, faults)
    content.pop(FAULTS, None)
    lengths = None if function is not None and SHAPE in table_slots(function) else content.pop(SHAPE, None)
    drawn = _draw(function, content, table, faults, folder, before)
    drawing, failing = _fail(drawn, function, content, table, faults, folder)
    network, rows, values = drawing
    if run is not None:
        rows += [row for row in run[1] if (row.key, row.note) != ("longest_step", "default")]  # none
    if network is not None and lengths is not None:
        rows += _shape_rows(lengths, rotary_valves(network, values), table, faults)
    built = None
    if network is not None and run is not None and not faults:
        built = _circuit_and_stepping(network, function is None, (run[0], method), table, faults)
    if faults or built is None:
        raise ConfigError(list(dict.fromkeys(expansion.locate(full.locate(fault)) for fault in faults)))
    return System(
        name=name,
        title=str(table.content.get("title", name)),
        circuit=built[0],
        stepping=built[1],
        tables=values,
        rows=full.rows(rows),
        content=written.content,
        folder=folder,
        function=function,
        lengths=lengths,
        faults=failing,
        module=own_module(str(own_code(table.content)), folder),
    )


def _circuit_and_stepping(
    network: Network, is_drawn: bool, run: tuple[RunTable, Method], table: Table, faults: list[Fault]
) -> tuple[Circuit, Stepping] | None:
    """The circuit of a network, which has to make sense where a file draws it, and how it is stepped; None, and a
    fault, where that cannot be."""
    try:
        if is_drawn:
            check_sense(network)
        stepping = run[0].stepping(run[1])
        _check_temperature(network.temperature, stepping.sample_period)
        return build_circuit(network), stepping
    except (NetworkError, ParameterError) as problem:
        faults.append(_locate_fault(without_class(str(problem)), table))
        return None


def _refuse_unknown_tables(
    function: NetworkFunction | None, table: Table, names: Collection[str], faults: list[Fault]
) -> None:
    """Append a fault for each key and table of a file that nothing reads, and for a title that is no text; `names` are
    tables that its own ones may have been meant for."""
    if not isinstance(title := table.content.get("title", ""), str):
        faults.append(fault_at(table, "title", f"{title!r} is not a text in quotes"))
    if function is None and set(DRAWN).isdisjoint(table.content):
        return  # it is not known which tables there should be
    own = TABLES if function is None else (*table_slots(function), FAULTS, SHAPE)
    meant = [f"run.{key}" for key in (*keys_of(RunTable), "method")]
    if function is None:
        meant += [f"operation.{key}" for key in keys_of(Temperature)]
    refuse_unknown(table.content, (*HEADINGS, *own, "run", *meant), "", table, faults, names)


def saved_system(directory: Directory, name: str, recorded: Any, trust: str = "") -> System:
    """The system in a result directory; of code of a user's own only what may be run again (`systems.own_modules`).

    recorded  what meta.json says of the module that drew the circuit
    trust     a module that the user lets run, by name or file
    Raises ConfigError with all its faults, UntrustedModuleError where there is code that may not be run.
    """
    place = directory.path / "system.toml"
    table = parsed_table(directory.text("system.toml"), str(place))
    return built_system(table, name, folder_of_saved(own_code(table.content), str(place), recorded, trust))


def _draw(
    function: NetworkFunction | None,
    content: Mapping[str, object],
    table: Table,
    faults: list[Fault],
    folder: Path,
    before: System | None,
) -> Drawing:
    """The drawing of a file, by its function or by itself."""
    if function is not None:
        known = None if before is None else ReadBefore(before.content, before.tables, before.rows)
        values, rows = read_tables(function, content, table, faults, known)
        return Drawing(None if faults else network_of(function, values, table, faults), rows, values)
    if set(DRAWN).isdisjoint(content):
        return Drawing(None, [], {})
    found = draw_network(content, table, faults, folder)
    return found if found.network is None else found._replace(rows=with_idle_speeds(found.rows, found.network))


def _fail(
    drawing: Drawing,
    function: NetworkFunction | None,
    content: Mapping[str, object],
    table: Table,
    faults: list[Fault],
    folder: Path,
) -> tuple[Drawing, tuple[NamedFault, ...]]:
    """The drawing of a file with the faults that it states."""
    if drawing.network is None or FAULTS not in table.content or faults:
        return drawing, ()
    reader = FaultReader(drawing.network, None if function is None else drawing.tables, table, faults)
    failing, wrong = reader.faults(), list[Fault]()

    def redraw(others: Sequence[OtherValue]) -> Network | None:
        if function is None:
            return draw_network(change_entries(content, others), table, wrong, folder).network
        return network_of(function, change_tables(drawing.tables, others), table, wrong)

    network = None
    try:
        network = None if faults else faulty_network(drawing.network, drawing.tables, failing, redraw)
    except (NetworkError, ParameterError) as problem:
        wrong.append(fault_at(table, FAULTS, without_class(str(problem))))
    where = next((f"{FAULTS}.{each.name}" for each in failing if isinstance(each.fault, OtherValue)), FAULTS)
    faults += [fault_at(table, where, f"the circuit cannot be drawn with it: {each.message}") for each in wrong]
    return Drawing(network, [*drawing.rows, *reader.rows], drawing.tables), failing


def _shape_rows(lengths: Any, valves: Sequence[RotaryValve], table: Table, faults: list[Fault]) -> Iterator[Sourced]:
    """Where each value of the table [geometry] comes from; whether it can be made is not asked here."""
    if not isinstance(lengths, Mapping):
        faults.append(fault_at(table, SHAPE, f"{lengths!r} is not a table"))
    elif len(valves) != 1:
        faults.append(fault_at(table, SHAPE, f"the circuit has {len(valves)} rotary valves; expected one"))
    elif (found := read_shape(valves[0], lengths, table, faults)) is not None:
        yield from (row for row in found.rows if row.key in lengths)


def _locate_fault(message: str, table: Table) -> Fault:
    """A fault of the whole network at the line of the node, component or program with whose name the message begins."""
    word, _, key = message.partition(":")[0].partition(" ")[0].partition(".")
    for group in ("nodes", "components", "programs"):
        for path in (f"{group}.{word}.{key}", f"{group}.{word}"):
            if path in table.lines:
                return Fault(table.place, table.lines[path], path, message.removeprefix(f"{word}: "))
        if word in as_table(table.content.get(group)):  # of a part: its file and use are found by the path
            return Fault(table.place, 0, f"{group}.{word}.{key}".rstrip("."), message.removeprefix(f"{word}: "))
    return Fault(table.place, 0, "", message)


def _run_table(given: Any, table: Table, faults: list[Fault]) -> tuple[tuple[RunTable, list[Sourced]] | None, Method]:
    """The [run] table and its method."""
    if not isinstance(given, Mapping):
        what = "missing table" if given is None else f"{given!r} is not a table"
        faults.append(Fault(table.place, table.lines.get("run", 0), "run", what))
        return None, Method.AUTOMATIC
    content = dict(given)
    method = _method(content.pop("method", "automatic"), table, faults)
    if "average_from" not in content and "until" in content:
        with suppress(ParameterError):  # `build` says what is wrong with it
            content["average_from"] = f"{0.5 * duration_of(content['until'])!r} s"
    found, rows = build(RunTable, content, "run", table, faults)
    rows = [replace(row, status="given") if row.note == "default" else row for row in rows]  # not on the circuit
    return (None if found is None else (found, rows)), method


def _method(word: object, table: Table, faults: list[Fault]) -> Method:
    names = {method.name.lower(): method for method in Method}
    if isinstance(word, str) and word in names:
        return names[word]
    line = table.lines.get("run.method", 0)
    faults.append(Fault(table.place, line, "run.method", f"{word!r}; expected one of {', '.join(names)}"))
    return Method.AUTOMATIC
