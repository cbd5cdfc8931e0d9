"""docs/small-circuits.md: each file runs, its balances close, and it gives what follows by hand."""

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from vvdp.base.tables import Table
from vvdp.evaluation.summary import Summary, summary
from vvdp.evaluation.validity import broken_bounds
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import built_system, load_system

PAGE = (Path(__file__).parents[2] / "docs" / "small-circuits.md").read_text("utf-8")


class Done(NamedTuple):
    """A run and its summary."""

    run: Run
    found: Summary
    broken: list[str]


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Runs the file of a section of the page, with settings."""
    folder = tmp_path_factory.mktemp("circuits")

    @cache
    def done(title: str, *settings: str) -> Done:
        text = re.search(rf"^## {title}\n.*?```toml\n(.*?)```", PAGE, re.MULTILINE | re.DOTALL)[1]
        path = folder / f"{re.sub(r'[^a-z]+', '-', title.lower())}.toml"
        path.write_text(text, "utf-8")
        system = load_system(str(path), list(settings))
        run = simulate(system.model, system.case, system.stepping)
        found = summary(system, run)
        return Done(run, found, broken_bounds(system, found))

    return done


def check_closed(done: Done) -> None:
    """Both balances of a run close."""
    assert max(abs(done.found["energy_residual"]), abs(done.found["mass_residual"])) < 1e-6


def test_tank_cooler_filter(ran):
    done = ran("Tank, cooler, filter")
    check_closed(done)
    assert not done.broken
    end = done.run.outputs
    assert end.tank_level[-1] == pytest.approx(0.4 - 6 / 6e4 * 120 / 0.1, abs=5e-5)
    assert done.run.state.filter.clogging[-1] == pytest.approx(0.5, abs=5e-4)
    drop = done.run.state.between[-1] - done.run.state.behind[-1]
    assert drop == pytest.approx(2e5, rel=1e-3)
    assert done.found["level_min_tank_m"] == pytest.approx(end.tank_level[-1])


def test_a_tank_that_runs_dry_is_told(ran):
    covered = ran("Tank, cooler, filter", "components.drain.flow=40 lpm", "run.until=47 s")
    assert not covered.broken
    dry = ran("Tank, cooler, filter", "components.drain.flow=40 lpm", "run.until=48 s")
    assert not dry.found["within_validity"]
    assert any("its suction runs dry" in sentence for sentence in dry.broken)


def test_square_wave(ran):
    done = ran("A square wave in a line")
    check_closed(done)
    assert not done.broken
    assert done.found["pressure_max_end_Pa"] == pytest.approx(200e5, rel=2e-3)
    end = done.run.state.end - 101325.0 - 150e5
    assert np.sum(np.diff(np.sign(end)) != 0) == 12
    first = done.run.times > 25e-3
    assert np.min(done.run.state.end[first]) - 101325.0 == pytest.approx(100e5, rel=2e-3)


def test_gas_fast_and_slowly(ran):
    title = "Compressing a gas fast and slowly"
    done, quick = ran(title), ran(title, "components.accumulator.heat_time=1000 s")
    for each in (done, quick):
        check_closed(each)
    first = 1e7 + 101325.0
    V = 1e-3 / done.run.state.accumulator.compression[-1]
    assert pytest.approx(0.604e-3, abs=5e-7) == V
    assert done.run.state.line[-1] == pytest.approx(first * 1e-3 / V, rel=1e-3)
    assert done.run.state.accumulator.gas_temperature[-1] == pytest.approx(293.15, abs=0.1)
    least = 1e-3 / np.max(quick.run.state.accumulator.compression)
    assert quick.found["pressure_max_line_Pa"] + 101325.0 == pytest.approx(first * (1e-3 / least) ** 1.4, rel=1e-3)
    real = ran(title, "components.accumulator.real_gas=1")
    check_closed(real)
    assert real.run.state.line[-1] == pytest.approx(170.3e5 + 101325.0, rel=1e-3)


def test_behind_a_piston(ran):
    done = ran("Behind a piston")
    check_closed(done)
    P0, P = 101325.0, 150e5 + 101325.0
    V = (100e5 + P0) * 1e-3 / P
    assert done.run.state.piston.position[-1] == pytest.approx((1e-3 - V) / 5e-3, rel=1e-3)
    assert done.run.state.spring_piston.position[-1] == pytest.approx(0.05, rel=1e-3)


G = 9.80665


def test_winch(ran):
    done = ran("A winch")
    check_closed(done)
    rise = 0.2 * 2.0 * np.pi
    assert done.found["velocity_mean_load_m_s"] == pytest.approx(rise, rel=1e-4)
    assert done.found["power_shaft_W"] == pytest.approx(500.0 * G * rise, rel=1e-4)


def test_arm(ran):
    done = ran("An arm")
    check_closed(done)
    angle = done.run.state.joint.angle[-1]
    length = 0.5 * np.sqrt(2.0 - 2.0 * np.cos(angle))
    force = 2000.0 / (0.25 * np.sin(angle) / length)
    assert done.run.state.chamber[-1] - 101325.0 == pytest.approx(force / 2e-3, rel=1e-4)
    assert force / 2e-3 == pytest.approx(28.3e5, rel=2e-3)


def test_friction_that_sticks(ran):
    done = ran("Friction that sticks")
    check_closed(done)
    times, body = done.run.times, done.run.state.body
    held = (times > 2.0) & (times < 99.9)
    assert np.max(np.abs(body.position[held] - 90e-6)) < 1e-12
    assert body.velocity[-1] == pytest.approx(10.0 * 0.1, rel=0.02)


def test_telescope(ran):
    done = ran("A telescope")
    check_closed(done)
    v = np.interp((8.0, 14.0), done.run.times, done.run.state.lift.velocity)
    thinner = np.exp(-np.array((19.8e5, 40.0e5)) / 1.4e9)  # compressed by that
    assert v == pytest.approx(thinner * (0.01, 0.02), rel=2e-4)
    assert done.run.state.chamber[-1] - 101325.0 == pytest.approx((1000.0 * G + 200.0) / 2.5e-3, rel=2e-3)


def test_cushion(ran):
    done = ran("A cushion")
    check_closed(done)
    rod = done.run.state.rod
    before = np.interp(0.04, rod.position[::-1], rod.velocity[::-1])
    creep = 0.61 * 2e-6 * np.sqrt(2.0 * 1e7 / 870.0) / 2e-3
    assert -before == pytest.approx(10.0 * creep, rel=5e-3)
    assert -rod.velocity[-1] == pytest.approx(creep, rel=5e-3)


def test_vehicle_that_rolls_out(ran):
    done = ran("A vehicle that rolls out")
    check_closed(done)
    slower = 0.01 * 2000.0 * G / (2000.0 + (2.0 + 9.0 * 1.0) / 0.09)
    assert done.run.state.vehicle.velocity[-1] == pytest.approx(10.0 - 20.0 * slower, rel=1e-4)
    assert done.run.state.flywheel.speed[-1] == pytest.approx(3.0 * done.run.state.axle.speed[-1], rel=1e-3)


def test_lever(ran):
    done = ran("A lever")
    check_closed(done)
    assert done.run.state.long.position[-1] == pytest.approx(10e-3, rel=1e-5)
    assert done.run.state.short.position[-1] == pytest.approx(11e-3 / 3.0, rel=1e-5)


def test_actual_flow_is_the_one_at_the_ports_pressure(ran):
    """Into the line at 1.8 bar the oil's modulus makes exp(-1.8 bar/1.4 GPa) of the tank volumes; at the tank none."""
    done = ran("Tank, cooler, filter", "components.pump.flow=60 lpm", "oil.liquid_bulk_modulus=10 MPa")
    found = done.found
    line = done.run.state.line - 101325.0
    t = done.run.times
    inside = t >= done.found["averaged_from_s"]
    thinner = np.trapezoid(np.exp(-line[inside] / 1e7), t[inside]) / np.ptp(t[inside])
    ratio = found["flow_actual_mean_pump_m3_s"] / found["flow_mean_pump_m3_s"]
    assert ratio == pytest.approx(thinner, rel=1e-4)
    assert ratio < 0.99
    assert found["flow_actual_mean_drain_m3_s"] == pytest.approx(found["flow_mean_drain_m3_s"], rel=1e-12)


