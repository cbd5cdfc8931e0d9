"""`vvdp export c`."""

import json

from tests.words import wording


def test_a_program_is_exported(vvdp, here, keys_as_described):
    answer = vvdp("export", "c", "accumulator-charging", "--part", "unloading", "--out", "u", "--samples", "5")
    assert answer.code == 0, answer.err
    assert wording.export.c_samples.format(samples=5) in answer.out
    files = {path.name for path in (here / "u").iterdir()}
    assert {"accumulator_charging_unloading.h", "Makefile", "README.md", "vectors.h"} <= files
    again = vvdp("export", "c", "accumulator-charging", "--part", "unloading", "--out", "u", "--json", "--force")
    found = json.loads(again.out)
    keys_as_described("export c", found)
    assert found["memory_bytes"] == 8
    assert found["settings_bytes"] == 16
    assert set(found["files"]) == files - {"vvdp.json"}


def test_values_are_those_of_the_command(vvdp, here):
    for value in ("0.3", "0.4"):
        answer = vvdp(
            "export",
            "c",
            "buck-converter",
            "--out",
            value,
            "--samples",
            "2",
            "--set",
            f"components.valve.duty_ratio={value}",
        )
        assert answer.code == 0, answer.err
        assert f".duty_ratio = {value}," in (here / value / "buck_converter_circuit.c").read_text("utf-8")


def test_wrong_inputs_are_reported_and_leave_nothing(vvdp, here):
    unknown = vvdp("export", "c", "prototype", "--part", "encodr", "--out", "x")
    assert unknown.code == 2
    assert "encoder" in unknown.err
    (here / "kept").mkdir()
    (here / "kept" / "notes.txt").write_text("mine")
    assert vvdp("export", "c", "prototype", "--part", "encoder", "--out", "kept", "--force").code == 2
    assert vvdp("export", "c", "nothing-of-the-kind", "--out", "y").code == 2
    assert sorted(path.name for path in here.iterdir()) == ["kept"]
