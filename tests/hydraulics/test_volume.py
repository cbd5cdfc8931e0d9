import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.volume import (
    Vessel,
    closed_volume_rate,
    closed_volume_stored,
    gas_energy,
    gas_volume,
    oil_held,
    pressure_rate,
    stored,
    wall_capacity,
)

REF = 101325.0


def vessel(**changed):
    values = {
        "oil_volume": 4e-4,
        "hose_compliance": 3e-10,
        "gas_volume": 5e-5,
        "precharge_pressure": 5e5,
        "gas_exponent": 1.3,
    }
    return Vessel(**(values | changed))


def test_gas_by_hand():
    isothermal = vessel(gas_exponent=1.0)
    assert gas_volume(2e6, isothermal) == pytest.approx(1.25e-5, rel=1e-14)  # 5e-5 * 5e5/2e6
    # p0 Vg0 ln 4 = 25 * 1.3862943611 = 34.657359028; ref * 3.75e-5 = 3.7996875
    assert gas_energy(2e6, isothermal, REF) == pytest.approx(30.857671528, rel=1e-10)
    # k = 1.5: Vg = 5e-5 * 8^(-2/3) = 1.25e-5; P Vg = 4e6 * 1.25e-5 = 50; (50 - 25)/0.5 = 50
    steep = vessel(gas_exponent=1.5)
    assert gas_volume(4e6, steep) == pytest.approx(1.25e-5, rel=1e-14)
    assert gas_energy(4e6, steep, REF) == pytest.approx(50.0 - 3.7996875, rel=1e-13)


def test_below_precharge_the_gas_takes_no_part():
    for pressure in (2e4, 3e5, 5e5):
        assert gas_volume(pressure, vessel()) == 5e-5
        assert gas_energy(pressure, vessel(), REF) == 0.0
        assert wall_capacity(pressure, vessel()) == 4e-4 * 3e-10


def test_gas_energy_goes_over_into_the_isothermal_limit():
    limit = gas_energy(6e6, vessel(gas_exponent=1.0), REF)
    # d(energy)/dk is about -p0 Vg0 L^2/2 - ... < 150 J: 1e-9 in k moves it by less than 2e-7 J
    for small in (1e-15, 1e-12, 1e-9):
        assert gas_energy(6e6, vessel(gas_exponent=1.0 + small), REF) == pytest.approx(limit, abs=150.0 * small + 1e-13)


@pytest.mark.parametrize("exponent", [1.0, 1.0001, 1.3, 1.67])
def test_gas_energy_is_the_work_done_on_it(exponent):
    tank = vessel(gas_exponent=exponent)
    work, _ = quad(
        lambda p: (p - REF) * (wall_capacity(p, tank) - tank.oil_volume * tank.hose_compliance),
        5e5,
        8e6,
        epsabs=0.0,
        epsrel=1e-12,
    )
    assert gas_energy(8e6, tank, REF) == pytest.approx(work, rel=1e-11)


def test_without_gas_and_hose_a_vessel_is_a_closed_volume(oil):
    plain = vessel(hose_compliance=0.0, gas_volume=0.0, precharge_pressure=0.0)
    for pressure in (1e3, REF, 3e7):
        fluid = fluid_state(pressure, oil)
        assert oil_held(pressure, plain, REF) == 4e-4
        assert pressure_rate(1e-4, 2e-5, pressure, fluid, plain, REF) == pytest.approx(
            closed_volume_rate(1e-4, 2e-5, 4e-4, fluid), rel=1e-14
        )
        assert stored(pressure, oil, plain) == closed_volume_stored(pressure, 4e-4, oil)
    nothing = stored(REF, oil, plain)
    assert nothing.energy == 0.0 and nothing.volume == pytest.approx(4e-4, rel=1e-15)


def test_closed_volume_rate_by_hand(oil):
    stiff = fluid_state(REF, oil)._replace(volume_ratio=0.98, bulk_modulus=1e9)
    # (0.98 * 1e-4 - 8e-6) * 1e9 / 1e-3 = 9e-5 * 1e12
    assert closed_volume_rate(1e-4, 8e-6, 1e-3, stiff) == pytest.approx(9e7, rel=1e-14)


def test_hose_by_hand():
    hose = vessel(gas_volume=0.0)
    assert oil_held(REF + 1e7, hose, REF) == pytest.approx(4e-4 * 1.003, rel=1e-15)
    assert wall_capacity(1e7, hose) == pytest.approx(1.2e-13, rel=1e-15)


def test_books_of_a_fill_and_empty_cycle_across_precharge_close(oil):
    """A pulsating flow and a moving wall; mass and energy against their own integrals at rtol 1e-11."""
    tank = vessel()

    def wall(t):
        return 5e-6 * (1.0 - np.cos(5.0 * t)), 2.5e-5 * np.sin(5.0 * t)

    def flow(t):
        return 1.2e-4 * np.sin(2.0 * np.pi * t) + 2e-5 * np.sin(14.0 * np.pi * t)

    def rates(t, y):
        swept, rate = wall(t)
        fluid = fluid_state(y[0], oil)
        q = flow(t)
        return [
            pressure_rate(q, rate, y[0], fluid, tank, REF, swept),
            q,
            q * fluid.enthalpy,
            (y[0] - REF) * rate,
            abs(q) * fluid.enthalpy,
        ]

    run = solve_ivp(
        rates,
        (0.0, 1.7),
        [1.5e5, 0.0, 0.0, 0.0, 0.0],
        method="DOP853",
        rtol=1e-11,
        atol=[1e-5, 1e-17, 1e-12, 1e-12, 1e-12],
        max_step=2e-3,
    )
    begin, end = stored(run.y[0, 0], oil, tank, wall(0.0)[0]), stored(run.y[0, -1], oil, tank, wall(1.7)[0])
    assert run.y[0].min() < tank.precharge_pressure < 1.5 * tank.precharge_pressure < run.y[0].max()
    _, mass, energy, work, moved = run.y[:, -1]
    assert abs(energy - work - (end.energy - begin.energy)) / moved < 1e-9
    assert abs(mass - (end.volume - begin.volume)) / begin.volume < 1e-9
    # The cycle is not trivial: each store takes part, and leaving one out would show
    assert gas_energy(run.y[0].max(), tank, REF) > 1e-2 * moved


def test_gas_without_precharge_is_refused():
    with pytest.raises(ParameterError, match="precharge_pressure"):
        vessel(precharge_pressure=0.0)
    with pytest.raises(ParameterError, match="oil_volume"):
        vessel(oil_volume=0.0)
