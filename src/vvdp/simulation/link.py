"""Joins a model (plain Python functions) to the compiled loop.

The functions that the model reaches are found, their code and constants hashed, and a small module
`<cache>/<hash>/linked.py` written whose functions take flat vectors. Numba compiles and caches that module; because
the hash is in the folder's name, a changed formula anywhere is never served from an old cache.
"""

import dataclasses
import hashlib
import importlib.util
import os
import platform
import re
import sys
import types
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import RunError
from vvdp.base.select import select
from vvdp.base.signal import changes_stop, changes_value, sines_value
from vvdp.simulation.model import Case, Model
from vvdp.simulation.values import flat, leaves, names, rebuilt

Functions = dict[str, tuple[types.FunctionType, list[Any]]]

COMPILING: Any = {"error_model": "numpy", "forceinline": True}
"""How formulas are compiled. A call hands over each field of its arguments; without calls a run is a sixth faster."""


class Linked(NamedTuple):
    """A compiled model: first-class functions over flat vectors, and the hash of their text."""

    rates: Any
    sample: Any
    mark: Any
    stop: Any
    digest: str


def default_cache() -> Path:
    """Where compiled code is kept: `VVDP_CACHE`, else the user's cache folder."""
    if place := os.environ.get("VVDP_CACHE"):
        return Path(place)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vvdp"


def reachable(function: Callable[..., Any], found: Functions) -> Functions:
    """Every plain function that `function` calls by name, and every constant these use, added to `found`."""
    if not isinstance(function, types.FunctionType):
        raise RunError(f"{function!r} is not a plain function; circuits and programs are module-level functions")
    key = f"{function.__module__}.{function.__qualname__}.{id(function)}"
    if key in found:
        return found
    if function.__closure__:
        raise RunError(f"{function.__qualname__} closes over variables; hand values over in params instead")
    constants: list[Any] = [function.__defaults__]
    found[key] = (function, constants)
    if faster := compiled_form(function):
        reachable(faster, found)
    for name in sorted(_names_used(function.__code__)):
        value = function.__globals__.get(name)
        if isinstance(value, types.FunctionType):
            reachable(value, found)
        elif isinstance(value, type) and hasattr(value, "_fields"):
            constants.append((name, value._fields))
        elif isinstance(value, np.ndarray):
            constants.append((name, value.tobytes(), value.shape))
        elif isinstance(value, int | float | str | tuple):
            constants.append((name, repr(value)))
        elif isinstance(value, types.ModuleType) and value.__name__.partition(".")[0] not in ("numpy", "math"):
            for attribute in sorted(_names_used(function.__code__)):
                inner = getattr(value, attribute, None)
                if isinstance(inner, types.FunctionType):
                    reachable(inner, found)
    return found


def compiled_form(function: Callable[..., Any]) -> Callable[..., Any] | None:
    """The function that replaces `function` in compiled code: its module's `<name>_compiled`, if there is one.

    It gives the same values faster, with plain conditionals that arrays and symbols could not pass.
    """
    form = function.__globals__.get(f"{function.__name__}_compiled")
    return form if isinstance(form, types.FunctionType) else None


def _names_used(code: types.CodeType) -> set[str]:
    inner = [_names_used(c) for c in code.co_consts if isinstance(c, types.CodeType)]
    return set(code.co_names).union(*inner)


def _text(code: types.CodeType) -> str:
    """What a function does, without where it stands: bytecode, constants and names."""
    constants = [
        _text(c) if isinstance(c, types.CodeType) else repr(c)
        for c in code.co_consts[1 if code.co_consts and isinstance(code.co_consts[0], str) else 0 :]
    ]
    return repr((code.co_code, constants, code.co_names, code.co_varnames))


