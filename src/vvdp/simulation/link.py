"""Joins a model (plain Python functions) to the compiled loop.

The functions of a circuit are compiled together, and each sensor and each step of a program by itself: a step knows
nothing of the circuit, so one compilation serves all circuits. `sample` calls them by their symbols.
"""

import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from vvdp.base.errors import RunError
from vvdp.generator.calls import Entry
from vvdp.simulation.assembly import Assembly, Compiling
from vvdp.simulation.cache import default_cache, quiet
from vvdp.simulation.layout import arrays, blocks
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import (
    Sampled,
    conditions_part,
    events_part,
    example_reading,
    measure_part,
    needs_outputs,
    outputs_part,
    outputs_size,
    rates_part,
    sample_part,
    step_part,
    stop_part,
)
from vvdp.simulation.text import told_size
from vvdp.simulation.watch import Remembered, model_key

__all__ = ["Linked", "default_cache", "link", "quiet"]


class Linked(NamedTuple):
    """A compiled model: functions over flat vectors, and the hash of their texts.

    rates(t, y, u, p, dy)
    sample(which, t, y, u, m, p, c)   0: the conditions, k: the k-th program; writes its parts of `m` and `c`
    events(t, y, u, p, g)             the mark, then the trigger of each program that has one
    stop(t, u, p) -> time             the next jump [s]

    `y` is the state, `u` the command in force, `c` the one to come, `m` the memory, `p` the parameters (`layout`).
    """

    rates: Entry
    sample: Entry
    events: Entry
    stop: Entry
    digest: str


def link(
    model: Model,
    case: Case,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
    *,
    checked: bool = False,
) -> Linked:
    """The compiled form of `model` for values of the shape of `case`; `say` is informed when something must be
    compiled.

    checked  whether bounds, divisions, whole numbers and assertions are checked while the code runs

    Raises RunError where a function cannot be compiled or hashed, or the cache cannot be trusted.
    """
    if not set(model.programs) == set(case.memory) == set(case.settings):
        raise RunError("a case has a memory and settings for each program of its model, and for no other")
    place = cache or default_cache()
    if (form := model_key(model, case)) is not None:
        form = (place, checked, form)
    if known := _REMEMBERED.get(form):
        return known
    assembled = ModelAssemblies(model, case, checked=checked)
    done = assembled.load(place, say)
    functions = {key: entry for each in assembled for key, entry in each.functions.items()}
    # How many numbers a reading with an array has may depend on the values of a case.
    if not any(arrays(example_reading(model, program, case)) for program in model.programs.values()):
        _REMEMBERED.put(form, functions, done)
    return done


_REMEMBERED = Remembered[Linked]()


class ModelAssemblies:
    """Units in which a model is compiled: its circuit, and a sensor and a step for each program."""

    def __init__(self, model: Model, case: Case, *, checked: bool = False) -> None:
        parts = [rates_part(model, case), stop_part(model, case), events_part(model, case)]
        seeing = [program for program in model.programs.values() if needs_outputs(program.measure)]
        parts += [outputs_part(model, case)] if seeing else []
        parts += [] if model.conditions is None else [conditions_part(model.conditions, case)]
        name = getattr(model.circuit, "__name__", "circuit").removesuffix("circuit").strip("_")
        self.circuit = Assembly(parts, f"the circuit {name}".rstrip(), inline=True, checked=checked)
        self.programs: list[tuple[Assembly, Assembly]] = []
        sampled = list[Sampled]()
        for name, program in model.programs.items():
            measure = Assembly([measure_part(model, program, case)], checked=checked)
            step = Assembly([step_part(model, name, case)], f"the program {name}", checked=checked)
            self.programs.append((measure, step))
            sampled.append(
                Sampled(
                    measure=measure.symbol("measure"),
                    step=step.symbol("step"),
                    block=blocks(case).programs[name],
                    reading=told_size(example_reading(model, program, case)),
                    outputs=outputs_size(model, case) if program in seeing else 0,
                )
            )
        held = None if model.conditions is None else self.circuit.symbol("hold")
        self.sample = Assembly([sample_part(held, self.circuit.symbol("outputs"), sampled)], checked=checked)

    def __iter__(self) -> Iterator[Assembly]:
        return iter([self.circuit, *(each for pair in self.programs for each in pair), self.sample])

    @property
    def digest(self) -> str:
        """The hash of all texts."""
        return hashlib.sha256(f"{self.circuit.digest}{self.sample.digest}".encode()).hexdigest()[:16]

    def load(self, cache: Path, say: Callable[[str], None] = quiet) -> Linked:
        """The functions of the model, from the cache or compiled into it."""
        pending = [each for each in self if not each.is_at_hand(cache)]
        if titles := [each.title for each in pending if each.title]:
            say(Compiling(", ".join(titles), sum(each.seconds for each in pending)))
        circuit, symbols = self.circuit.load(cache, say, announced=True), dict[str, Entry]()
        symbols |= {self.circuit.symbol(name): entry for name, entry in circuit.entries.items()}
        for pair in self.programs:
            for each, name in zip(pair, ("measure", "step"), strict=True):
                symbols[each.symbol(name)] = each.load(cache, say, announced=True)[name]
        wanted = {part.name for part in self.sample.parts[0].called.values()}
        used = {name: entry for name, entry in symbols.items() if name in wanted}
        sample = self.sample.load(cache, say, used, announced=True)["sample"]
        return Linked(
            rates=circuit["rates"], sample=sample, events=circuit["events"], stop=circuit["stop"], digest=self.digest
        )


def llvm_text(model: Model, case: Case) -> str:
    """The LLVM text of everything that a model is compiled in, with the file and line of each instruction."""
    found = []
    for each in ModelAssemblies(model, case):
        functions = ", ".join(part.name for part in each.parts)
        found.append(f"; {each.title or 'vectors'}: {functions}\n{each.llvm_text(debug=True)[0]}")
    return "\n".join(found)
