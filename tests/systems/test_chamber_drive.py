"""The part `chamber-drive`: numbers by hand, with other laws, twice in a circuit, and beside a rotary valve."""

import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from vvdp.base.errors import ConfigError
from vvdp.evaluation.summary import summary
from vvdp.simulation.record import record_of
from vvdp.simulation.run import simulate
from vvdp.systems.program_reports import ReportedPrograms
from vvdp.systems.system import System, load_system, shipped_systems

pytestmark = pytest.mark.heavy

DRIVE = """title = "A spool that a chamber moves"

[nodes]
supply = { type = "pressure-source", pressure = "250 psi" }
tank = { type = "tank" }
spool = { type = "driven-shaft", speed = "22.5 rev/s" }

[parts.drive]
type = "chamber-drive"
supply = "supply"
tank = "tank"
spool_angle = { from = "spool.angle" }
spool_speed = { from = "spool.speed" }
duty_ratio = { step = ["0.1", "0.4"], at = "1.2 s" }

[run]
until = "1.7 s"
average_from = "1.6 s"
"""

PAGE = (Path(__file__).parents[2] / "docs" / "own-code.md").read_text("utf-8")


def law(name: str) -> str:
    return f'[programs.drive.law]\ntype = "{name}"\n\n[run]'


@cache
def found_in(text: str, *settings: str) -> dict:
    return summary(*ran(text, *settings))


def ran(text: str, *settings: str):
    system = system_of(text, *settings)
    return system, simulate(system.model, system.case, system.stepping)


def system_of(text: str, *settings: str) -> System:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "own.toml"
        path.write_text(text, "utf-8")
        return load_system(str(path), list(settings))


def test_it_holds_the_duty_ratio_that_is_asked():
    """Duty ratio 0.4 is 8.128 mm of the helix of 20.32 mm, reached 0.5 s after the step within the filter's 30 um."""
    system, run = ran(DRIVE)
    found = summary(system, run)
    assert found["trusted"]
    assert run.state.drive_slide.position[-1] == pytest.approx(0.4 * 20.32e-3, abs=60e-6)
    assert found["control_begin_s"] == pytest.approx(0.32, abs=2e-3)
    assert found["spool_position_error_rms_m"] < 100e-6
    assert found["spool_estimate_coverage"] > 0.9


def test_reach_by_hand():
    """(250 psi x 174 mm^2 - 211.5 N) / 2594 N/m = 34.1 mm."""
    assert found_in(DRIVE)["axial_reach_m"] == pytest.approx((250 * 6894.757 * 174e-6 - 211.5) / 2594.0, rel=1e-6)


def test_a_value_reaches_drive_observer_and_law():
    """With twice the spring everywhere it reaches half as far, and still follows: all three know."""
    found = found_in(DRIVE, "parts.drive.stiffness=5188 N/m")
    assert found["axial_reach_m"] == pytest.approx(0.5 * found_in(DRIVE)["axial_reach_m"], rel=1e-9)
    assert found["spool_position_error_rms_m"] < 100e-6


def test_another_law_by_one_line():
    """The published feedforward, with the same gains."""
    found = found_in(DRIVE.replace("[run]", law("printed-passivity")))
    assert found["spool_position_error_rms_m"] < 100e-6
    assert found["spool_position_error_rms_m"] != found_in(DRIVE)["spool_position_error_rms_m"]


def test_a_law_with_other_gains_needs_those_and_drops_the_old_ones():
    with pytest.raises(ConfigError) as refused:
        system_of(DRIVE.replace("[run]", law("backstepping")))
    assert "programs.law.pressure_weight" in str(refused.value) and "pressure_rate" not in str(refused.value)
    own = law("backstepping").replace("\n\n", '\npressure_weight = "3e-12 m^3/Pa"\nflow_gain = "1e-10 m^3/(s*Pa)"\n\n')
    assert found_in(DRIVE.replace("[run]", own))["spool_position_error_rms_m"] < 200e-6


def test_two_drives_report_under_their_names():
    second = """
[parts.other]
type = "chamber-drive"
supply = "supply"
tank = "tank"
spool_angle = { from = "spool.angle" }
spool_speed = { from = "spool.speed" }
duty_ratio = "0.2"

[run]"""
    system, run = ran(DRIVE.replace("[run]", second))
    assert isinstance(system.extras, ReportedPrograms)
    found = summary(system, run)
    assert "duty_error_rms" not in found
    assert found["drive_law_spool_position_error_rms_m"] < 100e-6
    assert found["other_law_spool_position_error_rms_m"] < 100e-6
    alone = found_in(DRIVE)["spool_position_error_rms_m"]
    assert found["drive_law_spool_position_error_rms_m"] == pytest.approx(alone, rel=1e-6)
    names = [chart.name for chart, _ in system.extras.charts(record_of(run))]
    assert sorted(set(names)) == sorted(names)
    assert {"drive-law-axial-control", "other-law-axial-control"} <= set(names)


