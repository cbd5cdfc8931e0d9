"""Pumps, motors, rods, shafts and lines as components: by hand, and the same on floats, arrays, symbols."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.components.drives import DRIVE_COUPLING, drive_coupling
from vvdp.components.lines import (
    COLUMN,
    LAYERED_COLUMN,
    LINE,
    LineState,
    column,
    column_stored,
    layered_column,
    line,
    line_walls,
)
from vvdp.components.machines import CHAMBER_PUMP, MOTOR, PUMP, chamber_pump, motor, motor_inertia, pump
from vvdp.components.rods import (
    CYLINDER,
    END_STOP,
    LOAD_FORCE,
    PLUNGER,
    ROD_FRICTION,
    SPRING,
    WEIGHT,
    cylinder,
    cylinder_walls,
    end_stop,
    load_force,
    piston_mass,
    plunger,
    plunger_walls,
    rod_friction,
    spring,
    weight,
    weight_mass,
)
from vvdp.components.shafts import (
    LOAD_TORQUE,
    ROTOR,
    SHAFT_FRICTION,
    TORSION_SPRING,
    load_torque,
    rotor,
    rotor_inertia,
    shaft_friction,
    torsion_spring,
)
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.cylinder import Cylinder, Plunger
from vvdp.hydraulics.friction import RodFriction, ShaftFriction
from vvdp.hydraulics.line import Line
from vvdp.hydraulics.motor import Motor
from vvdp.hydraulics.ports import Medium, RodState, ShaftSpeed, ShaftState
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.rod import EndStop, Spring, Weight
from vvdp.hydraulics.shaft import Rotor, TorsionSpring
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.unsteady_friction import LayeredState
from vvdp.network.component import Role
from vvdp.network.trial import check_law

ALL = [
    PUMP, MOTOR, DRIVE_COUPLING, CYLINDER, PLUNGER, END_STOP, ROD_FRICTION, SPRING, WEIGHT, LOAD_FORCE,
    SHAFT_FRICTION, ROTOR, TORSION_SPRING, LOAD_TORQUE, COLUMN, LINE, LAYERED_COLUMN,
]  # fmt: skip
TANK = FluidState(101325.0, 1.0, 1e9, 0.0)
HIGH = FluidState(101325.0 + 1e7, 0.99, 1.2e9, 9.95e6)
ROD = RodState(0.1, 0.05)
REV = 2.0 * np.pi


def test_ports_and_inputs():
    assert dict(PUMP.ports) == {"inlet": Role.PORT, "outlet": Role.PORT, "shaft": Role.SHAFT}
    assert dict(MOTOR.ports) == {"a": Role.PORT, "b": Role.PORT, "shaft": Role.SHAFT_SPEED}
    assert dict(CYLINDER.ports) == {"a": Role.PORT, "b": Role.PORT, "rod": Role.ROD}
    assert [a.name for a in LOAD_FORCE.inputs] == ["force"]
    assert [a.name for a in LOAD_TORQUE.inputs] == ["torque"]
    assert LINE.is_passage and LINE.state is LineState
    assert list(PUMP.losses) == ["leakage", "friction"]
    assert list(MOTOR.losses) == ["leakage", "friction", "compression"]


def test_pump_by_hand():
    values = Pump(
        displacement=22.8e-6 / REV,
        leakage_conductance=2e-12,
        ripple_amplitude=0.0,
        ripple_count=9.0,
        friction_torque=1.5,
    )
    got = pump(TANK, HIGH, ShaftState(0.0, REV * 30.0), values)
    # 22.8 cc * 30/s = 6.84e-4; leakage 2e-12 * 1e7 = 2e-5 at the outlet, over 0.99 in tank volumes
    leak = 2e-5 / 0.99
    assert got.outlet == pytest.approx(6.84e-4 - leak, rel=1e-13)
    assert got.inlet == -got.outlet
    assert got.leakage_flow == pytest.approx(leak, rel=1e-13)
    assert got.shaft == pytest.approx(-(22.8e-6 / REV * 9.95e6 + 1.5), rel=1e-13)
    assert got.losses == pytest.approx((leak * 9.95e6, 1.5 * REV * 30.0), rel=1e-13)


def test_a_pump_with_chambers_is_another_component_of_the_same_ports(oil):
    ideal = Pump(displacement=22.8e-6 / REV, leakage_conductance=2e-12, friction_torque=1.5)
    real = replace(ideal, precompression=0.0, dead_volume=3e-6 / REV)
    assert PUMP.suited(ideal) is PUMP and PUMP.suited(real) is CHAMBER_PUMP
    assert CHAMBER_PUMP.ports == PUMP.ports and list(CHAMBER_PUMP.losses) == [*PUMP.losses, "compression"]
    check_law(CHAMBER_PUMP, (real,), oil)
    low, high = fluid_state(1e5, oil), fluid_state(1e7, oil)
    for speed in (-100.0, 100.0):
        got = chamber_pump(low, high, ShaftState(0.0, speed), real)
        assert got.losses.compression > 0.0
        # the shaft's power goes into the oil and into heat
        gained = got.inlet * low.enthalpy + got.outlet * high.enthalpy
        assert -got.shaft * speed == pytest.approx(gained + sum(got.losses), rel=1e-12)
    as_ideal = chamber_pump(low, high, ShaftState(0.3, 100.0), ideal)
    plain = pump(low, high, ShaftState(0.3, 100.0), ideal)
    assert as_ideal[:3] == pytest.approx(plain[:3], rel=1e-14)
    assert as_ideal.losses == (*plain.losses, 0.0)


def test_a_pump_counts_what_it_displaces_at_its_inlet():
    values = Pump(
        displacement=1e-6, leakage_conductance=0.0, ripple_amplitude=0.0, ripple_count=9.0, friction_torque=0.0
    )
    boosted = FluidState(5e5, 0.95, 1e9, 4e5)
    assert pump(boosted, HIGH, ShaftState(0.0, 100.0), values).outlet == pytest.approx(1e-4 / 0.95, rel=1e-14)


def motor_values() -> Motor:
    return Motor(
        displacement=50e-6 / REV, leakage_conductance=2e-12, shaft_damping=0.0, coulomb_torque=2.0, coulomb_speed=1e-6,
        inertia=0.02,
    )  # fmt: skip


def test_motor_by_hand():
    speed, leak = REV * 20.0, 2e-5 / 0.99
    driven = motor(HIGH, TANK, ShaftSpeed(speed), motor_values())
    assert driven.b == pytest.approx(1e-3 / 0.99 + leak, rel=1e-13)  # counted where it comes from
    assert driven.a == -driven.b
    assert driven.shaft == pytest.approx(50e-6 / REV * 1e7 - 2.0, rel=1e-13)
    assert driven.losses.friction == pytest.approx(2.0 * speed, rel=1e-13)
    pumping = motor(HIGH, TANK, ShaftSpeed(-speed), motor_values())
    assert pumping.a == pytest.approx(1e-3 - leak, rel=1e-13)
    assert pumping.shaft == pytest.approx(50e-6 / REV * 1e7 + 2.0, rel=1e-13)
    assert motor_inertia(motor_values()) == 0.02


def test_cylinders_by_hand(oil):
    values = Cylinder(area_a=20e-4, area_b=10e-4, stroke=0.3, moving_mass=100.0, leakage_conductance=1e-12)
    got = cylinder(HIGH, TANK, ROD, oil, values)
    assert got.rod == pytest.approx(2e4, rel=1e-13)
    assert got.b == pytest.approx(1e-5 / 0.99, rel=1e-13)
    assert got.loss == pytest.approx(1e-5 / 0.99 * 9.95e6, rel=1e-13)
    assert cylinder_walls(ROD, values).b == pytest.approx((2e-4, -5e-5), rel=1e-13)
    assert piston_mass(values) == 100.0
    single = Plunger(area_a=20e-4, moving_mass=5.0)
    assert plunger(HIGH, ROD, oil, single).rod == pytest.approx(2e4, rel=1e-13)
    assert plunger_walls(ROD, single).a == pytest.approx((2e-4, 1e-4), rel=1e-13)


def test_rods_by_hand():
    stop = EndStop(lower_end=0.0, upper_end=0.099, stop_stiffness=2e7, stop_damping=2.0)
    assert end_stop(ROD, stop).rod == pytest.approx(-2e4 * 1.1, rel=1e-10)
    friction = RodFriction(
        viscous_friction=100.0,
        coulomb_friction=0.0,
        breakaway_friction=0.0,
        stribeck_velocity=1.0,
        coulomb_velocity=1.0,
    )
    assert rod_friction(ROD, friction) == pytest.approx((-5.0, 0.25), rel=1e-13)
    assert spring(ROD, Spring(stiffness=1e3, preload=20.0, rest_position=0.0)).rod == pytest.approx(-120.0, rel=1e-13)
    heavy = Weight(mass=10.0, slope=0.5 * np.pi)
    assert weight(ROD, heavy).rod == pytest.approx(-98.0665, rel=1e-13)
    assert weight_mass(heavy) == 10.0
    assert load_force(ROD, -1000.0) == (-1000.0, -50.0)


def test_shafts_by_hand():
    brake = ShaftFriction(shaft_damping=0.1, coulomb_torque=0.0, coulomb_speed=1.0)
    assert shaft_friction(ShaftSpeed(20.0), brake) == pytest.approx((-2.0, 40.0), rel=1e-14)
    body = Rotor(shaft_damping=0.1, coulomb_torque=0.0, coulomb_speed=1.0, inertia=0.5)
    assert rotor(ShaftSpeed(20.0), body) == shaft_friction(ShaftSpeed(20.0), brake)
    assert rotor_inertia(body) == 0.5
    twisted = TorsionSpring(torsional_stiffness=10.0, preload_torque=0.0, rest_angle=0.0)
    assert torsion_spring(ShaftState(0.2, 0.0), twisted).shaft == pytest.approx(-2.0, rel=1e-14)
    assert load_torque(ShaftSpeed(20.0), 3.0) == (3.0, 60.0)
    assert drive_coupling(ShaftSpeed(150.0), ShaftSpeed(140.0), SpoolDrive(coupling=0.01)) == pytest.approx(
        (-0.1, 0.1, 1.0), rel=1e-14
    )


def test_lines_by_hand():
    values, medium = Line(length=10.0, diameter=0.02), Medium(876.0, 0.04)
    got = column(HIGH, TANK, LineState(1e-4), medium, values)
    assert got.flow == pytest.approx(1e-4 / np.sqrt(0.995), rel=1e-14)
    assert got.rates.flow > 0.0 and got.loss > 0.0
    assert line(HIGH, TANK, LineState(1e-4), medium, values) == got
    half = 0.5 * np.pi * 1e-3
    assert line_walls(values).a == line_walls(values).b == pytest.approx((half, 0.0), rel=1e-14)
    assert column_stored(LineState(1e-4), medium, values).volume == 0.0
    settled = layered_column(HIGH, TANK, LayeredState(*[1e-4] * 6), medium, values)
    assert (settled.flow, settled.loss) == pytest.approx((got.flow, got.loss), rel=1e-13)
    assert settled.rates.flow == pytest.approx(got.rates.flow, rel=1e-13)
