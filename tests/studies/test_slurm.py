"""Studies on a real SLURM of one node, which the test starts for itself."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
from tests.slurm import told
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.studies.dask_engines import Slurm
from vvdp.studies.run import read_study, run_study

pytestmark = pytest.mark.slow


def test_a_study_on_slurm_survives_everything(
    own_slurm, begin_study, awaited, kill_a_worker, kept, long_study, tmp_path: Path
) -> None:
    """The whole study is killed; then a worker is, and all jobs are cancelled; what was finished is never run again."""
    directory = tmp_path / "long"
    process = begin_study(directory, "slurm")
    awaited(lambda: kept(directory), process)
    os.killpg(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    jobs = told("squeue", "-h", "-o", "%i").split()
    assert jobs
    until = time.monotonic() + 120.0
    while told("squeue", "-h") and time.monotonic() < until:  # they look for their study, and end
        time.sleep(0.2)
    assert not told("squeue", "-h")
    first = kept(directory)
    assert 1 <= len(first) < 120
    steps: list[set[str]] = []

    def progress(done: int, total: int) -> None:
        steps.append(kept(directory))
        if len(steps) == 2:
            kill_a_worker(lambda: filter(in_job, psutil.process_iter()))
        if len(steps) == 3:
            told("scancel", *told("squeue", "-h", "-o", "%i").split())

    engine = Slurm(2, memory="1 GiB", options=["--partition=short"], interface="lo", logs=directory / "slurm")
    found = run_study(long_study, directory, engine=engine, progress=progress)
    assert found.is_finished and found.ran == 120 - len(first) and not found.failures
    assert len(steps) >= 3
    assert all(first <= step for step in steps)
    assert np.isfinite(found.outputs["efficiency"].values).all()
    here = run_study(long_study, tmp_path / "here")
    assert np.array_equal(here.outputs["efficiency"].values, found.outputs["efficiency"].values)


def in_job(process: psutil.Process) -> bool:
    """Whether a process is of a SLURM job; one that has ended, or is another user's, is not."""
    try:
        return "SLURM_JOB_ID" in process.environ()
    except psutil.Error:
        return False


def test_the_command_line_runs_a_study_on_slurm(
    own_slurm, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from vvdp.cli.main import main

    monkeypatch.setenv("DASK_JOBQUEUE__SLURM__INTERFACE", "lo")
    file = tmp_path / "duty.toml"
    text = 'system = "prototype"\nuntil = "0.1 s"\noutputs = ["efficiency"]\n[grid]\n'
    file.write_text(text + '"operation.duty_ratio" = ["0.3", "0.5", "0.7"]\n')
    words = ["study", str(file), "--out", str(tmp_path / "out"), "--on", "slurm"]
    with pytest.raises(SystemExit) as ended:
        main([*words, "--sbatch=--partition=nowhere"])
    assert ended.value.code == 2
    assert "sbatch: " in (said := capsys.readouterr().err) and "partition" in said
    main_ended = None
    try:
        main([*words, "--workers", "1", "--sbatch=--partition=short", "--sbatch=--mem=1G"])
    except SystemExit as problem:
        main_ended = problem.code
    assert not main_ended, capsys.readouterr().err
    assert wording.study.cases_run.format(count=3) in capsys.readouterr().err
    assert list((tmp_path / "out" / "slurm").glob("*.err"))


def test_no_sbatch_is_told(long_study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ConfigError, match=wording.engine.not_installed.format(program="sbatch")):
        run_study(long_study, tmp_path / "s", engine=Slurm())
    assert len(read_study(long_study, tmp_path / "s").missing) == 120
