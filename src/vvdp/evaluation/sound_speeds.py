"""Whether one speed of sound shows the waves of a line whose delay is fixed: how it changes over their pressures."""

from collections.abc import Iterator, Mapping

from vvdp.base.kinds import RATIO
from vvdp.components.delay_lines import DELAY_LINE
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.delay_line import SOUND_SPEED, DelayLine
from vvdp.hydraulics.pipe import sound_speed
from vvdp.network.nodes import HydraulicNode
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem

WIDEST = 0.06
"""Change of the speed of sound, over its lowest, up to which one in the middle is within 3 % of all."""
ABOVE = 1.03
"""Speed of sound that is given for a line, over the highest that its oil has in a rigid pipe."""


def sound_bounds(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of the speed of sound in each line with a delay, over the pressures at its ends."""
    network = system.circuit.network
    for name, group in network.groups.items():
        if group.assembly is not DELAY_LINE:
            continue
        line, speeds = group.values, list[float]()
        assert isinstance(line, DelayLine)
        for end in group.ports.values():
            node = network.nodes[end]
            assert isinstance(node, HydraulicNode)
            for which in ("min", "max"):
                pressure = float(found[f"pressure_{which}_{end}_Pa"]) + node.oil.reference_pressure
                speeds.append(sound_speed(node.oil.density, fluid_state(pressure, node.oil), 0.0))
        words = name.replace("_", " ")
        yield Bound(
            label=f"change of the speed of sound in {words}",
            kind=RATIO,
            low=max(speeds) / min(speeds) - 1.0,
            high=max(speeds) / min(speeds) - 1.0,
            most=WIDEST,
            otherwise="its waves would grow steeper, while the line keeps their shape; a pipe in pieces follows them",
        )
        yield Bound(
            label=f"speed of sound in {words}",
            kind=SOUND_SPEED,
            low=line.sound_speed,
            high=line.sound_speed,
            most=ABOVE * max(speeds),
            otherwise="its oil has no faster waves, even in a rigid pipe",
        )
