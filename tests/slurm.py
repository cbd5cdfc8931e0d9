"""A real SLURM of one node, which a test starts for itself."""

import getpass
import os
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

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
        monkeypatch.setenv("DASK_JOBQUEUE__SLURM__DEATH_TIMEOUT", "20")
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
