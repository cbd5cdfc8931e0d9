"""The rates of a model as a graph of operations, found by running their text over flat vectors on symbols.

Its inputs are the time, the numbers of state, command and parameters at their places in the flat vectors (`layout`),
and the value of each signal, in the order of the parameters: how a signal moves is no part of the graph. Its outputs
are all the numbers that the text writes.
"""

import operator
from collections import namedtuple
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vvdp.base.signal import Signal, signal_value, sine
from vvdp.simulation.layout import members, vectors
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import Part, rates_part
from vvdp.simulation.symbols import Node, Op, Recorder, Untraceable
from vvdp.simulation.values import names

SOME_TIME = 0.3141


@dataclass(frozen=True)
class Graph:
    """Operations, each on nodes before it, the nodes that are written as outputs, and how many inputs there are."""

    nodes: tuple[Node, ...]
    outputs: tuple[int, ...]
    states: int
    signals: int


def trace(model: Model, case: Case, wanted: Callable[[Model, Case], Part] = rates_part) -> Graph:
    """The rates of `model` for values of the shape of `case`, or what another part of it, `wanted`, calculates.

    Raises Untraceable, with the reason, where they cannot be written as a graph.
    """
    for name in ("state", "command", "params"):
        for path, leaf in members(getattr(case, name), name):
            if np.ndim(leaf):
                raise Untraceable(f"{path} is an array or a table, whose length is no part of a circuit's text")
    part, recorder, numbers = wanted(model, case), Recorder(), vectors(case)
    signals = count()

    def inputs(op: Op, size: int) -> list[Any]:
        return [recorder.input(op, i) for i in range(size)]

    def signal(*_: Any) -> Signal:
        value: Any = recorder.input(Op.SIGNAL, next(signals))
        return Signal(value)

    y, u, p = inputs(Op.STATE, numbers.state.size), inputs(Op.COMMAND, numbers.command.size), numbers.params.size
    try:
        written = _run(part, signal, recorder.input(Op.TIME), y, u, inputs(Op.PARAMETER, p))
        outputs = [recorder.place(value) for value in written]
    except Untraceable:
        raise
    except Exception as problem:
        raise Untraceable(f"a circuit does with its numbers what only plain ones can: {problem}") from problem
    graph = _without_idle(Graph(tuple(recorder.nodes), tuple(outputs), len(y), next(signals)))
    _check(graph, part, case)
    return graph


def evaluate(graph: Graph, t: Any, y: Sequence[Any], u: Sequence[Any], p: Sequence[Any], s: Sequence[Any]) -> list[Any]:
    """The outputs at a time, a state, a command, parameters and values of the signals, floats or arrays of them."""
    inputs: dict[Op, Sequence[Any]] = {Op.TIME: [t], Op.STATE: y, Op.COMMAND: u, Op.PARAMETER: p, Op.SIGNAL: s}
    values: list[Any] = []
    with np.errstate(all="ignore"):
        for node in graph.nodes:
            if node.op is Op.CONSTANT:
                values.append(np.float64(node.number))
            elif node.op in inputs:
                values.append(np.asarray(inputs[node.op][int(node.number)], float)[()])
            else:
                values.append(PLAIN[node.op](*(values[i] for i in node.inputs)))
    return [values[i] for i in graph.outputs]


PLAIN: dict[Op, Callable[..., Any]] = {
    Op.ADD: operator.add,
    Op.SUBTRACT: operator.sub,
    Op.MULTIPLY: operator.mul,
    Op.DIVIDE: operator.truediv,
    Op.NEGATIVE: operator.neg,
    Op.ABSOLUTE: np.absolute,
    Op.POWER: np.power,
    Op.SQRT: np.sqrt,
    Op.EXP: np.exp,
    Op.EXPM1: np.expm1,
    Op.LOG: np.log,
    Op.LOG1P: np.log1p,
    Op.SIN: np.sin,
    Op.COS: np.cos,
    Op.TAN: np.tan,
    Op.TANH: np.tanh,
    Op.ATAN: np.arctan,
    Op.FLOOR: np.floor,
    Op.LESS: operator.lt,
    Op.AT_MOST: operator.le,
    Op.EQUAL: operator.eq,
    Op.BOTH: np.logical_and,
    Op.EITHER: np.logical_or,
    Op.NOT: np.logical_not,
    Op.SELECT: np.where,
}
"""Each operation on floats, and on arrays."""


