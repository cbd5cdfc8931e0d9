"""Records of a code wheel made by hand, and what an estimation makes of them.

Nothing here is shared with `vvdp.sensing`: the motion is integrated on a fine grid, crossings lie on straight lines.
"""

import h5py
import numpy as np

from vvdp.results.result import json_value
from vvdp.results.store import finite, read_result

TURN = 2.0 * np.pi


class Motion:
    """Angle [rad] over time [s] of a spool whose speed [rad/s] is a function of time."""

    def __init__(self, speed, until, start=0.3, step=2e-5):
        self.times = np.arange(0.0, until, step)
        self.speeds = np.broadcast_to(np.asarray(speed(self.times), float), self.times.shape)
        self.angles = start + np.concatenate([[0.0], np.cumsum(0.5 * (self.speeds[1:] + self.speeds[:-1]) * step)])

    def angle_at(self, times):
        return np.interp(times, self.times, self.angles)

    def speed_at(self, times):
        return np.interp(times, self.times, self.speeds)


def even_edges(sectors, moved=None, shift=0.0):
    """Angles of the edges of a wheel, bright from edge 0 to edge 1, with edge `moved` off by `shift` sectors."""
    places = [TURN / sectors * i for i in range(sectors)]
    if moved is not None:
        places[moved] += shift * TURN / sectors
    return np.array(places)


def crossings(motion, edges):
    """When edges pass, and whether the light goes on (1) or off (-1), in either direction."""
    n, angles, times = len(edges), motion.angles, motion.times
    turns = np.floor(angles / TURN)
    passed = (turns * n + np.searchsorted(edges, angles - turns * TURN, side="right")).astype(int)
    found, signs = [], []
    for i in np.flatnonzero(np.diff(passed)):
        low, high = passed[i], passed[i + 1]
        for k in range(low, high) if high > low else range(low - 1, high - 1, -1):
            place = (k // n) * TURN + edges[k % n]
            share = (place - angles[i]) / (angles[i + 1] - angles[i])
            found.append(times[i] + share * (times[i + 1] - times[i]))
            signs.append((1 if k % 2 == 0 else -1) * (1 if high > low else -1))
    return np.array(found), np.array(signs)


def wave_of(angles, edges, ramp=0.3):
    """The voltage of a photodiode, 0 to 1, with straight ramps `ramp` [rad] wide about each edge."""
    away = np.mod(angles[:, None] - edges + np.pi, TURN) - np.pi
    near = np.argmin(np.abs(away), axis=1)
    sign = np.where(near % 2 == 0, 1.0, -1.0)
    return np.clip(0.5 + sign * away[np.arange(angles.size), near] / ramp, 0.0, 1.0)


def counted(motion, edges, rate):
    """The channels of a counter of all edges that is read at a rate [Hz]."""
    passed, _ = crossings(motion, edges)
    t = np.arange(0.0, motion.times[-1], 1.0 / rate)
    return {"time": (t, "s"), "n": (np.searchsorted(passed, t, side="right").astype(float), "")}


class Kept:
    """What an estimation has left in a directory."""

    def __init__(self, directory):
        self.directory, self.result = directory, read_result(directory)
        known = {key: json_value(each) for key, each in self.result.numbers.items()}
        self.summary = finite(known) | {"finished": self.result.finished}
        self.config = (directory / "estimate.toml").read_text("utf-8")
        self.findings = [finding for finding in self.result.findings if finding.title]

    def column(self, name):
        with h5py.File(self.directory / "result.h5") as file:
            return file[name][:]

    def size(self, name):
        return self.column(name).size

    def has(self, name):
        with h5py.File(self.directory / "result.h5") as file:
            return name in file


def titles(kept):
    return {finding.title for finding in kept.findings}
