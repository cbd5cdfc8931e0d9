import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.cylinder import (
    Cylinder,
    CylinderState,
    cylinder_friction_force,
    cylinder_friction_power,
    cylinder_rate,
    cylinder_stored,
    stop_force,
)
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.volume import Vessel

REF = 101325.0
STIFF = FluidState(1e5, 1.0, 1e9, 0.0)


def chamber(volume, compliance):
    return Vessel(
        oil_volume=volume, hose_compliance=compliance, gas_volume=0.0, precharge_pressure=0.0, gas_exponent=1.4
    )


def cylinder(**changed):
    values = {
        "area_a": 20e-4,
        "area_b": 10e-4,
        "stroke": 0.3,
        "moving_mass": 100.0,
        "viscous_friction": 2000.0,
        "coulomb_friction": 50.0,
        "coulomb_velocity": 3e-3,
        "stop_stiffness": 2e7,
        "stop_damping": 2.0,
        "chamber_a": chamber(4e-4, 3e-10),
        "chamber_b": chamber(5e-4, 3e-10),
    }
    return Cylinder(**(values | changed))


def test_forces_by_hand():
    state = CylinderState(0.1, 0.004, REF + 10e5, REF + 5e5)
    rates = cylinder_rate(state, 0.0, 0.0, -300.0, STIFF, STIFF, cylinder(), REF)
    # 2000 - 500 - 2000*0.004 - 50 * 4/5 - 300 = 1152 N on 100 kg
    assert rates.velocity == pytest.approx(11.52, rel=1e-13)
    assert rates.position == 0.004


def test_pressures_by_hand():
    rigid = cylinder(chamber_a=chamber(4e-4, 0.0), chamber_b=chamber(5e-4, 0.0))
    rates = cylinder_rate(CylinderState(0.1, 0.05, 1e6, 1e6), 3e-4, -2e-5, 0.0, STIFF, STIFF, rigid, REF)
    # a: (3e-4 - 1e-4) * 1e9/(4e-4 + 2e-4); b: (-2e-5 + 5e-5) * 1e9/(5e-4 + 10e-4 * 0.2)
    assert rates.pressure_a == pytest.approx(2e-4 * 1e9 / 6e-4, rel=1e-13)
    assert rates.pressure_b == pytest.approx(3e-5 * 1e9 / 7e-4, rel=1e-13)


def test_chambers_are_still_where_flow_meets_motion():
    rates = cylinder_rate(CylinderState(0.1, 0.05, 1e6, 2e6), 1e-4, -5e-5, 0.0, STIFF, STIFF, cylinder(), REF)
    assert rates.pressure_a == rates.pressure_b == 0.0


def test_stops_by_hand():
    rig = cylinder()
    near = stop_force(-1e-3, -0.1, rig)  # 2e4 N * (1 + 2 * 0.1); loss 2e4 * 0.2 * 0.1
    assert near.force == pytest.approx(2.4e4, rel=1e-12)
    assert near.loss == pytest.approx(400.0, rel=1e-12)
    far = stop_force(0.301, -0.1, rig)  # coming out: 2e4 * (1 - 0.2), against the position
    assert far.force == pytest.approx(-1.6e4, rel=1e-12)
    assert far.loss == pytest.approx(400.0, rel=1e-12)
    torn = stop_force(0.301, -2.0, rig)  # faster than the stop springs back: it lets go, its spring energy is lost
    assert torn.force == 0.0
    assert torn.loss == pytest.approx(4e4, rel=1e-12)
    assert stop_force(0.15, -9.0, rig) == (0.0, 0.0)


@given(x=st.floats(-0.1, 0.4), v=st.floats(-20.0, 20.0))
def test_stops_and_friction_only_take(x, v):
    rig = cylinder()
    stop = stop_force(x, v, rig)
    assert stop.loss >= 0.0
    assert stop.force * (0.15 - x) >= 0.0  # never pulls the piston in
    assert cylinder_friction_power(v, rig) >= 0.0
    assert cylinder_friction_force(-v, rig) == -cylinder_friction_force(v, rig)


@given(x=st.floats(-0.001, 0.301), v=st.floats(-1.0, 1.0))
def test_a_symmetric_cylinder_mirrors(x, v):
    same = cylinder(area_b=20e-4, chamber_b=chamber(4e-4, 3e-10))
    here = cylinder_rate(CylinderState(x, v, 3e6, 1e6), 1e-4, -2e-4, 70.0, STIFF, STIFF, same, REF)
    there = cylinder_rate(CylinderState(0.3 - x, -v, 1e6, 3e6), -2e-4, 1e-4, -70.0, STIFF, STIFF, same, REF)
    scale = 1.0 + 2e7 * 1e-3 * 3.0 / 100.0
    assert here.velocity == pytest.approx(-there.velocity, abs=1e-9 * scale)
    assert here.pressure_a == pytest.approx(there.pressure_b, rel=1e-12)
    assert here.pressure_b == pytest.approx(there.pressure_a, rel=1e-12)


