"""The program `tally`: what counts, and which numbers it adds to any run."""

from functools import cache
from importlib import resources

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import parsed_table
from vvdp.evaluation.summary import simulated_summary, summary
from vvdp.programs.tally import CylinderTruth, TallySettings, tally_start, tally_step
from vvdp.simulation.outcome import outcome
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

BAR, ATMOSPHERE = 1e5, 101325.0
SETTINGS = TallySettings(tank_pressure=ATMOSPHERE, sections=3.0)
EXAMPLE = (resources.files("vvdp.systems") / "examples/programs/displacement-control.toml").read_text("utf-8")
FURTHER = """saturated = "law.saturated"
line_pressure = "line.pressure"
spool_angle = "unit.spool.angle"
map_gain = "map.duty_ratio"
sections = "3"
counted = { step = ["0", "1"], at = "0.5 s" }
"""


def truth(**changes):
    usual = CylinderTruth(
        position=0.1,
        reference=0.101,
        pressure_a=20.0 * BAR,
        pressure_b=10.0 * BAR,
        direction=1.0,
        opening=0.8,
        mode=1.0,
        saturated=0.0,
    )
    return usual._replace(**changes)


def after(*samples):
    """The memory after samples of 0.5 s each."""
    memory = tally_start(SETTINGS)
    for number, sample in enumerate(samples):
        memory, command = tally_step(0.5 * number, memory, sample, SETTINGS)
    return memory, command


def test_what_does_not_count_leaves_nothing():
    memory, command = after(truth(counted=0.0), truth(counted=0.0))
    assert memory.tracking.begin == np.inf and memory.lowest == np.inf
    assert command.error == 0.0


def test_errors_count_a_second_after_the_first_sample_that_counts():
    """Control begins at 0.5 s: -1 mm at 0.5 and 1 s are early, 3 mm and -1 mm at 1.5 and 2 s are late."""
    memory, command = after(
        truth(counted=0.0, position=9.0), truth(), truth(), truth(position=0.104), truth(direction=-1.0)
    )
    found = memory.tracking
    assert (found.begin, found.samples, found.switches) == (0.5, 2.0, 1.0)
    assert (found.early_peak, found.peak) == pytest.approx((1e-3, 3e-3))
    assert found.squares == pytest.approx(1e-5)
    assert command.error == pytest.approx(-1e-3)


def test_a_chamber_below_the_tank_counts():
    empty = truth(pressure_b=0.5 * BAR)
    memory, _ = after(truth(), truth(), truth(), empty, truth(mode=2.5))
    assert memory.tracking.below_tank == 1.0
    assert memory.tracking.modes.tolist() == [2.0, 0.0, 1.0, *6 * [0.0]]


def test_the_turn_of_a_spool_counts_from_the_first_sample_on():
    memory, _ = after(
        *(truth(spool_angle=angle, line_pressure=p * BAR) for angle, p in ((5.0, 9.0), (8.0, 7.0), (11.0, 8.0)))
    )
    assert (memory.turned, memory.time, memory.lowest) == (6.0, 1.0, 7.0 * BAR)


def ran(text, until="2 s"):
    system = built_system(parsed_table(text.replace('until = "4 s"', f'until = "{until}"'), "mine.toml"), "mine")
    return system, simulate(system.model, system.case, system.stepping)


@cache
def example_ran(more=False):
    return ran(EXAMPLE.replace('saturated = "law.saturated"\n', FURTHER) if more else EXAMPLE)


def test_any_run_has_its_numbers_with_a_record_or_without():
    system, run = example_ran()
    found, alone = summary(system, run), simulated_summary(outcome(run), system)
    assert found["tracking_error_max_m"] == alone["tracking_error_max_m"] > 0.0
    nodes = ("head", "back")
    assert alone["pressure_min_Pa"] == min(alone[f"pressure_min_{node}_Pa"] for node in nodes)
    assert alone["pressure_max_Pa"] == max(alone[f"pressure_max_{node}_Pa"] for node in nodes)
    assert not {"control_begin_s", "flow_map_gain", "pwm_frequency_Hz"} & found.keys()
    assert "pump_flow_max_m3_s" not in found and "mode_1_pump_energy_J" not in found  # no flow that the law reads


def test_line_map_and_spool_add_theirs():
    system, run = example_ran(more=True)
    found = summary(system, run)
    assert found["control_begin_s"] == 0.5
    assert found["flow_map_gain"] == pytest.approx(run.command.map.duty_ratio[-1], rel=0.01)
    late = run.times >= 0.5
    turned = np.ptp(run.state.unit_spool.angle[late]) / np.ptp(run.times[late])
    assert found["pwm_frequency_Hz"] == pytest.approx(3.0 * turned / (2.0 * np.pi), rel=1e-3)
    assert found["pressure_max_Pa"] >= found["pressure_max_line_Pa"]


def test_it_is_silent_before_anything_counts():
    text = EXAMPLE.replace('saturated = "law.saturated"\n', FURTHER)
    system, run = ran(text, until="0.2 s")
    found = summary(system, run)
    assert "tracking_error_first_second_m" not in found and "pressure_min_Pa" not in found
    assert "real_time_factor" in found


def test_two_tallies_have_keys_of_their_own():
    """Numbers of each program are kept where several programs report, whether keys are shared or not."""
    second = EXAMPLE[EXAMPLE.index("[programs.tally]") : EXAMPLE.index("[programs.map]")]
    system, run = ran(EXAMPLE.replace("[programs.map]", second.replace(".tally]", ".other]") + "[programs.map]"))
    found = summary(system, run)
    assert found["tally_tracking_error_max_m"] == found["other_tracking_error_max_m"] > 0.0
    lines = [line for line in system.extras.OVERVIEW if line.label == "time with the supply chamber low"]
    assert [line.keys for line in lines] == [
        (f"{name}_mode_2_share", f"{name}_mode_2_5_share") for name in ("tally", "other")
    ]


def test_figures_are_drawn_of_what_is_recorded():
    """The law of the example reads an observer; its flow is not known."""
    from vvdp.simulation.record import record_of

    system, run = example_ran()
    charts = {chart.name: table for chart, table in system.extras.charts(record_of(run))}
    assert {*charts} == {"displacement-motion", "displacement-pressures", "displacement-actuation"}
    assert "pump_flow_m3_s" not in charts["displacement-actuation"].columns
    error = charts["displacement-motion"]["tracking_error_m"]
    assert np.max(np.abs(error[run.times > 1.0])) == pytest.approx(
        summary(system, run)["tracking_error_max_m"], rel=1e-9
    )


def test_a_cycle_out_of_reach_is_refused_in_a_file_without_short_paths():
    """The rod is read directly: the law checks its cylinder, at the paths of the file."""
    direct = EXAMPLE.replace('position = "load.position"', 'position = "cylinder.rod.position"')
    with pytest.raises(ConfigError) as refused:
        ran(direct.replace("158 mm", "358 mm"))
    (fault,) = refused.value.faults
    assert fault.key == "programs.path.values"
    assert wording.systems.stroke_too_long.format(stroke="358 mm", low="0 mm", high="300 mm") in fault.message
    assert ran(direct, until="10 ms")
