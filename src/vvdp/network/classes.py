"""The NamedTuples and the parameter class of a written network."""

from functools import cached_property, lru_cache
from typing import Annotated, Any, NamedTuple, get_type_hints

from vvdp.base.conservation import Books, Nothing
from vvdp.base.errors import NetworkError
from vvdp.base.kinds import (
    EXCHANGED_ENERGY,
    FLOW,
    FRACTION,
    POWER,
    PRESSURE_LEVEL,
    RATIO,
    VOLUME,
    Angle,
    Duration,
    Energy,
    ExchangedEnergy,
    FinePressure,
    Inertia,
    Kind,
    Kink,
    Mass,
    Pressure,
    PressureTime,
    Speed,
    TankVolume,
    Temperature,
    Volume,
)
from vvdp.base.params import Params
from vvdp.fluid.dissolving import FREE_AIR, FreeAir
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.ports import Medium, RodState, ShaftState
from vvdp.network.heat import TOTALS, warm_volumes
from vvdp.network.nodes import (
    DrivenShaft,
    HydraulicNode,
    Junction,
    OilVolume,
    PressureSource,
    Rod,
    Shaft,
    Tank,
    can_boil,
    free_air_name,
    has_free_air,
    is_held,
)
from vvdp.network.paths import Places, StartValue, actual_flows, averaged_flows, part_outputs, paths_of, tank_exchanges
from vvdp.simulation.values import blank, names

INTEGRALS = {FLOW: TankVolume, PRESSURE_LEVEL: PressureTime, FRACTION: Duration, RATIO: Duration, POWER: Energy}
"""What the integrals over time of a kind are."""
SweptVolume = Annotated[float, Kind("volume that went by", "m^3", -1e6, 1e6, "1 l", scale=1e-6, accumulates=True)]


