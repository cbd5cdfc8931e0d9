"""Systems at and beyond the edge of what is plausible: they run, their books balance, and what is odd is reported."""

import numpy as np
import pytest

from vvdp.simulation.values import leaves

ORIFICE, SOURCE = "prototype", "prototype-constant-load"

BOTH = {
    "small inlet": ["inlet.volume=3.7 cc"],
    "hard relief valve": ["relief_valve.override_pressure=0.1 bar"],
    "slow relief valve": ["relief_valve.override_pressure=10 bar", "relief_valve.opening_time=2 ms"],
    "hardly any air": ["oil.air_fraction=0.1 %"],
    "foam": ["oil.air_fraction=30 %"],
    "duty 0": ["operation.duty_ratio=0"],
    "duty 1": ["operation.duty_ratio=1"],
    "duty below 0": ["operation.duty_ratio=-0.3"],
    "duty above 1": ["operation.duty_ratio=1.3"],
    "ports shut in between": ["valve.lap_ratio=1.3"],
    "slow check valve": ["check_valve.reverse_opening=0", "check_valve.opening_time=3 ms"],
    "choking nozzles": ["valve.pressure_recovery=0.7", "oil.vapour_pressure=0.1 bara"],
    "pump stopped": ["operation.pump_speed=0 rpm"],
    "pressure in the tank": ["operation.tank_pressure=5 bar"],
    "vacuum in the tank": ["operation.tank_pressure=-0.3 bar"],
    "pump with losses": [
        "pump.leakage_conductance=2e-12 m^3/(s*Pa)",
        "pump.ripple_amplitude=0.03",
        "pump.friction_torque=2 N*m",
    ],
}
ORIFICE_ONLY = {
    "small line": ["load_line.oil_volume=20 cc", "load_line.gas_volume=0 cc"],
    "load pulsing around the precharge": ["load_line.precharge_pressure=99 bar"],
    "throttle nearly shut": ["load.area=0.01 mm^2"],
    "throttle wide open": ["load.area=200 mm^2"],
    "stiff small line": [
        "load_line.oil_volume=20 cc", "load_line.gas_volume=0 cc", "load_line.hose_compliance=0 1/Pa",
        "load.area=20 mm^2",
    ],
    "all of these": [
        "inlet.volume=3.7 cc", "load_line.oil_volume=20 cc", "load_line.gas_volume=0 cc", "load.area=0.01 mm^2",
        "relief_valve.override_pressure=0.1 bar",
    ],
}  # fmt: skip
SOURCE_ONLY = {
    "load at a vacuum": ["load.pressure=-0.9 bar"],
    "load above the relief setting": ["load.pressure=150 bar"],
    "both at a vacuum": [
        "load.pressure=-0.95 bar", "operation.tank_pressure=-0.9 bar", "operation.pump_speed=0 rpm",
    ],
}  # fmt: skip
# Signals with corners: each shape is compiled once more.
MOVING = {
    "tank pressure jumps": ['operation.tank_pressure={step=["0 bar","3 bar"],at="0.0503 s"}'],
    "oil warms": ['operation.oil_temperature={ramp=["20 degC","60 degC"],from="0.02 s",to="0.2 s"}'],
    "pump stops": ['operation.pump_speed={ramp=["1800 rpm","0 rpm"],from="0.05 s",to="0.1 s"}'],
}
CASES = [
    *((name, label) for label in BOTH for name in (ORIFICE, SOURCE)),
    *((ORIFICE, label) for label in ORIFICE_ONLY),
    *((SOURCE, label) for label in SOURCE_ONLY),
]
SETTINGS = {**BOTH, **ORIFICE_ONLY, **SOURCE_ONLY, **MOVING}


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("name", "label"), [*CASES, *((SOURCE, label) for label in MOVING)])
def test_books_balance(name, label, ran):
    found, run = ran(name, SETTINGS[label], "0.2 s")
    assert run.finished and run.end == 0.2
    assert abs(found["energy_residual"]) < 1e-6
    assert abs(found["mass_residual"]) < 1e-6
    assert found["second_law"]
    assert found["trusted"] or not found["within_validity"]
    assert np.all(np.isfinite(run.states))
    unknown = {key for key, value in found.items() if not np.isfinite(value)}
    assert unknown <= {"efficiency", "loss_transition_W"}
    low = dict(zip((path for path, _, _ in leaves(run.case.state)), run.low, strict=True))
    assert low["inlet"] > 0.0  # absolute


@pytest.mark.slow
@pytest.mark.parametrize(("name", "label"), [(ORIFICE, label) for label in MOVING])
def test_books_balance_with_moving_operation(name, label, ran):
    test_books_balance(name, label, ran)


def test_nothing_cavitates_as_shipped(ran):
    for name in (ORIFICE, SOURCE):
        found, _ = ran(name, [], "0.2 s")
        assert not found["cavitation_volume"]


def test_vacuum_at_the_inlet_is_reported_and_not_clamped(ran):
    """The pump stands, the load draws: the inlet goes down to the load's 0.063 bar absolute, below the 0.3 bar of the
    limit, and is shown there."""
    settings = ["operation.pump_speed=0 rpm", "load.pressure=-0.95 bar", "operation.duty_ratio=1.3"]
    found, _ = ran(SOURCE, settings, "0.2 s")
    assert found["cavitation_volume"]
    assert found["pressure_min_inlet_Pa"] == pytest.approx(-0.95e5, abs=200.0)
    assert found["second_law"] and not found["within_validity"] and not found["trusted"]


def test_vacuum_at_the_load_is_reported(ran):
    """The load line, emptied into a tank at a vacuum while the spool gives it nothing."""
    settings = [
        "operation.tank_pressure=-0.9 bar",
        "operation.duty_ratio=-0.4",
        "initial.load_pressure=0.5 bar",
        "load.area=200 mm^2",
    ]
    found, _ = ran(ORIFICE, settings, "0.2 s")
    assert found["pressure_min_load_line_Pa"] < -0.7e5
    assert found["cavitation_volume"]
    assert found["second_law"] and not found["within_validity"] and not found["trusted"]


def test_load_above_the_relief_setting_drives_oil_back(ran):
    """150 bar against 120 bar: the source feeds the relief valve and the tank."""
    found, _ = ran(SOURCE, ["load.pressure=150 bar"], "0.2 s")
    assert found["mean_load_flow_m3_s"] < 0.0
    assert found["load_power_W"] < 0.0
    assert found["flow_mean_relief_valve_m3_s"] > 0.0


def test_blocked_ports_send_the_whole_flow_over_the_relief_valve(ran):
    """With overlap there is a dwell with both ports shut; the ideal relief valve then holds its setting."""
    found, run = ran(SOURCE, ["valve.lap_ratio=1.3"], "0.2 s")
    assert found["pressure_max_inlet_Pa"] == pytest.approx(120e5, rel=1e-4)
    out = run.outputs
    assert np.any((out.valve_load_opening == 0.0) & (out.valve_tank_opening == 0.0))


def test_slow_relief_valve_lets_the_pressure_overshoot(ran):
    """2 ms is long against the 0.4 ms in which 40 lpm take 12.7 cc from 120 to 200 bar."""
    found, _ = ran(SOURCE, SETTINGS["slow relief valve"], "0.2 s")
    assert found["pressure_max_inlet_Pa"] > 150e5