def tried(model: Model, case: Case) -> None:
    """Runs the model's functions once in plain Python. Raises RunError where their values do not fit together."""
    rates, _ = model.circuit(0.0, case.state, case.command, case.params)
    _same_fields("the rates of the circuit", rates, "its state", case.state)
    memory, command = model.program(0.0, case.memory, case.state, case.settings)
    _same_fields("the memory that the program returns", memory, "the memory it is given", case.memory)
    _same_fields("the command that the program returns", command, "the command of the circuit", case.command)
    for path, value, kind in leaves(case.state):
        if np.ndim(value):
            raise RunError(f"state {path!r} is an array; a state has one number for each field")
        if kind is None and not path.startswith("books."):
            raise RunError(
                f"state {path!r} has no kind; annotate it, for example `{path.rpartition('.')[2]}: Pressure`"
            )
    unsound = [path for path, value, _ in leaves(rates) if not np.isfinite(value)]
    if unsound:
        raise RunError(f"the circuit returns no finite rate at the start for {', '.join(unsound)}")
    _tried_on_arrays(model, case)
    if hasattr(case.state, "books"):
        if names(case.state)[-1] != "books":
            raise RunError("books must be the last field of the state")
        blank = rebuilt(case.state.books, iter(lambda: np.nan, None))
        again, _ = model.circuit(0.0, case.state._replace(books=blank), case.command, case.params)
        if not np.array_equal(flat(rates), flat(again)):
            raise RunError("the circuit reads its own books; they may only be written")


def _tried_on_arrays(model: Model, case: Case) -> None:
    """Outputs over time are the circuit itself, evaluated on whole columns; a plain `if` on a state shows here."""
    column = rebuilt(case.state, (np.array([value, value]) for value in flat(case.state)))
    try:
        model.circuit(np.zeros(2), column, case.command, case.params)
    except ValueError as problem:
        if "truth value" in str(problem):
            name = model.circuit.__qualname__
            raise RunError(f"{name} chooses by a state; write the choice with select, so that arrays pass") from None
    except TypeError:
        pass  # whatever else it is, compiling it says so with the place


def _same_fields(what: str, value: Any, other: str, expected: Any) -> None:
    found, wanted = [path for path, _, _ in leaves(value)], [path for path, _, _ in leaves(expected)]
    if found != wanted or flat(value).size != flat(expected).size:
        odd = sorted(set(found) ^ set(wanted)) or [f"{flat(value).size} numbers against {flat(expected).size}"]
        raise RunError(f"{what} and {other} differ in {', '.join(odd)}")


def quiet(message: str) -> None:
    """Says nothing: the default listener."""


def link(model: Model, case: Case, cache: Path | None = None, say: Callable[[str], None] = quiet) -> Linked:
    """The compiled form of `model` for values of the shape of `case`; `say` hears when something must be compiled.

    Raises RunError where the functions and values do not fit together.
    """
    tried(model, case)
    classes = Classes()
    source = _source(model, case, classes)
    called = {"circuit": model.circuit, "program": model.program, "event": model.mark, "jump": model.stop}
    module = compiled_module(source, called, classes, cache, say)
    return Linked(module.rates, module.sample, module.mark, module.stop, module.__name__.rpartition("_")[2])


def compiled_module(
    source: str,
    called: Mapping[str, Callable[..., Any]],
    classes: "Classes",
    cache: Path | None,
    say: Callable[[str], None],
) -> types.ModuleType:
    """The module of text `source`, compiled, in which the functions `called` and the `classes` have their names.

    Raises RunError where a function cannot be compiled, with the place.
    """
    import numba

    functions: Functions = {}
    for function in called.values():
        reachable(function, functions)
    digest = hashlib.sha256(source.encode())
    for function, constants in sorted(
        functions.values(), key=lambda entry: (entry[0].__module__, entry[0].__qualname__)
    ):
        digest.update(
            f"{function.__module__}.{function.__qualname__} {_text(function.__code__)} {constants!r}".encode()
        )
    digest.update(f"{platform.python_version()} {np.__version__} {numba.__version__} {COMPILING}".encode())
    name = digest.hexdigest()[:16]
    module = sys.modules.get(f"vvdp_linked_{name}")
    if module is None:
        _make_compilable(functions)
        module = _loaded(name, source, classes, called, cache or default_cache(), say)
    return module