def test_books_close_through_an_impact_on_the_end_stop(oil):
    """Supply to A, B to tank through orifices, out against the far stop at 0.3 m, then both ports swapped."""
    rig = cylinder()
    valve = Orifice(discharge_coefficient=0.62, transition_pressure=2e4)
    load = -1000.0
    supply, tank = fluid_state(60e5, oil), fluid_state(REF, oil)

    def rates(_, y, to_a):
        s = CylinderState(*y[:4])
        a, b = fluid_state(s.pressure_a, oil), fluid_state(s.pressure_b, oil)
        source_a, source_b = (supply, tank) if to_a else (tank, supply)
        level_a, level_b = (60e5, REF) if to_a else (REF, 60e5)
        in_a = passage(orifice_flow(6e-6, level_a - s.pressure_a, 876.0, valve), source_a, a)
        in_b = passage(orifice_flow(6e-6, level_b - s.pressure_b, 876.0, valve), source_b, b)
        return [
            *cylinder_rate(s, in_a.flow, in_b.flow, load, a, b, rig, REF),
            in_a.flow * source_a.enthalpy + in_b.flow * source_b.enthalpy,
            in_a.loss + in_b.loss,
            cylinder_friction_power(s.velocity, rig),
            stop_force(s.position, s.velocity, rig).loss,
            load * s.velocity,
            in_a.flow + in_b.flow,
        ]

    y = np.array([0.25, 0.0, 5e5, 5e5, *[0.0] * 6])
    atol = [1e-13, 1e-12, 1e-5, 1e-5, *[1e-10] * 5, 1e-16]
    begin = cylinder_stored(CylinderState(*y[:4]), oil, rig)
    for to_a in (True, False):
        run = solve_ivp(rates, (0.0, 0.4), y, method="DOP853", rtol=1e-11, atol=atol, args=(to_a,), max_step=2e-3)
        assert run.status == 0
        if to_a:
            assert run.y[0].max() > rig.stroke + 1e-4
        y = run.y[:, -1]
    assert y[0] < 0.29  # has left the stop
    end = cylinder_stored(CylinderState(*y[:4]), oil, rig)
    supplied, throttled, friction, impact, work, mass = y[4:]
    assert min(throttled, friction, impact) > 1e-3 * supplied
    residual = supplied + work - throttled - friction - impact - (end.energy - begin.energy)
    assert abs(residual) / supplied < 1e-9
    assert abs(mass - (end.volume - begin.volume)) / begin.volume < 1e-9


def test_stored_energy_by_hand(oil):
    rig = cylinder(area_b=1e-9, chamber_a=chamber(4e-4, 0.0), chamber_b=chamber(5e-4, 0.0))
    for x in (-1e-3, 0.301):
        held = cylinder_stored(CylinderState(x, 0.2, REF, REF), oil, rig)
        # 0.5 * 100 * 0.04 = 2 J of motion, 0.5 * 2e7 * 1e-6 = 10 J in the stop, none in the oil
        assert held.energy == pytest.approx(12.0, rel=1e-12)
        assert held.volume == pytest.approx(9e-4 + 20e-4 * x + 1e-9 * (0.3 - x), rel=1e-13)


def test_an_undamped_stop_gives_back_what_it_took():
    free = cylinder(viscous_friction=0.0, coulomb_friction=0.0, stop_damping=0.0, area_a=1e-9, area_b=1e-9)

    def rates(_, y):
        return cylinder_rate(CylinderState(y[0], y[1], REF, REF), 0.0, 0.0, 0.0, STIFF, STIFF, free, REF)[:2]

    run = solve_ivp(rates, (0.0, 0.05), [0.29, 1.0], rtol=1e-11, atol=1e-14, max_step=1e-4)
    assert run.y[1, -1] == pytest.approx(-1.0, rel=1e-8)
    assert run.y[0].max() - 0.3 == pytest.approx(np.sqrt(100.0 / 2e7), rel=1e-3)  # v sqrt(m/k)


def test_contradictions_are_refused():
    for name in ("area_a", "area_b", "stroke", "moving_mass", "coulomb_velocity", "stop_stiffness"):
        with pytest.raises(ParameterError, match=name):
            cylinder(**{name: 0.0})
    with pytest.raises(ParameterError, match="coulomb_friction"):
        cylinder(coulomb_friction=-1.0)
