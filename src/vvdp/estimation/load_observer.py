"""Velocity of a cylinder and the force of its load, from its position and the force of the oil on it.

m x'' = F_H - b x' + F_L with a load that stands still: an unknown constant load then leaves no velocity bias. Gains and
transition are exact for a force of the oil that is held between two samples. Derived in
docs/models/displacement-control.md.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Force, Mass, Position, Rate, Time, Velocity, ViscousFriction
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import require_positive

SLOW = 1e-3
"""Decay over a sample, b h/m, below which the transition is calculated as a series [1]."""


class LoadObserver(Params):
    """All three errors fade at the `observer_rate`; the reported load follows its estimate at the `load_rate`.

    Raises `ParameterError` where mass, sample period or a rate is not above 0.
    """

    moving_mass: Mass
    viscous_friction: ViscousFriction
    observer_rate: Rate
    load_rate: Rate
    sample_period: Time

    def check(self) -> None:
        require_positive(self, "moving_mass", "observer_rate", "load_rate", "sample_period")


class LoadMemory(NamedTuple):
    """Memory of the observer: its belief, the load that it shows, and the force of the oil at the last sample."""

    position: Position
    velocity: Velocity
    load_estimate: Force
    load_force: Force
    oil_force: Force


class CylinderStep(NamedTuple):
    """Motion over a sample: the velocity is multiplied by `keeping` [1] and adds `reach` [s] times itself to the
    position; an acceleration adds `reach` [s] to the velocity and `lift` [s^2] to the position."""

    keeping: float
    reach: float
    lift: float


class LoadGains(NamedTuple):
    """Corrections of position [1], velocity [1/s] and load [N/m] per innovation of the position [m]."""

    position: float
    velocity: float
    load: float


def cylinder_step(settings: LoadObserver) -> CylinderStep:
    """e = exp(-a h), (1 - e)/a and (h - (1 - e)/a)/a, a = b/m; the last ones as series where a h is small."""
    h, a = settings.sample_period, settings.viscous_friction / settings.moving_mass
    y = a * h
    if y < SLOW:
        reach = h * (1.0 - y / 2.0 * (1.0 - y / 3.0 * (1.0 - y / 4.0 * (1.0 - y / 5.0))))
        lift = h * h * (0.5 - y / 6.0 * (1.0 - y / 4.0 * (1.0 - y / 5.0 * (1.0 - y / 6.0))))
    else:
        reach = -expm1(-y) / a
        lift = (h - reach) / a
    return CylinderStep(1.0 - a * reach, reach, lift)


def load_gains(step: CylinderStep, settings: LoadObserver) -> LoadGains:
    """Gains with which all three errors fade as z = exp(-w h) from sample to sample, whatever they were.

    1 - z^3/e, (1 + e + z^3/e - 3 z - k_3 g/m)/d and m (1 - z)^3/(d h), d `reach` and g `lift`.
    """
    m, h = settings.moving_mass, settings.sample_period
    less = -expm1(-settings.observer_rate * h)
    z = 1.0 - less
    left = z * z * z / step.keeping
    load = m * less * less * less / (step.reach * h)
    velocity = (1.0 + step.keeping + left - 3.0 * z - load * step.lift / m) / step.reach
    return LoadGains(1.0 - left, velocity, load)


def load_observer_start(position: float, load_force: float) -> LoadMemory:
    """The memory before the first sample, at rest.  position: [m]; load_force: as expected, positive in its direction
    [N]."""
    return LoadMemory(
        position=position, velocity=0.0, load_estimate=load_force, load_force=load_force, oil_force=-load_force
    )


def load_observer_step(memory: LoadMemory, position: float, oil_force: float, settings: LoadObserver) -> LoadMemory:
    """The memory after a sample: its `velocity` and `load_force` are the estimates.

    position   as measured [m]
    oil_force  F_H of the pressures as measured [N]; between two samples their mean is held
    """
    step = cylinder_step(settings)
    gains = load_gains(step, settings)
    push = (0.5 * (memory.oil_force + oil_force) + memory.load_estimate) / settings.moving_mass
    expected = memory.position + step.reach * memory.velocity + step.lift * push
    innovation = position - expected
    load = memory.load_estimate + gains.load * innovation
    following = -expm1(-settings.load_rate * settings.sample_period)
    return LoadMemory(
        position=expected + gains.position * innovation,
        velocity=step.keeping * memory.velocity + step.reach * push + gains.velocity * innovation,
        load_estimate=load,
        load_force=memory.load_force + following * (load - memory.load_force),
        oil_force=oil_force,
    )
