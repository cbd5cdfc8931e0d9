# %% [markdown]
# # A sensor of your own
#
# A program of vvdp never receives the state of the circuit, only what a sensor measures of it. Most sensors are an *instrument* of the
# library: range, lag, offset, noise, resolution and faults, all of them values ([instrument](../models/instrument.md)). This page writes
# one that is more than that: a flow meter of two gear wheels. It gives pulses, one for each filling of its teeth, and some oil
# slips past them uncounted.
#
# A sensor is a step, `step(t, memory, reading, settings) -> (memory, shown)`, of plain numbers. It is tried by hand, and the same
# function then runs compiled in a circuit.

# %%
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Count, Flow, Time, Volume
from vvdp.base.params import Params
from vvdp.base.select import maximum, minimum
from vvdp.base.signal import step
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.library import UsualOil
from vvdp.components.resistances import ORIFICE
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.orifice import Orifice
from vvdp.network.build import build
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.network.program import ProgramType
from vvdp.simulation.balance import balance
from vvdp.simulation.run import Stepping, simulate

LPM = 1.0 / 6e4

# %% [markdown]
# ## Four records and a step
#
# *Settings* are a class of `Params`. Each value has a kind, which gives it a unit and a range that is checked when it is made; `check` refuses
# combinations that no range excludes. *Reading* is the true state, *memory* what the sensor keeps between two samples, and what it *shows* is
# all that estimators and controllers receive.


# %%
class GearMeter(Params):
    """A flow meter with `pulse_volume` to a pulse; `slip` passes the teeth uncounted."""

    pulse_volume: Volume
    slip: Flow

    def check(self) -> None:
        if not self.pulse_volume > 0.0:
            raise ParameterError(f"GearMeter.pulse_volume: {self.pulse_volume:g} m^3; expected more than 0")


class There(NamedTuple):
    flow: Flow


class Teeth(NamedTuple):
    time: Time
    filled: Volume
    pulsed: Time
    shown: Flow


class Told(NamedTuple):
    flow: Flow
    pulses: Count


def begin(settings: GearMeter) -> Teeth:
    return Teeth(0.0, 0.0, 0.0, 0.0)


def gear_meter(t: float, memory: Teeth, there: There, settings: GearMeter) -> tuple[Teeth, Told]:
    """The pulses of a sample, and the flow from the time since the pulse before; it fades while none comes."""
    filled = memory.filled + maximum(there.flow - settings.slip, 0.0) * (t - memory.time)
    pulses = np.floor(filled / settings.pulse_volume)
    pulsed, shown = memory.pulsed, memory.shown
    if pulses > 0.0:
        shown, pulsed = pulses * settings.pulse_volume / (t - memory.pulsed), t
    elif t > pulsed:
        shown = minimum(shown, settings.pulse_volume / (t - pulsed))
    return Teeth(t, filled - pulses * settings.pulse_volume, pulsed, shown), Told(shown, pulses)


# %% [markdown]
# ## By hand
#
# 6 lpm are 100 cc/s, of which 2 slip: with 1 cc to a pulse, 98 pulses come in a second. It is plain Python, so a debugger, a print and a test
# work as anywhere. A value out of its range is refused with its unit:

# %%
meter = GearMeter(pulse_volume=1e-6, slip=2e-6)
memory, pulses = begin(meter), 0.0
for k in range(1, 1001):
    memory, measured = gear_meter(1e-3 * k, memory, There(6 * LPM), meter)
    pulses += measured.pulses
print(f"{pulses:.0f} pulses, the last flow shown {measured.flow / LPM:.2f} lpm")
try:
    GearMeter(pulse_volume=-1e-6, slip=0.0)
except ParameterError as problem:
    print(problem)

# %% [markdown]
# ## In a circuit
#
# `ProgramType` names the parts; `reads` says where in the circuit each field of the reading comes from, and `period` how often the sensor is asked. What
# it shows is then read by others as `"meter.flow"`, an estimator or a controller for example, and recorded under that name. None of them can
# read past it.

# %%
METER = ProgramType(gear_meter, There, Told(0.0, 0.0), GearMeter, begin)

net = Network(UsualOil())
net.tank("tank")
net.volume("line", Chamber(volume=200e-6), start=2e5)
net.add("pump", FLOW_SOURCE, FlowSource(), a="tank", b="line", flow=step(20 * LPM, 6 * LPM, 0.5))
net.add("load", ORIFICE, Orifice(), a="line", b="tank", area=4e-6)
net.program("meter", METER, meter, reads={"flow": "load.flow"}, period=1e-3)
circuit = build(net)
run = simulate(circuit.model, circuit.case, Stepping(until=1.5))
measured, true = run.command.meter.flow, run.outputs.load_flow
early, late = (run.times > 0.2) & (run.times < 0.5), run.times > 1.0
for name, part in (("before", early), ("after", late)):
    mean, scatter = measured[part].mean() / LPM, measured[part].std() / LPM
    print(f"{name}: {true[part].mean() / LPM:.2f} lpm, measured {mean:.2f} +- {scatter:.2f} lpm")
print("trusted", balance(run).is_trusted)

# %% [markdown]
# The meter is low by about what slips, 0.12 lpm, and shows steps, since a pulse is only known to a sample: that is its noise, larger at large flow. Averaging pulses
# over a longer time would quieten it and make it late; [an estimator of your own](own-estimator.md) does better.

# %%
figure, axis = plt.subplots(figsize=(7, 3), layout="constrained")
axis.plot(run.times, measured / LPM, linewidth=0.8, label="measured")
axis.plot(run.times, true / LPM, label="true")
axis.set(xlabel="time [s]", ylabel="flow [lpm]")
axis.legend()
plt.show()
