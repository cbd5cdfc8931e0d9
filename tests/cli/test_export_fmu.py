"""`vvdp export fmu`."""

import json
import zipfile

import pytest


def test_a_system_is_exported(vvdp, here, keys_as_described):
    words = (
        "export",
        "fmu",
        "accumulator-charging",
        "--fmi",
        "2",
        "--out",
        "a.fmu",
        "--input",
        "nodes.shaft.speed=speed",
    )
    answer = vvdp(*words)
    assert answer.code == 0, answer.err
    assert "a.fmu" in answer.out
    assert zipfile.is_zipfile(here / "a.fmu")
    assert vvdp(*words).code == 2
    again = vvdp(*words, "--force", "--json")
    found = json.loads(again.out)
    keys_as_described("export fmu", found)
    assert found["inputs"] == ["speed"]
    with zipfile.ZipFile(here / "a.fmu") as file:
        assert sorted(file.namelist()) == found["files"]
        assert b'name="speed"' in file.read("modelDescription.xml")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--kind", "se"), "expected cs, me, both"),
        (("--platform", "amiga"), "expected one of x86_64-linux"),
        (("--input", "nodes.shaft.sped"), "did you mean 'nodes.shaft.speed'"),
        (("--output", "pump_lin"), "did you mean 'pump_line'"),
        (("--set", "nodes.shaft.speed=x"), "nodes.shaft.speed"),
    ],
)
def test_wrong_inputs_are_reported_and_leave_nothing(words, reason, vvdp, here):
    answer = vvdp("export", "fmu", "accumulator-charging", "--out", "a.fmu", *words)
    assert answer.code == 2
    assert reason in answer.err
    assert "Traceback" not in answer.err
    assert not list(here.iterdir())


def test_a_path_that_cannot_be_written_is_named(vvdp, here):
    answer = vvdp("export", "fmu", "accumulator-charging", "--out", "none/a.fmu")
    assert answer.code == 1
    assert "none/a.fmu" in answer.err
    assert not list(here.iterdir())
