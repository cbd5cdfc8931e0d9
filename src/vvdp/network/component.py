"""A component: one plain function that says what it does at an instant, and what else belongs to it.

The function's arguments are distinguished by their annotations, its result by its field names, so that nothing is
stated twice. `docs/components.md` shows one being written.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import cached_property
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from vvdp.base.conservation import Stored
from vvdp.base.errors import NetworkError
from vvdp.base.kinds import KINK, MODE, Kind
from vvdp.base.params import Params, argument_kinds, field_kinds
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.flow import Passage
from vvdp.hydraulics.ports import SURPLUS, Medium, RodState, ShaftSpeed, ShaftState
from vvdp.simulation.values import names


class Role(Enum):
    """Role of an argument of a component's function."""

    TIME = auto()
    PORT = auto()
    SHAFT = auto()
    SHAFT_SPEED = auto()
    ROD = auto()
    MEDIUM = auto()
    OIL = auto()
    PARAMS = auto()
    STATE = auto()
    HELD = auto()
    SURPLUS = auto()
    MODE = auto()
    INPUT = auto()


PORTS = {FluidState: Role.PORT, ShaftState: Role.SHAFT, ShaftSpeed: Role.SHAFT_SPEED, RodState: Role.ROD}
OTHERS = {Medium: Role.MEDIUM, Oil: Role.OIL}
PORT_ROLES = frozenset(PORTS.values())
MECHANICAL = PORT_ROLES - {Role.PORT}
EFFECTS = frozenset(("loss", "losses", "supplied", "rates", "flow"))
"""Fields of a law's result that are no outputs, beside those of its ports and modes."""


@dataclass(frozen=True)
class Argument:
    """One argument of a component's function."""

    name: str
    role: Role
    type: Any
    kind: Kind | None
    default: float | None


