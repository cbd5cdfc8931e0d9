"""A component: one plain function that says what it does at an instant, and what else belongs to it.

The function's arguments are told apart by their annotations, its result by its field names, so that nothing is said
twice. `docs/components.md` shows one being written.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from functools import cached_property
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from vvdp.base.books import Stored
from vvdp.base.errors import NetworkError
from vvdp.base.kinds import Kind
from vvdp.base.params import Params, field_kinds
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.flow import Passage
from vvdp.hydraulics.ports import SURPLUS, Medium, RodState, ShaftSpeed, ShaftState
from vvdp.simulation.values import names


class Role(Enum):
    """What an argument of a component's function is."""

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
    INPUT = auto()


PORTS = {FluidState: Role.PORT, ShaftState: Role.SHAFT, ShaftSpeed: Role.SHAFT_SPEED, RodState: Role.ROD}
OTHERS = {Medium: Role.MEDIUM, Oil: Role.OIL}
PORT_ROLES = frozenset(PORTS.values())


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
    """What a component is, apart from its values.

    law      what it does at an instant. Arguments, by annotation: FluidState (a hydraulic port), ShaftState,
             ShaftSpeed, RodState (mechanical ports), Medium, Oil, a Params class (its values), the NamedTuples of its
             state and of what `held` gives, Surplus, `t`; any other float with a kind is an input.
             Result: `Passage` for what lies between two ports, or a NamedTuple in which the fields named as ports are
             what it gives to the nodes there (tank volumes m^3/s into it, torque N m on it, force N on it), `loss`
             or `losses` are powers turned to heat, `supplied` is power from outside, `rates` those of its state, and
             all others are outputs that are recorded and can be connected.
    symbol   of the diagram
    held     held(...) -> NamedTuple worked out once per sample, of Medium, Oil and Params
    start    start(params) -> its state before a run; without one, all zero
    stored   stored(...) -> Stored, what it holds itself, of state, ports, Params, Medium
    walls    walls(...) -> NamedTuple of Wall for ports whose volume it moves, of mechanical ports and Params
    inertia  inertia(...) -> moment of inertia or mass that it adds to its mechanical port, of Params and held
    stop     stop(t, ...) -> next time at which its law jumps, of Params and inputs
    mark     mark(...) -> a period ends wherever its floor changes, of state, mechanical ports and Params
    averages names of outputs that are averaged over a run beside the flows
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

    @property
    def name(self) -> str:
        """The name of its law."""
        return self.law.__name__

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
        """The arguments of one of its functions, in order. Raises NetworkError where one cannot be told."""
        hints = get_type_hints(function, include_extras=True)
        return tuple(
            self._argument(function.__name__, name, hints.get(name), parameter.default)
            for name, parameter in inspect.signature(function).parameters.items()
        )

    def _argument(self, function: str, name: str, hint: Any, default: Any) -> Argument:
        kind = next((k for k in getattr(hint, "__metadata__", ()) if isinstance(k, Kind)), None)
        plain = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        start = None if default is inspect.Parameter.empty else float(default)
        return Argument(name, self._role(function, name, plain, kind), plain, kind, start)

    def _role(self, function: str, name: str, plain: Any, kind: Kind | None) -> Role:
        if name == "t":
            return Role.TIME
        if kind is not None:
            return Role.SURPLUS if kind is SURPLUS else Role.INPUT
        if role := PORTS.get(plain) or OTHERS.get(plain):
            return role
        if isinstance(plain, type) and issubclass(plain, Params):
            return Role.PARAMS
        if plain is not None and plain is self.state:
            return Role.STATE
        if self.held is not None and plain is get_type_hints(self.held).get("return"):
            return Role.HELD
        expected = (
            "FluidState, ShaftState, ShaftSpeed, RodState, Medium, Oil, Params, its state, or a float with a kind"
        )
        raise NetworkError(f"{function}: what {name!r} is cannot be told from {plain!r}; annotate it as {expected}")

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

    @property
    def params(self) -> tuple[type[Params], ...]:
        """The classes of its values."""
        return tuple(a.type for a in self.arguments if a.role is Role.PARAMS)

    @property
    def is_passage(self) -> bool:
        """Whether what leaves its first port enters its second."""
        return "flow" in names(self.result) and len(self.hydraulic_ports) == 2

    @cached_property
    def losses(self) -> Mapping[str, Kind | None]:
        """Names of the parts of its losses; the empty name where it has one loss only."""
        if "losses" in names(self.result):
            return field_kinds(get_type_hints(self.result)["losses"])
        return {"": field_kinds(self.result)["loss"]} if "loss" in names(self.result) else {}

    @cached_property
    def outputs(self) -> Mapping[str, Kind]:
        """Names and kinds of what it shows besides its effect on the nodes."""
        known = {*self.ports, "loss", "losses", "supplied", "rates", "flow"}
        shown = {name: kind for name, kind in field_kinds(self.result).items() if name not in known}
        if without := [name for name, kind in shown.items() if kind is None]:
            raise NetworkError(f"{self.name}: output {without[0]!r} has no kind; annotate it, for example with Flow")
        return {name: kind for name, kind in shown.items() if kind}


def check_component(component: Component) -> None:
    """Refuse, with a NetworkError that names it, a component whose functions do not fit together."""
    ports, fields = component.ports, set(names(component.result))
    if not ports:
        raise NetworkError(
            f"{component.name} has no port; annotate at least one argument as FluidState, or a shaft or rod"
        )
    if component.result is Passage and len(component.hydraulic_ports) != 2:
        count = len(component.hydraulic_ports)
        raise NetworkError(f"{component.name} returns a Passage and has {count} hydraulic ports; expected two")
    if not component.is_passage and not fields & set(ports):
        raise NetworkError(
            f"{component.name} gives nothing to a port; its result needs a field named as one of {', '.join(ports)}"
        )
    for name in component.averages:
        if name not in component.outputs:
            raise NetworkError(f"{component.name}: averages {name!r}, which is none of its outputs")
    if component.stored and get_type_hints(component.stored).get("return") is not Stored:
        raise NetworkError(f"{component.name}: what it stores needs the annotation Stored")
    assert component.arguments is not None and component.outputs is not None
