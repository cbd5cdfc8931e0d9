"""Code for many cases at once: its widths, its place in the cache, and how generated code calls it."""

import ctypes

import numpy as np
import pytest
from tests.compiled import compiled

from vvdp.generator.binding import compile_text, is_fused, load_code
from vvdp.simulation import lane_code, lane_vectors
from vvdp.simulation.lane_code import by_urgency, lane_rates, lane_text
from vvdp.simulation.symbols import Op, Recorder
from vvdp.simulation.trace import Graph, evaluate


@pytest.fixture
def graph():
    """Something of every kind of operation, of four inputs."""
    recorder = Recorder()
    t, y, u, p, s = (recorder.input(op) for op in (Op.TIME, Op.STATE, Op.COMMAND, Op.PARAMETER, Op.SIGNAL))
    inside = ((y > u) & ~(p <= s)) | (y == 2.0)
    outputs = [
        inside.select(np.sqrt(abs(y)) - t, -(u / p)),
        np.floor(s) + np.exp(u) * np.expm1(u) + np.log(p) - np.log1p(p) + p**u,
        np.sin(t) * np.cos(t) + np.tan(u) + np.tanh(y) + np.arctan(s),
        0.25,
    ]
    written = tuple(map(recorder.place, outputs))
    return Graph(tuple(recorder.nodes), written, 1, 1)


def values(width, rng):
    """Of each input as many numbers as there are lanes."""
    return [np.array([row]) for row in rng.uniform(0.1, 3.0, (5, width))]


def called(address, inputs, count):
    width = inputs[0].size
    result = np.zeros((count, width))
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 6)(address)(*(a.ctypes.data for a in (*inputs, result)))
    return result


def expected(graph, inputs):
    t, *vectors = inputs
    return np.array([np.broadcast_to(value, t.size) for value in evaluate(graph, t[0], *vectors)])


@pytest.mark.parametrize(("width", "fused"), [(4, False), (4, is_fused()), (8, is_fused())])
def test_every_width_gives_the_same(graph, width, fused):
    code = load_code(compile_text(lane_text(graph, width, fused), 3), [lane_code.NAME])
    rng = np.random.default_rng(6)
    for _ in range(20):
        inputs = values(width, rng)
        found = called(code.addresses[lane_code.NAME], inputs, 4)
        assert found == pytest.approx(expected(graph, inputs), rel=1e-14, abs=1e-14)


def call_lanes(place, t, y, u, p, s, result):
    lane_vectors.call(place, t, y, u, p, s, result)


def test_generated_code_calls_it_by_its_address(graph, tmp_path):
    lanes = lane_rates(graph, tmp_path)
    inputs, result = values(lanes.width, np.random.default_rng(7)), np.zeros((4, lanes.width))
    given = (lanes.address, *(each.ravel() for each in inputs), result.reshape(-1))
    compiled(call_lanes, *given)(*given)
    assert result == pytest.approx(expected(graph, inputs), rel=1e-14, abs=1e-14)


def test_compiled_code_is_kept_and_damage_is_seen(graph, tmp_path, monkeypatch):
    heard = []
    for _ in range(2):
        monkeypatch.setattr(lane_code, "_loaded", {})
        lane_rates(graph, tmp_path, heard.append)
    assert len(heard) == 1
    (place,) = tmp_path.iterdir()
    place.write_bytes(place.read_bytes()[:-1] + b"x")
    monkeypatch.setattr(lane_code, "_loaded", {})
    lanes = lane_rates(graph, tmp_path, heard.append)
    assert len(heard) == 2
    inputs = values(lanes.width, np.random.default_rng(8))
    assert called(lanes.address, inputs, 4) == pytest.approx(expected(graph, inputs), rel=1e-14, abs=1e-14)


def test_nothing_stands_before_what_it_takes(graph):
    order = by_urgency(graph)
    assert sorted(order) == list(range(len(graph.nodes)))
    when = {place: i for i, place in enumerate(order)}
    assert all(when[i] < when[place] for place, node in enumerate(graph.nodes) for i in node.inputs)
