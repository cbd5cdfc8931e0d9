"""A system with the loop that carries it, as one tree: the text of `simulation.loop.run` and all that it calls.

The functions are those of a simulation, over the same flat vectors. What differs is that they are known to the loop
before, and that lengths of arrays stand in the text, so that all arrays have a known size.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.generator.kinds import Address, Kind, Known
from vvdp.generator.source import LanguageError
from vvdp.generator.tree import Module
from vvdp.generator.unit import Options, Unit
from vvdp.generator.verify import verify
from vvdp.simulation import guest, loop
from vvdp.simulation.dialect import model_options
from vvdp.simulation.exchange import refuse_partners
from vvdp.simulation.flat import store
from vvdp.simulation.layout import blocks, vectors
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import (
    Part,
    Sampled,
    conditions_part,
    events_part,
    example_outputs,
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
from vvdp.simulation.text import Place, told_size, write

LENGTH = re.compile(r"int\((\w)\[([^\]]+)\]\)")
"""A length, or the place of an array, as the texts of `simulation.parts` read it from a vector."""
NONE: guest.Entries = {}
FEW = 4
"""Rounds of a loop that are written out, so that the text is short."""
SUM = re.compile(r"\s+([\w, ]+) = ([\w +*,]+)")
"""A line that calculates places from others."""


def machine_module(model: Model, case: Case, more: guest.Entries = NONE) -> Module:
    """The verified tree of a system with its loop; its entries are `run`, the loop, and `outputs`.

    It has `more` of `simulation.guest` as well, for a host. Lengths of arrays and places of signals are those of
    `case`. Raises LanguageError where a function uses what the language does not have, RunError where a program
    exchanges values with a model outside.
    """
    refuse_partners(model.partners, "exported code")
    known, shown = _functions(model, case), outputs_part(model, case, shapes=False)
    outputs = _with_lengths(shown, {"p": vectors(case).params})

    def read(options: Options) -> Module:
        unit = Unit(options)
        for name, (function, kinds) in {"run": (loop.run, loop.RUN), **more}.items():
            handed = parameters_of(function, kinds)
            types = [Known(known[each]) if isinstance(kind, Address) else kind for each, kind in handed.items()]
            unit.add(function, types, name)
        unit.add(outputs, shown.kinds, "outputs")
        return verify(unit.module())

    try:
        return read(replace(model_options(), unrolled=FEW))
    except LanguageError:  # what is chosen by its number, as one of several functions, needs known numbers
        return read(model_options())


def parameters_of(function: Callable[..., Any], kinds: Sequence[Kind]) -> dict[str, Kind]:
    """The types of a function's arguments by name; those that are functions are known to it before."""
    return dict(zip(function.__code__.co_varnames, kinds, strict=False))


def _functions(model: Model, case: Case) -> dict[str, Callable[..., Any]]:
    """By name, the functions that the loop calls, and `outputs`."""
    params, begin = {"p": vectors(case).params}, blocks(case).programs
    parts = [rates_part(model, case), stop_part(model, case), events_part(model, case), outputs_part(model, case)]
    if model.conditions is not None:
        parts.append(conditions_part(model.conditions, case))
    found = {part.name: _with_lengths(part, params) for part in parts}
    sampled, told = list[Sampled](), _told_numbers(example_outputs(model, case))
    for number, (name, program) in enumerate(model.programs.items(), 1):
        seen = needs_outputs(program.measure)
        reading = _told_numbers(example_reading(model, program, case))
        found[f"measure_{number}"] = _with_lengths(measure_part(model, program, case), {**params, "o": told})
        found[f"step_{number}"] = _with_lengths(step_part(model, name, case), {**params, "r": reading}, begin[name])
        sampled.append(Sampled("", "", begin[name], reading.size, outputs_size(model, case) if seen else 0))
    sample = sample_part(None if model.conditions is None else "", "", sampled)
    found["sample"] = replace(sample, called={name: found[name] for name in sample.called}).function()
    return found


def _told_numbers(value: Any) -> Array:
    """The numbers of a value as sensors and programs are handed them: the shape of an array before its numbers."""
    lines, numbers = list[str](), np.zeros(told_size(value))
    write(value, "value", "numbers", Place(), lines, shapes=True)
    exec("\n".join(line.strip() for line in lines), {"np": np, "store": store, "value": value, "numbers": numbers})
    return numbers


def _with_lengths(part: Part, numbers: Mapping[str, Array], block: int = 0) -> Callable[..., Any]:
    """The function of a part in whose text lengths and places stand as numbers.

    numbers  by their names in the text, vectors from which it would read lengths and places
    block    where the block of a program begins in the parameters
    """
    places: dict[str, Any] = {"k": block}

    def number(found: re.Match[str]) -> str:
        return str(int(numbers[found[1]][eval(found[2], {}, places)]))

    lines = []
    for line in part.source.splitlines():
        lines.append(LENGTH.sub(number, line))
        total = SUM.fullmatch(lines[-1])
        if total and all(name in places or name.isdigit() for name in re.findall(r"\w+", total[2])):
            exec(lines[-1].strip(), {}, places)
    return replace(part, source="\n".join(lines) + "\n").function()
