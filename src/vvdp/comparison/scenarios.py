"""Scenarios of the estimators: how the shaft turns, what the encoder is like, what counts."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.signal import constant, ramp
from vvdp.comparison.motion import Lag, Motion, Ramps, Ripple, steady
from vvdp.comparison.scores import Truth
from vvdp.evaluation.bench import rotary_bench
from vvdp.fluid.oil import Oil, density, dynamic_viscosity, film_ratios
from vvdp.sensing.encoder import NO_FAULTS, SAMPLED, Encoder, capture_unit
from vvdp.sensing.photodiode import LightSpot
from vvdp.sensing.wheel import TURN, equal_wheel
from vvdp.systems.system import load_system
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import (
    equilibrium_speed,
    flow_damping,
    friction_coefficient,
    spool_inertia,
    spool_time_constant,
    stall_torque,
)

LPM = 1e-3 / 60.0
SLOW_FLOW, FAST_FLOW = 26.7 * LPM, 40.0 * LPM
"""Pump flows before and after the step [m^3/s]: wang2017, section 3.6."""
WARM_OIL = 313.15

SLOW_SPOOL, FAST_SPOOL = 126.7, 133.0
"""Between which speeds the spool swings while it switches [rad/s]: ours, docs/comparison.md."""

RATE = 1000.0
"""At which the published encoder was sampled [Hz]: wang2017, section 3.5."""
SECTORS, SPOT_SHARE, SECTOR_LENGTH = 8, 0.625, 8e-3
"""The published wheel: a spot of 5 mm on sectors of 8 mm: wang2017, section 3.2."""
LIGHT_NOISE = 0.098
"""Standard deviation of the light at the comparator [1]: edges of the published wheel then scatter by 0.048 rad, as
much as the published triangle of 1.5 ms at 25 Hz."""

SLOWEST, FASTEST = 100.0, 1e5
"""Rates between which a comparison makes sense and fits into memory [Hz]."""

USUAL_TURNS = 24.7
"""Turns per second where nothing else is stated: near the published 25, but in step with no usual clock."""

SETTLED = 0.5
"""Errors count from this time on [s]: all estimators have begun by then."""


@dataclass(frozen=True)
class Scenario:
    """A shaft that moves in a known way, and the encoder on it, sampled at `rate` [Hz] until `until` [s].

    Errors count from `scored_from` [s] on. Clock phase, wheel angle and noise are drawn again for each seed. Raises
    ParameterError for a rate at which there is nothing to see or too much to keep.
    """

    name: str
    title: str
    motion: Motion
    encoder: Encoder
    rate: float
    until: float
    scored_from: float = SETTLED

    def __post_init__(self) -> None:
        if not SLOWEST <= self.rate <= FASTEST:
            raise ParameterError(f"a sampling rate of {self.rate:g} Hz; expected {SLOWEST:g} Hz to {FASTEST:g} Hz")

    @property
    def samples(self) -> int:
        """How many samples there are."""
        return int(np.floor(self.until * self.rate))

    @property
    def sectors(self) -> int:
        """How many sectors the code wheel has."""
        return len(self.encoder.wheel.edges)

    @property
    def sector(self) -> float:
        """Mean width of a sector [rad]."""
        return TURN / self.sectors


class Record(NamedTuple):
    """Course of one run, and the output of the encoder."""

    seed: int
    truth: Truth
    readings: Array  # (samples, fields of Reading)


def encoder_of(sectors: int) -> Encoder:
    """A sampled encoder of equal sectors without faults; the spot covers 5/8 of a sector, as published.

    Raises ParameterError for an odd number of sectors.
    """
    length = SECTOR_LENGTH * SECTORS / sectors
    return Encoder(
        wheel=equal_wheel(sectors),
        spot=LightSpot(width=SPOT_SHARE * length, track_radius=sectors * length / TURN, roundness=0.0),
        threshold=constant(0.5),
        hysteresis=0.0,
        noise=LIGHT_NOISE,
        counter_bits=16.0,
        acquisition=SAMPLED,
        faults=NO_FAULTS,
    )


class Drive(NamedTuple):
    """Rotary drive of the prototype's spool: its valve, and its oil at 40 degC; in the clearance it is thicker, by a
    ratio, than at the reference pressure."""

    valve: RotaryValve
    oil: Oil
    density: float  # [kg/m^3]
    viscosity: float  # dynamic, in the clearance [Pa s]
    thickening: float  # [1]


@cache
def drive() -> Drive:
    """The drive of the shipped prototype."""
    bench = rotary_bench(load_system("prototype"), "compare")
    thickening = film_ratios(bench.load_pressure, bench.tank_pressure, bench.oil).viscosity
    viscosity = dynamic_viscosity(WARM_OIL, bench.oil) * thickening
    return Drive(bench.valve, bench.oil, density(WARM_OIL, bench.oil), viscosity, thickening)


def flow_step(at: float) -> Lag:
    """The spool of the prototype, fully open and spun by its flow, when that steps from 26.7 to 40 lpm at `at` [s].

    At a constant flow the balance of torques is linear in the speed, so the spool follows as a first-order lag.

    Source  ours, docs/models/rotary-valve.md
    """
    valve, _, rho, mu, _ = drive()
    before, after = (equilibrium_speed(flow, rho, mu, valve) for flow in (SLOW_FLOW, FAST_FLOW))
    return Lag(float(before), float(after), at, float(spool_time_constant(FAST_FLOW, rho, mu, valve)))


def pwm_ripple() -> Ripple:
    """The spool of the prototype within its PWM periods: from `SLOW_SPOOL` to `FAST_SPOOL` and back, three a turn.

    The mean over time is the geometric mean of the two: sqrt(126.7 133) = 129.8 rad/s.

    Source  ours, docs/comparison.md
    """
    share = (FAST_SPOOL - SLOW_SPOOL) / (FAST_SPOOL + SLOW_SPOOL)
    return Ripple(float(np.sqrt(FAST_SPOOL * SLOW_SPOOL)), share, 3.0)


def driving_flow(motion: Lag, time: Array) -> Array:
    """The flow that makes the prototype's spool move as `motion` says [m^3/s], positive.

    From J omega' = rho Q^2 (R_in/A_in + R_out/A_out,eff) - (k_f + rho R_out^2 Q) omega, quadratic in Q.

    Source  wang2017, eqs. 2.6, 2.7 and 2.9
    """
    valve, _, rho, mu, _ = drive()
    omega = motion.speed(time)
    a, b = stall_torque(1.0, rho, valve), flow_damping(1.0, rho, valve) * omega
    c = friction_coefficient(mu, valve) * omega + spool_inertia(valve) * motion.acceleration(time)
    flow: Array = (b + np.sqrt(b * b + 4.0 * a * np.clip(c, 0.0, None))) / (2.0 * a)
    return flow


def scenarios(sectors: int = SECTORS, rate: float = RATE) -> tuple[Scenario, ...]:
    """All scenarios, for a wheel of `sectors` sectors sampled at `rate` [Hz].

    Raises ParameterError for an odd number of sectors, and for a rate outside 100 Hz to 100 kHz.
    """
    sound = encoder_of(sectors)
    sharp = replace(sound, noise=0.0)
    usual = steady(USUAL_TURNS * TURN)
    in_step = commensurate_turns(sectors, rate)

    def faulty(**faults: float) -> Encoder:
        return replace(sound, faults=replace(NO_FAULTS, **faults))

    def scenario(name: str, title: str, motion: Motion, encoder: Encoder = sound, until: float = 2.5) -> Scenario:
        return Scenario(name=name, title=title, motion=motion, encoder=encoder, rate=rate, until=until)

    return (
        scenario("constant", "24.7 Hz, the edges fall anywhere between two samples", usual),
        scenario(
            "commensurate",
            f"{in_step:.4g} Hz, a sector takes a whole number of samples, sharp edges",
            steady(in_step * TURN),
            sharp,
        ),
        scenario("step", "pump flow steps from 26.7 to 40 lpm at 1 s", flow_step(1.0)),
        scenario(
            "start", "from rest to 24.7 Hz, time constant 0.5 s", Lag(0.0, USUAL_TURNS * TURN, 0.2, 0.5), until=4.0
        ),
        scenario("missed-edges", "24.7 Hz, a fifth of the edges missed", usual, faulty(missed_edges=0.2)),
        scenario("double-edges", "24.7 Hz, one edge in twenty bounces", usual, faulty(double_edges=0.05)),
        scenario("dropout", "24.7 Hz, no edges from 1 s to 1.3 s", usual, faulty(dropout_begin=1.0, dropout_end=1.3)),
        scenario(
            "long-dropout", "24.7 Hz, no edges from 1 s to 2 s", usual, faulty(dropout_begin=1.0, dropout_end=2.0), 3.0
        ),
        scenario("threshold-bias", "24.7 Hz, threshold at 0.65", usual, replace(sound, threshold=constant(0.65))),
        scenario(
            "threshold-drift",
            "24.7 Hz, threshold from 0.35 to 0.65 within 2 s",
            usual,
            replace(sound, threshold=ramp(0.35, 0.65, 0.5, 2.5)),
        ),
        scenario("eccentric", "24.7 Hz, wheel off centre by 0.05 of its radius", usual, faulty(eccentricity=0.05)),
        scenario(
            "captured", "24.7 Hz, sharp edges, each stamped", usual, replace(sharp, acquisition=capture_unit(0.0))
        ),
        *_unsteady(sound, rate),
    )


def _unsteady(encoder: Encoder, rate: float) -> Iterator[Scenario]:
    """Motions that are not the flow's own: the ripple of the ports, a stop, a reversal."""
    ripple = f"{SLOW_SPOOL:g} to {FAST_SPOOL:g} rad/s within a PWM period, three of them a turn"
    stop = Ramps((0.0, 2.0, 2.05, 4.0, 4.05), (155.0, 155.0, 0.0, 0.0, 155.0))
    reversal = Ramps((0.0, 1.8, 2.8), (100.0, 100.0, -100.0))
    for name, title, motion, until in (
        ("pwm-ripple", ripple, pwm_ripple(), 2.5),
        ("stop", "155 rad/s, jammed within 50 ms at 2 s, free again at 4 s", stop, 5.5),
        ("reversal", "from 100 rad/s forward to 100 rad/s backward within 1 s", reversal, 4.5),
    ):
        yield Scenario(name=name, title=title, motion=motion, encoder=encoder, rate=rate, until=until)


def commensurate_turns(sectors: int, rate: float) -> float:
    """The turns per second closest to 25 for which a sector takes a whole number of samples [1/s].

    sectors  of the wheel
    rate     of sampling [Hz]

    Source  ours, docs/comparison.md
    """
    samples = max(1.0, round(rate / (25.0 * sectors)))
    return rate / (samples * sectors)
