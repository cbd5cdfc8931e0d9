"""Derivatives of rates and outputs along a direction as C: the traced graph of a circuit, differentiated forward."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from vvdp.base.signal import Signal
from vvdp.export.c_machine import CMachine, parameter_places
from vvdp.generator.c_text import constant, wrap
from vvdp.generator.kinds import FLOAT
from vvdp.simulation.layout import members
from vvdp.simulation.parts import outputs_part
from vvdp.simulation.symbols import Node, Op
from vvdp.simulation.trace import Graph, trace

INFIX = {
    Op.ADD: "+", Op.SUBTRACT: "-", Op.MULTIPLY: "*", Op.DIVIDE: "/", Op.LESS: "<", Op.AT_MOST: "<=", Op.EQUAL: "==",
    Op.BOTH: "&&", Op.EITHER: "||",
}  # fmt: skip
CALLS = {
    Op.ABSOLUTE: "fabs", Op.POWER: "pow", Op.SQRT: "sqrt", Op.EXP: "exp", Op.EXPM1: "expm1", Op.LOG: "log",
    Op.LOG1P: "log1p", Op.SIN: "sin", Op.COS: "cos", Op.TAN: "tan", Op.TANH: "tanh", Op.ATAN: "atan",
    Op.FLOOR: "floor", Op.NEGATIVE: "-", Op.NOT: "!",
}  # fmt: skip
TRUTHS = frozenset({Op.LESS, Op.AT_MOST, Op.EQUAL, Op.BOTH, Op.EITHER, Op.NOT})
VECTORS = {Op.STATE: "y", Op.COMMAND: "u", Op.PARAMETER: "p"}
SLOPES: Mapping[Op, str] = {
    Op.NEGATIVE: "-1.0",
    Op.ABSOLUTE: "({a} < 0.0 ? -1.0 : 1.0)",
    Op.SQRT: "0.5 / {v}",
    Op.EXP: "{v}",
    Op.EXPM1: "({v} + 1.0)",
    Op.LOG: "1.0 / {a}",
    Op.LOG1P: "1.0 / (1.0 + {a})",
    Op.SIN: "cos({a})",
    Op.COS: "-sin({a})",
    Op.TAN: "(1.0 + {v} * {v})",
    Op.TANH: "(1.0 - {v} * {v})",
    Op.ATAN: "1.0 / (1.0 + {a} * {a})",
}
"""The derivative of an operation on one number `a` with the value `v`."""
HEADER = """\
/* Derivatives at t along a direction: `dy` of the state, `dp` of the parameters that are inputs of the FMU.
   Fills `found` with those of {rates} rates [per second] and of {outputs} outputs; u, which holds between two samples,
   is constant. */
