"""The call of the compiled loop as a page makes it: its arguments in order, and what its arrays begin with."""

import base64
import inspect
from collections.abc import Mapping
from dataclasses import fields
from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

from vvdp.generator.kinds import FLOAT, Kind, Record, Row
from vvdp.simulation import loop, places
from vvdp.simulation.layout import mode_paths
from vvdp.simulation.prepare import Prepared, start_run
from vvdp.simulation.run import why_not_on
from vvdp.simulation.stepping import Stepping
from vvdp.simulation.values import leaves
from vvdp.systems.system import System

FUNCTIONS = 4
"""Arguments of the loop that a module knows by itself: those that are functions."""


def pack_array(numbers: npt.NDArray[Any]) -> dict[str, Any]:
    """An array as JSON has it: its shape, and its numbers of 8 bytes each; no bytes where all are zero."""
    kind = "i8" if numbers.dtype.kind == "i" else "f8"
    content = np.ascontiguousarray(numbers, f"<{kind}").tobytes()
    if not any(content):
        content = b""
    return {"kind": kind, "shape": list(numbers.shape), "bytes": base64.b64encode(content).decode()}


def arguments() -> list[dict[str, Any]]:
    """The arguments behind the functions in the order of the loop: arrays and records of them, and plain numbers."""
    names = list(inspect.signature(loop.run).parameters)[FUNCTIONS:]
    return [_argument(name, kind) for name, kind in zip(names, loop.RUN[FUNCTIONS:], strict=True)]


def _argument(name: str, kind: Kind) -> dict[str, Any]:
    if isinstance(kind, Row):
        return {"name": name, "is": "array"}
    if isinstance(kind, Record):
        return {"name": name, "is": "record", "fields": list(getattr(kind.cls, "_fields", ()))}
    return {"name": name, "is": "float" if kind is FLOAT else "int"}


def call(system: System, ready: Prepared) -> dict[str, Any]:
    """Data with which a page runs a system through its module: arguments, arrays, times, and words for failures."""
    begun = start_run(ready, system.stepping)
    arrays: dict[str, npt.NDArray[Any]] = {
        "y": begun.state, "command": begun.command, "memory": begun.memory, "params": ready.vectors.params,
        "plan": ready.plan, "agenda": begun.agenda, "waiting": begun.waiting, "clock": begun.clock,
        "course": begun.course, "atol": ready.atol, "rtol": ready.rtol, "scale": ready.scale, "floor": ready.floor,
        "width": ready.width,
    }  # fmt: skip
    bench = loop.workbench(ready.plan, begun.state.size, ready.width.size, ready.pattern)
    return {
        "arguments": arguments(),
        "arrays": {name: pack_array(each) for name, each in arrays.items()},
        "pattern": {name: pack_array(each) for name, each in ready.pattern._asdict().items()},
        "bench": {name: list(each.shape) for name, each in bench._asdict().items()},
        "stepping": _stepping(system.stepping),
        "places": {name.lower(): getattr(places, name) for name in PLACES},
        "states": [path for path, _, _ in leaves(system.case.state)],
        "modes": mode_paths(system.case),
        "failures": {str(status): why_not_on(status, CULPRIT) for status in FAILURES},
    }


PLACES = (
    "TIME", "STEP", "STEPS", "REJECTED", "EVALUATIONS", "RECORDS", "MARKS", "STORED", "METHOD", "JUMPS", "JUMP_TIME",
    "CULPRIT", "SPANS", "DONE", "PAUSED", "MARKS_FULL", "NOT_FINITE", "STEP_TOO_SMALL", "STOP_BEHIND",
    "TOO_MANY_WAITING", "RESTLESS", "BELOW_ZERO",
)  # fmt: skip
"""Places in the clock of a run, and what the loop answers, that a page knows by name."""
FAILURES = (
    places.NOT_FINITE, places.STEP_TOO_SMALL, places.STOP_BEHIND, places.TOO_MANY_WAITING, places.BELOW_ZERO,
    places.RESTLESS,
)  # fmt: skip
CULPRIT = "{culprit}"
"""Placeholder for the name of a pressure or mode in the words for a failure."""


def _stepping(stepping: Stepping) -> Mapping[str, object]:
    found = {each.name: getattr(stepping, each.name) for each in fields(stepping)}
    return {name: value.value if isinstance(value, Enum) else value for name, value in found.items()}
