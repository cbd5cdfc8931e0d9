"""Variables of a function as C wants them: which are needed, where they are declared, which arrays change."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from vvdp.generator import tree
from vvdp.generator.kinds import Row
from vvdp.generator.llvm_statements import inner_blocks, statements_in
from vvdp.generator.verify import operands, statement_operands

Place = tuple[int, int]
"""A block by its identity, and the number of a statement in it."""


@dataclass
class Scopes:
    """Where variables are declared.

    live      variables whose value is used
    here      by a statement, the variables that are declared where it assigns them
    before    by a place, the variables that are declared in front of it, since several statements assign them
    again     variables that may be assigned more than once
    """

    live: set[tree.Variable]
    here: set[tuple[tree.Variable, int]] = field(default_factory=set)
    before: dict[Place, list[tree.Variable]] = field(default_factory=dict)
    again: set[tree.Variable] = field(default_factory=set)


def expressions_in(value: tree.Expression) -> Iterator[tree.Expression]:
    """An expression and all within it."""
    yield value
    for inner in operands(value):
        yield from expressions_in(inner)


def reads_in(values: tuple[tree.Expression, ...]) -> Iterator[tree.Variable]:
    """The variables that expressions read."""
    for value in values:
        for each in expressions_in(value):
            if isinstance(each, tree.Read):
                yield each.variable


def has_effect(value: tree.Expression) -> bool:
    """Whether an expression calls a function, which may write to arrays or fail."""
    return any(isinstance(each, tree.Call | tree.CallAddress | tree.CallIntrinsic) for each in expressions_in(value))


def callees(function: tree.Function) -> Iterator[tree.Function]:
    """The functions that a function calls, once for each call."""
    for statement in statements_in(function.body):
        for operand in statement_operands(statement):
            yield from (each.function for each in expressions_in(operand) if isinstance(each, tree.Call))


def assignments(statement: tree.Statement) -> list[tuple[tree.Variable, tree.Expression]]:
    """The variables that a statement assigns, with their values."""
    if isinstance(statement, tree.Let):
        return [(statement.variable, statement.value)]
    if isinstance(statement, tree.Set):
        return list(zip(statement.variables, statement.values, strict=True))
    return []


def live_variables(function: tree.Function) -> set[tree.Variable]:
    """The variables on whose values something depends besides values of no use."""
    found: set[tree.Variable] = set()
    waiting: dict[tree.Variable, list[tree.Expression]] = {}
    needed: list[tree.Expression] = []
    for statement in statements_in(function.body):
        pairs = assignments(statement)
        for variable, value in pairs:
            waiting.setdefault(variable, []).append(value)
            needed += [value] if has_effect(value) else []
        if not pairs:
            needed += statement_operands(statement)
    while needed:
        for variable in reads_in((needed.pop(),)):
            if variable not in found:
                found.add(variable)
                needed += waiting.get(variable, [])
    return found


def scopes_of(function: tree.Function) -> Scopes:
    """Where the variables of a function are declared: in the innermost block that holds all that mentions them."""
    scopes = Scopes(live_variables(function))
    mentions: dict[tree.Variable, list[tuple[Place, ...]]] = {}
    assigned: dict[tree.Variable, tuple[tuple[Place, ...], tree.Statement]] = {}
    counts: set[tree.Variable] = set(function.parameters)

    def walk(block: tree.Block, path: tuple[Place, ...]) -> None:
        for number, statement in enumerate(block):
            here = (*path, (id(block), number))
            pairs = assignments(statement)
            for variable, _ in pairs:
                assigned.setdefault(variable, (here, statement))
            if isinstance(statement, tree.Set):
                scopes.again.update(statement.variables)
            for variable in (*(v for v, _ in pairs), *reads_in(tuple(statement_operands(statement)))):
                mentions.setdefault(variable, []).append(here)
            if isinstance(statement, tree.For):
                counts.add(statement.variable)
            for inner in inner_blocks(statement):
                walk(inner, here)

    walk(function.body, ())
    for variable, paths in mentions.items():
        if variable in counts or variable not in assigned:
            continue
        first, statement = assigned[variable]
        place = _common_place(paths)
        if first[-1] == place:
            scopes.here.add((variable, id(statement)))
        else:
            scopes.before.setdefault(place, []).append(variable)
    return scopes


def _common_place(paths: list[tuple[Place, ...]]) -> Place:
    """The innermost block that holds all of these paths, and the first statement in it that one of them passes."""
    depth = 0
    while all(len(path) > depth + 1 for path in paths):
        if len({path[depth] for path in paths}) > 1 or len({path[depth + 1][0] for path in paths}) > 1:
            break
        depth += 1
    return min(path[depth] for path in paths)


def changed_rows(function: tree.Function, known: dict[str, set[tree.Variable]]) -> set[tree.Variable]:
    """The arrays of a function whose numbers it changes, or hands to something that may; `known` by function."""
    found: set[tree.Variable] = set()
    bound: dict[tree.Variable, list[tree.Expression]] = {}
    waiting: list[tree.Expression] = []
    for statement in statements_in(function.body):
        for variable, value in assignments(statement):
            bound.setdefault(variable, []).append(value)
        if isinstance(statement, tree.Store):
            waiting.append(statement.array)
        if isinstance(statement, tree.Return) and statement.value is not None:
            waiting.append(statement.value)
        for operand in statement_operands(statement):
            for each in expressions_in(operand):
                waiting += _handed_over(each, known)
    while waiting:
        root = root_of(waiting.pop())
        if root is not None and root not in found:
            found.add(root)
            waiting += bound.get(root, [])
    return found


def _handed_over(value: tree.Expression, known: dict[str, set[tree.Variable]]) -> list[tree.Expression]:
    """The arrays that an expression hands to a function which changes them, or keeps in a record."""
    if isinstance(value, tree.Call):
        pairs = zip(value.arguments, value.function.parameters, strict=True)
        return [argument for argument, parameter in pairs if parameter in known[value.function.name]]
    if isinstance(value, tree.CallAddress | tree.CallIntrinsic | tree.Library):
        return [argument for argument in value.arguments if isinstance(argument.kind, Row)]
    if isinstance(value, tree.Make):
        return [part for part in value.parts if part is not None and isinstance(part.kind, Row)]
    return []


def root_of(value: tree.Expression) -> tree.Variable | None:
    """The variable whose array an array is a part of; None where it is of a record, of a table, or new."""
    while isinstance(value, tree.View):
        value = value.array
    return value.variable if isinstance(value, tree.Read) and isinstance(value.kind, Row) else None
