"""What a log is best explained by: how fast its speed wanders, by how much its edges scatter, and what repeats with
every turn. Derived in docs/logs.md.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.event_settings import EventFilter
from vvdp.offline.likelihood import Errors, Fit, Likelihood, fit, speed_errors, time_resolution
from vvdp.offline.passage import FAR, Noise
from vvdp.offline.passed_edges import Passed
from vvdp.offline.pattern_fit import CLEAR, find_pattern, fit_by_turns, has_turns, likeliest_offsets, price
from vvdp.offline.turn_pattern import Candidate, SpeedRipple
from vvdp.sensing.wheel import TURN
from vvdp.simulation.link import quiet

EVEN = 0.9
"""Share of the times between edges that a clock has in common, whatever is damaged; edges of a spool share none."""
OPTIMISTIC = 1.3
"""Squared innovations so much larger than expected matter, whatever the speed."""
WORSE, MODEST = 1.25, 3.0
"""A speed error so many times as large as it need be, or stated so many times too large, matters ..."""
WORTH = 2e-3
"""... from this share of the speed on; `MODEST` times that where it is only stated too large."""
ROUNDS = 3
"""Sudden changes of the speed are looked for so often; each time the noise is known better."""


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
    fit: Fit
    """The likeliest settings on the wheel that the log speaks for, sudden changes of the speed left out."""
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
    nis: float
    """Mean of the squared innovations over what the settings in use expect, on that wheel."""
    outliers: float
    """Share of the edges that lie beyond four deviations, or at which the speed changes suddenly, even with the
    likeliest settings; chance makes 6e-5 of it."""
    likelihood: Likelihood

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
        if self.likelihood.sectors % period == 0 or not has_turns(self.likelihood, period):
            return 0.0
        likelihood, plain = self.likelihood, self.plain
        refitted, _ = fit_by_turns(likelihood, plain, lambda noise: likeliest_offsets(likelihood, noise, period))
        return refitted.log_likelihood - plain.log_likelihood - price(likelihood, period - 1)


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
    pattern = find_pattern(likelihood, plain, sections)
    own = likelihood if pattern.wheel is None else likelihood.without(pattern.offsets)
    fitted = plain if pattern.wheel is None else pattern.wheel
    own, fitted = _without_events(own, fitted)
    (nu, S), (mu, S_fitted) = own.surprises(used), own.surprises(fitted.noise)
    density = _careful_density(own, fitted, used) if fitted.at_floor[0] else fitted.noise.acceleration_density
    scatter = fitted.noise.edge_variance * passed.times.size / (passed.times.size - pattern.learnt)
    return Explained(
        used=used,
        advised=Noise(density, scatter + float(np.mean(pattern.own_offsets**2))),
        plain=plain,
        wheel=pattern.wheel,
        fit=fitted,
        offsets=pattern.own_offsets,
        ripple=pattern.ripple,
        candidates=pattern.candidates,
        settings_gain=fitted.log_likelihood - own.logarithm(used),
        used_errors=speed_errors(own, used, fitted.noise),
        fitted_errors=speed_errors(own, Noise(density, fitted.noise.edge_variance), fitted.noise),
        nis=float(np.mean(nu * nu / S)),
        outliers=float(np.sum(mu * mu > FAR * FAR * S_fitted) + own.pieces - likelihood.pieces) / passed.times.size,
        likelihood=likelihood,
    )


def _without_events(likelihood: Likelihood, found: Fit) -> tuple[Likelihood, Fit]:
    """The log without its sudden changes of the speed, and the likeliest settings there: a single step is no noise that
    lasts."""
    for _ in range(ROUNDS):
        calm = likelihood.without_events(found.noise)
        if calm is None:
            break
        likelihood, found = calm, fit(calm)
    return likelihood, found


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
