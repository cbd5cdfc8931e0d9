"""Faults of a model and its case, found before they run: the functions are tried in plain Python."""

import re
import traceback
import types
from collections.abc import Callable, Iterator
from contextlib import suppress
from inspect import signature
from typing import Any

import numpy as np

from vvdp.base.conservation import Nothing
from vvdp.base.errors import RunError, VvdpError
from vvdp.base.params import field_kinds
from vvdp.base.rules import POSITIVE
from vvdp.base.tables import nearest
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.reach import Functions, paths, reachable
from vvdp.simulation.start import check_start
from vvdp.simulation.values import flat, leaves, names
from vvdp.simulation.watch import Remembered, model_key

WITH_SELECT = "write the choice with select, so that arrays pass"


_PASSED = Remembered[bool]()
"""Models whose functions were found to be sound for cases of a form: of the next one only the values are looked at."""


def check_model(model: Model, case: Case) -> None:
    """Tries every function of `model` once, as a run would use it. Raises RunError with the first thing wrong."""
    key = model_key(model, case)
    passed = _PASSED.get(key) is not None
    with np.errstate(all="ignore"):
        _are_numbers(case)
        check_start(case)
        if not passed:
            _reads_no_lists(model)
        rates, outputs = _circuit_values(model, case)
        _rates_are_finite(rates)
        if not passed:
            _circuit_is_sound(model, case, rates, outputs)
            _passes_arrays("the circuit", model.circuit, (0.0, case.state, case.command, case.params))
        if model.stored is not None:
            _stored_is_sound(model, case)
        _stops_and_marks(model, case)
        if model.conditions is not None:
            _conditions_are_sound(model, case)
        for name, program in model.programs.items():
            _program_is_sound(name, program, model, case)
            if not passed:
                arguments = (0.0, blank_books(case.state), outputs, case.params)
                _passes_arrays(f"measure of program {name!r}", program.measure, arguments)
    if not passed:
        with suppress(RunError):  # of what cannot be compiled; linking says it
            _PASSED.put(key, _reach_functions(model), True)


def _reach_functions(model: Model) -> Functions:
    """Functions that a model reaches from those that are tried. Raises RunError if one cannot be compiled."""
    found = Functions()
    for function in _try_functions(model):
        reachable(function, found)
    return found


def _try_functions(model: Model) -> list[Callable[..., Any]]:
    called = [model.circuit, model.mark, model.stop, model.conditions]
    called += [f for p in model.programs.values() for f in (p.measure, p.step, p.trigger)]
    return [function for function in called if function is not None]


def check_times(model: Model, sample_period: float) -> None:
    """Raises RunError where a program's period, phase and latency [s] do not fit together."""
    for name, program in model.programs.items():
        if program.trigger is not None:
            if program.period is not None or program.phase:
                raise RunError(f"program {name!r} has a trigger; it goes by events, and period and phase mean nothing")
            if not 0.0 <= program.latency < np.inf:
                raise RunError(f"program {name!r}: latency = {program.latency:g} s must be at least 0 s")
            continue
        period = sample_period if program.period is None else program.period
        if not 0.0 < period < np.inf:
            raise RunError(f"program {name!r}: period: {period:g} s {POSITIVE}")
        if not 0.0 <= program.phase < period:
            raise RunError(
                f"program {name!r}: phase = {program.phase:g} s; expected 0 s to below one period, {period:g} s"
            )
        if not 0.0 <= program.latency <= period:
            raise RunError(
                f"program {name!r}: latency = {program.latency:g} s; expected 0 s to one period, {period:g} s"
            )


def _are_numbers(case: Case) -> None:
    parts = [("state", case.state), ("params", case.params), ("command", case.command)]
    parts += [(f"memory of {name!r}", value) for name, value in case.memory.items()]
    parts += [(f"settings of {name!r}", value) for name, value in case.settings.items()]
    for what, whole in parts:
        for path, value, kind in leaves(whole):
            if isinstance(value, str):
                example = f"parse({value!r}, {kind.name.upper().replace(' ', '_') if kind else 'KIND'})"
                raise RunError(f"{what} {path!r} = {value!r} is a text; expected one in SI, vvdp.base.units.{example}")
            try:
                is_number = value is not None and np.asarray(value, float).size > 0
            except (TypeError, ValueError):
                is_number = False
            if not is_number and not isinstance(value, tuple):
                raise RunError(f"{what} {path!r} = {value!r}; expected a number")


