"""From a measured log to angle and speed, in one pass and in bounded memory.

The record goes by in portions: edges are found, bounces taken out, the event filter taken over them, rows written. A
smoother, where asked for, is a second pass over the edges that were written.
"""

import hashlib
import platform
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.base.files import write_whole
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.estimation.fusion import fusion
from vvdp.estimation.pressure_edges import PressureSample, pressure_edges_start, pressure_edges_step
from vvdp.estimation.smoother import Run, Smoothed, smoothed_at, smoothed_portions, smoothing_overlap
from vvdp.logs.channel import Log, Portion
from vvdp.logs.clock import ClockChoice, seconds
from vvdp.logs.quantity import Conversion, to_si
from vvdp.logs.source import open_log
from vvdp.numerics.kalman import AngleSpeed
from vvdp.offline.beginning import Beginning, apply_verdict, beginning, edges_looked_at
from vvdp.offline.bridging import LONGEST_BRIDGED
from vvdp.offline.charts import Excerpt
from vvdp.offline.config import Counts, Estimation, InletPressure, Stamps, Wave, source_channels
from vvdp.offline.config_text import config_text
from vvdp.offline.diagnostics import numbers_in_doubt, settings_of, summary
from vvdp.offline.edges import (
    GAP,
    JUMPING,
    Chosen,
    CountEdges,
    Debounce,
    Edges,
    StampEdges,
    WaveEdges,
    join,
    no_edges,
    part,
)
from vvdp.offline.estimate_result import EDGES, FUSED_ROWS, PRESSURE_ROW, ROWS, SMOOTHED, Store
from vvdp.offline.findings import findings
from vvdp.offline.noise_fit import fitted_filter
from vvdp.offline.offline_filter import FEWEST_EDGES, FilteredRows, OfflineFilter, Waves, no_waves
from vvdp.offline.result import Outcome, estimate_result
from vvdp.offline.ripple_findings import ripple_words
from vvdp.offline.sums import Sums
from vvdp.offline.turn_pattern import SpeedRipple
from vvdp.results.result import Result
from vvdp.results.store import write_result
from vvdp.sensing.wheel import TURN, sector_widths
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay

CONFIG = "estimate.toml"
"""Every setting, also the defaults; a config for the next estimation."""
SAMPLES_AT_ONCE = 1_000_000
USUAL_RATE = 1000.0
"""Rows a second of the time base, unless the log has fewer samples or another rate is asked for."""
REMEMBERED = 1_000_000
"""Rows that wait for the pressure; beyond, it is taken in before the portion ends."""
FITTED_EDGES = 20_000
"""The settings of the filter are fitted to so many edges at the beginning of the log ..."""
FITTED_AT_ONCE = 100_000
"""... which is read in portions of so many samples."""
EXCERPT_TURNS = 3
LARGEST_EXCERPT = 20_000
SMOOTHED_EDGES = 50_000
MOST_BACKWARD = 1000
"""A clock that goes back more often is none."""
FORGOTTEN = 1e-4
"""Edges count for a smoothed instant until their share has fallen to this."""


def open_for_estimate(path: Path, wanted: Estimation) -> Log:
    """The log, opened with the clock that was named; columns of edge times need none.

    Raises ConfigError where it cannot be read, or lacks a channel that is asked for.
    """
    if isinstance(wanted.source, Stamps):
        return _opened_stamps(path, wanted)
    log = open_log(path, time=wanted.time, rate=wanted.sample_rate, time_unit=wanted.time_unit)
    check_channels(log, wanted)
    return log


def _opened_stamps(path: Path, wanted: Estimation) -> Log:
    faults = [
        Fault("log", 0, word, "edge times are a clock themselves; leave it out")
        for word, value in (("time", wanted.time), ("sample_rate", wanted.sample_rate))
        if value is not None
    ]
    if wanted.pressure is not None:
        faults.append(
            Fault("pressure", 0, "", "a pressure needs a clock of its own, which a table of edge times does not have")
        )
    if faults:
        raise ConfigError(faults)
    log = open_log(path, rate=1.0)  # rows are counted, their times are of no use
    check_channels(log, wanted)
    try:
        log.portions(source_channels(wanted), 1)
    except ConfigError:
        log.close()
        log = open_log(path)  # a file whose channels have a clock
    return log


def check_channels(log: Log, wanted: Estimation) -> None:
    """Raises ConfigError for every channel that the log does not have, and for units that are none."""
    faults: list[Fault] = []
    for name in source_channels(wanted):
        try:
            log.channel(name)
        except ConfigError as problem:
            faults.extend(problem.faults)
    if wanted.pressure is not None:
        try:
            _pascals(log, wanted.pressure)
        except ConfigError as problem:
            faults.extend(problem.faults)
    if faults:
        raise ConfigError(faults)


