"""Which settings of the filter a log speaks for: how fast its speed wanders, and by how much its edges scatter.

The innovations of a constant-speed Kalman filter are independent and Gaussian where its settings are right, so the
likelihood of a log is a product over its edges. Derived in docs/logs.md.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.event_settings import EventFilter
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.offline.edges import Chosen
from vvdp.offline.passed_edges import Passed
from vvdp.offline.turn_pattern import (
    Candidate,
    SpeedRipple,
    candidates,
    chance_of,
    is_likely,
    is_whole,
    ripple_in,
    ripple_patterns,
)
from vvdp.sensing.wheel import TURN
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay

TURNS_OF_A_WHEEL = 8
"""A wheel's edges are placed from so many turns, at least."""
MOST_PLACES = 256
EVEN = 0.9
"""Share of the times between edges that a clock has in common, whatever is damaged; edges of a spool share none."""
CLEAR = 10.0
"""By so much the logarithm of the likelihood has to be higher before one explanation is preferred to another."""
FASTEST_CHANGE = 1e4
"""Largest q T^3/R that is tried [1]: the speed is another with each edge."""
OPTIMISTIC = 1.3
"""Squared innovations so much larger than expected matter, whatever the speed."""
WORSE, MODEST = 1.25, 3.0
"""A speed error so many times as large as it need be, or stated so many times too large, matters ..."""
WORTH = 2e-3
"""... from this share of the speed on; `MODEST` times that where it is only stated too large."""
SILENT = 16.0
"""After a time between edges of so many usual ones nothing is known any more; missed edges make no such time."""
FORETOLD_PARTS = 64
"""Where there is no ripple, one fitted to the parts before foretells the next with a chance of 0.57 over this."""
FAR = 4.0
"""Deviations beyond which an edge is an outlier."""


class Noise(NamedTuple):
    """What a log is explained by: q [rad^2/s^3] of the acceleration, and R_2 [rad^2] of an edge's angle."""

    acceleration_density: float
    edge_variance: float


class Passage(NamedTuple):
    """From one edge to the next: time [s], angle [rad], the variance of the angle from sampling alone [rad^2], and
    whether a piece begins here (1, else 0)."""

    duration: float
    angle: float
    sampling_variance: float
    first: float


class PassageMemory(NamedTuple):
    """The belief at the last edge, its angle counted from where that edge lies; `seen` edges of the piece, up to 2."""

    belief: AngleSpeed
    seen: float


class Surprise(NamedTuple):
    """By how much an edge differed from what was expected [rad], and the variance of that; 0 where nothing was."""

    innovation: float
    variance: float


def passage_start() -> PassageMemory:
    """Memory before the first edge."""
    return PassageMemory(AngleSpeed(0.0, 0.0, 1.0, 0.0, 0.0), 0.0)


def passage_step(memory: PassageMemory, passage: Passage, noise: Noise) -> tuple[PassageMemory, Surprise]:
    """The constant-speed Kalman filter over one more edge.

    Nothing is known before the first two edges of a piece: they settle the belief and say nothing of the noise,
    P11 = R, P12 = R/h, P22 = (R + R_before)/h^2 + q h/3.

    Source  ours, docs/logs.md
    """
    h, q = passage.duration, noise.acceleration_density
    R = passage.sampling_variance + noise.edge_variance
    if passage.first > 0.0 or memory.seen == 0.0:
        return PassageMemory(AngleSpeed(0.0, 0.0, R, 0.0, 0.0), 1.0), Surprise(0.0, 0.0)
    if memory.seen == 1.0:
        P22 = (R + memory.belief.angle_variance) / (h * h) + q * h / 3.0
        return PassageMemory(AngleSpeed(0.0, passage.angle / h, R, R / h, P22), 2.0), Surprise(0.0, 0.0)
    prior = predict(memory.belief, h, q)
    innovation = passage.angle - prior.angle
    b = update(prior, innovation, R)
    after = AngleSpeed(b.angle - passage.angle, b.speed, b.angle_variance, b.covariance, b.speed_variance)
    return PassageMemory(after, 2.0), Surprise(innovation, prior.angle_variance + R)


