"""`vvdp run --watch`, and what else shows compiled code: `--checked`, `vvdp show --llvm`."""

import os
import signal
import subprocess
import sys
import time

import pytest
from tests.words import wording

PRESS = """
[nodes]
tank = {{ type = "tank" }}
rail = {{ type = "volume", volume = "100 cc", start = "0 bar" }}

[components]
pump = {{ type = "flow-source", a = "tank", b = "rail", flow = "20 lpm" }}
load = {{ type = "orifice", a = "rail", b = "tank", area = "{area}" }}

[run]
until = "0.8 s"
"""
PATIENCE = 60.0


@pytest.fixture
def watched(tmp_path):
    """A press that is watched: writes an area and returns what is printed until vvdp waits again."""
    file, output = tmp_path / "press.toml", tmp_path / "output.txt"
    file.write_text(PRESS.format(area="4 mm^2"))
    with output.open("w") as stream:
        process = subprocess.Popen(
            [sys.executable, "-u", "-m", "vvdp", "run", "press.toml", "--watch"],
            cwd=tmp_path, stdout=stream, stderr=subprocess.STDOUT, env={**os.environ, "COLUMNS": "120"},
        )  # fmt: skip
        seen = [0]

        def saved(area=None):
            if area is not None:
                file.write_text(PRESS.format(area=area))
            began = time.monotonic()
            while wording.run.watching not in output.read_text()[seen[0] :]:
                assert time.monotonic() - began < PATIENCE and process.poll() is None, output.read_text()
                time.sleep(0.02)
            text = output.read_text()
            found, seen[0] = text[seen[0] :], len(text)
            return found

        yield saved
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0


def test_a_saved_file_runs_again_and_what_changed_is_printed(watched, tmp_path):
    """4 to 5 mm2 at one flow: the drop falls by the square of the areas, to 0.64 of 79.29 bar, 50.7 (51.0 with the
    laminar part and the oil's compression)."""
    assert "79.29" in watched()
    changed = watched("5 mm^2")
    assert "79.2867 bar" in changed and "50.9671 bar" in changed
    assert "mmm^2" in watched("5 mmm^2")
    assert "79.2867 bar" in watched("4 mm^2")
    assert {path.name for path in tmp_path.iterdir()} == {"press.toml", "output.txt"}


def test_only_a_file_can_be_watched(vvdp, here):
    answer = vvdp("run", "prototype", "--watch")
    assert answer.code == 2
    assert wording.run.no_file_to_watch in answer.err
    assert vvdp("run", "press.toml", "--watch", "--out", "there").code == 2


def test_checked_code_gives_the_same_numbers(vvdp, here):
    (here / "press.toml").write_text(PRESS.format(area="4 mm^2"))
    plain, checked = (
        vvdp("run", "press.toml", "--no-report", "--json", "--out", name, *more).out
        for name, more in (("plain", ()), ("checked", ("--checked",)))
    )
    lines = [[line for line in text.splitlines() if "wall_time" not in line] for text in (plain, checked)]
    same = [line for one, line in zip(*lines, strict=True) if one == line]
    assert len(same) >= len(lines[0]) - 2  # the folder, and the speed


def test_llvm_text_of_a_circuit_has_its_functions_and_lines(vvdp, here):
    (here / "press.toml").write_text(PRESS.format(area="4 mm^2"))
    text = vvdp("show", "press.toml", "--llvm").out
    assert text.startswith("; the circuit: rates, stop, events")
    assert 'define void @"rates"' in text and "DILocation(line:" in text
    assert text == vvdp("show", "press.toml", "--llvm").out
