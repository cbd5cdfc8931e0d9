"""Exported steps on microcontrollers in QEMU: bits, instructions, and what is stated of them."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.conftest import required_program

from vvdp.base.errors import ConfigError
from vvdp.base.units import parse
from vvdp.export import c_target
from vvdp.export.c_folder import exported_folder
from vvdp.export.c_parts import Precision
from vvdp.export.c_target import CLOCK, LOAD, Load, counted_loads, late_cores, load_text
from vvdp.systems.system import load_system

EXAMPLE = Path(__file__).parents[2] / "src" / "vvdp" / "systems" / "examples" / "programs" / "speed-from-edges.toml"


@pytest.fixture
def tools():
    for name in ("make", "arm-none-eabi-gcc", "qemu-system-arm"):
        required_program(name, "arm")


def test_the_load_of_a_step_at_a_clock():
    """By hand: 277 000 instructions at 168 MHz are 1.649 ms, 1.649 of a period of 1 ms; at 300 MHz 0.923."""
    load = Load("Cortex-M4", code=23000, stack=5000, least=100, most=277_000, mean=47_000, sample=1279)
    assert "| Cortex-M4 | 23000 | 5000 | 47000 | 277000 | 1.65e+03 | 1.65 |" in load_text([load], 1e-3, 168e6)
    (warning,) = late_cores([load], 1e-3, 168e6)
    assert "on a Cortex-M4 at 168 MHz the worst sample takes 1.65 ms" in warning
    assert late_cores([load], 1e-3, 300e6) == []
    assert late_cores([load], 2e-3, 168e6) == []
    assert parse("168 MHz", CLOCK) == 168e6


def test_what_qemu_prints_is_read():
    text = (
        "Cortex-M7: code 120 bytes\nx_step: 3 of 3 samples have the same bits\n"
        "x_step: 5 to 9 instructions per sample, mean 7; most in sample 2 of 3\nx_step: stack 40 bytes\n"
    )
    found = LOAD.search(text).groupdict()
    assert found == {
        "core": "Cortex-M7",
        "code": "120",
        "least": "5",
        "most": "9",
        "mean": "7",
        "sample": "2",
        "stack": "40",
    }


def test_without_tools_nothing_is_counted_and_that_is_stated(monkeypatch):
    monkeypatch.setattr(c_target.shutil, "which", lambda _: None)
    said = []
    made = exported_folder(load_system(str(EXAMPLE)), "speed", 3, clock=168e6, say=said.append)
    assert said == ["instructions were not counted: arm-none-eabi-gcc, qemu-system-arm, make not found"]
    assert "Not known; instructions were not counted" in made.files["README.md"]
    assert made.facts["loads"] == []


def test_a_load_is_that_of_a_program():
    with pytest.raises(ConfigError, match="programs only"):
        exported_folder(load_system("prototype"), "circuit", 3, clock=1e8)


@pytest.mark.usefixtures("tools")
def test_a_step_is_counted_on_both_cores():
    """A thousand instructions more in each call are counted as such."""
    files = exported_folder(load_system("accumulator-charging"), "unloading", 20).files
    loads = counted_loads(files)
    assert [load.core for load in loads] == ["Cortex-M4", "Cortex-M7"]
    for load in loads:
        assert 10 < load.least <= load.mean <= load.most < 2000
        assert 20 < load.stack < 600
        assert 100 < load.code < 2000
    own = next(
        name for name in files if re.fullmatch(r"\w+_unloading\.c", name) and not name.startswith(("test", "loop"))
    )
    slower = files[own].replace("    return", '    __asm volatile(".rept 1000\\n nop\\n .endr");\n    return', 1)
    more = counted_loads({**files, own: slower})
    for one, other in zip(loads, more, strict=True):
        assert abs(other.most - one.most - 1000) <= 4


@pytest.mark.usefixtures("tools")
def test_the_command_states_the_load_and_warns(tmp_path):
    """In double precision by software, one sample takes longer than the period of 1 ms at 16 MHz."""
    out = tmp_path / "filter"
    words = ["export", "c", str(EXAMPLE), "--part", "speed", "--samples", "100", "--clock", "16 MHz", "--out", str(out)]
    done = subprocess.run([sys.executable, "-m", "vvdp", *words], capture_output=True, text=True, check=True)
    assert "warning: on a Cortex-M4 at 16 MHz the worst sample takes" in done.stderr
    assert re.search(r"Cortex-M7: \d+ bytes of code, at most \d+ instructions per sample", done.stdout)
    assert "## Time on a microcontroller" in (out / "README.md").read_text("utf-8")


@pytest.mark.thorough
@pytest.mark.usefixtures("tools")
@pytest.mark.parametrize("precision", list(Precision))
def test_the_event_filter_keeps_its_limits(precision):
    """Of the code, stack and worst sample; half a second of the example."""
    m4, m7 = counted_loads(exported_folder(load_system(str(EXAMPLE)), "speed", 500, precision).files)
    assert m7.most < 15_000
    if precision is Precision.SINGLE:
        assert m4.most < 30_000
        assert max(m4.stack, m7.stack) < 3500
        return
    page = (Path(__file__).parents[2] / "docs" / "c-export.md").read_text("utf-8")
    stated = re.search(r"takes up to (\d+) 000 instructions, so the period must be longer than (\S+) ms", page)
    assert m4.most == pytest.approx(1e3 * int(stated[1]), rel=0.03)
    assert int(stated[1]) / 168.0 == pytest.approx(float(stated[2]), abs=0.005)


def test_the_limits_of_the_page_are_those_of_its_table():
    page = (Path(__file__).parents[2] / "docs" / "c-export.md").read_text("utf-8")
    row = r"\| `speed-from-edges` \| `speed` \| Cortex-M\d \| \w+ \| (\d+) \| (\d+) \|"
    (single, _), (double, stack) = re.findall(row, page)
    sizes = (
        f"{int(single) / 1e3:.0f} kB of code on a Cortex-M4 in single precision, {int(double) / 1e3:.0f} kB on a Cortex"
    )
    assert sizes in page
    assert f"and {int(stack) / 1e3:.1f} kB of stack in double precision" in page


def test_all_tools_are_named():
    assert all(shutil.which(name) or name in c_target.missing_tools() for name in c_target.TOOLS)
