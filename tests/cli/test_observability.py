"""`vvdp observability`: the numbers of the spool of chapter 5, what it says of them, and what it refuses."""

import json

import pytest

from vvdp.results.store import read_result

SPOOL = """
[nodes]
tank = { type = "tank" }
chamber = { type = "volume", volume = "60 cc", start = "3 bar" }
slide = { type = "rod", position = "0 mm" }
spool = { type = "driven-shaft", speed = "22.5 rev/s" }
[components.piston]
type = "plunger"
a = "chamber"
rod = "slide"
area_a = "174 mm^2"
moving_mass = "0.5 kg"
[components.spring]
type = "spring"
rod = "slide"
stiffness = "2594 N/m"
preload = "211.5 N"
rest_position = "0 mm"
[components.friction]
type = "rod-friction"
rod = "slide"
viscous_friction = "20 N*s/m"
coulomb_friction = "0 N"
breakaway_friction = "0 N"
stribeck_velocity = "20 mm/s"
coulomb_velocity = "1 mm/s"
[components.feed]
type = "orifice"
a = "chamber"
b = "tank"
area = "1 mm^2"
discharge_coefficient = 0.62
transition_pressure = "0.05 bar"
[components.bearing]
type = "shaft-friction"
shaft = "spool"
shaft_damping = "0.001 N*m*s"
coulomb_torque = "0 N*m"
coulomb_speed = "1 rad/s"
[run]
until = "10 ms"
"""


@pytest.fixture
def spool(here):
    (here / "spool.toml").write_text(SPOOL)
    return here


def numbers(vvdp, *options):
    answer = vvdp("observability", "spool.toml", *options, "--json", "--no-report", "--out", "out", "--force")
    assert answer.code == 0, answer.err
    return json.loads(answer.out)


def test_fixed_words(vvdp, spool):
    found = numbers(vvdp, "--speed", "22.5 rev/s", "--harmonics", "5")
    assert found["verb"] == "observability"
    assert found["observability_margin"] == pytest.approx(0.0738, abs=5e-5)
    assert found["observable"] is True
    assert found["natural_frequency_Hz"] == pytest.approx(11.464, abs=5e-4)
    assert found["lost_speeds_rev_s"] == pytest.approx([11.464, 5.732, 3.821, 2.866, 2.293], abs=5e-4)
    assert (found["observable_states"], found["states"]) == (12, 12)
    assert found["warnings"] == []
    assert 0.0 < found["observability_margin_damped"] < found["observability_margin"]
    assert found["observability_margin_with_pressure"] > 0.7
    assert found == numbers(vvdp)


def test_windows_are_those_about_the_lost_speeds(vvdp, spool):
    """Below 0.01 from 10.25 to 13.01 rev/s about the first, and within it below 0.001; nothing missed in between."""
    found = numbers(vvdp)
    rows = zip(*(found[f"windows_{key}"] for key in ("limit", "low_rad_s", "high_rad_s")), strict=True)
    windows = [(limit, low / 6.283185307, high / 6.283185307) for limit, low, high in rows]
    wide = [row[1:] for row in windows if row[0] == 0.01]
    assert wide[-1] == pytest.approx((10.25, 13.01), abs=6e-3)
    for limit in (0.01, 0.001):
        about = [row[1:] for row in windows if row[0] == limit]
        assert len(about) == 5
        assert all(low < lost < high for (low, high), lost in zip(about, found["lost_speeds_rev_s"][::-1], strict=True))


@pytest.mark.parametrize(
    ("speed", "words", "grade"),
    [("12.5 rev/s", "little to go by", "warn"), ("11.6 rev/s", "the sensor scheme fails", "bad")],
)
def test_it_warns_where_the_scheme_fails(vvdp, spool, speed, words, grade):
    found = numbers(vvdp, "--speed", speed)
    assert len(found["warnings"]) == 1
    assert words in found["warnings"][0]
    finding = read_result(spool / "out").findings[0]
    assert finding.grade == grade
    assert "measure the chamber's pressure" in finding.remedy


def test_more_harmonics(vvdp, spool):
    assert numbers(vvdp, "--harmonics", "10")["observability_margin"] == pytest.approx(0.0386, abs=5e-5)


def test_without_a_spring_nothing_is_lost(vvdp, spool):
    (spool / "spool.toml").write_text(SPOOL.replace('stiffness = "2594 N/m"', 'stiffness = "0 N/m"'))
    found = numbers(vvdp, "--speed", "9 rev/s")
    assert found["natural_frequency_Hz"] == 0.0
    assert found["lost_speeds_rev_s"] == []
    assert found["observability_margin"] == pytest.approx(0.0648, abs=5e-5)
    assert found["observable"] is True


def test_a_person_reads_the_speeds(vvdp, spool):
    answer = vvdp("observability", "spool.toml", "--out", "out")
    assert answer.code == 0
    said = " ".join(answer.out.split())
    assert "Position and velocity are lost at 11.46, 5.732, 3.821, 2.866, 2.293 rev/s." in said
    assert "10.25 to 13.01 rev/s" in said
    page = (spool / "out" / "report.html").read_text("utf-8")
    assert "Observability margin over spool speed" in page
    assert "wang2017" in page or "Wang" in page


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--speed", "-3 rev/s"), "--speed: '-3 rev/s'; expected a speed greater than zero"),
        (("--speed", "0 rpm"), "--speed: '0 rpm'; expected a speed greater than zero"),
        (("--speed", "22.5"), "--speed: '22.5' has no unit"),
        (("--speed", "22.5 Hz"), "--speed"),
        (("--harmonics", "0"), "harmonics: 0; expected a whole number, 1 to 200"),
        (("--harmonics", "2.5"), "harmonics: 2.5; expected a whole number, 1 to 200"),
        (("--of", "spool"), "'spool' is none of these: slide"),
        (("--set", "nodes.spool.speed=0 rpm"), "--speed: 0 rad/s at the start of spool; expected a speed greater"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(vvdp, spool, options, words):
    refused = vvdp("observability", "spool.toml", *options)
    assert refused.code == 2
    assert words in " ".join(refused.err.split())
    assert [path.name for path in spool.iterdir()] == ["spool.toml"]


def test_a_system_without_a_spool_to_drive_is_refused(vvdp, here):
    refused = vvdp("observability", "prototype", "--speed", "22.5 rev/s")
    assert refused.code == 2
    assert "prototype: `vvdp observability` needs what moves along its axis" in refused.err
    assert [*here.iterdir()] == []


def test_a_speed_is_asked_for_where_no_spool_turns(vvdp, here):
    refused = vvdp("observability", "cylinder-stops")
    assert refused.code == 2
    assert "--speed: missing; the circuit has no driven shaft 'spool'" in refused.err
