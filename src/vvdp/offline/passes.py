"""One pass over a log: clock, edges, debounce, filter, writer, and the chain of the inlet pressure beside them."""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.logs.channel import Log, Portion
from vvdp.logs.clock import ClockChoice, seconds
from vvdp.logs.quantity import Conversion, to_si
from vvdp.offline.beginning import Beginning
from vvdp.offline.charts import Excerpt
from vvdp.offline.clock import USUAL_RATE, RecordClock
from vvdp.offline.config import Counts, Estimation, InletPressure, Stamps, Wave, source_channels
from vvdp.offline.edges import CountEdges, Debounce, Edges, StampEdges, WaveEdges, join, no_edges, part
from vvdp.offline.estimate_result import EDGES, FUSED_ROWS, PRESSURE_ROW, ROWS, Store
from vvdp.offline.interrupt import Stopped, catch_interrupt
from vvdp.offline.offline_filter import FilteredRows, OfflineFilter, filter_of
from vvdp.offline.pressure_chain import PressureChain, Waiting
from vvdp.offline.sums import Tally
from vvdp.sensing.wheel import TURN, sector_widths

SAMPLES_AT_ONCE = 1_000_000
SAMPLES_AT_FIRST = 100_000
"""Where only the first edges are wanted."""
REMEMBERED = 1_000_000
"""Rows that wait for the pressure; beyond, it is taken in before the portion ends."""
EXCERPT_TURNS = 3
LARGEST_EXCERPT = 20_000


def pascals(log: Log, pressure: InletPressure) -> Conversion:
    """How the channel of the pressure becomes Pa. Raises ConfigError where its unit is none of a pressure."""
    channel = log.channel(pressure.channel)
    if not (channel.unit or pressure.unit):
        words = 'has no unit; name it in [pressure] unit, for example "bar"'
        raise ConfigError([Fault(str(log.path), 0, channel.name, words)])
    return to_si(log.path, channel, PRESSURE_LEVEL, pressure.unit or None)


class Settled(NamedTuple):
    """Edges that no later one changes, `last` where nothing follows on their clock; the stretch of samples that settled
    them, and the edges `found` in it."""

    edges: Edges
    last: bool = False
    stretch: Portion | None = None
    found: Edges | None = None


class EdgeFinder:
    """The first three stages: what a portion holds becomes edges that are settled, clock by clock."""

    def __init__(self, log: Log, wanted: Estimation, tally: Tally) -> None:
        self._wanted, self.tally = wanted, tally
        self.clock = RecordClock(log.path, wanted, tally)
        match wanted.source:
            case Wave(comparator=comparator):
                tally.finder = WaveEdges(comparator)
            case Counts():
                tally.finder = CountEdges()
            case Stamps(falling=falling):
                tally.finder = StampEdges(bool(falling), tally.tick)
        narrowest = min(sector_widths(wanted.wheel)) * len(wanted.wheel.edges) / TURN
        self.debounce = Debounce(shortest=min(0.15, 0.4 * narrowest))
        self._units = _units_of_stamps(log, wanted)

    def push(self, portion: Mapping[str, Portion]) -> Iterator[Settled]:
        """The edges that a portion settles."""
        finder, tally = self.tally.finder, self.tally
        if isinstance(finder, StampEdges):
            columns = [seconds(portion[name].values, unit) for name, unit in self._units.items()]
            tally.samples += columns[0].size
            found = finder.push(columns[0], columns[1] if len(columns) > 1 else np.empty(0), last=False)
            tally.not_numbers = finder.not_numbers
            for ahead in self.clock.edges(part(found, self.clock.inside(found.times))):
                yield self.close() if ahead is None else self._settle(ahead)
            return
        for stretch in self.clock.stretches(portion[self._wanted.source.channel]):
            if stretch is None:
                yield self.close()
                continue
            if isinstance(finder, WaveEdges):
                found = finder.push(stretch.times, stretch.values, tally.period)
            else:
                assert finder is not None
                found = finder.push(stretch.times, stretch.values)
            yield self._settle(found)._replace(stretch=stretch, found=found)

    def _settle(self, found: Edges, *, last: bool = False) -> Settled:
        settled = self.debounce.push(found)
        settled = join([settled, self.debounce.push(no_edges(), last=True)]) if last else settled
        self.tally.edges += float(np.sum(settled.counts))
        self.tally.doubled = self.debounce.doubled
        return Settled(settled, last)

    def close(self) -> Settled:
        """Nothing follows on this clock: what waits is settled."""
        finder, found = self.tally.finder, no_edges()
        if isinstance(finder, StampEdges):
            found = finder.push(np.empty(0), np.empty(0), last=True)
            found = part(found, self.clock.inside(found.times))
            self.tally.end = max(self.tally.end, float(np.max(found.times, initial=-np.inf)))
        elif finder is not None:
            finder.restart()
        return self._settle(found, last=True)


