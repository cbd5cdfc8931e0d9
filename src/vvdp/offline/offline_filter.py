"""The event filter taken over the pieces of a record, portion by portion, onto a uniform time base.

With each piece it starts again. Between pieces the last row goes on where the wheel stands still by it.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.estimator import Estimate
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.estimation.fusion import Fusion, FusionMemory, FusionReading, fusion, fusion_start, fusion_step
from vvdp.offline.alignment import wheel_as_met
from vvdp.offline.beginning import Beginning
from vvdp.offline.config import Estimation
from vvdp.offline.cutting import Begin, Cutter, End, Follow
from vvdp.offline.edges import Edges, known_times, part
from vvdp.offline.sums import STANDING, Tally
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, edge_angle
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay

SETTLING_TURNS = 2
"""After so many turns of a piece its estimates count in means and extremes."""
LONGEST_FILL = 600.0
"""Up to so many seconds [s] without an estimate are rows of NaN; beyond, the time base jumps."""
ROWS_AT_ONCE = 200_000


class Shown(NamedTuple):
    """What is kept of each row: the estimate, and the number of the last edge, on the wheel as it was met."""

    estimate: Estimate
    edge: float


class FusedShown(NamedTuple):
    """The same of the fusion, and what it believes of the pressure's wave."""

    encoder: Shown
    pressure_phase: float
    pressure_duty_ratio: float
    pressure_duty_deviation: float
    pressure_lag: float


def tracked_step(memory: EventFilterMemory, reading: Reading, settings: EventFilter) -> tuple[EventFilterMemory, Shown]:
    """The event filter's step, showing the edge as well.

    Source  wang2017, eqs. 3.5 to 3.10, corrected: docs/errata.md
    """
    memory, estimate = event_filter_step(memory, reading, settings)
    return memory, Shown(estimate, memory.last.number)


def fused_step(memory: FusionMemory, reading: FusionReading, settings: Fusion) -> tuple[FusionMemory, FusedShown]:
    """The fusion's step, showing the edge as well.

    Source  ours, docs/models/pressure-fusion.md
    """
    memory, f = fusion_step(memory, reading, settings)
    shown = Shown(f.estimate, memory.filter.last.number)
    return memory, FusedShown(shown, f.phase, f.duty_ratio, f.duty_deviation, f.lag)


EDGE = len(Estimate._fields)
"""The column of the last edge's number; those before it are of the estimate, those after it of the pressure's wave."""
ANGLE, SPEED, ANGLE_DEVIATION, SPEED_DEVIATION, INNOVATION, INNOVATION_DEVIATION, MISSED, STANDSTILL = range(EDGE)
Memory: TypeAlias = EventFilterMemory | FusionMemory
Settings: TypeAlias = EventFilter | Fusion


class Waves(NamedTuple):
    """Edges of the inlet pressure: when they were confirmed, when they were, within which interval, and which way."""

    known: Array
    times: Array
    intervals: Array
    polarities: Array


def no_waves() -> Waves:
    """An empty record."""
    return Waves(*(np.empty(0) for _ in range(4)))


class FilteredRows(NamedTuple):
    """Rows of the uniform time base and edges, each a mapping from name to column, as `estimate_result` has them."""

    rows: dict[str, Array]
    edges: dict[str, Array]


class LastEdge(NamedTuple):
    """The last edge that was used: its time [s] and its number along the spool, and the speed since [rad/s] on
    the wheel as it is met in that direction."""

    time: float
    number: float
    speed: float
    direction: float
    standstill: float = 0.0


@dataclass
class Piece:
    """A piece of the record, followed in one direction, with the edges that were taken so far."""

    number: int
    memory: Memory | None
    direction: float
    edges: int = 0
    settled_at: float = np.inf
    missed: float = 0.0

    def add(self, times: Array, settling: int, missed: float) -> None:
        """Counts edges at these times [s], with which it has `missed` so many; it settles with number `settling`."""
        if self.edges <= settling < self.edges + times.size:
            self.settled_at = float(times[settling - self.edges])
        self.edges, self.missed = self.edges + times.size, missed


