"""Means are taken over whole PWM periods, and their parts add up."""

import numpy as np
import pytest

from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

BENCHES = ("prototype", "prototype-constant-load")


@pytest.mark.parametrize("name", BENCHES)
def test_window_spans_whole_periods_after_the_start_of_averaging(name, ran):
    found, run = ran(name, [])
    begin, end = found["averaged_from_s"], found["averaged_to_s"]
    assert 0.25 <= begin < end <= 0.5
    inside = run.mark_times[(run.mark_times >= 0.25)]
    assert (begin, end) == (inside[0], inside[-1])
    assert found["averaged_periods"] == inside.size - 1
    assert found["pwm_frequency_Hz"] == pytest.approx(found["averaged_periods"] / (end - begin), rel=1e-6)
    assert found["settled"]


@pytest.mark.parametrize("name", BENCHES)
def test_parts_of_the_budget_add_up(name, ran):
    """Input less load is the sum of all losses, up to what is stored: over whole periods of a settled run, little."""
    found, _ = ran(name, [])
    losses = sum(found[f"loss_{part}_W"] for part in ("pump", "valve", "relief_valve", "coupling"))
    assert losses == pytest.approx(found["loss_total_W"], rel=5e-3)
    flows = sum(found[f"mean_{k}_flow_m3_s"] for k in ("load", "tank", "leakage"))
    flows += found["flow_mean_pump_leakage_m3_s"]
    assert flows + found["flow_mean_relief_valve_m3_s"] == pytest.approx(found["mean_pump_flow_m3_s"], rel=5e-3)
    assert found["efficiency"] == pytest.approx(found["load_power_W"] / found["input_power_W"])


def test_spool_that_stands_gives_no_periods_and_says_so(ran):
    """Without marks, the mean is taken over the plain time, in which nothing changes."""
    settings = ["spool_drive.coupling=10 N*m*s", "operation.spool_motor_speed=0 rpm", "initial.spool_speed=0 rpm"]
    found, run = ran("prototype-constant-load", settings)
    assert found["averaged_periods"] == 0.0
    assert found["settled"]
    assert (run.mark_times < 1e-3).all()  # it trembles at its start, at the angle that is counted from
    assert (found["averaged_from_s"], found["averaged_to_s"]) == (0.25, 0.5)
    assert {key for key, value in found.items() if not np.isfinite(value)} <= {"efficiency", "loss_transition_W"}


def test_run_that_is_still_speeding_up_is_not_settled(ran):
    found, _ = ran("prototype-constant-load", ["initial.spool_speed=300 rpm"], "0.1 s")
    assert not found["settled"]


def test_interrupted_run_is_averaged_over_its_second_half():
    def interrupt(t: float) -> None:
        if t > 0.12:
            raise KeyboardInterrupt

    system = load_system("prototype-constant-load")
    run = simulate(system.model, system.case, system.stepping, progress=interrupt, portion=200.0)
    found = summary(system, run)
    assert not found["finished"]
    assert found["averaged_from_s"] >= 0.5 * run.end
    assert found["averaged_to_s"] <= run.end
    assert found["trusted"]


def test_means_do_not_depend_on_what_is_recorded(ran):
    """They come from integral states."""
    fine, _ = ran("prototype-constant-load", [], "0.3 s")
    coarse, _ = ran("prototype-constant-load", ["run.window_interval=5 ms", "run.record_interval=50 ms"], "0.3 s")
    for key in ("mean_load_flow_m3_s", "loss_total_W", "pwm_frequency_Hz", "pressure_mean_inlet_Pa"):
        assert coarse[key] == fine[key]