class Classes:
    """The classes of a network's state, books, outputs, command and parameters."""

    def __init__(self, places: Places) -> None:
        self.places = places
        self.network = places.network

    @cached_property
    def supplied_class(self) -> type:
        """Energy from outside: by tanks, sources, driven shafts and parts."""
        given = [n for n, node in self.network.nodes.items() if isinstance(node, Tank | PressureSource | DrivenShaft)]
        given += [p.name for p in self.network.parts.values() if "supplied" in names(p.component.result)]
        return named_tuple("Supplied", dict.fromkeys(given, Energy))

    @cached_property
    def spent_parts(self) -> dict[str, type]:
        """For each part with several losses, these."""
        return {
            part.name: named_tuple(
                f"{_title(part.name)}Spent", {n: _energy(kind) for n, kind in part.component.losses.items()}
            )
            for part in self.network.parts.values()
            if part.component.losses and "" not in part.component.losses
        }

    @cached_property
    def spent_class(self) -> type:
        """Energy dissipated, by part."""
        losses = {p.name: p.component.losses for p in self.network.parts.values() if p.component.losses}
        hints = {n: _energy(kinds[""]) if "" in kinds else self.spent_parts[n] for n, kinds in losses.items()}
        hints |= {free_air_name(n): ExchangedEnergy for n, node in self.network.nodes.items() if has_free_air(node)}
        return named_tuple("Spent", hints)

    @cached_property
    def oil_volumes(self) -> type:
        """Reported quantities of each oil where there are several."""
        return named_tuple("OilVolumes", dict.fromkeys(self.places.oils, TankVolume))

    @cached_property
    def totals(self) -> type:
        """Integrals from which means are taken."""
        hints: dict[str, Any] = {}
        for name, node in self.network.nodes.items():
            if isinstance(node, HydraulicNode):
                _join(hints, name, {f"{name}_pressure": PressureTime})
        boiling = (f"{n}_vapour" for n, node in self.network.nodes.items() if can_boil(node))
        aerated = (free_air_name(n) for n, node in self.network.nodes.items() if has_free_air(node))
        _join(hints, "the oil", dict.fromkeys(boiling, _integral(VOLUME)) | dict.fromkeys(aerated, _integral(FREE_AIR)))
        for part in self.network.parts.values():
            flows = [f"{part.name}_{n}" for n in averaged_flows(part)]
            actual = [f"{part.name}_{n}" for n in actual_flows(part)]
            fresh: dict[str, Any] = dict.fromkeys(flows, TankVolume) | dict.fromkeys(actual, SweptVolume)
            fresh |= {f"{part.name}_{n}": _integral(part.component.outputs[n]) for n in part.component.averages}
            _join(hints, part.name, fresh)
        if warm_volumes(self.network):
            _join(hints, "the heat", dict.fromkeys(TOTALS, ExchangedEnergy))
        return named_tuple("Totals", hints)

    @cached_property
    def state(self) -> type:
        """The state: pressures, shafts, rods, states of parts, books."""
        hints: dict[str, Any] = {}
        for name, node in self.network.nodes.items():
            match node:
                case OilVolume():
                    hints[name] = FinePressure if can_boil(node) else Pressure
                    if has_free_air(node):
                        hints[free_air_name(name)] = FreeAir
                case Shaft():
                    hints[name] = ShaftState
                case Rod():
                    hints[name] = RodState
                case DrivenShaft() if name in self.places.turning:
                    hints[name] = Angle
        hints |= {p.name: p.component.state for p in self.network.parts.values() if p.component.state is not None}
        hints |= {f"{name}_heat": ExchangedEnergy for name in warm_volumes(self.network)}
        return named_tuple("State", hints | {"books": Books})

    @cached_property
    def outputs(self) -> type:
        """Recorded quantities beside the state."""
        hints: dict[str, Any] = {}
        for name, node in self.network.nodes.items():
            if isinstance(node, Tank | PressureSource | Junction):
                hints[f"{name}_pressure"] = Pressure
            elif isinstance(node, DrivenShaft):
                hints[f"{name}_speed"] = Speed
        for part in self.network.parts.values():
            _join(
                hints,
                part.name,
                {f"{part.name}_{n}": Annotated[float, kind] for n, (_, kind) in part_outputs(part).items()},
            )
        _join(hints, "the oil", {f"{n}_vapour": Volume for n, node in self.network.nodes.items() if can_boil(node)})
        for path in self.program_reads:
            kind = self.places.quantity(path, path).kind
            _join(hints, path, {path.replace(".", "_"): Annotated[float, kind]})
        _join(hints, "the heat", {f"{name}_temperature": Temperature for name in warm_volumes(self.network)})
        return named_tuple("Outputs", hints)

    @cached_property
    def program_reads(self) -> tuple[str, ...]:
        """Commands of programs that other programs read."""
        programs = self.network.programs.values()
        reads = [path for program in programs for source in program.reads.values() for path in paths_of(source)]
        return tuple(dict.fromkeys(path for path in reads if path.partition(".")[0] in self.network.programs))

    @cached_property
    def medium(self) -> type:
        """The oils at their temperature."""
        oils = {"medium": Medium}
        for node in self.network.nodes.values():
            if isinstance(node, HydraulicNode) and node.oil is not self.network.oil:
                oils[f"medium_{self.places.path(node.oil).removeprefix('p.')}"] = Medium
        return named_tuple("Media", oils)

    @cached_property
    def conditions_class(self) -> type:
        """Quantities that are calculated once per sample."""
        hints = dict(get_type_hints(self.medium, include_extras=True))
        for name, node in self.network.nodes.items():
            match node:
                case Tank() | PressureSource() if is_held(node):
                    _join(hints, name, {name: FluidState})
                case Shaft():
                    _join(hints, name, {f"{name}_inertia": Inertia})
                case Rod():
                    _join(hints, name, {f"{name}_inertia": Mass})
        for part in self.network.parts.values():
            if part.component.held:
                _join(hints, part.name, {part.name: get_type_hints(part.component.held)["return"]})
        return named_tuple("Held", hints)

    @cached_property
    def modes(self) -> type:
        """The modes and kinks of all parts, and in which direction oil is exchanged with what is prescribed."""
        hints: dict[str, Any] = {}
        for part in self.network.parts.values():
            found = {f"{part.name}_{n}": Annotated[float, kind] for n, kind in part.component.modes.items()}
            _join(hints, part.name, found)
        boiling = (f"{n}_vapour" for n, node in self.network.nodes.items() if can_boil(node))
        return named_tuple("Modes", hints | dict.fromkeys((*tank_exchanges(self.places), *boiling), Kink))

    @cached_property
    def command(self) -> type:
        """What is held between samples: the conditions, the modes, and the command of each program."""
        modes = {} if self.modes is Nothing else {"modes": self.modes}
        programs = {name: type(program.type.command) for name, program in self.network.programs.items()}
        return named_tuple("Command", {"held": self.conditions_class, **modes, **programs})

    @cached_property
    def start(self) -> type[Params]:
        """The start values."""
        hints: dict[str, Any] = {}
        for value in self.own_starts:
            _join(hints, value.name, {value.name: Annotated[float, value.kind]})
        return params_class("Start", hints)

    @property
    def own_starts(self) -> tuple[StartValue, ...]:
        """The start values that stand nowhere else among the parameters."""
        values = (value for several in self.places.starts.values() for value in several)
        return tuple(value for value in values if value.path == f"p.start.{value.name}")

    @cached_property
    def params(self) -> type[Params]:
        """All values of the network."""
        start = {"start": self.start} if self.own_starts else {}
        return params_class("Values", {name: hint for name, (hint, _) in self.places.fields.items()} | start)

    @property
    def values(self) -> Params:
        """The parameters with the values that the network was drawn with."""
        found = {name: value for name, (_, value) in self.places.fields.items()}
        if self.own_starts:
            found["start"] = self.start(**{value.name: value.value for value in self.own_starts})
        return self.params(**found)

    @cached_property
    def empty_books(self) -> Books:
        """Books before a run."""
        none: Any = 0.0 if len(self.places.oils) <= 1 else blank(self.oil_volumes)
        return Books(blank(self.supplied_class), blank(self.spent_class), none, none, blank(self.totals))


