import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.volume import (
    Vessel,
    closed_volume_contents,
    closed_volume_rate,
    gas_energy,
    gas_excess,
    gas_volume,
    oil_held,
    pressure_rate,
    vessel_contents,
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
    # The seat (width s = 1 % of 5e5) carries s^2/(4 d) = 4.2 Pa at d = 1.5e6: 2.1e-6 of 2e6.
    assert gas_volume(2e6, isothermal) == pytest.approx(1.25e-5, rel=2.2e-6)  # 5e-5 * 5e5/2e6
    # p0 Vg0 ln 4 = 25 * 1.3862943611 = 34.657359028; ref * 3.75e-5 = 3.7996875
    # and the seat: 0.25e-4 * 25 * ln(3/3.1e-5) = 7.2e-3 J at most
    assert gas_energy(2e6, isothermal, REF) == pytest.approx(30.857671528, abs=8e-3)
    # k = 1.5: Vg = 5e-5 * 8^(-2/3) = 1.25e-5; P Vg = 4e6 * 1.25e-5 = 50; (50 - 25)/0.5 = 50
    steep = vessel(gas_exponent=1.5)
    assert gas_volume(4e6, steep) == pytest.approx(1.25e-5, rel=1e-6)
    assert gas_energy(4e6, steep, REF) == pytest.approx(50.0 - 3.7996875, abs=8e-3)


def test_seat_by_hand():
    # d = 0: (0 + s)/2 = 2500 Pa; d = 12 s/5: s (12/5 + 13/5)/2 = 2.5 s = 12 500 Pa; d = -12 s/5: s/10 = 500 Pa
    for pressure, excess in ((5e5, 2500.0), (512e3, 12500.0), (488e3, 500.0)):
        assert gas_excess(pressure, vessel()) == pytest.approx(excess, rel=1e-12)


def test_below_precharge_the_gas_takes_hardly_any_part():
    free = 5e-5 / (1.3 * 5e5)  # Vg0/(k p0), the gas's capacity right above its precharge
    for pressure in (2e4, 3e5):
        carried = 0.25 * (5e3 / (5e5 - pressure)) ** 2  # (1 + d/sqrt(d^2 + s^2))/2 -> s^2/(4 d^2)
        assert gas_volume(pressure, vessel()) == pytest.approx(5e-5, rel=carried)
        assert wall_capacity(pressure, vessel()) - 4e-4 * 3e-10 == pytest.approx(carried * free, rel=1e-3)
    assert gas_energy(REF, vessel(), REF) == 0.0


@pytest.mark.parametrize("pressure", [1e3, 3e5, 4.99e5, 5e5, 5.01e5, 2e6])
def test_capacity_is_the_slope_of_the_gas_volume(pressure):
    tank, step = vessel(hose_compliance=0.0), 1.0
    slope = (gas_volume(pressure - step, tank) - gas_volume(pressure + step, tank)) / (2.0 * step)
    # Rounding of the volume, 5e-5 * 2e-16 over 2 Pa; the difference's own error is step^2/s^2 = 4e-8 of it.
    assert wall_capacity(pressure, tank) == pytest.approx(slope, rel=1e-6, abs=2e-20)


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
        REF,
        8e6,
        epsabs=0.0,
        epsrel=1e-12,
        points=[4.9e5, 5e5, 5.1e5],
        limit=500,
    )
    assert gas_energy(8e6, tank, REF) == pytest.approx(work, rel=1e-11)


def test_without_gas_and_hose_a_vessel_is_a_closed_volume(oil):
    plain = vessel(hose_compliance=0.0, gas_volume=0.0, precharge_pressure=0.0)
    for pressure in (1e3, REF, 3e7):
        fluid = fluid_state(pressure, oil)
        assert oil_held(pressure, plain, REF) == 4e-4
        assert pressure_rate(1e-4, 2e-5, fluid, plain, REF) == pytest.approx(
            closed_volume_rate(1e-4, 2e-5, 4e-4, fluid), rel=1e-14
        )
        fluid = fluid_state(pressure, oil)
        assert vessel_contents(fluid, oil, plain) == closed_volume_contents(fluid, 4e-4, oil)
    nothing = vessel_contents(fluid_state(REF, oil), oil, plain)
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
            pressure_rate(q, rate, fluid, tank, REF, swept),
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
    begin, end = (
        vessel_contents(fluid_state(run.y[0, 0], oil), oil, tank, wall(0.0)[0]),
        vessel_contents(fluid_state(run.y[0, -1], oil), oil, tank, wall(1.7)[0]),
    )
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
