"""`vvdp observability`: the numbers of the spool of chapter 5, what it says of them, and what it refuses."""

import json
import re
import shlex
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.results.store import read_result

SPRING = """
[nodes]
slide = { type = "rod", position = "0 mm" }
[components.spring]
type = "spring"
rod = "slide"
stiffness = "STIFFNESS"
preload = "0 N"
rest_position = "0 mm"
[components.weight]
type = "weight"
rod = "slide"
mass = "0.5 kg"
slope = "0 deg"
[run]
until = "10 ms"
"""


def numbers(vvdp, system, *options):
    answer = vvdp("observability", system, *options, "--json", "--no-report", "--out", "out", "--force")
    assert answer.code == 0, answer.err
    return json.loads(answer.out)


def test_fixed_words(vvdp, here, keys_as_described):
    found = numbers(vvdp, "axial-chamber", "--speed", "22.5 rev/s", "--harmonics", "5")
    keys_as_described("observability", found)
    assert found["verb"] == "observability"
    assert found["observability_margin"] == pytest.approx(0.0738, abs=5e-5)
    assert found["observable"] is True
    assert found["natural_frequency_Hz"] == pytest.approx(11.464, abs=5e-4)
    assert found["lost_speeds_rev_s"] == pytest.approx([11.464, 5.732, 3.821, 2.866, 2.293], abs=5e-4)
    assert (found["observable_states"], found["states"]) == (12, 12)
    assert found["warnings"] == []
    assert 0.0 < found["observability_margin_damped"] < found["observability_margin"]
    assert found["observability_margin_with_pressure"] > 0.7
    assert found == numbers(vvdp, "axial-chamber")  # speed and harmonics are those of the system


def test_a_stiff_spring_is_not_refused_for_what_the_supply_reaches(vvdp, here):
    """9 kN/m at 5.25 mm take more than the 13.1 bar that there are; sqrt(9000/0.5)/(2 pi) = 21.35 Hz."""
    found = numbers(vvdp, "axial-chamber", "--set", "parts.drive.stiffness=9000 N/m")
    assert found["natural_frequency_Hz"] == pytest.approx(21.35, abs=0.01)


@pytest.mark.parametrize("system", ["vvdp-duty-control", "displacement-control"])
def test_a_weak_supply_is_no_matter_of_sight(vvdp, here, system):
    """5 bar do not hold the spool anywhere; where the sensor sees does not depend on that."""
    weak = numbers(vvdp, system, "--speed", "22.5 rev/s", "--set", "pilot.supply_pressure=5 bar")
    own = numbers(vvdp, system, "--speed", "22.5 rev/s")
    assert weak["observability_margin"] == pytest.approx(own["observability_margin"], rel=1e-9)


def test_windows_are_those_about_the_lost_speeds(vvdp, here):
    """Below 0.01 from 10.25 to 13.01 rev/s about the first, and within it below 0.001; nothing missed in between."""
    found = numbers(vvdp, "axial-chamber")
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
    [
        ("12.5 rev/s", wording.observability.little_to_go_by, "warn"),
        ("11.6 rev/s", wording.observability.scheme_fails, "bad"),
    ],
)
def test_it_warns_where_the_scheme_fails(vvdp, here, speed, words, grade):
    found = numbers(vvdp, "axial-chamber", "--speed", speed)
    assert len(found["warnings"]) == 1
    assert words in found["warnings"][0]
    finding = read_result(here / "out").findings[0]
    assert finding.grade == grade
    assert wording.observability.measure_chamber in finding.remedy


def test_more_harmonics(vvdp, here):
    assert numbers(vvdp, "axial-chamber", "--harmonics", "10")["observability_margin"] == pytest.approx(
        0.0386, abs=5e-5
    )


@pytest.mark.parametrize(("stiffness", "hertz"), [("2594 N/m", 11.464), ("0 N/m", 0.0)])
def test_any_rod_will_do(vvdp, here, stiffness, hertz):
    """Without a spring nothing is lost; without a chamber there is no pressure to be measured."""
    (here / "spring.toml").write_text(SPRING.replace("STIFFNESS", stiffness))
    found = numbers(vvdp, "spring.toml", "--speed", "22.5 rev/s")
    assert found["natural_frequency_Hz"] == pytest.approx(hertz, abs=5e-4)
    assert len(found["lost_speeds_rev_s"]) == (5 if hertz else 0)
    assert found["observability_margin"] == pytest.approx(0.0738 if hertz else 0.0648, abs=5e-5)
    assert found["observable"] is True
    assert "observability_margin_with_pressure" not in found


def test_a_spool_that_a_flow_moves_is_seen_at_every_speed(vvdp, here):
    found = numbers(vvdp, "axial-gerotor")
    assert (found["observability_margin"], found["observable"], found["natural_frequency_Hz"]) == (2.0, True, 0.0)
    assert (found["observable_states"], found["states"]) == (11, 11)
    assert found["lost_speeds_rev_s"] == []
    assert "mass_kg" not in found


def test_a_person_reads_the_speeds(vvdp, here, is_shown):
    """As the guide has it."""
    guide = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text("utf-8")
    (command, shown), *_ = re.findall(r"^    \$ vvdp (observability .*)\n((?:    .*\n|\n)*)", guide, re.MULTILINE)
    answer = vvdp(*shlex.split(command))
    assert answer.code == 0
    assert is_shown(re.sub("^    ", "", shown, flags=re.MULTILINE), answer.out)
    assert "10.25 to 13.01 rev/s" in answer.out
    page = (here / "results" / "seen" / "report.html").read_text("utf-8")
    assert wording.observability.margin in page
    assert "wang2017" in page or "Wang" in page


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--speed", "-3 rev/s"), "--speed: " + wording.files.must_be_greater_than_zero.format(value="'-3 rev/s'")),
        (("--speed", "0 rpm"), "--speed: " + wording.files.must_be_greater_than_zero.format(value="'0 rpm'")),
        (("--speed", "22.5"), "--speed: '22.5' " + wording.files.has_no_unit),
        (("--speed", "22.5 Hz"), "--speed"),
        (("--harmonics", "0"), "harmonics: " + wording.observability.harmonics.format(value=0, low=1, high=200)),
        (("--harmonics", "2.5"), "harmonics: " + wording.observability.harmonics.format(value=2.5, low=1, high=200)),
        (("--of", "spool"), wording.observability.none_of_these.format(part="spool", parts="drive_slide")),
        (
            ("--set", "nodes.spool.speed=0 rpm"),
            "--speed: " + wording.observability.speed_at_start.format(speed="0 rpm", system="axial-chamber"),
        ),
    ],
)
def test_bad_input_is_refused(vvdp, here, options, words):
    refused = vvdp("observability", "axial-chamber", *options)
    assert refused.code == 2
    assert words in " ".join(refused.err.split())
    assert [*here.iterdir()] == []


def test_a_system_without_a_spool_to_drive_is_refused(vvdp, here):
    refused = vvdp("observability", "prototype", "--speed", "22.5 rev/s")
    assert refused.code == 2
    assert "prototype: " + wording.observability.needs_axis in refused.err
    assert [*here.iterdir()] == []


def test_a_speed_is_asked_for_where_no_spool_turns(vvdp, here):
    refused = vvdp("observability", "cylinder-stops")
    assert refused.code == 2
    assert "--speed: " + wording.observability.no_axial_sensor.format(system="cylinder-stops") in refused.err
