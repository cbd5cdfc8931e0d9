"""Statements of the tree as LLVM instructions."""

from collections.abc import Callable, Iterator
from typing import Any, Protocol

from vvdp.generator import tree
from vvdp.generator.kinds import Known, Record, Row, has_rows, leaves, registers_of, size
from vvdp.generator.llvm_expressions import is_own_room, item_address, one, registers, return_nothing, trouble_address
from vvdp.generator.llvm_text import TYPES, Needs, Registers, Text, is_held_in_memory, open_lengths


def statements_in(block: tree.Block) -> Iterator[tree.Statement]:
    """Every statement of a block, those within others included."""
    for each in block:
        yield each
        for inner in inner_blocks(each):
            yield from statements_in(inner)


def inner_blocks(statement: tree.Statement) -> tuple[tree.Block, ...]:
    """The blocks within a statement."""
    if isinstance(statement, tree.If):
        return statement.then, statement.otherwise
    if isinstance(statement, tree.For):
        return statement.body, statement.exhausted
    return (statement.body,) if isinstance(statement, tree.Loop) else ()


def carries_rows(block: tree.Block) -> bool:
    """Whether an array may outlive the round of a loop in which it was made."""
    sets = (each for each in statements_in(block) if isinstance(each, tree.Set))
    return any(has_rows(variable.kind) for each in sets for variable in each.variables)


class Roomy(Protocol):
    """The text of a function as far as it says where arrays lie."""

    function: tree.Function
    needs: dict[str, Needs]
    hoisted: bool


def takes_room(text: Roomy, block: tree.Block) -> bool:
    """Whether arrays that statements make lie in the frame of the entry."""
    for each in statements_in(block):
        value = each.value if isinstance(each, tree.Let) else each.call if isinstance(each, tree.Do) else None
        if isinstance(value, tree.Call) and text.needs[value.function.name].room:
            return True
        if isinstance(value, tree.Room) and not is_own_room(text.hoisted, text.function.result, value):
            return True
    return False


def needs_of(function: tree.Function, known: dict[str, Needs]) -> Needs:
    """Needs of a function, from its own statements and the needs of the functions that it calls."""
    room = trouble = False

    def look(block: tree.Block, hoisted: bool) -> None:
        nonlocal room, trouble
        for each in block:
            value = each.value if isinstance(each, tree.Let) else each.call if isinstance(each, tree.Do) else None
            if isinstance(value, tree.Call):
                needs = known[value.function.name]
                room, trouble = room or needs.room, trouble or needs.trouble
            room = room or (isinstance(value, tree.Room) and not is_own_room(hoisted, function.result, value))
            trouble = trouble or isinstance(each, tree.Fail) or isinstance(value, tree.CallAddress)
            inside = hoisted and not (isinstance(each, tree.For | tree.Loop) and carries_rows(each.body))
            for inner in inner_blocks(each):
                look(inner, inside)

    look(function.body, True)
    return Needs(room, trouble)


def write_block(text: Text, block: tree.Block) -> None:
    """Writes statements; what cannot be reached is left out."""
    for each in block:
        if not text.is_open:
            return
        locate(text, getattr(each, "line", 0))
        WRITTEN[type(each)](text, each)


def locate(text: Text, line: int) -> None:
    """Gives the instructions that follow the place of their Python text."""
    if text.shared.debug and line:
        scope = scope_of(text)
        number = text.shared.metadata(f"!DILocation(line: {line}, column: 0, scope: !{scope})")
        text.location = f", !dbg !{number}"


def scope_of(text: Text) -> int:
    """The number of the metadata of a function."""
    function, shared = text.function, text.shared
    folder, _, name = function.file.rpartition("/")
    file = shared.metadata(f'!DIFile(filename: "{name}", directory: "{folder}")')
    unit = shared.metadata(
        f"distinct !DICompileUnit(language: DW_LANG_Python, file: !{file}, emissionKind: LineTablesOnly)"
    )
    kind = shared.metadata("!DISubroutineType(types: !{null})")
    words = f'name: "{function.name}", file: !{file}, line: {function.line}, scopeLine: {function.line}'
    return shared.metadata(
        f"distinct !DISubprogram({words}, scope: !{file}, type: !{kind}, spFlags: DISPFlagDefinition, unit: !{unit})"
    )