def _pascals(log: Log, pressure: InletPressure) -> Conversion:
    channel = log.channel(pressure.channel)
    if not (channel.unit or pressure.unit):
        words = 'has no unit; name it in [pressure] unit, for example "bar"'
        raise ConfigError([Fault(str(log.path), 0, channel.name, words)])
    return to_si(log.path, channel, PRESSURE_LEVEL, pressure.unit or None)


@contextmanager
def _catch_interrupt() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed, to be asked where the record can be left; a second one ends everything at once."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True

    before = signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)


class _Stopped(Exception):
    """Ctrl-C was pressed where the record can be left."""


def estimate(
    log: Log,
    wanted: Estimation,
    folder: Path,
    *,
    progress: Callable[[float], None] = lambda done: None,
    say: Callable[[str], None] = quiet,
    more: Mapping[str, Any] | None = None,
) -> Result:
    """Runs an estimation over a log, writes all of it into `folder`, and gives the result.

    progress  hears the share that is done of the log, or with `smooth` of both passes over it, 0 to 1;
              KeyboardInterrupt raised there, and Ctrl-C, end the pass where it is, and all that was reached is kept
    more      is added to meta.json
    Raises ConfigError where the log has no edges to go by or the file is damaged, KeyboardInterrupt where it ended
    before anything was reached.
    """
    began = time.perf_counter()
    beginning, wanted = _look_at_beginning(log, wanted, say)
    wanted = _fit_settings(log, wanted, beginning, say)
    with Store(folder / "result.h5") as store:
        run = _Run(log, wanted, store, say, beginning)
        passes = 2.0 if wanted.smooth else 1.0
        run.through(lambda done: progress(done / passes))
        if not run.sums.rows:
            if run.sums.interruptions:
                raise KeyboardInterrupt
            raise unusable(log.path, run.explain_no_result())
        with _catch_interrupt():  # the second pass heeds Ctrl-C itself; all else is done to the end, in seconds
            run.report_skipped()
            if wanted.smooth:
                run.smooth(lambda done: progress((1.0 + done) / passes))
            outcome = _outcome(run, wanted, log, began)
            result = estimate_result(outcome)
            write_whole(folder / CONFIG, outcome.config)
            write_result(folder, result, "", more=_meta(outcome) | dict(more or {}))
            return result


def _outcome(run: "_Run", wanted: Estimation, log: Log, began: float) -> Outcome:
    """What a run came to, with all rows of result.h5 written."""
    run.store.flush()
    seconds = time.perf_counter() - began
    found = summary(run.sums, wanted) | {"estimated_share": run.estimated_share}
    return Outcome(
        log=log.path,
        wanted=wanted,
        wave_unit=log.channel(wanted.source.channel).unit if isinstance(wanted.source, Wave) else "",
        file=run.store.file,
        sums=run.sums,
        excerpt=run.excerpt,
        summary=found,
        findings=findings(found, run.sums, wanted, log),
        config=config_text(wanted, log.channels(), log.path.name),
        remarks=tuple(log.remarks),
        log_sha256=_hash(log.path),
        seconds=seconds,
    )


def _meta(outcome: Outcome) -> dict[str, Any]:
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "log": str(outcome.log),
        "log_bytes": outcome.log.stat().st_size,
        "log_sha256": outcome.log_sha256,
        "remarks": list(outcome.remarks),
        "finished": not outcome.sums.interruptions,
        "seconds": outcome.seconds,
    }


def _look_at_beginning(log: Log, wanted: Estimation, say: Callable[[str], None]) -> tuple[Beginning, Estimation]:
    """What the first edges of the log say of the wheel and of the clock, and the estimation that takes the wheel so."""
    with TemporaryDirectory() as place, Store(Path(place) / "first.h5") as store:
        run = _Run(log, wanted, store, say, None)
        run.through(lambda done: None, edges_looked_at(wanted.wheel))
        if run.sums.interruptions:
            raise KeyboardInterrupt
        found = beginning(run.first_edges, wanted)
    return found, apply_verdict(wanted, found.verdict)


