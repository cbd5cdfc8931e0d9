"""How long and how finely a run is stepped and recorded."""

from enum import Enum

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Ratio, Time
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive


class Method(Enum):
    """How a run is stepped; the values are those of the compiled loop."""

    AUTOMATIC = 0
    EXPLICIT = 1
    STIFF = 2


class Stepping(Params):
    """How long and how finely a run is stepped and recorded.

    The whole run is recorded every `record_interval`, its last `window` every `window_interval` as well. Conditions,
    and programs without a period of their own, are calculated every `sample_period`. Means are taken from
    `average_from` on, with None not at all.
    """

    until: Time
    begin: Time = 0.0
    average_from: Time | None = None
    relative_tolerance: Ratio = 1e-6
    sample_period: Time = 1e-3
    longest_step: Time = 1e6
    record_interval: Time = 1e-3
    window: Time = 0.25
    window_interval: Time = 2e-5
    method: Method = Method.AUTOMATIC

    def check(self) -> None:
        require_positive(self, "until", "sample_period", "longest_step", "record_interval", "window_interval")
        if not self.until > self.begin:
            refuse(self, "until", f"must be greater than begin, {field_text(self, 'begin')}")
        if not 1e-13 <= self.relative_tolerance <= 1e-2:
            raise ParameterError(f"relative_tolerance = {self.relative_tolerance:g}; expected 1e-13 to 0.01")
        lasts = self.until - self.begin
        rows = lasts / self.record_interval + min(self.window, lasts) / self.window_interval
        if rows > 2e7:
            raise ParameterError(f"{rows:.3g} rows to record; at most 2e7: record less often or in a shorter window")

    @property
    def record_times(self) -> Array:
        """All times [s] at which the state is recorded, increasing."""
        first = int(np.ceil(self.begin / self.record_interval - 1e-9))
        coarse = np.arange(first, round(self.until / self.record_interval) + 1) * self.record_interval
        begin = max(self.begin, self.until - self.window)
        fine = begin + np.arange(round((self.until - begin) / self.window_interval) + 1) * self.window_interval
        both = np.union1d(coarse.clip(min=self.begin), np.append(fine, self.begin))
        both = both[np.concatenate([[True], np.diff(both) > 1e-3 * self.window_interval])]
        inside: Array = both[both <= self.until * (1 + 1e-12)].clip(max=self.until)
        return inside

    def means_from(self, end: float) -> float:
        """When means of a run to `end` [s] begin: at a sample near its middle where it ends before `average_from`."""
        if self.average_from is None:
            return self.begin
        if self.average_from < end:
            return max(self.begin, self.average_from)
        middle = 0.5 * (self.begin + end)
        sample = round(middle / self.sample_period) * self.sample_period
        return sample if self.begin <= sample < end else middle

    @property
    def span_times(self) -> Array:
        """When means begin, and three spans of equal length up to the end [s], shape (4,); empty where none are wanted.

        Steps end there. The spans are whole sample periods, at whose ends steps end anyway, where there are as many.
        """
        if self.average_from is None:
            return np.zeros(0)
        first = self.means_from(self.until)
        third = (self.until - first) / 3.0
        third = self.sample_period * np.floor(third / self.sample_period * (1.0 + 1e-9)) or third
        times: Array = np.array([first, *(self.until - third * np.arange(3.0, 0.0, -1.0))]).clip(min=first)
        samples = np.round(times / self.sample_period) * self.sample_period
        return np.where(np.abs(times - samples) < 1e-9 * self.sample_period, samples, times)
