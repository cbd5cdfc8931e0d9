"""Networks that a system file draws itself: its tables [nodes], [components] and [programs]."""

import dataclasses
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import cache, lru_cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, NamedTuple, cast, get_type_hints

from vvdp.base.errors import ConfigError, Fault, NetworkError, ParameterError
from vvdp.base.kinds import (
    AddedInertia,
    Angle,
    Compliance,
    Kind,
    Mass,
    Position,
    Power,
    Pressure,
    PressureSignal,
    Speed,
    SpeedSignal,
    TemperatureSignal,
    Velocity,
    Volume,
)
from vvdp.base.params import Params, field_names
from vvdp.base.rules import without_class
from vvdp.base.signal import Signal
from vvdp.base.tables import (
    Sourced,
    Table,
    build,
    fault_at,
    inner_table,
    nearest,
    read_sourced,
    refuse_unknown,
    suggestion,
)
from vvdp.components.library import COMPONENTS, UsualOil
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.heat import HeatBalance
from vvdp.hydraulics.volume import GasExponent, GasPressure, Vessel
from vvdp.network.assembly import Assembly, InnerCircuit
from vvdp.network.component import Component, Role
from vvdp.network.network import ROOM_TEMPERATURE, Network
from vvdp.network.nodes import UNRATED, Chamber, Connection, Load, Rotor
from vvdp.network.paths import Places
from vvdp.programs.quantities import written_quantity
from vvdp.systems.drawn_programs import ProgramDrawer
from vvdp.systems.limits import Limits
from vvdp.systems.part_files import shipped_parts
from vvdp.systems.part_keys import PartType, other_type, part_keys
from vvdp.systems.part_scopes import Entries
from vvdp.systems.shares import Share, check_share, share, whole_quantity

TABLES = (
    "oil",
    "oils",
    "operation",
    "heat",
    "nodes",
    "components",
    "programs",
    "parts",
    "limits",
    "faults",
    "geometry",
)
DRAWING_WORDS = ("type", "at")


class Temperature(Params):
    """The [operation] table of a drawn network."""

    oil_temperature: TemperatureSignal


class VolumeTable(Chamber):
    """A rigid volume and its pressure at first."""

    start: Pressure


class VesselTable(Params):
    """A volume with elastic walls or gas, and its pressure at first."""

    oil_volume: Volume
    start: Pressure
    hose_compliance: Compliance = 0.0
    gas_volume: Volume = 0.0
    precharge_pressure: GasPressure = 1e5
    gas_exponent: GasExponent = 1.3


class StartPressure(Params):
    """The pressure in a component at first."""

    start: Pressure


class JunctionTable(Params):
    """A place without oil; nothing is to be said of it."""


class SourceTable(Params):
    """A pressure source, or a tank that is not at the oil's reference pressure."""

    pressure: PressureSignal


class ShaftTable(Params):
    """A shaft that turns freely, its own inertia beside that of what it joins, and how it starts."""

    inertia: AddedInertia = 0.0
    angle: Angle = 0.0
    speed: Speed = 0.0


class DrivenShaftTable(Params):
    """A shaft whose speed is prescribed; beyond the rated power of what drives it, a run warns."""

    speed: SpeedSignal
    rated_power: Power = UNRATED


class RodTable(Params):
    """A mass that moves along a line beside that of what it joins, and how it starts."""

    mass: Mass = 0.0
    position: Position = 0.0
    velocity: Velocity = 0.0


def _add_volume(net: Network, name: str, v: VolumeTable, oil: Oil) -> None:
    net.volume(name, Chamber(volume=v.volume), start=v.start, oil=oil)


def _add_vessel(net: Network, name: str, v: VesselTable, oil: Oil) -> None:
    fields = {field.name: getattr(v, field.name) for field in dataclasses.fields(Vessel)}
    net.volume(name, Vessel(**fields), start=v.start, oil=oil)


def _add_junction(net: Network, name: str, v: JunctionTable, oil: Oil) -> None:
    net.junction(name, oil)


