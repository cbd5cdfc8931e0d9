"""The event filter taken over the edges of a record, portion by portion, onto a uniform time base.

The record is cut where nothing could be said across a gap: where the prediction would be uncertain by half a sector,
and not within three of the times that edges usually take there. What is usual is judged from the edges before the gap,
at the beginning of a piece also from those after it. After a cut the filter starts anew.
"""

from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.estimation.fusion import Fusion, FusionMemory, fusion_start
from vvdp.offline.alignment import Alignment, edges_needed, start, wheel_as_met
from vvdp.offline.bridging import RECENT, longest_bridged, usual_before
from vvdp.offline.edges import Chosen, Edges, join, known_times, no_edges, part
from vvdp.offline.filter_steps import EDGE, SPEED, STANDSTILL, replay_of
from vvdp.offline.passages import SEEN_AFTER, SEEN_BEFORE, slow_passages
from vvdp.sensing.wheel import TURN, edge_angle
from vvdp.simulation.link import quiet

SETTLING_TURNS = 2
"""After so many turns of a piece its estimates count in means and extremes."""
LONGEST_FILL = 600.0
"""Up to so many seconds [s] without an estimate are rows of NaN; beyond, the time base jumps."""
ROWS_AT_ONCE = 200_000
FEWEST_EDGES = 3
"""A piece of fewer edges is left out."""
EDGES_AT_ONCE = 20_000
MOST_ROWS = 2.0**52
"""The times of later rows could not be told apart."""
NAMED_TIMES = 5


class Waves(NamedTuple):
    """Edges of the inlet pressure: when they were confirmed, when they were, within which interval, and which way."""

    known: Array
    times: Array
    intervals: Array
    polarities: Array


def no_waves() -> Waves:
    """An empty record."""
    return Waves(*(np.empty(0) for _ in range(4)))


FUSED_COLUMNS = ("pressure_phase", "pressure_duty_ratio", "pressure_duty_deviation", "pressure_lag")
"""What a fused row has besides."""


class FilteredRows(NamedTuple):
    """Rows of the uniform time base and edges, each a mapping from name to column, as `kept` describes them."""

    rows: dict[str, Array]
    edges: dict[str, Array]
    settled: Chosen
    """Of each row, whether it counts."""


class LastEdge(NamedTuple):
    """The last edge that was used: its time [s] and its number along the spool, and the speed since [rad/s]."""

    time: float
    number: float
    speed: float
    standstill: float = 0.0


@dataclass
class _Piece:
    memory: EventFilterMemory | FusionMemory
    direction: float
    edges: int = 0
    settled_at: float = np.inf
    missed: float = 0.0


