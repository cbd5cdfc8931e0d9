"""Whole right-hand sides do not care for the units: scale metre, kilogram and second, and everything scales along.

A formula with a number in it that secretly has a unit would be found. Two are known, each with its bound:

- the viscosity chart (`fluid.oil.kinematic_viscosity`) is defined in mm^2/s and kelvin;
- `valve.branch.STILL_FLOW`, 1e-11 m^3/s, keeps the centre section's power finite at zero flow. Its share in the drop is
  0.045 (STILL_FLOW/Q)^2: 5e-10 at 1e-7 m^3/s (6 cm^3 a minute), and falling.
"""

import dataclasses
from collections import namedtuple
from functools import cache

import numpy as np
import pint
import pytest

from vvdp.base.conservation import Nothing
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal
from vvdp.simulation.values import flat, leaves, names, rebuild
from vvdp.systems.system import load_system, shipped_systems
from vvdp.valve.branch import BranchLaw, branch_law
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import friction_coefficient, spool_inertia

SCALES = {"[length]": 1.7, "[mass]": 0.43, "[time]": 2.3}
REGISTRY = pint.UnitRegistry()
EXPONENT = 1.91  # of the flow in the centre section of every shipped system


@cache
def factor(unit: str) -> float:
    """By how much a number changes when metre, kilogram and second are replaced by other units."""
    if unit == "1":
        return 1.0
    dimensions = REGISTRY.parse_units(unit.replace("^", "**")).dimensionality
    return float(np.prod([SCALES.get(d, 1.0) ** e for d, e in dimensions.items()]))


FLOW, PRESSURE = "m^3/s", "Pa"


def own_factor(value, name: str) -> float | None:
    """For quantities whose unit depends on an exponent."""
    if isinstance(value, RotaryValve) and name == "centre_coefficient":  # Q^m = k D^n dp
        n = value.centre_diameter_exponent
        return factor(FLOW) ** value.centre_flow_exponent / factor("m") ** n / factor(PRESSURE)
    if isinstance(value, BranchLaw) and name == "centre_section":  # dp = R Q^m
        return factor(PRESSURE) / factor(FLOW) ** value.flow_exponent
    return None


@cache
def record_class(cls: type, fields: tuple[str, ...]) -> type:
    return namedtuple(cls.__name__, fields)


def scaled_signal(signal: Signal, by: float) -> Signal:
    s = factor("s")
    return dataclasses.replace(
        signal,
        base=signal.base * by,
        start=tuple(t * s for t in signal.start),
        duration=tuple(t * s for t in signal.duration),
        change=tuple(c * by for c in signal.change),
        amplitude=tuple(a * by for a in signal.amplitude),
        frequency=tuple(f / s for f in signal.frequency),
    )


def scaled(value):
    """`value` in the other units; parameter classes become plain records, since their ranges are in SI."""
    kinds, members = field_kinds(type(value)), []
    for name in names(value):
        member, kind = getattr(value, name), kinds.get(name)
        by = own_factor(value, name) or (factor(kind.unit) if kind else None)
        if isinstance(member, Signal):
            members.append(scaled_signal(member, by))
        elif isinstance(member, Nothing):
            members.append(member)
        elif names(member):
            members.append(scaled(member))
        else:
            assert by, f"{type(value).__name__}.{name} has no unit"
            members.append(member * by)
    cls = record_class(type(value), names(value)) if isinstance(value, Params) else type(value)
    return cls(*members)


RANGES = {
    "Pa": (1e5, 1.5e7),
    "rad": (-30.0, 30.0),
    "rad/s": (-50.0, 300.0),
    "m": (0.0, 0.5),
    "m/s": (-0.5, 0.5),
    "m^3/s": (-1e-3, 1e-3),
    "1": (0.2, 1.0),
}
SETTINGS = {
    "as shipped": [],
    "dynamic relief": ["relief_valve.override_pressure=10 bar", "relief_valve.opening_time=2 ms"],
    "everything": [
        "relief_valve.override_pressure=10 bar",
        "spool_drive.coupling=0.1 N*m*s",
        "operation.spool_motor_speed=3000 rpm",
        "pump.leakage_conductance=2e-12 m^3/(s*Pa)",
        "pump.ripple_amplitude=0.03",
        "pump.friction_torque=2 N*m",
        "check_valve.reverse_opening=0.2",
        'operation.pump_speed={step=["1200 rpm", "1800 rpm"], at="0.5 s"}',
        'operation.duty_ratio={sine="0.5", amplitude="0.3", frequency="5 Hz"}',
    ],
}


def variants():
    """Every shipped system, and those with a rotary valve with other settings."""
    for name in shipped_systems():
        for word, settings in SETTINGS.items() if name.startswith("prototype") else [("as shipped", [])]:
            yield pytest.param(name, settings, id=f"{name}, {word}")


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "settings"), [*variants()])
def test_right_hand_side_is_independent_of_units(name, settings):
    """Rates scale as state over time. Rounding, and the still flow: flows above 1e-6 m^3/s, so 1e-11 of the rates.

    Scaled by 1.7 and 2.3 the still flow is another one by a factor of 2.
    """
    system = load_system(name, settings)
    circuit, case = system.model.circuit, system.case
    rng = np.random.default_rng(11)
    params, command = scaled(case.params), scaled(case.command)
    paths = [(path, kind) for path, _, kind in leaves(case.state)]
    of_rates = flat(scaled(rebuild(case.state, iter([1.0] * len(paths))))) / factor("s")
    plain, other = [], []
    for _ in range(100):
        numbers = [0.0 if path.startswith("books.") else float(rng.uniform(*RANGES[k.unit])) for path, k in paths]
        t, state = float(rng.uniform(0.0, 1.0)), rebuild(case.state, iter(numbers))
        plain.append(flat(circuit(t, state, case.command, case.params)[0]) * of_rates)
        other.append(flat(circuit(t * factor("s"), scaled(state), command, params)[0]))
    largest = np.max(np.abs(plain), axis=0).clip(1e-300)
    assert np.max(np.abs(np.array(plain) - np.array(other)) / largest) < 1e-11


def test_a_number_with_a_hidden_unit_would_be_seen():
    """A pressure of 1 bar in place of the parameter, for instance."""
    assert factor("Pa") == pytest.approx(0.43 / 1.7 / 2.3**2)
    assert abs(factor("Pa") - 1.0) > 0.1


@pytest.mark.parametrize("name", ["prototype", "prototype-constant-load"])
def test_what_is_held_between_samples_is_independent_of_units(name):
    """Law of the branches, leakage, friction, inertia; viscosity and density given, for the chart has units."""
    case = load_system(name).case
    valve, rho, mu = case.params.valve, 870.0, 0.035
    assert valve.centre_flow_exponent == EXPONENT
    other, rho2, mu2 = scaled(valve), rho * factor("kg/m^3"), mu * factor("Pa*s")
    assert flat(branch_law(rho2, other)) == pytest.approx(flat(scaled(branch_law(rho, valve))), rel=1e-12)
    expected = leakage_conductance(mu, valve) * factor("m^3/(s*Pa)")
    assert leakage_conductance(mu2, other) == pytest.approx(expected, rel=1e-12)
    assert friction_coefficient(mu2, other) == pytest.approx(
        friction_coefficient(mu, valve) * factor("N*m*s"), rel=1e-12
    )
    assert spool_inertia(other) == pytest.approx(spool_inertia(valve) * factor("kg*m^2"), rel=1e-12)
