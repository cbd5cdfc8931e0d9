"""What holds for every component of the library."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.compiled import compiled

from vvdp.base.kinds import Flow, Power
from vvdp.base.params import Params
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import Passage, passage
from vvdp.network.component import Component

ROUNDING = 1e-12


def numbers(value: Any) -> list[Any]:
    return [x for part in value for x in numbers(part)] if hasattr(value, "_fields") else [value]


def joined(values: list[Any], join: Any) -> Any:
    """One value of many: each number of a record goes through `join`."""
    first = values[0]
    if isinstance(first, Params):
        return first
    if hasattr(first, "_fields"):
        return type(first)(*(joined(list(parts), join) for parts in zip(*values, strict=True)))
    return join(values)


def test_power_and_oil_balance(component, power_balance):
    assert power_balance(component) >= 40


def test_start_and_stop_fit(component, meetings, call):
    for group in meetings(component):
        for met in group:
            if component.start:
                assert type(component.start(met.params[0])) is component.state
            if component.stop:
                assert call(component, component.stop, met) > met.values["t"]
            if component.mark:
                assert np.isfinite(call(component, component.mark, met))


def test_arrays_and_symbols_give_the_same(component, meetings, met_argument):
    casadi = pytest.importorskip("casadi")
    for group in meetings(component):
        cases = [[met_argument(a, met) for a in component.arguments] for met in group]
        plain = np.array([numbers(component.law(*case)) for case in cases], float)
        assert np.all(np.isfinite(plain))
        scale = np.max(np.abs(plain), axis=0).clip(1e-300)

        columns = [joined(list(column), np.array) for column in zip(*cases, strict=True)]
        together = numbers(component.law(*columns))
        arrays = np.array([np.broadcast_to(x, len(cases)) for x in together]).T
        assert np.max(np.abs(arrays - plain) / scale) < ROUNDING

        symbols: list[Any] = []
        inputs: list[np.ndarray] = []

        def symbol(values: list[float], symbols=symbols, inputs=inputs) -> Any:
            symbols.append(casadi.SX.sym(f"x{len(symbols)}"))
            inputs.append(np.array(values))
            return symbols[-1]

        traced = numbers(component.law(*(joined(list(column), symbol) for column in zip(*cases, strict=True))))
        function = casadi.Function("f", symbols, [casadi.vertcat(*traced)])
        found = np.array([np.ravel(function(*row)) for row in np.array(inputs).T])
        assert np.max(np.abs(found - plain) / scale) < ROUNDING


@pytest.mark.thorough
def test_compiled_code_gives_the_same(component, meetings, met_argument):
    for group in meetings(component):
        cases = [[met_argument(a, met) for a in component.arguments] for met in group[:10]]
        plain = np.array([numbers(component.law(*case)) for case in cases], float)
        fast = compiled(component.law, *cases[0])
        values = np.array([numbers(fast(*case)) for case in cases], float)
        scale = np.max(np.abs(plain), axis=0).clip(1e-300)
        assert np.max(np.abs(values - plain) / scale) < ROUNDING


class Thief(NamedTuple):
    """Oil that does not arrive."""

    a: Flow
    b: Flow
    loss: Power


def uphill(a: FluidState, b: FluidState) -> Passage:
    """Flows against its drop."""
    return passage(1e-12 * (b.pressure - a.pressure), a, b)


def leaky(a: FluidState, b: FluidState) -> Thief:
    """Loses a tenth of the oil on its way, with its power in order."""
    q, _ = passage(1e-12 * (a.pressure - b.pressure), a, b)
    return Thief(-q, 0.9 * q, q * (a.enthalpy - 0.9 * b.enthalpy))


def free(a: FluidState, b: FluidState) -> Thief:
    """Forgets its loss."""
    q, _ = passage(1e-12 * (a.pressure - b.pressure), a, b)
    return Thief(-q, q, 0.0)


@pytest.mark.parametrize(("law", "told"), [(uphill, "gains"), (leaky, "oil"), (free, "power")])
def test_a_component_that_breaks_a_law_is_found(law, told, power_balance):
    with pytest.raises(AssertionError, match=told):
        power_balance(Component(law, symbol="orifice"))
