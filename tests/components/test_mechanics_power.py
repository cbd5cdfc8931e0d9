"""Power in is power out, for random inputs, of every component between machines, rods, shafts and lines.

sum q h + sum T omega + sum F v - sum (P - P0) dV/dt + losses - supplied + d(stored)/dt = 0, and no oil is lost.
"""

import dataclasses
from typing import Any

import numpy as np
import pytest

from vvdp.components import drives, lines, machines, rods, shafts
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Cylinder, Plunger
from vvdp.hydraulics.friction import RodFriction, ShaftFriction
from vvdp.hydraulics.line import Line
from vvdp.hydraulics.motor import Motor
from vvdp.hydraulics.ports import Medium, RodState, ShaftSpeed, ShaftState
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.rod import EndStop, Spring, Weight
from vvdp.hydraulics.shaft import Rotor, TorsionSpring
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.network.component import Component, Role

VALUES: dict[type, Any] = {
    type(v): v
    for v in (
        Pump(
            displacement=3e-6, leakage_conductance=2e-12, ripple_amplitude=0.05, ripple_count=9.0, friction_torque=1.5,
        ),
        Motor(
            displacement=5e-6, leakage_conductance=2e-12, shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0,
            inertia=0.02,
        ),
        Cylinder(area_a=20e-4, area_b=10e-4, stroke=0.3, moving_mass=100.0, leakage_conductance=1e-12),
        Plunger(area_a=20e-4, moving_mass=100.0),
        EndStop(lower_end=0.0, upper_end=0.2, stop_stiffness=2e7, stop_damping=2.0),
        RodFriction(
            viscous_friction=100.0, coulomb_friction=50.0, breakaway_friction=80.0, stribeck_velocity=0.1,
            coulomb_velocity=0.01,
        ),
        Spring(stiffness=1e4, preload=200.0, rest_position=0.05),
        Weight(mass=50.0, slope=0.7),
        ShaftFriction(shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0),
        Rotor(shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0, inertia=0.02),
        TorsionSpring(torsional_stiffness=30.0, preload_torque=2.0, rest_angle=0.3),
        SpoolDrive(coupling=0.01),
        Line(length=3.0, diameter=0.012),
    )
}  # fmt: skip
COMPONENTS = {
    name: value
    for module in (drives, lines, machines, rods, shafts)
    for name, value in vars(module).items()
    if isinstance(value, Component)
}
INPUTS = {"force": 5e3, "torque": 50.0}


def drawn(component: Component, rng: np.random.Generator, oil: Oil) -> dict[str, Any]:
    """A random value for every argument of its law."""
    by_role = {
        Role.PORT: lambda a: fluid_state(float(np.exp(rng.uniform(*np.log([2e4, 3e7])))), oil),
        Role.SHAFT: lambda a: ShaftState(float(rng.uniform(-9.0, 9.0)), float(rng.uniform(-300.0, 300.0))),
        Role.SHAFT_SPEED: lambda a: ShaftSpeed(float(rng.uniform(-300.0, 300.0))),
        Role.ROD: lambda a: RodState(float(rng.uniform(-0.01, 0.21)), float(rng.uniform(-1.0, 1.0))),
        Role.MEDIUM: lambda a: Medium(870.0, 0.03),
        Role.OIL: lambda a: oil,
        Role.PARAMS: lambda a: VALUES[a.type],
        Role.STATE: lambda a: a.type(*rng.uniform(-1e-3, 1e-3, len(a.type._fields)).tolist()),
        Role.INPUT: lambda a: float(rng.uniform(-INPUTS[a.name], INPUTS[a.name])),
    }
    return {a.name: by_role[a.role](a) for a in component.arguments}


def called(component: Component, function, given: dict[str, Any]):
    return function(**{a.name: given[a.name] for a in component.arguments_of(function)})


def stored_rate(component: Component, given: dict[str, Any], got) -> float:
    """How fast what it stores grows, by central differences along its motion: exact where it is a parabola."""
    rates = {}
    for argument in component.arguments_of(component.stored):
        value = given[argument.name]
        if argument.role is Role.STATE:
            rates[argument.name] = got.rates
        elif argument.role in (Role.ROD, Role.SHAFT):
            rates[argument.name] = type(value)(value[1], 0.0)

    def energy(by):
        moved = {
            k: type(v)(*(x + by * r for x, r in zip(v, rates[k], strict=True))) for k, v in given.items() if k in rates
        }
        return called(component, component.stored, given | moved).energy

    step = 1e-6
    return (energy(step) - energy(-step)) / (2.0 * step)


