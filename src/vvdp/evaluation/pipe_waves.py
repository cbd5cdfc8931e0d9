"""Whether the pieces of a pipe are short enough for its waves: how smooth the pressure along it is."""

from collections.abc import Iterator, Mapping

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import RATIO
from vvdp.base.signal import signal_value
from vvdp.components.pipes import LAYERED_PIPE, PIPE
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.hydraulics.line import line_friction_drop
from vvdp.hydraulics.pipe import LinePipe, sound_speed
from vvdp.network.assembly import Group
from vvdp.network.network import Network
from vvdp.network.nodes import HydraulicNode
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem

ROUGHEST = 0.03
"""Roughness up to which the highest and lowest pressure of a line are taken for right: how far off they may be."""
STILL = 1e-9
"""A flow whose friction is laminar [m^3/s]."""
TAIL = 16.0
"""Scales of dispersion over which the swings behind a front are counted."""


def roughness(pressures: Array, transits: float, damping: float = 0.0) -> float:
    """How far the extremes of a pipe in pieces may be off at worst, over the highest pressure [1].

    Waves of a chain are slower the shorter they are: after M transits of n pieces a wave has the shape of the Airy
    function of the scale (n M/8)^(1/3) pieces in place of a front. What that changes along the pipe counts. Damping d
    stops it at 1/(4 d) pieces, and takes about d n/2 times the second difference from a wave on its way, which counts
    in its place. Of fewer than five pieces it is the whole swing. docs/models/components.md derives both.

    pressures  absolute, in every piece at every time, shape (times, pieces) [Pa]
    transits   for how many a wave lasts [1]
    damping    of the pipe [1]
    """
    swing = pressures - pressures.mean(axis=0)
    pieces = pressures.shape[1]
    if pieces < 5:
        return float(np.abs(swing).max() / pressures.max())
    taken = 0.5 * damping * pieces * np.abs(np.diff(swing, 2, axis=1)).max()
    scale = (pieces * transits / 8.0) ** (1.0 / 3.0)
    if damping > 0.0:
        scale = min(scale, 0.25 / damping)
    return float(max(_change_by_dispersion(swing, scale), taken) / pressures.max())


def _change_by_dispersion(swing: Array, scale: float) -> float:
    """How much a wave changes at most that is dispersed over `scale` pieces [Pa]."""
    from scipy.special import airy

    reach = int(np.ceil(2.0 * TAIL * scale))
    x = np.arange(-reach, reach + 1) / scale
    shape = airy(x)[0] * np.exp(-((np.clip(x, None, 0.0) / TAIL) ** 2))
    offsets, pieces = np.arange(-reach, reach + 1), swing.shape[1]
    # A row for each piece: beyond its ends the line goes on as its last pieces, so that no record is lengthened.
    rows = [np.bincount(np.clip(i - offsets, 0, pieces - 1), shape / shape.sum(), pieces) for i in range(pieces)]
    return float(np.abs(swing @ np.array(rows).T - swing).max())


def lasting_transits(pipe: Group, network: Network, highest: float, duration: float) -> float:
    """For how many transits a wave lasts [1]: for the whole run, or until wall friction has taken all but 1/e of it.

    highest   pressure in the pipe, absolute, at which waves are fastest [Pa]
    duration  of the run [s]
    """
    line, node = pipe.values, network.nodes[pipe.nodes[0]]
    assert isinstance(line, LinePipe) and isinstance(node, HydraulicNode)
    temperature = signal_value(0.0, network.temperature)
    rho = density(temperature, node.oil)
    c = sound_speed(rho, fluid_state(highest, node.oil), line.hose_compliance)
    impedance = rho * c / (0.25 * np.pi * line.diameter**2)
    drop = line_friction_drop(STILL, rho, dynamic_viscosity(temperature, node.oil), line)
    lasting = 2.0 * impedance * STILL / drop if drop > 0.0 else np.inf
    return float(min(c * duration / line.length, lasting))


def pipes(system: LoadedSystem) -> Mapping[str, Group]:
    """The pipes in pieces of a system, by name."""
    groups = system.circuit.network.groups
    return {name: group for name, group in groups.items() if group.assembly in (PIPE, LAYERED_PIPE)}


def wave_numbers(system: LoadedSystem, run: Run) -> dict[str, float]:
    """The roughness of each pipe of a recorded run, by key."""
    places = {path: place for place, (path, _, _) in enumerate(leaves(run.case.state))}
    duration, found = float(run.times[-1] - run.times[0]), dict[str, float]()
    for name, pipe in pipes(system).items():
        pressures = run.states[:, [places[node] for node in pipe.nodes]]
        lasting = lasting_transits(pipe, system.circuit.network, float(pressures.max()), duration)
        assert isinstance(pipe.values, LinePipe)
        found[f"wave_roughness_{name}"] = roughness(pressures, lasting, pipe.values.damping)
    return found


def wave_bounds(found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of the roughness of the pipes of which a run shows it."""
    for key in found:
        if key.startswith("wave_roughness_"):
            name = key.removeprefix("wave_roughness_").replace("_", " ")
            yield Bound(
                label=f"roughness of the waves in {name}",
                kind=RATIO,
                low=float(found[key]),
                high=float(found[key]),
                most=ROUGHEST,
                otherwise="waves that its pieces do not show right put its highest and lowest pressure off by about so "
                "much; give it more pieces, or its ends slower changes. With `damping` 0.3 nothing swings behind a "
                "front, and `--check` shows what more pieces change",
            )