def time_resolution(times: Array, share: float = 1.0) -> float:
    """The step in which times are written [s]: a power of ten where at least this `share` of them are whole multiples
    of it, else the distance of neighbouring double numbers."""
    largest = float(np.quantile(np.abs(times), share)) if times.size else 0.0
    spacing = float(np.spacing(max(largest, 1e-300)))
    for digits in range(10):
        step = 10.0**-digits
        if spacing > 1e-3 * step:
            break
        parts = times / step
        if np.mean(np.abs(parts - np.round(parts)) < 1e-6 + 2.0 * spacing / step) >= share:
            return step
    return spacing


class Fit(NamedTuple):
    """The likeliest settings, and what they are worth; where a value lies at its floor all below explain the log as
    well."""

    noise: Noise
    log_likelihood: float
    at_floor: tuple[bool, bool]
    edges: int


def _first_edges(passed: Passed) -> Chosen:
    """Whether nothing before an edge shows where it should be: a stop or a lost sensor is no noise, nor are edges that
    are numbered again after one."""
    steps = np.diff(passed.times)
    silent = (steps > SILENT * np.median(steps)) | (np.abs(np.diff(passed.numbers)) > SILENT)
    return np.concatenate([[True], (np.diff(passed.pieces) != 0.0) | silent])