class Replayed:
    """The compiled filter over a record, with what is known of it besides its edges: gaps, and edges of the pressure.

    Backwards the filter, which only knows a wheel that turns forward, runs over the mirrored one.
    """

    def __init__(self, settings: EventFilter, fusion: Fusion | None, say: Callable[[str], None]) -> None:
        self._replay = _replay(settings, fusion, say)
        self._fused = fusion is not None
        unheard = replace(settings, stop_rate=0.0)
        self._met = {sign: _as_met(settings, fusion, sign) for sign in (1.0, -1.0)}
        self._unheard = {sign: _as_met(unheard, fusion, sign) for sign in (1.0, -1.0)}
        self.columns = len(self._replay.columns)
        self.gaps: list[tuple[float, float]] = []
        self.waves = no_waves()

    def forget(self) -> None:
        """Nothing follows on this clock."""
        self.gaps, self.waves = [], no_waves()

    def add_waves(self, waves: Waves) -> None:
        """Edges of the pressure, for what is to come."""
        self.waves = Waves(*(np.concatenate(both) for both in zip(self.waves, waves, strict=True)))

    def begin(self, cut: Begin, number: float, piece: int) -> Piece:
        """The piece of this number, with the `number` of its first edge on the wheel as it is met."""
        return begin_piece(cut, number, piece, self._met[cut.start.direction])

    def run(self, piece: Piece, edges: Edges, grid: Array) -> Array:
        """What the filter shows of these edges and then of the times `grid` [s], a row for each."""
        known, m, rows = known_times(edges), edges.times.size, readings(edges, grid, piece.direction)
        if self._fused:
            past = self.waves.known <= float(np.max(rows[:, 0], initial=-np.inf))
            ready, self.waves = (Waves(*(column[chosen] for column in self.waves)) for chosen in (past, ~past))
            rows = _with_waves(rows, ready)
        order = np.argsort(rows[:, 0], kind="stable")
        shown = np.empty((rows.shape[0], self.columns))
        for chosen, heard in _heard_parts(rows[order, 0], known, self.gaps):
            settings = (self._met if heard else self._unheard)[piece.direction]
            done = self._replay(piece.memory, rows[order[chosen]], settings)
            piece.memory, shown[order[chosen]] = done.memory, done.shown
        self.gaps = [(begin, end) for begin, end in self.gaps if not m or end > known[-1]]
        return shown[: m + grid.size]


