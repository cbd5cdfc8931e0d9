"""Silences in which the sensor was lost while the spool turned on, and what the rows have in them.

Derived in docs/logs.md, "Standstill or lost sensor".

Source  ours, docs/logs.md, where a function names no other.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.beginning import PACE
from vvdp.offline.estimate_result import portions
from vvdp.sensing.wheel import TURN

SEEN = 8
"""So many times between edges, before a silence and after it, say whether the spool slowed down or sped up."""
NEAR = 2
"""The speed at the silence is that over so many of them; noise makes less of a difference then."""
SLOWER = 0.8
"""A spool that comes to a stop, or starts, is slower there than this share of the speed further away; assumed."""
SPOOL_TIME = 0.028
"""Inertia over viscous torque of a spool [s]: at the speed w drive and friction change it by w/SPOOL_TIME. Those of a
slower spool than usual are as strong as of one at `PACE`."""
PRIOR = -1.0
"""Logarithm of the odds that a sensor is lost against a stop and a start of which nothing shows; assumed."""
WANDERS = 0.03
"""By so much of itself the speed is taken to wander in the middle of a silence [1]; assumed."""
UNLIKELY = 0.05
"""Probability below which a silence is a stop, and nothing else is calculated with [1]."""
RENUMBERED = 17
"""Within so many edges after a silence the filter may find the turns itself: `estimation.doubt`."""
LONG = 3.0
"""A silence lasts longer than so many times between the edges before it."""


class Silence(NamedTuple):
    """From one edge to the next: times [s], the angle at which it begins [rad], speeds at both ends [rad/s] with their
    sign, their standard error [rad/s], the piece of the record, and the probability that the sensor was lost [1]."""

    begin: float
    end: float
    angle: float
    before: float
    after: float
    error: float
    piece: float
    lost: float
    turns: float
    """Whole turns by which the angles after it lie further on than they were numbered ..."""
    until: float
    """... up to this time [s]; there the filter has found them itself."""

    @property
    def is_lost(self) -> bool:
        """Whether the sensor was lost rather than the spool stood."""
        return self.lost > 0.5

    @property
    def travel(self) -> float:
        """The angle through which a spool turns in it whose speed changes evenly [rad]."""
        return 0.5 * (self.before + self.after) * (self.end - self.begin)


def lost_probability(before: Array, after: Array, pitch: float, hardest: float | None = None) -> float:
    """Probability that the sensor was lost in a silence and the spool did not stand [1].

    before, after  speeds from edge to edge, the nearest to the silence first [rad/s]
    pitch          angle of a sector, in which a stop or a start would have to happen [rad]
    hardest        standard deviation of what drive and friction can do [rad/s^2]; None: the speed, or `PACE` if that
                   is more, over `SPOOL_TIME`

    To stand within a sector takes a = w^2/(2 pitch). Where the speed changes towards the silence it is a stop. The
    logarithm of the odds is PRIOR + sum of (a/hardest)^2/2 over both ends.
    """
    odds = PRIOR
    for speeds in (np.abs(before), np.abs(after)):
        usual = float(np.median(speeds[:SEEN]))
        near = min(float(np.mean(speeds[:NEAR])), usual)  # edges that are numbered again later make a jump
        if not near > SLOWER * usual:
            return 0.0
        possible = max(near, PACE) / SPOOL_TIME if hardest is None else hardest
        odds += 0.5 * (near * near / (2.0 * pitch) / possible) ** 2
    return float(1.0 / (1.0 + np.exp(-min(odds, 700.0))))


def silences(
    file: Any, standstills: Sequence[tuple[float, float]], sectors: int, hardest: float | None
) -> tuple[Silence, ...]:
    """The silences of an open result.h5 in which a sensor may have been lost: those with one of the `standstills` in
    them, from when to when [s]."""
    found: list[Silence] = []
    if not standstills:
        return ()
    begins = np.sort(np.array([begin for begin, _ in standstills]))
    for time, angle, piece, first, last in _edge_portions(file):
        steps = np.diff(time)
        for i in np.flatnonzero(steps[1:] > LONG * steps[:-1]) + 1:
            stands = np.searchsorted(begins, time[i]) < np.searchsorted(begins, time[i + 1])
            if first <= i < last and stands:
                each = _silence(time, angle, piece, int(i), TURN / sectors, hardest)
                found += [each] if each is not None else []
    return tuple(found)


def _edge_portions(file: Any) -> Iterator[tuple[Array, Array, Array, int, int]]:
    """Times, angles and pieces of the edges that were used, with some of the portions beside; the first at which a
    silence may begin, and the one after the last."""
    kept: list[Array] = [np.empty(0) for _ in range(3)]
    done = 0
    for columns in (*portions(file, "edges/", "time", "angle", "piece"), None):
        if columns is not None:
            used = np.isfinite(columns[1])
            kept = [np.concatenate([old, new[used]]) for old, new in zip(kept, columns, strict=True)]
        last = kept[0].size - 1 - (RENUMBERED + 1 if columns is not None else 0)
        if last > done:
            time, angle, piece = kept
            yield time, angle, piece, done, last
            cut = max(last - SEEN - 1, 0)
            kept, done = [each[cut:] for each in kept], last - cut


def _silence(time: Array, angle: Array, piece: Array, i: int, pitch: float, hardest: float | None) -> Silence | None:
    """The silence after edge `i`; None where a stop is all that is calculated with."""
    sides = slice(max(i - SEEN, 0), i + 1), slice(i + 1, i + 2 + SEEN)
    earlier, later = (_speeds(time[side], angle[side]) for side in sides)
    speeds = (earlier[::-1], later)
    begin, end = float(time[i]), float(time[i + 1])
    if min(each.size for each in speeds) < NEAR or not end > begin:
        return None
    before, after = (float(np.median(each)) for each in speeds)
    lost = lost_probability(earlier[::-1], later, pitch, hardest) if before * after > 0.0 else 0.0
    if lost < UNLIKELY:
        return None
    error = float(np.sqrt(sum(np.var(each) / each.size for each in speeds)))
    found = Silence(
        begin=begin,
        end=end,
        angle=float(angle[i]),
        before=before,
        after=after,
        error=error,
        piece=float(piece[i]),
        lost=lost,
        turns=0.0,
        until=np.inf,
    )
    known = np.arange(i + 1, min(i + 2 + RENUMBERED, time.size))
    ahead = found.angle + found.travel + after * (time[known] - end) - angle[known]
    turns: Array = np.round(ahead / TURN) * float(found.is_lost)
    right = (turns == 0.0) & (piece[known] == found.piece) & bool(turns[0])
    until = float(time[known][right][0]) if np.any(right) else np.inf
    return found._replace(turns=float(turns[0]), until=until)


def _speeds(time: Array, angle: Array) -> Array:
    """Speeds from edge to edge [rad/s], without those of edges at one instant."""
    steps = np.diff(time)
    usable = steps > 0.0
    found: Array = np.diff(angle)[usable] / steps[usable]
    return found


def settle_silences(file: Any, found: Sequence[Silence], sections: int, sectors: int) -> None:
    """Writes into an open result.h5 what is known of these silences, and moves the angles after them."""
    if not found:
        return
    _shift(file, "edges/", found, {"angle": TURN, "number": float(sectors)})
    _shift(file, "", found, {"angle": TURN})
    moved = 0.0
    for each in found:
        end = each.until if np.isfinite(each.until) else each.end
        _write_rows(file, each._replace(angle=each.angle + moved, end=end), sections)
        moved += TURN * each.turns if np.isinf(each.until) else 0.0


def _shift(file: Any, group: str, found: Sequence[Silence], scales: dict[str, float]) -> None:
    first = 0
    for time, piece in portions(file, group, "time", "piece"):
        turns = sum(
            each.turns
            * (
                ((piece > each.piece) & np.isinf(each.until))
                | ((piece == each.piece) & (time >= each.end) & (time < each.until))
            )
            for each in found
        )
        if np.any(turns):
            for name, scale in scales.items():
                file[f"{group}{name}"][first : first + time.size] += scale * turns
        first += time.size


def _write_rows(file: Any, silence: Silence, sections: int) -> None:
    first, s = 0, silence
    for time, piece in portions(file, "", "time", "piece"):
        inside = np.flatnonzero((piece == s.piece) & (time > s.begin) & (time < s.end))
        if inside.size:
            rows = slice(first + int(inside[0]), first + int(inside[-1]) + 1)
            old = {name: file[name][rows] for name in _CHANGED}
            for name, column in settled_rows(file["time"][rows], old, s, sections).items():
                file[name][rows] = column
        first += time.size


_CHANGED = ("angle", "angle_in_turn", "speed", "angle_deviation", "speed_deviation", "pwm_frequency", "standstill")


def settled_rows(time: Array, rows: dict[str, Array], silence: Silence, sections: int) -> dict[str, Array]:
    """The `rows` at these times [s] in a silence: the course of a spool that turned on where the sensor was lost; of
    both the deviations have what the other would make. Rows without an estimate stay so.

    The speed goes evenly from one end to the other and wanders between, WANDERS 2 sqrt(u (1 - u)) of itself, u the
    share of the silence that has passed.
    """
    s = silence
    passed = time - s.begin
    u = passed / (s.end - s.begin)
    speed = s.before + (s.after - s.before) * u
    travel = passed * 0.5 * (s.before + speed)
    wander = WANDERS * np.abs(speed)
    own = wander * wander * 4.0 * u * (1.0 - u) + s.error**2
    off = travel * travel * (WANDERS**2 / 3.0)
    if not s.is_lost:
        wide = {"speed_deviation": s.lost * (own + speed * speed), "angle_deviation": s.lost * (off + travel * travel)}
        return {name: np.sqrt(rows[name] ** 2 + more) for name, more in wide.items()}
    angle, known = s.angle + travel, np.where(np.isfinite(rows["angle"]), 0.0, np.nan)
    changed = {
        "angle": angle,
        "angle_in_turn": np.mod(angle, TURN),
        "speed": speed,
        "angle_deviation": np.sqrt(off + (1.0 - s.lost) * travel * travel),
        "speed_deviation": np.sqrt(own + (1.0 - s.lost) * speed * speed),
        "pwm_frequency": np.abs(speed) * sections / TURN,
        "standstill": np.full(time.size, 1.0 - s.lost),
    }
    return {name: column + known for name, column in changed.items()}