def _let(text: Text, statement: tree.Let) -> None:
    found = registers(text, statement.value)
    text.held[statement.variable] = open_lengths(found, statement.value.kind, statement.variable.kind)


def keep(text: Text, variable: tree.Variable) -> Registers:
    """Where a variable is kept that is set more than once."""
    if variable not in text.kept:
        if isinstance(variable.kind, Record):
            text.kept[variable] = (text.slot(size(variable.kind), "kept"),)
        else:
            text.kept[variable] = tuple(text.slot(1, "kept") for _ in leaves(variable.kind))
    return text.kept[variable]


def _set(text: Text, statement: tree.Set) -> None:
    """All values are at hand before the first is kept, since one may be calculated from what another replaces."""
    found = []
    for variable, value in zip(statement.variables, statement.values, strict=True):
        one_value = open_lengths(registers(text, value), value.kind, variable.kind)
        if isinstance(variable.kind, Record) and len(statement.variables) > 1 and _is_kept(text, value):
            beside = text.slot(size(variable.kind), "beside")
            text.store_value(variable.kind, one_value, beside)
            one_value = (beside,)
        found.append(one_value)
    for variable, held in zip(statement.variables, found, strict=True):
        addresses = keep(text, variable)
        if isinstance(variable.kind, Record):
            text.store_value(variable.kind, held, addresses[0])
        else:
            for leaf, register, address in zip(leaves(variable.kind), held, addresses, strict=True):
                text.store(leaf, register, address)


def _is_kept(text: Text, value: tree.Expression) -> bool:
    while isinstance(value, tree.Field):
        value = value.record
    return isinstance(value, tree.Read) and value.variable in text.kept


def _store(text: Text, statement: tree.Store) -> None:
    number = one(text, statement.value)
    kind = statement.array.kind
    assert isinstance(kind, Row)
    text.store(kind.element, number, item_address(text, statement.array, statement.indexes))


def _do(text: Text, statement: tree.Do) -> None:
    registers(text, statement.call)


def _if(text: Text, statement: tree.If) -> None:
    test = one(text, statement.test)
    then, otherwise, after = text.label("then"), text.label("else"), text.label("after")
    text.end(f"br i1 {test}, label %{then}, label %{otherwise if statement.otherwise else after}")
    reached = not statement.otherwise
    for label, block in ((then, statement.then), (otherwise, statement.otherwise)):
        if block or label == then:
            text.begin(label)
            write_block(text, block)
            if text.is_open:
                text.end(f"br label %{after}")
                reached = True
    if reached:
        text.begin(after)


def _for(text: Text, statement: tree.For) -> None:
    first, last, step = (one(text, each) for each in statement.range)
    counter = text.slot(1, "count")
    text.put(f"store i64 {first}, ptr {counter}, align 8")
    head, inside, past = text.label("head"), text.label("inside"), text.label("past")
    next_, after = text.label("next"), text.label("after")
    text.begin(head)
    count = text.get(f"load i64, ptr {counter}, align 8")
    text.held[statement.variable] = (count,)
    text.end(f"br i1 {_goes_on(text, count, last, statement.range[2], step)}, label %{inside}, label %{past}")
    text.begin(inside)
    _round(text, statement.body, after, next_)
    text.begin(next_)
    text.put(f"store i64 {text.get(f'add i64 {count}, {step}')}, ptr {counter}, align 8")
    text.end(f"br label %{head}")
    text.begin(past)
    write_block(text, statement.exhausted)
    text.begin(after)
    if _never_ends(statement):
        text.end("unreachable")


