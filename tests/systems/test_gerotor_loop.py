"""The gerotor drive in closed loop: its stages, what it holds, what it does without its sensor, and what is refused."""

import numpy as np
import pytest
from tests.systems.axial_texts import change, change_table, run_of, system_of
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.evaluation.control_stages import reach_bounds
from vvdp.evaluation.summary import summary
from vvdp.programs.axial_stages import HOME, LEARN, RUN, STOP
from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

SHIPPED = shipped_systems()["axial-gerotor"]
UNIT = shipped_systems()["vvdp-duty-control-gerotor"]
SHORT = change(SHIPPED, "run", until="2 s", average_from="1.6 s")


def refusal(text: str) -> str:
    with pytest.raises(ConfigError) as refused:
        system_of(text)
    return str(refused.value)


def test_it_homes_learns_and_is_controlled():
    """0.3 s to the end at 30 mm/s, 0.3 s there, then to duty ratio 0; what it believes at the end is where it is."""
    _, run = run_of(SHORT)
    shown, x, t = run.command.drive_observer, run.state.drive_gerotor.position, run.times
    begins = [t[np.argmax(shown.stage == stage)] for stage in (HOME, LEARN, RUN)]
    assert begins == pytest.approx([0.0, 0.301, 0.601], abs=2e-3)
    fastest = np.min(np.diff(x[t < 0.2]) / np.diff(t[t < 0.2]))
    assert fastest == pytest.approx(-0.9 * (0.6 - 0.08) / 0.92 * 3e-5 / 506.7e-6, rel=1e-3)
    learning = shown.stage == LEARN
    assert x[learning] == pytest.approx(-6.2e-3, abs=1e-8)
    assert shown.position[learning][2:] == pytest.approx(-6.2e-3, abs=1e-12)
    assert np.max(np.abs(run.command.drive_law.command[learning][2:])) == 0.0
    assert abs(x[t < 1.6][-1]) < 60e-6


def test_trapezoid_of_the_whole_duty_ratio():
    """55 um rms and 0.16 mm at most, at the corners; the pollution is 0.53 mm rms."""
    found = summary(*run_of(SHIPPED))
    assert found["trusted"]
    assert abs(found["energy_residual"]) < 1e-9
    assert found["spool_position_error_rms_m"] < 70e-6
    assert found["spool_position_error_max_m"] < 0.2e-3
    assert found["pollution_rms_m"] == pytest.approx(0.527e-3, rel=0.01)
    assert found["duty_error_rms"] == pytest.approx(found["spool_position_error_rms_m"] / 20.32e-3)
    assert "storage_rises" not in found


def test_observers_without_a_deviation_state_none():
    text = change_table(SHIPPED, "programs.drive.observer", type="lumped-observer", bandwidth="60 rad/s")
    found = summary(*run_of(text))
    assert found["spool_position_error_rms_m"] > 100e-6
    assert "spool_estimate_coverage" not in found


def test_a_short_time_without_the_sensor_is_bridged_by_the_flow():
    """0.2 s at rest: nothing is delivered within the dead band, and nothing is believed to be."""
    text = change(SHORT, "axial_sensor", dropout_begin="1.4 s", dropout_end="1.6 s")
    _, run = run_of(text)
    lost = (run.times > 1.41) & (run.times < 1.6)
    assert np.all(run.command.drive_sensor.position[lost] == 30e-3)
    assert np.ptp(run.state.drive_gerotor.position[lost]) < 30e-6


def test_stopped_it_stays_where_it_is():
    """It has no spring: without current the duty ratio remains."""
    _, run = run_of(change(change(SHIPPED, "axial_sequence", stop_time="3 s"), "run", until="4 s"))
    late = run.times > 3.1
    assert np.all(run.command.drive_observer.stage[late] == STOP)
    assert run.state.drive_gerotor.position[late] == pytest.approx(20.32e-3, abs=0.1e-3)
    assert np.ptp(run.state.drive_gerotor.position[late]) < 1e-6


@pytest.mark.parametrize("seeds", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_pump_unit_is_held_within_the_dead_band(seeds):
    """Its encoder tells the angle."""
    for seed in range(1, seeds + 1):
        found = summary(*run_of(change(change(UNIT, "axial_sensor", seed=str(seed)), "encoder", seed=str(seed))))
        assert found["trusted"] and found["control_begin_s"] < 0.8
        assert found["spool_position_error_rms_m"] < 60e-6
        assert found["spool_estimate_error_rms_m"] < 30e-6
        assert abs(found["energy_residual"]) < 1e-6
        assert abs(found["mass_residual"]) < 1e-6


def test_a_duty_ratio_beyond_the_drive_is_told():
    """1.4 of a helix of 20.32 mm are 28.45 mm; the drive goes to 27 mm."""
    system = system_of(change(UNIT, "operation", duty_ratio="1.4"))
    (asked,) = (each for each in reach_bounds(system) if not each.is_kept)
    assert asked.high == pytest.approx(28.448e-3)
    assert "28.45 mm, above 27 mm; the drive ends there" in asked.sentence
    assert all(each.is_kept for each in reach_bounds(system_of(UNIT)))


def test_what_is_refused():
    for text in (SHIPPED, UNIT):
        refused = refusal(change(text, "calibration", lag="0 s"))
        assert "lag: " in refused and wording.systems.no_motor_follows.format(lag="0 ms") in refused
    assert "straight_flow" in refusal(change(SHIPPED, "calibration", straight_flow="2 lpm"))
    text = change_table(SHIPPED, "programs.drive.observer", type="generator-observer", noise_period="41.5 ms")
    assert "41.5" in refusal(change_table(text, "programs.drive.observer", generator_drift="3 um"))
