"""What linked modules are made of: numbers at an address, signals as small records, and formulas in compiled form.

Numba is loaded with this module.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import extending, njit, types
from numba.core import cgutils
from numba.core.typing.templates import builtin_registry
from numba.np.arrayobj import make_array, populate_array

from vvdp.base.errors import RunError
from vvdp.base.powers import expm1, power
from vvdp.base.select import clip, maximum, minimum, select
from vvdp.base.signal import changes_stop, changes_value, signal_stop, signal_value, sines_value
from vvdp.simulation import in_place
from vvdp.simulation.lane_code import is_fused
from vvdp.simulation.lane_values import Code, Vector

intrinsic: Any = extending.intrinsic
overload: Any = extending.overload
register_jitable: Any = extending.register_jitable

COMPILING: Any = {"error_model": "numpy", "forceinline": True}
"""How formulas are compiled. A call hands over each field of its arguments; without calls a run is a sixth faster."""
ENDLESS = 2**40


class Signal(NamedTuple):
    """A signal in compiled code. An array in it would be counted wherever the parameters are handed on."""

    base: float
    place: float  # of its starts, durations, changes, amplitudes, frequencies and phases; 0 where it is constant
    changes: float
    sines: float
    parameters: int  # address of the vector in which they are
    time: float  # at which it was worked out before the circuit, where no test stands in the way of other work
    value: float  # then


@intrinsic
def address(typing: Any, array: Any) -> Any:
    """The address of the first number of an array."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.ptrtoint(data, context.get_value_type(types.intp))

    return types.intp(array), generate


