"""Statements of the tree in C."""

from collections.abc import Callable
from typing import Any

from vvdp.generator import tree
from vvdp.generator.c_expressions import NAME, SUM, c_form, call, fields_made, initial, item, one, row
from vvdp.generator.c_scopes import has_effect, reads_in
from vvdp.generator.c_text import Text, length_names
from vvdp.generator.kinds import FLOAT, INT, Kind, Known, Record, Row, Scalar, has_rows
from vvdp.generator.llvm_expressions import is_own_room
from vvdp.generator.llvm_statements import carries_rows, falls_through, has_break, takes_room


def write_block(text: Text, block: tree.Block) -> None:
    """Writes statements; what cannot be reached is left out."""
    for number, each in enumerate(block):
        for variable in text.scopes.before.get((id(block), number), ()):
            declare(text, variable)
        if is_handed_on(block[number:]):
            assert isinstance(each, tree.Let) and isinstance(each.value, tree.Call)
            _hand_on(text, each.value)
            return
        WRITTEN[type(each)](text, each)
        if not falls_through((each,)):
            return


def is_handed_on(block: tree.Block) -> bool:
    """Whether a block begins with a call whose record is the result of the function."""
    if len(block) < 2 or not isinstance(block[0], tree.Let) or not isinstance(block[1], tree.Return):
        return False
    let, value = block[0], block[1].value
    is_record = isinstance(let.value, tree.Call) and isinstance(let.value.kind, Record)
    return is_record and isinstance(value, tree.Read) and value.variable is let.variable


def _hand_on(text: Text, value: tree.Call) -> None:
    """Lets another function write the result of this one."""
    text.put(f"{call(text, value, 'result')};")
    if text.own.room and not has_rows(text.function.result):
        text.put("*workspace = entered;")
    text.put("return;")


def declare(text: Text, variable: tree.Variable) -> None:
    """Declares a variable that is assigned later."""
    if variable not in text.scopes.live:
        return
    name, kind = text.name(variable), variable.kind
    if isinstance(kind, Row):
        text.put(f"{text.row_type(variable)}{name};")
        for each in length_names(name, kind):
            text.optional.add(each)
            text.put(f"int64_t {each};")
    else:
        text.put(f"{text.shared.type_of(kind)} {name};")


def is_here(text: Text, variable: tree.Variable, statement: tree.Statement) -> bool:
    """Whether a variable is declared by this statement."""
    return (variable, id(statement)) in text.scopes.here


def assign(text: Text, variable: tree.Variable, values: tuple[str, ...], head: str = "") -> None:
    """Writes what a variable is from here on; `head` stands before its name where this declares it."""
    name, kind = text.name(variable), variable.kind
    if not isinstance(kind, Row):
        own = text.shared.type_of(kind)
        text.put(f"{head}{own} {name} = {initial(values[0])};" if head else f"{name} = {values[0]};")
        return
    text.put(f"{text.row_type(variable) if head else ''}{name} = {values[0]};")
    for each, value in zip(length_names(name, kind), values[1:], strict=True):
        text.optional.add(each)
        text.put(f"{head}{'int64_t ' if head else ''}{each} = {value};")


def value_as(text: Text, value: tree.Expression, variable: tree.Variable) -> tuple[str, ...]:
    """An expression as the value of a variable."""
    if isinstance(variable.kind, Row):
        return row(text, value, variable.kind, changes=variable in text.changed)
    return (one(text, value),)


def _let(text: Text, statement: tree.Let) -> None:
    variable, value = statement.variable, statement.value
    if isinstance(value, tree.Call | tree.CallAddress | tree.CallIntrinsic):
        _write_call(text, statement)
        leave_on_failure(text, value)
    elif variable in text.scopes.live:
        head = "const " if is_here(text, variable, statement) else ""
        if isinstance(value, tree.Room):
            _room(text, variable, value, head)
        else:
            assign(text, variable, value_as(text, value, variable), head)
            text.optional.add(text.name(variable))


def _write_call(text: Text, statement: tree.Let) -> None:
    """A call whose result has a name. Records and arrays are written where the call says."""
    variable, value = statement.variable, statement.value
    here, is_live = is_here(text, variable, statement), variable in text.scopes.live
    if isinstance(value, tree.CallAddress) or isinstance(value.kind, Scalar):
        found = c_form(text, value)
        if is_live:
            assign(text, variable, found, "const " if here else "")
        else:
            text.put(f"(void){found[0]};")
        return
    assert isinstance(value, tree.Call)
    kind = result_record(value.kind)
    if isinstance(value.kind, Record) and is_live and not here:
        text.put(f"{call(text, value, f'&{text.name(variable)}')};")
        return
    name = text.name(variable) if isinstance(value.kind, Record) else text.new_name(f"{variable.name}_found")
    fails = text.shared.needs[value.function.name].trouble
    text.put(f"{text.shared.type_of(kind)} {name}{' = {0}' if fails else ''};")
    text.put(f"{call(text, value, f'&{name}')};")
    if isinstance(value.kind, Row) and is_live:
        lengths = [f"{name}.{each}" for each in length_names("at", value.kind)]
        assign(text, variable, (f"{name}.at", *lengths), "const " if here else "")