class OfflineFilter:
    """Takes settled edges, gives rows and edges with what the filter makes of them.

    Of a wheel with an index each piece finds its direction; angles, numbers and speeds are given with their signs.
    """

    def __init__(
        self,
        settings: EventFilter,
        tally: Tally,
        sections: int,
        fusion: Fusion | None = None,
        say: Callable[[str], None] = quiet,
        direction: float = 1.0,
    ) -> None:
        self._cutter, self._replayed = Cutter(settings, tally, direction), Replayed(settings, fusion, say)
        self._settings, self._tally = settings, tally
        self._sections, self._sectors = sections, len(settings.wheel.edges)
        self._piece: Piece | None = None
        self._last: LastEdge | None = None
        self._next: int | None = None  # number of the next row
        nothing = row_columns(Piece(0, None, 1.0), np.empty(0), np.empty((0, self._replayed.columns)), sections)
        self._row = dict.fromkeys(nothing, np.nan)  # the last row
        self._covered_to: float | None = None
        self.covered = 0.0
        """Time from the first to the last edge that was used [s], summed over the clocks."""
        self.reached = -np.inf
        """The rows go so far [s]."""

    def add_pressure_edges(self, waves: Waves) -> None:
        """Edges of the pressure, for the rows to come."""
        self._replayed.add_waves(waves)
        self._cutter.waves = np.concatenate([self._cutter.waves, waves.times])

    def add_gaps(self, gaps: Iterable[tuple[float, float]]) -> None:
        """Gaps of the record, from when to when [s], for the rows to come: a silence there says nothing."""
        self._replayed.gaps.extend(gaps)

    def push(self, edges: Edges, horizon: float, *, last: bool = False) -> Iterator[FilteredRows]:
        """What can be said now that the record is known up to `horizon` [s]; `last`: nothing follows on this clock."""
        for cut in self._cutter.push(edges, horizon, last=last):
            match cut:
                case Begin():
                    first = _first_number(cut, self._last, self._sectors)
                    self._piece = self._replayed.begin(cut, first, self._tally.pieces)
                case Follow(taken, until) if self._piece is not None:
                    yield from self._rows(self._piece, taken, until)
                case End():
                    self._end()
        if last:
            self._forget()

    def stop(self) -> None:
        """Ends here, whatever was still to come."""
        self._cutter.forget()
        self._end()
        self._forget()

    def _end(self) -> None:
        self._tally.missed += self._piece.missed if self._piece is not None else 0.0
        self._piece = None

    def _forget(self) -> None:
        """Nothing follows on this clock: the next rows may lie at any time."""
        if self._last is not None:
            self._last = LastEdge(0.0, self._last.number, 0.0, self._last.direction)
        self._replayed.forget()
        self._next, self.reached, self._covered_to = None, -np.inf, None

    def _rows(self, piece: Piece, edges: Edges, until: float) -> Iterator[FilteredRows]:
        """The filter over these edges and over the rows up to `until` [s]."""
        known, rate = known_times(edges), self._tally.rate
        begin = int(np.ceil(float(known[0]) * rate - 1e-9)) if known.size else 0
        if self._next is None:
            self._next = begin
        elif piece.edges == 0 and known.size:
            silent_from = min((gap for gap, _ in self._replayed.gaps), default=np.inf)
            yield from gap_rows(range(self._next, begin), rate, self._row, silent_from)
            self._next = max(begin, self._next)
        for chosen, grid in portions(self._next, int(np.floor(until * rate + 1e-9)), known, rate):
            yield self._step(piece, part(edges, chosen), grid)
            self._next += grid.size

    def _step(self, piece: Piece, edges: Edges, grid: Array) -> FilteredRows:
        shown, m = self._replayed.run(piece, edges, grid), edges.times.size
        told = self._take_edges(piece, edges, shown[:m]) if m else {}
        named = row_columns(piece, grid, shown[m:], self._sections)
        if grid.size:
            self.reached, self._row = float(grid[-1]), {name: float(values[-1]) for name, values in named.items()}
            if self._last is not None and grid[-1] >= self._last.time:
                speed, standstill = shown[-1, [SPEED, STANDSTILL]].tolist()
                self._last = self._last._replace(speed=speed, standstill=standstill)
        return FilteredRows(named, told)

    def _take_edges(self, piece: Piece, edges: Edges, shown: Array) -> dict[str, Array]:
        first, last = float(edges.times[0]), float(edges.times[-1])
        self.covered += last - (first if self._covered_to is None else self._covered_to)
        self._covered_to = last
        found = edge_columns(piece, edges, shown, self._settings)
        self._last = LastEdge(last, piece.direction * float(shown[-1, EDGE]), float(shown[-1, SPEED]), piece.direction)
        piece.add(edges.times, SETTLING_TURNS * self._sectors, float(shown[-1, MISSED]))
        return found


def portions(first: int, last: int, known: Array, rate: float) -> Iterator[tuple[slice, Array]]:
    """The times of the rows from the `first` to the `last` [s] in portions, each with the edges that are `known` [s] by
    its end; with the last portion come all others."""
    done = 0
    while True:
        stop = min(first + ROWS_AT_ONCE, last + 1)
        grid = np.arange(first, stop) / rate
        upto = int(np.searchsorted(known, grid[-1], side="right")) if stop <= last else known.size
        yield slice(done, upto), grid
        if stop > last:
            return
        done, first = upto, stop


