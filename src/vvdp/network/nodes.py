"""The nodes of a network: where ports meet. Volumes, shafts and rods have a state, junctions follow from what meets at
them; the others are prescribed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeGuard

from vvdp.base.kinds import AddedInertia, Mass, Volume
from vvdp.base.params import Params
from vvdp.base.signal import Signal
from vvdp.fluid.dissolving import dissolves
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.pipe import LinePipe
from vvdp.hydraulics.volume import Vessel


class Chamber(Params):
    """A rigid volume of oil."""

    volume: Volume


class Rotor(Params):
    """Inertia on a shaft beside that of the components that it joins."""

    inertia: AddedInertia


class Load(Params):
    """Mass on a rod beside that of the components that it joins."""

    mass: Mass


@dataclass(frozen=True)
class Connection:
    """Result of `function` of signals, parameter classes and paths such as "spool.speed", in this order."""

    function: Callable[..., float]
    sources: tuple[Signal | Params | str, ...]


UNRATED = 1e9
"""Rated power of a drive that has no limit [W]."""
Start: TypeAlias = float | str
"""A number at which a run begins, in SI, or where it stands among the network's values: "initial.inlet_pressure"."""
Source: TypeAlias = float | Signal | str | Connection
"""Where an input comes from: a number or signal; the path of a state, output or command; a function of several."""


@dataclass(frozen=True)
class OilVolume:
    """Oil under one pressure: rigid, or with elastic walls and gas. `start` is its pressure at first, absolute [Pa]."""

    name: str
    values: Chamber | Vessel | LinePipe
    start: Start
    oil: Oil


@dataclass(frozen=True)
class Tank:
    """A tank under a prescribed pressure, read once per sample."""

    name: str
    pressure: Signal
    oil: Oil


@dataclass(frozen=True)
class PressureSource:
    """A source or sink that holds its pressure whatever flows."""

    name: str
    pressure: Source
    oil: Oil


@dataclass(frozen=True)
class Junction:
    """A place without oil of its own: its pressure is the one at which as much flows in as out."""

    name: str
    oil: Oil


@dataclass(frozen=True)
class Shaft:
    """A shaft that turns freely, with the inertia of all that it joins; `angle` [rad] and `speed` [rad/s] at first."""

    name: str
    values: Rotor | None
    angle: Start
    speed: Start


@dataclass(frozen=True)
class DrivenShaft:
    """A shaft whose speed is prescribed or commanded, whatever torque that takes; `rated_power` is that of what drives
    it [W].
    """

    name: str
    speed: Source
    rated_power: float = UNRATED


@dataclass(frozen=True)
class Rod:
    """A mass that moves along a line, with all that it joins. At first it has `position` [m] and `velocity` [m/s]."""

    name: str
    values: Load | None
    position: Start
    velocity: Start


HydraulicNode: TypeAlias = OilVolume | Tank | PressureSource | Junction
Node: TypeAlias = HydraulicNode | Shaft | DrivenShaft | Rod


def free_air_name(name: str) -> str:
    """What the free air of a volume is called."""
    return f"{name}_air"


def has_free_air(node: Node) -> bool:
    """Whether the free air of a node is a state: of volumes of oil whose air dissolves."""
    return isinstance(node, OilVolume) and dissolves(node.oil)


def is_held(node: Node) -> TypeGuard[Tank | PressureSource]:
    """Whether the oil's state in a node is calculated once per sample: where a signal prescribes its pressure."""
    return isinstance(node, Tank | PressureSource) and isinstance(node.pressure, Signal)


def can_boil(node: Node) -> bool:
    """Whether vapour may form in a node: in volumes of oil that has a vapour pressure."""
    return isinstance(node, OilVolume) and node.oil.vapour_pressure > 0.0


def kind_of_node(node: Node | type[Node]) -> str:
    """The word of messages for a node, or for a class of nodes."""
    cls = node if isinstance(node, type) else type(node)
    words: dict[type[Any], str] = {OilVolume: "volume", PressureSource: "pressure source", DrivenShaft: "driven shaft"}
    return words.get(cls, cls.__name__.lower())