@intrinsic
def view(typing: Any, place: Any, shape: Any) -> Any:
    """The numbers at an address as an array of `shape` that nobody counts and nobody frees."""
    found = types.Array(types.float64, len(shape), "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = builder.inttoptr(arguments[0], context.get_value_type(types.CPointer(types.float64)))
        item = context.get_constant(types.intp, 8)
        sizes = cgutils.unpack_tuple(builder, arguments[1])
        strides = [item]
        for size in reversed(sizes[1:]):
            strides.insert(0, builder.mul(strides[0], size))
        array = make_array(found)(context, builder)
        populate_array(array, data=data, shape=sizes, strides=strides, itemsize=item, meminfo=None)
        return array._getvalue()

    return found(types.intp, types.UniTuple(types.intp, len(shape))), generate


@register_jitable(**COMPILING)
def vector(place: int) -> Any:
    """The numbers from an address on. Nothing checks the length of a vector in compiled code, so it needs none."""
    return view(place, (ENDLESS,))


def store(vector: Any, place: int, values: Any) -> int:
    """Writes an array or a tuple to a vector from `place` on; returns the place behind it."""
    raise NotImplementedError("for compiled code")


@overload(store, strict=False, jit_options=COMPILING)
def _store_form(vector: Any, place: Any, values: Any) -> Any:
    return _store_tuple if isinstance(values, types.BaseTuple) else _store_array


def _store_array(vector: Any, place: int, values: Any) -> int:
    row = values.ravel()
    vector[place : place + row.size] = row
    behind: int = place + row.size
    return behind


def _store_tuple(vector: Any, place: int, values: Any) -> int:
    for i in range(len(values)):
        vector[place + i] = values[i]
    return place + len(values)


def apart(function: Callable[..., Any]) -> Any:
    """`function` of two arguments for compiled code that seldom calls it: it is never copied in, and writes nothing,
    so that the code around it need not save what it has read."""
    compiled: Any = njit(error_model="numpy")(function)

    @intrinsic
    def call(typing: Any, first: Any, second: Any) -> Any:
        compiled.compile((first, second))
        found = compiled.overloads[first, second]

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            context.add_linking_libs([found.library])
            return builder.call(_bridge(context, builder.module, found, arguments), arguments)

        return found.signature.return_type(first, second), generate

    return call


def _bridge(context: Any, module: Any, found: Any, arguments: Any) -> Any:
    """A function in `module` that calls the compiled one `found` and says of it what the compiler cannot see."""
    name = f"apart_{found.fndesc.mangled_name}"
    if name in module.globals:
        return module.globals[name]
    result = context.get_value_type(found.signature.return_type)
    bridge = ir.Function(module, ir.FunctionType(result, [given.type for given in arguments]), name)
    bridge.linkage = "internal"
    for attribute in ("noinline", "cold", "nounwind", "readonly"):
        bridge.attributes.add(attribute)
    inside = ir.IRBuilder(bridge.append_basic_block())
    callee = context.declare_function(module, found.fndesc)
    kinds = found.signature.return_type, found.signature.args
    inside.ret(context.call_conv.call_function(inside, callee, *kinds, bridge.args)[1])
    return bridge


# Most signals are constant, and pass with one test of a number that is at hand; copied in, the rest would make the
# text of a circuit three times as long.
@apart
def _moving(t: float, signal: Any) -> Any:
    place, n, m = signal.parameters + 8 * int(signal.place), int(signal.changes), int(signal.sines)
    changed = changes_value(t, view(place, (n,)), view(place + 8 * n, (n,)), view(place + 16 * n, (n,)))
    place += 24 * n
    swung = sines_value(t, view(place, (m,)), view(place + 8 * m, (m,)), view(place + 16 * m, (m,)))
    return signal.base + changed + swung


@apart
def _corner(t: float, signal: Any) -> Any:
    place, n = signal.parameters + 8 * int(signal.place), int(signal.changes)
    return changes_stop(t, view(place, (n,)), view(place + 8 * n, (n,)))


@intrinsic
def _is_same(typing: Any, one: Any, other: Any) -> Any:
    """Whether two numbers have the same bits: of a number and itself the compiler knows it, whereas NaN != NaN."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = [builder.bitcast(argument, ir.IntType(64)) for argument in arguments]
        return builder.icmp_unsigned("==", *bits)

    return types.boolean(types.float64, types.float64), generate


@register_jitable(**COMPILING)
def signal(t: float, base: float, place: float, changes: float, sines: float, parameters: int) -> Any:
    """The signal of these numbers, worked out at the time `t` [s]."""
    unknown = Signal(base=base, place=place, changes=changes, sines=sines, parameters=parameters, time=t, value=base)
    value = _moving(t, unknown) if place > 0.0 else base
    return Signal(base=base, place=place, changes=changes, sines=sines, parameters=parameters, time=t, value=value)


def _record_value(t: float, signal: Any) -> Any:
    if _is_same(float(t), signal.time):
        return signal.value
    return _moving(float(t), signal) if signal.place > 0.0 else signal.base


def _record_stop(t: float, signal: Any) -> Any:
    return _corner(float(t), signal) if signal.place > 0.0 else np.inf


def _is_record(signal: Any) -> bool:
    return getattr(signal, "instance_class", None) is Signal


def _is_empty(column: Any) -> bool:
    """Compiled code cannot index a tuple of nothing, even in a loop that never runs."""
    return isinstance(column, types.BaseTuple) and not len(column)


def _written_in_place(write: Callable[..., Vector], count: int) -> Any:
    """A function of so many numbers for compiled code, which `write` puts in place of its calls."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        code = Code(builder, 1, is_fused())
        return write(code, *(Vector(code, argument) for argument in arguments)).value

    if count == 1:
        return intrinsic(lambda typing, x: (types.float64(types.float64), generate))
    return intrinsic(lambda typing, x, y: (types.float64(types.float64, types.float64), generate))


_power, _expm1 = _written_in_place(in_place.power, 2), _written_in_place(in_place.expm1, 1)


def _power_form(base: Any, exponent: Any) -> Any:
    if isinstance(base, types.Number) and isinstance(exponent, types.Number):
        return lambda base, exponent: _power(float(base), float(exponent))
    return lambda base, exponent: base**exponent


def _expm1_form(x: Any) -> Any:
    return (lambda x: _expm1(float(x))) if isinstance(x, types.Number) else (lambda x: np.expm1(x))


def _select_form(condition: Any, a: Any, b: Any) -> Any:
    return lambda condition, a, b: a if condition else b


def _value_form(t: Any, signal: Any) -> Any:
    return _record_value if _is_record(signal) else signal_value


def _stop_form(t: Any, signal: Any) -> Any:
    return _record_stop if _is_record(signal) else signal_stop


def _changes_form(t: Any, start: Any, duration: Any, change: Any) -> Any:
    return (lambda t, start, duration, change: 0.0) if _is_empty(start) else changes_value


def _sines_form(t: Any, amplitude: Any, frequency: Any, phase: Any) -> Any:
    return (lambda t, amplitude, frequency, phase: 0.0) if _is_empty(amplitude) else sines_value


def _corner_form(t: Any, start: Any, duration: Any) -> Any:
    return (lambda t, start, duration: np.inf) if _is_empty(start) else changes_stop


FORMS: dict[Callable[..., Any], Callable[..., Any]] = {
    select: _select_form,
    signal_value: _value_form,
    signal_stop: _stop_form,
    changes_value: _changes_form,
    sines_value: _sines_form,
    changes_stop: _corner_form,
    power: _power_form,
    expm1: _expm1_form,
}
"""Functions whose compiled text differs from their Python text, and how it is chosen from the argument types."""

_registered: dict[Callable[..., Any], str | None] = {}
_forms: dict[Callable[..., Any], Callable[..., Any] | None] = {}


def make_compilable(function: Callable[..., Any], form: Callable[..., Any] | None, text: str | None = None) -> None:
    """Lets compiled code call the plain `function`; `form` is the function that it runs in its place, if another.

    `text` differs wherever the function or a constant of it does, so that none of an earlier text is compiled in.
    """
    known, before = function in _registered, _registered.get(function)
    if known and (_forms[function] is not form or (text and before and text != before)):
        _forget()
    _registered[function], _forms[function] = text or before, form
    if known:
        return
    if function in FORMS:
        overload(function, strict=False, jit_options=COMPILING)(FORMS[function])
    else:
        overload(function, strict=False, jit_options=COMPILING)(lambda *_, **__: _forms[function] or function)


def _forget() -> None:
    """Lets Numba compile all functions anew. It keeps each, with its constants and all that it calls, for good."""
    for template in builtin_registry.functions:
        if (function := getattr(template, "key", None)) in _registered:
            for name in ("_impl_cache", "_compiled_overloads", "_inline_overloads"):
                if (kept := getattr(template, name, None)) is None:
                    raise RunError(f"{function} is compiled here as it was before a change; start Python anew")
                kept.clear()


# Signals are worked out wherever there are some, also for functions that never ask for one.
_own: tuple[Any, ...] = (*FORMS, minimum, maximum, clip)
for _function in _own:
    make_compilable(_function, None)
