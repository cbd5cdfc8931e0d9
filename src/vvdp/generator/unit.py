"""A unit of generated code: functions read from their source text, each once for each combination of argument types."""

import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vvdp.generator import tree
from vvdp.generator.body import Body, End, Word
from vvdp.generator.joining import finish
from vvdp.generator.kinds import FLOAT, INT, Intrinsic, Kind, Known, Row, element_of, scalar_of
from vvdp.generator.source import LanguageError, read_source
from vvdp.generator.statements import read_block
from vvdp.generator.values import Undefined, argument_type, refusal


@dataclass(frozen=True)
class Options:
    """How functions are read.

    replaced    functions that others stand for in generated code
    intrinsics  functions that intrinsics stand for, where their arguments are numbers
    words       functions that are written in place, from the body and the arguments (`generator.words`)
    apart       functions that are seldom called and have no effects: they are never copied to where they are called
    checked     whether bounds, divisions, whole numbers and assertions are checked while the code runs
    unrolled    loops of at most so many known rounds are written out
    """

    replaced: Mapping[Any, Any] = field(default_factory=dict)
    intrinsics: Mapping[Any, Intrinsic] = field(default_factory=dict)
    words: Mapping[Any, Word] = field(default_factory=dict)
    apart: frozenset[Any] = frozenset()
    checked: bool = False
    unrolled: int = 8


@dataclass
class Unit:
    """Functions under construction, callees first."""

    options: Options = field(default_factory=Options)
    functions: list[tree.Function] = field(default_factory=list)
    entries: list[str] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    _done: dict[Any, tree.Function] = field(default_factory=dict)
    reading: list[Any] = field(default_factory=list)
    _tables: dict[Any, tree.Table] = field(default_factory=dict)
    intrinsics: dict[str, Intrinsic] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.checked = self.options.checked
        self.words = dict(self.options.words)
        for function, intrinsic in self.options.intrinsics.items():
            self.words[function] = intrinsic_word(self, intrinsic)

    def add(self, function: Callable[..., Any], kinds: Sequence[Kind], name: str) -> tree.Function:
        """Reads `function` for arguments of these types, to be called from outside by `name`.

        Raises LanguageError where it uses what the language does not have.
        """
        if name in self.entries:
            raise ValueError(f"there are two entries {name}")
        made = _read(self, self.replacement(function), tuple(kinds), name, is_entry=True)
        self.entries.append(name)
        return made

    def module(self) -> tree.Module:
        """All that was read so far."""
        return tree.Module(tuple(self.functions), tuple(self.entries), tuple(self.reasons), dict(self.intrinsics))

    def replacement(self, function: Any) -> Any:
        """The function that stands for another in generated code."""
        try:
            return self.options.replaced.get(function, function)
        except TypeError:
            return function

    def call(self, body: Body, function: Any, values: Sequence[Any], given: Mapping[str, object]) -> Any:
        """The result of a call of a plain function."""
        source = read_source(function)
        arguments = _in_order(source.function, values, given)
        kinds = tuple(map(argument_type, arguments))
        key = source.function, kinds
        if key not in self._done:
            name = f"{source.function.__name__}_f{len(self.functions) + len(self.reading) + 1}"
            self._done[key] = _read(self, function, kinds, name)
        made = self._done[key]
        handed = [body.as_kind(value, kind) for value, kind in zip(arguments, kinds, strict=True)]
        result = tree.Call(made, tuple(each for each in handed if each is not None))
        if isinstance(made.result, Known):
            body.add(tree.Do(result, body.line))
            return made.result.value
        return body.bind(result, source.function.__name__)

    def table(self, array: np.ndarray[Any, Any]) -> tree.Table:
        """The numbers of a known array, which are the same in all of the unit."""
        try:
            kind = Row(element_of(array), array.shape)
        except TypeError as problem:
            raise refusal(str(problem), "make it with np.array(..., float) or np.int64") from None
        return self._kept_table(kind, array.tobytes(), array.ravel().tolist())

    def constant_row(self, numbers: tuple[Any, ...]) -> tree.Table:
        """Known numbers as an array."""
        kind = FLOAT if any(scalar_of(number) is FLOAT for number in numbers) else INT
        row = np.array(numbers, kind.value)
        return self._kept_table(Row(kind, row.shape), row.tobytes(), row.tolist())

    def _kept_table(self, kind: Row, key: bytes, numbers: list[Any]) -> tree.Table:
        return self._tables.setdefault((kind, key), tree.Table(f"table_{len(self._tables) + 1}", kind, tuple(numbers)))

    def reason(self, body: Body, words: str) -> int:
        """The number of a failure, with the file and the line at which it would happen."""
        where = f"{body.source.file}:{body.line}: {words} (in {body.source.name})"
        if where not in self.reasons:
            self.reasons.append(where)
        return self.reasons.index(where) + 1