void {name}_tangent(const {name}_machine *machine, double t, const double *dy, const double *dp, double *found);
"""
ALONG = """\
/* A slope times a direction; nothing where the direction is nothing, be the slope infinite. */
static double along(double slope, double d)
{
    return d == 0.0 ? 0.0 : slope * d;
}
"""
SIGNAL = """\
/* The value of a signal at t: its base, changes that each take some time, and sines. */
static double signal_at(double t, const double *p, const double *slots)
{
    const double *start = p + (int)slots[1];
    const int changes = (int)slots[2], sines = (int)slots[3];
    const double *duration = start + changes, *change = duration + changes;
    const double *amplitude = change + changes, *frequency = amplitude + sines, *phase = frequency + sines;
    double value = slots[0];
    for (int i = 0; i < changes; i++) {
        const double gone = duration[i] > 0.0 ? (t - start[i]) / duration[i] : t >= start[i] ? 1.0 : 0.0;
        value += change[i] * fmin(fmax(gone, 0.0), 1.0);
    }
    for (int i = 0; i < sines; i++) {
        value += amplitude[i] * sin(6.283185307179586 * frequency[i] * t + phase[i]);
    }
    return value;
}
"""


class Tangent(NamedTuple):
    """The graph of the rates, of which there are so many, and behind them of the outputs.

    signals  where in the parameters each signal begins
    inputs   the places of the parameters along which there are derivatives
    """

    graph: Graph
    rates: int
    signals: tuple[int, ...]
    inputs: frozenset[int]

    @property
    def is_active(self) -> list[bool]:
        """Whether each node changes along any direction."""
        found = list[bool]()
        for op, inputs, number in self.graph.nodes:
            place = self.signals[int(number)] if op is Op.SIGNAL else int(number)
            own = op is Op.STATE or (op in (Op.PARAMETER, Op.SIGNAL) and place in self.inputs)
            passes = op not in TRUTHS and op is not Op.FLOOR
            steered = inputs[1:] if op is Op.SELECT else inputs
            found.append(own or (passes and any(found[i] for i in steered)))
        return found

    @property
    def sources(self) -> list[frozenset[tuple[Op, int]]]:
        """By rate or output: the states (Op.STATE) and parameters that are inputs (Op.PARAMETER) that it depends on by
        their places, and Op.TIME; also where it only jumps with one."""
        found = list[frozenset[tuple[Op, int]]]()
        for op, inputs, number in self.graph.nodes:
            place = self.signals[int(number)] if op is Op.SIGNAL else int(number) if op in VECTORS else 0
            own = frozenset[tuple[Op, int]]()
            if op in (Op.PARAMETER, Op.SIGNAL) and place in self.inputs:
                own = frozenset([(Op.PARAMETER, place)])
            elif op is Op.STATE or op in (Op.TIME, Op.SIGNAL):
                own = frozenset([(op, place) if op is Op.STATE else (Op.TIME, 0)])
            found.append(own.union(*(found[i] for i in inputs)))
        return [found[i] for i in self.graph.outputs]


def tangent_of(machine: CMachine, inputs: frozenset[int]) -> Tangent:
    """The derivatives of a machine. Raises Untraceable, with the reason, where they cannot be written."""
    model, case = machine.system.model, machine.system.case
    rates, outputs = trace(model, case), trace(model, case, outputs_part)
    found = zip(members(case.params, ""), parameter_places(case), strict=False)
    signals = tuple(begin for (_, value), (begin, _, _) in found if isinstance(value, Signal))
    return Tangent(_union_of(rates, outputs), len(rates.outputs), signals, inputs)


def _union_of(one: Graph, other: Graph) -> Graph:
    """Both graphs with what they have in common once."""
    nodes, known = list(one.nodes), {node: place for place, node in enumerate(one.nodes)}
    renamed = list[int]()
    for op, inputs, number in other.nodes:
        node = Node(op, tuple(renamed[i] for i in inputs), number)
        if node not in known:
            known[node] = len(nodes)
            nodes.append(node)
        renamed.append(known[node])
    return Graph(tuple(nodes), (*one.outputs, *(renamed[i] for i in other.outputs)), one.states, one.signals)


def tangent_header(machine: CMachine, tangent: Tangent) -> str:
    """The function for callers."""
    outputs = len(tangent.graph.outputs) - tangent.rates
    return HEADER.format(name=machine.name, rates=tangent.rates, outputs=outputs)


def tangent_text(machine: CMachine, tangent: Tangent) -> str:
    """The source file of the function."""
    graph, active, name = tangent.graph, tangent.is_active, machine.name
    numbers = "const double *dy, const double *dp, double *found"
    lines = [f'#include "{name}.h"\n\n#include <math.h>\n', *([SIGNAL] if tangent.signals else []), ALONG]
    lines.append(wrap(f"void {name}_tangent(const {name}_machine *machine, double t, {numbers})"))
    lines += ["{", "    const double *y = machine->state, *u = machine->command, *p = machine->parameters;"]
    needed = _value_places(graph, active)
    for place, node in enumerate(graph.nodes):
        if place in needed:
            kind = "int" if node.op in TRUTHS else "double"
            lines.append(wrap(f"    const {kind} v{place} = {_value(node, tangent)};"))
        if active[place]:
            lines.append(wrap(f"    const double d{place} = {_slope(place, node, tangent, active)};"))
    lines += [f"    found[{row}] = {f'd{i}' if active[i] else '0.0'};" for row, i in enumerate(graph.outputs)]
    lines += [f"    (void){word};" for word in ("t", "y", "u", "p", "dy", "dp")]
    return "\n".join([*lines, "}", ""])


def _value_places(graph: Graph, active: Sequence[bool]) -> set[int]:
    """The nodes whose values the derivatives take."""
    found = set[int]()
    for place in range(len(graph.nodes) - 1, -1, -1):
        node = graph.nodes[place]
        if active[place]:
            found.update(_values_behind(place, node, active))
        if place in found:
            found.update(node.inputs)
    return found


def _values_behind(place: int, node: Node, active: Sequence[bool]) -> Iterator[int]:
    """The nodes whose values the derivative of a node takes, itself among them."""
    op, inputs = node.op, node.inputs
    if op is Op.SELECT:
        yield inputs[0]
    elif op is Op.MULTIPLY:
        yield from (other for one, other in (inputs, inputs[::-1]) if active[one])
    elif op is Op.DIVIDE:
        yield from (inputs[1], *([place] if active[inputs[1]] else []))
    elif op is Op.POWER:
        yield from (*inputs, place)
    elif op in SLOPES:
        yield from ([inputs[0]] if "{a}" in SLOPES[op] else []) + ([place] if "{v}" in SLOPES[op] else [])


def _value(node: Node, tangent: Tangent) -> str:
    """The value of a node in C."""
    values = [f"v{i}" for i in node.inputs]
    if node.op is Op.CONSTANT:
        return constant(FLOAT, node.number)
    if node.op is Op.TIME:
        return "t"
    if node.op is Op.SIGNAL:
        return f"signal_at(t, p, p + {tangent.signals[int(node.number)]})"
    if node.op in VECTORS:
        return f"{VECTORS[node.op]}[{int(node.number)}]"
    if node.op in INFIX:
        return f" {INFIX[node.op]} ".join(values)
    if node.op is Op.SELECT:
        return f"{values[0]} ? {values[1]} : {values[2]}"
    return f"{CALLS[node.op]}({', '.join(values)})"


def _slope(place: int, node: Node, tangent: Tangent, active: Sequence[bool]) -> str:
    """The derivative of an active node in C."""
    op, inputs = node.op, node.inputs
    slopes = [f"d{i}" if active[i] else "0.0" for i in inputs]
    values = [f"v{i}" for i in inputs]
    if op is Op.STATE:
        return f"dy[{int(node.number)}]"
    if op in (Op.PARAMETER, Op.SIGNAL):
        return f"dp[{tangent.signals[int(node.number)] if op is Op.SIGNAL else int(node.number)}]"
    if op is Op.SELECT:
        return f"{values[0]} ? {slopes[1]} : {slopes[2]}"
    if op in SLOPES:
        return f"along({SLOPES[op].format(a=values[0], v=f'v{place}')}, {slopes[0]})"
    return " + ".join(PAIRS[op](place, values, slopes, [active[i] for i in inputs]))


Terms = Callable[[int, list[str], list[str], list[bool]], list[str]]


def _sum(place: int, v: list[str], d: list[str], active: list[bool]) -> list[str]:
    return [each for each, own in zip(d, active, strict=True) if own]


def _difference(place: int, v: list[str], d: list[str], active: list[bool]) -> list[str]:
    return [d[0]] * active[0] + [f"-{d[1]}"] * active[1]


def _product(place: int, v: list[str], d: list[str], active: list[bool]) -> list[str]:
    return [f"{d[0]} * {v[1]}"] * active[0] + [f"{v[0]} * {d[1]}"] * active[1]


def _quotient(place: int, v: list[str], d: list[str], active: list[bool]) -> list[str]:
    return [f"{d[0]} / {v[1]}"] * active[0] + [f"-v{place} * {d[1]} / {v[1]}"] * active[1]


def _power(place: int, v: list[str], d: list[str], active: list[bool]) -> list[str]:
    of_base = f"along({v[1]} * pow({v[0]}, {v[1]} - 1.0), {d[0]})"
    return [of_base] * active[0] + [f"along(v{place} * log({v[0]}), {d[1]})"] * active[1]


PAIRS: Mapping[Op, Terms] = {
    Op.ADD: _sum,
    Op.SUBTRACT: _difference,
    Op.MULTIPLY: _product,
    Op.DIVIDE: _quotient,
    Op.POWER: _power,
}
"""The terms of the derivative of an operation on two numbers."""
