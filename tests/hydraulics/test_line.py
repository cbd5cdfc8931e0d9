import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.line import (
    Line,
    flow_scale,
    inertance,
    line_energy,
    line_flow_rate,
    line_friction_drop,
    line_friction_power,
    line_volume,
)
from vvdp.hydraulics.volume import closed_volume_contents, closed_volume_rate

LINE = Line(length=1.0, diameter=0.01)
RHO, MU = 876.0, 0.04


def flow_at(Re):
    return Re * np.pi * LINE.diameter * MU / (4.0 * RHO)


def test_laminar_by_hand():
    # 128 * 0.04 * 1/(pi * 1e-8) * 1e-5 = 1629.75 Pa, Re = 28
    assert line_friction_drop(1e-5, RHO, MU, LINE) == pytest.approx(5.12e3 / np.pi, rel=1e-13)
    assert inertance(RHO, LINE) == pytest.approx(876.0 / (np.pi * 2.5e-5), rel=1e-14)
    assert line_energy(2e-4, RHO, LINE) == pytest.approx(0.5 * 876.0 * 4e-8 / (np.pi * 2.5e-5), rel=1e-14)


def test_turbulent_is_blasius():
    # Re = 1e4: 0.3164/10 = 0.03164; dp = 0.03164 L/d rho v^2/2
    v = 1e4 * MU / (RHO * LINE.diameter)
    drop = 0.03164 * (LINE.length / LINE.diameter) * 0.5 * RHO * v**2
    assert line_friction_drop(flow_at(1e4), RHO, MU, LINE) == pytest.approx(drop, rel=1e-12)


def test_friction_grows_smoothly_through_the_transition():
    flows = flow_at(np.linspace(0.0, 8000.0, 8001))
    drops = line_friction_drop(flows, RHO, MU, LINE)
    slopes = np.diff(drops)
    assert np.all(slopes > 0.0)
    # a jump of the slope would show as a change of its own size within one of the 8000 intervals
    assert np.abs(np.diff(slopes)).max() < 0.01 * slopes.max()


@given(Re=st.floats(-1e6, 1e6), P_a=st.floats(1e3, 3e7), P_b=st.floats(1e3, 3e7))
def test_friction_only_takes(oil, Re, P_a, P_b):
    q, a, b = flow_at(Re), fluid_state(P_a, oil), fluid_state(P_b, oil)
    assert line_friction_power(q, a, b, RHO, MU, LINE) >= 0.0
    assert line_friction_drop(-q, RHO, MU, LINE) == -line_friction_drop(q, RHO, MU, LINE)


def test_friction_can_be_left_out():
    free = Line(length=1.0, diameter=0.01, wall_friction=0.0)
    assert line_friction_drop(flow_at(1e4), RHO, MU, free) == 0.0
    rough = Line(length=1.0, diameter=0.01, wall_friction=1.5)
    for Re in (100.0, 1e4):
        drop = line_friction_drop(flow_at(Re), RHO, MU, LINE)
        assert line_friction_drop(flow_at(Re), RHO, MU, rough) == pytest.approx(1.5 * drop, rel=1e-14)


def test_scale_and_rate_by_hand():
    up, down = FluidState(1e5, 0.98, 1e9, 3e5), FluidState(1e5, 1.0, 1e9, 1e5)
    assert flow_scale(up, down) == pytest.approx(np.sqrt(0.99), rel=1e-14)
    rate = line_flow_rate(0.0, up, down, RHO, MU, LINE)
    assert rate == pytest.approx(2e5 / np.sqrt(0.99) / inertance(RHO, LINE), rel=1e-14)
    # stiff oil, laminar: 1000 Pa of drop against 128 mu l/(pi d^4) z
    z = 1e3 * np.pi * 1e-8 / (128.0 * MU)
    up, down = FluidState(1e5, 1.0, 1e9, 3e5), FluidState(1e5, 1.0, 1e9, 2.99e5)
    assert line_flow_rate(z, up, down, RHO, MU, LINE) == pytest.approx(0.0, abs=1e-12)
    assert line_friction_power(z, up, down, RHO, MU, LINE) == pytest.approx(1e3 * z, rel=1e-13)


