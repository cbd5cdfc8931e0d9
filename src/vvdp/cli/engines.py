"""The engine that a command's options name: where many cases are run."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.options import Output, Restart

if TYPE_CHECKING:
    from vvdp.studies.engine import Engine

HERE, DASK, SLURM = "here", "dask", "slurm"

On = Annotated[
    str,
    typer.Option(
        "--on",
        metavar="WHERE",
        help=f"Where to compute: {HERE} (this process), {DASK} (local worker processes), {SLURM} (batch jobs), or the "
        "address of a Dask scheduler, for example tcp://head:8786.",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", min=1, help=f"Number of workers, with --on {DASK} or --on {SLURM}."),
]
Cores = Annotated[
    int | None,
    typer.Option("--cores", metavar="N", min=1, help="Number of cores per worker (default: all, if computed here)."),
]
Sbatch = Annotated[
    list[str] | None,
    typer.Option(
        "--sbatch",
        metavar="OPTION",
        help=f"Option passed on to sbatch, with --on {SLURM}, for example --sbatch=--partition=short (repeatable).",
    ),
]


@dataclass(frozen=True)
class Engines:
    """Options: where many cases are run."""

    on: On = HERE
    workers: Workers = None
    cores: Cores = None
    sbatch: Sbatch = None

    def engine(self, directory: Path) -> "Engine":
        """The engine that the options name; what SLURM jobs print goes to a folder in `directory`.

        Raises ConfigError with every option that does not go with `on`, and where `on` is no place; MissingExtraError
        where Dask is not installed, before anything is written.
        """
        from vvdp.base.errors import ConfigError, Fault
        from vvdp.base.extras import require
        from vvdp.cli.screen import say
        from vvdp.studies.engine import ThisProcess

        is_address = ":" in self.on
        faults = []
        if self.on not in (HERE, DASK, SLURM) and not is_address:
            expected = f"expected {HERE}, {DASK}, {SLURM} or an address such as tcp://head:8786"
            faults.append(Fault("--on", 0, "", f"{self.on!r}; {expected}"))
        if self.workers is not None and (self.on == HERE or is_address):
            faults.append(Fault("--workers", 0, "", f"{self.workers} workers cannot be had with --on {self.on}"))
        if self.cores is not None and is_address:
            faults.append(Fault("--cores", 0, "", f"{self.cores} cores: the workers of {self.on} have theirs already"))
        if self.sbatch and self.on != SLURM:
            faults.append(Fault("--sbatch", 0, "", f"nothing is given to sbatch with --on {self.on}"))
        if faults:
            raise ConfigError(faults)
        if self.on == HERE:
            return ThisProcess(self.cores)
        require("dask_jobqueue" if self.on == SLURM else "distributed", "scale", f"--on {self.on}")

        from vvdp.studies.dask_engines import DaskScheduler, LocalDask, Slurm

        if self.on == DASK:
            return LocalDask(self.workers, self.cores or 1, say=say)
        if self.on == SLURM:
            logs = (directory / "slurm").resolve()
            return Slurm(self.workers or 1, self.cores or 1, options=tuple(self.sbatch or ()), logs=logs, say=say)
        return DaskScheduler(self.on, say=say)


@dataclass(frozen=True)
class Spread(Engines, Output):
    """Options of a command that runs many cases: where it writes, where they are run, what is shown."""


@dataclass(frozen=True)
class Resumable(Spread):
    """The same for a command that keeps what an earlier call has finished."""

    force: Restart = False

    def directory(self, name: str) -> Path:
        """Where to write; without --out the directory under `results` that a call before has written to."""
        return self.out if self.out is not None else Path("results", name)

    @property
    def shared_cores(self) -> int:
        """The cores that share the work, as far as options or this machine say."""
        from vvdp.simulation.crew import all_cores

        return (self.workers or 1) * (self.cores or (1 if self.workers else all_cores()))
