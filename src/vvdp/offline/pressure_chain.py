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
from vvdp.offline.offline_filter import OfflineFilter, Waves, no_waves
from vvdp.offline.record_check import Inspection
from vvdp.offline.sums import Sums
from vvdp.offline.writer import Writer
from vvdp.sensing.wheel import TURN
from vvdp.simulation.replay import Replay

LONGEST = 4_000_000
"""Samples, and rows, that wait for each other at most."""


@dataclass
class _Waiting:
    """Samples that the rows have not reached."""

    times: Array = field(default_factory=lambda: np.empty(0))
    values: Array = field(default_factory=lambda: np.empty(0))
    folded: int = 0
    """1 where the first of these was folded already; rows before the next sample lie between the two."""

    def add(self, times: Array, values: Array) -> None:
        self.times, self.values = np.concatenate([self.times, times]), np.concatenate([self.values, values])
        if self.values.size > LONGEST:
            self.times, self.values, self.folded = self.times[-LONGEST:], self.values[-LONGEST:], 0

    def drop(self, ready: int) -> None:
        """Forgets the first samples, but the last of them."""
        self.times, self.values, self.folded = self.times[ready - 1 :], self.values[ready - 1 :], 1


class PressureChain:
    """The inlet pressure of a record on its way."""

    def __init__(
        self, wanted: InletPressure, pascals: Conversion, sections: int, sums: Sums, say: Callable[[str], None]
    ) -> None:
        self._wanted, self._pascals, self._sections, self._sums = wanted, pascals, sections, sums
        start, sample = pressure_edges_start(0.0, 0.0), PressureSample(0.0, 0.0)
        self._replay = Replay(pressure_edges_step, start, sample, wanted.edges, say=say)
        self._clock, self._own_clock, self._last_time = 0, 0, -np.inf  # how often the time went back: there, and here
        self._record = Inspection(wanted.channel)
        self._later: list[tuple[int, Array, Array]] = []  # stretches on clocks that the edges have not reached yet
        self.restart()

    def restart(self) -> None:
        """Forgets what came before: the time went back."""
        self._memory: PressureEdgesMemory | None = None
        self._rise_angle, self.waves, self.waiting = np.nan, no_waves(), _Waiting()

    def push(self, portion: Portion, inside: Chosen, tracker: OfflineFilter | None) -> None:
        """Takes samples in; fused, a filter is told of the edges among them."""
        self._record.pieces(Portion(portion.times[inside], portion.values[inside]))
        self._sums.pressure_record = self._record.findings()
        sound = (np.abs(portion.values) < LARGEST) & inside
        times, values = portion.times[sound], self._pascals(portion.values[sound])
        if not times.size:
            return
        back = np.flatnonzero(np.diff(np.concatenate([[self._last_time], times])) < 0.0)
        self._last_time = float(times[-1])
        for i, (first, last) in enumerate(zip([0, *back], [*back, times.size], strict=True)):
            self._own_clock += 1 if i else 0
            if last > first:
                self._later.append((self._own_clock, times[first:last], values[first:last]))
        self._take_up(tracker)

    def next_clock(self, tracker: OfflineFilter | None) -> None:
        """The time of the edges went back; so did that of the pressure, or it will."""
        self.restart()
        self._clock += 1
        self._take_up(tracker)

    def _take_up(self, tracker: OfflineFilter | None) -> None:
        for clock, times, values in self._later:
            if clock == self._clock:
                self._take(times, values, tracker)
        self._later = [each for each in self._later if each[0] > self._clock]

    def _take(self, times: Array, values: Array, tracker: OfflineFilter | None) -> None:
        """Pressures [Pa] on the clock that the edges are on."""
        if self._memory is None:
            self._memory = pressure_edges_start(float(times[0]), float(values[0]))
        self.waiting.add(times, values)
        done = self._replay(self._memory, np.column_stack([times, values]))
        self._memory = done.memory
        columns = dict(zip(self._replay.columns, done.shown.T, strict=True))
        at = np.flatnonzero(columns["pressure_edges"] > 0.0)
        names = ("time", "pressure_edge_time", "pressure_edge_interval", "pressure_polarity")
        found = Waves(*(columns[name][at] for name in names))
        self.waves = Waves(*(np.concatenate(both) for both in zip(self.waves, found, strict=True)))
        if self._wanted.fused and tracker is not None:
            tracker.add_pressure_edges(found)

    def meet(self, writer: Writer, *, last: bool = False) -> None:
        """Gives the rows their pressure, folds it over the angle and takes its duty ratio, as far as both are known;
        `last`: no more of it comes on this clock."""
        if writer.rows is None:
            return
        writer.give_pressure(self.waiting.times, self.waiting.values, LONGEST, last=last)
        row_times, angles = writer.rows
        self._fold(row_times, angles)
        begin = max(0, row_times.size - LONGEST)
        if self.waiting.times.size:
            begin = max(begin, int(np.searchsorted(row_times, self.waiting.times[0])) - 1)
        writer.forget_rows(begin)

    def _fold(self, row_times: Array, angles: Array) -> None:
        until, waiting = float(row_times[-1]), self.waiting
        ready = int(np.searchsorted(waiting.times, until, side="right"))
        if ready <= waiting.folded:
            return
        times, values = waiting.times[waiting.folded : ready], waiting.values[waiting.folded : ready]
        angle = np.interp(times, row_times, angles)
        self._sums.pressures(values, np.where(times >= row_times[0], np.mod(angle, TURN), np.nan))
        heard = int(np.searchsorted(self.waves.known, until, side="right"))
        edge_angles = np.interp(self.waves.times[:heard], row_times, angles, left=np.nan)
        self._duty(edge_angles, self.waves.polarities[:heard] > 0.0)
        self.waves = Waves(*(column[heard:] for column in self.waves))
        waiting.drop(ready)

    def _duty(self, angles: Array, rising: Chosen) -> None:
        """Takes in each pulse: the angles of a rising edge and of the falling one that follows it."""
        rises = np.concatenate([[self._rise_angle], np.where(rising, angles, np.nan)])  # NaN after a falling edge
        shares = (np.abs(angles - rises[:-1]) * (self._sections / TURN))[~rising]
        self._sums.duties(shares[(shares > 0.0) & (shares < 1.0)] - self._wanted.duty_excess)
        self._rise_angle = float(rises[-1])
