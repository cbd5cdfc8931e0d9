"""The axial drives as shipped systems: what their runs show, and what is refused with its line."""

from functools import cache

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import parsed_table, with_settings
from vvdp.evaluation.summary import summary
from vvdp.sensing.axial_sensor import pollution_at
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, built_system, load_system, shipped_systems

pytestmark = pytest.mark.heavy

NAMES = ("axial-chamber", "axial-gerotor")
BY_COMMAND = """
[components.drive.gerotor]
command = { table = [["0 s", "0"], ["0.05 s", "0"], ["0.05 s", "0.05"], ["0.2 s", "0.05"], ["0.2 s", "1"],
  ["0.9 s", "1"], ["0.9 s", "-1"]] }
[run]
until = "1.2 s"
average_from = "0.2 s"
"""
"""The gerotor drive without its control: inside the dead band, forward to its end, and back."""


CURVE = '["96 %", "76 %", "80 %", "36 %", "16 %"]'
CHAMBER_COMMAND = """
[components.drive.pilot_valve]
command = { table = [["0 s", "0"], ["0.05 s", "0"], ["0.05 s", "0.2"], ["0.15 s", "0.2"], ["0.15 s", "0"],
  ["0.5 s", "0"], ["0.5 s", "-0.02"], ["0.51 s", "-0.02"], ["0.51 s", "0"], ["0.7 s", "0"], ["0.7 s", "-1"]] }
[run]
until = "1 s"
average_from = "0.2 s"
"""
"""The chamber drive without its control: filled, shut, let out a little, and at 0.7 s de-energised."""


def by_command(name: str) -> str:
    """A shipped drive on a prescribed command."""
    text = shipped_systems()[name]
    return text[: text.index("[run]")] + (CHAMBER_COMMAND if name == "axial-chamber" else BY_COMMAND)


def loaded(name: str, settings: tuple[str, ...] = ()) -> System:
    return built_system(with_settings(parsed_table(by_command(name), name), list(settings)), name)


@cache
def done(name: str, *settings: str) -> tuple[dict, Run]:
    system = loaded(name, settings)
    run = simulate(system.model, system.case, system.stepping)
    return summary(system, run), run


def refusal(text: str, tmp_path) -> str:
    path = tmp_path / "own.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(ConfigError) as refused:
        load_system(str(path))
    return str(refused.value)


@pytest.mark.parametrize("name", NAMES)
def test_runs_and_is_to_be_trusted(name):
    found, _ = done(name)
    assert found["trusted"]
    assert abs(found["energy_residual"]) < 1e-7
    assert abs(found["mass_residual"]) < 1e-7


@pytest.mark.parametrize("name", NAMES)
def test_every_value_says_where_it_comes_from(name):
    assert [row.key for row in load_system(name).rows if row.status == "given" and row.table != "run"] == []


def test_chamber_shuts_holds_and_lets_go():
    """Shut at 0.15 s the chamber holds the spool, which has come to rest by 0.49 s; 5.9 ms without current suffice."""
    _, run = done("axial-chamber")
    x, t = run.state.drive_slide.position, run.times
    assert np.ptp(x[(t > 0.45) & (t < 0.5)]) < 0.1e-3
    assert x[t < 0.5][-1] == pytest.approx(5.0e-3, abs=0.1e-3)
    assert np.all(x[t > 0.7075] < 0.0)
    assert x[-1] == pytest.approx(-6.21e-3, abs=2e-5)


def test_pressure_at_which_the_spring_lets_go():
    """Between -6.2 mm, (211.5 - 2594 x 6.2e-3)/174 mm^2 = 11.23 bar, and 12.16 bar at position 0."""
    _, run = done("axial-chamber")
    x, gauge = run.state.drive_slide.position, run.state.drive_pilot_chamber - 101325.0
    leaves = np.argmax(x > -6.2e-3)
    assert gauge[leaves - 1] / 1e5 < 11.4
    assert gauge[leaves] / 1e5 == pytest.approx(11.23, abs=0.5)


def test_reach_is_told():
    found, _ = done("axial-chamber")
    assert found["axial_reach_m"] == pytest.approx(6.338e-3, abs=1e-6)
    assert found["duty_reach"] == pytest.approx(0.3119, abs=1e-4)