@pytest.mark.parametrize("name", COMPONENTS)
def test_power_and_oil_close(oil, name):
    component, rng = COMPONENTS[name], np.random.default_rng(3)
    exchanged = {n for n, k in component.losses.items() if k and k.low < 0.0}
    for _ in range(200):
        given = drawn(component, rng, oil)
        got = component.law(**given)
        flows = {p: getattr(got, p) for p in component.hydraulic_ports if p in got._fields}
        if component.is_passage:
            flows = dict(zip(component.hydraulic_ports, (-got.flow, got.flow), strict=True))
        parts = [q * given[p].enthalpy for p, q in flows.items()]
        for port, role in component.ports.items():
            if role is not Role.PORT:
                parts.append(getattr(got, port) * given[port][-1])
        if component.walls:
            walls = called(component, component.walls, given)
            parts += [-(given[p].pressure - oil.reference_pressure) * getattr(walls, p).rate for p in walls._fields]
        losses = {"": got.loss} if "loss" in got._fields else {}
        if "losses" in got._fields:
            losses = got.losses._asdict()
        parts += [*losses.values(), -getattr(got, "supplied", 0.0)]
        if component.stored:
            parts.append(stored_rate(component, given, got))
        scale = sum(map(abs, parts)) + 1e-9
        assert abs(sum(parts)) < (1e-7 if component.stored else 1e-12) * scale
        assert abs(sum(flows.values())) <= 1e-15 * sum(map(abs, flows.values()))
        assert all(value >= -1e-9 * scale for part, value in losses.items() if part not in exchanged)


def flat(value: Any) -> list[Any]:
    return [x for part in value for x in flat(part)] if hasattr(value, "_fields") else [value]


def rebuilt(value: Any, take) -> Any:
    if hasattr(value, "_fields"):
        return type(value)(*(rebuilt(v, take) for v in value))
    return take() if isinstance(value, float) else value


def varied(given: dict[str, Any]) -> list[float]:
    return [x for v in given.values() if not dataclasses.is_dataclass(v) for x in flat(v)]


@pytest.mark.parametrize("name", COMPONENTS)
def test_arrays_and_symbols_give_what_floats_give(oil, name):
    casadi = pytest.importorskip("casadi")
    component, rng = COMPONENTS[name], np.random.default_rng(4)
    cases = [drawn(component, rng, oil) for _ in range(20)]
    plain = np.array([flat(component.law(**given)) for given in cases])
    scale = np.abs(plain).max(axis=0).clip(1e-300)
    columns = np.array([varied(given) for given in cases])

    def together(numbers):
        taken = iter(numbers)
        return {k: v if dataclasses.is_dataclass(v) else rebuilt(v, lambda: next(taken)) for k, v in cases[0].items()}

    arrays = np.array([np.broadcast_to(x, 20) for x in flat(component.law(**together(columns.T)))]).T
    assert np.max(np.abs(arrays - plain) / scale) < 1e-12
    symbols = casadi.SX.sym("x", columns.shape[1])
    result = flat(component.law(**together([symbols[i] for i in range(columns.shape[1])])))
    function = casadi.Function("f", [symbols], [casadi.vertcat(*result)])
    traced = np.array([np.ravel(function(row)) for row in columns])
    assert np.max(np.abs(traced - plain) / scale) < 1e-12


@pytest.mark.slow
def test_compiled_code_gives_what_floats_give(oil):
    from collections import namedtuple

    from numba import njit

    from vvdp.simulation.link import _make_compilable, reachable

    found: dict = {}
    functions = [(c, f) for c in COMPONENTS.values() for f in (c.law, c.walls, c.stored) if f]
    for _, function in functions:
        reachable(function, found)
    _make_compilable(found)

    def record(value):
        if not dataclasses.is_dataclass(value):
            return value
        names = [f.name for f in dataclasses.fields(value)]
        return namedtuple(type(value).__name__, names)(*(getattr(value, n) for n in names))

    rng = np.random.default_rng(5)
    for component, function in functions:
        compiled = njit(error_model="numpy")(function)
        for case in [drawn(component, rng, oil) for _ in range(20)]:
            given = [case[a.name] for a in component.arguments_of(function)]
            plain = np.array(flat(function(*given)))
            values = np.array(flat(compiled(*map(record, given))))
            assert np.all(np.abs(values - plain) <= 1e-12 * np.abs(plain).max()), function.__name__
