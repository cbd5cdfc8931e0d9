"""Joins a model (plain Python functions) to the compiled loop.

Every function of the model becomes a small module of its own, `<cache>/<hash>-<processor>/linked.py`, whose text makes
the function's arguments from flat vectors. The hash is that of the text, of all functions and constants that the
function reaches, and of the versions: a changed formula anywhere is never served from an old cache, and what has not
changed is not compiled again. A program's step knows nothing of the circuit, so one compilation serves all circuits.
"""

import hashlib
import platform
import sys
import time
from collections.abc import Callable, Sequence
from functools import cache as remembered
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import RunError
from vvdp.base.interrupts import interrupts_afterwards
from vvdp.simulation.cache import Wanted, default_cache, is_kept, is_loaded, load, quiet
from vvdp.simulation.installed import ALONE, SECONDS, is_loop_compiled
from vvdp.simulation.layout import arrays, blocks
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import (
    Part,
    Sampled,
    conditions_part,
    events_part,
    example_reading,
    measure_part,
    rates_part,
    sample_part,
    step_part,
    stop_part,
    symbol,
)
from vvdp.simulation.reach import Functions, compiled_form, own_words, reachable, words
from vvdp.simulation.reason import reason
from vvdp.simulation.values import names
from vvdp.simulation.watch import Remembered, model_key

WRITERS = ("compiled", "in_place", "lane_code", "lane_math", "lane_values")
BASE = ("powers", "select", "signal")
"""Modules that compiled code is made by or with, whatever the model."""
SECONDS_EACH, SECONDS_PER_BYTE = 0.7, 1.5e-4
"""About how long a part takes to compile, and each byte of the code that it reaches, on an idle machine of 2024."""
WARMING = 2.0
"""What the first part takes longer: all that Numba imports before it compiles [s]."""

__all__ = ["Hashed", "Linked", "default_cache", "link", "quiet"]


class Linked(NamedTuple):
    """A compiled model: first-class functions over flat vectors, and the hash of their texts.

    rates(t, y, u, p, dy)
    sample(which, t, y, u, m, p, c)   0: the conditions, k: the k-th program; writes its parts of `m` and `c`
    events(t, y, u, p, g)             the mark, then the trigger of each program that has one
    stop(t, u, p) -> time             the next jump [s]

    `y` is the state, `u` the command in force, `c` the one to come, `m` the memory, `p` the parameters (`layout`).
    """

    rates: Any
    sample: Any
    events: Any
    stop: Any
    digest: str


def link(model: Model, case: Case, cache: Path | None = None, say: Callable[[str], None] = quiet) -> Linked:
    """The compiled form of `model` for values of the shape of `case`; `say` hears when something must be compiled.

    Raises RunError where a function cannot be compiled or hashed, or the cache cannot be trusted.
    """
    if not set(model.programs) == set(case.memory) == set(case.settings):
        raise RunError("a case has a memory and settings for each program of its model, and for no other")
    place = cache or default_cache()
    if (form := model_key(model, case)) is not None:
        form = (place, form)
    if known := _REMEMBERED.get(form, _is_loaded):
        return known.linked
    rates, stop, events = (Hashed(part(model, case)) for part in (rates_part, stop_part, events_part))
    held = None if model.conditions is None else Hashed(conditions_part(model.conditions, case))
    programs, sampled = list[Hashed](), list[Sampled]()
    for name, program in model.programs.items():
        part, size = measure_part(model, program, case)
        measure, step = Hashed(part), Hashed(step_part(model, name, case))
        programs += [measure, step]
        sampled.append(Sampled(symbol(measure.digest), symbol(step.digest), blocks(case).programs[name], size))
    sample = Hashed(sample_part(None if held is None else symbol(held.digest), sampled))
    outside = [*programs, *([held] if held else [])]
    parts = (rates, stop, events, *outside, sample)
    pending = Pending(parts, place, loop=0.0 if is_loop_compiled() else SECONDS)
    found = {part.digest: part.module(place, say, pending) for part in (rates, stop, events)}
    for each in outside:
        each.export(place, say, pending)
    digest = hashlib.sha256("".join([*found, sample.digest]).encode()).hexdigest()[:16]
    joined = sample.module(place, say, pending).sample
    linked = (found[rates.digest].rates, joined, found[events.digest].events)
    done = Linked(*linked, found[stop.digest].stop, digest)
    functions = {key: entry for part in parts for key, entry in part.functions.items()}
    # How many numbers a reading with an array has may depend on the values of a case.
    if not any(arrays(example_reading(model, program, case)) for program in model.programs.values()):
        _REMEMBERED.put(form, functions, _Remembered(done, tuple(part.digest for part in parts)))
    return done


