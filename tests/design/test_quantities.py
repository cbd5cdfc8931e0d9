"""What designs are judged by, against the published operating point and against their own definitions."""

import numpy as np
import pytest

from vvdp.design.quantities import Quantities, key, quantities, setup
from vvdp.design.variables import VARIABLES, redesign, setting_text, value_in, with_variables
from vvdp.systems.system import load_system
from vvdp.valve.losses import full_open_loss
from vvdp.valve.operating_point import SetPoint, operating_point


def test_prototype(prototype):
    """40 lpm, 100 bar, relief 120 bar, 40 degC, duty ratio 0.5: the published tables.

    Input 6.6667e-4 m3/s at 50 + ... bar: load 2873.7 W, with 445.1 W and 1333.2 W of throttling 4652 W; less 26.3 W
    and 38.1 W the load keeps 2809.3 W, 0.604 of it. Pulsation: 0.25 * 6.6667e-4 / 72 = 2.315 cc."""
    q = quantities(setup(prototype))
    assert q.pressure_drop_total == pytest.approx(6.6765e5, rel=1e-4)
    assert q.pwm_frequency == pytest.approx(72.0, rel=2e-4)
    assert q.transition_fraction == pytest.approx(0.3001, rel=1e-3)
    assert q.loss_full_open == pytest.approx(445.1, abs=0.1)
    assert q.loss_transition == pytest.approx(1333.2, abs=0.3)
    assert q.loss_leakage == pytest.approx(26.3, abs=0.1)
    assert q.efficiency == pytest.approx(0.604, abs=5e-4)
    assert q.load_pulsation == pytest.approx(2.315e-6, rel=1e-3)
    assert q.spool_friction_power == pytest.approx(30.35, abs=0.05)
    assert q.relief_margin == pytest.approx(20e5 - 6.6765e5, rel=1e-4)


def test_same_as_the_operating_point(prototype):
    at = setup(prototype)
    q = quantities(at)
    set_point = SetPoint(
        flow=at.flow,
        temperature=at.temperature,
        duty_ratio=at.duty_ratio,
        load_pressure=at.load_pressure,
        relief_pressure=at.relief_pressure,
        tank_pressure=at.tank_pressure,
        relief_override=at.relief_override,
        relief_rated_flow=at.relief_rated_flow,
    )
    point = operating_point(set_point, at.inlet_volume, at.oil, at.valve)
    assert q.pressure_drop_total == point.total_drop
    assert q.pwm_frequency == pytest.approx(point.full_open_pwm_frequency, rel=1e-14)
    assert q.loss_transition == point.transition_loss
    assert q.loss_leakage == point.leakage_loss
    # the only difference: here the compressibility counts the fully open frequency
    ratio = point.full_open_pwm_frequency / point.averaged_pwm_frequency
    assert q.loss_compressibility == pytest.approx(ratio * point.compressibility_loss, rel=1e-12)


def test_energy_is_counted_once(prototype):
    """Input = load + losses: with L the sum of the losses and e the efficiency, load power = e (load power + L)."""
    at = setup(prototype)
    q = quantities(at)
    load = (at.load_pressure - at.tank_pressure) * q.load_flow - q.loss_leakage - q.loss_compressibility
    assert load / (load + q.loss_total) == pytest.approx(q.efficiency, rel=1e-12)


def test_driven_spool(prototype):
    """A stiff coupling holds the spool at its motor's speed: 3000 rpm and three nozzles are 150 Hz; the motor then
    gives what friction takes beyond the turbines' torque."""
    motor = ["spool_drive.coupling=1000 N*m*s", "operation.spool_motor_speed=3000 rpm"]
    driven = load_system("prototype-constant-load", motor)
    at = setup(driven)
    q = quantities(at)
    assert q.pwm_frequency == pytest.approx(150.0, rel=1e-4)
    omega, valve = 100.0 * np.pi, at.valve
    friction = valve.friction_area * 0.0387 * valve.spool_radius**2 / valve.radial_clearance * omega
    rho_q = 876.0 * at.flow
    turbines = rho_q * at.flow * (0.0127 / 36.5e-6 + 0.0127 / 61.8e-6) - rho_q * 0.0127**2 * omega
    assert q.spool_drive_power == pytest.approx((friction - turbines) * omega, rel=2e-3)
    assert q.loss_total - quantities(setup(prototype)).loss_total == pytest.approx(
        q.spool_drive_power + q.loss_compressibility * (1.0 - 72.0 / 150.0), rel=1e-3
    )


def test_arrays_of_designs_are_single_designs(prototype):
    at = setup(prototype)
    values = {"spool_radius": np.array([0.01, 0.013]), "nozzle_area": np.array([3e-5, 5e-5])}
    together = quantities(with_variables(at, values))
    for k in range(2):
        alone = quantities(with_variables(at, {name: float(column[k]) for name, column in values.items()}))
        for name in Quantities._fields:
            found = np.broadcast_to(getattr(together, name), 2)[k]
            assert found == pytest.approx(getattr(alone, name), rel=1e-12), name


def test_what_goes_with_a_variable(prototype):
    """Twice the radius: twice the friction area and jet radius, four times the mass; outlet areas keep their ratio."""
    valve = prototype.case.params.valve
    new = with_variables(setup(prototype), {"spool_radius": 2.0 * valve.spool_radius, "outlet_area": 93.6e-6}).valve
    assert new.friction_area == pytest.approx(2.0 * valve.friction_area)
    assert new.inlet_radius == new.outlet_radius == pytest.approx(2.0 * valve.spool_radius)
    assert new.spool_mass == pytest.approx(4.0 * valve.spool_mass)
    assert new.outlet_effective_area == pytest.approx(2.0 * 61.8e-6)


def test_a_redesigned_system_is_the_changed_setup(prototype):
    values = {"spool_radius": 0.011, "outlet_area": 9e-5, "helix_length": 0.025, "relief_pressure": 1.31e7,
              "inlet_volume": 4e-6}  # fmt: skip
    system = redesign(prototype, values, "test", "title")
    new, expected = quantities(setup(system)), quantities(with_variables(setup(prototype), values))
    for name in Quantities._fields:
        assert getattr(new, name) == pytest.approx(getattr(expected, name), rel=1e-9), name
    assert all(value_in(setup(system), name) == pytest.approx(value, rel=1e-9) for name, value in values.items())


def test_every_variable_is_written_so_that_it_is_read():
    from vvdp.base.units import parse

    for variable in VARIABLES.values():
        value = parse(variable.kind.example, variable.kind) * 1.0123456789
        assert parse(setting_text(value, variable.kind), variable.kind) == pytest.approx(value, rel=1e-9)


def test_keys_end_in_their_unit():
    from vvdp.design.quantities import KINDS

    assert key("pressure_drop_total", KINDS["pressure_drop_total"]) == "pressure_drop_total_Pa"
    assert key("load_flow", KINDS["load_flow"]) == "load_flow_m3_s"
    assert key("efficiency", KINDS["efficiency"]) == "efficiency"


def test_power_of_the_open_valve(prototype):
    at = setup(prototype)
    rho = 876.0
    assert quantities(at).loss_full_open == pytest.approx(full_open_loss(at.flow, rho, at.valve), rel=1e-12)