def result_record(kind: Kind) -> Kind:
    """The record that a function writes for a result which is no number."""
    from vvdp.generator.c_text import RowResult

    return Record(RowResult, (kind,)) if isinstance(kind, Row) else kind


def leave_on_failure(text: Text, value: tree.Call | tree.CallAddress | tree.CallIntrinsic) -> None:
    """Leaves the function where the one that it has called has failed."""
    if isinstance(value, tree.CallIntrinsic):
        return
    if isinstance(value, tree.CallAddress) or text.shared.needs[value.function.name].trouble:
        text.put("if (*failure != 0) {")
        text.put(f"    {nothing(text)}")
        text.put("}")


def nothing(text: Text) -> str:
    """Leaves the function without a result that means anything."""
    kind = text.function.result
    if not isinstance(kind, Scalar):
        return "return;"
    return f"return {'0.0' if kind is FLOAT else '0' if kind is INT else 'false'};"


def _room(text: Text, variable: tree.Variable, value: tree.Room, head: str) -> None:
    name, kind = text.name(variable), text.shared.type_of(value.kind)
    if is_own_room(text.hoisted, text.function.result, value):
        count = 1
        for length in value.kind.shape:
            count *= length or 0
        own = text.new_name(f"{name}_room")
        text.rooms.append(f"    {kind} {own}[{max(1, count)}];")
        assign(text, variable, (own, *_sizes(text, value)), head)
        return
    sizes = [one(text, each) for each in value.sizes]
    count_text = sizes[0]
    for each in sizes[1:]:
        count_text = f"mul64({count_text}, {each})"
    take = "take_wholes" if value.kind.element is INT else "take_reals"
    assign(text, variable, (f"{take}(workspace, {count_text}, failure)", *_sizes(text, value)), head)
    text.put("if (*failure != 0) {")
    text.put(f"    {nothing(text)}")
    text.put("}")


def _sizes(text: Text, value: tree.Room) -> list[str]:
    return [one(text, n) for n, known in zip(value.sizes, value.kind.shape, strict=True) if known is None]


def _set(text: Text, statement: tree.Set) -> None:
    """All values are at hand before the first is kept, if one is calculated from what another replaces."""
    pairs = [
        (variable, value_as(text, value, variable), value)
        for variable, value in zip(statement.variables, statement.values, strict=True)
        if variable in text.scopes.live or has_effect(value)
    ]
    replaced = {variable for variable, _, _ in pairs}
    if len(pairs) > 1 and any(v is not variable and v in replaced for variable, _, e in pairs for v in reads_in((e,))):
        pairs = [(variable, _beside(text, variable, found), value) for variable, found, value in pairs]
    for variable, found, _ in pairs:
        first = is_here(text, variable, statement)
        if first and not isinstance(variable.kind, Row):
            own = text.shared.type_of(variable.kind)
            text.put(f"{own} {text.name(variable)} = {initial(found[0])};")
        elif first:
            declare(text, variable)
            assign(text, variable, found)
        else:
            assign(text, variable, found)


def _beside(text: Text, variable: tree.Variable, values: tuple[str, ...]) -> tuple[str, ...]:
    """The values under names of their own."""
    kinds = [text.shared.type_of(variable.kind), *["int64_t"] * (len(values) - 1)]
    kinds[0] = text.row_type(variable) if isinstance(variable.kind, Row) else f"const {kinds[0]} "
    found = []
    for kind, value in zip(kinds, values, strict=True):
        name = text.new_name("next")
        text.put(f"{kind}{name} = {value};" if kind[-1] in "* " else f"const {kind} {name} = {value};")
        found.append(name)
    return tuple(found)


def _store(text: Text, statement: tree.Store) -> None:
    text.put(f"{item(text, statement.array, statement.indexes)} = {one(text, statement.value)};")


def _do(text: Text, statement: tree.Do) -> None:
    value = statement.call
    if isinstance(value, tree.CallAddress | tree.CallIntrinsic):
        text.put(f"{c_form(text, value)[0]};")
    elif isinstance(value.kind, Known):
        text.put(f"{call(text, value)};")
    elif isinstance(value.kind, Scalar):
        text.put(f"(void){call(text, value)};")
    else:
        name = text.new_name("unused")
        text.put(f"{text.shared.type_of(result_record(value.kind))} {name};")
        text.put(f"{call(text, value, f'&{name}')};")
    leave_on_failure(text, value)


