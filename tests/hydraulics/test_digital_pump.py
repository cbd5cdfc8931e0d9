"""Pump of enabled pistons: flow of single pistons, what its inlet valves lose and take, refused values."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.components.digital_pumps import digital_pump
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.digital_pump import (
    DigitalPump,
    actuation_power,
    breathing_torque,
    decision_period,
    stroke_share,
)
from vvdp.hydraulics.ports import ShaftState
from vvdp.hydraulics.pump import delivery
from vvdp.systems.system import load_system

OMEGA = 60.0 * np.pi
"""1800 rpm."""
PUMP = DigitalPump(
    displacement=2.4e-5 / (2.0 * np.pi),
    leakage_conductance=2e-12,
    friction_torque=0.0,
    pistons=12.0,
    valve_conductance=1e-6,
    valve_energy=0.2,
)
"""Twelve pistons of 2 cm^3 each."""
OIL = load_system("digital-pump-control").circuit.network.oil


def test_a_piston_gives_its_volume_in_half_a_revolution():
    """The share of one piston over its stroke: 2 cm^3, none before and after, pi/12 in the middle."""
    angles = np.linspace(0.0, np.pi, 20001)
    share = np.array([stroke_share(angle, 1.0, 0.0, PUMP) for angle in angles])
    assert np.trapezoid(share * PUMP.displacement, angles) == pytest.approx(2e-6, rel=1e-7)
    assert np.max(share) == pytest.approx(np.pi / 12.0, rel=1e-7)
    assert stroke_share(np.pi + 0.1, 1.0, 0.0, PUMP) == stroke_share(-0.1, 1.0, 0.0, PUMP) == 0.0


def test_six_pistons_in_their_stroke_give_the_mean_flow_within_their_ripple():
    """Sum of six sines 30 degrees apart: 1/tan 15 deg = 3.7321 where one begins, 1/sin 15 deg = 3.8637 in between;
    times pi/12 these are 0.9770 and 1.0115."""
    starts = -np.arange(6.0) * np.pi / 6.0
    sums = float(np.sum(np.cos(starts))), float(np.sum(np.sin(starts)))
    assert stroke_share(0.0, *sums, PUMP) == pytest.approx(0.97705, rel=1e-4)
    assert stroke_share(np.pi / 12.0, *sums, PUMP) == pytest.approx(1.01152, rel=1e-4)


def test_breathing_is_the_drop_over_the_inlet_valves_times_their_flow():
    """Integral of (q/K)^2 q over a stroke, q = V/2 omega sin: V^3 omega^2/(6 K^2) = 8e-18 35531/6e-12 = 0.047374 J.

    All twelve take in and half give back: 12 30 1.5 0.047374 = 25.58 W at 1800 rpm.
    """
    phases = np.linspace(0.0, np.pi, 20001)
    flow = 1e-6 * OMEGA * np.sin(phases)
    stroke = np.trapezoid((flow / 1e-6) ** 2 * flow, phases) / OMEGA
    assert stroke == pytest.approx(0.047374, rel=1e-4)
    assert breathing_torque(OMEGA, 0.5, PUMP) * OMEGA == pytest.approx(12 * 30 * 1.5 * stroke, rel=1e-6)
    assert breathing_torque(OMEGA, 0.0, PUMP) == pytest.approx(2.0 * breathing_torque(OMEGA, 1.0, PUMP), rel=1e-12)


def test_valves_are_paid_for_each_stroke_that_delivers():
    """360 pistons in a second, 0.2 J each: 72 W while all are enabled, none while all idle."""
    assert actuation_power(OMEGA, 1.0, PUMP) == pytest.approx(72.0, rel=1e-12)
    assert actuation_power(OMEGA, 0.0, PUMP) == 0.0
    assert decision_period(12.0, OMEGA) == pytest.approx(1.0 / 360.0, rel=1e-12)


def test_energy_of_the_pump_is_that_of_its_shaft_its_valves_and_its_oil():
    """What shaft and valves put in is what the oil gains and what is lost, at any share, with all of its losses."""
    pump = replace(PUMP, friction_torque=3.0, dead_volume=2e-6, precompression=0.2)
    inlet, outlet = fluid_state(1.2e5, OIL), fluid_state(150e5, OIL)
    found = digital_pump(inlet, outlet, ShaftState(0.7, OMEGA), 1.3, -2.1, 0.5, 1.0, pump)
    put_in = -found.shaft * OMEGA + found.supplied
    gained = found.outlet * outlet.enthalpy + found.inlet * inlet.enthalpy
    assert put_in == pytest.approx(gained + sum(found.losses), rel=1e-12)
    assert found.inlet == -found.outlet and min(found.losses) > 0.0


def test_idle_pistons_do_not_leak_and_dead_volume_follows_the_flow():
    inlet, outlet = fluid_state(1e5, OIL), fluid_state(100e5, OIL)
    pump = replace(PUMP, dead_volume=PUMP.displacement)
    idle = digital_pump(inlet, outlet, ShaftState(0.7, OMEGA), 0.0, 0.0, 0.0, 0.0, pump)
    assert idle.outlet == idle.leakage_flow == 0.0 and idle.losses.breathing > 0.0
    some = digital_pump(inlet, outlet, ShaftState(np.pi / 2.0, OMEGA), 1.0, 0.0, 0.5, 0.0, pump)
    full = delivery(0.0, inlet, outlet, pump).displacement * OMEGA
    assert some.outlet + some.leakage_flow == pytest.approx(np.pi / 12.0 * full, rel=1e-12)
    assert some.leakage_flow * outlet.volume_ratio == pytest.approx(0.5 * 2e-12 * 99e5, rel=1e-9)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"pistons": 7.0}, "pistons"),
        ({"pistons": 0.0}, "pistons"),
        ({"pistons": 102.0}, "pistons"),
        ({"ripple_amplitude": 0.1}, "ripple_amplitude"),
        ({"valve_conductance": 0.0}, "valve_conductance"),
    ],
)
def test_values_that_make_no_such_pump_are_refused(changed, told):
    with pytest.raises(ParameterError, match=f"DigitalPump.{told}"):
        replace(PUMP, **changed)
