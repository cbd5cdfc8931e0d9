"""Where ways through a function meet: one value for what a name stands for on each, and variables where they differ."""

from typing import Any

from vvdp.generator import tree
from vvdp.generator.body import Body, End, Names
from vvdp.generator.kinds import Kind, Known, Record, has_rows, tuple_of
from vvdp.generator.values import Undefined, are_same, carried_type, joined_type, part, parts, refusal


def set_all(body: Body, target: Any, value: Any) -> None:
    """Assigns a value to the variables of which `target` consists, all at once."""
    pairs = _pairs(body, target, value)
    if pairs:
        body.add(tree.Set(tuple(v for v, _ in pairs), tuple(e for _, e in pairs), body.line))


def _pairs(body: Body, target: Any, value: Any) -> list[tuple[tree.Variable, tree.Expression]]:
    if are_same(target, value):
        return []
    if isinstance(target, tuple):
        each = zip(target, (part(value, i) for i in range(len(target))), strict=True)
        return [pair for t, v in each for pair in _pairs(body, t, v)]
    if isinstance(target, tree.Read):
        found = body.as_kind(value, target.kind)
        return [] if found is None else [(target.variable, found)]
    return []


def merge(body: Body, ends: list[End]) -> Names | None:
    """Meanings of the names where these ways meet; None where there is no way. Variables are set at the ends."""
    if len(ends) < 2:
        return ends[0].names if ends else None
    merged: Names = {}
    for name in dict.fromkeys(name for end in ends for name in end.names):
        missing = Undefined(f"`{name}` is not assigned on every way to this line")
        merged[name] = _meeting_value(body, name, [end.names.get(name, missing) for end in ends])
    for end in ends:
        with body.within(end.block):
            set_all(body, tuple(merged.values()), tuple(end.names.get(name) for name in merged))
    return merged


def _meeting_value(body: Body, name: str, values: list[Any]) -> Any:
    """One value for those that a name has at several ends, with variables wherever they differ."""
    first = values[0]
    if all(are_same(first, value) for value in values[1:]):
        return first
    kind = joined_type(values)
    if isinstance(kind, Record) and not all(isinstance(v, tree.Read) and v.kind == kind for v in values):
        rows = zip(*map(parts, values), strict=True)
        return tuple_of(kind.cls, [_meeting_value(body, name, list(row)) for row in rows])
    if kind is None:
        missing = next((v for v in values if isinstance(v, Undefined)), None)
        return missing or Undefined(f"`{name}` has values of several types here")
    return first if isinstance(kind, Known) else tree.Read(body.variable(name, kind))


def changing(body: Body, name: str, kind: Kind | None, value: Any) -> Any:
    """Variables for a value of this type that a loop changes, in parts where `value` is."""
    if isinstance(kind, Known) or isinstance(value, Undefined):
        return value
    if kind is None:
        return Undefined(f"`{name}` changes its type in the loop")
    if isinstance(kind, Record) and isinstance(value, tuple):
        each = zip(kind.fields, value, strict=True)
        return tuple_of(kind.cls, [changing(body, name, k, v) for k, v in each])
    return tree.Read(body.variable(name, kind))


def finish(body: Body, *, is_entry: bool) -> Kind:
    """Writes the returns, and gives the type of the result; an entry hands over known numbers, too."""
    kind = joined_type([value for _, value, _ in body.returns]) if body.returns else Known(None)
    if kind is None:
        raise refusal("returns of different types", "return values of one type everywhere")
    kind = carried_type(kind) if is_entry else kind
    if is_entry and has_rows(kind):
        raise refusal("an array that an entry returns", "write its numbers to an array that is handed over")
    for end, value, line in body.returns:
        with body.within(end.block):
            body.line = line
            body.add(tree.Return(body.as_kind(value, kind), line))
    return kind