def test_a_closed_box_warms_by_its_loss_over_its_heat_capacity(ran):
    done = ran("A closed box that warms")
    check_closed(done)
    state, P0, oil = done.run.state, 101325.0, 876.0 * 1900.0
    # Tank volumes of the oil in each: V exp((P - P0)/b), b of the usual oil.
    held = {name: 1e-3 * np.exp((getattr(state, name)[-1] - P0) / 1.4e9) for name in ("low", "high")}
    rise = {name: getattr(done.run.outputs, f"{name}_temperature")[-1] - 313.15 for name in held}
    mean = sum(held[name] * rise[name] for name in held) / sum(held.values())
    lost = state.books.spent.orifice[-1] - state.books.spent.orifice[0]
    assert mean == pytest.approx(lost / (oil * sum(held.values())), rel=1e-6)
    assert mean == pytest.approx(7.744, abs=1e-3)
    assert abs(done.found["heat_residual"]) < 1e-8
    assert done.found["temperature_max_low_K"] == pytest.approx(313.15 + rise["low"])
    # Half of what the orifice gives is carried on to the other volume.
    assert rise["low"] - rise["high"] == pytest.approx(0.5 * lost / 60.0 * 6e4 / 20.0 / oil, rel=0.01)


def test_heat_that_the_oil_brings_and_takes_is_in_the_balance(ran):
    """Through walls, and in and out of a tank at another temperature."""
    done = ran(
        "Tank, cooler, filter", "heat.start_temperature=40 degC", "heat.wall_conductance=5 W/K", "run.until=20 s"
    )
    check_closed(done)
    assert abs(done.found["heat_residual"]) < 1e-8
    assert done.found["heat_outside_W"] != 0.0
    assert done.found["heat_walls_W"] > 0.0