class OfflineFilter:
    """Takes settled edges, gives rows and edges with what the filter makes of them.

    Of a wheel with an index each piece finds its direction; backwards the filter, which only knows a wheel that turns
    forward, runs over the mirrored one, and angles, numbers and speeds are given with their signs.
    """

    def __init__(
        self,
        settings: EventFilter,
        rate: float,
        sections: int,
        fusion: Fusion | None = None,
        say: Callable[[str], None] = quiet,
        direction: float = 1.0,
    ) -> None:
        self._replay = replay_of(settings, fusion, say)
        self._fusion, self._waves = fusion, no_waves()
        self._met = {sign: _met_settings(settings, fusion, sign) for sign in (1.0, -1.0)}
        unheard = replace(settings, stop_rate=0.0)
        self._unheard = {sign: _met_settings(unheard, fusion, sign) for sign in (1.0, -1.0)}
        self._gaps: list[tuple[float, float]] = []
        self._filter, self.rate, self._sections = settings, rate, sections
        self._direction = direction
        self._sectors = len(settings.wheel.edges)
        self._wanted = max(edges_needed(settings.wheel), 2 * SEEN_AFTER)  # edges that tell how a piece begins
        self._pending = no_edges()
        self._piece: _Piece | None = None
        self._steps = np.empty(0)
        self._last: LastEdge | None = None
        self._history = np.empty(0)  # the last times of edges of the piece
        self._looked_past = -np.inf  # slow passages up to here are done with
        self.slow_passages: list[float] = []
        """When the wheel nearly stood still, and did not turn back as far as is known [s]."""
        self.reversals: list[float] = []
        """When it turned back [s]."""
        self._next: int | None = None  # number of the next row
        self.pieces = 0
        nothing = self._by_name(np.zeros(1), np.full((1, len(self._replay.columns)), np.nan))
        self._row = {name: float(values[0]) for name, values in nothing.items()}  # the last row
        self.left_out = 0
        """Edges of pieces that were too short."""
        self.left_out_times: list[float] = []
        """When the first of them were [s]."""
        self.covered = 0.0
        """Time from the first to the last edge that was used [s], summed over the clocks."""
        self._covered_to: float | None = None
        self.missed_edges = 0.0
        self.alignments: list[Alignment] = []
        self.longest_bridged = 0.0
        self.reached = -np.inf
        """The rows go so far [s]."""

    def add_pressure_edges(self, waves: Waves) -> None:
        """Edges of the pressure, for the rows to come."""
        self._waves = Waves(*(np.concatenate(both) for both in zip(self._waves, waves, strict=True)))

    def add_gaps(self, gaps: Iterable[tuple[float, float]]) -> None:
        """Gaps of the record, from when to when [s], for the rows to come: a silence there says nothing."""
        self._gaps.extend(gaps)

    def push(self, edges: Edges, horizon: float, *, last: bool = False) -> Iterator[FilteredRows]:
        """What can be said now that the record is known up to `horizon` [s]; `last`: nothing follows on this clock."""
        self._pending = join([self._pending, edges])
        while self._pending.times.size:
            if not (yield from self._segment(last)):
                return  # a piece begins, but too little of it is known yet
        if self._piece is not None and self._last is not None:
            yield from self._rows(no_edges(), min(horizon, self._lasting()))
        if last:
            self._end(forget=True)

    def stop(self) -> None:
        """Ends here, whatever was still to come."""
        self._pending = no_edges()
        self._end(forget=True)

    def _can_bridge(self, times: Array) -> Chosen:
        """Of each of the next edges, whether the time since the edge before it can be bridged."""
        before = self._last.time if self._piece is not None and self._last is not None else float(times[0])
        steps = np.diff(times, prepend=before)
        if self._piece is None:  # the first edge of a piece has nothing before it
            limits = np.concatenate([[np.inf], longest_bridged(usual_before(steps[1:]), steps[1:], self._filter)])
        else:
            usual = usual_before(np.concatenate([self._steps, steps]))[self._steps.size :]
            limits = longest_bridged(usual, steps, self._filter)
        found: Chosen = steps <= limits
        if self._fusion is not None:
            for i in np.flatnonzero(~found):
                heard = self._waves.times[(self._waves.times < times[i]) & (self._waves.times > times[i] - steps[i])]
                between = np.diff(np.concatenate([[times[i] - steps[i]], heard, [times[i]]]))
                found[i] = bool(np.all(between <= limits[i]))
        return found

    def _segment(self, last: bool) -> Generator[FilteredRows, None, bool]:
        """Takes in the pending edges up to the next cut; false where more have to be known first."""
        wanted = self._wanted
        looked_at = self._pending.times[: max(EDGES_AT_ONCE, wanted)]
        cuts = np.flatnonzero(~self._can_bridge(looked_at))
        end = int(cuts[0]) if cuts.size else looked_at.size
        if self._piece is None:
            if end < wanted and not cuts.size and not last:
                return False
            first, final = float(looked_at[0]), float(looked_at[end - 1])
            if end < FEWEST_EDGES or not final > first or abs(final) * self.rate > MOST_ROWS:
                self.left_out += end
                self.left_out_times = [*self.left_out_times, *looked_at[:end].tolist()][:NAMED_TIMES]
                self._pending = part(self._pending, slice(end, None))
                return True
            self._begin(part(self._pending, slice(0, min(end, wanted))))
            before = first
        else:
            assert self._last is not None
            before = self._last.time
        whole = bool(cuts.size) or (last and looked_at.size == self._pending.times.size)
        known, turned = self._until_turn(end, whole)
        if known:
            yield from self._take(part(self._pending, slice(0, known)), before)
            self._pending = part(self._pending, slice(known, None))
        if turned or (cuts.size and known == end):
            yield from self._rows(no_edges(), min(self._lasting(), float(self._pending.times[0])))
            self._end(forget=False)
        return turned or known > 0

    def _take(self, taken: Edges, before: float) -> Iterator[FilteredRows]:
        """Edges of a piece, with the rows up to the last of them; `before` is the time of the edge before them [s]."""
        steps = np.diff(taken.times, prepend=before)[0 if self._steps.size else 1 :]
        self.longest_bridged = max(self.longest_bridged, float(np.max(steps, initial=0.0)))
        self._steps = np.concatenate([self._steps, steps])[-RECENT:]
        self._history = np.concatenate([self._history, taken.times])[-SEEN_BEFORE - 1 :]
        yield from self._rows(taken, float(known_times(taken)[-1]))

    def _until_turn(self, end: int, whole: bool) -> tuple[int, bool]:
        """How many of the pending edges, up to `end`, go on as before, as far as is known, and whether the wheel turns
        back then; `whole`: the piece has no more of them."""
        assert self._piece is not None
        times, wanted = self._pending.times[:end], self._wanted
        seen = np.concatenate([self._history, times])
        for step in slow_passages(np.diff(seen)):
            i = step + 1 - self._history.size
            if i < 0 or times[i] <= self._looked_past:
                continue
            if end - i < wanted and not whole:
                return i, False
            self._looked_past = float(times[i])
            after = part(self._pending, slice(i, min(i + wanted, end)))
            if start(after, self._filter.wheel, self._piece.direction).direction != self._piece.direction:
                self.reversals.append(float(0.5 * (seen[step] + seen[step + 1])))
                return i, True
            self.slow_passages.append(float(0.5 * (seen[step] + seen[step + 1])))
        return (end if whole else max(end - SEEN_AFTER, 0)), False

    def _begin(self, first: Edges) -> None:
        direction, found = start(first, self._filter.wheel, self._direction)
        self.alignments.append(found)
        settings = self._met[direction]
        met_filter = settings.filter if isinstance(settings, Fusion) else settings
        number = self._continue_count(found, direction, float(first.times[0]), direction * float(first.polarities[0]))
        half = 0.5 * TURN / self._sectors
        angle = edge_angle(number, met_filter.wheel) - half  # the filter takes the edge half a sector ahead
        time = float(first.times[0])
        memory = (
            fusion_start(settings, time, angle, found.speed)
            if isinstance(settings, Fusion)
            else event_filter_start(settings, time, angle, found.speed)
        )
        self._piece = _Piece(memory, direction)
        self._direction, self._history = direction, np.empty(0)
        self.pieces += 1

    def _continue_count(self, found: Alignment, direction: float, time: float, polarity: float) -> float:
        """The number of a piece's first edge on the wheel as it is met: on the turn that the last speed would have
        reached; where the wheel has turned back, its last edge again."""
        if self._last is None:
            return float(found.number)
        n, same, before = self._sectors, direction == self._direction, direction * self._last.number
        stood = self._last.standstill > 0.5
        pace = 0.0 if stood else self._last.speed
        expected = before + max(1.0, (time - self._last.time) * pace * n / TURN) if same else before
        if found.index_found:
            number = found.number + n * np.round((expected - found.number) / n)
            return float(number if number > before or stood or not same else number + n)
        number = np.round(expected)
        if polarity != 0.0 and (number % 2 == 0) != (polarity > 0.0):
            number += 1
        return float(max(number, before + 1.0) if same else number)

    def _end(self, *, forget: bool) -> None:
        """Closes a piece; with `forget` also its clock, and the next piece may lie at any time."""
        if self._piece is not None:
            self.missed_edges += self._piece.missed
        self._piece = None
        self._steps = np.empty(0)
        if forget:
            if self._last is not None:
                self._last = LastEdge(0.0, self._last.number, 0.0)
            self._looked_past, self._gaps = -np.inf, []
            self._next, self.reached, self._covered_to = None, -np.inf, None
            self._waves = no_waves()

    def _lasting(self) -> float:
        """Until when rows can be given without another edge [s]."""
        assert self._last is not None
        end, reach = self._last.time, self._reach()
        if self._fusion is not None:
            for time in self._waves.times[self._waves.times > end].tolist():
                if time > end + reach:
                    break
                end = time
        return end + reach

    def _reach(self) -> float:
        """How long after the last edge the filter is still followed [s]."""
        if not self._steps.size:
            return 0.0
        return float(longest_bridged(usual_before(self._steps)[-1:], np.array([np.inf]), self._filter)[0])

    def _rows(self, edges: Edges, until: float) -> Iterator[FilteredRows]:
        """The filter over these edges and over the rows up to `until` [s]."""
        piece = self._piece
        assert piece is not None
        known = known_times(edges)
        if self._next is None:
            self._next = int(np.ceil(float(known[0]) * self.rate - 1e-9)) if known.size else 0
        elif piece.edges == 0 and known.size:
            yield from self._gap_rows(float(known[0]))
        end, done = int(np.floor(until * self.rate + 1e-9)), 0
        while True:
            stop = min(self._next + ROWS_AT_ONCE, end + 1)
            grid = np.arange(self._next, stop) / self.rate
            upto = int(np.searchsorted(known, grid[-1], side="right")) if stop <= end else known.size
            yield self._step(piece, part(edges, slice(done, upto)), grid)
            done, self._next = upto, max(stop, self._next)
            if stop > end:
                return

    def _gap_rows(self, time: float) -> Iterator[FilteredRows]:
        """Rows up to `time`, between two pieces: the last one again where the wheel stands still by it and the record
        has no gap, else NaN; nothing where that would be very many."""
        assert self._next is not None
        begin = int(np.ceil(time * self.rate - 1e-9))
        if (begin - self._next) / self.rate <= LONGEST_FILL:
            for start in range(self._next, begin, ROWS_AT_ONCE):
                grid = np.arange(start, min(start + ROWS_AT_ONCE, begin)) / self.rate
                stands = self._stands(grid)
                rows = {name: np.where(stands, value, np.nan) for name, value in self._row.items()}
                rows |= {name: np.full(grid.size, self._row[name]) for name in ("piece", "standstill")} | {"time": grid}
                yield FilteredRows(rows, self._no_edges(), np.zeros(grid.size, bool))
        self._next = max(begin, self._next)

    def _stands(self, grid: Array) -> Chosen:
        """At which of the times of rows after the last one the wheel stands still, as far as is known."""
        first = min((begin for begin, _ in self._gaps), default=np.inf)
        found: Chosen = (grid < first) & bool(self._row["standstill"] > 0.5)
        return found

    def _step(self, piece: _Piece, edges: Edges, grid: Array) -> FilteredRows:
        known = known_times(edges)
        m = known.size
        rows = np.zeros((m + grid.size, 5))
        polarities = piece.direction * edges.polarities
        rows[:m] = np.column_stack([known, edges.counts, edges.times, edges.intervals, polarities])
        rows[m:, 0] = grid
        if self._fusion is not None:
            rows = self._with_waves(rows)
        order = np.argsort(rows[:, 0], kind="stable")
        shown = np.empty((rows.shape[0], len(self._replay.columns)))
        for part_of_rows, heard in self._heard_parts(rows[order, 0], known):
            settings = (self._met if heard else self._unheard)[piece.direction]
            done = self._replay(piece.memory, rows[order[part_of_rows]], settings)
            piece.memory = done.memory
            shown[order[part_of_rows]] = done.shown
        columns = self._of_edges(piece, edges, shown[:m]) if m else self._no_edges()
        named = self._by_name(grid, shown[m : m + grid.size])
        if grid.size:
            self.reached, self._row = float(grid[-1]), {name: float(values[-1]) for name, values in named.items()}
            if self._last is not None and grid[-1] >= self._last.time:
                speed, standstill = shown[m + grid.size - 1, [SPEED, STANDSTILL]].tolist()
                self._last = self._last._replace(speed=speed, standstill=standstill)
        settled = grid >= piece.settled_at
        return FilteredRows(named, columns, settled)

    def _heard_parts(self, times: Array, known: Array) -> Iterator[tuple[slice, bool]]:
        """The rows at `times` in parts in which a silence tells something and in which it does not: within a gap of the
        record, and from there to the first edge, `known` after it."""
        done, open_gaps = 0, []
        for begin, end in self._gaps:
            k = int(np.searchsorted(known, end))
            first = max(done, int(np.searchsorted(times, begin, side="right")))
            last = int(np.searchsorted(times, known[k], side="right")) if k < known.size else times.size
            if k == known.size:
                open_gaps.append((begin, end))
            if last > first:
                if first > done:
                    yield slice(done, first), True
                yield slice(first, last), False
                done = last
        self._gaps = open_gaps
        if times.size > done:
            yield slice(done, times.size), True

    def _with_waves(self, rows: Array) -> Array:
        """Rows of the fusion: the encoder's, then those of the pressure's edges up to the last of them."""
        until = float(np.max(rows[:, 0], initial=-np.inf))
        heard = self._waves.known <= until
        ready, self._waves = (Waves(*(column[chosen] for column in self._waves)) for chosen in (heard, ~heard))
        found = np.zeros((rows.shape[0] + ready.known.size, 10))
        found[:, 9] = np.nan  # no axial sensor
        found[: rows.shape[0], :5] = rows
        found[rows.shape[0] :, 0] = ready.known
        ones = np.ones(ready.known.size)
        found[rows.shape[0] :, 5:9] = np.column_stack([ones, ready.times, ready.intervals, ready.polarities])
        return found

    def _of_edges(self, piece: _Piece, edges: Edges, shown: Array) -> dict[str, Array]:
        m, sign = edges.times.size, piece.direction
        speed, nu, deviation, number = shown[:, SPEED], sign * shown[:, 4], shown[:, 5], sign * shown[:, EDGE]
        used = deviation > 0.0
        place = piece.edges + np.arange(m)
        settling = SETTLING_TURNS * self._sectors
        if piece.edges <= settling < piece.edges + m:
            piece.settled_at = float(edges.times[settling - piece.edges])
        piece.edges += m
        piece.missed = float(shown[-1, 6])
        before = float(edges.times[0]) if self._covered_to is None else self._covered_to
        self.covered += float(edges.times[-1]) - before
        self._covered_to = float(edges.times[-1])
        self._last = LastEdge(float(edges.times[-1]), float(number[-1]), float(speed[-1]))
        sector = np.mod(number, self._sectors)
        angle = TURN * np.floor(number / self._sectors) + np.array(self._filter.wheel.edges)[sector.astype(int)]
        variance = edge_angle_variance(speed, edges.intervals, self._filter)  # type: ignore[arg-type]
        nothing = np.where(used, 0.0, np.nan)
        return {
            "time": edges.times,
            "interval": edges.intervals,
            "piece": np.full(m, float(self.pieces)),
            "number": number + nothing,
            "sector": sector + nothing,
            "polarity": sign * edges.polarities,
            "angle": angle + nothing,
            "variance": np.asarray(variance),
            "innovation": nu + nothing,
            "innovation_deviation": deviation + nothing,
            "normalised_innovation": nu / np.where(used, deviation, np.nan),
            "settled": np.where(place > settling, 1.0, 0.0),
        }

    def _no_edges(self) -> dict[str, Array]:
        return {}

    def _by_name(self, grid: Array, shown: Array) -> dict[str, Array]:
        sign = self._direction
        angle, speed = sign * shown[:, 0], sign * shown[:, SPEED]
        more = {} if self._fusion is None else dict(zip(FUSED_COLUMNS, shown[:, EDGE + 1 :].T, strict=True))
        if more:
            more["pressure_phase"] = sign * more["pressure_phase"]
        return more | {
            "time": grid,
            "piece": np.full(grid.size, float(self.pieces)),
            "angle": angle,
            "angle_in_turn": np.mod(angle, TURN),
            "speed": speed,
            "angle_deviation": shown[:, 2],
            "speed_deviation": shown[:, 3],
            "pwm_frequency": np.abs(speed) * self._sections / TURN,
            "standstill": shown[:, STANDSTILL],
        }


def _met_settings(settings: EventFilter, fusion: Fusion | None, direction: float) -> EventFilter | Fusion:
    """The settings for the wheel as it is met in a direction."""
    wheel = wheel_as_met(settings.wheel, direction) if settings.wheel.has_index else settings.wheel
    as_met = replace(settings, wheel=wheel)
    return as_met if fusion is None else replace(fusion, filter=as_met)