def _add_tank(net: Network, name: str, v: SourceTable | None, oil: Oil) -> None:
    net.tank(name, v.pressure if v else None, oil)


def _add_source(net: Network, name: str, v: SourceTable, oil: Oil) -> None:
    net.pressure_source(name, v.pressure, oil)


def _add_shaft(net: Network, name: str, v: ShaftTable, oil: Oil) -> None:
    net.shaft(name, Rotor(inertia=v.inertia), angle=v.angle, speed=v.speed)


def _add_driven_shaft(net: Network, name: str, v: DrivenShaftTable, oil: Oil) -> None:
    net.driven_shaft(name, v.speed, v.rated_power)


def _add_rod(net: Network, name: str, v: RodTable, oil: Oil) -> None:
    net.rod(name, Load(mass=v.mass), position=v.position, velocity=v.velocity)


@dataclasses.dataclass(frozen=True)
class NodeType:
    """A type of node in a file: the class of its table, and how it is added."""

    table: type[Params]
    add: Callable[..., None]
    holds_oil: bool = True


NODES: Mapping[str, NodeType] = {
    "volume": NodeType(VolumeTable, _add_volume),
    "vessel": NodeType(VesselTable, _add_vessel),
    "junction": NodeType(JunctionTable, _add_junction),
    "tank": NodeType(SourceTable, _add_tank),
    "pressure-source": NodeType(SourceTable, _add_source),
    "shaft": NodeType(ShaftTable, _add_shaft, holds_oil=False),
    "driven-shaft": NodeType(DrivenShaftTable, _add_driven_shaft, holds_oil=False),
    "rod": NodeType(RodTable, _add_rod, holds_oil=False),
}


class GivenTable:
    """What a file gives under a path; equal to another one with the same text."""

    def __init__(self, part: Mapping[str, object]) -> None:
        self.part, self.text = part, repr(part)

    def __hash__(self) -> int:
        return hash(self.text)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, GivenTable) and self.text == other.text


@lru_cache(maxsize=4096)
def sound_table(cls: Any, path: str, given: GivenTable) -> tuple[Any, tuple[Sourced, ...]]:
    """The values of a table and where each comes from, read once however often a circuit is drawn with other values.

    Raises ConfigError where something is wrong with it.
    """
    faults: list[Fault] = []
    found, rows = build(cls, given.part, path, Table("", {}, {}), faults)
    if faults:
        raise ConfigError(faults)
    return found, tuple(rows)


class Drawing(NamedTuple):
    """What a file draws: the network, where each value comes from, and tables that are not part of the circuit."""

    network: Network | None
    rows: list[Sourced]
    tables: dict[str, Params]


