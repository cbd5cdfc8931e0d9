"""A traced graph as machine code that calculates the rates of many cases side by side, without a compiler around.

The graph is written as LLVM's text for vectors as wide as the processor's. The compiled object is kept in the cache
under the hash of the graph and of what writes its text, so that the next process only loads it.
"""

import hashlib
from collections.abc import Callable, Mapping
from functools import cache as remembered
from pathlib import Path
from typing import Any, NamedTuple

from llvmlite import ir

from vvdp.generator import binding
from vvdp.simulation import lane_math, lane_values
from vvdp.simulation.cache import default_cache, keep, one_at_a_time, quiet, read_kept
from vvdp.simulation.lane_math import FUNCTIONS
from vvdp.simulation.lane_values import DOUBLE, Code, Mask, Vector
from vvdp.simulation.symbols import Node, Op
from vvdp.simulation.trace import Graph

WIDE, NARROW = 8, 4
ARGUMENTS = (Op.TIME, Op.STATE, Op.COMMAND, Op.PARAMETER, Op.SIGNAL)
"""Arguments of the function, in this order; behind them the place for its results."""

CYCLES = {Op.DIVIDE: 13, Op.SQRT: 20, Op.POWER: 95, Op.FLOOR: 4} | dict.fromkeys(
    (Op.EXP, Op.EXPM1, Op.LOG, Op.LOG1P, Op.SIN, Op.COS, Op.TAN, Op.TANH, Op.ATAN), 55
)
"""About how long one has to wait for an operation; for others about 3."""


class LaneRates(NamedTuple):
    """Compiled rates(t, y, u, p, s, dy) of addresses: of each number, `width` values one after the other.

    What is written at `dy` must not lie where something is read.
    """

    width: int
    address: int
    symbol: str  # under which other compiled code finds it


def lane_rates(graph: Graph, cache: Path | None = None, say: Callable[[str], None] = quiet) -> LaneRates:
    """The compiled form of `graph` for this processor; `say` is informed when it must be compiled.

    Raises RunError where the cache cannot be trusted.
    """
    told = f"{_versions()} {graph!r}"
    symbol = f"{NAME}_{hashlib.sha256(told.encode()).hexdigest()[:16]}"

    with one_at_a_time:
        if symbol not in _loaded:
            place = cache or default_cache()
            code = read_kept(symbol, place)
            if code is None:
                say("compiling rates for many cases at once")
                text = lane_text(graph, host_width(), binding.is_fused()).replace(NAME, symbol)
                code = binding.compile_text(text, level=3)
                keep(symbol, code, place)
            _loaded[symbol] = binding.load_code(code, [symbol])
    return LaneRates(host_width(), _loaded[symbol].addresses[symbol], symbol)


NAME = "vvdp_lanes"
_loaded: dict[str, binding.Loaded] = {}
"""Owner of the code of each function; without it the code would be freed."""


@remembered
def _versions() -> str:
    """Versions that compiled code depends on besides the graph; the processor is part of its file's name."""
    own = (__file__, lane_math.__file__, lane_values.__file__)
    return hashlib.sha256(b"".join(Path(path).read_bytes() for path in own)).hexdigest()


def host_width() -> int:
    """Lanes of a vector on the processor that code is made for."""
    return WIDE if binding.has_feature("avx512f") else NARROW


def lane_text(graph: Graph, width: int, fused: bool) -> str:
    """LLVM's text of the function."""
    module = ir.Module(name=NAME)
    kinds = [ir.PointerType(DOUBLE)] * (len(ARGUMENTS) + 1)
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), NAME)
    for argument in function.args:
        argument.add_attribute("noalias")
    code = Code(ir.IRBuilder(function.append_basic_block()), width, fused)
    values: dict[int, Any] = {}
    for place in by_urgency(graph):
        node = graph.nodes[place]
        values[place] = _write_node(code, node, [values[i] for i in node.inputs], function.args)
        for row in (row for row, output in enumerate(graph.outputs) if output == place):
            code.builder.store(values[place].value, _row(code, function.args[-1], row), align=8)
    code.builder.ret_void()
    return _prefer_whole_vectors(str(module), width)


def by_urgency(graph: Graph) -> list[int]:
    """The nodes in the order in which they must begin at the latest, none before what it takes.

    A processor works on what stands close together; in the order of the formulas it would mostly wait for one chain.
    """
    latest = [0] * len(graph.nodes)
    for place in range(len(graph.nodes) - 1, -1, -1):
        op, inputs, _ = graph.nodes[place]
        latest[place] -= CYCLES.get(op, 3 if inputs else 0)
        for i in inputs:
            latest[i] = min(latest[i], latest[place])
    return sorted(range(len(graph.nodes)), key=lambda place: (latest[place], place))


def _write_node(code: Code, node: Node, inputs: list[Any], arguments: Any) -> Any:
    """The vector or mask of a node."""
    if node.op is Op.CONSTANT:
        return code.vector(node.number)
    if node.op in ARGUMENTS:
        place = _row(code, arguments[ARGUMENTS.index(node.op)], int(node.number))
        return Vector(code, code.builder.load(place, align=8))
    if node.op in FUNCTIONS:
        return FUNCTIONS[node.op](code, *inputs)
    return SIMPLE[node.op](code, *inputs)


SIMPLE: Mapping[Op, Callable[..., Vector | Mask]] = {
    Op.ADD: lambda _, a, b: a + b,
    Op.SUBTRACT: lambda _, a, b: a - b,
    Op.MULTIPLY: lambda _, a, b: a * b,
    Op.DIVIDE: lambda _, a, b: a / b,
    Op.NEGATIVE: lambda _, a: -a,
    Op.ABSOLUTE: lambda _, a: abs(a),
    Op.SQRT: lambda code, a: code.call("sqrt", a),
    Op.FLOOR: lambda code, a: code.call("floor", a),
    Op.LESS: lambda _, a, b: a < b,
    Op.AT_MOST: lambda _, a, b: a <= b,
    Op.EQUAL: lambda _, a, b: a.equals(b),
    Op.BOTH: lambda _, a, b: a & b,
    Op.EITHER: lambda _, a, b: a | b,
    Op.NOT: lambda _, a: ~a,
    Op.SELECT: lambda _, condition, a, b: condition.select(a, b),
}
"""Code of each operation that a processor has."""


def _row(code: Code, vector: Any, row: int) -> Any:
    """The address of the lanes of a number."""
    kind = ir.PointerType(code.kind(DOUBLE))
    first = code.builder.gep(vector, [ir.Constant(ir.IntType(64), row * code.width)])
    return code.builder.bitcast(first, kind)


def _prefer_whole_vectors(text: str, width: int) -> str:
    """`text` with the wish for whole vectors, which LLVM would otherwise halve on some processors."""
    bits = 64 * width
    wish = f'"prefer-vector-width"="{bits}" "min-legal-vector-width"="{bits}"'
    head, name, rest = text.partition(f'@"{NAME}"')
    signature, brace, body = rest.partition("{")
    return f"{head}{name}{signature.rstrip()} {wish}\n{brace}{body}"