class Classes:
    """Names under which the linked module knows the classes of a case's values."""

    def __init__(self) -> None:
        self.names: dict[type, str] = {}

    def name(self, cls: type) -> str:
        return self.names.setdefault(cls, f"T{len(self.names)}_{cls.__name__}")

    def tuples(self) -> Iterator[tuple[str, type]]:
        return ((name, cls) for cls, name in self.names.items() if not dataclasses.is_dataclass(cls))

    def records(self) -> Iterator[tuple[str, type]]:
        return ((name, cls) for cls, name in self.names.items() if dataclasses.is_dataclass(cls))


def built(value: Any, vector: str, position: int, classes: Classes) -> tuple[str, int]:
    """Source that rebuilds `value` from a flat vector, and the position after it."""
    if inner := names(value):
        parts = []
        for name in inner:
            text, position = built(getattr(value, name), vector, position, classes)
            parts.append(text)
        return f"{classes.name(type(value))}({', '.join(parts)})", position
    if isinstance(value, tuple):  # not a slice: compiled code counts references to arrays wherever they are handed on
        end = position + len(value)
        return f"({''.join(f'{vector}[{i}], ' for i in range(position, end))})", end
    if np.ndim(value):
        end = position + int(np.size(value))
        shape = f".reshape({np.shape(value)})" if np.ndim(value) > 1 else ""
        return f"{vector}[{position}:{end}]{shape}", end
    return f"{vector}[{position}]", position + 1


def written(value: Any, path: str, vector: str, position: int, lines: list[str]) -> int:
    """Adds to `lines` the source that writes `value` to a flat vector; returns the position after it."""
    if inner := names(value):
        for name in inner:
            position = written(getattr(value, name), f"{path}.{name}", vector, position, lines)
        return position
    if np.ndim(value):
        end = position + int(np.size(value))
        lines.append(f"    {vector}[{position}:{end}] = {path}.ravel()")
        return end
    lines.append(f"    {vector}[{position}] = {path}")
    return position + 1


def _source(model: Model, case: Case, classes: Classes) -> str:
    state, params = built(case.state, "y", 0, classes)[0], built(case.params, "p", 0, classes)[0]
    command, memory = built(case.command, "u", 0, classes)[0], built(case.memory, "m", 0, classes)[0]
    settings = built(case.settings, "z", 0, classes)[0]
    compiled = "@njit({}, cache=True, error_model='numpy')"
    lines = [compiled.format("FLAT"), "def rates(t, y, u, p, dy):"]
    lines.append(f"    value, outputs = circuit(t, {state}, {command}, {params})")
    written(case.state, "value", "dy", 0, lines)
    lines += ["", "", compiled.format("FLAT"), "def sample(t, m, y, z, u):"]
    lines.append(f"    memory, command = program(t, {memory}, {state}, {settings})")
    written(case.memory, "memory", "m", 0, lines)
    written(case.command, "command", "u", 0, lines)
    lines += ["", "", compiled.format("float64(float64, float64[::1], float64[::1])"), "def mark(t, y, p):"]
    lines.append(f"    return float(event(t, {state}, {params}))")
    lines += ["", "", compiled.format("float64(float64, float64[::1])"), "def stop(t, p):"]
    lines.append(f"    return float(jump(t, {params}))")
    return "\n".join([*heading(classes), "", "FLAT = void(float64, *[float64[::1]] * 4)", "", "", *lines]) + "\n"


def heading(classes: Classes) -> list[str]:
    """First lines of a linked module; a parameter class is a plain record to compiled code, which reads its fields."""
    records = [f"{name} = namedtuple({name!r}, {names(cls)!r})" for name, cls in classes.records()]
    return ["from collections import namedtuple", "", "from numba import float64, njit, void", "", *records]