def _units_of_stamps(log: Log, wanted: Estimation) -> dict[str, str]:
    if not isinstance(wanted.source, Stamps):
        return {}
    choice, units = ClockChoice(unit=wanted.time_unit), {}
    for name in source_channels(wanted):
        units[name], remark = choice.unit_of(log.path, name, log.channel(name).unit)
        if remark is not None:
            log.remark(remark)
    return units


class GatheringPass:
    """A pass over a log that only gathers edges, up to each end of a clock. An interruption is reported in the
    tally.
    """

    def __init__(self, log: Log, wanted: Estimation, beginning: Beginning | None = None) -> None:
        self.log, self.wanted = log, wanted
        self.tally = Tally(len(wanted.wheel.edges))
        if beginning is not None:
            self.tally.verdict, self.tally.tick = beginning.verdict, beginning.tick
        self.finder = EdgeFinder(log, wanted, self.tally)
        self.channels: tuple[str, ...] = source_channels(wanted)
        self.found: list[Edges] = [no_edges()]
        self.check: Callable[[], None] = lambda: None

    def through(self, progress: Callable[[float], None] = lambda done: None, most_edges: float = np.inf) -> None:
        """Takes in the whole log, or its first edges."""
        with catch_interrupt() as self.check:
            try:
                finished = self._take_portions(progress, most_edges)
                self.take(self.finder.close())
            except Stopped:
                finished = False
                self.stop()
        if not finished:
            told = f"The estimation was stopped after {self.tally.measured:.6g} s of the log."
            self.tally.interruptions.append(told)

    def _take_portions(self, progress: Callable[[float], None], most_edges: float) -> bool:
        """Takes in portion by portion; false where `progress` raised KeyboardInterrupt."""
        for portion in self.log.portions(self.channels, SAMPLES_AT_ONCE if np.isinf(most_edges) else SAMPLES_AT_FIRST):
            self.hear(portion)
            for settled in self.finder.push(portion):
                self.take(settled)
            self.check()
            if self.tally.edges >= most_edges:
                break
            try:
                progress(self.log.done)
            except KeyboardInterrupt:
                return False
        return True

    def hear(self, portion: Mapping[str, Portion]) -> None:
        """Takes in what a portion holds besides edges."""

    def take(self, settled: Settled) -> None:
        """Takes settled edges."""
        self.found[-1] = join([self.found[-1], settled.edges])
        self.found += [no_edges()] if settled.last else []

    def stop(self) -> None:
        """Leaves out what was read but not reached."""


