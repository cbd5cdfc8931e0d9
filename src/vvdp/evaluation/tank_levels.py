"""Levels of tanks over a run, and whether a suction mouth ran dry or a tank over."""

from collections.abc import Iterator, Mapping

from vvdp.base.kinds import LENGTH
from vvdp.hydraulics.reservoir import Reservoir, mouth_width, reservoir_level
from vvdp.network.network import Network
from vvdp.simulation.outcome import Outcome
from vvdp.simulation.values import leaves
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem


def reservoirs(network: Network) -> dict[str, Reservoir]:
    """The tanks of a network that have a level, by name."""
    values = ((name, value) for name, part in network.parts.items() for value in part.values)
    return {name: value for name, value in values if isinstance(value, Reservoir)}


def level_numbers(run: Outcome, system: LoadedSystem) -> dict[str, float]:
    """The lowest and the highest level of each tank over every step, by key."""
    paths = [path for path, _, _ in leaves(run.case.state)]
    return {
        f"level_{which}_{name}_m": reservoir_level(float(volumes[paths.index(f"{name}.tank_volume")]), tank)
        for name, tank in reservoirs(system.circuit.network).items()
        for which, volumes in (("min", run.low), ("max", run.high))
    }


def level_bounds(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of the levels: the upper edge of the suction mouth and the height of the tank."""
    for name, tank in reservoirs(system.circuit.network).items():
        yield Bound(
            label=f"level in {name.replace('_', ' ')}",
            kind=LENGTH,
            low=float(found[f"level_min_{name}_m"]),
            high=float(found[f"level_max_{name}_m"]),
            least=tank.suction_height + mouth_width(tank),
            most=tank.tank_height,
            otherwise="below, its suction runs dry and draws air; above, it runs over",
        )