# The circuit


def _circuit_values(model: Model, case: Case) -> tuple[Any, Any]:
    name, state = _name(model.circuit), type(case.state).__name__
    found = _call("the circuit", model.circuit, "t, state, command, params", 0.0, case.state, case.command, case.params)
    has_modes = "modes" in names(case.command)
    if not isinstance(found, tuple) or names(found) or len(found) != 2 + has_modes:
        what = "nothing" if found is None else "the rates only" if type(found) is type(case.state) else repr(found)
        raise RunError(
            f"the circuit, {name}, returns {what}; expected rates and outputs, `return {state}(...), Outputs(...)`, "
            "with NOTHING for the outputs where there are none"
            + (", and then the modes, since the command has a field for them" if has_modes else "")
        )
    rates, outputs = found[:2]
    _same_fields(f"the rates that {name} returns", rates, "its state", case.state)
    if not names(outputs):
        raise RunError(f"the outputs that {name} returns are {outputs!r}; expected a NamedTuple, or NOTHING")
    _have_kinds(f"output of {name}", outputs)
    if has_modes:
        _same_fields(f"the modes that {name} returns", found[2], "the command's field 'modes'", case.command.modes)
    return rates, outputs


def _rates_are_finite(rates: Any) -> None:
    unsound = [path for path, value, _ in leaves(rates) if not np.isfinite(value)]
    if unsound:
        raise RunError(f"the circuit returns no finite rate at the start for {', '.join(unsound)}")


def _circuit_is_sound(model: Model, case: Case, rates: Any, outputs: Any) -> None:
    again = _call("the circuit", model.circuit, "", 0.0, case.state, case.command, case.params)
    if not (_equal(rates, again[0]) and _equal(outputs, again[1])):
        raise RunError(
            f"the circuit, {_name(model.circuit)}, gives two answers to the same question; random numbers belong into "
            "a program's memory (vvdp.numerics.random)"
        )
    if hasattr(case.state, "books"):
        blind = _call("the circuit", model.circuit, "", 0.0, blank_books(case.state), case.command, case.params)
        if not _equal(rates, blind[0]):
            raise RunError("the circuit reads its own books; they may only be written")


def blank_books(state: Any) -> Any:
    """The state with NaN in its books."""
    return state._replace(books=_map_leaves(state.books, lambda _: np.nan)) if hasattr(state, "books") else state


def _stored_is_sound(model: Model, case: Case) -> None:
    assert model.stored is not None
    if not hasattr(case.state, "books"):
        raise RunError(f"the model has `stored`, but its state, {type(case.state).__name__}, has no field `books`")
    found = _call("stored", model.stored, "state, params", case.state, case.params)
    if names(found) != ("energy", "volume") or not np.isfinite(flat(found)).all():
        raise RunError(f"stored, {_name(model.stored)}, returns {found!r}; expected Stored(energy, volume)")


def _stops_and_marks(model: Model, case: Case) -> None:
    arguments = "t, state, command, params"
    _finite("mark", model.mark, _call("mark", model.mark, arguments, 0.0, case.state, case.command, case.params))
    t = 0.0
    for _ in range(2):
        later = _call("stop", model.stop, "t, command, params", t, case.command, case.params)
        if np.ndim(later) or not isinstance(later, int | float | np.number) or not later > t:
            raise RunError(
                f"stop, {_name(model.stop)}, returns {later} when asked at t = {t:.6g} s; expected the next time after "
                "that at which the rates jump, np.inf where there is none"
            )
        if not np.isfinite(later):
            break
        t = float(later)


