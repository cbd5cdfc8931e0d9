"""How the functions of models are read: signals, views of flat vectors, and formulas in place."""

import types
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from vvdp.base.powers import expm1, power
from vvdp.base.select import select
from vvdp.base.signal import signal_stop, signal_value
from vvdp.generator.arrays import fill, item, reshape, total
from vvdp.generator.body import Body
from vvdp.generator.kinds import FLOAT, Intrinsic
from vvdp.generator.operations import choose, combine, truth
from vvdp.generator.unit import Options
from vvdp.generator.values import is_array, parts
from vvdp.simulation import lane_vectors
from vvdp.simulation.exchange import EXCHANGE, exchange
from vvdp.simulation.flat import corner, moving, record_stop, record_value, store, view
from vvdp.simulation.queue import TAKE, take
from vvdp.simulation.reach import compiled_form


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
    """Replacements of functions: named here, or their module's `<name>_compiled`."""

    def get(self, function: Any, default: Any = None) -> Any:
        if function in self:
            return self[function]
        return compiled_form(function) or default if isinstance(function, types.FunctionType) else default


def model_options(
    plain: Mapping[str, Callable[..., float]] | None = None, *, checked: bool = False, fused: bool | None = None
) -> Options:
    """How the functions of models are read.

    plain  powers and exponentials for the tree that is run by CPython, by default NumPy's
    fused  whether they multiply and add with one rounding; by default where this processor does
    """
    known = plain or {"power": np.float_power, "expm1": np.expm1}
    texts = _in_place_texts(fused)
    return Options(
        replaced=_Forms({signal_value: record_value, signal_stop: record_stop}),
        intrinsics={
            power: Intrinsic("vvdp_power", (FLOAT, FLOAT), texts["power"], known["power"]),
            expm1: Intrinsic("vvdp_expm1", (FLOAT,), texts["expm1"], known["expm1"]),
            take: TAKE,
            exchange: EXCHANGE,
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
def _in_place_texts(fused: bool | None) -> dict[str, str]:
    """The LLVM text of each function that is calculated in place."""
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
        code = Code(ir.IRBuilder(function.append_basic_block()), 1, is_fused() if fused is None else fused)
        code.builder.ret(write(code, *(Vector(code, argument) for argument in function.args)).value)
        found[name] = str(module)
    return found
