"""A bench whose spool is watched: encoder and filter in the compiled loop, and what a run says of them."""

from dataclasses import fields

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import EventFilterValues, event_filter
from vvdp.evaluation.summary import summary
from vvdp.programs.estimate_report import estimate_errors
from vvdp.sensing.encoder import Shaft, encoder_start, encoder_step
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.run import simulate
from vvdp.simulation.values import flat
from vvdp.systems.system import built_system, load_system, system_table

SECTOR = 2.0 * np.pi / 8.0
WHOLE = ("run.window=0 s",)
"""All of the run is kept."""


def unwatched():
    """The prototype without its programs and what is said of them."""
    table = system_table("prototype")
    content = {k: v for k, v in table.content.items() if k not in ("programs", "encoder", "spool_filter")}
    values = {k: v for k, v in content["values"].items() if k not in ("encoder", "spool_filter")}
    initial = {**values["initial"], "spool_angle": "nodes.spool.angle"}
    return Table(table.place, {**content, "values": {**values, "initial": initial}}, table.lines)


def test_the_loop_takes_the_same_steps_as_plain_python(ran):
    """Rows at the samples show the estimate of the sample before; its readings follow from the rows themselves."""
    _, run = ran("prototype", ["run.window=0 s"], "0.2 s")
    settings = load_system("prototype").case.settings
    wheel, belief = settings["encoder"].encoder, settings["estimate"]
    spool, found = run.state.spool, run.command.estimate._asdict()
    sensor = encoder_start(wheel, 0.0, float(spool.angle[0]), 1.0)
    memory = event_filter_start(belief, 0.0, 0.0, 0.0)
    for k in range(run.times.size - 1):
        shaft = Shaft(float(run.times[k]), float(spool.angle[k]), float(spool.speed[k]))
        sensor, reading = encoder_step(sensor, shaft, wheel)
        memory, estimate = event_filter_step(memory, reading, belief)
        for name in ("angle", "speed", "angle_deviation", "innovation", "missed_edges"):
            assert found[name][k + 1] == pytest.approx(getattr(estimate, name), rel=1e-9, abs=1e-9), (name, k)


def test_watching_changes_nothing_of_what_is_watched():
    watched = load_system("prototype", until="0.1 s")
    alone = built_system(unwatched(), "prototype")
    alone_run = simulate(alone.model, alone.case, watched.stepping)
    watched_run = simulate(watched.model, watched.case, watched.stepping)
    assert np.array_equal(flat(alone_run.state), flat(watched_run.state))
    assert not alone_run.memory
    assert "spool_angle_error_rms_rad" not in summary(alone, alone_run)


def test_angle_and_speed_are_found(ran):
    """Absolute, as there is an index: within the 0.06 rad that wang2017, section 3.5, states for a constant speed."""
    found = ran("prototype", (), "1 s")[0]
    assert found["spool_angle_error_rms_rad"] < 0.06
    assert found["spool_missed_edges"] == 0.0
    mean = ran("prototype", ["spool_filter.ripple_order=0"], "1 s")[0]
    assert mean["spool_speed_error_rms_rad_s"] < 0.3  # of the mean over a PWM period
    assert found["spool_speed_error_rms_rad_s"] < 1.5  # of the instant


def test_the_estimate_knows_how_good_it_is(ran):
    """Two stated deviations hold 90 to 99 % of the errors; pooled, as half a second has few independent ones."""
    runs = [ran("prototype", [*WHOLE, f"encoder.seed={seed}"], "1 s")[0] for seed in range(1, 9)]
    for name in ("angle", "speed"):
        covered, nees = (np.mean([found[f"spool_{name}_{key}"] for found in runs]) for key in ("coverage", "nees"))
        assert 0.90 <= covered <= 0.99, name
        assert 0.4 < nees < 1.3, name
    error, stated = (
        np.mean([found[f"spool_speed_{key}_rms_rad_s"] for found in runs]) for key in ("error", "deviation")
    )
    assert stated == pytest.approx(error, rel=0.35)


def test_missed_edges_are_known_and_cost_no_sector(ran):
    found, run = ran("prototype", ["encoder.missed_edges=0.2"], "2 s")
    errors = estimate_errors(run.command.estimate._asdict(), run.memory["encoder"]._asdict(), 0.0).angle
    assert np.max(np.abs(errors[run.times > 0.5])) < 0.5 * SECTOR
    spool = run.state.spool
    count = (spool.angle[-1] - spool.angle[0]) / SECTOR
    chance = np.sqrt(count * 0.2 * 0.8)
    assert abs(found["spool_missed_edges"] - 0.2 * count) < 4.0 * chance + 8.0  # and a turn before the filter knows


def test_errors_are_those_at_the_last_sample_within_half_a_turn():
    """2.1 rad against 2 rad and a turn more: 0.1 rad too far; 10 rad/s against 9 rad/s: 1 rad/s too fast."""
    told = {"angle": np.array([2.1]), "speed": np.array([10.0])}
    errors = estimate_errors(told, {"angle": np.array([2.0 + 2.0 * np.pi]), "speed": np.array([9.0])}, 0.0)
    assert errors.angle == pytest.approx([0.1])
    assert errors.speed == pytest.approx([1.0])


def test_errors_over_a_reversal_are_against_what_the_spool_has_turned_through():
    """There and back by 0.3 rad: the wheel has seen 0.6 rad pass, at 4 rad/s and at 4 rad/s."""
    sampled = {"angle": np.array([1.0, 1.3, 1.0]), "speed": np.array([4.0, 4.0, -4.0])}
    errors = estimate_errors({"angle": np.array([1.0, 1.3, 1.6]), "speed": np.full(3, 4.0)}, sampled, 0.0)
    assert errors.angle == pytest.approx(np.zeros(3), abs=1e-15)
    assert errors.speed == pytest.approx(np.zeros(3))


def test_the_encoder_remembers_the_spool_of_the_last_sample(ran):
    """Rows at the samples show what was held until then: the spool one row before."""
    _, run = ran("prototype", ["run.window=0 s"], "0.2 s")
    spool, sampled = run.state.spool, run.memory["encoder"]
    for shown, true in ((sampled.time, run.times), (sampled.angle, spool.angle), (sampled.speed, spool.speed)):
        assert shown[1:] == pytest.approx(true[:-1], rel=1e-12)


def test_a_short_run_has_no_errors_to_tell(ran):
    assert "spool_angle_error_rms_rad" not in ran("prototype", (), "0.1 s")[0]


def test_the_filter_of_the_prototype_is_the_usual_one():
    values = load_system("prototype").case.settings["estimate"]
    usual = event_filter(equal_wheel(8))
    own = {"ripple_order", "ripple_variance", "ripple_drift"}
    assert values.ripple_order == load_system("prototype").case.params.valve.sections
    for field in fields(EventFilterValues):
        if field.name in own:
            continue
        assert getattr(values, field.name) == pytest.approx(getattr(usual, field.name), rel=1e-12), field.name


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("encoder.sectors=7", "7"),
        ("encoder.seed=1.5", wording.systems.whole_number),
        ("encoder.spot_width=9 mm", wording.systems.narrower_than_sector),
        (
            "encoder.track_radius=0 mm",
            "track_radius: " + wording.files.must_be_greater_than_zero.format(value="0 mm"),
        ),
        ("spool_filter.edge_variance=0 rad^2", "edge_variance"),
    ],
)
def test_what_cannot_be_is_refused_with_numbers(setting, told):
    with pytest.raises(ConfigError, match=told):
        load_system("prototype", [setting])