def _fit_settings(log: Log, wanted: Estimation, beginning: Beginning, say: Callable[[str], None]) -> Estimation:
    """The estimation with the settings that the beginning of the log speaks for, if it asks for them."""
    if not wanted.fit:
        return wanted
    with TemporaryDirectory() as place, Store(Path(place) / "first.h5") as store:
        run = _Run(log, wanted, store, say, beginning)
        run.through(lambda done: None, FITTED_EDGES)
        if run.sums.interruptions:
            raise KeyboardInterrupt
        told = run.sums.noise_fit(settings_of(wanted))
    if told is None or numbers_in_doubt(told, run.sums, wanted):
        why = "the log is too short" if told is None else "which edge is which is in doubt, too much"
        log.remark(f"{why} for a fit of the filter's settings; they were left as they were")
        return replace(wanted, fit=False)
    if told.ripple is not None:
        log.remark(f"{ripple_words(told.ripple)}; taken for ripple")
    return replace(wanted, fit=False, filter=fitted_filter(wanted.filter, told))


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass
class _Pressure:
    """The inlet pressure on its way: samples that wait for the angle, the wave's edges, and the fold over a turn."""

    pascals: Conversion
    replay: Replay
    memory: Any = None
    waiting_times: Array = field(default_factory=lambda: np.empty(0))
    waiting: Array = field(default_factory=lambda: np.empty(0))
    folded: int = 0
    """1 where the first of these was folded already; rows before the next sample lie between the two."""
    bare_rows: int = 0
    """So many of the last rows still lack their pressure."""
    rise_angle: float = np.nan
    waves: Waves = field(default_factory=no_waves)
    """Edges that wait for the speed."""
    clock: int = 0
    """How often the time of this channel went back."""
    last_time: float = -np.inf
    later: list[tuple[int, Array, Array]] = field(default_factory=list)
    """Stretches after times that went back, which the edges have not reached yet: their clock, times and values."""

    LONGEST = 4_000_000

    def restart(self) -> None:
        """Forget what came before: the time went back."""
        self.memory, self.rise_angle, self.waves = None, np.nan, no_waves()
        self.waiting_times, self.waiting, self.folded = np.empty(0), np.empty(0), 0


