"""Laws that every component of the library keeps, whoever writes it: found by scanning, met at random values.

A component whose values cannot be made from the examples of their kinds has a row in `VALUES`.
"""

import importlib
import itertools
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import vvdp.components
from vvdp.base.kinds import Kind
from vvdp.base.params import Params, field_kinds, field_types
from vvdp.base.signal import Signal
from vvdp.base.units import parse
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.ports import Medium
from vvdp.network.component import Argument, Component, Role, check_component

COUNT = 40
STEP = 1e-6  # of time, over which a store is differenced
EXCHANGED = {"to_spool"}  # parts of losses that are work done on a spool or taken from it

SEAT = {"seat_diameter": 0.01, "largest_lift": 2e-3}
VALUES: dict[str, list[dict[str, float]]] = {
    "Orifice": [{"transition_pressure": 2e4}],
    "CheckPoppet": [
        {"cracking_pressure": 5e4, "rated_drop": 2.5e5, "reverse_opening": 0.0, "opening_time": 0.0},
        {"cracking_pressure": 0.0, "rated_drop": 1e7, "reverse_opening": 0.1, "opening_time": 2e-3},
    ],
    "CheckValve": [{"closing_time": 0.0}],
    "PilotCheckValve": [{"pilot_ratio": 3.0}, {"pilot_ratio": 0.0}],
    "ReliefValve": [
        {"cracking_pressure": 8e6, "override_pressure": 1e6, "opening_time": 2e-3, "reseat_drop": 0.0},
        {"cracking_pressure": 8e6, "override_pressure": 1e6, "opening_time": 0.0, "reseat_drop": 1e6},
        {"cracking_pressure": 8e6, "override_pressure": 0.0, "opening_time": 0.0, "reseat_drop": 0.0},
    ],
    "LoadReliefValve": [{"override_pressure": 1e6, "opening_time": 0.0, "closing_time": 0.0}],
    "ShockValve": [
        {"override_pressure": 1e6, "opening_time": 0.0, "closing_time": 0.0},
        {"override_pressure": 1e6, "opening_time": 2e-3, "closing_time": 5e-3, "largest_opening": 1.5},
    ],
    "ReducingValve": [
        {"closing_pressure": 1e7, "override_pressure": 8e6, "opening_time": 0.0},
        {"closing_pressure": 1e7, "override_pressure": 8e6, "opening_time": 5e-3},
    ],
    "FlowControlValve": [{"minimum_drop": 8e5, "maximum_drop": 5e6, "flow_rise": 0.04}],
    "DigitalPump": [
        {"pistons": 12.0, "ripple_amplitude": 0.0, "valve_conductance": 1e-6},
        {"pistons": 2.0, "ripple_amplitude": 0.0, "dead_volume": 0.0, "precompression": 1.0},
    ],
    "VariableMachine": [
        {},
        {"laminar_slip": 3e-9, "turbulent_slip": 2e-5, "viscous_drag": 2e5, "kinetic_drag": 0.5, "setting_drag": 0.3},
    ],
    "MeasuredMachine": [
        {
            "speeds": (50.0, 150.0),
            "pressures": (5e6, 1e7, 2e7),
            "settings": (0.5, 1.0),
            "volumetric_efficiencies": (0.8, 0.9, 0.75, 0.88, 0.7, 0.85, 0.9, 0.95, 0.88, 0.94, 0.85, 0.92),
            "mechanical_efficiencies": (0.7, 0.85, 0.8, 0.9, 0.85, 0.92, 0.65, 0.8, 0.75, 0.88, 0.82, 0.9),
        }
    ],
    "GovernedMover": [{"reset_time": 0.0, "speed_band": 20.0}, {"reset_time": 0.5, "speed_band": 20.0}],
    "DieselEngine": [{"speeds": (0.0, 100.0, 220.0), "full_torques": (0.0, 400.0, 300.0)}],
    "ProportionalSpool": [
        {"natural_frequency": 60.0, "response_time": 0.0, "hysteresis": 0.0},
        {"natural_frequency": 0.0, "response_time": 0.02, "hysteresis": 0.04, "flow_yield": 1e-9},
    ],
    "LappedValve": [{"overlap_pa": 0.05, "overlap_pb": 0.05, "overlap_at": -0.1, "overlap_bt": 0.1}],
    "PoppetValve": [
        {"preload": 500.0, "poppet_friction": 5.0, "opening_time": 2e-3, "cone_angle": 0.7, **SEAT},
        {"preload": 5.0, "poppet_friction": 0.0, "opening_time": 0.0, "closing_time": 0.0, "cone_angle": 1.5, **SEAT},
    ],
    "ProportionalValve": [{"transition_pressure": 2e4}],
    "DirectionalValve": [{"overlap": 0.05}, {"overlap": 0.0}],
    "Characteristic": [{"dead_band": 0.05, "rangeability": 1.0}, {"dead_band": 0.2, "rangeability": 30.0}],
    "SwitchingValve": [{"stroke": 1e-2, "lap": 1e-3}, {"stroke": 1e-2, "lap": -5e-3}],
    "TwoWayValve": [{"normally_open": 0.0}, {"normally_open": 1.0}],
    "EndStop": [{"lower_end": -5e-3, "upper_end": 1e-2}],
    "GerotorDrive": [{"lower_end": -5e-3, "upper_end": 1e-2}],
    "GerotorCalibration": [{"commands": (-1.0, -0.1, 0.1, 1.0), "flows": (-3e-5, 0.0, 0.0, 3e-5)}],
    "OnOffValve": [{"dead_travel": 0.25}],
    "UnitValve": [{"weight": 2.0, "modulus": 4.0}],
    "Reservoir": [
        {"base_area": 0.1, "tank_height": 0.4, "tank_volume": 0.01, "suction_height": 0.0, "sealed": 0.0},
        {"base_area": 0.1, "tank_height": 0.4, "tank_volume": 0.01, "suction_height": 0.0, "sealed": 1.0},
    ],
    "GasAccumulator": [
        {"gas_volume": 1e-3, "precharge_pressure": 5e6, "heat_time": 5.0, "real_gas": 1.0, "oil_volume": 1e-5},
        {"gas_volume": 1e-3, "precharge_pressure": 5e6, "heat_time": 5.0, "real_gas": 0.0, "oil_volume": 1e-5},
    ],
    "PistonCharge": [{"gas_volume": 1e-3, "precharge_pressure": 5e6, "real_gas": 1.0, "piston_area": 1e-3}],
    "Arm": [{"base_arm": 0.3, "eye_arm": 0.4, "retracted_length": 0.45}],
    "Cushion": [{"port_area": 1e-4, "throttle_area": 2e-6, "cushion_begin": 0.03, "cushion_end": 0.01}],
    "Telescope": [{"areas": (5e-3, 3e-3, 2e-3), "strokes": (5e-3, 4e-3, 1e-2)}],
    "StickFriction": [{"dry_friction": 100.0, "stick_stiffness": 1e4, "stick_damping": 10.0}],
    "FlowSource": [{"counted_at_outlet": 0.0}, {"counted_at_outlet": 1.0}],
}
OIL = Oil(
    density=876.0,
    thermal_expansion=7e-4,
    viscosity_40=44.2e-6,
    viscosity_100=6.8e-6,
    liquid_bulk_modulus=1.4e9,
    air_fraction=0.01,
    polytropic_exponent=1.4,
    reference_pressure=101325.0,
)
MEDIUM = Medium(density=870.0, viscosity=0.035)


