"""MISRA C:2012, as far as the add-on of cppcheck knows it, for the text of a whole system."""

import re
import subprocess
from pathlib import Path

import pytest
from tests.conftest import required_program

from vvdp.export.c_machine import c_machine
from vvdp.systems.system import load_system

ADVISORY = {"2.5", "8.9", "10.5", "12.1", "12.3", "15.4", "15.5", "17.8", "18.4", "19.2", "20.1"}
"""Rules of the category advisory that the text does not keep: those that the page names."""
GIVEN = ("FLT_EVAL_METHOD=0", "__x86_64__=1", "__GLIBC__=2", "__GNUC__=12")
"""What a compiler for Linux defines."""


def test_the_page_names_the_rules():
    page = (Path(__file__).parents[2] / "docs" / "c-export.md").read_text("utf-8")
    (found,) = re.findall(r"these are not kept: ([\d., ]+) \(", page)
    assert set(found.split(", ")) == ADVISORY


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["accumulator-charging", "prototype", "displacement-control"])
def test_no_required_rule_is_violated(name, tmp_path):
    made = c_machine(load_system(name))
    for end in ("h", "c"):
        (tmp_path / f"{made.name}_core.{end}").write_text(made.core.header if end == "h" else made.core.source)
    cppcheck = [required_program("cppcheck"), "--std=c99", "--addon=misra", "--enable=warning,portability", "-q"]
    given = [*(f"-D{each}" for each in GIVEN), "--suppress=unknownEvaluationOrder"]  # it reads `.a = x` as an effect
    words = [*cppcheck, *given, "--template={id} {line}: {message}", f"{made.name}_core.c"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    found = {rule.removeprefix("misra-c2012-") for rule in re.findall(r"^\S+", done.stderr, re.M)}
    assert found - ADVISORY == set(), done.stderr
    assert len(found) > 3, "the add-on was not at work"