@dataclass(frozen=True)
class Component:
    """Definition of a component, apart from its values.

    law      what it does at an instant. Arguments, by annotation: FluidState (a hydraulic port), ShaftState,
             ShaftSpeed, RodState (mechanical ports), Medium, Oil, a Params class (its values), the NamedTuples of its
             state and of what `held` gives, Surplus, `t`, Mode (the floor of the result's field of that name, which
             holds until a step has ended where it changes); any other float with a kind is an input.
             Result: `Passage` for what lies between two ports, or a NamedTuple in which the fields named as ports are
             what it gives to the nodes there (tank volumes m^3/s into it, torque N m on it, force N on it), `loss`
             or `losses` are powers dissipated, `supplied` is power from outside, `rates` those of its state, a
             Mode or a Kink is where it stands among its modes, and all others are outputs that are recorded and can
             be connected.
    symbol   of the diagram
    held     held(...) -> NamedTuple calculated once per sample, of Medium, Oil and Params
    start    start(params) -> its state before a run; without one, all zero
    stored   stored(...) -> Stored, what it holds itself, of state, ports, Params, Medium
    walls    walls(...) -> NamedTuple of Wall for ports whose volume it moves, of mechanical ports and Params
    inertia  inertia(...) -> moment of inertia or mass that it adds to its one mechanical port, of Params
    stop     stop(t, ...) -> next time at which its law jumps, of Params and inputs
    mark     mark(...) -> a period ends wherever its floor changes, of t, state, angles, positions and Params
    averages names of outputs that are averaged over a run beside the flows; a component that has some may be a meter,
             which gives nothing to its ports
    cooling  cooling(values) -> Coolant, to which the oil behind it gives heat where there is a heat balance
    suited   suited(values) -> the component of the same ports and values that stands in its place, where most values
             need less than all
    given_by by the name of an input, a function of another quantity and of Params that gives it: a file may say that
             quantity instead
    offered  whether a system file can name it
    """

    law: Callable[..., Any]
    symbol: str
    held: Callable[..., Any] | None = None
    start: Callable[..., Any] | None = None
    stored: Callable[..., Any] | None = None
    walls: Callable[..., Any] | None = None
    inertia: Callable[..., Any] | None = None
    stop: Callable[..., Any] | None = None
    mark: Callable[..., Any] | None = None
    averages: tuple[str, ...] = ()
    cooling: Callable[..., Any] | None = None
    suited: "Callable[..., Component] | None" = None
    given_by: Mapping[str, Callable[..., float]] = field(default_factory=dict, hash=False)
    offered: bool = True

    @property
    def name(self) -> str:
        """The name of its law, without an underscore that keeps it apart from a word of Python."""
        return self.law.__name__.rstrip("_")

    @cached_property
    def result(self) -> type:
        """The NamedTuple that the law returns."""
        found = get_type_hints(self.law).get("return")
        if not (isinstance(found, type) and hasattr(found, "_fields")):
            raise NetworkError(f"{self.name}: its result needs an annotation, a NamedTuple such as Passage")
        return found

    @cached_property
    def state(self) -> type | None:
        """The NamedTuple of its state, where it has one."""
        return None if "rates" not in names(self.result) else get_type_hints(self.result)["rates"]

    @cached_property
    def arguments(self) -> tuple[Argument, ...]:
        """The arguments of its law, in order."""
        return self.arguments_of(self.law)

    def arguments_of(self, function: Callable[..., Any]) -> tuple[Argument, ...]:
        """The arguments of one of its functions, in order. Raises NetworkError where one cannot be determined."""
        known = self._known_arguments
        return known.get(function) or known.setdefault(function, _arguments(function, self))

    @cached_property
    def _known_arguments(self) -> dict[Callable[..., Any], tuple[Argument, ...]]:
        """The arguments of its functions that were asked for."""
        return {}

    @cached_property
    def ports(self) -> Mapping[str, Role]:
        """Names of its ports and what each joins, hydraulic and mechanical, in order."""
        return {a.name: a.role for a in self.arguments if a.role in PORT_ROLES}

    @property
    def hydraulic_ports(self) -> tuple[str, ...]:
        """Names of the ports where oil flows, in order."""
        return tuple(name for name, role in self.ports.items() if role is Role.PORT)

    @property
    def inputs(self) -> tuple[Argument, ...]:
        """The arguments that a signal, a connection or a command has to give."""
        return tuple(a for a in self.arguments if a.role is Role.INPUT)

    @cached_property
    def alternatives(self) -> Mapping[str, Argument]:
        """The quantities that a file may say instead of an input, by the name of the input."""
        return {
            name: next(a for a in self.arguments_of(function) if a.role is Role.INPUT)
            for name, function in self.given_by.items()
        }

    @cached_property
    def wall_ports(self) -> tuple[str, ...]:
        """Names of the ports whose volume it takes part in."""
        return () if self.walls is None else names(get_type_hints(self.walls).get("return", ()))

    @cached_property
    def moves_walls(self) -> bool:
        """Whether a shaft or rod moves walls of it, so that oil is swept without a flow through it."""
        return self.walls is not None and any(a.role in MECHANICAL for a in self.arguments_of(self.walls))

    @property
    def params(self) -> tuple[type[Params], ...]:
        """The classes of its values."""
        return tuple(a.type for a in self.arguments if a.role is Role.PARAMS)

    @property
    def is_passage(self) -> bool:
        """Whether what leaves its first port enters its second, and nothing flows at others."""
        return "flow" in names(self.result) and len(self.hydraulic_ports) >= 2

    @property
    def ends(self) -> tuple[str, ...]:
        """The two ports of a passage between which its oil flows; none of another component."""
        return self.hydraulic_ports[:2] if self.is_passage else ()

    @cached_property
    def losses(self) -> Mapping[str, Kind | None]:
        """Names of the parts of its losses; the empty name where it has one loss only."""
        if "losses" in names(self.result):
            return field_kinds(get_type_hints(self.result)["losses"])
        return {"": field_kinds(self.result)["loss"]} if "loss" in names(self.result) else {}

    @cached_property
    def modes(self) -> Mapping[str, Kind]:
        """Names and kinds of its modes and kinks; a kink that the law receives as it holds is a mode."""
        told = {a.name for a in self.arguments if a.role is Role.MODE}
        kinds = {name: kind for name, kind in field_kinds(self.result).items() if kind in (MODE, KINK)}
        return {name: MODE if name in told else kind for name, kind in kinds.items() if kind}

    @cached_property
    def outputs(self) -> Mapping[str, Kind]:
        """Names and kinds of what it shows besides its effect on the nodes."""
        effects = {*self.ports, *self.modes, *EFFECTS}
        return {name: kind for name, kind in field_kinds(self.result).items() if kind and name not in effects}


def _arguments(function: Callable[..., Any], component: Component) -> tuple[Argument, ...]:
    hints, kinds = get_type_hints(function, include_extras=True), argument_kinds(function)
    found = []
    for name, parameter in inspect.signature(function).parameters.items():
        hint, kind, default = hints.get(name), kinds.get(name), parameter.default
        plain = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        role = Role.TIME if name == "t" else _role(plain, kind, component)
        if role is None:
            raise NetworkError(
                f"{function.__name__}: what {name!r} is does not follow from {plain!r}; annotate it as FluidState, "
                "ShaftState, ShaftSpeed, RodState, Medium, Oil, Params, its state, or a float with a kind"
            )
        found.append(Argument(name, role, plain, kind, None if default is parameter.empty else float(default)))
    return tuple(found)


def _role(plain: Any, kind: Kind | None, component: Component) -> Role | None:
    """What an argument of a component's function is by its annotation; None if that does not say."""
    if kind is not None:
        return Role.SURPLUS if kind is SURPLUS else Role.MODE if kind is MODE else Role.INPUT
    if role := PORTS.get(plain) or OTHERS.get(plain):
        return role
    if isinstance(plain, type) and issubclass(plain, Params):
        return Role.PARAMS
    if plain is not None and plain is component.state:
        return Role.STATE
    is_held = component.held is not None and plain is get_type_hints(component.held).get("return")
    return Role.HELD if is_held else None


