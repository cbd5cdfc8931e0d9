"""Expressions of the tree as LLVM instructions."""

from collections.abc import Callable
from typing import Any

from vvdp.generator import tree
from vvdp.generator.kinds import (
    BOOL,
    FLOAT,
    INT,
    Known,
    Record,
    Row,
    Scalar,
    has_rows,
    leaves,
    place,
    registers_of,
    size,
)
from vvdp.generator.library import C_LIBRARY, EXACT, FITS
from vvdp.generator.llvm_text import (
    SELDOM,
    TYPES,
    Registers,
    Shared,
    Text,
    arguments_text,
    constant,
    is_held_in_memory,
    open_lengths,
    result_type,
)

FLOAT_SIGNS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
WHOLE_SIGNS = {"+": "add", "-": "sub", "*": "mul", "&": "and", "|": "or", "^": "xor"}
ORDERS = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge"}
PURE = "nounwind willreturn memory(none)"


def registers(text: Text, value: tree.Expression) -> Registers:
    """Writes what calculates an expression; what it is held in."""
    return WRITTEN[type(value)](text, value)


def one(text: Text, value: tree.Expression) -> str:
    """The register of a number, or of the address of a record."""
    return registers(text, value)[0]


def _read(text: Text, value: tree.Read) -> Registers:
    variable = value.variable
    if variable in text.kept:
        if isinstance(variable.kind, Record):
            return text.kept[variable]
        return tuple(text.load(t, a) for t, a in zip(leaves(variable.kind), text.kept[variable], strict=True))
    return text.held[variable]


def _unary(text: Text, value: tree.Unary) -> Registers:
    operand = one(text, value.operand)
    if value.sign == "not":
        return (text.get(f"xor i1 {operand}, true"),)
    if value.sign == "~":
        return (text.get(f"xor i64 {operand}, -1"),)
    return (text.get(f"fneg double {operand}" if value.kind is FLOAT else f"sub i64 0, {operand}"),)


def _binary(text: Text, value: tree.Binary) -> Registers:
    left, right = one(text, value.left), one(text, value.right)
    if value.kind is FLOAT:
        return (text.get(f"{FLOAT_SIGNS[value.sign]} double {left}, {right}"),)
    if value.sign in WHOLE_SIGNS:
        return (text.get(f"{WHOLE_SIGNS[value.sign]} {TYPES[value.kind]} {left}, {right}"),)
    if value.sign in ("<<", ">>"):
        return (_shift(text, value.sign, left, right),)
    return (_floor_divided(text, value.sign, left, right, value.right),)


def _shift(text: Text, sign: str, left: str, right: str) -> str:
    """A shift, of which 64 places and more leave nothing but the sign."""
    inside = text.get(f"icmp ult i64 {right}, 64")
    if sign == ">>":
        return text.get(f"ashr i64 {left}, {text.get(f'select i1 {inside}, i64 {right}, i64 63')}")
    moved = text.get(f"shl i64 {left}, {text.get(f'select i1 {inside}, i64 {right}, i64 0')}")
    return text.get(f"select i1 {inside}, i64 {moved}, i64 0")


def _floor_divided(text: Text, sign: str, left: str, right: str, divisor: tree.Expression) -> str:
    """Python's `//` or `%`; both are 0 where the divisor is, as NumPy has it."""
    if isinstance(divisor, tree.Constant) and divisor.value not in (0, -1):
        return _floor(text, sign, left, right)
    is_zero, is_minus = text.get(f"icmp eq i64 {right}, 0"), text.get(f"icmp eq i64 {right}, -1")
    special = text.get(f"or i1 {is_zero}, {is_minus}")  # the processor traps at 0, and at -1 under the lowest number
    found = _floor(text, sign, left, text.get(f"select i1 {special}, i64 1, i64 {right}"))
    if sign == "%":
        return found
    negative = text.get(f"select i1 {is_minus}, i64 {text.get(f'sub i64 0, {left}')}, i64 {found}")
    return text.get(f"select i1 {is_zero}, i64 0, i64 {negative}")


def _floor(text: Text, sign: str, left: str, right: str) -> str:
    rest = text.get(f"srem i64 {left}, {right}")
    signs = text.get(f"xor i64 {rest}, {right}")
    differ, some = text.get(f"icmp slt i64 {signs}, 0"), text.get(f"icmp ne i64 {rest}, 0")
    wrong = text.get(f"and i1 {differ}, {some}")
    if sign == "%":
        return text.get(f"select i1 {wrong}, i64 {text.get(f'add i64 {rest}, {right}')}, i64 {rest}")
    share = text.get(f"sdiv i64 {left}, {right}")
    return text.get(f"select i1 {wrong}, i64 {text.get(f'sub i64 {share}, 1')}, i64 {share}")