@dataclass(frozen=True)
class Meeting:
    """What a component meets at an instant: `values` by name of argument, its ports, inputs, time, and its own."""

    values: Mapping[str, Any]
    state: Any
    params: tuple[Params, ...]
    held: Any = None


def library() -> list[Component]:
    """Every component of the library."""
    found: dict[str, Component] = {}
    for info in pkgutil.walk_packages(vvdp.components.__path__, "vvdp.components."):
        for value in vars(importlib.import_module(info.name)).values():
            if isinstance(value, Component):
                found[value.name] = value
    return [found[name] for name in sorted(found)]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test with an argument `component` holds for each of the library."""
    if "component" in metafunc.fixturenames:
        metafunc.parametrize("component", library(), ids=lambda c: c.name)


def settings(cls: type[Params]) -> Iterator[Params]:
    """Values of a parameter class: its and its bases' rows of `VALUES`, for the rest the examples of their kinds."""
    rows = [VALUES.get(base.__name__, [{}]) for base in reversed(cls.__mro__)]
    for chosen in itertools.product(*rows):
        given = {name: value for row in chosen for name, value in row.items()}
        kinds, types = field_kinds(cls), field_types(cls)
        yield cls(**{name: given.get(name, example(types[name], kinds[name])) for name in kinds})


