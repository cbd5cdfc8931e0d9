"""Observer and law of the gerotor drive as programs: against the sampled block of `axial-gerotor`, and by hand."""

import re

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import parsed_table
from vvdp.programs.gerotor_control import DriveTask, FeedforwardTable, feedforward_settings, feedforward_step
from vvdp.programs.gerotor_control import feedforward_start as start
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Run, simulate
from vvdp.systems.summary import summary
from vvdp.systems.system import System, built_system, shipped_systems

pytestmark = pytest.mark.heavy

SHIPPED = shipped_systems()["axial-gerotor"]
PERIOD = 1e-3


def rows(table: str) -> str:
    """The values of a table of the shipped system, without where they come from."""
    part = SHIPPED[SHIPPED.index(f"[{table}]\n") :].split("\n", 1)[1].split("\n[", 1)[0]
    return re.sub(r"(?m)^(\w+) = \{ value = (\[.*?\]|\".*?\").*\}$", r"\1 = \2", part)


def drawn(ahead: float = 0.0, previous: str = '["command"]') -> str:
    """The shipped drive of components and programs; the duty ratio is asked for so much earlier [s]."""
    asked = re.search(r"duty_ratio = \{ table = (\[\[.*?\]\])", SHIPPED)[1]
    asked = re.sub(r'"([\d.]+) s"', lambda m: f'"{max(float(m[1]) - ahead, 0.0)!r} s"', asked)
    sequence = rows("axial_sequence").replace("homing_command", "# homing_command")
    return f"""title = "Gerotor drive of programs"
[nodes]
spool = {{ type = "driven-shaft", speed = "10 rev/s" }}
[components.gerotor]
type = "gerotor-drive"
command = {{ from = "law.command" }}
start = {{ flow = "0 lpm", position = "0 mm" }}
{rows("gerotor")}
{rows("characteristic")}
[programs.sensor]
type = "axial-sensor"
position = "gerotor.position"
angle = "spool.angle"
{rows("axial_sensor")}
[programs.observer]
type = "gerotor-observer"
measured = "sensor.position"
light = "sensor.light"
angle = "spool.angle"
speed = "spool.speed"
command = "law.command"
previous = {previous}
area = "506.7 mm^2"
stop_position = "-6.2 mm"
helix_length = "20.32 mm"
{rows("calibration")}
{rows("axial_observer")}
{sequence}
[programs.wanted]
type = "product"
first = {{ table = {asked} }}
second = "20.32 mm"
[programs.reference]
type = "reference"
reads = "wanted.value"
released = "observer.released"
rest = "-6.2 mm"
{rows("axial_reference")}
[programs.law]
type = "feedforward-pi"
reference = "reference.value"
reference_velocity = "reference.rate"
position = "observer.position"
stage = "observer.stage"
homing_command = "0.6"
area = "506.7 mm^2"
sample_period = "1 ms"
{rows("calibration").replace("lag =", "# lag =")}
{rows("position_control")}
[run]
until = "3 s"
average_from = "2 s"
relative_tolerance = "1e-10"
"""


def loaded(text: str) -> System:
    return built_system(parsed_table(text, "own"), "own")


def ran(text: str) -> Run:
    system = loaded(text)
    return simulate(system.model, system.case, system.stepping)


def test_it_is_the_sampled_block():
    """Asked a sample earlier, for its reference follows what was asked at the last one, it gives the same motion."""
    block = ran(
        SHIPPED[: SHIPPED.index("[run]")] + '[run]\nuntil = "3 s"\naverage_from = "2 s"\nrelative_tolerance = "1e-10"\n'
    )
    found = ran(drawn(PERIOD))
    times = np.linspace(0.0, 3.0, 1000)
    one, other = (np.interp(times, run.times, run.state.gerotor.position) for run in (block, found))
    assert np.ptp(one) > 20e-3
    assert other == pytest.approx(one, abs=1e-9)
    asked = ran(drawn())
    late = np.interp(times, asked.times, asked.state.gerotor.position)
    assert 1e-6 < np.max(np.abs(late - one)) < 30e-6  # 20.32 mm/s times 1 ms


KEYS = ("duty_error_rms", "spool_position_error_rms_m", "spool_estimate_error_rms_m", "spool_estimate_coverage")


def test_the_law_reports_what_the_block_does():
    """Asked a sample earlier the numbers are the same; the figures are those of a drive."""
    systems = loaded(SHIPPED[: SHIPPED.index("[run]")] + drawn()[drawn().index("[run]") :]), loaded(drawn(PERIOD))
    runs = [simulate(system.model, system.case, system.stepping) for system in systems]
    block, found = (summary(system, run) for system, run in zip(systems, runs, strict=True))
    assert [found[key] for key in KEYS] == pytest.approx([block[key] for key in KEYS], rel=1e-6)
    names = [
        [chart.name for chart, _ in system.extras.charts(record_of(run))]
        for system, run in zip(systems, runs, strict=True)
    ]
    assert names[0] == names[1] != []


def test_the_command_of_the_last_sample_breaks_the_loop():
    with pytest.raises(ConfigError, match="same instant: "):
        ran(drawn(previous="false"))
    with pytest.raises(ConfigError, match="a list of its inputs"):
        ran(drawn(previous='["flow"]'))


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
