"""A traced graph as machine code that works out the rates of many cases side by side, without a compiler around.

The graph is written as LLVM's text for vectors as wide as the processor's, and compiled by the library that comes with
Numba. The compiled object is kept in the cache under the hash of its text, so that the next process only loads it.
"""

import hashlib
from collections.abc import Callable, Mapping
from functools import cache as remembered
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import llvmlite.binding as llvm
from llvmlite import ir

from vvdp.simulation.cache import default_cache, kept, quiet
from vvdp.simulation.lane_math import FUNCTIONS
from vvdp.simulation.lane_values import DOUBLE, Code, Mask, Vector
from vvdp.simulation.symbols import Node, Op
from vvdp.simulation.trace import Graph

WIDE, NARROW = 8, 4
ARGUMENTS = (Op.TIME, Op.STATE, Op.COMMAND, Op.PARAMETER, Op.SIGNAL)
"""What the function takes, in this order; behind them where its results go."""


class LaneRates(NamedTuple):
    """Compiled rates(t, y, u, p, s, dy) of addresses: of each number, `width` values one after the other."""

    width: int
    address: int
    symbol: str  # under which other compiled code finds it


def lane_rates(graph: Graph, cache: Path | None = None, say: Callable[[str], None] = quiet) -> LaneRates:
    """The compiled form of `graph` for this processor; `say` hears when it must be compiled.

    Raises RunError where the cache cannot be trusted.
    """
    width = host_width()
    text = lane_text(graph, width, is_fused())
    told = f"{llvmlite.__version__} {llvm.llvm_version_info} {text}"
    symbol = f"vvdp_lanes_{hashlib.sha256(told.encode()).hexdigest()[:16]}"
    if symbol not in _loaded:
        text = text.replace(NAME, symbol)

        def make() -> bytes:
            say("compiling rates for many cases at once (a few seconds)")
            return compiled(text)

        _loaded[symbol] = loaded(kept(symbol, make, cache or default_cache()))
        llvm.add_symbol(symbol, _loaded[symbol].get_function_address(symbol))
    return LaneRates(width, _loaded[symbol].get_function_address(symbol), symbol)


NAME = "vvdp_lanes"
_loaded: dict[str, Any] = {}
"""What holds the code of each function; it would be freed without."""


def host_width() -> int:
    """Lanes of a vector on this processor."""
    return WIDE if llvm.get_host_cpu_features().get("avx512f") else NARROW


def is_fused() -> bool:
    """Whether this processor multiplies and adds in one."""
    return bool(llvm.get_host_cpu_features().get("fma")) or not llvm.get_process_triple().startswith("x86")


def lane_text(graph: Graph, width: int, fused: bool) -> str:
    """LLVM's text of the function."""
    module = ir.Module(name=NAME)
    place = ir.PointerType(DOUBLE)
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [place] * (len(ARGUMENTS) + 1)), NAME)
    for argument in function.args:
        argument.add_attribute("noalias")
    code = Code(ir.IRBuilder(function.append_basic_block()), width, fused)
    values: list[Any] = []
    for node in graph.nodes:
        values.append(_written(code, node, [values[i] for i in node.inputs], function.args))
    for row, output in enumerate(graph.outputs):
        code.builder.store(values[output].value, _row(code, function.args[-1], row), align=8)
    code.builder.ret_void()
    return _widened(str(module), width)


def _written(code: Code, node: Node, inputs: list[Any], arguments: Any) -> Any:
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
"""What each operation is that a processor has."""


def _row(code: Code, vector: Any, row: int) -> Any:
    """The address of the lanes of a number."""
    kind = ir.PointerType(ir.VectorType(DOUBLE, code.width))
    first = code.builder.gep(vector, [ir.Constant(ir.IntType(64), row * code.width)])
    return code.builder.bitcast(first, kind)


def _widened(text: str, width: int) -> str:
    """`text` with the wish for whole vectors, which LLVM would otherwise halve on some processors."""
    bits = 64 * width
    wish = f'"prefer-vector-width"="{bits}" "min-legal-vector-width"="{bits}"'
    head, name, rest = text.partition(f'@"{NAME}"')
    signature, brace, body = rest.partition("{")
    return f"{head}{name}{signature.rstrip()} {wish}\n{brace}{body}"


def compiled(text: str) -> bytes:
    """The machine code of LLVM's `text` for this processor."""
    module = llvm.parse_assembly(text)
    module.triple = llvm.get_process_triple()
    machine = _machine()
    module.data_layout = str(machine.target_data)
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def loaded(code: bytes) -> Any:
    """An engine that holds the functions of compiled `code`."""
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


@remembered
def _ready() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_triple(llvm.get_process_triple())


def _machine() -> Any:
    features = llvm.get_host_cpu_features().flatten()
    return _ready().create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=3, jit=True)
