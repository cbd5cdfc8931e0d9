"""How much of a workspace the functions of a module in C take at most."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from vvdp.generator import tree
from vvdp.generator.kinds import INT, has_rows
from vvdp.generator.llvm_expressions import is_own_room
from vvdp.generator.llvm_statements import carries_rows, inner_blocks

Amount = tuple[int, int]
"""Floats, and whole numbers."""


class _Taken(NamedTuple):
    """Numbers that text takes; infinite if that is known only when the code runs.

    most    at most while it runs
    after   still where it is over and the next statement follows; -inf if none ever does
    left    still where the function is left from within it; -inf if it never is
    """

    most: float = 0.0
    after: float = 0.0
    left: float = -math.inf


def room_of(module: tree.Module) -> dict[str, Amount | None]:
    """By function, the most that it takes; None if that depends on what is known only when the code runs."""
    reals, wholes = (_room_taken(module, of_wholes=each) for each in (False, True))
    found = {name: (reals[name].most, wholes[name].most) for name in reals}
    return {name: None if math.inf in both else (int(both[0]), int(both[1])) for name, both in found.items()}


def _room_taken(module: tree.Module, *, of_wholes: bool) -> dict[str, _Taken]:
    """The room that each function takes. One whose result has no arrays gives all back at its end."""
    found = dict[str, _Taken]()
    for function in module.functions:
        own = _of_block(_Frame(function, found, of_wholes), function.body, hoisted=True)
        after = max(0.0, own.after, own.left) if has_rows(function.result) else 0.0
        found[function.name] = _Taken(own.most, after)
    return found


class _Frame(NamedTuple):
    """A function, what those before it take, and whether whole numbers are counted or floats."""

    function: tree.Function
    known: Mapping[str, _Taken]
    of_wholes: bool


def _of_block(frame: _Frame, block: tree.Block, *, hoisted: bool) -> _Taken:
    """The room that successive statements take. A loop whose rounds carry arrays on takes what is not known."""
    most = taken = 0.0
    left = -math.inf
    for each in block:
        carried = isinstance(each, tree.For | tree.Loop) and carries_rows(each.body)
        inner = [_of_block(frame, part, hoisted=hoisted and not carried) for part in inner_blocks(each)]
        if carried and any(part.most for part in inner):
            return _Taken(math.inf, math.inf, math.inf)
        found = _join_room(each, inner) if inner else _of_value(frame, each, hoisted=hoisted)
        most, left = max(most, taken + found.most), max(left, taken + found.left)
        taken += found.after
        if taken == -math.inf:
            break
    return _Taken(most, taken, left)


def _join_room(statement: tree.Statement, inner: Sequence[_Taken]) -> _Taken:
    """Of two branches, the larger amount; of a loop, one round, which gives back what the one before took."""
    most, left = max(each.most for each in inner), max(each.left for each in inner)
    if isinstance(statement, tree.If):
        return _Taken(most, max(each.after for each in inner), left)
    after = max(0.0, inner[0].after)  # a loop may be left by a break, or not be entered
    for each in inner[1:]:
        most, left = max(most, after + each.most), max(left, after + each.left)
        after += max(0.0, each.after)
    return _Taken(most, after, left)


def _of_value(frame: _Frame, statement: tree.Statement, *, hoisted: bool) -> _Taken:
    """The room that the array or the call of a statement takes, or that the statement leaves the function."""
    if isinstance(statement, tree.Return | tree.Fail):
        return _Taken(after=-math.inf, left=0.0)
    value: tree.Expression | None = None
    if isinstance(statement, tree.Let | tree.Do):
        value = statement.value if isinstance(statement, tree.Let) else statement.call
    if isinstance(value, tree.Call):
        return frame.known[value.function.name]
    if not isinstance(value, tree.Room) or is_own_room(hoisted, frame.function.result, value):
        return _Taken()
    if (value.kind.element is INT) is not frame.of_wholes:
        return _Taken()
    count = math.prod(math.inf if length is None else length for length in value.kind.shape)
    return _Taken(count, count)