def _compare(text: Text, value: tree.Compare) -> Registers:
    left, right, kind = one(text, value.left), one(text, value.right), value.left.kind
    if kind is FLOAT:
        order = {"==": "oeq", "!=": "une"}.get(value.sign) or f"o{ORDERS[value.sign]}"
        return (text.get(f"fcmp {order} double {left}, {right}"),)
    order = {"==": "eq", "!=": "ne"}.get(value.sign) or f"{'u' if kind is BOOL else 's'}{ORDERS[value.sign]}"
    return (text.get(f"icmp {order} {TYPES[kind]} {left}, {right}"),)


def _convert(text: Text, value: tree.Convert) -> Registers:
    register, kind = one(text, value.operand), value.operand.kind
    if value.kind is FLOAT:
        return (text.get(f"{'sitofp i64' if kind is INT else 'uitofp i1'} {register} to double"),)
    if value.kind is BOOL:
        zero = "fcmp une double {}, 0.0" if kind is FLOAT else "icmp ne i64 {}, 0"
        return (text.get(zero.format(register)),)
    if kind is BOOL:
        return (text.get(f"zext i1 {register} to i64"),)
    return (text.call("i64", "llvm.fptosi.sat.i64.f64", f"double {register}", "double"),)


def _choose(text: Text, value: tree.Choose) -> Registers:
    test, then, otherwise = (one(text, each) for each in (value.test, value.then, value.otherwise))
    kind = TYPES[value.kind]
    return (text.get(f"select i1 {test}, {kind} {then}, {kind} {otherwise}"),)


def _library(text: Text, value: tree.Library) -> Registers:
    numbers = [one(text, each) for each in value.arguments]
    if value.name in FITS:
        return (_fits(text, FITS[value.name], *numbers),)
    floats, types = ", ".join(f"double {n}" for n in numbers), ", ".join(["double"] * len(numbers))
    if value.name in EXACT:
        return (text.call("double", f"llvm.{value.name}.f64", floats, types),)
    if value.name in C_LIBRARY:
        declare_library(text.shared, value.name, len(numbers))
        return (text.get(f"call double @{value.name}({floats}) nobuiltin"),)
    return (text.get(f"call double @{value.name}({floats})"),)


def declare_library(shared: Shared, name: str, count: int) -> None:
    """Declares a function of the C library; one that LLVM takes for the function it knows, it replaces by others."""
    types = ", ".join(["double"] * count)
    shared.declared.setdefault(name, f"declare double @{name}({types}) nobuiltin {PURE}")


def _fits(text: Text, name: str, left: str, right: str) -> str:
    """Whether an operation on whole numbers stays within 64 bits."""
    if not name:
        return text.get(f"icmp ult i64 {right}, 64")
    pair = "{ i64, i1 }"
    whole = text.call(pair, f"llvm.{name}.with.overflow.i64", f"i64 {left}, i64 {right}", "i64, i64")
    return text.get(f"xor i1 {text.get(f'extractvalue {pair} {whole}, 1')}, true")


def _field(text: Text, value: tree.Field) -> Registers:
    kind = value.record.kind
    assert isinstance(kind, Record)
    return text.load_value(value.kind, text.offset(one(text, value.record), place(kind, value.number)))


def lengths(text: Text, array: tree.Expression) -> tuple[Registers, list[str]]:
    """Registers of an array, and all of its lengths."""
    kind = array.kind
    assert isinstance(kind, Row)
    found = registers(text, array)
    return found, list(open_lengths(found, kind, Row(kind.element, (None,) * len(kind.shape)))[1:])


def _length(text: Text, value: tree.Length) -> Registers:
    return (lengths(text, value.array)[1][value.axis],)


def item_address(text: Text, array: tree.Expression, indexes: tuple[tree.Expression, ...]) -> str:
    """The address of a number in an array."""
    found, sizes = lengths(text, array)
    position = one(text, indexes[0])
    for index, length in zip(indexes[1:], sizes[1:], strict=True):
        row = text.get(f"mul i64 {position}, {length}")
        position = text.get(f"add i64 {row}, {one(text, index)}")
    return text.get(f"getelementptr inbounds double, ptr {found[0]}, i64 {position}")


def _item(text: Text, value: tree.Item) -> Registers:
    return (text.load(value.kind, item_address(text, value.array, value.indexes)),)


def _view(text: Text, value: tree.View) -> Registers:
    address = one(text, value.array)
    if not (isinstance(value.offset, tree.Constant) and value.offset.value == 0):
        address = text.get(f"getelementptr inbounds double, ptr {address}, i64 {one(text, value.offset)}")
    return (address, *_open_sizes(text, value))


def _open_sizes(text: Text, value: tree.View | tree.Room) -> list[str]:
    return [one(text, n) for n, known in zip(value.sizes, value.kind.shape, strict=True) if known is None]


def _room(text: Text, value: tree.Room) -> Registers:
    """Room at the beginning of the function where it is known how much, and nothing outlives it; else of the
    context.
    """
    if is_own_room(text.hoisted, text.function.result, value):
        count = 1
        for length in value.kind.shape:
            count *= length or 0
        return (text.slot(count, "row"),)
    count_register = "1"
    for each in value.sizes:
        count_register = text.get(f"mul i64 {count_register}, {one(text, each)}")
    return (text.get(f"call ptr @generator_room(ptr %context, i64 {count_register})"), *_open_sizes(text, value))