def test_a_ring_with_a_cooler(ran):
    done = ran("A ring with a cooler")
    check_closed(done)
    assert abs(done.found["heat_residual"]) < 1e-8
    over = done.run.outputs.low_temperature[-1] - 293.15
    assert over == pytest.approx(done.found["power_pump_W"] / 100.0, rel=1e-3)


LPM, BAR = 1e-3 / 60.0, 1e5


def tank_volumes(flow, pressure):
    """Tank volumes of a flow [m^3/s] at a gauge pressure, of the oil without air."""
    return flow * np.exp(pressure / 1.4e9)


def test_brake_valve(ran):
    """y Q_r root(P/P_r) = Q with 94.2 bar between outlet and inlet; the shaft takes the torque of its drop."""
    done = ran("A motor behind a brake valve")
    check_closed(done)
    assert not done.broken
    drop = 30.0 * 2.0 * np.pi / 20e-6
    # Actual flows: what the pump gives at the inlet, and thinner by the drop at the outlet.
    feed = brentq(lambda P: (P / BAR - 20.0) / 40.0 * np.sqrt((P + drop) / BAR / 80.0) - 1.0, 20 * BAR, 60 * BAR)
    assert feed == pytest.approx(49.8 * BAR, abs=0.02 * BAR)
    found = done.found
    assert found["speed_mean_swing_rad_s"] == pytest.approx(1000.0 * np.pi / 30.0, rel=1e-3)
    assert found["pressure_mean_feed_Pa"] == pytest.approx(feed, rel=5e-3)
    assert found["pressure_mean_braked_Pa"] - found["pressure_mean_feed_Pa"] == pytest.approx(drop, rel=5e-4)


