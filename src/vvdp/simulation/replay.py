"""A sampled step (sensor, estimator, controller) run over a record of its inputs, compiled.

A step is `step(memory, reading, settings) -> (memory, shown)`, plain functions over NamedTuples of floats; in a
simulation a program calls it at each sample, here it goes through rows that lie ready. What it has reached is in its
memory, so a record may come in portions.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import RunError
from vvdp.generator.kinds import FLOAT, Row
from vvdp.simulation.assembly import Assembly
from vvdp.simulation.cache import default_cache, quiet
from vvdp.simulation.layout import Packed
from vvdp.simulation.parts import VECTOR, Part
from vvdp.simulation.text import Classes, Place, numbers, parameters, remember, write
from vvdp.simulation.values import as_value, flat, leaves

MATRIX = Row(FLOAT, (None, None))
Step = Callable[[Any, Any, Any], tuple[Any, Any]]


class Replayed(NamedTuple):
    """Outcome of a step over a record: its memory after the last row, and its output at each."""

    memory: Any
    shown: Array  # (rows, m)


class Replay:
    """`step` compiled for memories, readings and settings of one shape; calls release the interpreter's lock.

    `digest` is the hash of its text, and of the versions that compiled it.

    Raises RunError where step, memory, reading and settings do not fit together.
    """

    def __init__(
        self,
        step: Step,
        memory: Any,
        reading: Any,
        settings: Any,
        *,
        say: Callable[[str], None] = quiet,
    ) -> None:
        shown = _trial_output(step, memory, reading, settings)
        self.columns = tuple(path for path, _, _ in leaves(shown))
        self.width = flat(reading).size
        self._example, self._settings, self._shapes = memory, settings, Packed()
        for value in (memory, reading):
            self._shapes.add_shapes(value)
        assembly = _assembly(step, memory, reading, settings, shown)
        self._run, self.digest = assembly.load(default_cache(), say)["replay"], assembly.digest

    def __call__(self, memory: Any, rows: Array, settings: Any | None = None) -> Replayed:
        """The step taken over `rows`, shape (samples, numbers of a reading), starting from `memory`."""
        reached = flat(memory)
        shown = self.outputs(reached, rows, settings)
        return Replayed(as_value(self._example, reached), shown)

    def outputs(self, memory: Array, rows: Array, settings: Any | None = None) -> Array:
        """The output alone, shape (samples, numbers shown), from a flat `memory`, which is then that after the rows."""
        rows = np.ascontiguousarray(rows, float)
        if rows.ndim != 2 or rows.shape[1] != self.width:
            raise RunError(f"rows of shape {rows.shape}; expected (samples, {self.width})")
        found = np.empty((rows.shape[0], len(self.columns)))
        packed = Packed()
        packed.add(self._settings if settings is None else settings)
        packed.fixed += self._shapes.fixed
        self._run(memory, packed.vector(), rows, found)
        return found


class Compiled:
    """Steps over rows, each compiled as it is first taken: a `run` of `vvdp.estimation.smoother`."""

    def __init__(self, say: Callable[[str], None] = quiet) -> None:
        self._say, self._runs = say, dict[Step, Replay]()

    def __call__(self, step: Step, memory: Any, row: Any, settings: Any, rows: Array) -> tuple[Any, Array]:
        """The memory after the last row, and what was shown at each."""
        if step not in self._runs:
            self._runs[step] = Replay(step, memory, row, settings, say=self._say)
        return self._runs[step](memory, rows, settings)


def replay_digest(step: Step, memory: Any, reading: Any, settings: Any) -> str:
    """`Replay.digest`, without compiling. Raises RunError as `Replay` does."""
    return _assembly(step, memory, reading, settings, _trial_output(step, memory, reading, settings)).digest


def _trial_output(step: Step, memory: Any, reading: Any, settings: Any) -> Any:
    """Output of a step at these values. Raises RunError where it returns another memory than it takes."""
    after, shown = step(memory, reading, settings)
    before, found = [path for path, _, _ in leaves(memory)], [path for path, _, _ in leaves(after)]
    if before != found or flat(memory).size != flat(after).size:
        odd = sorted(set(before) ^ set(found)) or [f"{flat(memory).size} numbers against {flat(after).size}"]
        raise RunError(f"{step.__qualname__} returns a memory that differs from the one given in {', '.join(odd)}")
    if flat(shown).size != len(list(leaves(shown))):
        raise RunError(f"{step.__qualname__} shows an array; show each of its numbers under a name of its own")
    return shown


def _assembly(step: Step, memory: Any, reading: Any, settings: Any, shown: Any) -> Assembly:
    """replay(m, p, rows, out): `p` has the block of the settings, then the shapes in memory and reading."""
    classes, block, end = Classes(), Place(), Place()
    lines = [
        "def replay(m, p, rows, out):",
        "    t = 0.0",
        f"    settings = {parameters(settings, block, classes)}",
    ]
    start = numbers(memory, "m", end, block, lines, classes)
    lines += [f"    memory = {start}", "    for i in range(rows.shape[0]):", "        r, o = rows[i], out[i]"]
    inner: list[str] = []
    row = numbers(reading, "r", Place(), block, inner, classes)
    inner.append(f"    memory, shown = step(memory, {row}, settings)")
    write(shown, "shown", "o", Place(), inner)
    lines += [f"    {line}" for line in inner]
    lines += remember(memory, "memory", "0", str(end))
    part = Part(
        name="replay",
        source="\n".join(lines) + "\n",
        called={"step": step},
        classes=classes,
        kinds=(VECTOR, VECTOR, MATRIX, MATRIX),
    )
    return Assembly([part], f"the {step.__name__.replace('_', ' ')}")