def example(hint: Any, kind: Kind | None) -> Any:
    """A value of a field."""
    if kind is None:
        assert isinstance(hint, type) and issubclass(hint, Params), f"give {hint!r} a value here"
        return next(settings(hint))
    value = parse(kind.example, kind)
    return Signal(base=value) if hint is Signal else value


def random_value(kind: Kind, rng: np.random.Generator) -> float:
    """Within twice the example of a kind, and either side of zero where the kind allows it."""
    size = abs(parse(kind.example, kind))
    low = -size if kind.low < 0.0 else 0.1 * size
    return float(rng.uniform(max(low, kind.low), min(2.0 * size, kind.high)))


def random_record(cls: Any, rng: np.random.Generator) -> Any:
    """A random value of a NamedTuple of kinds, at any depth."""
    kinds, types = field_kinds(cls), field_types(cls)
    return cls(*(random_value(k, rng) if (k := kinds[n]) else random_record(types[n], rng) for n in cls._fields))


def meetings(component: Component, seed: int = 20261121) -> Iterator[list[Meeting]]:
    """For each setting of a component, `COUNT` random meetings."""
    rng = np.random.default_rng(seed)
    for params in itertools.product(*(tuple(settings(cls)) for cls in component.params)):
        bare = Meeting({}, None, params)
        held = call(component, component.held, bare) if component.held else None
        yield [
            settled(
                component,
                Meeting(
                    {a.name: random_argument(a, rng) for a in component.arguments if a.role is not Role.PARAMS},
                    random_record(component.state, rng) if component.state else None,
                    params,
                    held,
                ),
            )
            for _ in range(COUNT)
        ]


def settled(component: Component, met: Meeting) -> Meeting:
    """The same in the modes that hold there."""
    told = [a.name for a in component.arguments if a.role is Role.MODE]
    for _ in range(4):
        result = call(component, component.law, met) if told else None
        found = {name: float(np.floor(getattr(result, name))) for name in told}
        if all(met.values[name] == mode for name, mode in found.items()):
            return met
        met = Meeting({**met.values, **found}, met.state, met.params, met.held)
    raise AssertionError(f"the modes of {component.name} do not come to rest")


def random_argument(argument: Argument, rng: np.random.Generator) -> Any:
    """What a component may meet under a name."""
    if argument.role is Role.PORT:
        return fluid_state(float(rng.uniform(2e4, 2e7)), OIL)
    if argument.role in (Role.SHAFT, Role.SHAFT_SPEED, Role.ROD):
        return random_record(argument.type, rng)
    if argument.role is Role.TIME:
        return float(rng.uniform(0.0, 1.0))
    if argument.role is Role.MODE:
        return 0.0
    if argument.role is Role.SURPLUS:
        return float(rng.uniform(-1e-3, 1e-3))
    return random_value(argument.kind, rng) if argument.kind else None


def call(component: Component, function: Callable[..., Any], met: Meeting) -> Any:
    """One of a component's functions at what it meets."""
    return function(*(met_argument(a, met) for a in component.arguments_of(function)))


def met_argument(argument: Argument, met: Meeting) -> Any:
    """What one argument of a component's function is at a meeting."""
    own = {Role.STATE: met.state, Role.HELD: met.held, Role.MEDIUM: MEDIUM, Role.OIL: OIL}
    if argument.role is Role.PARAMS:
        return next(p for p in met.params if isinstance(p, argument.type))
    return own[argument.role] if argument.role in own else met.values[argument.name]


