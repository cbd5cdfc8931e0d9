import pytest

from vvdp.valve.condition import Condition
from vvdp.valve.losses import transition_loss
from vvdp.valve.operating_point import SetPoint, nozzle_reynolds_number, operating_point

BAR, T = 1e5, 101325.0


def point(valve, oil, **changes):
    usual = SetPoint(
        flow=40.0 / 6e4,
        temperature=313.15,
        duty_ratio=0.5,
        load_pressure=100.0 * BAR + T,
        relief_pressure=120.0 * BAR + T,
        tank_pressure=T,
    )
    return operating_point(usual._replace(**changes), 12.7e-6, oil, valve)


def test_nozzle_reynolds_number(prototype):
    # 876 * 18.265 m/s * 3.3392e-3 / 0.0387 = 1380.5
    assert nozzle_reynolds_number(40.0 / 6e4, 876.0, 0.0387, prototype) == pytest.approx(1380.5, rel=1e-4)


def test_prototype_at_its_design_point(prototype, vg46):
    found = point(prototype, vg46)
    assert found.total_drop == pytest.approx(6.6765e5, rel=1e-4)
    # 876 / 2 (Q / (0.61 x 36.5 mm^2))^2 and 876 / 2 (Q / (0.677 x 46.8 mm^2))^2
    assert found.nozzle_drop == pytest.approx(3.9269e5, rel=1e-4)
    assert found.outlet_drop == pytest.approx(1.9392e5, rel=1e-4)
    assert found.nozzle_drop + found.centre_drop + found.outlet_drop == pytest.approx(found.total_drop, rel=1e-14)
    assert found.inlet_torque == pytest.approx(0.13547, rel=1e-4)
    assert found.inlet_torque + found.outlet_torque == pytest.approx(found.friction_torque, rel=1e-12)
    assert found.full_open_pwm_frequency == pytest.approx(72.0, abs=0.05)
    assert found.averaged_pwm_frequency == pytest.approx(63.1, rel=1e-3)
    assert found.transition_fraction == pytest.approx(0.3001, abs=1e-4)
    assert found.full_open_loss == pytest.approx(445.1, rel=5e-4)
    assert found.transition_loss == pytest.approx(1333.2, rel=5e-4)
    assert found.leakage_loss == pytest.approx(26.3, rel=5e-3)
    # 38.1 W at 72 Hz, here at the frequency at which the valve switches
    assert found.compressibility_loss == pytest.approx(38.1 * 63.1 / 72.0, rel=5e-3)
    assert found.friction_loss == pytest.approx(30.35, rel=1e-3)
    assert found.cycle.loss == pytest.approx(1778.4, rel=1e-3)


def test_total_leaves_out_what_the_drop_already_contains(prototype, vg46):
    found = point(prototype, vg46)
    parts = found.full_open_loss + found.transition_loss + found.leakage_loss + found.compressibility_loss
    assert found.total_loss == pytest.approx(parts, rel=1e-14)


def test_warnings_tell_of_laminar_nozzles_and_of_the_range(prototype, vg46):
    assert point(prototype, vg46).warnings == ()  # the Reynolds number, 1381, is that of a usual point
    assert point(prototype, vg46, temperature=353.15).warnings == ()
    assert any("duty ratio 0.1" in warning for warning in point(prototype, vg46, duty_ratio=0.1).warnings)


def test_warm_oil_spins_faster(prototype, vg46):
    assert point(prototype, vg46, temperature=323.15).full_open_pwm_frequency == pytest.approx(106.3, abs=0.1)


def test_an_override_is_carried(prototype, vg46):
    """What the cycle loses beyond the open valve: with an override that goes to nothing, the closed form; with 10 bar
    at 40 lpm a higher pressure while both ports are nearly shut, and so a higher loss and a faster spool."""
    ideal = point(prototype, vg46)
    stiff, soft = (
        point(prototype, vg46, relief_override=override, relief_rated_flow=40.0 / 6e4)
        for override in (10.0, 10.0 * BAR)
    )
    assert stiff.transition_loss == pytest.approx(ideal.transition_loss, rel=3e-4)
    assert stiff.averaged_pwm_frequency == pytest.approx(ideal.averaged_pwm_frequency, rel=1e-5)
    assert 1.01 < soft.transition_loss / ideal.transition_loss < 10.0 / 120.0 + 1.0
    assert soft.averaged_pwm_frequency > ideal.averaged_pwm_frequency
    assert soft.full_open_loss == ideal.full_open_loss


def test_a_pump_that_delivers_a_flow_displaces_more(prototype, vg46):
    """There and back: what 41.04 lpm deliver is delivered by 41.04 lpm."""
    leaking = SetPoint(
        flow=22.8e-6 * 30.0,
        temperature=313.15,
        duty_ratio=0.5,
        load_pressure=100.0 * BAR + T,
        relief_pressure=120.0 * BAR + T,
        tank_pressure=T,
        pump_leakage=2.45e-12,
    )
    delivered = operating_point(leaking, 12.7e-6, vg46, prototype).flow
    back = leaking.delivering(delivered, vg46, prototype)
    assert back.flow == pytest.approx(leaking.flow, rel=1e-10)
    assert leaking._replace(pump_leakage=0.0).delivering(1e-4, vg46, prototype).flow == 1e-4


def test_the_pump_delivers_less_than_it_displaces(prototype, vg46):
    """22.8 cc/rev at 1800 rpm displace 41.04 lpm. At a mean of 69.9 bar over the tank 2.45e-12 m3/(s Pa) take
    1.712e-5 m3/s = 1.027 lpm of it; through the valve go 40.013 lpm."""
    found = point(prototype, vg46, flow=22.8e-6 * 30.0, pump_leakage=2.45e-12)
    leakage = 2.45e-12 * (found.cycle.inlet_pressure - T)
    assert found.flow == pytest.approx(22.8e-6 * 30.0 - leakage, rel=1e-12)
    assert 6e4 * found.flow == pytest.approx(40.013, abs=0.001)
    tight = point(prototype, vg46)
    assert found.total_drop == pytest.approx(tight.total_drop, rel=1e-3)
    # While the relief valve is open the pump's leakage costs nothing more, so that the transitions lose less by it;
    # docs/models/rotary-valve.md, "Flow map".
    assert found.transition_loss == pytest.approx(1312.4, abs=0.3)
    at = Condition(flow=found.flow, load_pressure=100.0 * BAR + T, relief_pressure=120.0 * BAR + T, tank_pressure=T,
                   density=876.0)  # fmt: skip
    assert transition_loss(at, prototype).loss == pytest.approx(1334.0, abs=0.6)
    assert 0.95 * tight.transition_loss < found.transition_loss < tight.transition_loss