def _if(text: Text, statement: tree.If) -> None:
    then, otherwise = (_inner(text, block) for block in (statement.then, statement.otherwise))
    test = one(text, statement.test)
    if not then and not otherwise:
        return
    if not then:
        text.put(f"if (!{one(text, statement.test, NAME)}) {{")
        text.lines += otherwise
    else:
        text.put(f"if ({test}) {{")
        text.lines += then
        if otherwise:
            text.put("} else {")
            text.lines += otherwise
    text.put("}")


def _inner(text: Text, block: tree.Block) -> list[str]:
    """The lines of a block within a statement."""
    before, text.lines = text.lines, []
    text.depth += 1
    write_block(text, block)
    text.depth -= 1
    found, text.lines = text.lines, before
    return found


def _for(text: Text, statement: tree.For) -> None:
    name = text.name(statement.variable)
    first, last, step = statement.range
    end = _limit(text, last, "end")
    if isinstance(step, tree.Constant):
        test = f"{name} {'<' if step.value > 0 else '>'} {end}"
        count = {1: f"{name}++", -1: f"{name}--"}.get(step.value, "")
    else:
        by = _limit(text, step, "by")
        test, count = f"{by} > 0 ? {name} < {end} : {name} > {end}", ""
    if not count:
        by = one(text, step) if isinstance(step, tree.Constant) else by
        count = f"{name} = add64({name}, {by})"
    left = ""
    if statement.exhausted and has_break(statement.body):
        left = text.new_name("is_left")
        text.put(f"bool {left} = false;")
        text.optional.add(left)
    _round(text, f"for (int64_t {name} = {one(text, first)}; {test}; {count}) {{", statement.body, left)
    if not left:
        write_block(text, statement.exhausted)
    elif lines := _inner(text, statement.exhausted):
        text.put(f"if (!{left}) {{")
        text.lines += lines
        text.put("}")


def _limit(text: Text, value: tree.Expression, name: str) -> str:
    """A number of a range, calculated before the first round."""
    if isinstance(value, tree.Constant) or (isinstance(value, tree.Read) and text.is_fixed(value.variable)):
        return one(text, value, SUM)
    found = text.new_name(name)
    text.put(f"const int64_t {found} = {one(text, value)};")
    return found


def _loop(text: Text, statement: tree.Loop) -> None:
    _round(text, "for (;;) {", statement.body, "")


def _round(text: Text, head: str, block: tree.Block, left: str) -> None:
    """One round of a loop. Room that the one before took is given back where no array is carried on."""
    before, carried = text.hoisted, carries_rows(block)
    text.hoisted = before and not carried
    free = ""
    if not carried and takes_room(text, block):
        free = text.new_name("before")
        text.put(f"const {text.shared.prefix}_workspace {free} = *workspace;")
    text.put(head)
    if free:
        text.put(f"    *workspace = {free};")
    text.loops.append(left)
    text.lines += _inner(text, block)
    text.loops.pop()
    text.hoisted = before
    text.put("}")


def _break(text: Text, statement: tree.Break) -> None:
    if text.loops[-1]:
        text.put(f"{text.loops[-1]} = true;")
    text.put("break;")


def _return(text: Text, statement: tree.Return) -> None:
    result, value = text.function.result, statement.value
    frees = text.own.room and not has_rows(result)
    if value is None or isinstance(result, Known):
        lines = ["return;"]
    elif isinstance(result, Scalar):
        lines = [f"return {one(text, value)};"]
        if frees and not isinstance(value, tree.Constant | tree.Read):
            found = text.new_name("found")
            text.put(f"const {text.shared.type_of(result)} {found} = {one(text, value)};")
            lines = [f"return {found};"]
    elif isinstance(result, Row):
        names = ["at", *length_names("at", result)]
        lines = [f"result->{n} = {v};" for n, v in zip(names, row(text, value, result), strict=True)] + ["return;"]
    else:
        made = fields_made(text, value, "result->") if isinstance(value, tree.Make) else []
        parts = made or [("*result", one(text, value))]  # fields are written one by one, so that none is copied
        lines = [*(f"{path} = {each};" for path, each in parts), "return;"]
    for line in [*lines[:-1], *["*workspace = entered;"] * frees, lines[-1]]:
        text.put(line)


def _fail(text: Text, statement: tree.Fail) -> None:
    text.put(f"*failure = {statement.number};")
    text.put(nothing(text))


WRITTEN: dict[type[Any], Callable[[Text, Any], None]] = {
    tree.Let: _let,
    tree.Set: _set,
    tree.Store: _store,
    tree.Do: _do,
    tree.If: _if,
    tree.For: _for,
    tree.Loop: _loop,
    tree.Break: _break,
    tree.Continue: lambda text, statement: text.put("continue;"),
    tree.Return: _return,
    tree.Fail: _fail,
}