def test_calibration_that_is_not_monotone_is_refused_with_its_line(tmp_path):
    text = by_command("axial-gerotor").replace("[run]", f"[programs.drive.sensor]\nlight = {CURVE}\n[run]")
    line = next(i for i, row in enumerate(text.splitlines(), 1) if row.startswith("light ="))
    told = refusal(text, tmp_path)
    assert (
        f"own.toml:{line}: programs.drive.sensor.light: "
        + wording.systems.table_falls.format(row=3, value=0.8, before=0.76)
        in told
    )


def calibrated(commands: str, flows: str) -> str:
    """The drive on its prescribed command, its flows measured."""
    rows = f'type = "calibrated-gerotor-drive"\ncommands = {commands}\nflows = {flows}\n'
    return by_command("axial-gerotor").replace("[components.drive.gerotor]\n", "[components.drive.gerotor]\n" + rows)


def test_table_of_flows_that_falls_is_refused_with_its_line(tmp_path):
    text = calibrated('["-1", "0", "0.5", "1"]', '["-1.6 lpm", "0 lpm", "1 lpm", "0.9 lpm"]')
    line = next(i for i, row in enumerate(text.splitlines(), 1) if row.startswith("flows ="))
    told = refusal(text, tmp_path)
    assert (
        f"own.toml:{line}: components.drive.gerotor.flows: "
        + wording.systems.not_below_row.format(row=4, value="0.9 lpm", other=3)
        in told
    )


def test_calibrated_drive_runs_from_a_file(tmp_path):
    rows = calibrated('["-1", "-0.08", "0.06", "1"]', '["-1.62 lpm", "0 lpm", "0 lpm", "1.8 lpm"]')
    (tmp_path / "own.toml").write_text(rows, "utf-8")
    system = load_system(str(tmp_path / "own.toml"))
    run = simulate(system.model, system.case, system.stepping)
    assert run.state.drive_gerotor.position == pytest.approx(
        done("axial-gerotor")[1].state.drive_gerotor.position, abs=1e-8
    )


def test_gerotor_meets_its_end_and_comes_back():
    _, run = done("axial-gerotor")
    x, t = run.state.drive_gerotor.position, run.times
    assert np.all(x[t < 0.2] == 0.0)
    assert np.max(x) == pytest.approx(27e-3, abs=1e-8)
    assert np.gradient(x[t > 1.0], t[t > 1.0]) == pytest.approx(-0.9 * 3e-5 / 506.7e-6, rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_sensor_sees_position_and_pollution(name):
    """What it shows less the position and the pollution at the spool's angle is the noise, 20 um."""
    system = loaded(name)
    _, run = done(name)
    spool = "drive_slide" if name == "axial-chamber" else "drive_gerotor"
    sensor = system.circuit.network.programs["drive_sensor"].settings
    x = getattr(run.state, spool).position
    polluted = np.array([pollution_at(float(angle), sensor.near) for angle in run.state.spool])
    seen = run.command.drive_sensor.position
    assert np.std(polluted) > 0.4e-3
    coarse = run.times < run.times[-1] - 0.26  # a row at a sample shows what was commanded before it
    noise = seen[1:] - (x + polluted)[:-1]
    assert np.std(noise[coarse[1:]]) == pytest.approx(20e-6, rel=0.1)
    assert run.state.spool[-1] == pytest.approx(
        2.0 * np.pi * (22.5 if name == "axial-chamber" else 10.0) * run.times[-1]
    )


def test_lost_and_frozen_signal_of_a_file():
    faults = {"dropout_begin": "0.3 s", "dropout_end": "0.4 s", "freeze_begin": "0.5 s", "freeze_end": "0.6 s"}
    faults["bias"] = "1 mm"
    _, run = done("axial-gerotor", *(f"programs.drive_sensor.{key}={value}" for key, value in faults.items()))
    t, seen = run.times, run.command.drive_sensor.position
    assert np.all(seen[(t > 0.301) & (t < 0.399)] == 30e-3)
    assert np.ptp(seen[(t > 0.501) & (t < 0.599)]) == 0.0
    plain = done("axial-gerotor")[1].command.drive_sensor.position
    assert seen[(t > 0.01) & (t < 0.2)] - plain[(t > 0.01) & (t < 0.2)] == pytest.approx(1e-3, abs=1e-9)