@pytest.mark.parametrize("level", [64e5, 250e5])
def test_a_small_swing_has_the_frequency_of_the_momentum(oil, level):
    """Two volumes and a line without friction: I q' = dP gives omega^2 = beta nu (1/V1 + 1/V2)/I."""
    V1, V2, free = 1e-3, 2e-3, Line(length=10.0, diameter=0.02, wall_friction=0.0)

    def rates(y):
        a, b = fluid_state(y[0], oil), fluid_state(y[1], oil)
        q = y[2] / flow_scale(a, b)
        z_rate = line_flow_rate(y[2], a, b, RHO, MU, free)
        return np.array([closed_volume_rate(-q, 0.0, V1, a), closed_volume_rate(q, 0.0, V2, b), z_rate])

    steps, middle = np.diag([1e3, 1e3, 1e-9]), np.array([level, level, 0.0])
    slopes = np.array([(rates(middle + d) - rates(middle - d)) / (2.0 * d.sum()) for d in steps]).T
    oil_there = fluid_state(level, oil)
    momentum = oil_there.bulk_modulus * oil_there.volume_ratio * (1.0 / V1 + 1.0 / V2) / inertance(RHO, free)
    assert np.abs(np.linalg.eigvals(slopes).imag).max() == pytest.approx(np.sqrt(momentum), rel=1e-6)


def test_inside_and_column_by_hand():
    assert line_volume(Line(length=10.0, diameter=0.02)) == pytest.approx(np.pi * 1e-3, rel=1e-14)


def test_friction_is_free_of_units():
    m, kg, s = 3.0, 5.0, 7.0
    Pa = kg / (m * s**2)
    scaled = Line(length=1.0 * m, diameter=0.01 * m)
    for Re in (100.0, 3000.0, 2e4):
        q = flow_at(Re)
        drop = line_friction_drop(q * m**3 / s, RHO * kg / m**3, MU * Pa * s, scaled)
        assert drop == pytest.approx(line_friction_drop(q, RHO, MU, LINE) * Pa, rel=1e-12)


def test_books_of_two_volumes_and_a_line_close(oil):
    """Oil swings between 200 and 5 bar through the turbulent range and back, until friction has taken some of it."""
    V1, V2, thin = 5e-4, 3e-4, 0.005

    def rates(_, y):
        a, b = fluid_state(y[0], oil), fluid_state(y[1], oil)
        return [
            closed_volume_rate(-y[2] / flow_scale(a, b), 0.0, V1, a),
            closed_volume_rate(y[2] / flow_scale(a, b), 0.0, V2, b),
            line_flow_rate(y[2], a, b, RHO, thin, LINE),
            line_friction_power(y[2], a, b, RHO, thin, LINE),
        ]

    run = solve_ivp(
        rates, (0.0, 0.05), [200e5, 5e5, 0.0, 0.0], method="DOP853", rtol=1e-11, atol=[1e-4, 1e-4, 1e-14, 1e-11]
    )

    def store(y):
        a = closed_volume_contents(fluid_state(y[0], oil), V1, oil)
        b = closed_volume_contents(fluid_state(y[1], oil), V2, oil)
        return a.energy + b.energy + line_energy(y[2], RHO, LINE), a.volume + b.volume

    (energy0, mass0), (energy1, mass1) = store(run.y[:, 0]), store(run.y[:, -1])
    assert run.y[2].min() < 0.0  # it has swung back
    assert run.y[3, -1] > 0.05 * energy0
    assert abs(energy0 - energy1 - run.y[3, -1]) / energy0 < 1e-9
    assert abs(mass1 - mass0) / mass0 < 1e-9


def test_a_line_without_length_is_refused():
    with pytest.raises(ParameterError, match="length"):
        Line(length=0.0, diameter=0.01)