class _Remembered(NamedTuple):
    """A linked model, and the digests of its modules."""

    linked: Linked
    digests: tuple[str, ...]


_REMEMBERED = Remembered[_Remembered]()


def _is_loaded(known: _Remembered) -> bool:
    return all(map(is_loaded, known.digests))


class Hashed:
    """A part with the functions that it reaches, and the hash of all of its text."""

    def __init__(self, part: Part) -> None:
        self.part = part
        self.functions: Functions = {}
        for function in part.called.values():
            reachable(function, self.functions)
        classes = [(cls.__module__, cls.__qualname__, names(cls)) for cls in part.classes.names]
        told = [part.source, repr(classes), *words(self.functions), _versions()]
        self.digest = hashlib.sha256("\n".join(told).encode()).hexdigest()[:16]

    @property
    def seconds(self) -> float:
        """About how long it takes to compile [s]."""
        length = sum(len(function.__code__.co_code) for function, _ in self.functions.values())
        return SECONDS_EACH + SECONDS_PER_BYTE * self.part.effort * length

    def module(self, cache: Path, say: Callable[[str], None], pending: "Pending | None" = None) -> ModuleType:
        """The compiled module. Raises RunError where a function cannot be compiled, with the place.

        pending  the parts of which it is one; without them it stands alone
        """
        known = {**dict(self.part.classes.tuples()), **self.part.called}
        within = pending or Pending([self], cache)
        wanted = Wanted(self.digest, self.part.source, known, self._prepare, lambda: within.words(self))
        try:
            with interrupts_afterwards():
                return load(wanted, cache, say)
        except RunError:
            raise
        except Exception as problem:
            raise RunError(reason(problem, self.functions)) from None

    def export(self, cache: Path, say: Callable[[str], None], pending: "Pending") -> None:
        """Compiles the module and lets others find its function by its symbol."""
        import llvmlite.binding as llvm

        (result,) = self.module(cache, say, pending).exported.overloads.values()
        # The entry that Numba makes for calls by pointer: plain C, and compiled already.
        place = result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)
        llvm.add_symbol(symbol(self.digest), place)

    def _prepare(self) -> None:
        from vvdp.simulation.compiled import make_compilable

        for function, constants in self.functions.values():
            make_compilable(function, compiled_form(function), own_words(function, constants))


class Pending:
    """Those of `parts` that must be compiled, in this order, and how long that may still take.

    loop  what the loop takes that is compiled after them, 0 where none is [s]
    """

    def __init__(self, parts: Sequence[Hashed], cache: Path, loop: float = 0.0) -> None:
        self._seconds = {part.digest: part.seconds for part in parts if not is_kept(part.digest, cache)}
        for first in list(self._seconds)[: not is_warm()]:
            self._seconds[first] += WARMING
        if loop > 0.0:
            self._seconds[ALONE] = loop
        self._began = time.monotonic()

    def words(self, part: Hashed) -> str:
        """What to say before `part` is compiled: its place among the others, and the time left at the pace so far."""
        if not part.part.title:
            return ""
        digests = list(self._seconds)
        number = digests.index(part.digest) if part.digest in digests else 0
        past, left = (sum(self._seconds[name] for name in some) for some in (digests[:number], digests[number:]))
        pace = (time.monotonic() - self._began) / past if past else 1.0
        place = f"part {number + 1} of {len(digests)}, " if len(digests) > 1 else ""
        return f"compiling {part.part.title} (first use only): {place}about {max(1.0, pace * left):.0f} s left"


def is_warm() -> bool:
    """Whether Numba has imported what it compiles with."""
    return "numba.np.linalg" in sys.modules


@remembered
def _versions() -> str:
    """What compiled code depends on besides the model."""
    import numba

    here, told = Path(__file__).parent, hashlib.sha256()
    for path in (*(here / f"{name}.py" for name in WRITERS), *(here.parent / "base" / f"{name}.py" for name in BASE)):
        told.update(path.read_bytes())
    return f"{platform.python_version()} {np.__version__} {numba.__version__} {told.hexdigest()}"