def _never_ends(statement: tree.For) -> bool:
    """Whether nothing comes behind a loop, since all ways out of it leave the function."""
    return falls_through(statement.exhausted) is False and not has_break(statement.body)


def falls_through(block: tree.Block) -> bool:
    """Whether what stands behind a block is reached."""
    if not block:
        return True
    last = block[-1]
    if isinstance(last, tree.If):
        return falls_through(last.then) or falls_through(last.otherwise)
    if isinstance(last, tree.Loop):
        return has_break(last.body)
    if isinstance(last, tree.For):
        return not _never_ends(last)
    return not isinstance(last, tree.Break | tree.Continue | tree.Return | tree.Fail)


def has_break(block: tree.Block) -> bool:
    """Whether a block leaves the loop around it."""
    for each in block:
        if isinstance(each, tree.Break):
            return True
        if isinstance(each, tree.If) and (has_break(each.then) or has_break(each.otherwise)):
            return True
        if isinstance(each, tree.For) and has_break(each.exhausted):
            return True
    return False


def _goes_on(text: Text, count: str, last: str, step: tree.Expression, register: str) -> str:
    if isinstance(step, tree.Constant):
        return text.get(f"icmp {'slt' if step.value > 0 else 'sgt'} i64 {count}, {last}")
    up, below = text.get(f"icmp sgt i64 {register}, 0"), text.get(f"icmp slt i64 {count}, {last}")
    return text.get(f"select i1 {up}, i1 {below}, i1 {text.get(f'icmp sgt i64 {count}, {last}')}")


def _loop(text: Text, statement: tree.Loop) -> None:
    inside, after, next_ = text.label("inside"), text.label("after"), text.label("next")
    text.begin(inside)
    _round(text, statement.body, after, next_)
    text.begin(next_)
    text.end(f"br label %{inside}")
    if has_break(statement.body):
        text.begin(after)


def _round(text: Text, block: tree.Block, after: str, next_: str) -> None:
    """One round of a loop. Room that it takes is given back where no array is carried on."""
    before, carried = text.hoisted, carries_rows(block)
    text.hoisted = before and not carried
    frees = not carried and takes_room(text, block)
    cursor = text.get("load ptr, ptr %context, align 8") if frees else ""
    text.loops.append((after, next_))
    write_block(text, block)
    text.loops.pop()
    text.hoisted = before
    if frees and text.is_open:
        text.put(f"store ptr {cursor}, ptr %context, align 8")


def _break(text: Text, statement: tree.Break) -> None:
    text.end(f"br label %{text.loops[-1][0]}")


def _continue(text: Text, statement: tree.Continue) -> None:
    text.end(f"br label %{text.loops[-1][1]}")


def _return(text: Text, statement: tree.Return) -> None:
    result, function = text.function.result, text.function
    found: Registers = ()
    if statement.value is not None:
        found = open_lengths(registers(text, statement.value), statement.value.kind, result)
    if is_held_in_memory(result):
        text.store_value(result, found, "%result")
    if text.needs[function.name].room and not has_rows(result):
        text.put("store ptr %entered, ptr %context, align 8")
    if isinstance(result, Known) or is_held_in_memory(result):
        text.end("ret void")
    else:
        text.end(f"ret {TYPES[registers_of(result)[0]]} {found[0]}")


def _fail(text: Text, statement: tree.Fail) -> None:
    text.put(f"store i64 {text.shared.base + statement.number}, ptr {trouble_address(text)}, align 8")
    return_nothing(text)


WRITTEN: dict[type[Any], Callable[[Text, Any], None]] = {
    tree.Let: _let,
    tree.Set: _set,
    tree.Store: _store,
    tree.Do: _do,
    tree.If: _if,
    tree.For: _for,
    tree.Loop: _loop,
    tree.Break: _break,
    tree.Continue: _continue,
    tree.Return: _return,
    tree.Fail: _fail,
}
