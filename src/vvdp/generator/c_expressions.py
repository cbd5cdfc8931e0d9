"""Expressions of the tree in C."""

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

from vvdp.generator import tree
from vvdp.generator.c_arithmetic import FITTING, WHOLE
from vvdp.generator.c_text import TYPES, Held, Text, constant, length_names
from vvdp.generator.kinds import BOOL, FLOAT, INT, Address, Kind, Record, Row, Scalar
from vvdp.generator.library import FITS

CHOICE, TRUTH, BITS, ORDER, SUM, PRODUCT, SIGN, NAME = range(8)
"""How strongly the parts of an expression hold together."""
SIGNS = {"+": ("+", SUM), "-": ("-", SUM), "*": ("*", PRODUCT), "/": ("/", PRODUCT)}
BIT_SIGNS = {"&": "&", "|": "|", "^": "^"}
TRUTH_SIGNS = {"&": "&&", "|": "||", "^": "!="}
ORDERS = {"<": "<", "<=": "<=", ">": ">", ">=": ">=", "==": "==", "!=": "!="}
SMALL = 2**31


def strength(value: tree.Expression) -> int:
    """How strongly an expression holds together as it is written."""
    if isinstance(value, tree.Binary):
        if value.kind is FLOAT:
            return SIGNS[value.sign][1]
        return BITS if value.sign in BIT_SIGNS and value.kind is INT else TRUTH if value.kind is BOOL else NAME
    if isinstance(value, tree.Constant):
        negative = value.kind is not BOOL and (value.value < 0 or math.copysign(1.0, value.value) < 0)
        return SUM if negative else NAME
    found: dict[type[Any], int] = {
        tree.Compare: ORDER, tree.Choose: CHOICE, tree.View: SUM, tree.Unary: SIGN, tree.Convert: SIGN,
    }  # fmt: skip
    return found.get(type(value), NAME)


def one(text: Text, value: tree.Expression, at_least: int = CHOICE) -> str:
    """A number or record in C, in brackets if it does not hold together `at_least` as strongly."""
    found = c_form(text, value)[0]
    return f"({found})" if strength(value) < at_least else found


def c_form(text: Text, value: tree.Expression) -> Held:
    """An expression in C."""
    return WRITTEN[type(value)](text, value)


def row(text: Text, value: tree.Expression, target: Kind, *, changes: bool = True) -> Held:
    """An array as one of another type: its address, and the lengths that are open there.

    changes   whether its numbers may be changed by that address
    """
    found, kind = c_form(text, value), value.kind
    assert isinstance(kind, Row) and isinstance(target, Row)
    address = f"({TYPES[kind.element]} *){found[0]}" if changes and isinstance(value, tree.Table) else found[0]
    sizes = lengths(kind, found)
    return (address, *(n for n, wanted in zip(sizes, target.shape, strict=True) if wanted is None))


def lengths(kind: Row, found: Held) -> list[str]:
    """All lengths of an array."""
    left = list(found[1:])
    return [left.pop(0) if n is None else str(n) for n in kind.shape]


def _read(text: Text, value: tree.Read) -> Held:
    name = text.name(value.variable)
    if isinstance(value.kind, Row):
        return (name, *length_names(name, value.kind))
    return (f"*{name}" if text.by_address(value.variable) else name,)


def _unary(text: Text, value: tree.Unary) -> Held:
    if value.sign == "not":
        return (f"!{one(text, value.operand, NAME)}",)
    if value.sign == "-" and value.kind is INT:
        return (f"neg64({one(text, value.operand)})",)
    return (f"{value.sign}{one(text, value.operand, NAME)}",)


def _binary(text: Text, value: tree.Binary) -> Held:
    if value.kind is FLOAT:
        sign, level = SIGNS[value.sign]
        return (f"{one(text, value.left, level)} {sign} {one(text, value.right, level + 1)}",)
    if value.kind is BOOL:
        return (f"{one(text, value.left, ORDER + 1)} {TRUTH_SIGNS[value.sign]} {one(text, value.right, ORDER + 1)}",)
    if value.sign in BIT_SIGNS:
        return (f"{one(text, value.left, SIGN)} {BIT_SIGNS[value.sign]} {one(text, value.right, SIGN)}",)
    return (f"{WHOLE[value.sign]}({one(text, value.left)}, {one(text, value.right)})",)


def _compare(text: Text, value: tree.Compare) -> Held:
    return (f"{one(text, value.left, SUM)} {ORDERS[value.sign]} {one(text, value.right, SUM)}",)


