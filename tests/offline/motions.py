"""Records of a code wheel by class, each from its seed, and how far an estimate of one is from the motion.

Nothing here is shared with `vvdp.sensing`: the speed is integrated on a grid of the angle's own scale, crossings lie on
straight lines, and jitter is an angle of Gaussian size.
"""

from dataclasses import dataclass

import numpy as np

TURN = 2.0 * np.pi
STEPS = 60_000
"""Of the grid on which a motion is integrated."""
STOPPING = (150.0, 2500.0)
"""How hard a spool is braked and driven [rad/s^2]."""
SIZES = (4, 6, 8, 8, 8, 12, 16, 24, 32, 60)
"""Sectors of a wheel: that of the prototype is drawn more often."""


@dataclass
class Record:
    """Edge times [s] with the motion that made them: times [s], angles [rad], speeds [rad/s]."""

    name: str
    sectors: int
    edges: np.ndarray
    times: np.ndarray
    angles: np.ndarray
    speeds: np.ndarray
    pace: float
    order: int = 0
    breaks: tuple[float, ...] = ()
    """Times [s] in which edges do not tell how far the wheel turned."""
    traceless: bool = False
    """Whether the edges around a break may lie as if there were none."""


class Draw:
    """The random values of a record, and the parts that its motion is made of."""

    def __init__(self, seed, sectors=None, pace=None):
        self.random = np.random.default_rng([20261127, seed])
        self.sectors = sectors or int(self.random.choice(SIZES))
        self.pace = pace or float(np.exp(self.random.uniform(np.log(2.0), np.log(300.0))))
        self.pitch = TURN / self.sectors
        self.turns = float(np.clip(900.0 / self.sectors, 20.0, 80.0))
        self.duration = self.turns * TURN / self.pace
        self.times = np.linspace(0.0, self.duration, STEPS)
        self.order, self.ripple, self.phase = 0, 0.0, float(self.random.uniform(0.0, TURN))
        self.places = np.arange(self.sectors) * self.pitch
        self.jitter = self.pitch * float(np.exp(self.random.uniform(np.log(0.006), np.log(0.06))))

    def between(self, low, high):
        return float(self.random.uniform(low, high))

    def scatter_sectors(self, share=0.05):
        self.places = self.places + self.random.normal(0.0, share * self.pitch, self.sectors)

    def add_ripple(self, order, amplitude):
        self.order, self.ripple = order, amplitude

    def record(self, name, speed, damage=lambda edges: edges):
        """The record of a `speed` [rad/s] over `times`, its edges damaged."""
        t, step = self.times, self.times[1] - self.times[0]
        course = self.between(0.0, TURN) + np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * step)])
        angle, true = course, speed
        if self.order:  # the angle is the course with a wave of itself: d angle/d course = 1 + a cos(order course)
            at = self.order * course + self.phase
            angle = course + self.ripple / self.order * np.sin(at)
            true = speed * (1.0 + self.ripple * np.cos(at))
        edges = damage(crossings(t, angle, self.places, self.jitter, self.random))
        return Record(name, self.sectors, edges, t, angle, true, self.pace, self.order)