def _join(hints: dict[str, Any], whose: str, fresh: dict[str, Any]) -> None:
    """Add fields. Raises NetworkError where one is there already."""
    if twice := hints.keys() & fresh.keys():
        raise NetworkError(f"two results would be called {min(twice)!r}; rename {whose!r}")
    hints |= fresh


def named_tuple(name: str, hints: dict[str, Any]) -> type:
    """A NamedTuple class; `Nothing` without fields. The same one for the same fields: a study draws a network often."""
    return _named_tuple(name, tuple(hints.items())) if hints else Nothing


@lru_cache(maxsize=1000)
def _named_tuple(name: str, hints: tuple[tuple[str, Any], ...]) -> type:
    return NamedTuple(name, list(hints))  # type: ignore[return-value]


def params_class(name: str, hints: dict[str, Any]) -> type[Params]:
    """A parameter class, the same one for the same fields."""
    return _params_class(name, tuple(hints.items()))


@lru_cache(maxsize=1000)
def _params_class(name: str, hints: tuple[tuple[str, Any], ...]) -> type[Params]:
    return type(name, (Params,), {"__annotations__": dict(hints), "__doc__": "Values of a network."})


def _title(name: str) -> str:
    return name.title().replace("_", "")


def _energy(kind: Kind | None) -> Any:
    return ExchangedEnergy if kind is None or kind is EXCHANGED_ENERGY or kind.low < 0.0 else Energy


def _integral(kind: Kind) -> Any:
    found = INTEGRALS.get(kind)
    return (
        found or Annotated[float, Kind(f"{kind.name} over time", f"{kind.unit}*s", -1e15, 1e15, "1", accumulates=True)]
    )
