import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.line import (
    Line,
    inertance,
    line_energy,
    line_flow_rate,
    line_friction_drop,
    line_friction_power,
)
from vvdp.hydraulics.volume import closed_volume_rate, closed_volume_stored

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


@given(Re=st.floats(-1e6, 1e6))
def test_friction_only_takes(Re):
    q = flow_at(Re)
    assert line_friction_power(q, RHO, MU, LINE) >= 0.0
    assert line_friction_drop(-q, RHO, MU, LINE) == -line_friction_drop(q, RHO, MU, LINE)


def test_a_line_speeds_up_with_the_enthalpy_difference():
    up, down = FluidState(1e5, 0.99, 1e9, 3e5), FluidState(1e5, 1.0, 1e9, 1e5)
    rate = line_flow_rate(0.0, up, down, RHO, MU, LINE)
    assert rate == pytest.approx(2e5 / inertance(RHO, LINE), rel=1e-14)
    steady = 2e5 * np.pi * 1e-8 / (128.0 * MU)  # laminar if the drop were 200 times smaller
    assert line_flow_rate(steady / 200.0, up, FluidState(1e5, 1.0, 1e9, 2.99e5), RHO, MU, LINE) == pytest.approx(
        0.0, abs=1e-12
    )


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
            closed_volume_rate(-y[2], 0.0, V1, a),
            closed_volume_rate(y[2], 0.0, V2, b),
            line_flow_rate(y[2], a, b, RHO, thin, LINE),
            line_friction_power(y[2], RHO, thin, LINE),
        ]

    run = solve_ivp(
        rates, (0.0, 0.05), [200e5, 5e5, 0.0, 0.0], method="DOP853", rtol=1e-11, atol=[1e-4, 1e-4, 1e-14, 1e-11]
    )

    def store(y):
        a, b = closed_volume_stored(y[0], V1, oil), closed_volume_stored(y[1], V2, oil)
        return a.energy + b.energy + line_energy(y[2], RHO, LINE), a.volume + b.volume

    (energy0, mass0), (energy1, mass1) = store(run.y[:, 0]), store(run.y[:, -1])
    assert run.y[2].min() < 0.0  # it has swung back
    assert run.y[3, -1] > 0.05 * energy0
    assert abs(energy0 - energy1 - run.y[3, -1]) / energy0 < 1e-9
    assert abs(mass1 - mass0) / mass0 < 1e-9


def test_a_line_without_length_is_refused():
    with pytest.raises(ParameterError, match="length"):
        Line(length=0.0, diameter=0.01)
