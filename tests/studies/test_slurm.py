"""Studies on a real SLURM of one node, which the test starts for itself."""

import getpass
import os
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest

from vvdp.base.errors import ConfigError
from vvdp.studies.dask_engines import Slurm
from vvdp.studies.run import read_study, run_study

pytestmark = pytest.mark.slow

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")

CONFIGURATION = """
ClusterName=own
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={place}/munge.socket
CredType=cred/munge
SlurmctldPort={controller}
SlurmdPort={node}
StateSaveLocation={place}
SlurmdSpoolDir={place}/spool
SlurmctldPidFile={place}/slurmctld.pid
SlurmdPidFile={place}/slurmd.pid
SlurmctldLogFile={place}/slurmctld.log
SlurmdLogFile={place}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
MailProg=/bin/true
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=short Nodes={host} Default=YES State=UP
"""


def free_ports(count: int) -> list[int]:
    with_ports = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    found = [each.getsockname()[1] for each in with_ports]
    for each in with_ports:
        each.close()
    return found


def told(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, timeout=20).stdout.strip()


@pytest.fixture
def own_slurm(not_tested, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A SLURM with one node of two cores and the partition "short"; its commands find it by SLURM_CONF."""
    monkeypatch.setenv("PATH", f"{os.environ['PATH']}:/usr/sbin:/sbin")
    if missing := [name for name in PROGRAMS if shutil.which(name) is None]:
        not_tested(f"SLURM is not installed ({', '.join(missing)})", "slurm")
    host = socket.gethostname().partition(".")[0]
    begun: list[subprocess.Popen[bytes]] = []
    with tempfile.TemporaryDirectory(prefix="slurm-", dir="/tmp") as place:  # a socket's path must be short

        def begin(*command: str) -> None:
            quiet = subprocess.DEVNULL
            begun.append(subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, cwd=place))

        key, conf = Path(place, "munge.key"), Path(place, "slurm.conf")
        key.write_bytes(secrets.token_bytes(1024))
        key.chmod(0o400)
        controller, node = free_ports(2)
        user = getpass.getuser()
        conf.write_text(CONFIGURATION.format(host=host, user=user, place=place, controller=controller, node=node))
        monkeypatch.setenv("SLURM_CONF", str(conf))
        monkeypatch.setenv("DASK_JOBQUEUE__SLURM__DEATH_TIMEOUT", "5")
        files = (f"--{name}-file={place}/munged.{name}" for name in ("pid", "log", "seed"))
        try:
            begin("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={place}/munge.socket", *files)
            begin("slurmctld", "-D", "-c", "-f", str(conf))
            begin("slurmd", "-D", "-N", host, "-f", str(conf))
            until = time.monotonic() + 60.0
            while told("sinfo", "-h", "-o", "%t") != "idle":
                assert time.monotonic() < until, Path(place, "slurmctld.log").read_text()
                time.sleep(0.2)
            yield
        finally:
            told("scancel", "--user", user)
            until = time.monotonic() + 30.0
            while told("squeue", "-h") and time.monotonic() < until:
                time.sleep(0.2)
            for process in reversed(begun):
                process.terminate()
            for process in begun:
                process.wait(30.0)


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
    until = time.monotonic() + 60.0
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
    assert "3 cases run" in capsys.readouterr().out
    assert list((tmp_path / "out" / "slurm").glob("*.err"))


def test_no_sbatch_is_told(long_study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ConfigError, match="sbatch: is not installed here"):
        run_study(long_study, tmp_path / "s", engine=Slurm())
    assert len(read_study(long_study, tmp_path / "s").missing) == 120
