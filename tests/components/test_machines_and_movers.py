"""Measured machines, prime movers, compensators, spools and poppets: values by hand, and the laws that they obey."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.components.four_way_valves import four_way_valve, load_sensing_valve, six_way_valve
from vvdp.components.prime_movers import diesel_engine, electric_motor
from vvdp.components.pump_compensators import pump_compensator
from vvdp.components.self_acting_valves import LiftState, check_valve, poppet_valve, shock_valve
from vvdp.components.variable_machines import measured_motor, measured_pump, variable_motor, variable_pump
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.check_valve import CheckValve
from vvdp.hydraulics.four_way_valve import FourWayValve, SensingValve, SixWayValve, four_edges
from vvdp.hydraulics.measured_machine import MeasuredMachine
from vvdp.hydraulics.opening import OpeningState
from vvdp.hydraulics.poppet_valve import PoppetValve, free_lift, lift_range
from vvdp.hydraulics.ports import Medium, ShaftSpeed
from vvdp.hydraulics.prime_mover import DieselEngine, ElectricMotor, GovernorState, RackState
from vvdp.hydraulics.proportional_spool import ProportionalSpool, ValveSpool, spool_error, spool_motion
from vvdp.hydraulics.pump_compensator import PumpCompensator
from vvdp.hydraulics.relief_valve import ShockValve
from vvdp.hydraulics.variable_machine import SettingState, VariableMachine, drag_torque, slip_flow
from vvdp.hydraulics.variable_pump import SwivelState

BAR, RPM = 1e5, np.pi / 30.0
MEDIUM = Medium(density=870.0, viscosity=0.03)


def stiff(pressure):
    """Oil that does not yield, at a gauge pressure."""
    return FluidState(pressure + 101325.0, 1.0, 1e15, pressure)


MODEL = VariableMachine(
    displacement=1e-5, leakage_conductance=2e-12, shaft_damping=0.02, coulomb_torque=2.0, coulomb_speed=0.1,
    inertia=0.01, response_time=0.05, largest_rate=10.0, pressure_friction=0.03, laminar_slip=3e-9,
    turbulent_slip=1e-5, viscous_drag=2e5, kinetic_drag=0.3, setting_drag=0.2,
)  # fmt: skip
SPEEDS, PRESSURES, SETTINGS = np.linspace(50.0, 300.0, 6), np.linspace(100e5, 350e5, 6), np.linspace(0.4, 1.0, 4)


def measured(as_pump):
    """A table of the efficiencies that the loss model has on a test stand."""
    volumetric, mechanical = [], []
    for omega in SPEEDS:
        for drop in PRESSURES:
            leak = slip_flow(drop, MEDIUM, MODEL)
            for s in SETTINGS:
                drag = drag_torque(omega, drop, s, MEDIUM, MODEL)
                flow, torque = s * MODEL.displacement * omega, s * MODEL.displacement * drop
                volumetric.append((flow - leak) / flow if as_pump else flow / (flow + leak))
                mechanical.append(torque / (torque + drag) if as_pump else (torque - drag) / torque)
    return MeasuredMachine(
        displacement=MODEL.displacement,
        inertia=MODEL.inertia,
        coulomb_speed=MODEL.coulomb_speed,
        response_time=0.05,
        largest_rate=10.0,
        speeds=tuple(SPEEDS),
        pressures=tuple(PRESSURES),
        settings=tuple(SETTINGS),
        volumetric_efficiencies=tuple(volumetric),
        mechanical_efficiencies=tuple(mechanical),
    )


@pytest.mark.parametrize("as_pump", [True, False])
def test_a_measured_map_and_the_loss_model_that_it_was_taken_from_agree(as_pump):
    """Flow, torque and each loss within 1 % anywhere between the points, also overcentre and backwards."""
    table, rng = measured(as_pump), np.random.default_rng(36)
    law, model = (measured_pump, variable_pump) if as_pump else (measured_motor, variable_motor)
    for _ in range(60):
        omega, drop = rng.uniform(50.0, 300.0) * rng.choice([-1, 1]), rng.uniform(100e5, 350e5) * rng.choice([-1, 1])
        s = rng.uniform(0.4, 1.0) * rng.choice([-1, 1])
        ends = (stiff(max(-drop, 0.0)), stiff(max(drop, 0.0)), ShaftSpeed(omega), s, SettingState(s))
        found, expected = law(*ends, table), model(*ends, MEDIUM, MODEL)
        assert found[:3] == pytest.approx(expected[:3], rel=1e-2)
        assert found.losses[:2] == pytest.approx(expected.losses[:2], rel=1e-2)


def test_slip_and_drag_by_hand():
    """Each of Wilson's and Schloesser's terms alone."""
    bare = replace(
        MODEL, leakage_conductance=0.0, shaft_damping=0.0, coulomb_torque=0.0, pressure_friction=0.0,
        laminar_slip=0.0, turbulent_slip=0.0, viscous_drag=0.0, kinetic_drag=0.0, setting_drag=0.0,
    )  # fmt: skip
    # 1e-5 (1e-5 m^3)^(2/3) root(2 2e7 Pa/870 kg/m^3) = 1e-5 4.6416e-4 m^2 214.42 m/s
    turbulent = slip_flow(2e7, MEDIUM, replace(bare, turbulent_slip=1e-5))
    assert turbulent == pytest.approx(9.9526e-7, rel=1e-4)
    # 2e5 0.03 Pa s 1e-5 m^3 100/s, and 0.3 870 kg/m^3 (1e-5 m^3)^(5/3) 1e4/s^2
    assert drag_torque(100.0, 2e7, 0.4, MEDIUM, replace(bare, viscous_drag=2e5)) == pytest.approx(6.0, rel=1e-12)
    kinetic = drag_torque(-100.0, 2e7, 0.4, MEDIUM, replace(bare, kinetic_drag=0.3))
    assert kinetic == pytest.approx(-0.3 * 870.0 * 1e-5 * 4.641589e-4 * 1e4, rel=1e-6)
    for setting in (0.4, -0.4):  # as much for 0.75 at a setting of 0.4, either way
        stirred = drag_torque(-100.0, 2e7, setting, MEDIUM, replace(bare, setting_drag=0.75))
        assert stirred == pytest.approx(kinetic, rel=1e-12)


def test_power_of_a_machine_changes_its_sign_overcentre():
    """Into the shaft and out of it, at one speed and one pressure."""
    for law in (variable_motor, measured_motor):
        values = (MEDIUM, MODEL) if law is variable_motor else (measured(False),)
        powers = [
            law(stiff(2e7), stiff(0.0), ShaftSpeed(150.0), s, SettingState(s), *values).shaft * 150.0
            for s in (0.8, -0.8)
        ]
        assert powers[0] > 0.0 > powers[1]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            {"speeds": (100.0, 50.0, 150.0, 200.0, 250.0, 300.0)},
            "row 2, 477.465 rpm, must be greater than row 1, 954.93 rpm",
        ),
        ({"settings": (0.0, 0.5, 0.8, 1.0)}, "must be greater than 0: an efficiency at 0"),
        ({"volumetric_efficiencies": (0.9,)}, "1 values; expected 144"),
        ({"mechanical_efficiencies": (0.0,) * 144}, "must be greater than 0"),
    ],
)
def test_a_table_that_cannot_be_is_refused(change, told):
    with pytest.raises(ParameterError, match=told):
        replace(measured(True), **change)


ENGINE = DieselEngine(
    shaft_damping=0.0, coulomb_torque=20.0, coulomb_speed=1e-3, inertia=2.0, speed_band=10.0, rack_time=0.05,
    speeds=(80.0, 150.0, 230.0), full_torques=(300.0, 400.0, 360.0),
)  # fmt: skip
MOTOR = ElectricMotor(
    shaft_damping=0.0, coulomb_torque=0.0, coulomb_speed=1e-3, inertia=0.1, speed_band=10.0, reset_time=0.2,
    largest_torque=100.0, largest_power=15e3, copper_loss=900.0,
)  # fmt: skip


def test_an_engine_gives_its_curve_at_full_rack_and_drags_without_fuel():
    full = diesel_engine(ShaftSpeed(190.0), 200.0, RackState(0.0, 1.0), ENGINE)
    assert full.shaft == pytest.approx(380.0, rel=1e-9)
    assert full.rates == pytest.approx((0.0, 0.0))  # 10 rad/s below is the whole band
    dragged = diesel_engine(ShaftSpeed(210.0), 200.0, RackState(0.0, 0.0), ENGINE)
    assert dragged.shaft == pytest.approx(-20.0, rel=1e-9)
    assert dragged.supplied == 0.0


def test_a_motor_reaches_its_torque_and_beyond_a_speed_its_power():
    held = electric_motor(ShaftSpeed(100.0), 105.0, GovernorState(0.0), MOTOR)
    assert held.shaft == pytest.approx(50.0)
    assert held.losses.copper == pytest.approx(225.0)  # half the torque, a quarter of the loss
    assert held.supplied == pytest.approx(5225.0)
    assert held.rates.held == pytest.approx(0.5 / 0.2)
    fast = electric_motor(ShaftSpeed(300.0), 400.0, GovernorState(1.0), MOTOR)
    assert fast.shaft == pytest.approx(50.0) and fast.rates.held == pytest.approx(0.0)  # does not wind up
    braking = electric_motor(ShaftSpeed(100.0), 0.0, GovernorState(0.0), MOTOR)
    assert braking.shaft == pytest.approx(-100.0) and braking.supplied == pytest.approx(-9100.0)


def test_a_curve_without_a_torque_for_each_speed_is_refused():
    with pytest.raises(ParameterError, match="2 torques for 3 speeds"):
        replace(ENGINE, full_torques=(300.0, 400.0))


def test_a_compensator_takes_the_least_of_what_load_pressure_and_torque_allow():
    """100 bar of load ask for 120; 250 bar are the end; 300 bar times the displacement are more than 120 N m allow."""
    control = PumpCompensator(
        margin=20 * BAR, highest_pressure=250 * BAR + 101325.0, proportional_band=10 * BAR, reset_time=0.1,
        displacement=1e-5, largest_torque=120.0,
    )  # fmt: skip

    def setting(load, outlet):
        return pump_compensator(stiff(0.0), stiff(outlet), stiff(load), SwivelState(0.5), control).setting

    assert setting(100 * BAR, 120 * BAR) == pytest.approx(0.5)
    assert setting(100 * BAR, 118 * BAR) == pytest.approx(0.7)
    assert setting(245 * BAR, 251 * BAR) == pytest.approx(0.4)
    assert setting(245 * BAR, 245 * BAR) == pytest.approx(120.0 / (1e-5 * 245 * BAR))


SPOOL = ProportionalSpool(natural_frequency=0.0, response_time=0.02, largest_rate=1e4, hysteresis=0.04)


def test_a_spool_of_first_order_has_hysteresis_between_a_rising_and_a_falling_command():
    """Slowly up and down again, it stands 0.02 behind either way: 0.04 apart at the same command."""
    up = np.linspace(0.0, 0.8, 4001)
    spool, found = ValveSpool(0.0, 0.0), []
    for command in (*up, *up[::-1]):
        rates = spool_motion(spool_error(command, spool.position, 0.0, SPOOL), spool, SPOOL)
        spool = ValveSpool(spool.position + 2e-3 * rates.position, 0.0)
        found.append(spool.position)
    behind = 2e-4 / 2e-3 * 0.02  # the lag of a ramp: its rate times the time constant
    assert found[2000] == pytest.approx(0.4 - 0.02 - behind, abs=2e-4)
    assert found[-2001] == pytest.approx(0.4 + 0.02 + behind, abs=2e-4)
    assert spool_motion(0.1, ValveSpool(0.0, 0.0), SPOOL).position == pytest.approx(5.0)
    assert spool_motion(0.1, ValveSpool(0.0, 0.0), replace(SPOOL, largest_rate=3.0)).position == 3.0


def test_a_spool_is_of_first_or_of_second_order():
    with pytest.raises(ParameterError, match="or else 0 with a response_time"):
        replace(SPOOL, natural_frequency=50.0)
    with pytest.raises(ParameterError, match="must be greater than 0, or else"):
        replace(SPOOL, response_time=0.0)


CLOSED = {"overlap_pa": 0.1, "overlap_pb": 0.1, "overlap_at": 0.1, "overlap_bt": 0.1}
FIRST = {
    "conductance": 1e-7, "transition_pressure": 1e3, "natural_frequency": 0.0, "response_time": 0.02,
    "largest_rate": 100.0,
}  # fmt: skip
VALVE = FourWayValve(
    conductance=1e-7, transition_pressure=1e3, natural_frequency=50.0, largest_rate=100.0, flow_yield=2e-9, **CLOSED
)


@pytest.mark.parametrize(
    ("change", "joined"),
    [
        ({}, ""),
        ({"overlap_at": -0.1, "overlap_bt": -0.1}, "at bt"),
        ({"overlap_pa": -0.1, "overlap_pb": -0.1}, "pa pb"),
        ({"overlap_pa": -0.1, "overlap_pb": -0.1, "overlap_at": -0.1, "overlap_bt": -0.1}, "pa pb at bt"),
        ({"bypass_conductance": 2e-7, "bypass_travel": 0.1}, "bypass"),
    ],
    ids=["closed", "float", "regenerative", "open", "tandem"],
)
def test_centre_positions(change, joined):
    """Which ways are open in the middle, and how much the pump is lost there."""
    valve = replace(VALVE, **change)
    edges = four_edges(0.0, valve)._asdict()
    passed = {**dict.fromkeys(edges, valve.conductance), "bypass": valve.bypass_conductance}
    assert {name for name, y in edges.items() if y * passed[name] > 0.0} == set(joined.split())
    low = stiff(0.0)
    flows = four_way_valve(stiff(100 * BAR), low, low, low, 0.0, ValveSpool(0.0, 0.0), valve)
    past = 2e-7 * np.sqrt(100 * BAR) if joined == "bypass" else 0.0
    assert flows.tank == pytest.approx(past, rel=1e-8)  # the root law is short by (eps/2 dp)^2


def test_flow_forces_push_a_spool_back():
    """What is missing of the command at rest: 2e-9 1/Pa times the opening and 100 bar, over two edges."""
    at = ValveSpool(0.96, 0.0)
    wide = replace(VALVE, overlap_pa=-0.9, overlap_bt=-0.9)
    loaded = four_way_valve(stiff(2e7), stiff(0.0), stiff(1e7), stiff(1e7), 1.0, at, wide)
    assert 1.0 - (loaded.rates.wanted_rate / (2.0 * np.pi * 50.0) ** 2 + 0.96) == pytest.approx(
        2e-9 * 2e7 * (0.96 + 0.9) / 1.9, rel=1e-9
    )


def test_a_six_way_valve_sends_the_pump_on_until_it_is_moved():
    valve = SixWayValve(
        bypass_conductance=2e-7, bypass_travel=0.5, **FIRST, **CLOSED,
    )  # fmt: skip
    high, low = stiff(1e6), stiff(0.0)

    def flows(position):
        return six_way_valve(high, low, low, low, high, low, 0.0, ValveSpool(position, 0.0), valve)

    assert flows(0.0).onward == pytest.approx(2e-7 * 1e3, rel=1e-6) and flows(0.0).a == 0.0
    assert flows(0.25).onward == pytest.approx(1e-7 * 1e3, rel=1e-6)
    assert flows(-1.0).onward == 0.0 and flows(-1.0).b == pytest.approx(1e-7 * 1e3, rel=1e-6)
    with pytest.raises(ParameterError, match="bypass_conductance"):
        replace(valve, bypass_conductance=0.0)


@pytest.mark.parametrize(("position", "joined"), [(0.0, "tank"), (0.6, "a"), (-0.6, "b")])
def test_a_load_sensing_port_has_the_pressure_of_the_side_that_is_fed(position, joined):
    """No oil flows at the port where its pressure is that one, and some at any other."""
    valve = SensingValve(
        bypass_travel=0.05, sensing_conductance=1e-8, **FIRST, **CLOSED,
    )  # fmt: skip
    ends = {"tank": stiff(0.0), "a": stiff(1e7), "b": stiff(5e6)}
    for name, sensed in ends.items():
        flows = load_sensing_valve(
            stiff(2e7), ends["tank"], ends["a"], ends["b"], sensed, 0.0, ValveSpool(position, 0.0), valve
        )
        assert (flows.sensing == 0.0) == (name == joined)


POPPET = PoppetValve(
    seat_diameter=0.01, cone_angle=0.5 * np.pi, largest_lift=1e-3, preload=0.25 * np.pi * 1e-4 * 1e7,
    stiffness=1e5, poppet_friction=0.25 * np.pi * 1e-4 * 2e5, opening_time=2e-3, closing_time=8e-3,
)  # fmt: skip


def test_a_poppet_by_its_measures():
    """Cracks at 100 bar; on a flat seat the spring alone counts: (dp - 100 bar) A/k, up to 1 mm at 112.7 bar."""
    area = 0.25 * np.pi * 1e-4
    assert free_lift(105 * BAR, 0.0, POPPET) == pytest.approx(area * 5e5 / 1e5, rel=1e-12)
    assert lift_range(200 * BAR, POPPET) == (1e-3, 1e-3) and lift_range(-200 * BAR, POPPET) == (0.0, 0.0)
    steep = replace(POPPET, cone_angle=0.25 * np.pi)
    # the jet adds pi d C dp to the spring: 0.0314 m 0.61 1.05e7 Pa = 201 N/mm on 100 N/mm
    assert free_lift(105 * BAR, 0.0, steep) == pytest.approx(
        area * 5e5 / (1e5 + np.pi * 0.01 * 0.61 * 1.05e7), rel=1e-12
    )


def test_friction_holds_a_poppet_and_it_closes_slower_than_it_opens():
    """2 bar of friction either way: from 103 to 107 bar nothing moves; at 110 and at 100 bar it does."""
    lift = free_lift(105 * BAR, 0.0, POPPET)

    def rate(pressure):
        return poppet_valve(stiff(pressure), stiff(0.0), LiftState(lift), MEDIUM, POPPET).rates.lift

    assert rate(103.1 * BAR) == 0.0 and rate(106.9 * BAR) == 0.0
    step = free_lift(110 * BAR, 0.0, POPPET) - free_lift(107 * BAR, 0.0, POPPET)
    assert rate(110 * BAR) == pytest.approx(step / 2e-3, rel=1e-9)
    assert rate(100 * BAR) == pytest.approx(-step / 8e-3, rel=1e-9)
    with pytest.raises(ParameterError, match="opening_time"):
        replace(POPPET, opening_time=0.0)


def test_relief_and_check_valves_close_in_a_time_of_their_own_and_open_so_far_only():
    relief = ShockValve(
        cracking_pressure=1e7, override_pressure=1e6, rated_flow=1e-3, opening_time=2e-3, closing_time=5e-3,
        largest_opening=1.5,
    )  # fmt: skip
    far = FluidState(1.3e7, 1.0, 1e15, 1.3e7)  # 30 bar above: 3 times its rated opening
    assert shock_valve(far, stiff(0.0), 1.0, OpeningState(0.5), relief).rates.opening == pytest.approx(1.0 / 2e-3)
    assert shock_valve(far, stiff(0.0), 1.0, OpeningState(2.0), relief).rates.opening == pytest.approx(-0.5 / 5e-3)
    check = CheckValve(cracking_pressure=0.0, rated_drop=1e5, rated_flow=1e-3, opening_time=1e-3, closing_time=4e-3)
    assert check_valve(stiff(0.0), stiff(1e5), OpeningState(1.0), check).rates.opening == pytest.approx(-250.0)
    assert check_valve(stiff(1e5), stiff(0.0), OpeningState(0.0), check).rates.opening == pytest.approx(1000.0)
    with pytest.raises(ParameterError, match="closing_time"):
        replace(check, opening_time=0.0)
