"""The functions of a model as entries of a unit, from the texts that `simulation.parts` writes for Numba."""

import linecache
import re
import types
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

from vvdp.base.powers import expm1, power
from vvdp.base.select import select
from vvdp.base.signal import changes_stop, changes_value, signal_stop, signal_value, sines_value
from vvdp.generator.arrays import fill, item, reshape, total
from vvdp.generator.body import Body
from vvdp.generator.kinds import FLOAT, INT, Row, stand_in
from vvdp.generator.operations import choose, combine, truth
from vvdp.generator.unit import Intrinsic, Options, Unit
from vvdp.generator.values import is_array, parts
from vvdp.simulation import in_place
from vvdp.simulation.lane_code import is_fused
from vvdp.simulation.lane_values import Code, Vector
from vvdp.simulation.layout import blocks
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import (
    Part,
    conditions_part,
    events_part,
    measure_part,
    rates_part,
    step_part,
    stop_part,
)
from vvdp.simulation.reach import compiled_form

VECTOR = Row(FLOAT, (None,))


class Signal(NamedTuple):
    """A signal in generated code: its numbers stand in the parameters from `place` on."""

    base: float
    place: float
    changes: float
    sines: float
    parameters: Any


def signal(t, base, place, changes, sines, parameters):
    return Signal(base, place, changes, sines, parameters)


def moving(t, signal):
    place, n, m, p = int(signal.place), int(signal.changes), int(signal.sines), signal.parameters
    changed = changes_value(t, p[place : place + n], p[place + n : place + 2 * n], p[place + 2 * n : place + 3 * n])
    place = place + 3 * n
    swung = sines_value(t, p[place : place + m], p[place + m : place + 2 * m], p[place + 2 * m : place + 3 * m])
    return signal.base + changed + swung


def corner(t, signal):
    place, n, p = int(signal.place), int(signal.changes), signal.parameters
    return changes_stop(t, p[place : place + n], p[place + n : place + 2 * n])


def record_value(t, signal):
    return moving(t, signal) if signal.place > 0.0 else signal.base


def record_stop(t, signal):
    return corner(t, signal) if signal.place > 0.0 else np.inf


def address(vector):
    return vector


def view(vector, place, shape):
    """Written in place."""


def store(vector, place, values):
    """Written in place."""


def view_word(body: Body, vector: Any, place: Any, shape: Any) -> Any:
    count: Any = 1
    for length in shape:
        count = combine(body, "*", count, length)
    row = item(body, vector, slice(place, combine(body, "+", place, count)))
    return row if len(shape) == 1 else reshape(body, row, shape)


def store_word(body: Body, vector: Any, place: Any, values: Any) -> Any:
    count = total(body, values) if is_array(values) else len(parts(values))
    end = body.bind(combine(body, "+", place, count))
    fill(body, item(body, vector, slice(place, end)), values)
    return end


def select_word(body: Body, condition: Any, a: Any, b: Any) -> Any:
    return choose(body, truth(body, condition), body.bind(a), body.bind(b))


class Forms(dict[Any, Any]):
    """What stands for a function: named here, or its module's `<name>_compiled`."""

    def get(self, function: Any, default: Any = None) -> Any:
        if function in self:
            return self[function]
        return compiled_form(function) or default if isinstance(function, types.FunctionType) else default


def in_place_text(name: str, count: int, write: Callable[..., Vector]) -> str:
    """The LLVM text of one of the functions that are worked out in place."""
    module, double = ir.Module(), ir.DoubleType()
    function = ir.Function(module, ir.FunctionType(double, [double] * count), name)
    function.linkage = "internal"
    function.attributes.add("alwaysinline")
    code = Code(ir.IRBuilder(function.append_basic_block()), 1, is_fused())
    code.builder.ret(write(code, *(Vector(code, argument) for argument in function.args)).value)
    return str(module)


def options(plain: dict[str, Callable[..., float]] | None = None, *, checked: bool = False) -> Options:
    """How the functions of models are read; `plain` has the functions worked out in place for CPython."""
    known = plain or {"power": np.float_power, "expm1": np.expm1}
    return Options(
        replaced=Forms({signal_value: record_value, signal_stop: record_stop}),
        intrinsics={
            power: Intrinsic("vvdp_power", 2, in_place_text("vvdp_power", 2, in_place.power), known["power"]),
            expm1: Intrinsic("vvdp_expm1", 1, in_place_text("vvdp_expm1", 1, in_place.expm1), known["expm1"]),
        },
        words={select: select_word, view: view_word, store: store_word},
        apart=frozenset({moving, corner}),
        checked=checked,
    )


def function_of(part: Part, name: str) -> Callable[..., Any]:
    """The function of a part's text, without what only Numba needs."""
    text = re.sub(r"^def \w+\(", f"def {name}(", part.source[part.source.index("\ndef ") + 1 :])
    text = text.replace("_place", "").replace("8 * int(", "int(").replace("8 * (", "(")
    text = re.sub(r"^    [\w, ]+ = vector\(.*\n", "", text, flags=re.M)
    text = re.sub(r"view\(address\((\w)\) \+ ", r"view(\1, ", text)
    file = f"<{name} {hash(text)}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    known = {"np": np, "signal": signal, "address": address, "view": view, "store": store}
    known |= dict(part.called) | dict(part.classes.tuples())
    known |= {own: stand_in(cls) for own, cls in part.classes.records()}
    exec(compile(text, file, "exec"), known)
    found: Callable[..., Any] = known[name]
    return found


def unit_of(model: Model, case: Case, chosen: Options) -> Unit:
    """Every function of a model as an entry."""
    unit = Unit(chosen)
    named = {"rates": rates_part(model, case), "stop": stop_part(model, case), "events": events_part(model, case)}
    if model.conditions is not None:
        named["held"] = conditions_part(model.conditions, case)
    for number, (name, program) in enumerate(model.programs.items()):
        named[f"measure_{number}"] = measure_part(model, program, case)[0]
        named[f"step_{number}"] = step_part(model, name, case)
        assert blocks(case).programs[name] >= 0
    kinds = {"t": FLOAT, "k": INT}
    for name, part in named.items():
        function = function_of(part, name)
        code = function.__code__
        unit.add(function, [kinds.get(each, VECTOR) for each in code.co_varnames[: code.co_argcount]], name)
    return unit
