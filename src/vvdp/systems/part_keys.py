"""The keys that a component or a program has in a file, and the type that was meant where they are those of another."""

from collections.abc import Mapping
from typing import NamedTuple

from vvdp.base.params import Params, default_values, field_names
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram

PartType = Component | Assembly | ProgramType | GenericProgram


PROGRAM_KEYS = ("sensors", "period", "phase", "latency", "previous")
"""Keys that every program may have."""


class PartKeys(NamedTuple):
    """The keys that a part must have, and all that it may have."""

    needed: frozenset[str]
    known: frozenset[str]


def part_keys(part: PartType) -> PartKeys:
    """The keys of a component or program in a file: ports, inputs or readings, values, and what a drawing adds."""
    classes: tuple[type[Params], ...]
    part = part.type if isinstance(part, GenericProgram) else part
    if isinstance(part, ProgramType):
        classes = (part.settings,) if part.settings else ()
        inputs = {*part.reading._fields}  # type: ignore[attr-defined]
        joined, optional = inputs - {*part.defaults, "time"}, {*inputs, *PROGRAM_KEYS}
    elif isinstance(part, Assembly):
        classes, joined = (part.params,), {*part.ports, *part.inputs}
        optional = {"at", "start"} if part.holds_oil else {"at"}
    else:
        others = {each.name for each in part.alternatives.values()}
        needed_inputs = {each.name for each in part.inputs if each.default is None and each.name not in part.given_by}
        joined = {*part.ports, *needed_inputs}
        classes, optional = tuple(part.params), {"at", "start", *others, *(each.name for each in part.inputs)}
    fields = {key for cls in classes for key in field_names(cls)}
    needed = {"type", *joined, *(fields - {key for cls in classes for key in default_values(cls)})}
    return PartKeys(frozenset(needed), frozenset({*needed, *fields, *optional}))


def other_type(word: str, given: Mapping[str, object], types: Mapping[str, PartType]) -> str:
    """A message where the keys `given` with type `word` are not its own but all those of another; else empty."""
    own = part_keys(types[word])
    odd = [key for key in given if key not in own.known]
    if not odd:
        return ""
    keys = {name: part_keys(part) for name, part in types.items()}
    meant = [name for name, each in keys.items() if each.needed <= given.keys() <= each.known]
    if not meant:
        return ""
    return f"type {word!r} takes no {', '.join(odd)}; the keys given are those of type {' or '.join(map(repr, meant))}"