class FilteringPass(GatheringPass):
    """A pass that filters edges and writes rows, on the wheel that the beginning of the log speaks for."""

    def __init__(
        self, log: Log, wanted: Estimation, store: Store, say: Callable[[str], None], beginning: Beginning
    ) -> None:
        super().__init__(log, wanted, beginning)
        self.store, self._say, self._beginning = store, say, beginning
        self.excerpt: Excerpt | None = None
        self.tracker: OfflineFilter | None = None
        self._pressure: PressureChain | None = None
        if (told := wanted.pressure) is not None:
            self.channels = tuple(dict.fromkeys((*self.channels, told.channel)))
            self._pressure = PressureChain(told, pascals(log, told), wanted.sections, self.tally, store, say)

    def hear(self, portion: Mapping[str, Portion]) -> None:
        """Takes in the pressure."""
        if self._pressure is not None and self.wanted.pressure is not None:
            pressure = portion[self.wanted.pressure.channel]
            self._pressure.push(pressure, self.finder.clock.inside(pressure.times))

    def take(self, settled: Settled) -> None:
        """Filters settled edges and writes the rows up to where the record is known."""
        if self.excerpt is None or self.log.done <= 0.55:
            waiting = None if self._pressure is None else self._pressure.waiting
            self.excerpt = excerpt(settled, self.tally, waiting) or self.excerpt
        tracker = self._begin() if self.tracker is None else self.tracker
        self.check()
        edges = settled.edges
        if self._beginning.blur > 0.0:  # it is part of the edges' variance then, which silences are judged by
            edges = edges._replace(intervals=np.zeros(edges.times.size))
        tracker.add_gaps(self.finder.clock.gaps)
        self.finder.clock.gaps = []
        horizon = min(self.tally.end, self.finder.debounce.waiting_from)
        for filtered in tracker.push(edges, horizon, last=settled.last):
            self.write(filtered)
            self.check()
        if self._pressure is not None:
            self._pressure.meet(last=settled.last)
        if settled.last:
            self._end_clock(tracker)

    def write(self, filtered: FilteredRows) -> None:
        """Writes rows and edges; a row waits until its pressure is known."""
        self.store.append("", filtered.rows)
        self.store.append("edges", filtered.edges)
        if self._pressure is not None:
            self._pressure.add_rows(filtered.rows["time"], filtered.rows["angle"])
            if self._pressure.row_times.size > REMEMBERED:
                self._pressure.meet()

    def stop(self) -> None:
        """Leaves out what was read but not reached."""
        if self.tracker is None:
            return
        if np.isfinite(self.tracker.reached):
            self.tally.measured -= max(0.0, self.tally.end - self.tracker.reached)
        if self._pressure is not None:
            self._pressure.meet(last=True)
        self.tracker.stop()
        self._end_clock(self.tracker)

    def _end_clock(self, tracker: OfflineFilter) -> None:
        if isinstance(self.tally.finder, StampEdges):
            self.tally.measured = tracker.covered
        if self._pressure is not None:
            self._pressure.next_clock()

    def _begin(self) -> OfflineFilter:
        """The filter and what is written, made as soon as the sample rate is known."""
        usual = min(USUAL_RATE, 1.0 / self.tally.period) if self.tally.period else USUAL_RATE
        self.tally.rate = self.wanted.output_rate or _round_rate(usual)
        told = self.wanted.pressure
        fused = told is not None and told.fused
        self.store.columns("", {**ROWS, **(PRESSURE_ROW if told is not None else {}), **(FUSED_ROWS if fused else {})})
        self.store.columns("edges", EDGES)
        self.tracker = filter_of(self.wanted, self._beginning, self.tally, self._say)
        if fused and self._pressure is not None:
            self._pressure.tell(self.tracker)
        return self.tracker


def excerpt(settled: Settled, tally: Tally, pressure: Waiting | None) -> Excerpt | None:
    """The last turns of the stretch in which edges were found, with the pressure meanwhile; None of too few edges."""
    finder, samples, found = tally.finder, settled.stretch, settled.found
    if samples is None or found is None or found.times.size < 2:
        return None
    shown = part(found, slice(-EXCERPT_TURNS * tally.sectors, None))
    margin = float(shown.times[-1] - shown.times[0]) / shown.times.size
    seen = _between(samples, shown.times[0] - margin, shown.times[-1] + margin)
    wave = isinstance(finder, WaveEdges)
    return Excerpt(
        times=seen.times if wave else np.empty(0),
        values=seen.values if wave else np.empty(0),
        level=finder.level if isinstance(finder, WaveEdges) else np.nan,
        band=finder.band if isinstance(finder, WaveEdges) else np.nan,
        edges=shown,
        pressure=None if pressure is None or not seen.times.size else _between(pressure, *seen.times[[0, -1]]),
    )


def _between(samples: Portion | Waiting, begin: float, end: float) -> Portion:
    first, last = np.searchsorted(samples.times, [begin, end])
    chosen = slice(max(first, last - LARGEST_EXCERPT), last)
    return Portion(samples.times[chosen].copy(), samples.values[chosen].copy())


def _round_rate(rate: float) -> float:
    """A rate without the rounding of time stamps: 9999.9999 becomes 10000."""
    near = round(rate, 3 - int(np.floor(np.log10(rate)))) if rate > 0.0 else rate
    return near if abs(near - rate) < 1e-4 * rate else rate