def crossings(times, angles, places, jitter, random):
    """When edges pass in either direction [s], each seen by a Gaussian `jitter` [rad] early or late."""
    n, turns = places.size, np.floor(angles / TURN)
    passed = (turns * n + np.searchsorted(places, angles - turns * TURN, side="right")).astype(int)
    found = []
    for i in np.flatnonzero(np.diff(passed)):
        low, high = int(passed[i]), int(passed[i + 1])
        ahead = high > low
        for k in range(low, high) if ahead else range(low - 1, high - 1, -1):
            place = (k // n) * TURN + places[k % n]
            rate = (angles[i + 1] - angles[i]) / (times[i + 1] - times[i])
            late = random.normal(0.0, jitter) / max(abs(rate), 1e-9)
            room = 0.3 * TURN / n / max(abs(rate), 1e-9)
            found.append(times[i] + (place - angles[i]) / rate + float(np.clip(late, -room, room)))
    return np.sort(np.array(found))


def ramp(times, begin, end, first, last):
    """From `first` to `last` on a straight line between two times."""
    return first + (last - first) * np.clip((times - begin) / max(end - begin, 1e-12), 0.0, 1.0)


def level(draw):
    return np.full(draw.times.size, draw.pace)


def constant(draw):
    return draw.record("constant", level(draw))


def uneven(draw):
    """Sectors off by 5 %, root mean square."""
    draw.scatter_sectors()
    return draw.record("uneven", level(draw))


def walk(draw):
    t, density = draw.times, draw.between(0.02, 0.3) ** 2 * draw.pace**2 / draw.duration
    steps = draw.random.normal(0.0, np.sqrt(density * (t[1] - t[0])), t.size)
    return draw.record("walk", np.fmax(draw.pace + np.cumsum(steps), 0.3 * draw.pace))


def swing(draw):
    waves = draw.between(1.0, 6.0)
    return draw.record(
        "swing", draw.pace * (1.0 + draw.between(0.02, 0.3) * np.sin(TURN * waves * draw.times / draw.duration))
    )


def step(draw):
    t, middle, factor = draw.times, 0.5 * draw.duration, draw.between(0.5, 1.6)
    lasts = abs(factor - 1.0) * draw.pace / draw.between(*STOPPING)
    return draw.record("step", draw.pace * ramp(t, middle, middle + lasts, 1.0, factor))


def start(draw):
    t, rise = draw.times, draw.pace / draw.between(*STOPPING)
    begin = draw.between(0.05, 0.15) * draw.duration
    return draw.record("start", np.where(t < begin, 0.0, draw.pace * (1.0 - np.exp(-(t - begin).clip(0.0) / rise))))


def stop(draw):
    t, a, b = draw.times, draw.between(*STOPPING), draw.between(*STOPPING)
    at, until = draw.between(0.4, 0.5) * draw.duration, draw.between(0.6, 0.7) * draw.duration
    down, up = (max(draw.pace / hard, 1.5 * draw.pitch / draw.pace) for hard in (a, b))
    return draw.record("stop", ramp(t, at, at + down, draw.pace, 0.0) + ramp(t, until, until + up, 0.0, draw.pace))


def creep(draw):
    t, at = draw.times, 0.5 * draw.duration
    return draw.record("creep", draw.pace * ramp(t, at, draw.between(0.75, 0.95) * draw.duration, 1.0, 0.0))


def reversal(draw):
    """Edges without polarity do not tell the direction: the motion is given as if the spool turned on. In which part
    of a sector it turned back leaves no trace."""
    t, at, hard = draw.times, draw.between(0.45, 0.55) * draw.duration, draw.between(*STOPPING)
    found = draw.record("reversal", ramp(t, at, at + 2.0 * draw.pace / hard, draw.pace, -draw.pace))
    found.angles = found.angles[0] + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(found.angles)))])
    found.speeds, found.breaks, found.traceless = np.abs(found.speeds), (at + draw.pace / hard,), True
    return found


def ripple(draw):
    draw.sectors = max(draw.sectors, 8)
    draw.places, draw.pitch = np.arange(draw.sectors) * TURN / draw.sectors, TURN / draw.sectors
    draw.jitter = draw.pitch * draw.between(0.004, 0.02)
    draw.add_ripple(int(draw.random.choice([3, 3, 5, 2])), abs(draw.random.normal(0.0, 0.025)) + 0.01)
    return draw.record("ripple", level(draw))


def ripple_uneven(draw):
    found = ripple_parts(draw)
    return draw.record("ripple, uneven", found)


def ripple_parts(draw):
    draw.sectors = max(draw.sectors, 8)
    draw.places, draw.pitch = np.arange(draw.sectors) * TURN / draw.sectors, TURN / draw.sectors
    draw.jitter = draw.pitch * draw.between(0.004, 0.02)
    draw.scatter_sectors()
    draw.add_ripple(3, float(draw.random.rayleigh(0.025)))
    return level(draw)


def missed(draw):
    share = float(draw.random.choice([0.02, 0.1, 0.2, 0.4]))
    return draw.record("missed", level(draw), lambda edges: edges[draw.random.random(edges.size) > share])


def double(draw):
    def damage(edges):
        again = edges[draw.random.random(edges.size) < 0.03]
        return np.sort(np.concatenate([edges, again + 0.03 * draw.pitch / draw.pace]))

    return draw.record("double", level(draw), damage)


