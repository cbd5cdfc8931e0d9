import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.friction import RodFriction, ShaftFriction, rod_friction_force, shaft_friction_torque, smooth_sign
from vvdp.hydraulics.rod import (
    EndStop,
    Spring,
    Weight,
    spring_energy,
    spring_force,
    stop_energy,
    stop_force,
    weight_energy,
    weight_force,
)
from vvdp.hydraulics.shaft import TorsionSpring, torsion_energy, torsion_torque

STOP = EndStop(lower_end=0.0, upper_end=0.3, stop_stiffness=2e7, stop_damping=2.0)
FRICTION = RodFriction(
    viscous_friction=2000.0,
    coulomb_friction=50.0,
    breakaway_friction=80.0,
    stribeck_velocity=0.01,
    coulomb_velocity=3e-3,
)


def test_stops_by_hand():
    near = stop_force(-1e-3, -0.1, STOP)  # 2e4 N * (1 + 2 * 0.1); loss 2e4 * 0.2 * 0.1
    assert near.force == pytest.approx(2.4e4, rel=1e-12)
    assert near.loss == pytest.approx(400.0, rel=1e-12)
    far = stop_force(0.301, -0.1, STOP)  # coming out: 2e4 * (1 - 0.2), against the position
    assert far.force == pytest.approx(-1.6e4, rel=1e-12)
    assert far.loss == pytest.approx(400.0, rel=1e-12)
    torn = stop_force(0.301, -2.0, STOP)  # faster than the stop springs back: it lets go, its spring energy is lost
    assert torn.force == 0.0
    assert torn.loss == pytest.approx(4e4, rel=1e-12)
    assert stop_force(0.15, -9.0, STOP) == (0.0, 0.0)
    for x in (-1e-3, 0.301):
        assert stop_energy(x, STOP) == pytest.approx(10.0, rel=1e-12)  # 0.5 * 2e7 * 1e-6


def test_stops_stand_where_they_are_put():
    moved = EndStop(lower_end=-0.2, upper_end=0.1, stop_stiffness=2e7, stop_damping=2.0)
    for x, v in ((-0.001, 0.3), (0.302, -0.1), (0.1, 0.2)):
        here, there = stop_force(x, v, STOP), stop_force(x - 0.2, v, moved)
        assert there == pytest.approx(here, rel=1e-9)


@given(x=st.floats(-0.1, 0.4), v=st.floats(-20.0, 20.0))
def test_stops_and_friction_only_take(x, v):
    stop = stop_force(x, v, STOP)
    assert stop.loss >= 0.0
    assert stop.force * (0.15 - x) >= 0.0  # never pulls the rod in
    assert rod_friction_force(v, FRICTION) * v >= 0.0
    assert rod_friction_force(-v, FRICTION) == -rod_friction_force(v, FRICTION)


def test_an_undamped_stop_gives_back_what_it_took():
    free = EndStop(lower_end=0.0, upper_end=0.3, stop_stiffness=2e7, stop_damping=0.0)

    def rates(_, y):
        return [y[1], stop_force(y[0], y[1], free).force / 100.0]

    run = solve_ivp(rates, (0.0, 0.05), [0.29, 1.0], rtol=1e-11, atol=1e-14, max_step=1e-4)
    assert run.y[1, -1] == pytest.approx(-1.0, rel=1e-8)
    assert run.y[0].max() - 0.3 == pytest.approx(np.sqrt(100.0 / 2e7), rel=1e-3)  # v sqrt(m/k)


def test_friction_by_hand():
    # at 4 mm/s, v_c = 3 mm/s: sign 4/5; exp(-0.16) of the 30 N more: 2000*0.004 + (50 + 30 e^-0.16) * 0.8
    assert rod_friction_force(0.004, FRICTION) == pytest.approx(8.0 + 0.8 * (50.0 + 30.0 * np.exp(-0.16)), rel=1e-13)
    assert rod_friction_force(0.0, FRICTION) == 0.0
    # far above the Stribeck velocity only 50 N and the viscous part are left
    assert rod_friction_force(1.0, FRICTION) == pytest.approx(2050.0, rel=1e-5)
    assert smooth_sign(3.0, 4.0) == 0.6


