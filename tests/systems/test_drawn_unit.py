"""`vvdp-duty-control` and `vvdp-duty-control-gerotor` of the shipped parts, against the functions that draw them."""

import re

import numpy as np
import pytest
from tests.systems.axial_texts import change, run_of

from vvdp.evaluation.summary import summary
from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

UNIT = """title = "Pump unit whose duty ratio is held, drawn of parts"
[operation]
oil_temperature = "40 degC"
[oil]
{oil}
[nodes]
tank = {{ type = "tank" }}
motor = {{ type = "driven-shaft", speed = "1800 rpm" }}
{nodes}
[nodes.line]
type = "vessel"
start = "20 bar"
{load_line}
[parts.unit]
type = "pump-unit"
load = "line"
tank = "tank"
shaft = "motor"
axial_position = {{ from = "drive.{spool}.position" }}
spool_speed = "1475 rpm"
[nodes.unit.inlet]
start = "5 bar"
[components.unit.pump]
{pump}
[components.unit.relief_valve]
{relief_valve}
[components.unit.valve]
{valve}
jet_asymmetry = "0"
{check_valve}
[components.load]
type = "orifice"
a = "line"
b = "tank"
{load}
[programs.edges]
type = "encoder"
angle = "unit.spool.angle"
speed = "unit.spool.speed"
{encoder}
[programs.filter]
type = "event-filter"
reads = "edges"
sectors = "8"
{spool_filter}
[parts.drive]
spool_angle = {{ from = "unit.spool.angle" }}
duty_ratio = "0.5"
{drive}
[programs.drive.observer]
angle = "filter.angle"
speed = "filter.speed"
angle_deviation = "filter.angle_deviation"
speed_deviation = "filter.speed_deviation"
slip = "filter.slip"
{axial_observer}
{axial_sequence}
{law}
[run]
until = "2 s"
average_from = "1.5 s"
relative_tolerance = "1e-9"
sample_period = "1 ms"
record_interval = "1 ms"
"""
GEROTOR = {
    "spool": "gerotor",
    "law": "",
    "oils": "",
    "nodes": "",
    "drive": 'type = "gerotor-drive"\naxial_position = "-6.2 mm"',
}
CHAMBER = {
    "spool": "slide",
    "law": '[programs.drive.law]\nfriction = "0 N*s/m"',
    "oils": "pilot_oil",
    "nodes": """pilot_supply = { type = "pressure-source", pressure = "250 psi", oil = "pilot" }
pilot_tank = { type = "tank", oil = "pilot" }""",
    "drive": """type = "chamber-drive"
supply = "pilot_supply"
tank = "pilot_tank"
supply_pressure = "250 psi"
liquid_bulk_modulus = "1.7 GPa"
air_fraction = "9.0909091 %"
""",
}


def rows(text: str, table: str) -> str:
    """The values of a table of a system, without where they come from."""
    part = text[text.index(f"[{table}]\n") :].split("\n", 1)[1].split("\n[", 1)[0]
    return re.sub(r"(?m)^(\w+) = \{ (?:table|value) = (\[.*?\]|\".*?\").*\}$", r"\1 = \2", part)


def drawn(name: str, words: dict[str, str]) -> str:
    """The text of a shipped system, drawn of the parts."""
    text = shipped_systems()[name]
    own = re.findall(r"\{(\w+)\}", UNIT.replace("{{", "").replace("}}", ""))
    made = UNIT.format(**{key: words[key] if key in words else rows(text, key) for key in own})
    if words["oils"]:
        pilot = f"[oils.pilot]\n{rows(text, words['oils'])}\n"
        made = made.replace("[nodes]\n", f'{pilot}[nodes.drive.pilot_chamber]\noil = "pilot"\n[nodes]\n')
    return re.sub(r"(?m)^homing_command.*\n", "", made)


SPOOLS = {"vvdp-duty-control-gerotor": ("gerotor", GEROTOR, 1e-8), "vvdp-duty-control": ("slide", CHAMBER, 5e-6)}
"""By what the spool is moved, and by how much it may be elsewhere [m]: the reference follows a sample later, which an
error of the estimate, some 10 um here, feels; with the gerotor pump the command is the same to the last digits."""


@pytest.mark.parametrize("name", SPOOLS)
def test_it_does_what_the_function_draws(name):
    """Spool, load pressure and PWM frequency of 2 s; both know the angle from the encoder, its slips with it."""
    spool, words, apart = SPOOLS[name]
    shipped = change(shipped_systems()[name], "run", until="2 s", average_from="1.5 s", relative_tolerance="1e-9")
    (block, one), (system, other) = run_of(shipped), run_of(drawn(name, words))
    times = np.linspace(0.0, 2.0, 4000)
    place, drawn_place = getattr(one.state, spool).position, getattr(other.state, f"drive_{spool}").position
    late = times > 0.6
    moved = np.interp(times, other.times, drawn_place) - np.interp(times, one.times, place)
    assert np.max(np.abs(moved[late])) < apart
    assert np.ptp(place) > 10e-3
    found, expected = summary(system, other), summary(block, one)
    assert found["trusted"]
    assert found["unit_pwm_frequency_Hz"] == pytest.approx(expected["pwm_frequency_Hz"], rel=2e-5)
    assert found["control_begin_s"] == expected["control_begin_s"]
    keys = ("spool_position_error_rms_m", "spool_estimate_error_rms_m", "spool_estimate_deviation_rms_m")
    assert [found[key] for key in keys] == pytest.approx([expected[key] for key in keys], abs=apart)
    assert found["pressure_mean_line_Pa"] == pytest.approx(expected["pressure_mean_load_line_Pa"], rel=1e-4)
