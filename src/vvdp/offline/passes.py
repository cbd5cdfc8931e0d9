"""One pass over a log: clock, edges, debounce, filter, writer, and the chain of the inlet pressure beside them."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.estimation.fusion import fusion
from vvdp.logs.channel import Log, Portion
from vvdp.logs.clock import ClockChoice, seconds
from vvdp.logs.quantity import Conversion, to_si
from vvdp.offline.beginning import Beginning
from vvdp.offline.charts import Excerpt
from vvdp.offline.clock import USUAL_RATE, RecordClock
from vvdp.offline.config import Counts, Estimation, InletPressure, Stamps, Wave, source_channels
from vvdp.offline.edges import CountEdges, Debounce, Edges, StampEdges, WaveEdges, join, no_edges, part
from vvdp.offline.estimate_result import Store
from vvdp.offline.excerpt import excerpt
from vvdp.offline.interrupt import Stopped, catch_interrupt
from vvdp.offline.offline_filter import OfflineFilter
from vvdp.offline.pressure_chain import PressureChain
from vvdp.offline.sums import Sums
from vvdp.offline.writer import Writer
from vvdp.sensing.wheel import TURN, sector_widths

SAMPLES_AT_ONCE = 1_000_000
SAMPLES_AT_FIRST = 100_000
"""Where only the first edges are wanted."""
REMEMBERED = 1_000_000
"""Rows that wait for the pressure; beyond, it is taken in before the portion ends."""


def pascals(log: Log, pressure: InletPressure) -> Conversion:
    """How the channel of the pressure becomes Pa. Raises ConfigError where its unit is none of a pressure."""
    channel = log.channel(pressure.channel)
    if not (channel.unit or pressure.unit):
        words = 'has no unit; name it in [pressure] unit, for example "bar"'
        raise ConfigError([Fault(str(log.path), 0, channel.name, words)])
    return to_si(log.path, channel, PRESSURE_LEVEL, pressure.unit or None)


class EdgeFinder:
    """The first three stages: what a portion holds becomes edges that are settled, clock by clock."""

    def __init__(self, log: Log, wanted: Estimation, sums: Sums, tick: float) -> None:
        self._wanted, self.sums = wanted, sums
        self.clock = RecordClock(log.path, wanted, sums)
        self.finder = _finder(wanted, tick)
        narrowest = min(sector_widths(wanted.wheel)) * len(wanted.wheel.edges) / TURN
        self.debounce = Debounce(shortest=min(0.15, 0.4 * narrowest))
        self._units = _units_of_stamps(log, wanted)

    def push(self, portion: Mapping[str, Portion], keep: Callable[[Portion, Edges], None], track: "Track") -> None:
        """Tracks the edges of a portion; each stretch of samples is shown to `keep` with those found in it."""
        channel = self._wanted.source.channel
        if isinstance(self.finder, StampEdges):
            columns = [seconds(portion[name].values, unit) for name, unit in self._units.items()]
            self.sums.samples += columns[0].size
            found = self.finder.push(columns[0], columns[1] if len(columns) > 1 else np.empty(0), last=False)
            self.sums.not_numbers = self.finder.not_numbers
            for ahead in self.clock.edges(part(found, self.clock.inside(found.times))):
                self._debounce(ahead, track)
            return
        for stretch in self.clock.stretches(portion[channel]):
            if stretch is None:
                self.close(track)
                continue
            if isinstance(self.finder, WaveEdges):
                found = self.finder.push(stretch.times, stretch.values, self.sums.period)
            else:
                found = self.finder.push(stretch.times, stretch.values)
            keep(stretch, found)
            self._debounce(found, track)

    def _debounce(self, found: Edges | None, track: "Track") -> None:
        if found is None:
            self.close(track)
        else:
            track(self.debounce.push(found), last=False)

    def close(self, track: "Track") -> None:
        """Nothing follows on this clock: what waits is settled."""
        found = no_edges()
        if isinstance(self.finder, StampEdges):
            found = self.finder.push(np.empty(0), np.empty(0), last=True)
            found = part(found, self.clock.inside(found.times))
            if found.times.size:
                self.sums.end = max(self.sums.end, float(found.times[-1]))
        else:
            self.finder.restart()
        settled = join([self.debounce.push(found), self.debounce.push(no_edges(), last=True)])
        track(settled, last=True)


Track = Callable[..., None]
"""Takes settled edges on, `last` where nothing follows on their clock."""


def _finder(wanted: Estimation, tick: float) -> WaveEdges | CountEdges | StampEdges:
    match wanted.source:
        case Wave(comparator=comparator):
            return WaveEdges(comparator)
        case Counts():
            return CountEdges()
        case Stamps(falling=falling):
            return StampEdges(bool(falling), tick)


def _units_of_stamps(log: Log, wanted: Estimation) -> dict[str, str]:
    if not isinstance(wanted.source, Stamps):
        return {}
    choice, units = ClockChoice(unit=wanted.time_unit), {}
    for name in source_channels(wanted):
        units[name], remark = choice.unit_of(log.path, name, log.channel(name).unit)
        if remark is not None:
            log.remark(remark)
    return units


class Pass:
    """One pass over a log. `gather` is what it does with settled edges; an interruption is told in the sums."""

    def __init__(self, log: Log, wanted: Estimation, tick: float = 0.0) -> None:
        self.log, self.wanted = log, wanted
        self.sums = Sums(len(wanted.wheel.edges), wanted.sections)
        self.edges = EdgeFinder(log, wanted, self.sums, tick)
        self.sums.finder = self.edges.finder
        self.check: Callable[[], None] = lambda: None

    def through(self, progress: Callable[[float], None], most_edges: float = np.inf) -> None:
        """Takes in the whole log, or its first edges."""
        finished = True
        with catch_interrupt() as self.check:
            at_once = SAMPLES_AT_ONCE if np.isinf(most_edges) else SAMPLES_AT_FIRST
            try:
                for portion in self.log.portions(self.channels, at_once):
                    self.take(portion)
                    self.check()
                    if self.sums.edges >= most_edges:
                        break
                    try:
                        progress(self.log.done)
                    except KeyboardInterrupt:
                        finished = False
                        break
                self.edges.close(self.track)
            except Stopped:
                finished = False
                self.stop()
        if not finished:
            self.sums.interruptions.append(f"The estimation was stopped after {self.sums.measured:.6g} s of the log.")

    @property
    def channels(self) -> tuple[str, ...]:
        """What is read."""
        return source_channels(self.wanted)

    def take(self, portion: Mapping[str, Portion]) -> None:
        """Takes in a portion of the log."""
        self.edges.push(portion, self.keep, self.track)

    def keep(self, stretch: Portion, found: Edges) -> None:
        """Keeps what is to be shown of the samples."""

    def track(self, settled: Edges, *, last: bool) -> None:  # noqa: ARG002 - which passes heed
        """Takes settled edges, the `last` on their clock or not."""
        self.sums.edges += float(np.sum(settled.counts))

    def stop(self) -> None:
        """Leaves out what was read but not reached."""


class GatheringPass(Pass):
    """A pass that only gathers edges, up to each end of a clock."""

    def __init__(self, log: Log, wanted: Estimation) -> None:
        super().__init__(log, wanted)
        self.found: list[Edges] = []

    def track(self, settled: Edges, *, last: bool) -> None:
        """Gathers settled edges."""
        super().track(settled, last=last)
        before = self.found.pop() if self.found else no_edges()
        self.found += [join([before, settled]), *([no_edges()] if last else [])]


class FilteringPass(Pass):
    """A pass that filters edges and writes rows, on the wheel that the beginning of the log speaks for."""

    def __init__(
        self, log: Log, wanted: Estimation, store: Store, say: Callable[[str], None], beginning: Beginning
    ) -> None:
        super().__init__(log, wanted, beginning.tick)
        self.store, self._say, self._beginning = store, say, beginning
        self.sums.verdict, self.sums.tick = beginning.verdict, beginning.tick
        self.excerpt: Excerpt | None = None
        self.tracker: OfflineFilter | None = None
        self._writer: Writer | None = None
        self._pressure: PressureChain | None = None
        if (told := wanted.pressure) is not None:
            self._pressure = PressureChain(told, pascals(log, told), wanted.sections, self.sums, say)

    @property
    def channels(self) -> tuple[str, ...]:
        """What is read, the pressure as well."""
        more = () if self.wanted.pressure is None else (self.wanted.pressure.channel,)
        return tuple(dict.fromkeys(super().channels + more))

    def take(self, portion: Mapping[str, Portion]) -> None:
        """Takes in a portion of the log, its pressure first."""
        if self._pressure is not None and self.wanted.pressure is not None:
            pressure = portion[self.wanted.pressure.channel]
            self._pressure.push(pressure, self.edges.clock.inside(pressure.times), self.tracker)
        super().take(portion)

    def keep(self, stretch: Portion, found: Edges) -> None:
        """Keeps the last turns of this stretch, until half of the log has gone by."""
        finder = self.edges.finder
        late = self.excerpt is not None and self.log.done > 0.55
        if found.times.size > 1 and not late and not isinstance(finder, StampEdges):
            waiting = None if self._pressure is None else self._pressure.waiting
            pressure = None if waiting is None else Portion(waiting.times, waiting.values)
            self.excerpt = excerpt(stretch, found, finder, pressure, len(self.wanted.wheel.edges))

    def track(self, settled: Edges, *, last: bool) -> None:
        """Filters settled edges and writes the rows up to where the record is known."""
        tracker, writer = self._stages()
        horizon = min(self.sums.end, self.edges.debounce.waiting_from)
        super().track(settled, last=last)
        self.check()
        if self._beginning.blur > 0.0:  # it is part of the edges' variance then, which silences are judged by
            settled = settled._replace(intervals=np.zeros(settled.times.size))
        tracker.add_gaps(self.edges.clock.gaps)
        self.edges.clock.gaps = []
        for filtered in tracker.push(settled, horizon, last=last):
            writer.write(filtered)
            self.check()
            if self._pressure is not None and writer.rows is not None and writer.rows[0].size > REMEMBERED:
                self._pressure.meet(writer)
        self._meet(last=last)
        if last:
            self._count()
            writer.end_clock()
            if self._pressure is not None:
                self._pressure.next_clock(tracker)

    def _meet(self, *, last: bool) -> None:
        if self._pressure is not None and self._writer is not None:
            self._pressure.meet(self._writer, last=last)

    def stop(self) -> None:
        """Leaves out what was read but not reached."""
        if self.tracker is None:
            return
        if np.isfinite(self.tracker.reached):
            self.sums.measured -= max(0.0, self.sums.end - self.tracker.reached)
        self._meet(last=True)
        self.tracker.stop()
        self._count()

    def _count(self) -> None:
        """What was counted on the way."""
        self.sums.doubled = self.edges.debounce.doubled
        if self.tracker is not None:
            self.sums.taken_from(self.tracker)
            if isinstance(self.edges.finder, StampEdges):
                self.sums.measured = self.tracker.covered

    def _stages(self) -> tuple[OfflineFilter, Writer]:
        """The filter and the writer, made as soon as the sample rate is known."""
        if self.tracker is None or self._writer is None:
            usual = min(USUAL_RATE, 1.0 / self.sums.period) if self.sums.period else USUAL_RATE
            self.sums.rate = self.wanted.output_rate or _round_rate(usual)
            self.tracker = _make_filter(self.wanted, self._beginning, self.sums.rate, self._say)
            told = self.wanted.pressure
            fused = told is not None and told.fused
            self._writer = Writer(self.store, self.sums, with_pressure=told is not None, fused=fused)
            if fused and self._pressure is not None:
                self.tracker.add_pressure_edges(self._pressure.waves)
        return self.tracker, self._writer


def _make_filter(wanted: Estimation, beginning: Beginning, rate: float, say: Callable[[str], None]) -> OfflineFilter:
    """The filter, with the fusion where it is asked for."""
    hidden = beginning.blur * TURN / len(wanted.wheel.edges)
    settings = replace(wanted.filter, edge_variance=wanted.filter.edge_variance + hidden * hidden / 12.0)
    told, together = wanted.pressure, None
    if told is not None and told.fused:
        together = replace(
            fusion(settings),
            sections=float(wanted.sections),
            duty_excess=told.duty_excess,
            lag=told.lag,
            lag_variance=told.lag_deviation**2,
        )
    return OfflineFilter(settings, rate, wanted.sections, together, say, beginning.verdict.likeliest.direction)


def _round_rate(rate: float) -> float:
    """A rate without the rounding of time stamps: 9999.9999 becomes 10000."""
    near = round(rate, 3 - int(np.floor(np.log10(rate)))) if rate > 0.0 else rate
    return near if abs(near - rate) < 1e-4 * rate else rate