def test_friction_without_a_fall_is_that_of_a_cylinder():
    level = RodFriction(
        viscous_friction=2000.0, coulomb_friction=50.0, breakaway_friction=50.0, stribeck_velocity=1.0,
        coulomb_velocity=3e-3,
    )  # fmt: skip
    assert rod_friction_force(0.004, level) == pytest.approx(2000.0 * 0.004 + 50.0 * 4.0 / 5.0, rel=1e-14)


def test_breakaway_lies_above_the_friction_of_motion():
    sticky = RodFriction(
        viscous_friction=0.0, coulomb_friction=50.0, breakaway_friction=80.0, stribeck_velocity=0.01,
        coulomb_velocity=1e-4,
    )  # fmt: skip
    forces = rod_friction_force(np.linspace(0.0, 0.1, 10001), sticky)
    assert 75.0 < forces.max() < 80.0
    assert forces[-1] == pytest.approx(50.0, rel=1e-5)


def test_shaft_friction_by_hand():
    friction = ShaftFriction(shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0)
    assert shaft_friction_torque(4.0, friction) == pytest.approx(0.04 + 1.6, rel=1e-14)
    assert shaft_friction_torque(-4.0, friction) == -shaft_friction_torque(4.0, friction)


def test_springs_by_hand():
    spring = Spring(stiffness=1e4, preload=50.0, rest_position=0.1)
    assert spring_force(0.12, spring) == pytest.approx(-250.0, rel=1e-12)  # -50 - 1e4 * 0.02
    assert spring_energy(0.12, spring) == pytest.approx(3.0, rel=1e-12)  # 50 * 0.02 + 0.5 * 1e4 * 4e-4
    twisted = TorsionSpring(torsional_stiffness=10.0, preload_torque=2.0, rest_angle=0.5)
    assert torsion_torque(1.0, twisted) == pytest.approx(-7.0, rel=1e-14)
    assert torsion_energy(1.0, twisted) == pytest.approx(1.0 + 1.25, rel=1e-14)


def test_weight_by_hand():
    up = Weight(mass=100.0, slope=0.5 * np.pi)
    assert weight_force(up) == pytest.approx(-980.665, rel=1e-14)
    assert weight_energy(0.5, up) == pytest.approx(490.3325, rel=1e-14)
    assert weight_force(Weight(mass=100.0, slope=np.pi / 6.0)) == pytest.approx(-490.3325, rel=1e-12)
    assert weight_force(Weight(mass=100.0, slope=0.0)) == 0.0


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("lower_end", lambda: EndStop(lower_end=0.3, upper_end=0.3, stop_stiffness=1e7, stop_damping=0.0)),
        ("stop_stiffness", lambda: EndStop(lower_end=0.0, upper_end=0.3, stop_stiffness=0.0, stop_damping=0.0)),
        ("slope", lambda: Weight(mass=1.0, slope=2.0)),
        ("coulomb_torque", lambda: ShaftFriction(shaft_damping=0.0, coulomb_torque=-1.0, coulomb_speed=1.0)),
        ("coulomb_speed", lambda: ShaftFriction(shaft_damping=0.0, coulomb_torque=1.0, coulomb_speed=0.0)),
    ],
)
def test_contradictions_are_refused(name, make):
    with pytest.raises(ParameterError, match=name):
        make()


@pytest.mark.parametrize(
    "values",
    [
        {"coulomb_friction": -1.0},
        {"breakaway_friction": 40.0},
        {"stribeck_velocity": 0.0},
        {"coulomb_velocity": 0.0},
        {"coulomb_velocity": 0.02},
    ],
)
def test_friction_that_contradicts_itself_is_refused(values):
    sound = {
        "viscous_friction": 0.0, "coulomb_friction": 50.0, "breakaway_friction": 80.0, "stribeck_velocity": 0.01,
        "coulomb_velocity": 1e-3,
    }  # fmt: skip
    with pytest.raises(ParameterError, match=next(iter(values))):
        RodFriction(**(sound | values))
