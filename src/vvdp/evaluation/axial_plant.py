"""Axial motion in a system, linear about the middle of its travel: mass, stiffness, damping, oil."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import POSITION, PRESSURE_LEVEL
from vvdp.base.signal import Signal, signal_value
from vvdp.estimation.observability import Plant
from vvdp.hydraulics.rod import EndStop
from vvdp.network.nodes import DrivenShaft, Rod
from vvdp.sensing.axial_sensor import AxialSensor
from vvdp.simulation.values import as_value, flat, leaves

if TYPE_CHECKING:
    from vvdp.systems.system import System

STEP = 1e-4
"""Of position [m] and, as a share, of pressure, over which slopes are taken."""
SLIDING, SLIDING_STEP = 1.0, 0.1
"""Velocity [m/s] at which dry friction no longer changes, and the step about it."""
SLOWEST = 1e-3
"""Natural frequency below which rounding is no spring [rad/s]."""


class AxialPlant(NamedTuple):
    """What moves: its name in the circuit, its plant, and the chambers that act on it, each with A^2 beta/V [N/m].

    Without a plant it has no mass: its velocity follows from a flow that is known.
    """

    name: str
    plant: Plant | None
    chambers: tuple[str, ...] = ()
    oil_stiffnesses: tuple[float, ...] = ()


class AxialSight(NamedTuple):
    """What an axial sensor of a system sees, as far as the circuit says: what moves, by its name, the spool's speed at
    the start [rad/s], and how many harmonics its periodic sensor error has."""

    moved: str = ""
    spool_speed: float | None = None
    harmonics: int | None = None


def axial_sight(system: "System") -> AxialSight:
    """What the axial sensor of a system sees; nothing is known where there is none, or several."""
    network = system.circuit.network
    programs = ((_sensor_of(program.settings), program.reads) for program in network.programs.values())
    found = [(sensor, reads) for sensor, reads in programs if sensor is not None]
    if len(found) != 1:
        return AxialSight()
    sensor, reads = found[0]
    moved, spool = (str(reads[word]).rpartition(".")[0] for word in ("position", "angle"))
    node = network.nodes.get(spool)
    source = node.speed if isinstance(node, DrivenShaft) else None
    speed = float(signal_value(0.0, source)) if isinstance(source, Signal) else None
    return AxialSight(moved, speed, max(len(end.amplitudes) for end in (sensor.near, sensor.far)))


def _sensor_of(settings: Any) -> AxialSensor | None:
    """The axial sensor among the values of a program: alone, of a loop, or of a loop that an encoder serves."""
    loop = getattr(settings, "loop", settings)
    sensor = getattr(loop, "sensor", loop)
    return sensor if isinstance(sensor, AxialSensor) else None


def axial_plant(system: "System", name: str = "") -> AxialPlant:
    """What moves along its axis in a system: `name`, else what the axial sensor sees, else the only one.

    The slopes are those of the written circuit in the middle between the end stops, with pressures that hold it there.
    Raises ConfigError, which names what there is, where that is not one, and where it is pushed off any place.
    """
    rods = [each for each, node in system.circuit.network.nodes.items() if isinstance(node, Rod)]
    moved = [path.rpartition(".")[0] for path, _, kind in leaves(system.case.state) if kind is POSITION]
    movers = rods or moved
    chosen = name or axial_sight(system).moved or (movers[0] if len(movers) == 1 else "")
    if chosen not in {*rods, *moved}:
        known = ", ".join(movers) or "nothing in this circuit does"
        asked = f"{name!r} is none of these: " if name else "which one? " if movers else ""
        message = (
            f"`vvdp observability` needs what moves along its axis, a rod or a spool with its drive; {asked}{known}"
        )
        raise ConfigError([Fault(system.name, 0, "", message)])
    return _linear(system, chosen) if chosen in rods else AxialPlant(chosen, None)


def _linear(system: "System", rod: str) -> AxialPlant:
    slopes = _Slopes(system, rod)
    mass = float(getattr(system.case.command.held, f"{rod}_inertia"))
    by_position = slopes.acceleration_by(slopes.position, STEP)
    if by_position > SLOWEST**2:
        message = f"{rod}: pushed off every place, with {mass * by_position:.4g} N/m; expected a spring or nothing"
        raise ConfigError([Fault(system.name, 0, "", message)])
    stiffness = -mass * by_position if by_position < -(SLOWEST**2) else 0.0
    sliding = slopes.at.copy()
    sliding[slopes.velocity] = SLIDING
    damping = -mass * slopes.difference(sliding, slopes.velocity, SLIDING_STEP)[slopes.velocity]
    chambers = {path: -mass * force * rate for path, force, rate in slopes.chambers() if force * rate < 0.0}
    plant = Plant(mass=mass, stiffness=float(stiffness), damping=float(max(damping, 0.0)))
    return AxialPlant(rod, plant, tuple(chambers), tuple(chambers.values()))


class _Slopes:
    """Slopes of the rates of a circuit about the place at which a rod stands in the middle of its travel."""

    def __init__(self, system: "System", rod: str) -> None:
        self.system = system
        paths = {path: (at, kind) for at, (path, _, kind) in enumerate(leaves(system.case.state))}
        self.position, self.velocity = paths[f"{rod}.position"][0], paths[f"{rod}.velocity"][0]
        self.pressures = {path: at for path, (at, kind) in paths.items() if kind is PRESSURE_LEVEL}
        self.at = flat(system.case.state)
        self.at[self.position] = _middle(system, rod, self.at[self.position])
        self.at[self.velocity] = 0.0
        self._hold()

    def rates(self, state: Array) -> Array:
        """Rates of all states [SI]."""
        case = self.system.case
        return flat(self.system.model.circuit(0.0, as_value(case.state, state), case.command, case.params)[0])

    def difference(self, about: Array, place: int, step: float) -> Array:
        """Slopes of all rates by one state."""
        shift = np.zeros_like(about)
        shift[place] = step
        return (self.rates(about + shift) - self.rates(about - shift)) / (2.0 * step)

    def acceleration_by(self, place: int, step: float) -> float:
        """Slope of the rod's acceleration by one state."""
        return float(self.difference(self.at, place, step)[self.velocity])

    def chambers(self) -> list[tuple[str, float, float]]:
        """Of each pressure its path, the acceleration by it, and its rate by the velocity."""
        by_velocity = self.difference(self.at, self.velocity, STEP)
        return [
            (path, self.acceleration_by(at, STEP * self.at[at]), float(by_velocity[at]))
            for path, at in self.pressures.items()
        ]

    def _hold(self) -> None:
        """Moves the pressures that act on the rod as little as holds it at rest, if that leaves them positive."""
        slopes = np.zeros_like(self.at)
        for at in self.pressures.values():
            slopes[at] = self.acceleration_by(at, STEP * self.at[at])
        if np.any(slopes):
            held = self.at - slopes * self.rates(self.at)[self.velocity] / (slopes @ slopes)
            if all(held[at] > 0.0 for at in self.pressures.values()):
                self.at = held


def _middle(system: "System", rod: str, otherwise: float) -> float:
    """The middle of the travel that the end stops on a rod leave it [m]."""
    parts = system.circuit.network.parts.values()
    stops = [v for part in parts if rod in part.nodes.values() for v in part.values if isinstance(v, EndStop)]
    if not stops:
        return otherwise
    return 0.5 * (max(stop.lower_end for stop in stops) + min(stop.upper_end for stop in stops))
