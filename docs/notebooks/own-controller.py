# %% [markdown]
# # A sensor, an estimator and a controller of your own
#
# A gauge with noise and a lag measures the pressure of a line; an estimator calculates the pressure and its rate from the
# measured values; a controller opens a throttle so that the line keeps 60 bar while the pump's flow steps. All three are plain
# functions: they run here as they are, over a record, and compiled in the loop.

# %%
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Area, Flow, Fraction, Number, Power, Pressure, Rate, Time
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.base.signal import step
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.library import UsualOil
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.ports import Medium
from vvdp.network.build import build
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.network.program import ProgramType
from vvdp.sensing.instrument import ideal_instrument
from vvdp.simulation.balance import balance
from vvdp.simulation.replay import Replay
from vvdp.simulation.run import Stepping, simulate

# %% [markdown]
# ## The sensor
#
# An instrument of the library is enough here: range, lag, resolution, noise, offset and faults are values. What it does not cover is
# written as a step of a program: [a sensor of your own](own-sensor.md).

# %%
gauge = replace(ideal_instrument(0.0, 250e5), lag=1e-3, resolution=0.1e5, noise=0.3e5, seed=1.0)

# %% [markdown]
# ## The estimator
#
# Its measured values are a `reading`, its internal values a `memory`, its parameters the `settings`: each is a record with kinds, so that
# everything is checked for range, recorded by name and printed with its unit. The equation is that of an alpha-beta filter.


# %%
class Seen(NamedTuple):
    pressure: Pressure


class Belief(NamedTuple):
    pressure: Pressure
    rate: Number


class Tracker(Params):
    period: Time
    bandwidth: Rate


def track(t: float, belief: Belief, seen: Seen, settings: Tracker) -> tuple[Belief, Belief]:
    """Pressure and its relative rate: a prediction, corrected by what the gauge shows."""
    h, w = settings.period, settings.bandwidth
    predicted = belief.pressure * (1.0 + belief.rate * h)
    error = seen.pressure - predicted
    pressure = predicted + (1.0 - np.exp(-1.4 * w * h)) * error
    rate = belief.rate + (w * h) ** 2 / h * error / belief.pressure
    after = Belief(clip(pressure, 1e4, 1e9), rate)
    return after, after


# %% [markdown]
# It is tried by hand, then over a record: 2000 noisy samples of a constant pressure of 50 bar. `Replay` compiles the step and runs it over the
# rows of an array, as `vvdp estimate` does over a log of any length.

# %%
tracker = Tracker(period=1e-3, bandwidth=150.0)
after, _ = track(0.0, Belief(50e5, 0.0), Seen(51e5), tracker)
print(f"{1e-5 * after.pressure:.3f} bar, {after.rate:.3f} of it per second")


def track_rows(belief: Belief, seen: Seen, settings: Tracker) -> tuple[Belief, Belief]:
    """The same for a record, whose rows are samples."""
    return track(0.0, belief, seen, settings)


rows = 50e5 + 0.3e5 * np.random.default_rng(0).standard_normal((2000, 1))
shown = Replay(track_rows, Belief(50e5, 0.0), Seen(0.0), tracker)(Belief(50e5, 0.0), rows, tracker).shown
print(f"noise {1e-5 * rows[500:].std():.2f} bar, estimate {1e-5 * shown[500:, 0].std():.3f} bar")

# %% [markdown]
# ## The controller
#
# It calls the estimator and acts on the estimate. One program may hold all three, as here, or each may be a program of its own with its
# own sample period.


# %%
class Gains(Params):
    tracker: Tracker
    target: Pressure
    band: Pressure
    reset_time: Time


class Memory(NamedTuple):
    belief: Belief
    integral: Fraction


class Asked(NamedTuple):
    opening: Fraction
    believed: Pressure


def begin(gains: Gains) -> Memory:
    """Believes in the target at first."""
    return Memory(Belief(gains.target, 0.0), 0.5)


def control(t: float, memory: Memory, seen: Seen, gains: Gains) -> tuple[Memory, Asked]:
    """PI on the believed pressure; the integral stands still while the opening is at an end."""
    belief, _ = track(t, memory.belief, seen, gains.tracker)
    error = (belief.pressure - gains.target) / gains.band
    integral = clip(memory.integral + error * gains.tracker.period / gains.reset_time, 0.0, 1.0)
    return Memory(belief, integral), Asked(clip(error + integral, 0.0, 1.0), belief.pressure)


CONTROL = ProgramType(control, Seen, Asked(0.5, 60e5), Gains, begin)

# %% [markdown]
# ## The circuit
#
# A throttle whose opening follows the command with a lag is a custom component as well: an equation and a record that names it.


# %%
class Throttle(Orifice):
    full_area: Area
    lag: Time


class Opening(NamedTuple):
    opening: Fraction


class Throttled(NamedTuple):
    flow: Flow
    loss: Power
    rates: Opening


def throttle(
    a: FluidState, b: FluidState, command: Fraction, state: Opening, medium: Medium, values: Throttle
) -> Throttled:
    """Orifice from a to b whose opening follows a command with a lag."""
    drop = a.pressure - b.pressure
    flow, loss = passage(orifice_flow(state.opening * values.full_area, drop, medium.density, values), a, b)
    return Throttled(flow, loss, Opening((command - state.opening) / values.lag))


THROTTLE = Component(throttle, symbol="proportional_valve")

net = Network(UsualOil())
net.tank("tank")
net.volume("line", Chamber(volume=500e-6), start=61e5)
net.add("pump", FLOW_SOURCE, FlowSource(), a="tank", b="line", flow=step(20 / 6e4, 30 / 6e4, 0.5))
net.add("throttle", THROTTLE, Throttle(full_area=10e-6, lag=0.01), a="line", b="tank", command="control.opening")
gains = Gains(tracker=tracker, target=61e5, band=100e5, reset_time=0.1)
net.program("control", CONTROL, gains, reads={"pressure": "line.pressure"}, sensors={"pressure": gauge}, period=1e-3)
circuit = build(net)
run = simulate(circuit.model, circuit.case, Stepping(until=1.5))
late = run.times > 1.2
print(f"line {1e-5 * run.state.line[late].mean():.2f} bar absolute, {1e-5 * run.state.line.max():.1f} at most")
print(f"scatter of the line {1e-5 * run.state.line[late].std():.3f} bar, trusted: {balance(run).is_trusted}")

# %%
import matplotlib.pyplot as plt

figure, axis = plt.subplots(figsize=(7, 3))
axis.plot(run.times, 1e-5 * run.state.line, label="line")
axis.plot(run.times, 1e-5 * run.command.control.believed, label="believed", linewidth=0.8)
axis.set(xlabel="time [s]", ylabel="pressure, absolute [bar]")
axis.legend()
figure.tight_layout()