ALLOWED = {
    "held": {Role.MEDIUM, Role.OIL, Role.PARAMS},
    "start": {Role.PARAMS},
    "stored": {Role.STATE, Role.PORT, Role.SHAFT, Role.SHAFT_SPEED, Role.ROD, Role.MEDIUM, Role.OIL, Role.PARAMS},
    "walls": {Role.SHAFT, Role.ROD, Role.PARAMS},
    "inertia": {Role.PARAMS},
    "stop": {Role.TIME, Role.INPUT, Role.PARAMS},
    "cooling": {Role.PARAMS},
    "mark": {Role.TIME, Role.STATE, Role.SHAFT, Role.ROD, Role.PARAMS},
}
"""Arguments of the functions of a component beside its law."""
GIVEN_UNITS = {Role.PORT: "m^3/s", Role.SHAFT: "N*m", Role.SHAFT_SPEED: "N*m", Role.ROD: "N"}
"""Units of what a component gives to a node."""


def check_component(component: Component) -> None:
    """Refuse, with a NetworkError that names it, a component whose functions do not fit together."""
    name, ports, fields = component.name, component.ports, set(names(component.result))
    if not ports and component.state is None:
        raise NetworkError(
            f"{name} has no port; annotate at least one argument as FluidState, or a shaft or rod, or give it a state"
        )
    hydraulic = component.hydraulic_ports
    if "flow" in fields and (len(hydraulic) < 2 or (component.result is Passage and len(hydraulic) > 2)):
        returned = "a Passage" if component.result is Passage else "a field 'flow'"
        raise NetworkError(
            f"{name} returns {returned} and has {len(hydraulic)} hydraulic ports; expected two, or a field each"
        )
    if component.is_passage and (twice := fields & set(hydraulic)):
        raise NetworkError(
            f"{name} returns both 'flow' and {min(twice)!r}; the one or the other, else oil counts twice"
        )
    if ports and not (component.is_passage or component.averages or fields & set(ports)):
        raise NetworkError(
            f"{name} gives nothing to a port; its result needs a field named as one of {', '.join(ports)}"
        )
    _check_units(component)
    _check_functions(component)
    for argument in component.arguments:
        if argument.role is Role.MODE and component.modes.get(argument.name) is not MODE:
            raise NetworkError(
                f"{name} receives its mode {argument.name!r}, but returns none; its result needs "
                f"`{argument.name}: Mode`"
            )
    for average in component.averages:
        if average not in component.outputs:
            raise NetworkError(f"{name}: averages {average!r}, which is none of its outputs")


def _check_units(component: Component) -> None:
    """Refuse a result whose fields are not in the units that the nodes and the books count in."""
    kinds = field_kinds(component.result)
    units = {port: GIVEN_UNITS[role] for port, role in component.ports.items() if port in kinds}
    units |= {name: "m^3/s" for name in ("flow",) if name in kinds}
    units |= {name: "W" for name in ("loss", "supplied") if name in kinds}
    found = [(name, kinds[name], unit) for name, unit in units.items()]
    if "" not in component.losses:
        found += [(f"losses.{name}", kind, "W") for name, kind in component.losses.items()]
    for name, kind, unit in found:
        if kind is None or kind.unit != unit:
            what = "has no kind" if kind is None else f"is {kind.with_article} [{kind.unit}]"
            raise NetworkError(f"{component.name}: {name!r} of its result {what}; expected one in {unit}")
    shown = kinds.keys() - component.ports.keys() - EFFECTS
    if without := [name for name in kinds if name in shown and kinds[name] is None]:
        raise NetworkError(f"{component.name}: output {without[0]!r} has no kind; annotate it, for example with Flow")
    if component.state is not None:
        without = [name for name, kind in field_kinds(component.state).items() if kind is None]
        if without and not hasattr(get_type_hints(component.state)[without[0]], "_fields"):
            raise NetworkError(
                f"{component.name}: {without[0]!r} of its state has no kind; annotate it, as with Pressure"
            )


def _check_functions(component: Component) -> None:
    """Refuse functions beside the law that take what they cannot be given, or return what is not read."""
    for word, allowed in ALLOWED.items():
        function = getattr(component, word)
        for argument in () if function is None else component.arguments_of(function):
            if argument.role not in allowed:
                what = argument.role.name.lower().replace("_", " ")
                raise NetworkError(
                    f"{component.name}: its {word}, {function.__name__}, takes {argument.name!r} ({what}), "
                    "which it cannot be given"
                )
    if component.stored and get_type_hints(component.stored).get("return") is not Stored:
        raise NetworkError(f"{component.name}: what it stores needs the annotation Stored")
    for wall in component.wall_ports:
        if wall not in component.hydraulic_ports:
            raise NetworkError(f"{component.name}: its walls name {wall!r}, which is none of its hydraulic ports")
    mechanical = len(component.ports) - len(component.hydraulic_ports)
    if component.inertia and mechanical != 1:
        raise NetworkError(f"{component.name} has an inertia and {mechanical} shafts and rods; expected one")
