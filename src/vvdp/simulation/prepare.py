"""What a run needs before its first step: a checked and linked case as flat vectors, and the compiled loop."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.numerics.tableaus import Array
from vvdp.simulation import places
from vvdp.simulation.check import check_model, check_times
from vvdp.simulation.layout import Vectors, command_parts, vectors
from vvdp.simulation.link import Linked, link, quiet
from vvdp.simulation.loading import registries_left_out
from vvdp.simulation.model import Case, Model
from vvdp.simulation.stepping import Method, Stepping
from vvdp.simulation.values import leaves


@dataclass(frozen=True)
class Prepared:
    """A case as flat vectors, with the compiled functions and the times at which its programs are called."""

    linked: Linked
    vectors: Vectors
    plan: Array  # (1 + programs, columns of `vvdp.simulation.schedule`)
    atol: Array
    rtol: Array
    scale: Array
    active: int


def prepared(
    model: Model, case: Case, stepping: Stepping, cache: Path | None = None, say: Callable[[str], None] = quiet
) -> Prepared:
    """Everything that the loop needs. The books take no part in the error control: it is they that judge it."""
    check_model(model, case)
    check_times(model, stepping.sample_period)
    kinds = [(path, kind) for path, _, kind in leaves(case.state)]
    linked = link(model, case, cache, say)
    scale = np.array([kind.scale if kind else 1.0 for _, kind in kinds])
    bounded = np.array([not (kind and kind.accumulates) for _, kind in kinds])
    active = sum(not path.startswith("books.") for path, _ in kinds)
    return Prepared(
        linked=linked,
        vectors=vectors(case),
        plan=_plan(model, case, stepping.sample_period),
        atol=stepping.relative_tolerance * scale,
        rtol=stepping.relative_tolerance * bounded,
        scale=scale,
        active=active,
    )


def _plan(model: Model, case: Case, sample_period: float) -> Array:
    """A row for the conditions and for each program, as `vvdp.simulation.schedule` has them."""
    parts, triggers = command_parts(case), 0
    rows = [[sample_period, 0.0, 0.0, 0.0, 0.0, 0.0]]
    for name, program in model.programs.items():
        triggers += program.trigger is not None
        period = sample_period if program.period is None else program.period
        trigger = 0.0 if program.trigger is None else triggers
        rows.append([period, program.phase, program.latency, trigger, parts[name].start, parts[name].stop])
    return np.array(rows, float)


class Reached(NamedTuple):
    """Where a run stands: everything that the loop changes, so that it can go on from there."""

    state: Array  # (n,)
    command: Array  # (commands,)
    memory: Array  # (memories,)
    agenda: Array  # (1 + programs, columns of `vvdp.simulation.schedule`)
    waiting: Array  # (1 + programs, depth, commands)
    clock: Array

    def copy(self) -> "Reached":
        """The same in arrays of its own."""
        return Reached._make(part.copy() for part in self)


def started(ready: Prepared, stepping: Stepping) -> Reached:
    """Where a run stands before its first step."""
    state, command, memory, _ = (part.copy() for part in ready.vectors)
    programs, clock = ready.plan.shape[0], np.zeros(places.CLOCK)
    clock[places.TIME] = clock[places.WINDOW_TIME] = stepping.begin
    clock[places.STEP] = min(1e-3 * stepping.sample_period, stepping.longest_step)
    clock[places.METHOD] = places.STIFF if stepping.method is Method.STIFF else places.EXPLICIT
    agenda, waiting = np.zeros((programs, places.AGENDA)), np.zeros((programs, places.DEPTH, command.size))
    return Reached(state, command, memory, agenda, waiting, clock)


def is_loop_compiled() -> bool:
    """Whether the compiled loop is kept from an earlier run."""
    return any((Path(__file__).parent / "__pycache__").glob("loop.run-*.nbi"))


def compiled_loop(say: Callable[[str], None]) -> Any:
    """The compiled loop; Numba is loaded here, and only here."""
    _drop_stale_loop()
    if not is_loop_compiled():
        say("compiling the simulation loop (once for each installation, about half a minute)")
    with registries_left_out():
        from vvdp.simulation import loop

    return loop


@cache
def _drop_stale_loop() -> None:
    """Numba knows a change of a function's own file only; the loop is written in several."""
    folder = Path(__file__).parent
    texts = (
        folder / "loop.py",
        folder / "schedule.py",
        folder / "steps.py",
        folder.parent / "numerics" / "tableaus.py",
    )
    digest = hashlib.sha256(b"".join(text.read_bytes() for text in texts)).hexdigest()
    kept = folder / "__pycache__" / "loop.digest"
    try:
        if kept.exists() and kept.read_text() == digest:
            return
        for stem in ("loop", "schedule", "steps"):
            for old in kept.parent.glob(f"{stem}.*.nb[ic]"):
                old.unlink(missing_ok=True)
        kept.parent.mkdir(exist_ok=True)
        kept.write_text(digest)
    except OSError:
        return  # a folder that cannot be written holds nothing of an earlier version
