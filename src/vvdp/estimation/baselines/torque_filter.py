"""Angle and speed from edges by a filter with a model of the torques on the spool.

At a constant flow the spool's speed is a first-order lag, so that every interval is propagated exactly. The third
spin is the excess of the torque over that of the model. Derived in docs/models/torque-filter.md.

Source  ours, docs/models/torque-filter.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    AccelerationDensity,
    AngularVariance,
    Flow,
    Kind,
    Ratio,
    RatioDrift,
    Speed,
    SpeedVariance,
    Temperature,
)
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import maximum, minimum
from vvdp.estimation.association import Sighting, associated_edge, counted_edge, first_edge, irregular_share, sector
from vvdp.estimation.between_edges import SLACK
from vvdp.estimation.estimator import Estimate, Estimator, to_estimate
from vvdp.estimation.event_filter import UNBELIEVABLE
from vvdp.estimation.event_memory import RELIABLE, Tally, new_tally
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.estimation.starting_again import BURST
from vvdp.fluid.oil import Oil, density, dynamic_viscosity
from vvdp.numerics.kalman import AngleSpeed
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle, edge_below
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import flow_damping, friction_coefficient, spool_inertia, stall_torque

ExcessVariance = Annotated[float, Kind("variance of a ratio", "1", 0.0, 1e6, "0.09")]


class TorqueFilter(Params):
    """Settings of the filter with the torque balance; `torque_filter` has the usual ones.

    `excess_density` is how fast the variance of the torque's excess over the model grows, `excess_variance` what it is
    at the start. When the sum of innovations exceeds `manoeuvre_gate`, the torque is taken to have changed suddenly, by
    a share of it with the variance `change_variance`. `film_thickening` is by how much the pressures at load and tank
    thicken the oil in the clearance, see `fluid.oil.film_ratios`. The other words are those of the event filter.
    """

    acceleration_density: AccelerationDensity
    excess_density: RatioDrift
    edge_variance: AngularVariance
    lowest_speed: Speed
    angle_variance: AngularVariance
    speed_variance: SpeedVariance
    excess_variance: ExcessVariance
    change_variance: ExcessVariance
    manoeuvre_gate: Ratio
    association_speed_deviation: Speed
    wheel: CodeWheel
    oil: Oil
    valve: RotaryValve
    film_thickening: Ratio = 1.0

    def check(self) -> None:
        """Refuse edges without any error: the covariance would become singular."""
        require_positive(self, "edge_variance", why="no edge is known exactly")


class TorqueReading(NamedTuple):
    """Inputs of the filter at a sample: the edges, and the oil that turned the spool since the sample before.

    `flow` is the mean over that interval [m^3/s]; below zero it counts as none. `temperature` is that of the oil [K].
    """

    reading: Reading
    flow: Flow
    temperature: Temperature


class SpoolMotion(NamedTuple):
    """Angle [rad], speed [rad/s] and excess, the torque over that of the model, less 1 [1]."""

    angle: float
    speed: float
    excess: float


class SpoolCovariance(NamedTuple):
    """Variances and covariances of a `SpoolMotion`."""

    angle: float
    angle_speed: float
    angle_excess: float
    speed: float
    speed_excess: float
    excess: float


class SpoolBelief(NamedTuple):
    """Belief of the filter about the spool."""

    mean: SpoolMotion
    covariance: SpoolCovariance


class TorqueChange(NamedTuple):
    """The sums of innovations that show when the torque changes, and when both were 0 last."""

    rise: float
    fall: float
    calm_time: float


class TorqueFilterMemory(NamedTuple):
    """Memory of the filter from sample to sample: its belief at the last sample, and the number of the last edge that
    it used."""

    time: float
    belief: SpoolBelief
    edge: float
    tally: Tally
    change: TorqueChange


class Spin(NamedTuple):
    """The spool at some flow: it accelerates by drive - damping speed."""

    drive: float  # b [rad/s^2]
    damping: float  # a [1/s]


class Lag(NamedTuple):
    """A first-order lag exp(-a t) over an interval h, and its integrals."""

    decay: float  # exp(-a h)
    once: float  # f1, its integral over h [s]
    twice: float  # f2, that of f1 [s^2]
    thrice: float  # f3 [s^3]
    once_squared: float  # integral of f1^2 [s^3]
    twice_squared: float  # integral of f2^2 [s^5]


def torque_filter(wheel: CodeWheel, oil: Oil, valve: RotaryValve) -> TorqueFilter:
    """The usual settings; change one with `dataclasses.replace`.

    Source  ours, docs/models/torque-filter.md; what it shares with the event filter is that of `event_filter`
    """
    shared = event_filter(wheel)
    return TorqueFilter(
        acceleration_density=shared.acceleration_density,
        excess_density=1e-4,
        edge_variance=shared.edge_variance,
        lowest_speed=shared.lowest_speed,
        angle_variance=shared.angle_variance,
        speed_variance=shared.speed_variance,
        excess_variance=0.09,
        change_variance=0.02,
        manoeuvre_gate=shared.manoeuvre_gate,
        association_speed_deviation=shared.association_speed_deviation,
        wheel=wheel,
        oil=oil,
        valve=valve,
    )


def pump_delivery(pump_speed: float, displacement: float, volumetric_efficiency: float) -> float:
    """Flow that a pump sends through the valve [m^3/s]: eta_v D omega_p.

    pump_speed             measured or commanded [rad/s]
    displacement           D [m^3/rad]
    volumetric_efficiency  eta_v [1]
    """
    return volumetric_efficiency * displacement * pump_speed


def spool_spin(flow: float, temperature: float, oil: Oil, valve: RotaryValve, thickening: float = 1.0) -> Spin:
    """Drive and damping of the spool of the fully open valve: b = stall torque / J, a = (k_f + rho R_out^2 Q) / J.

    flow         [m^3/s]
    temperature  of the oil [K]
    thickening   viscosity in the clearance over that at the oil's reference pressure [1]

    Source  wang2017, eqs. 2.6, 2.7 and 2.9
    """
    J, Q = spool_inertia(valve), maximum(flow, 0.0)
    rho = density(temperature, oil)
    friction = friction_coefficient(dynamic_viscosity(temperature, oil) * thickening, valve)
    return Spin(stall_torque(Q, rho, valve) / J, (friction + flow_damping(Q, rho, valve)) / J)


def lag(duration: float, damping: float) -> Lag:
    """A first-order lag over `duration` [s] of either sign, and its integrals; damping [1/s].

    In closed form, or by its power series in x = a h where the closed form would lose digits.
    """
    h, a = duration, damping
    x = a * h
    if abs(x) > 0.7:
        e, f1 = np.exp(-x), -np.expm1(-x) / a
        f2 = (h - f1) / a
        f3 = (0.5 * h * h - f2) / a
        f4 = (h * h * h / 6.0 - f3) / a
        return Lag(
            decay=e,
            once=f1,
            twice=f2,
            thrice=f3,
            once_squared=(f2 - 0.5 * f1 * f1) / a,
            twice_squared=(h * f3 - f4 - 0.5 * f2 * f2) / a,
        )
    # Sums of (-x)^k/(k+3)!, of (2^n - 2) (-x)^(n-2)/((n+1) n!) and of (2^n - 2 n - 2) (-x)^(n-4)/((n+1) n!).
    power, factorial, two = 1.0, 2.0, 4.0
    third, first_squared, second_squared = 0.0, 0.0, 0.0
    for k in range(18):
        n = 2.0 + k
        first_squared += (two - 2.0) / ((n + 1.0) * factorial) * power
        factorial *= n + 1.0
        third += power / factorial
        four = 4.0 * two
        second_squared += (four - 2.0 * (n + 3.0)) / ((n + 3.0) * factorial * (n + 2.0)) * power
        two *= 2.0
        power *= -x
    f3 = h * h * h * third
    f2 = 0.5 * h * h - a * f3
    f1 = h - a * f2
    return Lag(
        decay=1.0 - a * f1,
        once=f1,
        twice=f2,
        thrice=f3,
        once_squared=h * h * h * first_squared,
        twice_squared=h * h * h * h * h * second_squared,
    )


def predict_spool(
    belief: SpoolBelief, duration: float, spin: Spin, acceleration_density: float, excess_density: float
) -> SpoolBelief:
    """The belief after `duration` [s] at one flow without an edge; a negative one goes back and takes noise out again.

    omega' = b (1 + e) - a omega + w,  e' = v, with white noises w and v. Exact: F = [[1, f1, b f2], [0, exp(-a h),
    b f1], [0, 0, 1]], F P F' + Q, with f1, f2 and Q as in `lag`.

    acceleration_density  of w, q [rad^2/s^3]
    excess_density        of v, q_e [1/s]
    """
    b, q, q_e = spin.drive, acceleration_density, excess_density
    E, f1, f2, f3, f11, f22 = lag(duration, spin.damping)
    g1, g2 = b * f1, b * f2
    x, P = belief
    P11, P12, P13 = P.angle, P.angle_speed, P.angle_excess
    P22, P23, P33 = P.speed, P.speed_excess, P.excess
    # Rows of F P: r of the angle, s of the speed.
    r1, r2, r3 = P11 + f1 * P12 + g2 * P13, P12 + f1 * P22 + g2 * P23, P13 + f1 * P23 + g2 * P33
    s2, s3 = E * P22 + g1 * P23, E * P23 + g1 * P33
    mean = SpoolMotion(
        angle=x.angle + f1 * x.speed + g2 * (1.0 + x.excess),
        speed=E * x.speed + g1 * (1.0 + x.excess),
        excess=x.excess,
    )
    covariance = SpoolCovariance(
        angle=r1 + f1 * r2 + g2 * r3 + q * f11 + q_e * b * b * f22,
        angle_speed=E * r2 + g1 * r3 + 0.5 * q * f1 * f1 + 0.5 * q_e * g2 * g2,
        angle_excess=r3 + q_e * b * f3,
        speed=E * s2 + g1 * s3 + 0.5 * q * f1 * (1.0 + E) + q_e * b * b * f11,
        speed_excess=s3 + q_e * g2,
        excess=P33 + q_e * duration,
    )
    return SpoolBelief(mean=mean, covariance=covariance)


def update_spool(belief: SpoolBelief, innovation: float, measurement_variance: float) -> SpoolBelief:
    """The belief after an edge at an angle that differs from the expected one by `innovation` [rad].

    K = P H / S, S = P11 + R, P+ = P - K S K'; the row of the angle as R/S of what it was, without cancellation.

    measurement_variance  R [rad^2]

    Source  wang2017, eqs. 3.8 and 3.9, corrected: docs/errata.md
    """
    (x, P), R = belief, measurement_variance
    P11, P12, P13 = P.angle, P.angle_speed, P.angle_excess
    S = P11 + R
    k1, k2, k3 = P11 / S, P12 / S, P13 / S
    left = R / S
    mean = SpoolMotion(
        angle=x.angle + k1 * innovation, speed=x.speed + k2 * innovation, excess=x.excess + k3 * innovation
    )
    covariance = SpoolCovariance(
        angle=left * P11,
        angle_speed=left * P12,
        angle_excess=left * P13,
        speed=P.speed - k2 * P12,
        speed_excess=P.speed_excess - k2 * P13,
        excess=P.excess - k3 * P13,
    )
    return SpoolBelief(mean=mean, covariance=covariance)


def inflate(belief: SpoolBelief, duration: float, spin: Spin, excess_variance: float) -> SpoolBelief:
    """The belief when the torque may have changed suddenly `duration` [s] ago: P + V g g', g = (b f2, b f1, 1).

    excess_variance  V, of the change of the excess [1]
    """
    past, P, V = lag(duration, spin.damping), belief.covariance, excess_variance
    g1, g2 = spin.drive * past.once, spin.drive * past.twice
    covariance = SpoolCovariance(
        angle=P.angle + V * g2 * g2,
        angle_speed=P.angle_speed + V * g2 * g1,
        angle_excess=P.angle_excess + V * g2,
        speed=P.speed + V * g1 * g1,
        speed_excess=P.speed_excess + V * g1,
        excess=P.excess + V,
    )
    return SpoolBelief(mean=belief.mean, covariance=covariance)


def reset_speed(belief: SpoolBelief, settings: TorqueFilter) -> SpoolBelief:
    """The belief whose speed may have been anything, a multiple or a fraction of the true one, and its excess with it.

    Source  ours, docs/models/event-filter.md
    """
    x, P = belief
    covariance = P._replace(
        speed=maximum(x.speed * x.speed, settings.speed_variance),
        excess=maximum(x.excess * x.excess, settings.excess_variance),
    )
    return SpoolBelief(mean=x, covariance=covariance)


def torque_filter_start(settings: TorqueFilter, time: float, angle: float, speed: float) -> TorqueFilterMemory:
    """Memory before the first sample.

    time   [s]
    angle  where the wheel stands, as far as is known [rad]
    speed  expected [rad/s]
    """
    covariance = SpoolCovariance(
        angle=settings.angle_variance,
        angle_speed=0.0,
        angle_excess=0.0,
        speed=settings.speed_variance,
        speed_excess=0.0,
        excess=settings.excess_variance,
    )
    belief = SpoolBelief(mean=SpoolMotion(angle=angle, speed=speed, excess=0.0), covariance=covariance)
    return TorqueFilterMemory(
        time=time,
        belief=belief,
        edge=edge_below(angle, settings.wheel),
        tally=new_tally(),
        change=TorqueChange(rise=0.0, fall=0.0, calm_time=time),
    )


def torque_filter_step(
    memory: TorqueFilterMemory, reading: TorqueReading, settings: TorqueFilter
) -> tuple[TorqueFilterMemory, Estimate]:
    """Memory and estimate after a sample: forward to the edge, if there was one, and on to the sample.

    Source  ours, docs/models/torque-filter.md, as wang2017 suggests in section 3.6
    """
    now = reading.reading.time
    spin = spool_spin(reading.flow, reading.temperature, settings.oil, settings.valve, settings.film_thickening)
    innovation, deviation = 0.0, 0.0
    if reading.reading.edges > 0.0:
        memory, innovation, deviation = _after_edge(memory, reading.reading, spin, settings)
    q, q_e = settings.acceleration_density, settings.excess_density
    belief = predict_spool(memory.belief, now - memory.time, spin, q, q_e)
    m = memory
    memory = m._replace(time=now, belief=belief)
    x, P = belief
    motion = AngleSpeed(x.angle, x.speed, P.angle, P.angle_speed, P.speed)
    estimate = to_estimate(motion, np.nan, innovation, deviation, memory.tally.missed_edges)
    return memory, estimate


def _after_edge(
    memory: TorqueFilterMemory, reading: Reading, spin: Spin, settings: TorqueFilter
) -> tuple[TorqueFilterMemory, float, float]:
    wheel, gate, m = settings.wheel, settings.manoeuvre_gate, memory
    prior = predict_spool(
        m.belief, reading.edge_time - m.time, spin, settings.acceleration_density, settings.excess_density
    )
    wide = inflate(prior, reading.edge_time - m.change.calm_time, spin, settings.change_variance)
    R = edge_angle_variance(prior.mean.speed, reading.edge_interval, settings)
    edges = m.tally.ignored + reading.edges
    if m.tally.started == 0.0:
        number = first_edge(m.belief.mean.angle, reading.polarity, wheel)
        edges = number - m.edge
    elif m.tally.associating == 0.0:
        number = counted_edge(m.edge, edges, reading.polarity)
    else:
        sighting = Sighting(
            angle=prior.mean.angle,
            advance=prior.mean.angle - edge_angle(m.edge, wheel),
            variance=prior.covariance.angle + R,
            manoeuvre_variance=wide.covariance.angle + R,
            manoeuvre_odds=2.0 * SLACK * (gate - m.change.fall),  # in doubt the next edge by count is behind: slower
            ignored=m.tally.ignored,
            fresh=reading.edges,
            polarity=reading.polarity,
            irregular=m.tally.irregular,
        )
        seen = associated_edge(m.edge, sighting, wheel)
        number = seen.edge
        if seen.used == 0.0:
            tally = m.tally._replace(ignored=edges, irregular=irregular_share(m.tally.irregular, reading.edges, 0.0))
            ignoring = m._replace(tally=tally)
            return ignoring, 0.0, 0.0

    innovation = edge_angle(number, wheel) - prior.mean.angle
    rise, fall = 0.0, 0.0
    if m.tally.associating > 0.0:
        z = innovation / np.sqrt(prior.covariance.angle + R)
        rise, fall = maximum(m.change.rise + z - SLACK, 0.0), maximum(m.change.fall - z - SLACK, 0.0)
        if maximum(rise, fall) > gate:
            prior, rise, fall = wide, 0.0, 0.0
    skipped = maximum(number - m.edge - edges, 0.0)
    associating, irregular = (
        m.tally.associating,
        irregular_share(m.tally.irregular, m.tally.associating * minimum(skipped, BURST), 1.0),
    )
    if irregular > UNBELIEVABLE:
        prior, associating, irregular = reset_speed(prior, settings), 0.0, RELIABLE
    belief = update_spool(prior, innovation, R)
    known = 6.0 * np.sqrt(belief.covariance.angle) < sector(wheel)
    limit = settings.association_speed_deviation * settings.association_speed_deviation
    tally = Tally(
        started=1.0,
        associating=1.0 if associating > 0.0 or (known and belief.covariance.speed < limit) else 0.0,
        ignored=0.0,
        missed_edges=m.tally.missed_edges + skipped,
        irregular=irregular,
        watched=m.tally.watched + 1.0,
    )
    calm_time = reading.edge_time if maximum(rise, fall) == 0.0 else m.change.calm_time
    change = TorqueChange(rise=rise, fall=fall, calm_time=calm_time)
    after = TorqueFilterMemory(time=reading.edge_time, belief=belief, edge=number, tally=tally, change=change)
    return after, innovation, np.sqrt(prior.covariance.angle + R)


def torque_filter_estimator(
    settings: TorqueFilter, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The filter with the torque balance, ready to run; `angle` [rad] and `speed` [rad/s] as far as they are known."""
    memory = torque_filter_start(settings, time, angle, speed)
    return Estimator("Kalman filter with torque balance", torque_filter_step, memory, settings)