def dependencies(graph: Graph, p: Sequence[float] | None = None) -> NDArray[np.bool_]:
    """The states that each output depends on, shape (outputs, states); also where it only jumps with one.

    p  parameters that hold wherever this is used: what they switch off, or multiply by zero, is no dependency
    """
    known, found = _constant_values(graph, p), list[int]()  # a bit for each state
    for node, value in zip(graph.nodes, known, strict=True):
        inputs = node.inputs
        if node.op is Op.SELECT and known[inputs[0]] is not None:
            inputs = inputs[1:2] if known[inputs[0]] else inputs[2:]
        elif value is not None:
            inputs = ()
        own = 1 << int(node.number) if node.op is Op.STATE else 0
        for i in inputs:
            own |= found[i]
        found.append(own)
    return np.array([[bool(found[i] >> j & 1) for j in range(graph.states)] for i in graph.outputs], bool)


def _constant_values(graph: Graph, p: Sequence[float] | None) -> list[Any]:
    """The value of each node that parameters and constants settle, None for the others."""
    known: list[Any] = []
    with np.errstate(all="ignore"):
        for op, inputs, number in graph.nodes:
            values, settled = [known[i] for i in inputs], None
            if op is Op.CONSTANT:
                settled = np.float64(number)
            elif op is Op.PARAMETER and p is not None:
                settled = np.float64(p[int(number)])
            elif op is Op.MULTIPLY and 0.0 in values:
                settled = np.float64(0.0)
            elif values and not any(value is None for value in values):
                settled = PLAIN[op](*values)
            known.append(settled)
    return known


def _run(part: Part, signal: Callable[..., Any], t: Any, y: Any, u: Any, p: Any) -> list[Any]:
    """Result of the text of the rates, run unchanged in plain Python."""

    def store(vector: Any, place: int, values: Any) -> int:
        row = np.ravel(values)
        vector.update(enumerate(row, place))
        return place + row.size

    around: dict[str, Any] = {"np": np, "signal": signal, "store": store, **part.called}
    around |= dict(part.classes.tuples())
    around |= {name: namedtuple(name, names(cls)) for name, cls in part.classes.records()}
    written: dict[int, Any] = {}
    exec(part.source, around)
    around[part.name](t, y, u, p, written)
    return [written[place] for place in range(len(written))]


def _without_idle(graph: Graph) -> Graph:
    """The graph without operations on which no output depends, such as those of outputs that are no rates."""
    used = set(graph.outputs)
    for place in range(len(graph.nodes) - 1, -1, -1):
        if place in used:
            used.update(graph.nodes[place].inputs)
    renamed = {old: new for new, old in enumerate(sorted(used))}
    nodes = tuple(
        Node(op, tuple(renamed[i] for i in inputs), number)
        for op, inputs, number in (graph.nodes[old] for old in sorted(used))
    )
    return Graph(nodes, tuple(renamed[old] for old in graph.outputs), graph.states, graph.signals)


def _check(graph: Graph, part: Part, case: Case) -> None:
    """Raises Untraceable where the graph gives other values than its text at one state with moving signals, as when
    a circuit reads a signal at another time than the present."""
    flats, made = vectors(case), list[Signal]()

    def signal(t: float, base: float, *_: Any) -> Signal:
        made.append(sine(base, 1e-3 * abs(base) + 1e-6, 1.7, 0.4 * len(made)))
        return made[-1]

    y, u, p = flats.state.tolist(), flats.command.tolist(), flats.params.tolist()
    with np.errstate(all="ignore"):
        try:
            plain = _run(part, signal, SOME_TIME, y, u, p)
        except ArithmeticError:  # plain Python refuses what floats in compiled code pass on
            return
    traced = evaluate(graph, SOME_TIME, y, u, p, [signal_value(SOME_TIME, one) for one in made])
    for one, other in zip(plain, traced, strict=True):
        if not np.isclose(one, other, rtol=1e-7, atol=0.0, equal_nan=True):
            raise Untraceable("a circuit reads a signal at another time than the present, or does not stay the same")