def _convert(text: Text, value: tree.Convert) -> Held:
    if value.kind is BOOL:
        zero = "0.0" if value.operand.kind is FLOAT else "0"
        return (f"({one(text, value.operand, SUM)} != {zero})",)
    if value.kind is INT and value.operand.kind is FLOAT:
        return (f"cut64({one(text, value.operand)})",)
    return (f"({TYPES[value.kind]}){one(text, value.operand, NAME)}",)


def _choose(text: Text, value: tree.Choose) -> Held:
    test, then, otherwise = (one(text, each, TRUTH) for each in (value.test, value.then, value.otherwise))
    if value.kind is INT and f"{then}{otherwise}".isdigit():
        then, otherwise = f"INT64_C({then})", f"INT64_C({otherwise})"
    return (f"{test} ? {then} : {otherwise}",)


def _library(text: Text, value: tree.Library) -> Held:
    name = FITTING[value.name] if value.name in FITS else value.name
    found = [part for each in value.arguments for part in argument(text, each, each.kind, changes=True)]
    return (f"{name}({', '.join(found)})",)


def member(text: Text, record: tree.Expression, number: int) -> str:
    """A field of a record."""
    assert isinstance(record.kind, Record)
    name = text.shared.member(record.kind, number)
    if isinstance(record, tree.Read) and text.by_address(record.variable):
        return f"{text.name(record.variable)}->{name}"
    return f"{one(text, record, NAME)}.{name}"


def _field(text: Text, value: tree.Field) -> Held:
    found = member(text, value.record, value.number)
    if not isinstance(value.kind, Row):
        return (found,)
    assert isinstance(value.record.kind, Record)
    whole = found[: len(found) - len(text.shared.member(value.record.kind, value.number))]
    names = length_names(text.shared.member(value.record.kind, value.number), value.kind)
    return (found, *(f"{whole}{name}" for name in names))


def _length(text: Text, value: tree.Length) -> Held:
    assert isinstance(value.array.kind, Row)
    return (lengths(value.array.kind, c_form(text, value.array))[value.axis],)


def index(text: Text, value: tree.Expression) -> str:
    """A place in an array. A sum with a small number needs no care: beyond 64 bits it is outside of any array."""
    if isinstance(value, tree.Binary) and value.sign in ("+", "-"):
        for each in (value.left, value.right):
            if isinstance(each, tree.Constant) and 0 <= each.value < SMALL:
                return f"{one(text, value.left, SIGN)} {value.sign} {one(text, value.right, SIGN)}"
    return one(text, value)


def item(text: Text, array: tree.Expression, indexes: Sequence[tree.Expression]) -> str:
    """A number in an array."""
    kind = array.kind
    assert isinstance(kind, Row)
    found = c_form(text, array)
    address = f"({found[0]})" if strength(array) < NAME else found[0]
    if len(indexes) == 1:
        return f"{address}[{index(text, indexes[0])}]"
    place = one(text, indexes[0], PRODUCT)
    for each, length in zip(indexes[1:], lengths(kind, found)[1:], strict=True):
        before = f"({place})" if " + " in place else place
        rest = one(text, each, SIGN)
        rows = length if place == "1" else f"{before} * {length}"
        terms = [rows] * (place != "0") + [rest] * (rest != "0")
        place = " + ".join(terms) or "0"
    return f"{address}[{place}]"


def _view(text: Text, value: tree.View) -> Held:
    address = c_form(text, value.array)[0]
    if not (isinstance(value.offset, tree.Constant) and value.offset.value == 0):
        address = f"{address} + {one(text, value.offset, SIGN)}"
    sizes = zip(value.sizes, value.kind.shape, strict=True)
    return (address, *(one(text, size) for size, known in sizes if known is None))


def _make(text: Text, value: tree.Make) -> Held:
    parts = [f".{name} = {initial(found)}" for name, found in fields_made(text, value)]
    return (f"({text.shared.type_of(value.kind)}){{{', '.join(parts) or '0'}}}",)


def initial(value: str) -> str:
    """A value where it is the first of a variable or field: of a record its fields are enough."""
    return re.sub(r"^\(\w+\)(?={)", "", value)


