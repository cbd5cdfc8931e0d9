"""Streamlines of a computed flow: OpenFOAM follows them from where the oil enters, and they are read back."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import RunError
from vvdp.cfd.dictionary import Entry
from vvdp.cfd.monitor import times
from vvdp.geometry.mesh import Floats

STREAMLINES = "streamlines"
COUNT = 48
"""Streamlines, spread over all patches by which the oil enters."""


class Streamline(NamedTuple):
    """A path along the flow: points [m] and the speed at them [m/s]."""

    points: Floats
    speed: Array


def streamline_function(inlets: Sequence[str]) -> Mapping[str, Entry]:
    """The function object that follows the flow from patches."""
    seeds: Mapping[str, Entry] = {
        "type": "patchSeed",
        "patches": tuple(inlets),
        "maxPoints": COUNT,
        "axis": "xyz",
    }
    return {
        "type": "streamLine",
        "libs": ("fieldFunctionObjects",),
        "U": "U",
        "fields": ("p", "U"),
        "setFormat": "vtk",
        "direction": "forward",
        "lifeTime": 10_000,
        "nSubCycle": 5,
        "cloud": "particleTracks",
        "seedSampleSet": seeds,
        "executeControl": "timeStep",
        "writeControl": "timeStep",
    }


def read_streamlines(case: Path) -> list[Streamline]:
    """The streamlines that were followed last, none where there are none. Raises RunError where a file is damaged."""
    written = times(case / "postProcessing" / "sets" / STREAMLINES)
    if not written:
        return []
    path = list(written.values())[-1] / "track0_U.vtk"
    try:
        return list(_tracks(path.read_text("utf-8").split("\n")))
    except (OSError, ValueError, KeyError, IndexError) as problem:
        raise RunError(f"{path} is damaged: {problem}") from None


def _tracks(lines: list[str]) -> list[Streamline]:
    """Of a file in VTK's old form: points, lists of their places, vectors at them."""
    heads = {words[0]: place for place, line in enumerate(lines) if (words := line.split())}
    at, ways, fields = heads["POINTS"], heads["LINES"], heads["U"]
    count = int(lines[at].split()[1])
    points = _numbers(lines[at + 1 : ways], 3)[:count]
    speed = np.linalg.norm(_numbers(lines[fields + 1 :], 3)[:count], axis=1)
    places = (np.array(line.split()[1:], int) for line in lines[ways + 1 : heads["POINT_DATA"]] if line.strip())
    return [Streamline(points[each], speed[each]) for each in places if len(each) > 1]


def _numbers(lines: list[str], width: int) -> Floats:
    return np.array(" ".join(lines).split(), float).reshape(-1, width)
