"""Counterbalance, sequence, shuttle and four-way valves and variable machines, in circuits with closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from vvdp.base.errors import ConfigError
from vvdp.hydraulics.balanced_valve import opening_share
from vvdp.hydraulics.counterbalance_valve import CounterbalanceValve, pilot_aid, two_way_flow
from vvdp.hydraulics.flow import root_edge_flow
from vvdp.hydraulics.four_way_valve import FourWayValve, four_edges
from vvdp.hydraulics.proportional_spool import ValveSpool, spool_error, spool_motion
from vvdp.runs.simulate import run_system
from vvdp.systems.system import load_system

BAR, LPM = 1e5, 1e-3 / 60.0
STIFF_OIL = """
[oil]
air_fraction = "0 %"
liquid_bulk_modulus = "2 GPa"
"""
VALVE = CounterbalanceValve(
    cracking_pressure=200 * BAR,
    override_pressure=20 * BAR,
    rated_flow=60 * LPM,
    rated_drop=30 * BAR,
    opening_time=2e-3,
    reverse_cracking_pressure=0.5 * BAR,
    reverse_override_pressure=4.5 * BAR,
    pilot_ratio=3.0,
)
COUNTERBALANCE = """
type = "counterbalance-valve"
cracking_pressure = "200 bar"
override_pressure = "20 bar"
rated_flow = "60 lpm"
rated_drop = "30 bar"
opening_time = "2 ms"
reverse_cracking_pressure = "0.5 bar"
reverse_override_pressure = "4.5 bar"
pilot_ratio = "3"
"""
LOWERING = f"""
title = "A load that a pump lowers against a counterbalance valve"
[nodes]
tank = {{ type = "tank" }}
rod = {{ type = "rod" }}
load_side = {{ type = "volume", volume = "0.2 l", start = "98 bar" }}
pump_side = {{ type = "volume", volume = "0.2 l", start = "0 bar" }}
[components.pump]
type = "flow-source"
a = "tank"
b = "pump_side"
flow = "12 lpm"
counted_at_outlet = 1
[components.cylinder]
type = "cylinder"
a = "pump_side"
b = "load_side"
rod = "rod"
area_a = "12 cm^2"
area_b = "20 cm^2"
stroke = "2 m"
moving_mass = "100 kg"
leakage_conductance = "0 m^3/(s*Pa)"
[components.pull]
type = "load-force"
rod = "rod"
force = "20 kN"
[components.damping]
type = "rod-friction"
rod = "rod"
viscous_friction = "60 kN*s/m"
coulomb_friction = "0 N"
breakaway_friction = "0 N"
stribeck_velocity = "0.1 m/s"
coulomb_velocity = "0.01 m/s"
[components.holding]
a = "load_side"
b = "tank"
pilot = "pump_side"
{COUNTERBALANCE}
{STIFF_OIL}
[run]
until = "3 s"
average_from = "2.5 s"
"""


def result(tmp_path, text, *settings):
    path = tmp_path / "circuit.toml"
    path.write_text(text)
    run = run_system(load_system(str(path), settings))
    assert run.has("finished")
    assert run.summary["trusted"] is True, run.summary
    return run


def test_opening_follows_the_balance_of_forces_on_the_poppet():
    """R = 3: 200 bar open it alone; with 20 bar behind it 280 are needed; 50 bar at the pilot leave 50."""

    def opens_at(back, pilot):
        def missing(load):
            return opening_share(load - back + pilot_aid(pilot - back, VALVE), VALVE)

        return brentq(missing, -500 * BAR, 500 * BAR) / BAR

    assert opens_at(0.0, 0.0) == pytest.approx(200.0)
    assert opens_at(20 * BAR, 0.0) == pytest.approx(280.0)
    assert opens_at(0.0, 50 * BAR) == pytest.approx(50.0)


def test_a_load_is_lowered_at_the_speed_of_the_pump(tmp_path):
    """v = Q/A_p, and the pilot pressure at which load, valve and flow are in balance."""
    run = result(tmp_path, LOWERING)
    force, a_p, a_l = 20e3 - 60e3 * 12 * LPM / 12e-4, 12e-4, 20e-4
    flow = 12 * LPM / a_p * a_l

    def surplus(pilot):
        load = (force + a_p * pilot) / a_l
        lift = min(max(opening_share(load + pilot_aid(pilot, VALVE), VALVE), 0.0), 1.0)
        return two_way_flow(load, lift, VALVE) - flow

    pilot = brentq(surplus, 0.0, 200 * BAR)
    assert run.summary["pressure_mean_pump_side_Pa"] == pytest.approx(pilot, rel=2e-3)
    found = run.summary["pressure_mean_load_side_Pa"]
    assert found == pytest.approx((force + a_p * pilot) / a_l, rel=2e-3)


def test_backwards_a_check_valve_lets_the_load_be_raised(tmp_path):
    """At 60 lpm the check valve is fully open and has 5 bar."""
    text = f"""