def is_own_room(hoisted: bool, result: Any, value: tree.Room) -> bool:
    """Whether an array lies in the frame of its function."""
    return hoisted and None not in value.kind.shape and not has_rows(result)


def _make(text: Text, value: tree.Make) -> Registers:
    slot = text.slot(size(value.kind), "record")
    for number, (part, kind) in enumerate(zip(value.parts, value.kind.fields, strict=True)):
        if part is not None:
            found = open_lengths(registers(text, part), part.kind, kind)
            text.store_value(kind, found, text.offset(slot, place(value.kind, number)))
    return (slot,)


def _call(text: Text, value: tree.Call) -> Registers:
    function = value.function
    kinds = [parameter.kind for parameter in function.parameters]
    values = [open_lengths(registers(text, v), v.kind, k) for v, k in zip(value.arguments, kinds, strict=True)]
    arguments = [arguments_text(kinds, values)] if values else []
    needs, slot = text.needs[function.name], ""
    if is_held_in_memory(function.result):
        slot = text.slot(size(function.result), "result")
        arguments.insert(0, f"ptr {slot}")
    if needs.context:
        arguments.append("ptr %context")
    instruction = f'call {result_type(function.result)} @"{function.name}"({", ".join(arguments)})'
    found = write_call(text, instruction, function.result, slot)
    if needs.trouble:
        leave_on_trouble(text)
    return found


def write_call(text: Text, instruction: str, result: Any, slot: str = "") -> Registers:
    """Writes a call; what its result is held in."""
    if isinstance(result, Scalar):
        return (text.get(instruction),)
    text.put(instruction)
    return () if isinstance(result, Known) else text.load_value(result, slot)


def trouble_address(text: Text) -> str:
    """Where the number of a failure is kept."""
    return text.get(f"load ptr, ptr {text.offset('%context', 3)}, align 8")


def leave_on_trouble(text: Text) -> None:
    """Leaves the function where the one that it has called has failed."""
    failed = text.get(f"icmp ne i64 {text.get(f'load i64, ptr {trouble_address(text)}, align 8')}, 0")
    leave, on = text.label("failed"), text.label("on")
    text.end(f"br i1 {failed}, label %{leave}, label %{on}, !prof !{SELDOM}")
    text.begin(leave)
    return_nothing(text)
    text.begin(on)


def return_nothing(text: Text) -> None:
    """Leaves the function without a result that means anything."""
    result = text.function.result
    text.end(f"ret {TYPES[result]} {constant(result, 0)}" if isinstance(result, Scalar) else "ret void")


def _call_address(text: Text, value: tree.CallAddress) -> Registers:
    kinds = value.address.kind.arguments  # type: ignore[union-attr]
    values = [open_lengths(registers(text, v), v.kind, k) for v, k in zip(value.arguments, kinds, strict=True)]
    address, handed = one(text, value.address), arguments_text(kinds, values)
    handed = ", ".join(filter(None, (handed, f"ptr {trouble_address(text)}")))
    found = write_call(text, f"call {result_type(value.kind)} {address}({handed})", value.kind)
    leave_on_trouble(text)
    return found


def _symbol(text: Text, value: tree.Symbol) -> Registers:
    kinds = value.kind
    types = ", ".join([*(TYPES[t] for kind in kinds.arguments for t in registers_of(kind)), "ptr"])
    result = "void" if kinds.result is None else TYPES[kinds.result]
    text.shared.declared.setdefault(value.name, f"declare {result} @{value.name}({types})")
    return (f"@{value.name}",)


def _call_intrinsic(text: Text, value: tree.CallIntrinsic) -> Registers:
    kinds = [each.kind for each in value.arguments]
    values = [registers(text, each) for each in value.arguments]
    opened = [Row(k.element, (None,) * len(k.shape)) if isinstance(k, Row) else k for k in kinds]
    values = [open_lengths(v, k, o) for v, k, o in zip(values, kinds, opened, strict=True)]
    instruction = f"call {result_type(value.kind)} @{value.name}({arguments_text(opened, values)})"
    return write_call(text, instruction, value.kind)


WRITTEN: dict[type[Any], Callable[[Text, Any], Registers]] = {
    tree.Constant: lambda text, value: (constant(value.kind, value.value),),
    tree.Table: lambda text, value: text.table(value),
    tree.Read: _read,
    tree.Unary: _unary,
    tree.Binary: _binary,
    tree.Compare: _compare,
    tree.Convert: _convert,
    tree.Choose: _choose,
    tree.Library: _library,
    tree.Field: _field,
    tree.Length: _length,
    tree.Item: _item,
    tree.View: _view,
    tree.Room: _room,
    tree.Make: _make,
    tree.Call: _call,
    tree.CallAddress: _call_address,
    tree.Symbol: _symbol,
    tree.CallIntrinsic: _call_intrinsic,
}