def _read(unit: Unit, given: Any, kinds: tuple[Kind, ...], name: str, *, is_entry: bool = False) -> tree.Function:
    """Reads a function for arguments of these types. Raises LanguageError where the language does not have it."""
    source = read_source(given)
    if source.function in unit.reading:
        raise refusal(f"a call of `{source.name}` within itself", "write a loop")
    body = Body(unit, source)
    unit.reading.append(source.function)
    try:
        pairs = list(zip(_parameters(source.function), kinds, strict=True))
        variables = {n: tree.Variable(n, kind) for n, kind in pairs if not isinstance(kind, Known)}
        start = {n: kind.value if isinstance(kind, Known) else tree.Read(variables[n]) for n, kind in pairs}
        end = read_block(body, source.node.body, start)
        if end is not None:
            body.returns.append((End(body.block, end), None, body.line))
        result = finish(body, is_entry=is_entry)
    except LanguageError as problem:
        problem.locate(source.file, body.line, source.name)
        raise
    finally:
        unit.reading.pop()
    function = tree.Function(
        name=name,
        parameters=tuple(variables.values()),
        result=result,
        body=tree.freeze(body.block),
        file=source.file,
        line=source.node.lineno,
        apart=given in unit.options.apart,
    )
    unit.functions.append(function)
    return function


def intrinsic_word(unit: Unit, intrinsic: Intrinsic) -> Word:
    """Writer of a call of an intrinsic."""

    def word(body: Body, *values: Any) -> Any:
        unit.intrinsics[intrinsic.name] = intrinsic
        if len(values) != len(intrinsic.arguments):
            raise refusal(f"{len(values)} arguments", f"hand over {len(intrinsic.arguments)}")
        made = [body.as_kind(value, kind) for value, kind in zip(values, intrinsic.arguments, strict=True)]
        arguments = tuple(each for each in made if each is not None)
        if intrinsic.is_pure:
            return tree.Library(intrinsic.name, arguments, FLOAT)
        call = tree.CallIntrinsic(intrinsic.name, arguments, intrinsic.result or Known(None))
        if intrinsic.result is None:
            body.add(tree.Do(call, body.line))
            return None
        return body.bind(call)

    return word


def _parameters(function: types.FunctionType) -> tuple[str, ...]:
    code = function.__code__
    if code.co_flags & 0x0C:
        raise refusal(f"`*` or `**` among the arguments of `{function.__qualname__}`", "name each argument")
    return code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]


def _in_order(function: types.FunctionType, values: Sequence[Any], given: Mapping[str, object]) -> list[Any]:
    """The arguments of a call in the order of the parameters, defaults included."""
    names = _parameters(function)
    positional = function.__code__.co_argcount
    defaults = function.__defaults__ or ()
    known = dict(zip(names[positional - len(defaults) : positional], defaults, strict=True))
    known |= function.__kwdefaults__ or {}
    if len(values) > positional or any(name not in names for name in given):
        raise refusal(f"a call of `{function.__qualname__}` with other arguments", f"it takes {', '.join(names)}")
    known |= dict(zip(names, values, strict=False)) | dict(given)
    missing = [name for name in names if name not in known]
    if missing:
        raise refusal(f"a call of `{function.__qualname__}` without {', '.join(missing)}", "hand it over")
    found = [known[name] for name in names]
    for one in found:
        if isinstance(one, Undefined):
            raise refusal(one.reason, "assign it on every way to this line")
    return found
