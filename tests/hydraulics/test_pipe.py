import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import jv

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.line import Line, flow_scale, inertance, line_flow_rate, line_friction_drop
from vvdp.hydraulics.pipe import (
    LinePipe,
    TubeWall,
    end_piece,
    inner_piece,
    piece_rate,
    piece_stored,
    sound_speed,
    wall_compliance,
)
from vvdp.hydraulics.unsteady_friction import (
    LAYER_RATES,
    LAYER_WEIGHTS,
    LayeredState,
    layer_resistance,
    layered_energy,
    layered_power,
    layered_rate,
)
from vvdp.hydraulics.volume import Vessel, closed_volume_contents, closed_volume_rate, pressure_rate, vessel_contents

RHO, MU = 876.0, 0.04
HOSE = LinePipe(length=10.0, diameter=0.02, hose_compliance=0.0, wall_friction=0.0)
STIFF = FluidState(0.0, 1.0, 1.2e9, 0.0)


def slopes_of(rates, middle, steps):
    return np.array([(rates(middle + d) - rates(middle - d)) / (2.0 * d.sum()) for d in np.diag(steps)]).T


def first_mode(pipe, end_volume, oil, level=64e5, density=RHO):
    """Frequency [Hz] of the first swing between two equal volumes through a pipe in pieces, from the formulas."""
    n = int(pipe.pieces)

    def rates(y):
        P, z = y[: n + 2], y[n + 2 :]
        fluids = [fluid_state(p, oil) for p in P]
        columns = [end_piece(pipe), *[inner_piece(pipe)] * (n - 1), end_piece(pipe)]
        q, out = [0.0], []
        for i, line in enumerate(columns):
            q.append(z[i] / flow_scale(fluids[i], fluids[i + 1]))
            out.append(line_flow_rate(z[i], fluids[i], fluids[i + 1], density, MU, line))
        q.append(0.0)
        net = -np.diff(q)
        first = closed_volume_rate(net[0], 0.0, end_volume, fluids[0])
        last = closed_volume_rate(net[-1], 0.0, end_volume, fluids[-1])
        inside = [piece_rate(net[i], fluids[i], pipe, oil.reference_pressure) for i in range(1, n + 1)]
        return np.array([first, *inside, last, *out])

    middle = np.array([level] * (n + 2) + [0.0] * (n + 1))
    slopes = slopes_of(rates, middle, [1e3] * (n + 2) + [1e-9] * (n + 1))
    omega = np.sort(np.abs(np.linalg.eigvals(slopes).imag))
    return omega[omega > 1.0][0] / (2.0 * np.pi)


def exact_mode(pipe, end_volume, oil, level=64e5, density=RHO):
    """theta tan(theta) = C_line/(2 C_end), theta = omega l/(2 c): half a wave with a node in the middle."""
    here = fluid_state(level, oil)
    capacity = (1.0 / here.bulk_modulus + pipe.hose_compliance) * here.bulk_modulus
    ratio = pipe.length * 0.25 * np.pi * pipe.diameter**2 * capacity / end_volume
    theta = brentq(lambda x: x * np.tan(x) - 0.5 * ratio, 1e-9, 0.5 * np.pi - 1e-12)
    return theta * sound_speed(density, here, pipe.hose_compliance) / (np.pi * pipe.length)


def with_pieces(n, **changed):
    values = {"length": 10.0, "diameter": 0.02, "hose_compliance": 0.0, "wall_friction": 0.0, "pieces": float(n)}
    return LinePipe(**(values | changed))


TABLE = {1: 25.0, 2: 1.10, 3: 0.47, 4: 0.26, 5: 0.17, 10: 0.0413, 20: 0.0103}


@pytest.mark.parametrize("n", TABLE)
def test_first_mode_of_a_hose_in_pieces(oil, n):
    """10 m of 20 mm between two litres: what docs/models/components.md tells, in percent."""
    error = 100.0 * (first_mode(with_pieces(n), 1e-3, oil) / exact_mode(HOSE, 1e-3, oil) - 1.0)
    assert error == pytest.approx(TABLE[n], rel=0.03)


@pytest.mark.parametrize("level", [64e5, 250e5])
@pytest.mark.parametrize("compliance", [0.0, 3e-10])
def test_default_pieces_hold_the_first_mode_to_a_fifth_of_a_percent(oil, level, compliance):
    pipe = LinePipe(length=10.0, diameter=0.02, hose_compliance=compliance, wall_friction=0.0)
    assert pipe.pieces == 5.0
    # The hose has grown at pressure: the pieces hold more than at the reference pressure, by P/B = 0.75 % at most.
    assert first_mode(pipe, 1e-3, oil, level) == pytest.approx(
        exact_mode(pipe, 1e-3, oil, level), rel=6e-3 if compliance else 2e-3
    )


def test_pieces_add_up(oil):
    pipe = with_pieces(4, length=2.0)
    assert 2.0 * end_piece(pipe).length + 3.0 * inner_piece(pipe).length == pytest.approx(2.0, rel=1e-14)
    assert 4.0 * piece_stored(fluid_state(oil.reference_pressure, oil), oil, pipe).volume == pytest.approx(
        0.25 * np.pi * 4e-4 * 2.0, rel=1e-14
    )
    assert end_piece(pipe).wall_friction == inner_piece(pipe).wall_friction == 0.0