def test_sections_share_a_pump(ran):
    done = ran("Sections that share a pump")
    check_closed(done)
    found, K = done.found, 4e-7 * np.sqrt(BAR) / LPM

    def section(line, share, load):
        """Flow [l/min] at a pump pressure [bar]: throttle and compensator in series."""

        def surplus(between):
            opening = min(0.5 * (between - 102.0), 1.0)
            return 120.0 * opening * np.sqrt((between - load) / 5.0) - share * K * np.sqrt(line - between)

        return share * K * np.sqrt(line - brentq(surplus, 102.0, line))

    line = brentq(lambda P: section(P, 0.5, 60.0) + section(P, 1.0, 100.0) - 30.0, 105.0, 130.0)
    small, large = found["flow_mean_small_throttle_m3_s"], found["flow_mean_large_throttle_m3_s"]
    assert small / (small + large) == pytest.approx(section(line, 0.5, 60.0) / 30.0, rel=5e-4)
    assert found["pressure_mean_line_Pa"] == pytest.approx(line * BAR, rel=1e-3)
    for load in (60.0, 120.0):
        alone = ran("Sections that share a pump", f"nodes.light.pressure={load:g} bar").found
        drop = brentq(
            lambda d, at=load: 60.0 * 0.5 * (9.0 - d) * np.sqrt((200.0 - at - d) / 5.0) - K * np.sqrt(d), 7.0, 9.0
        )
        expected = tank_volumes(K * LPM * np.sqrt(drop), (load + drop) * BAR)
        assert alone["flow_mean_throttle_m3_s"] == pytest.approx(expected, rel=2e-3)


def test_priority_and_logic_valve(ran):
    done = ran("Priority and a logic valve")
    check_closed(done)
    found = done.found
    gauge = {name: found[f"pressure_mean_{name}_Pa"] / BAR for name in ("line", "first", "rest", "second")}
    # The spool stands where the drop over the throttle says; both its edges follow from that.
    y = 0.5 * (gauge["first"] - 80.0 - 7.0)
    rest = 80.0 * LPM * y * np.sqrt((gauge["line"] - gauge["rest"]) / 5.0)
    first = 2.5e-7 * np.sqrt((gauge["first"] - 80.0) * BAR)
    line, ahead = gauge["line"] * BAR, gauge["first"] * BAR
    assert found["flow_mean_logic_m3_s"] == pytest.approx(tank_volumes(rest, line), rel=1e-3)
    assert found["flow_mean_throttle_m3_s"] == pytest.approx(tank_volumes(first, ahead), rel=1e-3)
    assert first + rest == pytest.approx(40.0 * LPM, rel=5e-3)
    assert first == pytest.approx(12.7 * LPM, rel=2e-3)
    behind = brentq(lambda P: 80.0 * (P - 18.0) / 4.0 * np.sqrt(P / 5.0) - rest / LPM, 18.0, 22.0)
    assert gauge["rest"] == pytest.approx(behind, rel=3e-3)
    held = brentq(lambda P: 40.0 * (P - 30.5) / 4.5 * np.sqrt(P / 5.0) - 5.0, 30.5, 35.0)
    assert gauge["second"] == pytest.approx(held, rel=1e-4)


def test_measured_machines(ran):
    done = ran("A pump and a motor with measured efficiencies")
    check_closed(done)
    assert not done.broken
    found, omega = done.found, 50.0 * np.pi
    assert found["flow_mean_pump_m3_s"] == pytest.approx(0.94 * 60.0 * LPM, rel=1e-3)
    assert found["power_drive_W"] == pytest.approx(40e-6 / (2.0 * np.pi) * 200.0 * BAR * omega / 0.93, rel=1e-3)
    # taken in under 200 bar: 1 % of oil that yields by 20 GPa
    assert found["flow_mean_motor_m3_s"] == pytest.approx(30.0 / 0.88 * LPM * (1.0 + 200.0 * BAR / 20e9), rel=1e-3)
    assert found["power_axle_W"] == pytest.approx(-0.88 * 0.5 * 40e-6 / (2.0 * np.pi) * 200.0 * BAR * omega, rel=1e-3)