class Drawer(ProgramDrawer):
    """Draws one file: what it has found wrong so far, and where each value comes from."""

    def __init__(self, content: Mapping[str, object], origin: Table, faults: list[Fault], folder: Path) -> None:
        self.content, self.origin, self.faults, self.folder = content, origin, faults, folder
        self.rows: list[Sourced] = []
        self.shares: list[Share] = []

    def network(self) -> Network | None:
        """The network of the file; None where something is wrong."""
        oil = self._table(UsualOil, "oil", self._inner("oil"))
        heat = self._given_table(Temperature, "operation")
        oils = {name: self._table(Oil, f"oils.{name}", part) for name, part in self._parts("oils")}
        values: dict[str, Params] = {name: found for name, found in oils.items() if found}
        if balance := self._given_table(HeatBalance, "heat"):
            values["heat"] = balance
        net = Network(oil or UsualOil(), temperature=heat.oil_temperature if heat else ROOM_TEMPERATURE, **values)
        for name, part in self._parts("parts"):
            self._add_circuit(net, name, part["drawn"])
        for name, part in self._validly_named_parts(net, "nodes"):
            self._add_node(net, name, part, {n: o or net.oil for n, o in oils.items()})
        for name, part in self._validly_named_parts(net, "components"):
            self._add_component(net, name, part)
        self._add_programs(net, dict(self._validly_named_parts(net, "programs")))
        nothing = (("rated_power", UNRATED), ("inertia", 0.0))
        self.rows = [row for row in self.rows if row.note != "default" or (row.key, row.value) not in nothing]
        places = Places(net)
        for each in self.shares if not self.faults else ():
            self._try(each.path, partial(check_share, places, each))
        for name in net.programs if not self.faults else ():
            self._refuse_impossible(net, name)
        return None if self.faults else net

    def _refuse_impossible(self, net: Network, name: str) -> None:
        """A fault, at the path that it names, if the circuit cannot do what a program asks of it."""
        if refuse := net.programs[name].type.refuse:
            try:
                refuse(net, name)
            except ParameterError as problem:
                path, _, words = str(problem).partition(": ")
                self._fault(path, words)

    def _add_circuit(self, net: Network, name: str, drawn: Entries) -> None:
        net.circuits[name] = InnerCircuit(drawn["source"], drawn["ports"], frozenset(drawn["names"]))
        self._place(net, name, f"parts.{name}", drawn)

    def limits(self) -> Limits | None:
        """What is watched and reported; None where the file says nothing."""
        found: Limits | None = self._given_table(Limits, "limits")
        return found

    def _given_table(self, cls: type[Any], name: str) -> Any:
        """The values of a table of the file; None where there is none."""
        faults = len(self.faults)
        given = self._inner(name)
        return self._table(cls, name, given) if name in self.content and len(self.faults) == faults else None

    def _inner(self, table: str) -> Mapping[str, object]:
        return inner_table(self.content, table, self.origin, self.faults)

    def _parts(self, table: str) -> list[tuple[str, Entries]]:
        found = self._inner(table)
        for name, part in found.items():
            if not isinstance(part, Mapping):
                self._fault(f"{table}.{name}", f"{part!r} is not a table; expected {{ type = ... }}")
        return [(name, part) for name, part in found.items() if isinstance(part, Mapping)]

    def _validly_named_parts(self, net: Network, table: str) -> Iterator[tuple[str, Mapping[str, object]]]:
        """The parts of a table whose name can be given; of another one nothing but its name is reported."""
        for name, part in self._parts(table):
            path = f"{table}.{name}"
            self._try(path, partial(net.check_name, name))
            if not self._has_faults(path):
                yield name, part

    def _fault(self, path: str, message: str) -> None:
        self.faults.append(fault_at(self.origin, path, message))

    def _table(self, cls: type[Any], path: str, part: Any) -> Any:
        try:
            found, rows = sound_table(cast("Hashable", cls), path, GivenTable(part))
        except (ConfigError, ValueError):  # a number of thousands of digits has no text
            found, own = build(cls, part, path, self.origin, self.faults)
            rows = tuple(own)
        self.rows += rows
        return found

    def _type(self, path: str, part: Mapping[str, object], types: Mapping[str, object]) -> Any:
        word = part.get("type")
        if not isinstance(word, str) or word not in types:
            meant = nearest(str(word), list(types))
            if isinstance(word, str) and word in shipped_parts():
                meant = f"; it is a part, which stands in a table [parts.{path.partition('.')[2]}]"
            unknown = f"type {word!r} is unknown{meant}"
            self._fault(path, self._type_hint(path, types) if word is None else unknown)
            return None
        return types[word]

    def _type_hint(self, path: str, types: Mapping[str, object]) -> str:
        """What is stated of a part without a type: perhaps the name of another one is meant."""
        table, _, name = path.partition(".")
        others = [other for other, part in self._parts(table) if "type" in part]
        return "has no type" + (suggestion(name, others) or nearest("", list(types)))

    def _add_node(self, net: Network, name: str, part: Mapping[str, object], oils: Mapping[str, Oil]) -> None:
        path = f"nodes.{name}"
        kind = self._type(path, part, NODES)
        if kind is None:
            return
        words = (*DRAWING_WORDS, "oil") if kind.holds_oil else DRAWING_WORDS
        oil = oils.get(str(part["oil"])) if "oil" in part and kind.holds_oil else net.oil
        if oil is None:
            self._fault(f"{path}.oil", f"{part['oil']!r} is no oil{nearest(str(part['oil']), list(oils))}")
            return
        own = {key: value for key, value in part.items() if key not in words}
        values = None if kind is NODES["tank"] and not own else self._values(kind.table, path, own)
        if values is not None or (not own and kind is NODES["tank"]):
            self._try(path, lambda: kind.add(net, name, values, oil))
        self._place(net, name, path, part)

    def _values(self, cls: type[Params], path: str, own: Mapping[str, object]) -> Any:
        """The values of a node; what a source or a driven shaft prescribes may also be `{ from = "spool.speed" }`."""
        match own:
            case {"pressure": {"from": str() as source, **rest}} if cls is SourceTable and not rest:
                return SimpleNamespace(pressure=source)
            case {"speed": {"from": str() as source, **rest}} if cls is DrivenShaftTable and not rest:
                return SimpleNamespace(speed=source, rated_power=UNRATED)
        return self._table(cls, path, own)

    def _place(self, net: Network, name: str, path: str, part: Mapping[str, object]) -> None:
        match part.get("at"):
            case None:
                return
            case [int() | float() as x, int() | float() as y]:
                net.place(name, x, y)
            case other:
                self._fault(f"{path}.at", f"{other!r}; expected [column, row] of the diagram's grid")

    def _try(self, path: str, add: Callable[[], None]) -> None:
        try:
            add()
        except (NetworkError, ParameterError) as problem:
            words = without_class(str(problem).removeprefix(f"{path.rpartition('.')[2]}: "))
            key, _, rest = words.partition(": ")
            stands_there = f"{path}.{key}" in self.origin.lines
            self._fault(f"{path}.{key}" if stands_there else path, rest if stands_there else words)

    def _add_component(self, net: Network, name: str, part: Entries) -> None:
        path = f"components.{name}"
        component: Component | Assembly | None = self._type(path, part, COMPONENTS)
        if isinstance(component, Assembly):
            self._add_assembly(net, name, part, component)
        if component is None or isinstance(component, Assembly):
            return
        if not self._has_own_keys(path, part, COMPONENTS):
            return
        values = [
            self._table(cls, path, {k: part[k] for k in field_names(cls) if k in part}) for cls in component.params
        ]
        joints = {key: part[key] for key in component.ports if key in part}
        joints |= self._own_inputs(component, path, part, values)
        start = self._start(component, path, part.get("start"))
        ends = [node for node in joints.values() if isinstance(node, str)]
        if not self._has_faults(path) and not any(self._has_faults(f"nodes.{node}") for node in ends):
            self._try(path, lambda: net.add(name, component, *values, start=start, **joints))
        self._place(net, name, path, part)

    def _add_assembly(self, net: Network, name: str, part: Mapping[str, object], assembly: Assembly) -> None:
        path = f"components.{name}"
        fields = field_names(assembly.params)
        if not self._has_own_keys(path, part, COMPONENTS):
            return
        values = self._table(assembly.params, path, {key: part[key] for key in fields if key in part})
        start = None
        if assembly.holds_oil:
            start = self._table(StartPressure, path, {"start": part["start"]} if "start" in part else {})
        nodes = {port: part[port] for port in assembly.ports if port in part}
        inputs = self._inputs(assembly.inputs, path, {key: part[key] for key in assembly.inputs if key in part})
        if not self._has_faults(path) and not any(self._has_faults(f"nodes.{node}") for node in nodes.values()):
            self._try(path, lambda: assembly.add(net, name, values, nodes | inputs, start and start.start))
        self._place(net, name, path, part)

    def _has_own_keys(self, path: str, part: Mapping[str, object], types: Mapping[str, PartType]) -> bool:
        """Whether the keys of a part are not those of another type; unknown ones are reported."""
        word = str(part["type"])
        if meant := other_type(word, part, types):
            self._fault(path, meant)
            return False
        needed, known = part_keys(types[word])
        refuse_unknown(part, known, path, self.origin, self.faults, needed - part.keys())
        return True

    def _has_faults(self, path: str) -> bool:
        return any(fault.key == path or fault.key.startswith(f"{path}.") for fault in self.faults)

    def _own_inputs(
        self, component: Component, path: str, part: Mapping[str, object], values: Sequence[Params]
    ) -> dict[str, Any]:
        """Sources of the inputs of a component, or of the quantities that are said instead of them."""
        others = component.alternatives
        kinds = {argument.name: argument.kind for argument in (*component.inputs, *others.values())}
        given = self._inputs(kinds, path, {key: part[key] for key in kinds if key in part})
        for name, other in others.items():
            if other.name in given and name in given:
                self._fault(f"{path}.{other.name}", f"contradicts {name}; give one of the two")
            elif other.name in given:
                function = component.given_by[name]
                classes = [each.type for each in component.arguments_of(function) if each.role is Role.PARAMS]
                own = (next((each for each in values if isinstance(each, cls)), None) for cls in classes)
                given[name] = Connection(function, (given[other.name], *filter(None, own)))
            given.pop(other.name, None)
        return given

    def _inputs(self, known: Entries, path: str, given: Mapping[str, object]) -> dict[str, Any]:
        """Sources of inputs: `{ from = "spool.speed" }`, that `per` a value, or a signal."""
        found: dict[str, Any] = {}
        signals = {}
        for key, entry in given.items():
            match entry:
                case {"from": str() as source, **rest} if not rest:
                    found[key] = source
                case {"from": str() as source, "per": whole, **rest} if not rest:
                    found[key] = self._share(f"{path}.{key}", source, whole, known[key])
                case _:
                    signals[key] = entry
        kinds = tuple((key, known[key]) for key in signals)
        table = self._table(_signals_class(kinds), path, signals) if signals else None
        return found | ({key: getattr(table, key) for key in signals} if table else {})

    def _share(self, path: str, source: str, entry: object, of: Kind) -> Connection | None:
        """What is read at a source, per the value of an entry; None where that is none."""
        try:
            whole = whole_quantity(written_quantity(entry))
            row = read_sourced(path, "per", whole, Signal, entry)
        except ParameterError as problem:
            self._fault(f"{path}.per", str(problem))
            return None
        assert isinstance(row.value, Signal)
        if 0.0 in row.value.extremes:
            self._fault(f"{path}.per", "must not be 0")
        self.rows.append(row)
        self.shares.append(Share(path, source, whole, of))
        return Connection(share, (source, row.value))

    def _start(self, component: Component, path: str, given: Any) -> Any:
        """The state that a component starts from; None without a table `start`."""
        if given is None:
            return None
        if component.state is None or not isinstance(given, Mapping):
            self._fault(
                f"{path}.start", "this component has no state" if component.state is None else "expected a table"
            )
            return None
        hints = get_type_hints(component.state, include_extras=True)
        table = self._table(type("Start", (Params,), {"__annotations__": hints}), f"{path}.start", given)
        return component.state(**{key: getattr(table, key) for key in hints}) if table else None


@cache
def _signals_class(kinds: tuple[tuple[str, Kind], ...]) -> type[Params]:
    """A parameter class with a signal for each name."""
    return type("Inputs", (Params,), {"__annotations__": {key: Annotated[Signal, kind] for key, kind in kinds}})


def draw_network(content: Mapping[str, object], table: Table, faults: list[Fault], folder: Path = Path()) -> Drawing:
    """What a file draws; modules that it names are looked for in `folder`. Faults are appended to `faults`."""
    drawer = Drawer(content, table, faults, folder)
    limits = drawer.limits()
    return Drawing(drawer.network(), drawer.rows, {} if limits is None else {"limits": limits})
