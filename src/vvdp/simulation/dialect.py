"""What functions of models may use besides the language: signals, views of flat vectors, and formulas in place.

The texts of `simulation.parts` build the arguments of a model's functions from flat vectors with these.
"""

import types
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.powers import expm1, power
from vvdp.base.select import select
from vvdp.base.signal import changes_stop, changes_value, signal_stop, signal_value, sines_value
from vvdp.generator.arrays import fill, item, reshape, total
from vvdp.generator.body import Body
from vvdp.generator.kinds import FLOAT
from vvdp.generator.operations import choose, combine, truth
from vvdp.generator.unit import Intrinsic, Options
from vvdp.generator.values import is_array, parts
from vvdp.simulation import lane_vectors
from vvdp.simulation.queue import TAKE, take
from vvdp.simulation.reach import compiled_form


class Signal(NamedTuple):
    """A signal in generated code: its numbers are in the parameters from `place` on; 0 where it is constant."""

    base: float
    place: float
    changes: float
    sines: float
    parameters: Any


def signal(t: float, base: float, place: float, changes: float, sines: float, parameters: Any) -> Signal:
    """The signal of these numbers in the flat vector `parameters`."""
    return Signal(base, place, changes, sines, parameters)


def moving(t: float, signal: Any) -> float:
    """The value at the time `t` [s] of a signal that may move."""
    place, n, m, p = int(signal.place), int(signal.changes), int(signal.sines), signal.parameters
    changed = changes_value(t, p[place : place + n], p[place + n : place + 2 * n], p[place + 2 * n : place + 3 * n])
    place = place + 3 * n
    swung = sines_value(t, p[place : place + m], p[place + m : place + 2 * m], p[place + 2 * m : place + 3 * m])
    value: float = signal.base + changed + swung
    return value


def corner(t: float, signal: Any) -> float:
    """The next time [s] at which a signal that may move has a corner."""
    place, n, p = int(signal.place), int(signal.changes), signal.parameters
    return changes_stop(t, p[place : place + n], p[place + n : place + 2 * n])


def record_value(t: float, signal: Any) -> float:
    """`base.signal.signal_value` of a signal in a flat vector."""
    return moving(t, signal) if signal.place > 0.0 else signal.base


def record_stop(t: float, signal: Any) -> float:
    """`base.signal.signal_stop` of a signal in a flat vector."""
    return corner(t, signal) if signal.place > 0.0 else np.inf


def view(vector: Any, place: int, shape: tuple[int, ...]) -> Any:
    """The numbers of a flat vector from `place` on as an array of this shape."""
    return vector[place : place + int(np.prod(shape))].reshape(shape)


def store(vector: Any, place: int, values: Any) -> int:
    """Write an array or a tuple to a flat vector from `place` on; returns the place behind it."""
    row = np.ravel(values)
    vector[place : place + row.size] = row
    return place + row.size


def _view_word(body: Body, vector: Any, place: Any, shape: Any) -> Any:
    count: Any = 1
    for length in shape:
        count = combine(body, "*", count, length)
    row = item(body, vector, slice(place, combine(body, "+", place, count)))
    return row if len(shape) == 1 else reshape(body, row, shape)


def _store_word(body: Body, vector: Any, place: Any, values: Any) -> Any:
    count = total(body, values) if is_array(values) else len(parts(values))
    end = body.bind(combine(body, "+", place, count))
    fill(body, item(body, vector, slice(place, end)), values)
    return end


def _select_word(body: Body, condition: Any, a: Any, b: Any) -> Any:
    return choose(body, truth(body, condition), body.bind(a), body.bind(b))


class _Forms(dict[Any, Any]):
    """What stands for a function: named here, or its module's `<name>_compiled`."""

    def get(self, function: Any, default: Any = None) -> Any:
        if function in self:
            return self[function]
        return compiled_form(function) or default if isinstance(function, types.FunctionType) else default


def model_options(plain: Mapping[str, Callable[..., float]] | None = None, *, checked: bool = False) -> Options:
    """How the functions of models are read.

    plain  powers and exponentials for the tree that is run by CPython, by default NumPy's
    """
    known = plain or {"power": np.float_power, "expm1": np.expm1}
    texts = _in_place_texts()
    return Options(
        replaced=_Forms({signal_value: record_value, signal_stop: record_stop}),
        intrinsics={
            power: Intrinsic("vvdp_power", (FLOAT, FLOAT), texts["power"], known["power"]),
            expm1: Intrinsic("vvdp_expm1", (FLOAT,), texts["expm1"], known["expm1"]),
            take: TAKE,
            lane_vectors.call: lane_vectors.CALL,
        },
        words={
            select: _select_word,
            view: _view_word,
            store: _store_word,
            lane_vectors.combine: lane_vectors.combine_word,
        },
        apart=frozenset({moving, corner}),
        checked=checked,
    )


@cache
def _in_place_texts() -> dict[str, str]:
    """The LLVM text of each function that is worked out in place."""
    from llvmlite import ir

    from vvdp.generator.binding import is_fused
    from vvdp.simulation import in_place
    from vvdp.simulation.lane_values import Code, Vector

    found = {}
    for name, write in (("power", in_place.power), ("expm1", in_place.expm1)):
        module, double = ir.Module(), ir.DoubleType()
        count = 2 if name == "power" else 1
        function = ir.Function(module, ir.FunctionType(double, [double] * count), f"vvdp_{name}")
        function.linkage = "internal"
        function.attributes.add("alwaysinline")
        code = Code(ir.IRBuilder(function.append_basic_block()), 1, is_fused())
        code.builder.ret(write(code, *(Vector(code, argument) for argument in function.args)).value)
        found[name] = str(module)
    return found
