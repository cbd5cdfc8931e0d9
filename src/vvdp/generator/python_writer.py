"""The tree as Python: the same operations in the same order, for people to read, and for CPython to run.

Run on NumPy's floats it gives the bits of the machine code, which shows faults of reading from faults of writing.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vvdp.generator import tree
from vvdp.generator.kinds import BOOL, FLOAT, INT
from vvdp.generator.library import C_LIBRARY, EXACT, FITS, Failure, c_function, cut, is_within_64_bits
from vvdp.generator.llvm_statements import statements_in


def write_python(module: tree.Module) -> str:
    """The text of a module; what it calls besides its own functions are the `names_of` the module."""
    tables: dict[str, tree.Table] = {}
    for function in module.functions:
        for statement in statements_in(function.body):
            _find_tables(statement, tables)
    lines = [
        f"{t.name} = _array({list(t.numbers)!r}, {t.kind.shape!r}, {t.kind.element.value!r})" for t in tables.values()
    ]
    return "\n\n\n".join(["\n".join(lines), *(_function(each) for each in module.functions)]).lstrip() + "\n"


def run_python(module: tree.Module, symbols: Mapping[str, object] | None = None) -> dict[str, Callable[..., Any]]:
    """The entries of a module, written as Python and run by CPython. They take NumPy's floats.

    symbols  functions of other modules by their names
    """
    known = names_of(module) | dict(symbols or {})
    exec(compile(write_python(module), "<generated>", "exec"), known)
    return {name: known[name] for name in module.entries}


def names_of(module: tree.Module) -> dict[str, Any]:
    """Functions and values that the text of a module uses, by name."""

    def fail(number: int) -> None:
        raise Failure(module.reasons[number - 1])

    found: dict[str, Any] = {f"_{name}": function for name, (_, function) in EXACT.items()}
    found |= {f"_{name}": c_function(name) for name in C_LIBRARY}
    found |= {f"_{name}": intrinsic.plain for name, intrinsic in module.intrinsics.items()}
    found |= {"_f": np.float64, "_fail": fail, "_cut": cut, "_fits": is_within_64_bits, "_view": _view_of}
    found |= {"_quotient": _quotient, "_remainder": _remainder, "_left": _shift_left, "_right": _shift_right}
    return found | {"_room": np.empty, "_array": lambda numbers, shape, kind: np.array(numbers, kind).reshape(shape)}


def _view_of(array: np.ndarray[Any, Any], offset: int, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
    return array.reshape(-1)[offset : offset + math.prod(shape)].reshape(shape)


def _quotient(a: int, b: int) -> int:
    return a // b if b else 0


def _remainder(a: int, b: int) -> int:
    return a % b if b else 0


def _shift_left(a: int, b: int) -> int:
    return a << b if 0 <= b < 64 else 0


def _shift_right(a: int, b: int) -> int:
    return a >> (b if 0 <= b < 64 else 63)


def _find_tables(node: Any, found: dict[str, tree.Table]) -> None:
    for name in getattr(type(node), "__slots__", ()):
        inner = getattr(node, name)
        for each in inner if isinstance(inner, tuple) else (inner,):
            if isinstance(each, tree.Table):
                found[each.name] = each
            elif type(each) in EXPRESSED:
                _find_tables(each, found)


def _function(function: tree.Function) -> str:
    parameters = ", ".join(f"{each.name}: {repr(each.kind)!r}" for each in function.parameters)
    head = f"def {function.name}({parameters}) -> {repr(function.result)!r}:"
    return "\n".join([head, f"    # {function.file}:{function.line}", *_block(function.body)])


def _block(block: tree.Block) -> list[str]:
    lines = [line for each in block for line in STATED[type(each)](each)]
    return [f"    {line}" for line in lines or ["pass"]]


def _set(statement: tree.Set) -> list[str]:
    names = ", ".join(variable.name for variable in statement.variables)
    values = ", ".join(whole(value) for value in statement.values)
    return [f"{names} = {values}"]


def _if(statement: tree.If) -> list[str]:
    otherwise = ["else:", *_block(statement.otherwise)] if statement.otherwise else []
    return [f"if {text(statement.test)}:", *_block(statement.then), *otherwise]


def _for(statement: tree.For) -> list[str]:
    limits = ", ".join(map(text, statement.range))
    otherwise = ["else:", *_block(statement.exhausted)] if statement.exhausted else []
    return [f"for {statement.variable.name} in range({limits}):", *_block(statement.body), *otherwise]


STATED: dict[type[Any], Callable[[Any], list[str]]] = {
    tree.Let: lambda s: [f"{s.variable.name} = {whole(s.value)}"],
    tree.Set: _set,
    tree.Store: lambda s: [f"{text(s.array)}[{', '.join(map(text, s.indexes))}] = {text(s.value)}"],
    tree.Do: lambda s: [text(s.call)],
    tree.If: _if,
    tree.For: _for,
    tree.Loop: lambda s: ["while True:", *_block(s.body)],
    tree.Break: lambda s: ["break"],
    tree.Continue: lambda s: ["continue"],
    tree.Return: lambda s: [f"return {'None' if s.value is None else whole(s.value)}"],
    tree.Fail: lambda s: [f"_fail({s.number})"],
}


def text(value: tree.Expression) -> str:
    """An expression as part of another."""
    return EXPRESSED[type(value)](value)


def whole(value: tree.Expression) -> str:
    """An expression by itself: a float that is known is one of NumPy's, which may be divided by 0."""
    if isinstance(value, tree.Constant) and value.kind is FLOAT:
        found = text(value)
        return found if found.startswith("_f(") else f"_f({found})"
    if isinstance(value, tree.Choose):
        return f"{whole(value.then)} if {text(value.test)} else {whole(value.otherwise)}"
    return text(value)


