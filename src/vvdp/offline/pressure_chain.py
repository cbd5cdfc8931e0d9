"""The second chain of an estimation: the inlet pressure, its edges, its fold over a turn, and the duty ratio.

It comes on a clock of its own, ahead of the rows or behind them; what the edges have not reached yet waits.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.pressure_edges import (
    PressureEdgesMemory,
    PressureSample,
    pressure_edges_start,
    pressure_edges_step,
)
from vvdp.logs.channel import Portion
from vvdp.logs.quantity import Conversion
from vvdp.offline.clock import LARGEST
from vvdp.offline.config import InletPressure
from vvdp.offline.edges import Chosen
from vvdp.offline.estimate_result import Store
from vvdp.offline.offline_filter import OfflineFilter, Waves, no_waves
from vvdp.offline.record_check import Inspection
from vvdp.offline.sums import Tally
from vvdp.sensing.wheel import TURN
from vvdp.simulation.replay import Replay

WAVE_COLUMNS = ("time", "pressure_edge_time", "pressure_edge_interval", "pressure_polarity")
LONGEST = 4_000_000
"""Samples, and rows, that wait for each other at most."""


@dataclass
class Waiting:
    """Samples that the rows have not reached."""

    times: Array = field(default_factory=lambda: np.empty(0))
    values: Array = field(default_factory=lambda: np.empty(0))
    folded: int = 0
    """1 where the first of these was folded already; rows before the next sample lie between the two."""

    def add(self, times: Array, values: Array) -> None:
        """Takes in samples."""
        self.times, self.values = np.concatenate([self.times, times]), np.concatenate([self.values, values])
        if self.values.size > LONGEST:
            self.times, self.values, self.folded = self.times[-LONGEST:], self.values[-LONGEST:], 0

    def at(self, times: Array) -> Array:
        """Values at other times [s]; NaN before the first and after the last of them."""
        known = np.interp(times, self.times, self.values, left=np.nan, right=np.nan) if self.times.size else np.nan
        return np.broadcast_to(known, times.shape)

    def drop(self, ready: int) -> None:
        """Forgets the first samples, but the last of them."""
        self.times, self.values, self.folded = self.times[ready - 1 :], self.values[ready - 1 :], 1


@dataclass
class Clocks:
    """Stretches of samples, each on a clock of its own, until the edges have reached that: `current`."""

    current: int = 0
    _own: int = 0
    _last: float = -np.inf
    _later: list[tuple[int, Array, Array]] = field(default_factory=list)

    def add(self, times: Array, values: Array) -> None:
        """Takes in samples; where their time goes back the next clock begins."""
        back = np.flatnonzero(np.diff(times, prepend=self._last) < 0.0).tolist()
        for i, (first, last) in enumerate(zip([0, *back], [*back, times.size], strict=True)):
            self._own += 1 if i else 0
            if last > first:
                self._later.append((self._own, times[first:last], values[first:last]))
                self._last = float(times[last - 1])

    def take(self) -> list[tuple[Array, Array]]:
        """The samples on the clock that the edges are on."""
        found = [(times, values) for clock, times, values in self._later if clock == self.current]
        self._later = [each for each in self._later if each[0] > self.current]
        return found


class PressureChain:
    """The inlet pressure of a record on its way, and the rows that it receives."""

    def __init__(
        self,
        wanted: InletPressure,
        pascals: Conversion,
        sections: int,
        tally: Tally,
        store: Store,
        say: Callable[[str], None],
    ) -> None:
        self._wanted, self._pascals, self._sections, self._tally, self._store = wanted, pascals, sections, tally, store
        start, sample = pressure_edges_start(0.0, 0.0), PressureSample(0.0, 0.0)
        self._replay = Replay(pressure_edges_step, start, sample, wanted.edges, say=say)
        self._columns = [self._replay.columns.index(name) for name in ("pressure_edges", *WAVE_COLUMNS)]
        self._record, self._clocks = Inspection(wanted.channel), Clocks()
        self._tracker: OfflineFilter | None = None
        self._restart()

    def _restart(self) -> None:
        """Forgets what came before: the time went back."""
        self._memory: PressureEdgesMemory | None = None
        self._rise_angle, self.waves, self.waiting = np.nan, no_waves(), Waiting()
        self.row_times, self._row_angles, self._bare = np.empty(0), np.empty(0), 0  # of the last rows some lack theirs

    def tell(self, tracker: OfflineFilter) -> None:
        """Gives a filter the edges of the pressure, from the first one on."""
        self._tracker = tracker
        tracker.add_pressure_edges(self.waves)

    def add_rows(self, times: Array, angles: Array) -> None:
        """Rows that wait for their pressure."""
        self.row_times = np.concatenate([self.row_times, times])
        self._row_angles = np.concatenate([self._row_angles, angles])
        self._bare += times.size

    def push(self, portion: Portion, inside: Chosen) -> None:
        """Takes samples in."""
        self._record.pieces(Portion(portion.times[inside], portion.values[inside]))
        self._tally.pressure_record = self._record.findings()
        sound = (np.abs(portion.values) < LARGEST) & inside
        self._clocks.add(portion.times[sound], self._pascals(portion.values[sound]))
        self._take()

    def next_clock(self) -> None:
        """The time of the edges went back; so did that of the pressure, or it will."""
        self._restart()
        self._clocks.current += 1
        self._take()

    def _take(self) -> None:
        """Pressures [Pa] on the clock that the edges are on."""
        for times, values in self._clocks.take():
            if self._memory is None:
                self._memory = pressure_edges_start(float(times[0]), float(values[0]))
            self.waiting.add(times, values)
            self._memory, shown = self._replay(self._memory, np.column_stack([times, values]))
            found = Waves(*shown[shown[:, self._columns[0]] > 0.0][:, self._columns[1:]].T)
            self.waves = Waves(*(np.concatenate(both) for both in zip(self.waves, found, strict=True)))
            if self._tracker is not None:
                self._tracker.add_pressure_edges(found)

    def meet(self, *, last: bool = False) -> None:
        """Gives the rows their pressure, folds it over the angle and takes its duty ratio, as far as both are known;
        `last`: no more of it comes on this clock."""
        if not self.row_times.size:
            return
        self._give(last=last)
        self._fold()
        begin = max(0, self.row_times.size - LONGEST)
        if self.waiting.times.size:
            begin = max(begin, int(np.searchsorted(self.row_times, self.waiting.times[0])) - 1)
        self.row_times, self._row_angles = self.row_times[begin:], self._row_angles[begin:]

    def _give(self, *, last: bool) -> None:
        """Writes the pressure of the rows up to its newest sample; of all rows, if it is the `last`. No more than the
        `LONGEST` of them wait on."""
        times, total = self.waiting.times, self.row_times.size
        begin = total - self._bare
        end = int(np.searchsorted(self.row_times, times[-1], side="right")) if times.size else 0
        end = total if last else max(begin, end, total - LONGEST)
        self._store.append("", {"inlet_pressure": self.waiting.at(self.row_times[begin:end])})
        self._bare -= end - begin

    def _fold(self) -> None:
        row_times, waiting, until = self.row_times, self.waiting, float(self.row_times[-1])
        ready = int(np.searchsorted(waiting.times, until, side="right"))
        if ready <= waiting.folded:
            return
        times, values = waiting.times[waiting.folded : ready], waiting.values[waiting.folded : ready]
        angle = np.interp(times, row_times, self._row_angles)
        self._tally.pressure.add(values)
        self._tally.fold.add(values, np.where(times >= row_times[0], np.mod(angle, TURN), np.nan))
        heard = int(np.searchsorted(self.waves.known, until, side="right"))
        edge_angles = np.interp(self.waves.times[:heard], row_times, self._row_angles, left=np.nan)
        rising = self.waves.polarities[:heard] > 0.0
        shares, self._rise_angle = pulse_shares(edge_angles, rising, self._rise_angle, self._sections)
        self._tally.duty_ratio.add(shares - self._wanted.duty_excess)
        self.waves = Waves(*(column[heard:] for column in self.waves))
        waiting.drop(ready)


def pulse_shares(angles: Array, rising: Chosen, rise_angle: float, sections: int) -> tuple[Array, float]:
    """Which share of a PWM period each pulse takes, from the angles [rad] of a rising edge and of the falling one that
    follows it; `rise_angle` is that of the last edge before, and given back that of the last one, NaN if it falls."""
    rises = np.concatenate([[rise_angle], np.where(rising, angles, np.nan)])
    shares = (np.abs(angles - rises[:-1]) * (sections / TURN))[~rising]
    return shares[(shares > 0.0) & (shares < 1.0)], float(rises[-1])
