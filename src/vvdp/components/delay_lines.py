"""A long line without losses whose waves arrive a delay later, as one component: its ends, and what lies in between."""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import NUMBER, Count, Energy, Flow, Fraction, Power, Time
from vvdp.base.params import Params
from vvdp.base.select import maximum
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.delay_line import (
    Arriving,
    DelayLine,
    DelayState,
    Wave,
    WaveTime,
    delay_at_rest,
    delay_ends,
    delay_stored,
    line_delay,
    rest_wave,
)
from vvdp.network.assembly import Assembly, Group
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import HydraulicNode, Start
from vvdp.network.program import ProgramType


class DelaySettings(Params):
    """Settings of the memory of a line: its samples, how far they lie apart, and the wave in it at first."""

    samples: Count
    period: Time
    rest: Wave


class DelayReading(NamedTuple):
    """Integrals of the waves that have left both ends and of the energies sent into them so far."""

    left_a: WaveTime
    left_b: WaveTime
    sent_a: Energy
    sent_b: Energy


class DelayMemory(NamedTuple):
    """Means and swings of the waves that left both ends, a row each sample, and what had left at the last one."""

    means: Annotated[Array, NUMBER]
    swings: Annotated[Array, NUMBER]
    taken: Count
    before: DelayReading
    begun: Fraction


class DelayFlows(NamedTuple):
    """Flows of a line into the nodes at its ends, its loss, and the rates of its state."""

    a: Flow
    b: Flow
    loss: Power
    rates: DelayState


def delay_line_ends(
    a: FluidState,
    b: FluidState,
    state: DelayState,
    oil: Oil,
    wave_a: Wave,
    wave_b: Wave,
    swing_a: Wave,
    swing_b: Wave,
    values: DelayLine,
) -> DelayFlows:
    """Both ends of a line at which waves arrive; see `delay_ends`."""
    arriving = Arriving(wave_a, wave_b, swing_a, swing_b)
    ends = delay_ends(a.enthalpy, b.enthalpy, arriving, oil.density, values)
    return DelayFlows(-ends.a, -ends.b, ends.loss, ends.rates)


def delay_start(settings: DelaySettings) -> DelayMemory:
    """The memory of a line before the first sample: the same wave everywhere, either way."""
    rows = int(settings.samples)
    none = DelayReading(0.0, 0.0, 0.0, 0.0)
    means, swings = np.full((rows, 2), settings.rest), np.zeros((rows, 2))
    return DelayMemory(means=means, swings=swings, taken=0.0, before=none, begun=0.0)


def delay_step(
    t: float, memory: DelayMemory, reading: DelayReading, settings: DelaySettings
) -> tuple[DelayMemory, Arriving]:
    """Keep what has left both ends since the sample before, and give what left the other a delay ago."""
    rows, taken = int(settings.samples), int(memory.taken)
    means, swings = memory.means.copy(), memory.swings.copy()
    if memory.begun > 0.5:
        at, before, h = taken % rows, memory.before, settings.period
        means[at, 0] = (reading.left_a - before.left_a) / h
        means[at, 1] = (reading.left_b - before.left_b) / h
        swings[at, 0] = np.sqrt(maximum((reading.sent_a - before.sent_a) / h - means[at, 0] ** 2, 0.0))
        swings[at, 1] = np.sqrt(maximum((reading.sent_b - before.sent_b) / h - means[at, 1] ** 2, 0.0))
        taken = taken + 1
    out = taken % rows
    arriving = Arriving(means[out, 1], means[out, 0], swings[out, 1], swings[out, 0])
    return DelayMemory(means=means, swings=swings, taken=float(taken), before=reading, begun=1.0), arriving


DELAY_LINE_ENDS = Component(delay_line_ends, symbol="line", stored=delay_stored, offered=False)
WAVES = ProgramType(
    step=delay_step,
    reading=DelayReading,
    command=Arriving(0.0, 0.0, 0.0, 0.0),
    settings=DelaySettings,
    start=delay_start,
)


def add_delay_line(net: Network, name: str, values: DelayLine, nodes: Mapping[str, str], start: Start) -> None:
    """Add a line without losses whose waves keep their shape; the pressure in it is at first `start` [Pa, absolute]."""
    net.check_name(name)
    ends, waves = f"{name}_ends", f"{name}_waves"
    node = net.nodes.get(nodes.get("a", ""))
    oil = node.oil if isinstance(node, HydraulicNode) else net.oil
    enthalpy = float(fluid_state(net.start_value(start), oil).enthalpy)
    inputs = {key: f"{waves}.{key}" for key in Arriving._fields}
    at_rest = delay_at_rest(enthalpy, oil.density, values)
    net.add(ends, DELAY_LINE_ENDS, values, start=at_rest, **nodes, **inputs)
    settings = DelaySettings(
        samples=values.samples,
        period=line_delay(values) / values.samples,
        rest=rest_wave(enthalpy, oil.density, values),
    )
    reads = {key: f"{ends}.{key}" for key in DelayReading._fields}
    net.program(waves, WAVES, settings, reads=reads, period=settings.period)
    net.groups[name] = Group(
        assembly=DELAY_LINE, values=values, ports=dict(nodes), parts=(ends,), nodes=(), programs=(waves,)
    )


DELAY_LINE = Assembly("delay_line", DelayLine, ("a", "b"), "line", add_delay_line)