class _Run:
    """One pass over a log; without a `beginning` it only gathers edges."""

    def __init__(
        self, log: Log, wanted: Estimation, store: Store, say: Callable[[str], None], beginning: Beginning | None
    ) -> None:
        self.log, self.wanted, self.store, self.say = log, wanted, store, say
        self.beginning = beginning
        self.first_edges: list[Edges] = []
        """Without a beginning: edges up to each end of a clock."""
        self.sums = Sums(len(wanted.wheel.edges), wanted.sections)
        self.period = 0.0
        self.tracker: OfflineFilter | None = None
        narrowest = min(sector_widths(wanted.wheel)) * len(wanted.wheel.edges) / TURN
        self.debounce = Debounce(shortest=min(0.15, 0.4 * narrowest))
        self.clock_at = -np.inf
        self.gaps: list[tuple[float, float]] = []
        """Of the record, from when to when [s], that the tracker is not yet told of."""
        self.clock = 0  # how often the time went back
        self.excerpt: Excerpt | None = None
        self.pressure = self._pressure()
        self._rows: tuple[Array, Array] | None = None
        match wanted.source:
            case Wave(comparator=comparator):
                self.finder: WaveEdges | CountEdges | StampEdges = WaveEdges(comparator)
            case Counts():
                self.finder = CountEdges()
            case Stamps(falling=falling):
                self.finder = StampEdges(bool(falling), beginning.tick if beginning is not None else 0.0)
        self.sums.finder = self.finder
        if beginning is not None:
            self.sums.verdict, self.sums.tick = beginning.verdict, beginning.tick
        self._interrupted: Callable[[], bool] = lambda: False
        self._stamp_units = self._units_of_stamps()
        self._smoothed_rows = 0

    def _units_of_stamps(self) -> dict[str, str]:
        if not isinstance(self.wanted.source, Stamps):
            return {}
        choice, units = ClockChoice(unit=self.wanted.time_unit), {}
        for name in source_channels(self.wanted):
            units[name], remark = choice.unit_of(self.log.path, name, self.log.channel(name).unit)
            if remark is not None:
                self.log.remark(remark)
        return units

    def _pressure(self) -> _Pressure | None:
        wanted = self.wanted.pressure
        if wanted is None:
            return None
        replay = Replay(
            pressure_edges_step, pressure_edges_start(0.0, 0.0), PressureSample(0.0, 0.0), wanted.edges, say=self.say
        )
        return _Pressure(_pascals(self.log, wanted), replay)

    def through(self, progress: Callable[[float], None], most_edges: float = np.inf) -> None:
        """Takes in the whole log, or its first edges; an interruption is told in the sums."""
        names = source_channels(self.wanted)
        if self.wanted.pressure is not None:
            names += (self.wanted.pressure.channel,)
        wanted_names = tuple(dict.fromkeys(names))
        finished = True
        with _catch_interrupt() as self._interrupted:
            at_once = SAMPLES_AT_ONCE if np.isinf(most_edges) else FITTED_AT_ONCE
            try:
                for portion in self.log.portions(wanted_names, at_once):
                    self._take(portion)
                    self._heed()
                    if self.sums.edges >= most_edges:
                        break
                    try:
                        progress(self.log.done)
                    except KeyboardInterrupt:
                        finished = False
                        break
                self._close_clock()
            except _Stopped:
                finished = False
                self._stop_here()
        if not finished:
            self.sums.interruptions.append(f"The estimation was stopped after {self.sums.measured:.6g} s of the log.")

    def _heed(self) -> None:
        """Raises _Stopped after Ctrl-C; asked wherever the record can be left."""
        if self._interrupted():
            raise _Stopped

    def _stop_here(self) -> None:
        """Leaves out what was read but not reached."""
        if self.tracker is None:
            return
        if np.isfinite(self.tracker.reached):
            self.sums.measured -= max(0.0, self.sums.end - self.tracker.reached)
        self._take_in_pressure(last=True)
        self.tracker.stop()
        self._count()

    def _count(self) -> None:
        """What was counted on the way."""
        self.sums.doubled = self.debounce.doubled
        if self.tracker is not None:
            self.sums.taken_from(self.tracker)
            if isinstance(self.finder, StampEdges):
                self.sums.measured = self.tracker.covered

    def report_skipped(self) -> None:
        """Remarks when isolated edges were ignored; the time base does not reach out to them."""
        if self.tracker is None or not self.tracker.left_out_times:
            return
        times, count = self.tracker.left_out_times, self.tracker.left_out
        named = ", ".join(f"{time:.6g}" for time in times) + (" s and on" if count > len(times) else " s")
        ignored = "one isolated edge was" if count == 1 else f"{count} isolated edges were"
        self.log.remark(f"{ignored} ignored, at {named}")

    @property
    def estimated_share(self) -> float:
        """The share of the covered time for which there is an estimate."""
        rate, measured = self.sums.rate, self.sums.measured
        return min(self.sums.rows / rate / measured, 1.0) if rate and measured > 0.0 else np.nan

    # What goes in

    def _take(self, portion: Mapping[str, Portion]) -> None:
        match self.wanted.source, self.finder:
            case Stamps(channel=channel, falling=falling), StampEdges() as finder:
                rising = seconds(portion[channel].values, self._stamp_units[channel])
                other = seconds(portion[falling].values, self._stamp_units[falling]) if falling else np.empty(0)
                self.sums.samples += rising.size
                found = finder.push(rising, other, last=False)
                self.sums.not_numbers = finder.not_numbers
                self._edges(self._within(found))
            case ((Wave(channel=channel) | Counts(channel=channel)), _):
                if self.pressure is not None and self.wanted.pressure is not None:
                    self._take_pressure(portion[self.wanted.pressure.channel])
                self._take_samples(portion[channel])

    def _within(self, edges: Edges) -> Edges:
        return part(edges, self._inside(edges.times))

    def _inside(self, times: Array) -> Chosen:
        """Which times are in the range that was asked for."""
        begin, end = self.wanted.begin, self.wanted.end
        found: Chosen = np.isfinite(times)
        if begin is not None:
            found &= times >= begin
        if end is not None:
            found &= times <= end
        return found

    def _take_samples(self, portion: Portion) -> None:
        times, values = portion
        self.sums.samples += times.size
        sound = np.isfinite(values) & np.isfinite(times)
        self.sums.not_numbers += int(times.size - np.count_nonzero(sound))
        inside = self._inside(times)
        if not self.period and np.count_nonzero(inside) > 1:
            self._meet_clock(times[inside])
        self._watch_clock(times[inside])
        sound &= inside
        if not sound.all():
            times, values = times[sound], values[sound]
        if not times.size:
            return
        steps = np.diff(np.concatenate([[self.sums.end if np.isfinite(self.sums.end) else times[0]], times]))
        back = np.flatnonzero(steps < 0.0)
        self._refuse_backward(back.size)
        for i, (first, last) in enumerate(zip([0, *back], [*back, times.size], strict=True)):
            if i:
                self.sums.backward += 1
                self._close_clock()
            if last > first:
                self._take_stretch(times[first:last], values[first:last])

    def _refuse_backward(self, more: int) -> None:
        """Raises ConfigError where the time goes back so often that it is no clock."""
        if self.sums.backward + more > MOST_BACKWARD:
            channel = self.wanted.source.channel
            named = f"edge times {channel!r} do" if isinstance(self.wanted.source, Stamps) else "clock does"
            problem = f"the {named} not run forward, more than {MOST_BACKWARD} times; is it the right column?"
            raise unusable(self.log.path, problem)

    def _watch_clock(self, times: Array) -> None:
        """Gaps between samples, whatever their values."""
        if not times.size:
            return
        before = self.clock_at if np.isfinite(self.clock_at) else times[0]
        steps = np.diff(np.concatenate([[before], times]))
        self.clock_at = float(times[-1])
        after = np.flatnonzero(steps > GAP * self.period) if self.period else np.empty(0, int)
        self.sums.gaps += after.size
        self.gaps += [(float(times[i] - steps[i]), float(times[i])) for i in after.tolist()]
        self.sums.longest_gap = max(self.sums.longest_gap, float(np.max(steps, initial=0.0)))
        self.sums.measured += float(np.sum(steps[steps > 0.0]))

    def _take_stretch(self, times: Array, values: Array) -> None:
        if isinstance(self.finder, WaveEdges):
            found = self.finder.push(times, values, self.period)
        else:
            assert isinstance(self.finder, CountEdges)
            found = self.finder.push(times, values)
        self.sums.begin = min(self.sums.begin, float(times[0]))
        self.sums.end = float(times[-1])
        self._keep_excerpt(times, values, found)
        self._edges(found)

    def _meet_clock(self, times: Array) -> None:
        steps = np.diff(times)
        ahead = steps[steps > 0.0]
        self.period = float(np.median(ahead)) if ahead.size else 1.0 / USUAL_RATE
        self.sums.period = self.period

    def _edges(self, found: Edges) -> None:
        """Edges as they were found, up to where the record is known."""
        stamps = isinstance(self.wanted.source, Stamps)
        if stamps:
            for i, ahead in enumerate(self._ahead(found)):
                if i:
                    self._close_clock()
                self._forward(ahead)
        else:
            self._forward(found)

    def _ahead(self, found: Edges) -> Iterator[Edges]:
        """Times of edges cut where they go back: a column of several records, one below the other."""
        before = self.sums.end if np.isfinite(self.sums.end) else -np.inf
        back = np.flatnonzero(np.diff(np.concatenate([[before], found.times])) < 0.0)
        self._refuse_backward(back.size)
        self.sums.backward += back.size
        for first, last in zip([0, *back], [*back, found.times.size], strict=True):
            yield Edges(*(column[first:last] for column in found))

    def _forward(self, found: Edges) -> None:
        if isinstance(self.wanted.source, Stamps) and found.times.size:
            self.sums.begin = min(self.sums.begin, float(found.times[0]))
            self.sums.end = float(found.times[-1])
        self._track(self.debounce.push(found), last=False)

    def _track(self, settled: Edges, *, last: bool) -> None:
        if self.beginning is None:
            self.sums.edges += float(np.sum(settled.counts))
            before = self.first_edges.pop() if self.first_edges else no_edges()
            self.first_edges += [join([before, settled]), *([no_edges()] if last else [])]
            return
        if self.tracker is None:
            self.tracker = self._tracker()
        tracker = self.tracker
        waiting = self.debounce.waiting_from
        horizon = min(self.sums.end, waiting)
        self.sums.edges += float(np.sum(settled.counts))
        self._heed()
        if self.beginning.blur > 0.0:  # it is part of the edges' variance then, which silences are judged by
            settled = settled._replace(intervals=np.zeros(settled.times.size))
        tracker.add_gaps(self.gaps)
        self.gaps = []
        for tracked in tracker.push(settled, horizon, last=last):
            self._write(tracked)
            self._heed()
            if self._rows is not None and self._rows[0].size > REMEMBERED:
                self._take_in_pressure()
        self._take_in_pressure()

    def _tracker(self) -> OfflineFilter:
        usual = USUAL_RATE if not self.period else min(USUAL_RATE, 1.0 / self.period)
        rate = self.wanted.output_rate or _round_rate(usual)
        self.sums.rate = rate
        wanted, together, direction = self.wanted, None, 1.0
        settings = wanted.filter
        if self.beginning is not None:
            direction = self.beginning.verdict.likeliest.direction
            hidden = self.beginning.blur * TURN / self.sums.sectors
            settings = replace(settings, edge_variance=settings.edge_variance + hidden * hidden / 12.0)
        if wanted.pressure is not None and wanted.pressure.fused:
            told = wanted.pressure
            together = replace(
                fusion(settings),
                sections=float(wanted.sections),
                duty_excess=told.duty_excess,
                lag=told.lag,
                lag_variance=told.lag_deviation**2,
            )
        more = {**(PRESSURE_ROW if self.pressure is not None else {}), **(FUSED_ROWS if together is not None else {})}
        self.store.columns("", {**ROWS, **more})
        self.store.columns("edges", EDGES)
        tracker = OfflineFilter(settings, rate, wanted.sections, together, self.say, direction)
        if together is not None and self.pressure is not None:
            tracker.add_pressure_edges(self.pressure.waves)
        return tracker

    def _close_clock(self) -> None:
        """Nothing follows on this clock: what waits is settled."""
        found = no_edges()
        if isinstance(self.finder, StampEdges):
            found = self._within(self.finder.push(np.empty(0), np.empty(0), last=True))
            if found.times.size:
                self.sums.end = max(self.sums.end, float(found.times[-1]))
        else:
            self.finder.restart()
        settled = join([self.debounce.push(found), self.debounce.push(no_edges(), last=True)])
        self._track(settled, last=True)
        self._count()
        if self.pressure is not None:
            self._take_in_pressure(last=True)
            self.pressure.restart()
            self._rows = None
            self.clock += 1
            later, self.pressure.later = self.pressure.later, []
            for clock, times, values in later:
                if clock == self.clock:
                    self._take_pressures(times, values)
                elif clock > self.clock:
                    self.pressure.later.append((clock, times, values))

    # What comes out

    def _write(self, tracked: FilteredRows) -> None:
        rows = dict(tracked.rows)
        if rows["time"].size:
            if self.pressure is not None:
                self._remember(rows)
                self.pressure.bare_rows += rows["time"].size
            self.store.append("", rows)
        if tracked.edges:
            self.store.append("edges", tracked.edges)
        self.sums.add(tracked)

    def _remember(self, rows: Mapping[str, Array]) -> None:
        times, angles = rows["time"], rows["angle"]
        if self._rows is not None:
            times, angles = np.concatenate([self._rows[0], times]), np.concatenate([self._rows[1], angles])
        self._rows = (times, angles)

    def _take_pressure(self, portion: Portion) -> None:
        pressure = self.pressure
        assert pressure is not None
        sound = np.isfinite(portion.values) & self._inside(portion.times)
        times, values = portion.times[sound], pressure.pascals(portion.values[sound])
        if not times.size:
            return
        back = np.flatnonzero(np.diff(np.concatenate([[pressure.last_time], times])) < 0.0)
        pressure.last_time = float(times[-1])
        for i, (first, last) in enumerate(zip([0, *back], [*back, times.size], strict=True)):
            pressure.clock += 1 if i else 0
            if first == last:
                continue
            if pressure.clock > self.clock:
                pressure.later.append((pressure.clock, times[first:last], values[first:last]))
            elif pressure.clock == self.clock:
                self._take_pressures(times[first:last], values[first:last])

    def _take_pressures(self, times: Array, values: Array) -> None:
        """Pressures [Pa] on the clock that the edges are on."""
        pressure = self.pressure
        assert pressure is not None
        if pressure.memory is None:
            pressure.memory = pressure_edges_start(float(times[0]), float(values[0]))
        pressure.waiting_times = np.concatenate([pressure.waiting_times, times])
        pressure.waiting = np.concatenate([pressure.waiting, values])
        if pressure.waiting.size > pressure.LONGEST:
            pressure.waiting_times = pressure.waiting_times[-pressure.LONGEST :]
            pressure.waiting, pressure.folded = pressure.waiting[-pressure.LONGEST :], 0
        done = pressure.replay(pressure.memory, np.column_stack([times, values]))
        pressure.memory = done.memory
        columns = dict(zip(pressure.replay.columns, done.shown.T, strict=True))
        at = np.flatnonzero(columns["pressure_edges"] > 0.0)
        names = ("time", "pressure_edge_time", "pressure_edge_interval", "pressure_polarity")
        found = Waves(*(columns[name][at] for name in names))
        pressure.waves = Waves(*(np.concatenate(both) for both in zip(pressure.waves, found, strict=True)))
        if self.wanted.pressure is not None and self.wanted.pressure.fused and self.tracker is not None:
            self.tracker.add_pressure_edges(found)

    def _take_in_pressure(self, *, last: bool = False) -> None:
        """Gives the rows their pressure, folds it over the angle and takes its duty ratio, as far as both are known;
        `last`: no more of it comes on this clock."""
        pressure = self.pressure
        if pressure is None or self._rows is None:
            return
        row_times, angles = self._rows
        self._give_pressure(row_times, last)
        until = float(row_times[-1])
        ready = int(np.searchsorted(pressure.waiting_times, until, side="right"))
        if ready > pressure.folded:
            new = slice(pressure.folded, ready)
            times, values = pressure.waiting_times[new], pressure.waiting[new]
            known = times >= row_times[0]
            angle = np.interp(times, row_times, angles)
            self.sums.pressures(values, np.where(known, np.mod(angle, TURN), np.nan))
            waves = pressure.waves
            heard = int(np.searchsorted(waves.known, until, side="right"))
            pressure.waves = Waves(*(column[heard:] for column in waves))
            edge_times = waves.times[:heard]
            self._duty(np.interp(edge_times, row_times, angles, left=np.nan), waves.polarities[:heard] > 0.0)
            pressure.waiting_times, pressure.waiting = (
                pressure.waiting_times[ready - 1 :],
                pressure.waiting[ready - 1 :],
            )
            pressure.folded = 1
        begin = max(0, row_times.size - pressure.LONGEST)
        if pressure.waiting.size:
            begin = max(begin, int(np.searchsorted(row_times, pressure.waiting_times[0])) - 1)
        self._rows = (row_times[begin:], angles[begin:])

    def _give_pressure(self, row_times: Array, last: bool) -> None:
        """Writes the pressure of the rows up to its newest sample; of all rows, if it is the `last`."""
        pressure = self.pressure
        assert pressure is not None
        times, values = pressure.waiting_times, pressure.waiting
        begin = row_times.size - pressure.bare_rows
        end = int(np.searchsorted(row_times, times[-1], side="right")) if times.size else 0
        end = row_times.size if last else max(begin, end, row_times.size - pressure.LONGEST)
        rows = row_times[begin:end]
        given = np.interp(rows, times, values, left=np.nan, right=np.nan) if times.size else np.full(rows.size, np.nan)
        self.store.append("", {"inlet_pressure": given})
        pressure.bare_rows -= rows.size

    def _duty(self, angles: Array, rising: Chosen) -> None:
        """Takes in each pulse: the angles of a rising edge and of the falling one that follows it."""
        pressure = self.pressure
        assert pressure is not None
        rises = np.concatenate([[pressure.rise_angle], np.where(rising, angles, np.nan)])  # NaN after a falling edge
        shares = (np.abs(angles - rises[:-1]) * (self.wanted.sections / TURN))[~rising]
        excess = self.wanted.pressure.duty_excess if self.wanted.pressure is not None else 0.0
        self.sums.duties(shares[(shares > 0.0) & (shares < 1.0)] - excess)
        pressure.rise_angle = float(rises[-1])

    def _keep_excerpt(self, times: Array, values: Array, found: Edges) -> None:
        """The last turns of this stretch, until half of the log has gone by."""
        turn = len(self.wanted.wheel.edges)
        if found.times.size < 2 or (self.excerpt is not None and self.log.done > 0.55):
            return
        shown = Edges(*(column[-EXCERPT_TURNS * turn :] for column in found))
        margin = float(shown.times[-1] - shown.times[0]) / shown.times.size
        begin, end = np.searchsorted(times, [shown.times[0] - margin, shown.times[-1] + margin])
        begin = max(begin, end - LARGEST_EXCERPT)
        pressure = None
        if self.pressure is not None:
            t = self.pressure.waiting_times
            a, b = np.searchsorted(t, [times[begin], times[end - 1]])
            a = max(a, b - LARGEST_EXCERPT)
            pressure = Portion(t[a:b].copy(), self.pressure.waiting[a:b].copy())
        wave = isinstance(self.finder, WaveEdges)
        level = self.finder.level if isinstance(self.finder, WaveEdges) else np.nan
        band = self.finder.band if isinstance(self.finder, WaveEdges) else np.nan
        part = slice(begin, end) if wave else slice(0)
        self.excerpt = Excerpt(
            times=times[part].copy(),
            values=values[part].copy(),
            level=level,
            band=band,
            edges=shown,
            pressure=pressure,
        )

    def smooth(self, progress: Callable[[float], None]) -> None:
        """The second pass: every row again, given the edges before and after it; it may be interrupted as well."""
        with _catch_interrupt() as self._interrupted:
            self.store.flush()
            self.store.columns("", SMOOTHED)
            pieces = self.store.file["piece"][:]
            self.store.append("", {name: np.full(pieces.size, np.nan) for name in SMOOTHED})
            self.store.flush()
            try:
                self._smooth_pieces(pieces, progress)
            except _Stopped:
                self._stop_smoothing(pieces.size)

    def _smooth_pieces(self, pieces: Array, progress: Callable[[float], None]) -> None:
        numbers = self.store.file["edges/piece"][:]
        runs: dict[Any, Replay] = {}

        def run(step: Any, memory: Any, row: Any, settings: Any, rows: Array) -> tuple[Any, Array]:
            if step not in runs:
                runs[step] = Replay(step, memory, row, settings, say=self.say)
            done = runs[step](memory, rows, settings)
            return done.memory, done.shown

        for piece in np.unique(numbers):
            first, last = np.searchsorted(numbers, [piece, piece + 0.5])
            begin, end = np.searchsorted(pieces, [piece, piece + 0.5])
            self._heed()
            for smoothed in self._smooth(int(first), int(last), run):
                self._write_smoothed(smoothed, int(begin), int(end), run)
                try:
                    progress(self._smoothed_rows / pieces.size)
                except KeyboardInterrupt:
                    raise _Stopped from None

    def _stop_smoothing(self, rows: int) -> None:
        if self._smoothed_rows < rows:
            time, piece = (self.store.file[name][self._smoothed_rows] for name in ("time", "piece"))
            self.sums.interruptions.append(
                f"The second pass was stopped; from {time:.6g} s of piece {piece:g} on the smoothed columns are NaN."
            )

    def _ripple(self) -> SpeedRipple | None:
        """The ripple that the smoother takes off: of the order that the filter is told of, as the log has it."""
        told = self.sums.noise_fit(settings_of(self.wanted))
        ripple = None if told is None else told.ripple
        return ripple if ripple is not None and ripple.order == self.wanted.filter.ripple_order else None

    def _smooth(self, first: int, last: int, run: Run) -> Iterator[Smoothed]:
        file, q = self.store.file["edges"], self.wanted.filter.acceleration_density
        portions, ripple = list(range(first, last, SMOOTHED_EDGES)), self._ripple()

        def columns(begin: int) -> tuple[Array, Array, Array]:
            end = min(begin + SMOOTHED_EDGES, last)
            t, angle, variance = (file[name][begin:end] for name in ("time", "angle", "variance"))
            used = np.isfinite(angle)
            used[1:] &= np.diff(t) > 0.0
            met = angle if ripple is None else angle + ripple.offsets(angle)
            return t[used], met[used], variance[used]

        t, angle, variance = columns(first)
        if t.size < 2 or not q > 0.0:
            return
        turns = min(t.size - 1, 2 * self.sums.sectors)
        speed = float((angle[turns] - angle[0]) / (t[turns] - t[0]))
        settings = self.wanted.filter
        start = AngleSpeed(float(angle[0]), speed, settings.angle_variance, 0.0, settings.speed_variance)
        period = float(np.median(np.diff(t)))
        overlap = smoothing_overlap(q, float(np.median(variance)), period, FORGOTTEN)
        yield from smoothed_portions((columns(begin) for begin in portions), q, start, overlap, run)

    def _write_smoothed(self, smoothed: Smoothed, begin: int, end: int, run: Run) -> None:
        file = self.store.file
        times = file["time"][begin:end]
        a, b = np.searchsorted(times, smoothed.times[[0, -1]])
        if begin + b < end and b == times.size - 1:
            b = times.size
        if b <= a:
            return
        ripple = self._ripple()
        for start in range(int(a), int(b), SMOOTHED_EDGES):
            stop = min(start + SMOOTHED_EDGES, int(b))
            motion = smoothed_at(times[start:stop], smoothed, run)
            motion = motion if ripple is None else ripple.motion(motion)
            values = (motion.angle, motion.speed, np.sqrt(motion.angle_variance), np.sqrt(motion.speed_variance))
            for name, column in zip(SMOOTHED, values, strict=True):
                file[name][begin + start : begin + stop] = column
            self._smoothed_rows = begin + stop
            self._heed()

    def explain_no_result(self) -> str:
        """Why there is no estimate."""
        edges = f"{self.sums.edges:g} edges were found"
        channel = self.wanted.source.channel
        if isinstance(self.finder, WaveEdges) and not self.sums.edges and self.finder.jumps > JUMPING:
            return (
                f"channel {channel!r} goes through {100.0 * self.finder.jumps:.0f} % of its range from one sample to "
                "the next: there are too few samples for each sector (three at least are needed to see where the wave "
                "rises and falls), or it is noise; sample faster, or give threshold.level in a config"
            )
        if isinstance(self.finder, WaveEdges) and not np.isfinite(self.finder.level):
            return (
                f"channel {channel!r} does not go up and down between two levels, so there is no threshold and no "
                "edge; name the right channel, or give threshold.level in a config"
            )
        if not self.sums.samples:
            return f"channel {channel!r} has no samples"
        if isinstance(self.finder, CountEdges) and self.finder.fractions:
            return (
                f"{edges} in channel {channel!r}, and {self.finder.fractions} of its {self.sums.samples} values are no "
                "whole numbers, so it is no counter; if it is a wave, name it with --wave"
            )
        if not self.sums.edges and (self.wanted.begin is not None or self.wanted.end is not None):
            return f"no edges of {channel!r} lie in the time range that was asked for"
        needed = f"an estimate needs at least {FEWEST_EDGES} on one clock"
        if self.sums.backward:
            return (
                f"{edges} in channel {channel!r}, but time runs backwards there, {self.sums.backward} times; {needed}, "
                "and in the order of time"
            )
        if self.sums.edges > FEWEST_EDGES:
            apart = (self.sums.end - self.sums.begin) / (self.sums.edges - 1.0)
            if isinstance(self.finder, CountEdges) and apart < LONGEST_BRIDGED:
                steps = self.tracker.left_out if self.tracker is not None else 0
                return f"{edges} in channel {channel!r}, in only {steps} steps; {needed}, so read the counter faster"
            return (
                f"{edges} in channel {channel!r}, {apart:.4g} s apart on average: the spool is not rotating; look at "
                f"the unit of the times ({needed} with less than {LONGEST_BRIDGED:g} s between them)"
            )
        return f"{edges} in channel {channel!r}; {needed}"


def _round_rate(rate: float) -> float:
    """A rate without the rounding of time stamps: 9999.9999 becomes 10000."""
    near = round(rate, 3 - int(np.floor(np.log10(rate)))) if rate > 0.0 else rate
    return near if abs(near - rate) < 1e-4 * rate else rate