def _loaded(
    name: str,
    source: str,
    classes: Classes,
    called: Mapping[str, Callable[..., Any]],
    cache: Path,
    say: Callable[[str], None],
) -> types.ModuleType:
    folder = cache / name
    path = folder / "linked.py"
    try:
        if not path.exists():
            folder.mkdir(parents=True, exist_ok=True)
            temporary = folder / f"{os.getpid()}.tmp"
            temporary.write_text(source)
            temporary.replace(path)
    except OSError as problem:
        raise RunError(f"compiled code cannot be kept in {cache} ({problem.strerror}); set VVDP_CACHE") from None
    spec = importlib.util.spec_from_file_location(f"vvdp_linked_{name}", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    module.__dict__.update(dict(classes.tuples()))
    module.__dict__.update(called)
    if not any(folder.rglob("*.nbi")):
        say(f"compiling the {next(iter(called))} (once for each, a few seconds)")
    sys.modules[spec.name] = module  # before it runs: Numba's cache looks its functions' module up by name
    try:
        spec.loader.exec_module(module)
    except BaseException as problem:
        del sys.modules[spec.name]
        from numba.core.errors import NumbaError, UnsupportedBytecodeError

        if isinstance(problem, NumbaError | UnsupportedBytecodeError):
            raise RunError(_reason(problem, next(iter(called.values())))) from None
        raise
    return module


def _reason(problem: Exception, function: Callable[..., Any]) -> str:
    """What Numba has to say, without the layers around it: the innermost message, and where it arose."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", str(problem))
    told = [line.strip() for line in text.splitlines()]
    places = [
        place for line in told if (place := re.match(r'File "(.*)", line (\d+)', line)) and "linked.py" not in place[1]
    ]
    causes = [
        line
        for line in told
        if line
        and not re.match(
            r"File |During: |There are |- Of which|Overload|With argument|Rejected|raised from|\^|>>>|def |<source",
            line,
        )
    ]
    typing = [
        line
        for line in causes
        if re.match(r"(Unknown|Untyped|Cannot|Unsupported|Invalid|NameError|.*not supported|.*not implemented)", line)
    ]
    reason = (typing or causes or ["no reason given"])[0 if not typing else -1]
    where = f" ({places[0][1]}, line {places[0][2]})" if places else ""
    return f"{function.__qualname__} or a function that it reaches cannot be compiled: {reason[:300]}{where}"


def _select_form(condition: Any, a: Any, b: Any) -> Any:
    return lambda condition, a, b: a if condition else b


# Compiled code cannot index a tuple of nothing, even in a loop that never runs.
def _changes_form(t: Any, start: Any, duration: Any, change: Any) -> Any:
    return changes_value if len(start) else lambda t, start, duration, change: 0.0


def _sines_form(t: Any, amplitude: Any, frequency: Any, phase: Any) -> Any:
    return sines_value if len(amplitude) else lambda t, amplitude, frequency, phase: 0.0


def _stop_form(t: Any, start: Any, duration: Any) -> Any:
    return changes_stop if len(start) else lambda t, start, duration: np.inf


COMPILED_FORMS: dict[Callable[..., Any], Callable[..., Any]] = {
    select: _select_form,
    changes_value: _changes_form,
    sines_value: _sines_form,
    changes_stop: _stop_form,
}
"""Functions whose compiled text differs from their Python text, and how it is chosen from the argument types."""

_registered: set[types.FunctionType] = set()


def _make_compilable(functions: Functions) -> None:
    from numba.extending import overload, register_jitable

    for function, _ in functions.values():
        if function in _registered:
            continue
        _registered.add(function)
        if function in COMPILED_FORMS:
            overload(function, strict=False, jit_options=COMPILING)(COMPILED_FORMS[function])
        elif faster := compiled_form(function):
            arguments = ", ".join(function.__code__.co_varnames[: function.__code__.co_argcount])
            overload(function, strict=False, jit_options=COMPILING)(eval(f"lambda {arguments}: form", {"form": faster}))
        else:
            register_jitable(**COMPILING)(function)