def begin_piece(cut: Begin, number: float, piece: int, settings: Settings) -> Piece:
    """The piece of this number, with the `number` of its first edge on the wheel as it is met by the `settings`."""
    time, speed = float(cut.first.times[0]), cut.start.alignment.speed
    wheel = settings.filter.wheel if isinstance(settings, Fusion) else settings.wheel
    angle = edge_angle(number, wheel) - 0.5 * TURN / len(wheel.edges)  # the filter takes the edge half a sector ahead
    if isinstance(settings, Fusion):
        return Piece(piece, fusion_start(settings, time, angle, speed), cut.start.direction)
    return Piece(piece, event_filter_start(settings, time, angle, speed), cut.start.direction)


def _first_number(cut: Begin, last: LastEdge | None, sectors: int) -> float:
    """The number of a piece's first edge on the wheel as it is met: on the turn that the last speed would have
    reached; where the wheel has turned back, its last edge again."""
    direction, found = cut.start
    if last is None:
        return float(found.number)
    before, same, stood = direction * last.number, direction == last.direction, last.standstill > STANDING
    polarity = direction * float(cut.first.polarities[0])
    passed = (float(cut.first.times[0]) - last.time) * (0.0 if stood else last.speed) * sectors / TURN
    expected = before + max(1.0, passed) if same else before
    if found.index_found:
        number = found.number + sectors * np.round((expected - found.number) / sectors)
        return float(number if number > before or stood or not same else number + sectors)
    number = np.round(expected)
    if polarity != 0.0 and (number % 2 == 0) != (polarity > 0.0):
        number += 1
    return float(max(number, before + 1.0) if same else number)


def readings(edges: Edges, grid: Array, direction: float) -> Array:
    """The readings of the filter: one for each edge, then one for each of the times `grid` [s]."""
    rows = np.zeros((edges.times.size + grid.size, 5))
    columns = [known_times(edges), edges.counts, edges.times, edges.intervals, direction * edges.polarities]
    rows[: edges.times.size] = np.column_stack(columns)
    rows[edges.times.size :, 0] = grid
    return rows


def _heard_parts(times: Array, known: Array, gaps: list[tuple[float, float]]) -> Iterator[tuple[slice, bool]]:
    """The rows at `times` in parts in which a silence shows something and in which it does not: within a gap of the
    record, and from there to the first edge, `known` after it."""
    done = 0
    for begin, end in gaps:
        k = int(np.searchsorted(known, end))
        first = max(done, int(np.searchsorted(times, begin, side="right")))
        last = int(np.searchsorted(times, known[k], side="right")) if k < known.size else times.size
        if last > first:
            if first > done:
                yield slice(done, first), True
            yield slice(first, last), False
            done = last
    if times.size > done:
        yield slice(done, times.size), True


def _with_waves(rows: Array, waves: Waves) -> Array:
    """Rows of the fusion: the encoder's, then those of the pressure's edges."""
    n, m = rows.shape[0], waves.known.size
    found = np.zeros((n + m, 10))
    found[:, 9] = np.nan  # no axial sensor
    found[:n, :5], found[n:, 0] = rows, waves.known
    found[n:, 5:9] = np.column_stack([np.ones(m), waves.times, waves.intervals, waves.polarities])
    return found


def gap_rows(rows: range, rate: float, last: dict[str, float], silent_from: float) -> Iterator[FilteredRows]:
    """Rows of these numbers between two pieces: the `last` one again where the wheel stands still by it, until a gap of
    the record begins, `silent_from` [s]; else NaN. Nothing where that would be very many."""
    if len(rows) / rate > LONGEST_FILL:
        return
    for start in rows[::ROWS_AT_ONCE]:
        grid = np.arange(start, min(start + ROWS_AT_ONCE, rows.stop)) / rate
        stands = (grid < silent_from) & (last["standstill"] > STANDING)
        kept = {name: np.where(stands, value, np.nan) for name, value in last.items()}
        kept |= {name: np.full(grid.size, last[name]) for name in ("piece", "standstill")}
        yield FilteredRows(kept | {"time": grid, "settled": np.zeros(grid.size)}, {})