def _conditions_are_sound(model: Model, case: Case) -> None:
    assert model.conditions is not None
    if "held" not in names(case.command):
        raise RunError(f"the model has conditions, but its command, {type(case.command).__name__}, no field `held`")
    found = _call("conditions", model.conditions, "t, params", 0.0, case.params)
    _same_fields("what conditions returns", found, "the command's field `held`", case.command.held)
    _have_kinds("condition", found)


# Programs


def _program_is_sound(name: str, program: Program, model: Model, case: Case) -> None:
    what, params = f"program {name!r}", case.params
    if name not in names(case.command):
        raise RunError(f"{what} has no field of its name in the command, {type(case.command).__name__}")
    for part in ("memory", "settings"):
        if name not in getattr(case, part):
            raise RunError(f"{what} has no entry in the {part} of the case; NOTHING where it needs none")
    command, memory, settings = getattr(case.command, name), case.memory[name], case.settings[name]
    _same_fields(f"the first command of {what}", program.command, f"the command's field {name!r}", command)
    state = blank_books(case.state)
    outputs = model.circuit(0.0, state, case.command, params)[1]
    reading = _call(f"measure of {what}", program.measure, "t, state, outputs, params", 0.0, state, outputs, params)
    _reading_is_sound(what, reading)
    found = _call(f"step of {what}", program.step, "t, memory, reading, settings", 0.0, memory, reading, settings)
    if not isinstance(found, tuple) or names(found) or len(found) != 2:
        raise RunError(f"step of {what} returns {found!r}; expected (memory, command)")
    _same_fields(f"the memory that {what} returns", found[0], "the memory it is given", memory)
    _same_fields(f"the command that {what} returns", found[1], f"the command's field {name!r}", command)
    _have_kinds(f"memory of {what}", memory)
    _have_kinds(f"command of {what}", command)
    if program.trigger is not None:
        arguments = (0.0, state, case.command, params, settings)
        _finite(
            f"trigger of {what}",
            program.trigger,
            _call(f"trigger of {what}", program.trigger, "t, state, command, params, settings", *arguments),
        )


def _reading_is_sound(what: str, reading: Any) -> None:
    if not names(reading):
        raise RunError(f"measure of {what} returns {reading!r}; expected a NamedTuple, or NOTHING")
    _have_kinds(f"reading of {what}", reading)
    for path, value, _ in leaves(reading):
        if not np.isfinite(value).all():
            raise RunError(
                f"measure of {what} gives no finite {path!r} without the books; nothing may depend on the books, "
                "and a sensor sees none"
            )


# Trying a function


def _call(what: str, function: Callable[..., Any], expected: str, *arguments: Any) -> Any:
    """The value of `function`. Raises RunError with what is wrong, and where."""
    try:
        signature(function).bind(*arguments)
    except TypeError:
        raise RunError(f"{what}, {_name(function)}, takes {signature(function)}; expected ({expected})") from None
    try:
        return function(*arguments)
    except VvdpError:
        raise
    except Exception as problem:
        raise RunError(
            f"{what}, {_name(function)}, cannot be calculated: {_explain(problem)}{_place(problem)}"
        ) from None


def _explain(problem: Exception) -> str:
    """Meaning of a Python error for a user who wrote a circuit."""
    text = str(problem)
    if isinstance(problem, AttributeError) and names(problem.obj):
        hint = nearest(str(problem.name), names(problem.obj))
        return f"{type(problem.obj).__name__} has no field {problem.name!r}{hint}"
    if found := re.match(r"(\w+)\.__new__\(\) missing \d+ required positional arguments?: (.*)", text):
        return (
            f"{found[1]} is given too few values, so that {found[2]} is missing argument, or one before it: "
            f"name them, {found[1]}({found[2].split(', ')[0].strip(chr(39))}=...)"
        )
    return f"{type(problem).__name__}: {text}"


def _place(problem: BaseException) -> str:
    frames = [f for f in traceback.extract_tb(problem.__traceback__) if f.filename != __file__]
    return f" ({frames[-1].filename}, line {frames[-1].lineno}: `{frames[-1].line}`)" if frames else ""