def test_a_piece_is_a_vessel_without_gas(oil):
    pipe = with_pieces(4, length=2.0, hose_compliance=3e-10)
    vessel = Vessel(
        oil_volume=0.25 * np.pi * 4e-4 * 0.5,
        hose_compliance=3e-10,
        gas_volume=0.0,
        precharge_pressure=0.0,
        gas_exponent=1.4,
    )
    for pressure in (5e4, 1e6, 2.5e7):
        fluid = fluid_state(pressure, oil)
        expected = pressure_rate(1e-4, 0.0, fluid, vessel, oil.reference_pressure)
        assert piece_rate(1e-4, fluid, pipe, oil.reference_pressure) == pytest.approx(expected, rel=1e-14)
        assert piece_stored(fluid, oil, pipe) == pytest.approx(vessel_contents(fluid, oil, vessel), rel=1e-12)


def test_tube_by_hand():
    # 20 mm, 2 mm of steel: 0.02/(2e11 * 0.002) = 5e-11 1/Pa
    wall = TubeWall(diameter=0.02, wall_thickness=0.002, youngs_modulus=2e11)
    assert wall_compliance(wall) == pytest.approx(5e-11, rel=1e-14)
    # 1/sqrt(876 (1/1.2e9 + 5e-11)) = 1136.8 m/s
    assert sound_speed(RHO, STIFF, 5e-11) == pytest.approx(1.0 / np.sqrt(876.0 * (1.0 / 1.2e9 + 5e-11)), rel=1e-14)


def test_layers_are_the_exact_friction_of_a_laminar_swing():
    """Against the Bessel functions of a round pipe: friction over the steady one at omega d^2/(4 nu) = W."""
    for W, within in ((1.0, 1e-3), (10.0, 1e-3), (100.0, 5e-3), (1e3, 6e-3), (1e4, 2e-2)):
        x = 1j**1.5 * np.sqrt(W)
        exact = 1j * W / 8.0 * (1.0 / (1.0 - 2.0 * jv(1, x) / (x * jv(0, x))) - 1.0)
        layers = 1.0 + 0.5j * W * sum(m / (1j * W + n) for m, n in zip(LAYER_WEIGHTS, LAYER_RATES, strict=True))
        assert abs(layers / exact - 1.0) < within


def test_layers_by_hand():
    line = Line(length=1.0, diameter=0.01)
    steady = line_friction_drop(1e-5, RHO, MU, line) / 1e-5
    assert layer_resistance(MU, line) == pytest.approx(0.5 * steady, rel=1e-14)
    moving = LayeredState(1e-5, *[0.0] * 5)
    rates = layered_rate(moving, STIFF, STIFF, RHO, MU, line)
    clinging = 0.5 * steady * sum(LAYER_WEIGHTS) * 1e-5
    assert rates.flow == pytest.approx(-(steady * 1e-5 + clinging) / inertance(RHO, line), rel=1e-12)
    assert rates.layer_1 == pytest.approx(28.7511 * 4.0 * MU / (RHO * 1e-4) * 1e-5, rel=1e-12)
    together = LayeredState(*[1e-5] * 6)
    assert layered_rate(together, STIFF, STIFF, RHO, MU, line)[1:] == (0.0,) * 5
    assert layered_power(together, STIFF, STIFF, RHO, MU, line) == pytest.approx(steady * 1e-10, rel=1e-12)
    # all oil at one speed profile: a third more than the column alone, that of a parabola's momentum
    assert layered_energy(together, RHO, line) == pytest.approx(
        0.5 * inertance(RHO, line) * 1e-10 * 4.0 / 3.0, rel=1e-3
    )


def test_books_of_a_line_with_layers_close(oil):
    V1, V2, line = 5e-4, 3e-4, Line(length=1.0, diameter=0.01)

    def rates(_, y):
        a, b, state = fluid_state(y[0], oil), fluid_state(y[1], oil), LayeredState(*y[2:8])
        q = state.flow / flow_scale(a, b)
        loss = layered_power(state, a, b, RHO, MU, line)
        assert loss >= 0.0
        return [
            closed_volume_rate(-q, 0.0, V1, a),
            closed_volume_rate(q, 0.0, V2, b),
            *layered_rate(state, a, b, RHO, MU, line),
            loss,
        ]

    y0 = [200e5, 5e5, *[0.0] * 7]
    run = solve_ivp(
        rates, (0.0, 0.03), y0, method="DOP853", rtol=1e-11, atol=[1e-4, 1e-4, *[1e-14] * 6, 1e-11]
    )  # fmt: skip

    def store(y):
        a = closed_volume_contents(fluid_state(y[0], oil), V1, oil)
        b = closed_volume_contents(fluid_state(y[1], oil), V2, oil)
        return a.energy + b.energy + layered_energy(LayeredState(*y[2:8]), RHO, line), a.volume + b.volume

    (energy0, mass0), (energy1, mass1) = store(run.y[:, 0]), store(run.y[:, -1])
    assert run.y[2].min() < 0.0  # it has swung back
    assert abs(energy0 - energy1 - run.y[8, -1]) / energy0 < 1e-9
    assert abs(mass1 - mass0) / mass0 < 1e-9


def test_contradictions_are_refused():
    for values in ({"length": 0.0}, {"diameter": 0.0}, {"pieces": 0.0}, {"pieces": 2.5}):
        with pytest.raises(ParameterError, match=next(iter(values))):
            with_pieces(5, **values)
    with pytest.raises(ParameterError, match="wall"):
        TubeWall(diameter=0.02, wall_thickness=0.0, youngs_modulus=2e11)
