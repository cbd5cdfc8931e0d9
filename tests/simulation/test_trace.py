"""Tracing a circuit: its graph, which states each rate depends on, and what cannot be traced and why."""

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.kinds import Kind
from vvdp.base.params import Params
from vvdp.base.select import clip, select
from vvdp.base.signal import Signal, constant, signal_value
from vvdp.simulation.model import Case, Model
from vvdp.simulation.symbols import Node, Op, Recorder, Untraceable
from vvdp.simulation.trace import dependencies, evaluate, trace
from vvdp.simulation.values import leaves
from vvdp.systems.system import load_system

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
Prescribed = Annotated[Signal, Kind("plain number", "1", -1e9, 1e9, "1")]


class Pair(NamedTuple):
    x: Plain
    v: Plain


class Swing(Params):
    stiffness: Plain
    damping: Plain
    force: Prescribed


class Listed(Params):
    gains: tuple[float, ...]


CASE = Case(Pair(1.0, 2.0), Swing(stiffness=3.0, damping=0.0, force=constant(0.5)))


def swing(t, s, u, p):
    pull = signal_value(t, p.force) - p.stiffness * s.x - p.damping * s.v * abs(s.v)
    return Pair(s.v, pull), Pair(0.0, s.x * s.v)


def traced(circuit, case=CASE):
    return trace(Model(circuit), case)


def test_inputs_are_state_parameters_and_the_value_of_each_signal():
    graph = traced(swing)
    assert evaluate(graph, 0.0, [1.0, 2.0], [], [3.0, 0.25], [0.5]) == [2.0, 0.5 - 3.0 - 0.25 * 4.0]
    assert (graph.states, graph.signals) == (2, 1)
    assert not [node for node in graph.nodes if node.op is Op.TIME]  # the outputs' own work is left out
    assert dependencies(graph).tolist() == [[False, True], [True, True]]


def test_parameters_at_hand_thin_the_pattern():
    assert dependencies(traced(swing), [3.0, 0.0]).tolist() == [[False, True], [True, False]]

    def switched(t, s, u, p):
        return Pair(select(p.stiffness > 0.0, s.x, s.v), 0.0), 0.0

    assert dependencies(traced(switched)).tolist() == [[True, True], [False, False]]
    assert dependencies(traced(switched), [1.0, 0.0]).tolist() == [[True, False], [False, False]]


def test_the_same_work_is_noted_once():
    recorder = Recorder()
    a, b = recorder.input(Op.STATE, 0), recorder.input(Op.STATE, 1)
    before = len(recorder.nodes)
    assert (a + b).place == (b + a).place == np.add(a, b).place
    assert (a < b).place == (b > a).place
    assert len(recorder.nodes) == before + 2
    assert (a - b).place != (b - a).place


def test_only_what_changes_no_float_is_left_out():
    recorder = Recorder()
    a = recorder.input(Op.STATE, 0)
    assert all(same is a for same in (1.0 * a, a * 1, a / 1.0, a - 0.0, a**1, +a, (a < 2.0).select(a, a)))
    for kept in (a + 0.0, 0.0 - a, a * 0.0, a - (-0.0)):  # -0.0 and nan come out otherwise
        assert kept.place != a.place
    assert recorder.place(0.0) != recorder.place(-0.0)
    assert recorder.place(math.nan) == recorder.place(math.nan)


def test_small_whole_powers_are_products():
    recorder = Recorder()
    a = recorder.input(Op.STATE, 0)
    assert (a**2).place == np.square(a).place == (a * a).place
    assert (a**2.0).place == (a * a).place
    assert (a**3).place == (a * a * a).place
    assert (a**4).place == ((a * a) * (a * a)).place
    assert (a**-2).place == (1.0 / (a * a)).place
    for exponent in (0.5, 5, 0, a):
        assert recorder.nodes[(a**exponent).place].op is Op.POWER


def test_numpy_and_select_take_symbols():
    def circuit(t, s, u, p):
        inside = (s.x > -1.0) & ~(s.v >= 9.0) | (s.x == 7.0)
        chosen = select(inside, np.float64(2.0) * np.sqrt(abs(s.x)), -clip(s.v, 0.0, 1.0))
        return Pair(chosen, np.sin(s.x) + np.cos(s.x) - np.tan(s.x) / np.tanh(s.v) + np.arctan(s.v) * t), 0.0

    graph = traced(circuit)
    for x, v in ((0.3, 2.0), (-3.0, 0.5), (7.0, 12.0)):
        rates, _ = circuit(0.7, Pair(x, v), None, None)
        assert evaluate(graph, 0.7, [x, v], [], [], []) == pytest.approx(list(rates), rel=1e-15)


def test_a_longer_hose_has_a_longer_band_and_no_denser():
    counts = []
    for pieces in (4, 8, 16):
        system = load_system("long-hose", [f"components.hose.pieces={pieces}"])
        graph = trace(system.model, system.case)
        active = [i for i, (path, _, _) in enumerate(leaves(system.case.state)) if not path.startswith("books.")]
        counts.append(int(dependencies(graph)[np.ix_(active, active)].sum()))
    assert counts[2] - counts[1] == 2 * (counts[1] - counts[0]) > 0


def test_what_cannot_be_traced_is_told_why():
    def branching(t, s, u, p):
        return Pair(s.v if s.x > 0.0 else 0.0, 0.0), 0.0

    def chained(t, s, u, p):
        return Pair(select(0.0 < s.x < 1.0, 1.0, 0.0), 0.0), 0.0

    def plain_math(t, s, u, p):
        return Pair(math.sin(s.x), 0.0), 0.0

    def unknown(t, s, u, p):
        return Pair(np.arcsinh(s.x), 0.0), 0.0

    def remainder(t, s, u, p):
        return Pair(s.x % 2.0, 0.0), 0.0

    def late(t, s, u, p):
        return Pair(signal_value(t - 1.0, p.force), 0.0), 0.0

    told = {
        branching: "use select",
        chained: "use select",
        plain_math: "those of numpy",
        unknown: "numpy.arcsinh",
        remainder: "unsupported operand",
        late: "another time",
    }
    for circuit, words in told.items():
        with pytest.raises(Untraceable, match=words):
            traced(circuit)
    with pytest.raises(Untraceable, match=r"params\.gains " + wording.simulation.array_or_table):
        traced(swing, Case(Pair(0.0, 0.0), Listed(gains=(1.0, 2.0))))


def test_nodes_stand_behind_what_they_take():
    nodes = traced(swing).nodes
    assert all(i < place for place, node in enumerate(nodes) for i in node.inputs)
    assert len(set(nodes)) == len(nodes)
    assert isinstance(nodes[0], Node)
