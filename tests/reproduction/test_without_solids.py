"""What the extra for solids brings is asked for by the drawings that need it, not by the list or an estimate."""

import subprocess
import sys

import pytest

WITHOUT = """
import importlib.util, sys
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name in {"manifold3d", "trimesh"} else found(name, *rest)
sys.modules |= {"manifold3d": None, "trimesh": None}
from vvdp.cli.main import main
main(sys.argv[1:])
"""


def reproduce(*words):
    return subprocess.run(
        [sys.executable, "-c", WITHOUT, "reproduce", *words], capture_output=True, text=True, check=False
    )


@pytest.mark.thorough
def test_items_are_listed_and_those_without_solids_worked_out(tmp_path):
    listed = reproduce("--list")
    assert listed.returncode == 0 and "figure-3.9" in listed.stdout
    assert "unknown item; did you mean 'figure-5.9'" in reproduce("9.99").stderr
    made = reproduce("2.2", "equation-2.3", "--no-report", "--out", str(tmp_path / "out"))
    assert made.returncode == 0, made.stderr
    assert "manifold3d" in made.stdout