[nodes]
tank = {{ type = "tank" }}
supply = {{ type = "volume", volume = "10 cc", start = "5 bar" }}
[components.pump]
type = "flow-source"
a = "tank"
b = "supply"
flow = "60 lpm"
counted_at_outlet = 1
[components.valve]
a = "tank"
b = "supply"
pilot = "tank"
{COUNTERBALANCE}
[run]
until = "0.5 s"
average_from = "0.4 s"
"""
    assert result(tmp_path, text).summary["pressure_mean_supply_Pa"] == pytest.approx(5 * BAR, rel=1e-3)


@pytest.mark.parametrize(("drain", "least"), [("tank", 100.0), ("back", 140.0)])
def test_a_sequence_valve_counts_from_its_drain(tmp_path, drain, least):
    """Drained to the tank it opens at 100 bar whatever stands behind it; drained behind itself, 40 bar later."""
    text = f"""
[nodes]
tank = {{ type = "tank" }}
back = {{ type = "pressure-source", pressure = "40 bar" }}
supply = {{ type = "volume", volume = "50 cc", start = "90 bar" }}
[components.pump]
type = "flow-source"
a = "tank"
b = "supply"
flow = "6 lpm"
counted_at_outlet = 1
[components.valve]
type = "sequence-valve"
a = "supply"
b = "back"
drain = "{drain}"
cracking_pressure = "100 bar"
override_pressure = "10 bar"
rated_flow = "60 lpm"
rated_drop = "10 bar"
opening_time = "2 ms"
reverse_cracking_pressure = "0.5 bar"
reverse_override_pressure = "4.5 bar"
[run]
until = "1 s"
average_from = "0.8 s"
"""
    found = result(tmp_path, text).summary["pressure_mean_supply_Pa"] / BAR

    def surplus(pressure):
        return 60 * (pressure - least) / 10 * np.sqrt((pressure - 40) / 10) - 6

    assert found == pytest.approx(brentq(surplus, least, least + 10), rel=1e-4)


@pytest.mark.parametrize(("one", "other"), [("120 bar", "80 bar"), ("60 bar", "90 bar")])
def test_a_shuttle_valve_hands_on_the_higher_pressure(tmp_path, one, other):
    """Less the drop of 1 lpm over a seat that passes 4 lpm at 1 bar."""
    text = f"""
