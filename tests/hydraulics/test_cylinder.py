import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.cylinder import Cylinder, Plunger, cylinder_force, plunger_force, wall_a, wall_b
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.friction import RodFriction, rod_friction_force
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.rod import EndStop, stop_energy, stop_force
from vvdp.hydraulics.volume import Vessel, pressure_rate, vessel_contents

REF = 101325.0
RIG = Cylinder(area_a=20e-4, area_b=10e-4, stroke=0.3, moving_mass=100.0, leakage_conductance=1e-13)
STOP = EndStop(lower_end=0.0, upper_end=0.3, stop_stiffness=2e7, stop_damping=2.0)
FRICTION = RodFriction(
    viscous_friction=2000.0,
    coulomb_friction=50.0,
    breakaway_friction=50.0,
    stribeck_velocity=1.0,
    coulomb_velocity=3e-3,
)


def test_forces_by_hand():
    # 10 bar * 20 cm^2 - 5 bar * 10 cm^2 = 2000 - 500 N above the reference
    assert cylinder_force(REF + 10e5, REF + 5e5, REF, RIG) == pytest.approx(1500.0, rel=1e-13)
    assert plunger_force(REF + 10e5, REF, RIG) == pytest.approx(2000.0, rel=1e-13)
    assert cylinder_force(REF, REF, REF, RIG) == 0.0


def test_walls_by_hand():
    assert wall_a(0.1, 0.05, RIG) == pytest.approx((2e-4, 1e-4), rel=1e-13)
    assert wall_b(0.1, 0.05, RIG) == pytest.approx((2e-4, -5e-5), rel=1e-13)
    assert wall_a(0.1, 0.05, RIG).volume + wall_b(0.1, 0.05, RIG).volume == pytest.approx(20e-4 * 0.1 + 10e-4 * 0.2)


def test_books_close_through_an_impact_on_the_end_stop(oil):
    """Supply to A, B to tank through orifices, out against the far stop at 0.3 m, then both ports swapped."""
    valve = Orifice(discharge_coefficient=0.62, transition_pressure=2e4)
    plain = {"hose_compliance": 3e-10, "gas_volume": 0.0, "precharge_pressure": 0.0, "gas_exponent": 1.4}
    vessel_a, vessel_b = Vessel(oil_volume=4e-4, **plain), Vessel(oil_volume=5e-4, **plain)
    load = -1000.0
    supply, tank = fluid_state(60e5, oil), fluid_state(REF, oil)

    def rates(_, y, to_a):
        x, v, P_a, P_b = y[:4]
        a, b = fluid_state(P_a, oil), fluid_state(P_b, oil)
        source_a, source_b = (supply, tank) if to_a else (tank, supply)
        in_a = passage(orifice_flow(6e-6, source_a.pressure - P_a, 876.0, valve), source_a, a)
        in_b = passage(orifice_flow(6e-6, source_b.pressure - P_b, 876.0, valve), source_b, b)
        leak = passage(RIG.leakage_conductance * (P_a - P_b), a, b)
        in_chambers = wall_a(x, v, RIG), wall_b(x, v, RIG)
        friction, stop = rod_friction_force(v, FRICTION), stop_force(x, v, STOP)
        force = cylinder_force(P_a, P_b, REF, RIG) - friction + stop.force + load
        return [
            v,
            force / RIG.moving_mass,
            pressure_rate(in_a.flow - leak.flow, in_chambers[0].rate, a, vessel_a, REF, in_chambers[0].volume),
            pressure_rate(in_b.flow + leak.flow, in_chambers[1].rate, b, vessel_b, REF, in_chambers[1].volume),
            in_a.flow * source_a.enthalpy + in_b.flow * source_b.enthalpy,
            in_a.loss + in_b.loss + leak.loss,
            friction * v,
            stop.loss,
            load * v,
            in_a.flow + in_b.flow,
        ]

    def store(y):
        x, v, P_a, P_b = y[:4]
        a = vessel_contents(fluid_state(P_a, oil), oil, vessel_a, wall_a(x, v, RIG).volume)
        b = vessel_contents(fluid_state(P_b, oil), oil, vessel_b, wall_b(x, v, RIG).volume)
        return a.energy + b.energy + 0.5 * RIG.moving_mass * v**2 + stop_energy(x, STOP), a.volume + b.volume

    y = np.array([0.25, 0.0, 5e5, 5e5, *[0.0] * 6])
    atol = [1e-13, 1e-12, 1e-5, 1e-5, *[1e-10] * 5, 1e-16]
    energy0, mass0 = store(y)
    for to_a in (True, False):
        run = solve_ivp(rates, (0.0, 0.4), y, method="DOP853", rtol=1e-11, atol=atol, args=(to_a,), max_step=2e-3)
        assert run.status == 0
        if to_a:
            assert run.y[0].max() > STOP.upper_end + 1e-4
        y = run.y[:, -1]
    assert y[0] < 0.29  # has left the stop
    energy1, mass1 = store(y)
    supplied, throttled, friction, impact, work, mass = y[4:]
    assert min(throttled, friction, impact) > 1e-3 * supplied
    assert abs(supplied + work - throttled - friction - impact - (energy1 - energy0)) / supplied < 1e-9
    assert abs(mass - (mass1 - mass0)) / mass0 < 1e-9


def test_contradictions_are_refused():
    values = {"area_a": 20e-4, "area_b": 10e-4, "stroke": 0.3, "moving_mass": 100.0, "leakage_conductance": 0.0}
    for name in ("area_a", "area_b", "stroke"):
        with pytest.raises(ParameterError, match=name):
            Cylinder(**(values | {name: 0.0}))
    with pytest.raises(ParameterError, match=r"Plunger\.area_a"):
        Plunger(area_a=0.0, moving_mass=1.0)