def _passes_arrays(what: str, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """Outputs and readings over time are the functions themselves, evaluated on whole columns."""
    time, *values = arguments
    columns = [_map_leaves(value, lambda x: np.stack([np.asarray(x, float)] * 2, axis=-1)) for value in values[:2]]
    tries = (
        ("the time", (np.full(2, time), *values)),
        ("the state", (time, columns[0], *values[1:])),
        ("the command" if what == "the circuit" else "an output", (time, values[0], columns[1], values[2])),
        ("a value", (np.full(2, time), *columns, values[2])),
    )
    for by, tried in tries:
        try:
            function(*tried)
        except Exception as problem:
            raise RunError(f"{what}, {_name(function)}, {_array_fault(problem, by)}{_place(problem)}") from None


def _array_fault(problem: Exception, by: str) -> str:
    if isinstance(problem, ValueError) and "truth value" in str(problem):
        instant = "; a jump at a known time belongs into stop as well" if by == "the time" else ""
        return f"chooses by {by}; {WITH_SELECT}{instant}"
    if isinstance(problem, TypeError) and re.search(
        r"only .* arrays can be converted|only integer scalar", str(problem)
    ):
        return "hands an array to a function for single numbers; use that of NumPy, as np.sqrt for math.sqrt"
    return f"does not pass arrays: {_explain(problem)}"


def _reads_no_lists(model: Model) -> None:
    """Compiled code takes tuples and arrays for constants, but nothing that may still change."""
    seen: set[types.FunctionType] = set()
    for function in _try_functions(model):
        for user, name, value in _globals(function, seen):
            if isinstance(value, list | dict | set):
                kind = type(value).__name__
                raise RunError(
                    f"{_name(user)} reads {name!r}, a {kind} of its module; make it a tuple or an array of NumPy"
                )


def _globals(function: Any, seen: set[types.FunctionType]) -> Iterator[tuple[Any, str, Any]]:
    if not isinstance(function, types.FunctionType) or function in seen:
        return
    seen.add(function)
    for name in dict.fromkeys(path[0] for path in paths(function.__code__)):
        if name in function.__globals__:
            value = function.__globals__[name]
            yield function, name, value
            yield from _globals(value, seen)


# Comparing


def _same_fields(what: str, value: Any, other: str, expected: Any) -> None:
    found, wanted = dict(_sizes(value)), dict(_sizes(expected))
    if list(found.items()) == list(wanted.items()):
        return
    odd = sorted(set(found) ^ set(wanted)) or [
        f"{path} ({found[path]} numbers against {wanted[path]})" for path in wanted if found[path] != wanted[path]
    ]
    raise RunError(f"{what} and {other} differ in {', '.join(odd) or 'the order of their fields'}")


def _sizes(value: Any) -> Iterator[tuple[str, int]]:
    return ((path or "the value", np.size(leaf)) for path, leaf, _ in leaves(value))


def _equal(one: Any, other: Any) -> bool:
    return np.array_equal(flat(one), flat(other), equal_nan=True)


def _have_kinds(what: str, value: Any, path: str = "") -> None:
    """Everything that is recorded needs a unit."""
    if isinstance(value, Nothing):
        return
    if not names(value):
        raise RunError(f"{what} is {value!r}; expected a NamedTuple, or NOTHING")
    kinds = field_kinds(type(value))
    for name in names(value):
        inner = getattr(value, name)
        if names(inner):
            _have_kinds(what, inner, f"{path}{name}.")
        elif kinds.get(name) is None:
            raise RunError(f"{what}: {path + name!r} has no kind; annotate it, for example `{name}: Pressure`")


def _finite(what: str, function: Callable[..., Any], value: Any) -> None:
    if np.ndim(value) or not isinstance(value, int | float | np.number) or not np.isfinite(value):
        raise RunError(f"{what}, {_name(function)}, returns {value}; expected a finite number")


def _map_leaves(value: Any, change: Callable[[Any], Any]) -> Any:
    if inner := names(value):
        return type(value)(**{name: _map_leaves(getattr(value, name), change) for name in inner})
    return change(value)


def _name(function: Any) -> str:
    return str(getattr(function, "__qualname__", function))
