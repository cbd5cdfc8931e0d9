"""The engine that a command's options name: where many cases are run."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

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


def chosen_engine(
    on: str, workers: int | None, cores: int | None, sbatch: list[str] | None, directory: Path
) -> "Engine":
    """The engine that the options name; what SLURM jobs print goes to a folder in `directory`.

    Raises ConfigError with every option that does not go with `on`, and where `on` is no place; MissingExtraError where
    Dask is not installed, before anything is written.
    """
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.extras import require
    from vvdp.cli.screen import say
    from vvdp.studies.engine import ThisProcess

    is_address = ":" in on
    faults = []
    if on not in (HERE, DASK, SLURM) and not is_address:
        expected = f"expected {HERE}, {DASK}, {SLURM} or an address such as tcp://head:8786"
        faults.append(Fault("--on", 0, "", f"{on!r}; {expected}"))
    if workers is not None and (on == HERE or is_address):
        faults.append(Fault("--workers", 0, "", f"{workers} workers cannot be had with --on {on}"))
    if cores is not None and is_address:
        faults.append(Fault("--cores", 0, "", f"{cores} cores: the workers of {on} have theirs already"))
    if sbatch and on != SLURM:
        faults.append(Fault("--sbatch", 0, "", f"nothing is given to sbatch with --on {on}"))
    if faults:
        raise ConfigError(faults)
    if on == HERE:
        return ThisProcess(cores)
    require("dask_jobqueue" if on == SLURM else "distributed", "scale", f"--on {on}")

    from vvdp.studies.dask_engines import DaskScheduler, LocalDask, Slurm

    if on == DASK:
        return LocalDask(workers, cores or 1, say=say)
    if on == SLURM:
        logs = (directory / "slurm").resolve()
        return Slurm(workers or 1, cores or 1, options=tuple(sbatch or ()), logs=logs, say=say)
    return DaskScheduler(on, say=say)
