"""Completion in shells: verbs, options, systems and the keys of `--set`, asked as a shell asks."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import vvdp as package

SOURCE = str(Path(package.__file__).parents[1])


@pytest.fixture
def offered(tmp_path):
    """What bash is offered for the last of some words."""

    def ask(*words: str) -> list[str]:
        line = {"COMP_WORDS": " ".join(("vvdp", *words)), "COMP_CWORD": str(len(words))}
        answer = subprocess.run(
            [sys.executable, "-m", "vvdp"], cwd=tmp_path, capture_output=True, text=True, check=True,
            env={**os.environ, "PYTHONPATH": SOURCE, "_VVDP_COMPLETE": "complete_bash", **line},
        )  # fmt: skip
        assert answer.stderr == ""
        return answer.stdout.split("\n")[:-1]

    return ask


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("ma",), ["map"]),
        (("rig", "pr"), ["pressure-drop"]),
        (("run", "prototype", "--no"), ["--no-report", "--no-ranges"]),
        (("run", "proto"), ["prototype", "prototype-constant-load"]),
        (("design", "prototype-"), ["prototype-constant-load"]),
        (("new", "mine", "--from", "buck"), ["buck-converter"]),
        (("run", "mi"), ["mine.toml"]),
        (("run", "su"), ["sub/"]),
        (("run", "sub/"), ["sub/other.toml"]),
        (("run", "prototype", "--set", "operation.duty"), ["operation.duty_ratio=", "operation.duty_ratio=0.5"]),
        (("design", "prototype", "--set", "pump.displ"), ["pump.displacement=", "pump.displacement=22.8 cc/rev"]),
        (("run", "mine.toml", "--set", "oil.reference"), ["oil.reference_pressure=", "oil.reference_pressure=0 bar"]),
        (("run", "nothing-such", "--set", "o"), [""]),
    ],
)
def test_what_is_offered(offered, tmp_path, words, expected):
    (tmp_path / "sub").mkdir()
    source = Path(SOURCE) / "vvdp" / "systems" / "data" / "prototype.toml"
    for name in ("mine.toml", "sub/other.toml"):
        shutil.copy(source, tmp_path / name)
    (tmp_path / "minutes.txt").write_text("not a system")
    assert offered(*words) == expected


def test_all_keys_of_a_table_are_offered(offered):
    found = offered("run", "prototype", "--set", "operation.")
    assert {"operation.duty_ratio=", "operation.pump_speed=", "operation.oil_temperature="} <= set(found)
    assert all(key.startswith("operation.") and key.endswith("=") for key in found)


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_uses_the_script_that_is_shown(tmp_path):
    command = tmp_path / "vvdp"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m vvdp "$@"\n')
    command.chmod(0o755)
    environment = {**os.environ, "PYTHONPATH": SOURCE, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    script = (
        'eval "$(_VVDP_COMPLETE=source_bash vvdp)"; COMP_WORDS=(vvdp rig cl); COMP_CWORD=2; _vvdp_completion vvdp; '
    )
    answer = subprocess.run(
        ["bash", "-c", f'{script} complete -p vvdp; echo "${{COMPREPLY[@]}}"'],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert answer.stdout.splitlines() == ["complete -o default -F _vvdp_completion vvdp", "claims"], answer.stderr


@pytest.mark.parametrize(("shell", "sign"), [("bash", "complete -o"), ("zsh", "#compdef vvdp"), ("fish", "complete")])
def test_there_is_a_script_for_each_shell(shell, sign):
    environment = {**os.environ, "PYTHONPATH": SOURCE, "_VVDP_COMPLETE": f"source_{shell}"}
    answer = subprocess.run([sys.executable, "-m", "vvdp"], env=environment, capture_output=True, text=True, check=True)
    assert sign in answer.stdout
