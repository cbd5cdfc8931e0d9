"""How much of a workspace the functions of a module in C take at most."""

from vvdp.generator import tree
from vvdp.generator.kinds import INT
from vvdp.generator.llvm_expressions import is_own_room
from vvdp.generator.llvm_statements import carries_rows, inner_blocks

Amount = tuple[int, int]
"""Floats, and whole numbers."""


def room_of(module: tree.Module) -> dict[str, Amount | None]:
    """By function, the most that it takes; None if that depends on what is known only when the code runs."""
    found: dict[str, Amount | None] = {}
    for function in module.functions:
        taken = _needs_of_block(function, function.body, found, hoisted=True)
        sure = [each for each in taken if each is not None]
        whole = sum(floats for floats, _ in sure), sum(wholes for _, wholes in sure)
        found[function.name] = whole if len(sure) == len(taken) else None
    return found


def _needs_of_block(
    function: tree.Function, block: tree.Block, known: dict[str, Amount | None], *, hoisted: bool
) -> list[Amount | None]:
    """What each statement takes; a round of a loop gives back what the one before took, unless arrays are carried."""
    found: list[Amount | None] = []
    for each in block:
        value = each.value if isinstance(each, tree.Let) else each.call if isinstance(each, tree.Do) else None
        if isinstance(value, tree.Call):
            found.append(known[value.function.name])
        if isinstance(value, tree.Room) and not is_own_room(hoisted, function.result, value):
            found.append(_amount(value))
        carried = isinstance(each, tree.For | tree.Loop) and carries_rows(each.body)
        for inner in inner_blocks(each):
            taken = _needs_of_block(function, inner, known, hoisted=hoisted and not carried)
            found += [None] if carried and any(one != (0, 0) for one in taken) else taken
    return found


def _amount(value: tree.Room) -> Amount | None:
    count = 1
    for length in value.kind.shape:
        if length is None:
            return None
        count *= length
    return (0, count) if value.kind.element is INT else (count, 0)