class Likelihood:
    """The likelihood of the edges of a log under any settings."""

    def __init__(self, passed: Passed, sectors: int, say: Callable[[str], None] = quiet) -> None:
        self.passed, self.sectors = passed, sectors
        self._first = _first_edges(passed)
        self._durations = np.where(self._first, 0.0, np.diff(passed.times, prepend=passed.times[0]))
        self._replay = Replay(passage_step, passage_start(), Passage(0.0, 0.0, 0.0, 1.0), Noise(1.0, 1.0), say=say)
        self._rows = self._rows_of(passed.angles)
        self._learnt = 0.0
        self.period = float(np.median(self.steps))
        turned = np.diff(passed.angles, prepend=passed.angles[0])[~self._first]
        self.speed = abs(float(np.sum(turned) / np.sum(self.steps)))

    def _rows_of(self, angles: Array) -> Array:
        steps = np.where(self._first, 0.0, np.diff(angles, prepend=angles[0]))
        return np.column_stack([self._durations, steps, self.passed.sampling_variances, self._first])

    def surprises(self, noise: Noise, angles: Array | None = None) -> tuple[Array, Array]:
        """Innovations [rad] and their variances, of the edges that have them."""
        rows = self._rows if angles is None else self._rows_of(angles)
        shown = self._replay(passage_start(), rows, noise).shown
        told = shown[:, 1] > 0.0
        return shown[told, 0], shown[told, 1]

    def logarithm(self, noise: Noise) -> float:
        """ln L = -1/2 sum(ln(2 pi S) + nu^2/S)."""
        nu, S = self.surprises(noise)
        return -0.5 * float(np.sum(np.log(TURN * S) + nu * nu / S))

    @property
    def steps(self) -> Array:
        """Times between edges [s]."""
        found: Array = self._durations[~self._first]
        return found

    @property
    def steps_sampled(self) -> Array:
        """Of the edge at the end of each, the variance that is from sampling [rad^2]."""
        found: Array = self.passed.sampling_variances[~self._first]
        return found

    @cached_property
    def sampling_variance(self) -> float:
        """The part of an edge's variance that is from sampling [rad^2]."""
        return float(np.median(self.passed.sampling_variances))

    @property
    def variance_floor(self) -> float:
        """The edge variance below which nothing can be determined [rad^2]: (omega dt)^2/12 from the step in which
        the times are written, what the rounding of angles makes, the standard error sqrt(2/n) of the part from
        sampling, and what one edge shows that is as far off as those of a pattern that was taken off."""
        n = self.passed.times.size
        rounding = max(float(np.spacing(np.max(np.abs(self.passed.angles)))) ** 2, self._learnt)
        if self.sampling_variance > 0.0:
            return max(self.sampling_variance * float(np.sqrt(2.0 / n)), rounding)
        return max((self.speed * time_resolution(self.passed.times)) ** 2 / 12.0, rounding)

    def without(self, offsets: Array) -> "Likelihood":
        """The same edges on a wheel whose edges lie `offsets` [rad] further on; their count is the period."""
        moved = self.passed._replace(angles=self.passed.angles + offsets[self._places(offsets.size)])
        changed = object.__new__(Likelihood)
        changed.__dict__ |= self.__dict__
        changed.passed = moved
        changed._rows = changed._rows_of(moved.angles)
        changed._learnt = float(np.mean(offsets**2)) / (moved.times.size - offsets.size + 1)
        return changed

    def wheel_angles(self, period: int) -> Array:
        """Where on the wheel the edges lie that follow one another after `period` [rad]; evenly where none passed."""
        found: Array = np.array(np.arange(period) * (TURN / period), float)
        found[self._places(period)] = self.passed.angles
        return found

    def _places(self, period: int) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
        found: np.ndarray[tuple[int], np.dtype[np.int64]] = np.mod(self.passed.numbers, period).astype(np.int64)
        return found

    def white(self, noise: Noise, period: int) -> tuple[Array, Array]:
        """Innovations over their deviations [1], and by how much each of them grows with the place of each edge, after
        `period` the first again [1/rad]; one row for each edge that has an innovation."""
        return self._white(noise, (self._places(period)[:, None] == np.arange(period)).astype(float))

    def _white(self, noise: Noise, patterns: Array) -> tuple[Array, Array]:
        """The same for any patterns of the angles, shape (edges, m)."""
        nu, S = self.surprises(noise)
        root = np.sqrt(S)
        return nu / root, np.column_stack([self.surprises(noise, pattern)[0] / root for pattern in patterns.T])

    def offsets(self, noise: Noise, period: int) -> Array:
        """How much further on [rad] the edges lie that follow one another after `period`, mean of all zero.

        The filter is linear in the angles, so the innovations are those of the angles less the sum of the offsets times
        those of each edge's indicator: linear least squares of what the filter has made white.

        Source  ours, docs/logs.md
        """
        nu, responses = self.white(noise, period)
        found = np.linalg.lstsq(responses[:, :-1], -nu, rcond=1e-10)[0]
        every = np.append(found, 0.0)
        shifted: Array = every - np.mean(every)
        return shifted

    def ripple(self, noise: Noise, order: int) -> SpeedRipple:
        """The likeliest ripple of this order on the wheel as it is, by the same least squares."""
        nu, responses = self._white(noise, ripple_patterns(self.passed.angles, order))
        covariance = np.linalg.inv(responses.T @ responses)
        cosine, sine = (-covariance @ responses.T @ nu).tolist()
        return SpeedRipple(order, cosine, sine, float(np.sqrt(np.mean(np.diag(covariance)))))

    def foretold_gain(self, noise: Noise, order: int) -> float:
        """By which ln L of the edges of each part of the log is higher with the ripple of this order that the parts
        before it have, summed up: whether it foretells edges it was not fitted to.

        Source  dawid1984; docs/logs.md
        """
        z, patterns = self._white(noise, ripple_patterns(self.passed.angles, order))
        information, score, gain = np.zeros((2, 2)), np.zeros(2), 0.0
        for part in np.array_split(np.arange(z.size), FORETOLD_PARTS):
            told = z[part] - patterns[part] @ np.linalg.pinv(information, hermitian=True) @ score
            gain += 0.5 * float(np.sum(z[part] ** 2 - told**2))
            information, score = information + patterns[part].T @ patterns[part], score + patterns[part].T @ z[part]
        return gain