def dropout(draw):
    begin, lasts = draw.between(0.35, 0.5) * draw.duration, draw.between(0.05, 0.25) * draw.duration
    speed = draw.pace * (1.0 + draw.between(0.0, 0.02) * np.sin(TURN * 3.0 * draw.times / draw.duration))
    found = draw.record("dropout", speed, lambda edges: edges[(edges < begin) | (edges > begin + lasts)])
    found.breaks = (begin + lasts,)  # whole turns may be lost, as the finding says
    return found


def drift(draw):
    """The clock of the log is the only one there is: the motion is given on it."""
    wrong = draw.between(-2e-3, 2e-3)
    found = draw.record("drift", level(draw))
    share = wrong / draw.duration
    found.speeds = found.speeds / (1.0 + share * found.times)
    found.edges, found.times = (times + 0.5 * share * times**2 for times in (found.edges, found.times))
    return found


def ticks(draw):
    tick = draw.between(0.02, 0.2) * draw.pitch / draw.pace
    tick = 10.0 ** np.floor(np.log10(tick))
    return draw.record("ticks", level(draw), lambda edges: np.unique(np.round(edges / tick)) * tick)


CLASSES = (constant, uneven, walk, swing, step, start, stop, creep, reversal, ripple, ripple_uneven, missed, double,
           dropout, drift)  # fmt: skip


def record_of(number):
    """Record `number` of 600: its class and its seed follow from the number."""
    return CLASSES[number % len(CLASSES)](Draw(number))


def changing(record):
    """Share of the time in which the speed is about to change by 30 % of the pace before the next edge, or did so since
    the one before: how it goes within a sector cannot be seen from the edges at both ends. A standstill is none."""
    place = np.searchsorted(record.edges, record.times)
    begins = np.flatnonzero(np.diff(place, prepend=-1))
    swing = np.fmax.reduceat(record.speeds, begins) - np.fmin.reduceat(record.speeds, begins)
    wide = np.repeat(swing > 0.3 * record.pace, np.diff(np.append(begins, place.size)))
    return float(np.mean(wide & (record.speeds > 0.0)))


@dataclass
class Score:
    """How an estimate compares: share of rows within two stated deviations, mean square of errors over these, and the
    share beyond four of them and 30 % of the speed."""

    speed_covered: float
    angle_covered: float
    speed_nees: float
    angle_nees: float
    confident: float
    speed_rms: float


def weighted_median(values, weights):
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / np.sum(weights)
    return values[order][np.searchsorted(share, 0.5)]


def score(record, rows):
    """Errors of `rows` (time, piece, angle, speed and their deviations) after the first two turns; of each piece, and
    of each side of a break, the median of the angle's error is taken off, for a wheel without an index has no zero. The
    rows that are known best settle it. The sector of a turn that leaves no trace counts only for `confident`."""
    t = rows["time"]
    begin = record.edges[min(2 * record.sectors, record.edges.size - 1)]
    used = np.isfinite(rows["speed"]) & (t > begin) & (t < record.edges[-1])
    true_speed, true_angle = (np.interp(t, record.times, each) for each in (record.speeds, record.angles))
    speed, angle = rows["speed"] - true_speed, rows["angle"] - true_angle
    parts = rows["piece"] * (1 + len(record.breaks)) + np.searchsorted(record.breaks, t)
    for part in np.unique(parts[used]):
        own = used & (parts == part)
        angle[own] -= weighted_median(angle[own], 1.0 / rows["angle_deviation"][own] ** 2)
    speed_z, angle_z = speed / rows["speed_deviation"], angle / rows["angle_deviation"]
    far = (np.abs(speed_z) > 4.0) & (np.abs(speed) > 0.3 * record.pace)
    told = used.copy()
    for time in record.breaks if record.traceless else ():
        place = int(np.searchsorted(record.edges, time))
        told &= (t < record.edges[place - 1]) | (t > record.edges[min(place, record.edges.size - 1)])
    return Score(
        float(np.mean(np.abs(speed_z[told]) < 2.0)), float(np.mean(np.abs(angle_z[told]) < 2.0)),
        float(np.mean(speed_z[told] ** 2)), float(np.mean(angle_z[told] ** 2)), float(np.mean(far[used])),
        float(np.sqrt(np.mean(speed[used] ** 2))),
    )  # fmt: skip
