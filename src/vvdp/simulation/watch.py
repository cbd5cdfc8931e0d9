"""Whether functions are still what they were: what was calculated from them once is then still right.

Far less work than their hash, and as careful: each function's code and defaults, and each constant that one reads, must
be the same object as before; a class that is written again is another. What may change within, as an array may, is
detected in words again.
"""

import types
from collections.abc import Callable, Hashable
from dataclasses import fields
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from vvdp.base.errors import RunError
from vvdp.simulation.model import Case, Model
from vvdp.simulation.reach import MISSING, Functions, compiled_name, known_words, paths, value_at
from vvdp.simulation.values import form

FIXED = (bool, int, float, complex, str, bytes, type, types.FunctionType, types.BuiltinFunctionType, np.ufunc)
"""Kinds of constants that cannot change while they are the same object."""


Result = TypeVar("Result")


class _Code(NamedTuple):
    function: types.FunctionType
    code: types.CodeType
    defaults: tuple[Any, ...] | None
    named_defaults: tuple[tuple[str, Any], ...]


class _Led(NamedTuple):
    """End of a path of names through modules."""

    function: types.FunctionType
    path: tuple[str, ...]
    value: Any


class Watch:
    """`functions` as they are now. Raises RunError where a constant is none that a hash can vouch for."""

    def __init__(self, functions: Functions) -> None:
        self._codes = [_code(function) for function, _ in functions.values()]
        names: dict[tuple[int, str], tuple[dict[str, Any], str, Any]] = {}
        led: dict[tuple[int, tuple[str, ...]], _Led] = {}
        within: dict[int, tuple[Any, Any]] = {}
        for function, _ in functions.values():
            inside = function.__globals__
            for path in (*paths(function.__code__), (compiled_name(function),)):
                root, value = inside.get(path[0], MISSING), value_at(path, function)
                names[id(inside), path[0]] = (inside, path[0], root)
                if value is not root:
                    led[id(inside), path] = _Led(function, path, value)
                if value is not MISSING and not isinstance(value, (*FIXED, types.ModuleType)):
                    within[id(value)] = value, known_words(".".join(path), value)
        self._names, self._led, self._within = tuple(names.values()), tuple(led.values()), tuple(within.values())

    def is_unchanged(self) -> bool:
        """Whether all is as it was when this was made."""
        return (
            all(inside.get(name, MISSING) is value for inside, name, value in self._names)
            and all(_code(known.function) == known for known in self._codes)
            and all(value_at(path, function) is value for function, path, value in self._led)
            and all(known_words("", value) == words for value, words in self._within)
        )


def model_key(model: Model, case: Case) -> Hashable | None:
    """Key that differs between models at hand, and between cases of different forms; None if something other than
    functions may change.

    It holds on to the functions, so that no other can take the place of one.
    """
    parts: list[Any] = [model, *model.programs.values()]
    told: list[Hashable] = [tuple(model.programs), tuple(case.memory), tuple(case.settings)]
    for part in parts:
        for field in fields(part):
            value = getattr(part, field.name)
            if isinstance(value, types.FunctionType) or value is None or isinstance(value, float | int):
                told.append(value)
            elif not (part is model and field.name == "programs") and field.name != "command":
                return None
    known: dict[int, Hashable] = {}
    values = (case.state, case.params, case.command, *case.memory.values(), *case.settings.values())
    return (*told, *(form(value, known) for value in values))


class Remembered(Generic[Result]):
    """Results by key, each with the functions that it came from; the oldest make room."""

    def __init__(self, most: int = 200) -> None:
        self._most = most
        self._found: dict[Hashable, tuple[Watch, Result]] = {}

    def get(self, key: Hashable | None, holds: Callable[[Result], bool] = lambda _: True) -> Result | None:
        """Result remembered by `key`; None if there is none, a function has changed, or the result no longer
        `holds`."""
        if key is None or (known := self._found.get(key)) is None:
            return None
        watch, result = known
        if watch.is_unchanged() and holds(result):
            return result
        self._found.pop(key, None)  # another thread may have done it by now
        return None

    def put(self, key: Hashable | None, functions: Functions, result: Result) -> None:
        """Remembers what came of `functions`, where these can be watched."""
        if key is None:
            return
        try:
            watch = Watch(functions)
        except RunError:
            return
        while len(self._found) >= self._most:
            self._found.pop(next(iter(self._found)), None)
        self._found[key] = watch, result


def _code(function: Any) -> _Code:
    return _Code(function, function.__code__, function.__defaults__, tuple((function.__kwdefaults__ or {}).items()))