def fit(likelihood: Likelihood) -> Fit:
    """The settings under which the log is likeliest: a grid of decades, then a simplex.

    The search runs over ln R_2, above its floor, and ln(q T^3/R), with R the whole variance of an edge. That is n^-4 at
    least: the filter's time constant (R T/q)^(1/4) is then as long as n edges, and the speed constant as far as they
    show.

    Source  ours, docs/logs.md
    """
    from scipy.optimize import minimize

    n, pitch = likelihood.passed.times.size, TURN / likelihood.sectors
    low = np.log([n**-4.0, likelihood.variance_floor])
    high = np.log([FASTEST_CHANGE, max(pitch**2, 2.0 * likelihood.variance_floor)])

    def noise(place: Array) -> Noise:
        change, variance = np.exp(np.clip(place, low, high))
        return Noise(float(change * (variance + likelihood.sampling_variance) / likelihood.period**3), float(variance))

    def unlikely(place: Array) -> float:
        return -likelihood.logarithm(noise(place)) + float(np.sum((place - np.clip(place, low, high)) ** 2))

    decades = np.ceil((high - low) / np.log(10.0)).astype(int) + 1
    grid = [np.array([a, b]) for a in np.linspace(low[0], high[0], decades[0])
            for b in np.linspace(low[1], high[1], decades[1])]  # fmt: skip
    best = min(grid, key=unlikely)
    simplex = best + np.array([[0.0, 0.0], [1.2, 0.0], [0.0, 1.2]]) * np.where(best < 0.5 * (low + high), 1.0, -1.0)
    done = minimize(
        unlikely, best, method="Nelder-Mead", options={"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4}
    )
    place = np.clip(done.x, low, high)
    # Where the floor is as likely, it is a bound and no estimate.
    at_floor = tuple(
        bool(likelihood.logarithm(noise(np.where(np.arange(2) == i, low, place))) > -done.fun - 0.5) for i in range(2)
    )
    place = np.where(at_floor, low, place)
    found = noise(place)
    return Fit(found, likelihood.logarithm(found), at_floor, n)  # type: ignore[arg-type]


class Errors(NamedTuple):
    """Just after an edge, the deviation that the filter states, and the one that it has: of the speed [rad/s] and of
    the angle [rad]."""

    stated: float
    true: float
    angle_stated: float
    angle_true: float


def speed_errors(likelihood: Likelihood, taken: Noise, true: Noise) -> Errors:
    """How well a filter with settings `taken` knows the speed of a log whose noise is `true`, mean square over it.

    With the gain K of its own covariance: P = (I - K H')(F P F' + Q)(I - K H')' + K R K', Q and R the true ones.

    Source  ours, docs/logs.md
    """
    steps, sampled = likelihood.steps.tolist(), likelihood.steps_sampled.tolist()
    stated, real = (_after_two(steps[0], sampled[0] + n.edge_variance, n.acceleration_density) for n in (taken, true))
    sums, late = np.zeros(4), len(steps) // 4
    for k, (h, R) in enumerate(zip(steps, sampled, strict=True)):
        stated = predict(stated, h, taken.acceleration_density)
        b = predict(real, h, true.acceleration_density)
        R_taken, R_true = R + taken.edge_variance, R + true.edge_variance
        S = stated.angle_variance + R_taken
        k1, k2, left = stated.angle_variance / S, stated.covariance / S, R_taken / S
        P11, P12 = b.angle_variance, b.covariance
        real = AngleSpeed(
            0.0,
            0.0,
            left * left * P11 + k1 * k1 * R_true,
            left * (P12 - k2 * P11) + k1 * k2 * R_true,
            b.speed_variance + k2 * (k2 * P11 - 2.0 * P12) + k2 * k2 * R_true,
        )
        stated = update(stated, 0.0, R_taken)
        if k >= late:
            sums += (stated.speed_variance, real.speed_variance, stated.angle_variance, real.angle_variance)
    return Errors(*np.sqrt(sums / (len(steps) - late)).tolist())


def _after_two(h: float, R: float, q: float) -> AngleSpeed:
    """What two edges show."""
    return AngleSpeed(0.0, 0.0, R, R / h, 2.0 * R / (h * h) + q * h / 3.0)


@dataclass(frozen=True)
class Explained:
    """What a log is best explained by."""

    used: Noise
    advised: Noise
    """What to set: the fit, and what of the pattern the filter is not informed of as noise."""
    plain: Fit
    """The likeliest settings if the wheel is as it was described."""
    wheel: Fit | None
    """The same on a wheel whose edges lie where the log has them; None where that explains nothing more."""
    offsets: Array
    """By how much each edge of that wheel lies further on, less what the ripple makes of it [rad]."""
    ripple: SpeedRipple | None
    """Of the speed, locked to the turn; edges cannot distinguish it from a wheel with these offsets. None: none
    stands out.
    """
    candidates: tuple[Candidate, ...]
    """Ripples that the edges may show, if a pattern repeats with the turn: those that fit alike."""
    settings_gain: float
    """By which ln L is higher with the fitted settings than with those in use, on the same wheel."""
    used_errors: Errors
    fitted_errors: Errors
    lasting: float
    """Share of the squared innovations that lasts through the log [1]: fourth largest over mean of sixteen parts."""
    nis: float
    """Mean of the squared innovations over what the settings in use expect, on that wheel."""
    outliers: float
    """Share of the edges that lie beyond four deviations even with the likeliest settings; chance makes 6e-5 of it."""
    likelihood: Likelihood

    @property
    def fit(self) -> Fit:
        """The likeliest settings, on the wheel that the log speaks for."""
        return self.wheel if self.wheel is not None else self.plain

    @property
    def wheel_gain(self) -> float:
        """By which ln L is higher with the edges of the wheel where the log has them."""
        return self.wheel.log_likelihood - self.plain.log_likelihood if self.wheel is not None else 0.0

    @property
    def matters(self) -> bool:
        """Whether the fitted settings are clearly likelier, and either the edges scatter more than those in use say, or
        the speed could be known clearly better, or is known much better than they say."""
        if self.settings_gain < CLEAR:
            return False
        now, then, speed = self.used_errors, self.fitted_errors.true, self.likelihood.speed
        worse = now.true > WORSE * then and now.true > WORTH * speed
        modest = now.stated > MODEST * max(now.true, then) and now.stated > MODEST * WORTH * speed
        return self.nis > OPTIMISTIC or worse or modest

    @cached_property
    def even_share(self) -> float:
        """Share of the times between edges that are the median, or a whole multiple where samples are lost, as far as
        times are written."""
        steps, period = self.likelihood.steps, self.likelihood.period
        if not period > 0.0:
            return 0.0
        multiples = np.fmax(np.round(steps / period), 1.0)
        rounding = (1.5 + multiples) * time_resolution(
            self.likelihood.passed.times, EVEN
        )  # a time at each end, and the median
        return float(np.mean(np.abs(steps - multiples * period) <= rounding))

    @property
    def even_clock(self) -> bool:
        """Whether the times are evenly spaced but for damage to a few."""
        return self.even_share >= EVEN

    @cached_property
    def index_gain(self) -> float:
        """By which ln L is higher on the wheel as described than on one whose edges are all alike."""
        passed = self.likelihood.passed
        even = passed._replace(angles=passed.numbers * (TURN / self.likelihood.sectors))
        return self.plain.log_likelihood - fit(Likelihood(even, self.likelihood.sectors)).log_likelihood

    def period_gain(self, period: int) -> float:
        """By which ln L is higher if edges repeat after `period` instead, the price of its places taken off."""
        if self.likelihood.sectors % period == 0 or not _fit_statement(self.likelihood, period):
            return 0.0
        likelihood, plain = self.likelihood, self.plain
        refitted, _ = _fit_by_turns(likelihood, plain, lambda noise: likelihood.offsets(noise, period))
        return refitted.log_likelihood - plain.log_likelihood - _price(likelihood, period - 1)


def fitted_filter(settings: EventFilter, told: Explained) -> EventFilter:
    """The filter with what a log is best explained by; a manoeuvre is no calmer than the rest."""
    q, ripple = told.advised.acceleration_density, told.ripple
    found = replace(
        settings,
        acceleration_density=q,
        edge_variance=told.advised.edge_variance,
        manoeuvre_density=max(settings.manoeuvre_density, q),
    )
    if ripple is None:
        return found
    return replace(
        found,
        ripple_order=float(ripple.order),
        ripple_variance=0.5 * ripple.amplitude**2 + ripple.error**2,
        ripple_drift=careful_drift(ripple, told.advised.edge_variance, told.likelihood.period),
    )


def careful_drift(ripple: SpeedRipple, edge_variance: float, period: float) -> float:
    """The drift [1/s] with which a filter that meets an edge every `period` [s] knows a ripple as well as the log does.

    Of edges that show a part with r = 2 N^2 R, a walk of the drift P^2/(T (P + r)) is known to P just before each.

    edge_variance  R [rad^2]

    Source  ours, docs/logs.md
    """
    known, told = ripple.variance, 2.0 * ripple.order**2 * edge_variance
    return known**2 / (period * (known + told))


def fit_noise(
    passed: Passed, sectors: int, used: Noise, sections: int, say: Callable[[str], None] = quiet
) -> Explained:
    """What these edges of a wheel with `sectors` are best explained by: their settings, or what repeats with the turn,
    a ripple of the speed (of the spool's `sections`) or the places of the wheel's edges.

    Source  ours, docs/logs.md
    """
    likelihood = Likelihood(passed, sectors, say)
    plain = fit(likelihood)
    pattern = _find_pattern(likelihood, plain, sections)
    own = likelihood if pattern.wheel is None else likelihood.without(pattern.offsets)
    fitted = plain if pattern.wheel is None else pattern.wheel
    (nu, S), (mu, S_fitted) = own.surprises(used), own.surprises(fitted.noise)
    density = _careful_density(own, fitted, used) if fitted.at_floor[0] else fitted.noise.acceleration_density
    scatter = fitted.noise.edge_variance * passed.times.size / (passed.times.size - pattern.learnt)
    return Explained(
        used=used,
        advised=Noise(density, scatter + float(np.mean(pattern.own_offsets**2))),
        plain=plain,
        wheel=pattern.wheel,
        offsets=pattern.own_offsets,
        ripple=pattern.ripple,
        candidates=pattern.candidates,
        settings_gain=fitted.log_likelihood - own.logarithm(used),
        used_errors=speed_errors(own, used, fitted.noise),
        fitted_errors=speed_errors(own, Noise(density, fitted.noise.edge_variance), fitted.noise),
        lasting=_lasting_share(nu),
        nis=float(np.mean(nu * nu / S)),
        outliers=float(np.mean(mu * mu > FAR * FAR * S_fitted)),
        likelihood=likelihood,
    )


def _lasting_share(innovations: Array) -> float:
    """A step, which the filter's manoeuvres follow, makes large ones in one of sixteen parts, a speed that wanders in
    all."""
    squares = [float(np.mean(part * part)) for part in np.array_split(innovations, 16) if part.size]
    whole = float(np.mean(squares))
    return min(sorted(squares)[-min(4, len(squares))] / whole, 1.0) if whole > 0.0 else 1.0


class Pattern(NamedTuple):
    """What repeats with every turn: the fit without it, if it is real, where the edges seem to lie, of that the ripple
    and the offsets [rad] that are the wheel's own; `learnt` numbers say all that. The `candidates` are ripples that fit
    alike."""

    wheel: Fit | None
    offsets: Array
    ripple: SpeedRipple | None
    own_offsets: Array
    learnt: int
    candidates: tuple[Candidate, ...] = ()


def _find_pattern(likelihood: Likelihood, plain: Fit, sections: int) -> Pattern:
    """Offsets of all edges, less a ripple, where they are worth their price; else the spool's ripple if likely."""
    sectors, nothing = likelihood.sectors, np.zeros(likelihood.sectors)
    if not _fit_statement(likelihood, sectors):
        return Pattern(None, nothing, None, nothing, 0)
    angles = likelihood.wheel_angles(sectors)
    placed, offsets = _fit_by_turns(likelihood, plain, lambda noise: likelihood.offsets(noise, sectors))
    if placed.log_likelihood - plain.log_likelihood - _price(likelihood, sectors - 1) > CLEAR:
        ripple = ripple_in(offsets, angles, sections)
        alike = _candidates(likelihood, placed, offsets, sections if ripple is None else ripple.order)
        if ripple is not None and ripple.order not in [each.ripple.order for each in alike]:
            ripple = alike[0].ripple if alike else ripple  # it explains the edges clearly better
        left = offsets if ripple is None else offsets - ripple.offsets(angles)
        return Pattern(
            wheel=placed,
            offsets=offsets,
            ripple=ripple,
            own_offsets=left - np.mean(left),
            learnt=sectors - 1,
            candidates=alike,
        )
    if not is_whole(sections, sectors) or not is_likely(seen := likelihood.ripple(plain.noise, sections)):
        return Pattern(None, nothing, None, nothing, 0)
    if likelihood.foretold_gain(plain.noise, sections) > 0.0:
        placed, offsets = _fit_by_turns(
            likelihood, plain, lambda noise: likelihood.ripple(noise, sections).offsets(angles)
        )
        alike = _candidates(likelihood, placed, offsets, sections)
        return Pattern(
            wheel=placed,
            offsets=offsets,
            ripple=likelihood.ripple(placed.noise, sections),
            own_offsets=nothing,
            learnt=2,
            candidates=alike,
        )
    doubtful = (Candidate(seen, chance_of(seen)),)
    return Pattern(None, nothing, None, nothing, 0, candidates=doubtful)


def _candidates(likelihood: Likelihood, placed: Fit, offsets: Array, first: int) -> tuple[Candidate, ...]:
    """The ripples that may have made these offsets [rad]: those that fit as well as that of the order `first`."""
    seen = placed.noise.edge_variance + likelihood.sampling_variance
    scatter = seen * offsets.size / likelihood.passed.times.size
    return candidates(offsets, likelihood.wheel_angles(offsets.size), first, scatter)


def _careful_density(likelihood: Likelihood, fitted: Fit, used: Noise) -> float:
    """Where the speed was constant as far as the log shows, the largest q, not above the one in use, that costs no
    speed error worth a word: it will not always be, and a filter that is sure of its speed goes on through a stop."""
    q, R = fitted.noise
    density = used.acceleration_density
    while density > q:
        if speed_errors(likelihood, Noise(density, R), fitted.noise).true < 0.5 * WORTH * likelihood.speed:
            return density
        density *= 0.1
    return q


def _fit_statement(likelihood: Likelihood, period: int) -> bool:
    return 2 <= period <= MOST_PLACES and likelihood.passed.times.size >= TURNS_OF_A_WHEEL * period


def _price(likelihood: Likelihood, numbers: int) -> float:
    """What so many numbers that were fitted cost in ln L: half of them times ln n, after Schwarz."""
    return 0.5 * numbers * float(np.log(likelihood.passed.times.size))


def _fit_by_turns(likelihood: Likelihood, plain: Fit, pattern: Callable[[Noise], Array]) -> tuple[Fit, Array]:
    """The likeliest settings where the edges lie as the log has them, and the offsets that the `pattern` makes of the
    noise [rad]; settings and offsets by turns."""
    found, offsets = plain, np.zeros(1)
    for _ in range(3):
        offsets = pattern(found.noise)
        before, found = found, fit(likelihood.without(offsets))
        if found.log_likelihood < before.log_likelihood + 0.5:
            break
    return found, offsets
