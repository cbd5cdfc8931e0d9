"""Functions and constants that a plain function reaches, and the words for them that a hash is taken of."""

import dis
import enum
import types
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

from vvdp.base.errors import RunError
from vvdp.base.select import select

Functions = dict[str, tuple[types.FunctionType, list[Any]]]
"""By a name of its own each function, and the constants that it uses."""

FOREIGN = ("numpy", "math", "cmath", "builtins", "operator", "typing", "_operator")
"""Packages whose functions and values are known by their names; their versions are part of the hash."""
MISSING = object()


def reachable(function: Callable[..., Any], found: Functions) -> Functions:
    """Every plain function that `function` calls by name, and every constant these use, added to `found`.

    Raises RunError where a function or a constant is none that a hash can vouch for, with its name.
    """
    if not isinstance(function, types.FunctionType):
        raise RunError(f"{function!r} is not a plain function; circuits and programs are module-level functions")
    key = f"{function.__module__}.{function.__qualname__}.{id(function)}"
    if key in found:
        return found
    if function.__closure__:
        raise RunError(f"{function.__qualname__} closes over variables; hand values over in params instead")
    constants: list[Any] = []
    found[key] = (function, constants)
    if function is select:  # compiled code has its own text for it; the plain one reaches for casadi
        return found
    where = f"a default of {function.__qualname__}"
    constants.append(_name_value(where, (function.__defaults__, tuple((function.__kwdefaults__ or {}).items())), found))
    if faster := compiled_form(function):
        reachable(faster, found)
        return found
    for path in sorted(set(paths(function.__code__))):
        name, value = _value(path, function)
        if value is not MISSING:
            constants.append((path, _name_value(f"{name} (in {function.__qualname__})", value, found)))
    return found


def compiled_form(function: Callable[..., Any]) -> Callable[..., Any] | None:
    """The function that replaces `function` in compiled code: its module's `<name>_compiled`, if there is one.

    It gives the same values faster, with plain conditionals that arrays and symbols could not pass.
    """
    form = function.__globals__.get(compiled_name(function))
    return form if isinstance(form, types.FunctionType) else None


def compiled_name(function: Callable[..., Any]) -> str:
    """The name under which `compiled_form` is looked for."""
    return f"{function.__name__}_compiled"


def words(functions: Functions) -> Iterator[str]:
    """Words from which a hash of `functions` is formed: their code without its place in a file, and their constants."""
    for function, constants in sorted(functions.values(), key=lambda entry: _name(entry[0])):
        yield own_words(function, constants)


def own_words(function: types.FunctionType, constants: list[Any]) -> str:
    """The words for one function: its name, what it does, and the constants that it uses."""
    return f"{_name(function)} {_text(function.__code__)} {constants!r}"


def _name(function: types.FunctionType) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _text(code: types.CodeType) -> str:
    """Operations of a function, without their place in a file: bytecode, constants and names."""
    constants = [
        _text(c) if isinstance(c, types.CodeType) else repr(c)
        for c in code.co_consts[1 if code.co_consts and isinstance(code.co_consts[0], str) else 0 :]
    ]
    return repr((code.co_code, constants, code.co_names, code.co_varnames))


@cache
def paths(code: types.CodeType) -> tuple[tuple[str, ...], ...]:
    """Each global name that code reads, with the attributes that it takes of it."""
    found: list[tuple[str, ...]] = []
    path: tuple[str, ...] = ()
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            if path:
                found.append(path)
            path = (instruction.argval,)
        elif instruction.opname in ("LOAD_ATTR", "LOAD_METHOD") and path:
            path = (*path, instruction.argval)
        elif instruction.opname not in ("CACHE", "PUSH_NULL", "EXTENDED_ARG", "NOP"):
            if path:
                found.append(path)
            path = ()
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            found += paths(constant)
    return tuple(found)


def _value(path: tuple[str, ...], function: types.FunctionType) -> tuple[str, Any]:
    """The part of a path that leads through modules and enums, and what stands there; MISSING where nothing does."""
    reached, value = path[0], function.__globals__.get(path[0], MISSING)
    for name in path[1:]:
        if not isinstance(value, types.ModuleType | enum.EnumMeta) or _is_foreign(value):
            break
        reached, value = f"{reached}.{name}", getattr(value, name, MISSING)
    return reached, value


def value_at(path: tuple[str, ...], function: types.FunctionType) -> Any:
    """Value at a path of names that `function` reads; MISSING if there is none."""
    return _value(path, function)[1]


def known_words(where: str, value: Any) -> Any:
    """Words that differ wherever a constant does. Raises RunError where there are none, with `where` it is read."""
    return _name_value(where, value, {})


def _is_foreign(value: Any) -> bool:
    home = value.__name__ if isinstance(value, types.ModuleType) else getattr(value, "__module__", None)
    return isinstance(value, np.ufunc) or (isinstance(home, str) and home.partition(".")[0] in FOREIGN)


def _name_value(where: str, value: Any, found: Functions) -> Any:
    """Words that differ wherever `value` does."""
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        plain = value.value if isinstance(value, enum.Enum) else value
        return (type(value).__module__, type(value).__qualname__, repr(plain))
    if isinstance(value, enum.Enum):
        return (type(value).__qualname__, value.name, _name_value(where, value.value, found))
    if isinstance(value, tuple):
        named = type(value).__qualname__, getattr(value, "_fields", ())
        return (*named, tuple(_name_value(where, inner, found) for inner in value))
    if isinstance(value, np.ndarray | np.generic) and value.dtype.hasobject is False:
        return (str(value.dtype), np.shape(value), value.tobytes())
    if isinstance(value, type):
        return _known_class(where, value, found)
    if callable(value) and _is_foreign(value):
        return f"{getattr(value, '__module__', 'numpy')}.{getattr(value, '__qualname__', value)}"
    if isinstance(value, types.FunctionType):
        reachable(value, found)
        return _name(value)
    if isinstance(value, types.ModuleType) and _is_foreign(value):
        return value.__name__
    raise RunError(f"{where} is {_kind(value)}")


def _known_class(where: str, cls: type, found: Functions) -> Any:
    name = f"{cls.__module__}.{cls.__qualname__}"
    if hasattr(cls, "_fields"):
        defaults = tuple(getattr(cls, "_field_defaults", {}).items())
        return (name, cls._fields, _name_value(where, defaults, found))
    if issubclass(cls, enum.Enum):
        return (name, tuple(_name_value(where, member, found) for member in cls))
    if issubclass(cls, BaseException) or _is_foreign(cls):
        return name
    raise RunError(f"{where} is a class that compiled code cannot make; write a NamedTuple")


def _kind(value: Any) -> str:
    """Type of a value that no hash can cover, and what to write instead."""
    if isinstance(value, list | dict | set):
        return f"a {type(value).__name__}, which may change unseen; write a tuple or an array"
    if isinstance(value, types.ModuleType):
        return f"the module {value.__name__} itself; write the names that are meant with it, as in module.NAME"
    if hasattr(value, "py_func"):
        return "compiled by another compiler; leave it a plain function, which is compiled with the circuit"
    return f"a {type(value).__name__}; compiled code takes numbers, tuples, arrays and enums of them; use params"