def test_the_law_of_the_page(tmp_path):
    """One Python file and one line of TOML; the numbers of the page."""
    code = next(each for each in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "cascade_step" in each)
    line = next(each for each in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "my_law:LAW" in each)
    assert len([row for row in line.splitlines() if "=" in row]) == 1
    (tmp_path / "my_law.py").write_text(code)
    text = shipped_systems()["axial-chamber"]
    own = text.replace("[run]", f"{line}\n[run]")
    (tmp_path / "drive.toml").write_text(own)
    system = load_system(str(tmp_path / "drive.toml"))
    run = simulate(system.model, system.case, system.stepping)
    found = summary(system, run)
    shown = re.search(
        r"leaves ([\d.]+) mm rms against the reference, `passivity` ([\d.]+) mm.*?in (\d+) samples", PAGE, re.S
    )
    assert f"{1e3 * found['spool_position_error_rms_m']:.3f}" == shown[1]
    assert f"{1e3 * found_in(text)['spool_position_error_rms_m']:.3f}" == shown[2]
    assert found["storage_rises"] == float(shown[3])
    assert any("not passive" in words for words in system.extras.warnings(found))


PLAIN_LAW = '''
"""A proportional law with inputs and a gain of its own."""
from typing import NamedTuple
from vvdp.base.kinds import Fraction, Number, Position, SignedFraction
from vvdp.base.params import Params
from vvdp.network.program import ProgramType

class Seen(NamedTuple):
    reference: Position
    position: Position
    released: Fraction

class Gain(Params):
    gain_per_metre: Number

class Opening(NamedTuple):
    command: SignedFraction

def step(t, memory, seen, settings):
    opening = settings.gain_per_metre * (seen.reference - seen.position)
    return memory, Opening(min(max(opening, -1.0), 1.0) if seen.released > 0.5 else -1.0)

LAW = ProgramType(step, Seen, Opening(-1.0), Gain)
'''


def test_a_law_with_other_inputs_and_values_takes_its_place(tmp_path):
    """The keys of the shipped law that it does not know go with that law; its own gain is read."""
    (tmp_path / "plain_law.py").write_text(PLAIN_LAW)
    text = shipped_systems()["axial-chamber"]
    own = text.replace("[run]", '[programs.drive.law]\ntype = "plain_law:LAW"\ngain_per_metre = "100"\n\n[run]')
    (tmp_path / "drive.toml").write_text(own)
    law = load_system(str(tmp_path / "drive.toml")).circuit.network.programs["drive_law"]
    assert {*law.reads} == {"reference", "position", "released"}
    assert law.settings.gain_per_metre == 100.0


@pytest.mark.thorough
def test_the_law_of_the_page_in_the_whole_machine(tmp_path):
    """One word of the file; the numbers of the page, beside those of the shipped law."""
    code = next(each for each in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "cascade_step" in each)
    (tmp_path / "my_law.py").write_text(code)
    text, found = shipped_systems()["displacement-control"], []
    for law in ("my_law:LAW", "passivity"):
        path = tmp_path / "machine.toml"
        path.write_text(text.replace('type = "passivity"', f'type = "{law}"'))
        system = load_system(str(path))
        found.append(summary(system, simulate(system.model, system.case, system.stepping)))
    shown = re.search(
        r"error of ([\d.]+) mm rms \(([\d.]+)\), and its\s+cylinder follows within ([\d.]+) mm \(([\d.]+)", PAGE
    )
    keys = ("spool_position_error_rms_m", "tracking_error_max_m")
    assert [f"{1e3 * each[key]:.3f}" for key in keys for each in found] == [*shown.groups()]


UNIT = """
[nodes.motor]
type = "driven-shaft"
speed = "1800 rpm"

[nodes.line]
type = "vessel"
oil_volume = "0.4 l"
gas_volume = "50 cc"
precharge_pressure = "50 bar"
start = "60 bar"

[components.load]
type = "orifice"
a = "line"
b = "tank"
area = "3 mm^2"

[parts.unit]
type = "pump-unit"
load = "line"
tank = "tank"
shaft = "motor"
axial_position = { from = "drive.slide.position" }

[run]"""


def test_it_drives_the_rotary_valve_of_a_pump_unit():
    """The pump unit's own spool turns past the sensor; the duty ratio sets what reaches the load."""
    text = DRIVE.replace("[run]", UNIT).replace('spool = { type = "driven-shaft", speed = "22.5 rev/s" }\n', "")
    text = text.replace('"spool.', '"unit.spool.')
    low = found_in(text.replace('{ step = ["0.1", "0.4"], at = "1.2 s" }', '"0.3"'))
    high = found_in(text.replace('{ step = ["0.1", "0.4"], at = "1.2 s" }', '"0.6"'))
    assert low["trusted"] and high["trusted"]
    assert high["flow_mean_load_m3_s"] > 1.2 * low["flow_mean_load_m3_s"]
    assert high["spool_position_error_rms_m"] < 100e-6
    assert high["unit_pwm_frequency_Hz"] > 40.0