SHORT = ("run.until=0.3 s", "run.average_from=0 s", "run.record_interval=1 ms")


def test_engine_and_motor_under_load(ran):
    done = ran("An engine and a motor under load")
    check_closed(done)
    assert not done.broken
    found, rpm = done.found, np.pi / 30.0
    assert found["speed_mean_crank_rad_s"] == pytest.approx(1750.0 * rpm, rel=1e-6)
    assert found["speed_mean_axle_rad_s"] == pytest.approx(1800.0 * rpm, rel=1e-6)
    assert found["power_motor_W"] == pytest.approx(200.0 * 1800.0 * rpm + 2e3, rel=1e-6)
    over = ran("An engine and a motor under load", "components.on_engine.torque=-500 N*m", *SHORT)
    falls = (-500.0 + 400.0) / 2.0  # once its rack is open the whole curve is not enough
    speed = over.run.state.crank.speed
    assert (speed[-1] - speed[-21]) / (over.run.times[-1] - over.run.times[-21]) == pytest.approx(falls, rel=0.1)


def test_load_sensing_pump_and_valve(ran):
    done = ran("A load-sensing pump and valve")
    check_closed(done)
    assert not done.broken
    at = np.searchsorted(done.run.times, 4.9)
    gauge = (done.run.state.supply - 101325.0) / BAR
    assert gauge[at] == pytest.approx(120.0, rel=1e-6) and gauge[-1] == pytest.approx(20.0, rel=1e-6)
    passed = 0.5 * 6e-7 * np.sqrt(20.0 * BAR)
    assert done.run.outputs.valve_a_flow[at] == pytest.approx(tank_volumes(passed, 120.0 * BAR), rel=1e-4)
    heavy = ("components.valve.command=1", "nodes.load.pressure=220 bar", "nodes.supply.start=235 bar", "run.until=5 s")
    limited = ran("A load-sensing pump and valve", *heavy)
    check_closed(limited)
    assert -limited.run.outputs.pump_shaft[-1] == pytest.approx(120.0, rel=1e-9)
    assert limited.run.state.supply[-1] < 240.0 * BAR


def test_open_centre(ran):
    done = ran("An open centre")
    check_closed(done)
    assert not done.broken
    gauge = (done.run.state.supply - 101325.0) / BAR
    over = (40.0 * LPM / 1e-6) ** 2 / BAR
    assert gauge[np.searchsorted(done.run.times, 1.9)] == pytest.approx(over, rel=1e-4)
    assert gauge[-1] == pytest.approx(50.0 + over, rel=1e-4)


def test_relief_valve_by_its_measures(ran):
    done = ran("A relief valve by its measures")
    check_closed(done)
    assert not done.broken
    d, sine = 8e-3, np.sin(0.25 * np.pi)
    area = 0.25 * np.pi * d * d

    def lift(p):
        return (area * p - 500.0) / (50e3 + np.pi * d * 0.61 * p)

    def surplus(p):
        return 0.61 * np.pi * d * sine * lift(p) * np.sqrt(2.0 * p / 876.0) - 20.0 * LPM

    held = brentq(surplus, 500.0 / area, 150.0 * BAR)
    assert done.found["pressure_mean_supply_Pa"] == pytest.approx(held, rel=1e-4)
    assert done.run.state.valve.lift[-1] == pytest.approx(lift(held), rel=1e-3)


def test_without_a_heat_balance_nothing_is_written_of_heat():
    text = re.search(r"^## A closed box that warms\n.*?```toml\n(.*?)```", PAGE, re.MULTILINE | re.DOTALL)[1]
    content = tomllib.loads(text)
    warm = built_system(Table("warm", content, {}), "warm")
    cold = built_system(Table("cold", {key: value for key, value in content.items() if key != "heat"}, {}), "cold")
    assert "heat" not in cold.circuit.text and "warm" not in cold.circuit.text
    assert "warm_medium" in warm.circuit.text
