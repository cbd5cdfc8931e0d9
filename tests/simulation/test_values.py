"""Nested values taken apart by their classes: the same as field by field."""

from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.kinds import PRESSURE_LEVEL, Length, Pressure
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal, constant, step
from vvdp.simulation.values import flat, form, leaves, names
from vvdp.systems.system import load_system, shipped_systems


class One(NamedTuple):
    pressure: Pressure


class Two(Params):
    length: Length
    level: Pressure | Signal
    table: tuple[float, ...] = (1.0, 2.0)


class Nested(NamedTuple):
    one: One
    two: Two
    nothing: tuple[()]
    array: np.ndarray
    count: int


def nested(**changed):
    two = {"length": 0.5, "level": constant(2e5), **changed}
    return Nested(One(1e5), Two(**two), (), np.arange(4.0).reshape(2, 2), 3)


def field_by_field(value, path="", kind=None):
    inner = names(value)
    if not inner:
        yield path, value, kind
    for name in inner:
        below = f"{path}.{name}" if path else name
        yield from field_by_field(getattr(value, name), below, field_kinds(type(value)).get(name))


def examples():
    yield nested()
    yield nested(level=step(1e5, 2e5, 0.5))
    for name in shipped_systems():
        case = load_system(name).case
        yield from (case.state, case.params, case.command, *case.memory.values(), *case.settings.values())


def test_same_as_field_by_field():
    for value in examples():
        expected, found = list(field_by_field(value)), list(leaves(value))
        assert [(path, kind) for path, _, kind in found] == [(path, kind) for path, _, kind in expected]
        assert all(one is other for (_, one, _), (_, other, _) in zip(found, expected, strict=True))
        numbers = [np.ravel(np.asarray(leaf, float)) for _, leaf, _ in expected]
        np.testing.assert_array_equal(flat(value), np.concatenate([*numbers, np.zeros(0)]))


def test_forms():
    alike = form(nested(), {})
    assert form(nested(length=0.6), {}) == alike
    assert form(nested(level=step(1e5, 2e5, 0.5)), {}) == alike
    assert form(nested(level=2e5), {}) != alike
    assert form(nested(table=(1.0,)), {}) != alike
    assert form(nested()._replace(array=np.zeros(4)), {}) != alike
    assert form(nested()._replace(one=2.0), {}) != alike


def test_leaves_below_a_path_and_a_kind():
    assert list(leaves(2.0, "p", PRESSURE_LEVEL)) == [("p", 2.0, PRESSURE_LEVEL)]
    assert [path for path, _, _ in leaves(One(1.0), "above")] == ["above.pressure"]


@pytest.mark.parametrize("wrong", [np.nan, -1e5, 1e2, 1e12])
def test_a_start_that_is_wrong_is_told_of_its_case_alone(wrong):
    from dataclasses import replace

    from vvdp.simulation.batch import simulate_batch

    system = load_system("prototype", until="1 ms")
    off = system.case.state._replace(inlet=wrong)
    run = simulate_batch(system.model, [system.case, replace(system.case, state=off)], system.stepping)
    assert run.reasons[0] is None and "state 'inlet' starts wrongly" in run.reasons[1]