def _constant(value: tree.Constant) -> str:
    if value.kind is FLOAT and not math.isfinite(value.value):
        return f"_f('{value.value}')"
    return repr(value.value) if value.value >= 0 and math.copysign(1.0, value.value) > 0 else f"({value.value!r})"


def _binary(value: tree.Binary) -> str:
    left, right = text(value.left), text(value.right)
    named = {"//": "_quotient", "%": "_remainder", "<<": "_left", ">>": "_right"}
    if value.sign in named and not (isinstance(value.right, tree.Constant) and value.right.value > 0):
        return f"{named[value.sign]}({left}, {right})"
    return f"({left} {value.sign} {right})"


def _convert(value: tree.Convert) -> str:
    operand = text(value.operand)
    if value.kind is FLOAT:
        return f"_f({operand})"
    if value.kind is BOOL:
        return f"({operand} != 0)"
    return f"int({operand})" if value.operand.kind is BOOL else f"_cut({operand})"


def _library(value: tree.Library) -> str:
    if value.name in FITS:
        return f"_fits({text(value.arguments[0])} {value.name.removeprefix('fits')} {text(value.arguments[1])})"
    return f"_{value.name}({', '.join(map(whole, value.arguments))})"


def _item(value: tree.Item) -> str:
    found = f"{text(value.array)}[{', '.join(map(text, value.indexes))}]"
    return f"int({found})" if value.kind is INT else found


def _shape(values: tuple[tree.Expression, ...]) -> str:
    return f"({', '.join(map(text, values))},)"


EXPRESSED: dict[type[Any], Callable[[Any], str]] = {
    tree.Constant: _constant,
    tree.Read: lambda v: v.variable.name,
    tree.Table: lambda v: v.name,
    tree.Unary: lambda v: f"({v.sign} {text(v.operand)})" if v.sign == "not" else f"({v.sign}{text(v.operand)})",
    tree.Binary: _binary,
    tree.Compare: lambda v: f"({text(v.left)} {v.sign} {text(v.right)})",
    tree.Convert: _convert,
    tree.Choose: lambda v: f"({whole(v.then)} if {text(v.test)} else {whole(v.otherwise)})",
    tree.Library: _library,
    tree.Field: lambda v: f"{text(v.record)}[{v.number}]",
    tree.Length: lambda v: f"{text(v.array)}.shape[{v.axis}]",
    tree.Item: _item,
    tree.View: lambda v: f"_view({text(v.array)}, {text(v.offset)}, {_shape(v.sizes)})",
    tree.Room: lambda v: f"_room({_shape(v.sizes)}, {v.kind.element.value!r})",
    tree.Make: lambda v: f"({', '.join('None' if p is None else whole(p) for p in v.parts)},)",
    tree.Call: lambda v: f"{v.function.name}({', '.join(map(whole, v.arguments))})",
    tree.CallAddress: lambda v: f"{text(v.address)}({', '.join(map(whole, v.arguments))})",
    tree.Symbol: lambda v: v.name,
    tree.CallIntrinsic: lambda v: f"_{v.name}({', '.join(map(whole, v.arguments))})",
}
