"""How the shaft really turns, in closed form."""

from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError


@dataclass(frozen=True)
class Motion:
    """A shaft that turns at the speed `before` and from `change_at` on approaches `after` as a first-order lag does.

    Speeds in rad/s, times in s. Raises ParameterError where `time_constant` is not above zero.
    """

    before: float
    after: float
    change_at: float
    time_constant: float

    def __post_init__(self) -> None:
        if not self.time_constant > 0.0:
            raise ParameterError(f"a time constant of {self.time_constant:g} s; expected more than zero")

    @property
    def changes(self) -> bool:
        """Whether the speed is not the same all the time."""
        return self.before != self.after

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
        """Angle turned through since time 0 [rad], the exact integral of the speed.

        Source  ours, docs/comparison.md
        """
        gone = np.clip(time - self.change_at, 0.0, None)
        lagged = self.time_constant * -np.expm1(-gone / self.time_constant)
        steady = self.before * (time - gone) + self.after * gone
        return steady + (self.before - self.after) * lagged


def steady(speed: float) -> Motion:
    """A shaft that turns at `speed` [rad/s] for ever."""
    return Motion(speed, speed, 0.0, 1.0)