def edge_columns(piece: Piece, edges: Edges, shown: Array, settings: EventFilter) -> dict[str, Array]:
    """The columns of edges of a piece, from what the filter has `shown` of them."""
    m, sign, sectors = edges.times.size, piece.direction, len(settings.wheel.edges)
    deviation, number = shown[:, INNOVATION_DEVIATION], sign * shown[:, EDGE]
    unused = np.where(deviation > 0.0, 0.0, np.nan)
    sector, nu = np.mod(number, sectors), sign * shown[:, INNOVATION] + unused
    angle = TURN * np.floor(number / sectors) + np.array(settings.wheel.edges)[sector.astype(int)]
    variance = edge_angle_variance(shown[:, SPEED], edges.intervals, settings)  # type: ignore[arg-type]
    return {
        "time": edges.times,
        "interval": edges.intervals,
        "piece": np.full(m, float(piece.number)),
        "number": number + unused,
        "sector": sector + unused,
        "polarity": sign * edges.polarities,
        "angle": angle + unused,
        "variance": np.asarray(variance),
        "innovation": nu,
        "innovation_deviation": deviation + unused,
        "normalised_innovation": nu / np.where(deviation > 0.0, deviation, np.nan),
        "settled": np.where(piece.edges + np.arange(m) > SETTLING_TURNS * sectors, 1.0, 0.0),
    }


def row_columns(piece: Piece, grid: Array, shown: Array, sections: int) -> dict[str, Array]:
    """The columns of rows of a piece at the times `grid` [s], from what the filter has `shown` there."""
    sign = piece.direction
    angle, speed = sign * shown[:, ANGLE], sign * shown[:, SPEED]
    found = {
        "time": grid,
        "piece": np.full(grid.size, float(piece.number)),
        "angle": angle,
        "angle_in_turn": np.mod(angle, TURN),
        "speed": speed,
        "angle_deviation": shown[:, ANGLE_DEVIATION],
        "speed_deviation": shown[:, SPEED_DEVIATION],
        "pwm_frequency": np.abs(speed) * sections / TURN,
        "standstill": shown[:, STANDSTILL],
        "settled": np.where(grid >= piece.settled_at, 1.0, 0.0),
    }
    found |= dict(zip(FusedShown._fields[1:], shown[:, EDGE + 1 :].T, strict=False))
    return found | {name: sign * values for name, values in found.items() if name == "pressure_phase"}


def filter_of(wanted: Estimation, beginning: Beginning, tally: Tally, say: Callable[[str], None]) -> OfflineFilter:
    """The filter of an estimation, with the fusion where it is asked for."""
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
    return OfflineFilter(settings, tally, wanted.sections, together, say, beginning.verdict.likeliest.direction)


def _replay(settings: EventFilter, fusion: Fusion | None, say: Callable[[str], None]) -> Replay:
    """The compiled step, with the fusion where there is one."""
    example = Reading(0.0, 0.0, 0.0, 0.0, 0.0)
    if fusion is None:
        return Replay(tracked_step, event_filter_start(settings, 0.0, 0.0, 0.0), example, settings, say=say)
    silent = dict.fromkeys(FusionReading._fields[1:], 0.0)
    return Replay(fused_step, fusion_start(fusion, 0.0, 0.0, 0.0), FusionReading(example, **silent), fusion, say=say)


def _as_met(settings: EventFilter, fusion: Fusion | None, direction: float) -> Settings:
    """The settings for the wheel as it is met in a direction."""
    wheel = wheel_as_met(settings.wheel, direction) if settings.wheel.has_index else settings.wheel
    as_met = replace(settings, wheel=wheel)
    return as_met if fusion is None else replace(fusion, filter=as_met)
