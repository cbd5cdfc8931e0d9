# %% [markdown]
# # An estimator of your own
#
# Angle and speed of a shaft from a wheel with eight stripes: what ships with vvdp is the [event filter](../subjects/encoder-filter.md). This page puts
# a custom estimator beside it, on the same readings: a tracking loop of fixed gains that goes on at its speed, and is corrected at each edge
# by a share of the error.
#
# An estimator is a step, `step(memory, reading, settings) -> (memory, estimate)`. The `Reading` says how many edges came since the sample before,
# and when the last one passed; the `Estimate` has fields for the estimates and their standard deviations, NaN if the estimator gives none.

# %%
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Fraction, Rate, Speed, Time
from vvdp.base.params import Params
from vvdp.comparison.estimators import Contender, contenders
from vvdp.comparison.scenarios import scenarios
from vvdp.comparison.trials import compare
from vvdp.estimation.estimator import Estimate
from vvdp.sensing.reading import Reading

SECTOR = 2.0 * np.pi / 8.0


# %% [markdown]
# ## The step
#
# Bandwidth and damping are its settings. Memory is angle, speed and the time for which they hold; the wheel's edges are counted.


# %%
class Loop(Params):
    bandwidth: Rate
    damping: Fraction


class Belief(NamedTuple):
    time: Time
    angle: Angle
    speed: Speed
    edge: Angle


def loop_step(memory: Belief, reading: Reading, settings: Loop) -> tuple[Belief, Estimate]:
    """Goes on at the speed; each edge moves angle and speed by a share of the error."""
    time, angle, speed, edge = memory
    innovation = 0.0
    if reading.edges > 0.0:
        gap = reading.edge_time - time
        edge = edge + SECTOR * reading.edges
        innovation = edge - (angle + speed * gap)
        share = 1.0 - np.exp(-settings.bandwidth * gap)
        angle = angle + speed * gap + 2.0 * settings.damping * share * innovation
        speed = speed + settings.bandwidth * share * innovation
        time = reading.edge_time
    shown = Estimate(
        angle=angle + speed * (reading.time - time),
        speed=speed,
        angle_deviation=np.nan,
        speed_deviation=np.nan,
        innovation=innovation,
        innovation_deviation=0.0,
        missed_edges=0.0,
        standstill=np.nan,
    )
    return Belief(time, angle, speed, edge), shown


# %% [markdown]
# ## By hand
#
# A wheel at 150 rad/s, whose edges come every 5.24 ms and are read by a clock of 1 kHz. The loop starts at 140 rad/s.

# %%
loop = Loop(bandwidth=30.0, damping=0.8)
memory, passed = Belief(0.0, 0.0, 140.0, 0.0), 0
for k in range(1, 501):
    now = 1e-3 * k
    edges = np.floor(150.0 * now / SECTOR) - passed
    passed += edges
    memory, shown = loop_step(memory, Reading(now, edges, now - 5e-4, 1e-3, 0.0), loop)
    if k in (20, 100, 500):
        print(f"after {k} ms: {shown.speed:.1f} rad/s")

# %% [markdown]
# ## Beside the others
#
# A `Contender` is an estimator with its values and where it begins. `compare` runs all of them over random runs of scenarios whose truth is known, compiled, and
# reports errors, delays and lost edges: the figures of [estimators compared](../comparison.md). Here twenty runs each of a steady speed, of a flow that
# steps, and of a wheel a fifth of whose edges are missing.

# %%
wanted = ("constant", "step", "missed-edges")
chosen = [each for each in scenarios() if each.name in wanted]
shipped = [each for each in contenders() if each.name == "event-filter"]
start = Belief(0.0, 0.0, 0.0, 0.0)
mine = []
for w in (20.0, 60.0):
    loop = Loop(bandwidth=w, damping=0.8)
    mine.append(Contender(f"loop-{w:g}", "a tracking loop of my own", loop_step, start, loop))
found = compare(chosen, [*shipped, *mine], seeds=20)
print("rms of the speed's error in rad/s; sectors lost")
for scenario in wanted:
    for name in found.contenders:
        scores = found.scores[scenario, name]
        error, lost = scores["speed_error_rms_rad_s"].value, scores["lost_sectors"].value
        print(f"{scenario:13} {name:13} {error:7.3g} {lost:4.0f}")

# %% [markdown]
# A fixed bandwidth is a choice between quiet and quick: the slow loop is the quieter one at a steady speed and late at the step, the quick one the other way
# round. The event filter has both, and knows which edge it was where edges are missed; a loop that counts cannot.
#
# The same step runs over a measured log with `vvdp.simulation.replay.Replay(step, memory, reading, settings)`, in portions of rows as `vvdp estimate`
# does, and inside a simulated machine as part of a program: [a controller of your own](own-controller.md) calls its estimator that way.