[nodes]
tank = {{ type = "tank" }}
one = {{ type = "pressure-source", pressure = "{one}" }}
other = {{ type = "pressure-source", pressure = "{other}" }}
sensed = {{ type = "volume", volume = "5 cc", start = "50 bar" }}
[components.drain]
type = "flow-source"
a = "sensed"
b = "tank"
flow = "1 lpm"
[components.shuttle]
type = "shuttle-valve"
a = "one"
b = "other"
outlet = "sensed"
changeover_pressure = "1 bar"
rated_flow = "4 lpm"
rated_drop = "1 bar"
[oil]
air_fraction = "0 %"
[run]
until = "1 s"
average_from = "0.8 s"
"""
    higher = max(float(one.split()[0]), float(other.split()[0]))
    found = result(tmp_path, text).summary["pressure_mean_sensed_Pa"] / BAR
    assert found == pytest.approx(higher - 1.0 / 16.0, abs=1e-2)


FOUR_WAY = FourWayValve(
    conductance=2e-7,
    overlap_pa=0.05,
    overlap_pb=0.05,
    overlap_at=-0.2,
    overlap_bt=-0.2,
    transition_pressure=1e4,
    natural_frequency=50.0,
    damping_ratio=0.5,
    largest_rate=1e4,
)


def test_underlap_leaves_edges_open_in_the_middle():
    """A float: pressure shut, both loads open to the tank by 0.2/1.2; fully forward pa and bt alone."""
    assert four_edges(0.0, FOUR_WAY) == pytest.approx((0.0, 0.0, 0.2 / 1.2, 0.2 / 1.2, 1.0))
    assert four_edges(1.0, FOUR_WAY) == pytest.approx((1.0, 0.0, 0.0, 1.0, 0.0))
    assert four_edges(-0.05, FOUR_WAY).at == pytest.approx(0.25 / 1.2)


def stepped(valve, until, steps):
    """The position after a step of the command to 1, by the trapezoidal rule of second order (Heun)."""
    spool, dt, found = ValveSpool(0.0, 0.0), until / steps, []
    for _ in range(steps):
        first = spool_motion(spool_error(1.0, spool.position, 0.0, valve), spool, valve)
        ahead = ValveSpool(spool.position + dt * first.position, spool.wanted_rate + dt * first.wanted_rate)
        second = spool_motion(spool_error(1.0, ahead.position, 0.0, valve), ahead, valve)
        spool = ValveSpool(*(x + 0.5 * dt * (a + b) for x, a, b in zip(spool, first, second, strict=True)))
        found.append(spool.position)
    return np.array(found)


def test_a_spool_overshoots_like_a_second_order_system_below_its_largest_rate():
    """exp(-pi zeta/root(1 - zeta^2)) of the step."""
    zeta = FOUR_WAY.damping_ratio
    expected = 1.0 + np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta * zeta))
    assert stepped(FOUR_WAY, 0.04, 8000).max() == pytest.approx(expected, rel=1e-5)


def test_a_spool_moves_no_faster_than_its_largest_rate():
    """Almost at the end after 1/r, on a ramp in between."""
    path = stepped(replace(FOUR_WAY, damping_ratio=1.0, largest_rate=5.0), 0.2, 8000)
    rates = np.diff(path) / (0.2 / 8000)
    assert rates.max() == pytest.approx(5.0, rel=1e-9)
    assert np.ptp(rates[2000:6000]) < 1e-9
    assert path.max() < 1.0 + 1e-3


MACHINE = """
displacement = "28 cc/rev"
leakage_conductance = "2e-12 m^3/(s*Pa)"
shaft_damping = "0.01 N*m*s"
coulomb_torque = "1 N*m"
coulomb_speed = "10 rpm"
inertia = "0.002 kg*m^2"
pressure_friction = "0.03"
response_time = "50 ms"
largest_rate = "5 1/s"
"""
PUMPING = f"""
[nodes]
tank = {{ type = "tank" }}
line = {{ type = "pressure-source", pressure = "150 bar" }}
shaft = {{ type = "driven-shaft", speed = "1500 rpm" }}
[components.machine]
type = "variable-pump"
inlet = "tank"
outlet = "line"
shaft = "shaft"
setting = "0.6"
{MACHINE}
[oil]
air_fraction = "0 %"
[run]
until = "2 s"
average_from = "1.5 s"
"""


@pytest.mark.parametrize("setting", [0.6, -0.6])
def test_a_variable_pump_gives_and_overcentre_takes_power(tmp_path, setting):
    """Wilson: s D omega less the leakage, and s D dP with damping, dry and pressure friction on top."""
    run = result(tmp_path, PUMPING, f"components.machine.setting={setting}")
    D, omega, drop = 28e-6 / (2 * np.pi), 1500 * np.pi / 30, 150 * BAR
    torque = setting * D * drop + 0.01 * omega + (1.0 + 0.03 * D * drop) / np.hypot(1.0, 10 / 1500)
    supplied = run.summary["power_shaft_W"]
    # the enthalpy of oil that yields by 1 % at 150 bar is the work of displacing it within half of that
    assert supplied == pytest.approx(torque * omega, rel=6e-3)
    assert supplied * setting > 0.0


def test_a_setting_follows_with_its_rate_and_then_its_lag(tmp_path):
    """From 0 to 0.6: at 5 1/s until 0.25 are missing, then exponentially: a mean of the setting in closed form."""
    run = result(tmp_path, PUMPING, "run.average_from=0 s", "run.until=1 s")
    ramp = (0.6 - 0.25) / 5.0
    lost = 0.5 * ramp * (0.6 + 0.25) + 0.25 * 0.05 * (1.0 - np.exp(-(1.0 - ramp) / 0.05))
    displaced = 28e-6 / (2 * np.pi) * 1500 * np.pi / 30 * (0.6 - lost)
    leakage = run.summary["flow_mean_machine_leakage_m3_s"]
    assert run.summary["flow_mean_machine_m3_s"] == pytest.approx(displaced - leakage, rel=1e-5)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("components.machine.largest_rate=0 1/s", "largest_rate"),
        ("components.machine.setting=0.6 bar", "setting"),
        ("components.machine.pressure_friction=1.2", "pressure_friction"),
    ],
)
def test_wrong_values_are_named(tmp_path, given, told):
    path = tmp_path / "circuit.toml"
    path.write_text(PUMPING)
    with pytest.raises(ConfigError, match=told):
        load_system(str(path), [given])


def test_half_an_edge_passes_half_the_flow_either_way():
    """K root(dp): 2e-7 m^3/(s Pa^0.5) at 10 bar are 12 lpm."""
    assert root_edge_flow(FOUR_WAY.conductance, 0.5, 10 * BAR, FOUR_WAY.transition_pressure) == pytest.approx(
        6 * LPM, rel=1e-4
    )
    assert root_edge_flow(FOUR_WAY.conductance, 0.5, -10 * BAR, FOUR_WAY.transition_pressure) == pytest.approx(
        -6 * LPM, rel=1e-4
    )
