"""What only a process of its own can show: start-up time, clean stdout, Ctrl-C, a closed pipe."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.words import wording

import vvdp
from vvdp.simulation.results import read_results

SOURCE = str(Path(vvdp.__file__).parents[1])


@pytest.fixture
def process():
    """The arguments with which a process of `vvdp` is started."""
    environment = {**os.environ, "PYTHONPATH": SOURCE}
    return lambda *arguments: {"args": [sys.executable, "-m", "vvdp", *arguments], "env": environment, "text": True}


def test_help_names_the_verbs(process):
    answer = subprocess.run(**process("--help"), capture_output=True, check=True)
    assert "Commands:" in answer.stdout


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom vvdp.cli.main import main\n"
        "try: main(['--help'])\nexcept SystemExit: pass\n"
        "print([m for m in ('numpy', 'llvmlite', 'scipy', 'h5py', 'matplotlib', 'pint', 'rich') if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": SOURCE}
    answer = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert answer.stdout.splitlines()[-1] == "[]"


def test_stdout_holds_json_alone(process, tmp_path):
    arguments = ("run", "prototype", "--until", "0.05 s", "--json", "--no-report")
    environment_free_cache = process(*arguments)
    answer = subprocess.run(**environment_free_cache, cwd=tmp_path, capture_output=True, check=False)
    assert answer.returncode == 0, answer.stderr
    assert json.loads(answer.stdout)["finished"] is True


def test_ctrl_c_keeps_what_was_reached(process, tmp_path):
    arguments = ("run", "prototype", "--until", "200 s", "--no-report", "--out", "out", "--set", "run.window=0.01 s")
    with subprocess.Popen(
        **process(*arguments), cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        assert running.stderr is not None
        for line in running.stderr:
            if line.startswith("t = "):  # under way
                break
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=50)
    assert running.returncode == 130, err
    assert wording.progress.interrupted_at in err
    assert wording.run.interrupted in out
    kept = read_results(tmp_path / "out")
    assert kept.summary["finished"] is False
    assert kept.summary["trusted"] is True
    assert 0.0 < kept.summary["duration_s"] < 200.0
    assert kept.record.times[-1] <= kept.summary["duration_s"]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_a_reader_that_leaves_early_is_no_error(process):
    with subprocess.Popen(**process("show", "prototype"), stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        running.stdout.close()
        assert running.stderr is not None
        assert "Traceback" not in running.stderr.read()


@pytest.mark.thorough
def test_file_names_that_are_no_text(process, tmp_path):
    source = (Path(vvdp.__file__).parent / "systems" / "data" / "prototype.toml").read_bytes()
    (tmp_path / os.fsdecode(b"odd\xff.toml")).write_bytes(source)
    listed = subprocess.run(**process("list"), cwd=tmp_path, capture_output=True, check=False)
    assert listed.returncode == 0, listed.stderr
    assert "odd\\udcff.toml" in listed.stdout
    shown = subprocess.run(
        **process("show", os.fsdecode(b"odd\xff.toml")), cwd=tmp_path, capture_output=True, check=False
    )
    assert shown.returncode == 0, shown.stderr
