"""Observers and law of the gerotor drive as programs: in the part `gerotor-drive`, and by hand."""

import pytest
from tests.systems.axial_texts import change_table, run_of, system_of

from vvdp.base.errors import ConfigError
from vvdp.evaluation.summary import summary
from vvdp.programs.gerotor_control import DriveTask, FeedforwardTable, feedforward_settings, feedforward_step
from vvdp.programs.gerotor_control import feedforward_start as start
from vvdp.systems.system import load_system, shipped_systems

pytestmark = pytest.mark.heavy

SHIPPED = shipped_systems()["axial-gerotor"]
PERIOD = 1e-3


def test_a_value_of_the_part_reaches_drive_observer_and_law():
    """With twice the area all three know, and the spool goes half as fast."""
    system = load_system("axial-gerotor", ["parts.drive.area=1013.4 mm^2"])
    network = system.circuit.network
    settings = [network.programs[f"drive_{name}"].settings for name in ("observer", "law")]
    assert network.parts["drive_gerotor"].values[0].area == pytest.approx(1013.4e-6)
    assert [settings[0].observer.area, settings[1].law.area] == pytest.approx([1013.4e-6] * 2)


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("lumped-observer", {"bandwidth": "60 rad/s"}),
        ("generator-observer", {"noise_period": "100 ms", "generator_drift": "3 um"}),
    ],
)
def test_another_observer_by_its_type(kind, keys):
    """The drive follows with either, and needs no keys of the shipped one; its duty error is over the same helix."""
    text = change_table(SHIPPED, "programs.drive.observer", type=kind, **keys)
    found = summary(*run_of(change_table(text, "run", until="3 s", average_from="1.6 s")))
    assert 1e-5 < found["spool_position_error_rms_m"] < 3e-4
    assert found["duty_error_rms"] == pytest.approx(found["spool_position_error_rms_m"] / 20.32e-3)


def test_the_command_of_the_last_sample_breaks_the_loop():
    for previous, words in (("false", "same instant: "), ('["flow"]', "a list of its inputs")):
        entry = f"[programs.drive.observer]\nprevious = {previous}\n\n[run]"
        with pytest.raises(ConfigError, match=words):
            system_of(SHIPPED.replace("[run]", entry))


LAW = feedforward_settings(
    FeedforwardTable(
        area=5e-4,
        proportional_rate=30.0,
        integral_rate=0.0,
        largest_flow=3e-5,
        forward_dead_band=0.1,
        backward_dead_band=0.1,
        backward_gain=0.9,
        straight_flow=1e-6,
        sample_period=PERIOD,
        homing_command=0.6,
    )
)


@pytest.mark.parametrize(
    ("stage", "flow", "command"),
    [(0.0, 0.0, -0.6), (1.0, 0.0, 0.0), (2.0, 5e-4 * (0.01 + 30.0 * 1e-4), 0.1 + 0.9 * 6.5e-6 / 3e-5), (3.0, 0.0, 0.0)],
)
def test_flow_and_command_by_hand(stage, flow, command):
    """10 mm/s and 0.1 mm behind: 6.5 ml/s, of 30 ml/s beyond a dead band of 0.1."""
    found = feedforward_step(0.0, start(LAW), DriveTask(1e-4, 0.01, 0.0, stage), LAW)[1]
    assert found == pytest.approx((command, flow), rel=1e-9)