def fields_made(text: Text, value: tree.Make, path: str = "") -> list[tuple[str, str]]:
    """Path and value of each field of a record that is made, those of records within it if `path` is not empty."""
    found: list[tuple[str, str]] = []
    for number, (part, kind) in enumerate(zip(value.parts, value.kind.fields, strict=True)):
        if part is None:
            continue
        name = f"{path}{text.shared.member(value.kind, number)}"
        if isinstance(kind, Row):
            found += zip([name, *length_names(name, kind)], row(text, part, kind), strict=True)
        elif path and isinstance(part, tree.Make):
            found += fields_made(text, part, f"{name}.")
        else:
            found.append((name, one(text, part)))
    return found


def by_address(text: Text, value: tree.Expression) -> str:
    """The address of a record."""
    if isinstance(value, tree.Read) and text.by_address(value.variable):
        return text.name(value.variable)
    return f"&{one(text, value, NAME)}"


def field_of(value: tree.Expression) -> tree.Field | None:
    """The field of a record that holds an array, or the one of which it is a part; None where it is of no record."""
    while isinstance(value, tree.View):
        value = value.array
    return value if isinstance(value, tree.Field) else None


def argument(text: Text, value: tree.Expression, kind: Kind, *, changes: bool) -> list[str]:
    """The text of an argument in a call. The address of an array that a record holds, and which changes, has a name.

    The record is constant, its array is not: without the name, checkers take the array for constant (MISRA rule 11.8).
    """
    if isinstance(kind, Row):
        found = list(row(text, value, kind, changes=changes))
        field = field_of(value)
        if changes and field is not None:
            assert isinstance(field.record.kind, Record)
            name = text.new_name(text.shared.member(field.record.kind, field.number))
            text.optional.add(name)  # an expression may be written twice
            text.put(f"{TYPES[kind.element]} *{name} = {found[0]};")
            found[0] = name
        return found
    return [by_address(text, value) if isinstance(kind, Record) else one(text, value)]


def call(text: Text, value: tree.Call, result: str = "") -> str:
    """A call of a function, which writes a record to the address `result`."""
    function = value.function
    found: list[str] = []
    for each, parameter in zip(value.arguments, function.parameters, strict=True):
        changes = parameter in text.shared.changed[function.name]
        found += argument(text, each, parameter.kind, changes=changes)
    needs = text.shared.needs[function.name]
    extra = [result] * bool(result) + ["failure"] * needs.trouble + ["workspace"] * needs.room
    return f"{text.shared.names[function.name]}({', '.join([*found, *extra])})"


def _call(text: Text, value: tree.Call) -> Held:
    assert isinstance(value.kind, Scalar)
    return (call(text, value),)


def _call_address(text: Text, value: tree.CallAddress) -> Held:
    kind = value.address.kind
    assert isinstance(kind, Address)
    found: list[str] = []
    for each, wanted in zip(value.arguments, kind.arguments, strict=True):
        found += argument(text, each, wanted, changes=True)
    return (f"{one(text, value.address, NAME)}({', '.join([*found, 'failure'])})",)


def _symbol(text: Text, value: tree.Symbol) -> Held:
    """The name of a function of another module, which the text declares."""
    kind = text.shared.type_of(value.kind)
    text.shared.symbols.setdefault(value.name, f"extern const {kind} {value.name};\n")
    return (value.name,)


def call_intrinsic(text: Text, value: tree.CallIntrinsic) -> str:
    """A call of a function that the caller has supplied: of an array its address and all of its lengths."""
    found: list[str] = []
    for each in value.arguments:
        kind = each.kind
        opened = Row(kind.element, (None,) * len(kind.shape)) if isinstance(kind, Row) else kind
        found += argument(text, each, opened, changes=True)
    return f"{value.name}({', '.join(found)})"


WRITTEN: dict[type[Any], Callable[[Text, Any], Held]] = {
    tree.Constant: lambda text, value: (constant(value.kind, value.value),),
    tree.Table: lambda text, value: (text.shared.table(value),),
    tree.Read: _read,
    tree.Unary: _unary,
    tree.Binary: _binary,
    tree.Compare: _compare,
    tree.Convert: _convert,
    tree.Choose: _choose,
    tree.Library: _library,
    tree.Field: _field,
    tree.Length: _length,
    tree.Item: lambda text, value: (item(text, value.array, value.indexes),),
    tree.View: _view,
    tree.Make: _make,
    tree.Call: _call,
    tree.CallAddress: _call_address,
    tree.Symbol: _symbol,
    tree.CallIntrinsic: lambda text, value: (call_intrinsic(text, value),),
}