def given(component: Component, result: Any) -> dict[str, Any]:
    """What a component gives into the node at each of its ports."""
    if component.is_passage:
        first, second = component.ends
        result_of = {first: -result.flow, second: result.flow}
        return {port: result_of.get(port, getattr(result, port, 0.0)) for port in component.ports}
    return {port: getattr(result, port, 0.0) for port in component.ports}


def lost(result: Any) -> dict[str, Any]:
    """The parts of what a component loses."""
    if hasattr(result, "losses"):
        return dict(result.losses._asdict())
    return {"": result.loss} if hasattr(result, "loss") else {}


def moved(value: Any, rate: Any, dt: float) -> Any:
    """A record that has changed at a rate."""
    pairs = zip(value, rate, strict=True)
    return type(value)(*(moved(v, r, dt) if hasattr(v, "_fields") else v + dt * r for v, r in pairs))


def later(component: Component, met: Meeting, rates: Any, dt: float) -> Meeting:
    """The meeting a little later: state, angles and positions have gone on, the pressures and speeds have not."""
    values = dict(met.values)
    for name, role in component.ports.items():
        if role is Role.SHAFT:
            values[name] = values[name]._replace(angle=values[name].angle + dt * values[name].speed)
        elif role is Role.ROD:
            values[name] = values[name]._replace(position=values[name].position + dt * values[name].velocity)
    state = moved(met.state, rates, dt) if met.state is not None else None
    return Meeting(values, state, met.params, met.held)


def stored_rates(component: Component, met: Meeting, result: Any) -> tuple[float, float]:
    """How fast a component's own energy [W] and oil [m^3/s] grow."""
    if component.stored is None:
        return 0.0, 0.0
    rates = getattr(result, "rates", None)
    after = call(component, component.stored, later(component, met, rates, 0.5 * STEP))
    before = call(component, component.stored, later(component, met, rates, -0.5 * STEP))
    return (after.energy - before.energy) / STEP, (after.volume - before.volume) / STEP


def check_books(component: Component, met: Meeting) -> None:
    """Power and oil that a component takes and gives are the same, and it loses none below zero."""
    result = call(component, component.law, met)
    energy, volume = stored_rates(component, met, result)
    flows, powers = [volume], [energy]
    for port, amount in given(component, result).items():
        node = met.values[port]
        if isinstance(node, FluidState):
            flows.append(amount)
            powers.append(amount * node.enthalpy)
        else:
            powers.append(amount * (node.speed if hasattr(node, "speed") else node.velocity))
    walls = call(component, component.walls, met)._asdict() if component.walls else {}
    for port, wall in walls.items():
        powers.append(-(met.values[port].pressure - OIL.reference_pressure) * wall.rate)
    parts = lost(result)
    powers += [*parts.values(), -getattr(result, "supplied", 0.0)]
    accuracy = 1e-12 if component.stored is None else 1e-6
    assert abs(sum(powers)) <= accuracy * sum(map(abs, powers)), f"{component.name}: power at {met}"
    assert abs(sum(flows)) <= accuracy * sum(map(abs, flows)), f"{component.name}: oil at {met}"
    for name, loss in parts.items():
        assert name in EXCHANGED or loss >= -1e-12 * sum(map(abs, powers)), f"{component.name}: {name} gains at {met}"


@pytest.fixture(scope="session")
def power_balance() -> Callable[[Component], int]:
    """Holds the laws of power and of oil against a component at random; returns how often."""

    def balance(component: Component) -> int:
        check_component(component)
        count = 0
        for met in itertools.chain.from_iterable(meetings(component)):
            check_books(component, met)
            count += 1
        return count

    return balance


@pytest.fixture(scope="session", name="meetings")
def meetings_fixture() -> Callable[[Component], Iterator[list[Meeting]]]:
    return meetings


@pytest.fixture(scope="session", name="call")
def call_fixture() -> Callable[..., Any]:
    return call


@pytest.fixture(scope="session", name="met_argument")
def met_argument_fixture() -> Callable[..., Any]:
    return met_argument


@pytest.fixture(scope="session")
def oil() -> Oil:
    return OIL
