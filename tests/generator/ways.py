"""One function five ways: by CPython, from the tree as Python, as machine code at levels 0 and 2, and in C."""

import copy
import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from tests.generator.c_way import c_entries, compilers

from vvdp.generator import binding
from vvdp.generator.calls import callables
from vvdp.generator.kinds import kind_of
from vvdp.generator.llvm_writer import write_llvm
from vvdp.generator.python_writer import run_python
from vvdp.generator.tree import Module
from vvdp.generator.unit import Options, Unit
from vvdp.generator.verify import verify

PLAIN = Options()


def module_of(function: Callable[..., Any], values: tuple[Any, ...], options: Options = PLAIN) -> Module:
    """The verified tree of a function for arguments like these."""
    return module_with({"entry": function}, values, options)


def module_with(entries: dict[str, Callable[..., Any]], values: tuple[Any, ...], options: Options = PLAIN) -> Module:
    """The verified tree of several functions that take arguments like these."""
    unit = Unit(options)
    for name, function in entries.items():
        unit.add(function, [kind_of(value) for value in values], name)
    return verify(unit.module())


def machine_code(module: Module, level: int) -> dict[str, Callable[..., Any]]:
    """The entries of a module as machine code."""
    code = binding.compile_text(write_llvm(module), level)
    return callables(module, binding.load_code(code, module.entries))


def ways_of(module: Module) -> dict[str, Callable[..., Any]]:
    """The entry of a module in every way that a writer makes of it."""
    return {name: entries["entry"] for name, entries in all_ways(module).items()}


def all_ways(module: Module) -> dict[str, dict[str, Callable[..., Any]]]:
    """All entries of a module in every way that a writer makes of them."""
    found = {"tree": run_python(module), "level 0": machine_code(module, 0), "level 2": machine_code(module, 2)}
    return found | {"C": c_entries(module, compilers()[0])} if compilers() else found


def as_numpy(value: Any) -> Any:
    """A value with NumPy's floats, which may be divided by 0, and with arrays of its own."""
    if isinstance(value, tuple):
        return type(value)(*map(as_numpy, value)) if hasattr(value, "_fields") else tuple(map(as_numpy, value))
    return np.float64(value) if type(value) is float else copy.deepcopy(value)


def bits(value: Any) -> Any:
    """What must be the same in every way: of a float its bits, whatever kind of NaN it is."""
    if isinstance(value, tuple | list):
        return tuple(map(bits, value))
    if isinstance(value, np.ndarray) and value.ndim:
        return tuple(map(bits, value.ravel().tolist())) + value.shape
    if isinstance(value, np.ndarray):
        value = value.item()
    if isinstance(value, float | np.floating):
        return "nan" if math.isnan(value) else struct.pack("<d", float(value)).hex()
    if isinstance(value, bool | np.bool_):
        return bool(value)
    return value if value is None else int(value)


def run(function: Callable[..., Any], values: tuple[Any, ...]) -> Any:
    """What a function gives, and what it leaves in the arrays that it was handed."""
    handed = tuple(map(as_numpy, values))
    with np.errstate(all="ignore"):
        result = function(*handed)
    return bits(result), bits(tuple(value for value in handed if isinstance(value, np.ndarray)))


def results(function: Callable[..., Any], *values: Any, options: Options = PLAIN) -> dict[str, Any]:
    """The bits that each way gives."""
    found = {"CPython": run(function, values)}
    for name, way in ways_of(module_of(function, values, options)).items():
        found[name] = run(way, values)
    return found
