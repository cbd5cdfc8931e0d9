"""How the shaft really turns, in closed form."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import RATIO, SPEED, TIME
from vvdp.base.rules import require_positive_value


class Motion(Protocol):
    """A shaft that turns; times in s."""

    @property
    def by_flow(self) -> "Lag":
        """Motion that the flow alone would cause."""
        ...

    @property
    def step(self) -> "Lag | None":
        """Itself where the speed goes over from one value to another, and stays there."""
        ...

    def speed(self, time: Array) -> Array:
        """Speed at `time` [rad/s], below 0 backwards."""
        ...

    def angle(self, time: Array) -> Array:
        """Angle since time 0 [rad], the exact integral of the speed."""
        ...

    def travel(self, time: Array) -> Array:
        """Angle turned through since time 0, whichever way [rad]."""
        ...


@dataclass(frozen=True)
class Lag:
    """A shaft that turns at the speed `before` and from `change_at` on approaches `after` as a first-order lag does.

    Speeds in rad/s, not below 0, times in s. Raises ParameterError where `time_constant` is not above zero.
    """

    before: float
    after: float
    change_at: float
    time_constant: float

    def __post_init__(self) -> None:
        require_positive_value("time constant", self.time_constant, TIME)

    @property
    def by_flow(self) -> "Lag":
        """Itself: the flow makes all of it."""
        return self

    @property
    def step(self) -> "Lag | None":
        """Itself, unless the speed is the same all the time."""
        return self if self.before != self.after else None

    def speed(self, time: Array) -> Array:
        """Speed at `time` [rad/s]: after + (before - after) exp(-(t - change_at) / time_constant).

        Source  ours, docs/comparison.md
        """
        gone = np.clip(time - self.change_at, 0.0, None)
        return self.after + (self.before - self.after) * np.exp(-gone / self.time_constant)

    def acceleration(self, time: Array) -> Array:
        """Rate of the speed at `time` [rad/s^2].

        Source  ours, docs/comparison.md
        """
        late = time >= self.change_at
        return np.where(late, (self.after - self.speed(time)) / self.time_constant, 0.0)

    def angle(self, time: Array) -> Array:
        """Angle since time 0 [rad], the exact integral of the speed.

        Source  ours, docs/comparison.md
        """
        gone = np.clip(time - self.change_at, 0.0, None)
        lagged = self.time_constant * -np.expm1(-gone / self.time_constant)
        steady = self.before * (time - gone) + self.after * gone
        return steady + (self.before - self.after) * lagged

    def travel(self, time: Array) -> Array:
        """Angle turned through since time 0 [rad]: the angle, as it never turns back."""
        return self.angle(time)


@dataclass(frozen=True)
class Ripple:
    """A shaft whose speed swings with its angle, by a `share` to either side and `per_turn` times a turn.

    With x = per_turn theta the speed is mean (1 + share cos x)/sqrt(1 - share^2), whose mean over time is `mean`
    [rad/s]. Raises ParameterError where the share is not from 0 to below 1, or mean or `per_turn` not above zero.
    """

    mean: float
    share: float
    per_turn: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.share < 1.0:
            raise ParameterError(f"share of the ripple: {self.share:g} must be at least 0 and less than 1")
        require_positive_value("mean speed", self.mean, SPEED)
        require_positive_value("periods per revolution", self.per_turn, RATIO)

    @property
    def by_flow(self) -> Lag:
        """The mean: a flow meter does not see the ripple."""
        return steady(self.mean)

    @property
    def step(self) -> None:
        """None: it swings indefinitely."""

    def speed(self, time: Array) -> Array:
        """Speed at `time` [rad/s].

        Source  ours, docs/comparison.md
        """
        swing = 1.0 + self.share * np.cos(self.per_turn * self.angle(time))
        found: Array = self.mean / np.sqrt(1.0 - self.share**2) * swing
        return found

    def angle(self, time: Array) -> Array:
        """Angle since time 0 [rad]: tan(x/2) = k tan s, s = per_turn mean t/2, k^2 = (1 + share)/(1 - share).

        Source  ours, docs/comparison.md
        """
        k = np.sqrt((1.0 + self.share) / (1.0 - self.share))
        s = 0.5 * self.per_turn * self.mean * time
        sine, cosine = np.sin(s), np.cos(s)
        ahead = np.arctan2((k - 1.0) * sine * cosine, cosine * cosine + k * sine * sine)
        found: Array = 2.0 * (s + ahead) / self.per_turn
        return found

    def travel(self, time: Array) -> Array:
        """Angle turned through since time 0 [rad]: the angle, as it never turns back."""
        return self.angle(time)


@dataclass(frozen=True)
class Ramps:
    """A shaft whose speed goes in straight lines through `speeds` [rad/s] at `times` [s], and stays before and after.

    The flow goes on as at first: something else stops the shaft, or turns it back. Raises ParameterError where the
    times do not begin at 0 and increase.
    """

    times: tuple[float, ...]
    speeds: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.times) != len(self.speeds) or self.times[:1] != (0.0,) or not all(np.diff(self.times) > 0.0):
            raise ParameterError(
                f"speeds {self.speeds} rad/s at {self.times} s; expected as many times, from 0 on and increasing"
            )

    @property
    def by_flow(self) -> Lag:
        """The speed at first, indefinitely."""
        return steady(self.speeds[0])

    @property
    def step(self) -> None:
        """None: what stops or turns back is no step of the flow."""

    def speed(self, time: Array) -> Array:
        """Speed at `time` [rad/s]."""
        return np.interp(time, self.times, self.speeds)

    def angle(self, time: Array) -> Array:
        """Angle since time 0 [rad], the exact integral of the speed: a mean speed over each part of a line."""
        t, w = np.array(self.times), np.array(self.speeds)
        passed = np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(t))])
        line = np.clip(np.searchsorted(t, time, side="right") - 1, 0, t.size - 1)
        found: Array = passed[line] + 0.5 * (w[line] + self.speed(time)) * (time - t[line])
        return found

    def travel(self, time: Array) -> Array:
        """Angle turned through since time 0, whichever way [rad]."""
        t, w = np.array(self.times), np.array(self.speeds)
        back = np.flatnonzero(w[1:] * w[:-1] < 0.0)
        turns = t[back] + (t[back + 1] - t[back]) * w[back] / (w[back] - w[back + 1])
        order = np.argsort(np.concatenate([t, turns]))
        every, speeds = np.concatenate([t, turns])[order], np.concatenate([np.abs(w), 0.0 * turns])[order]
        return Ramps(tuple(every.tolist()), tuple(speeds.tolist())).angle(time)


def steady(speed: float) -> Lag:
    """A shaft that turns at `speed` [rad/s] indefinitely."""
    return Lag(speed, speed, 0.0, 1.0)
