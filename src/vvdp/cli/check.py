"""`vvdp check`."""

import os
import platform
import shutil
import tempfile
from importlib import metadata
from pathlib import Path

import typer

REQUIRED = ("numpy", "numba", "scipy", "h5py", "matplotlib", "pint", "rich", "typer")
PROGRAMS = {
    "chromium": ("chromium", "chromium-browser", "google-chrome", "chrome"),
    "openfoam": ("simpleFoam",),
    "slurm": ("sbatch",),
}


def check() -> None:
    """Show what vvdp finds on this machine.

    Versions of Python and libraries, the cache of compiled code, and the optional parts.
    """
    import vvdp
    from vvdp.cli.screen import console, grid
    from vvdp.simulation.link import default_cache
    from vvdp.simulation.run import is_loop_compiled

    versions = {name: _version(name) for name in REQUIRED}
    cache = default_cache()
    problem = _write_problem(cache)
    table = grid("part", "found")
    table.add_row("vvdp", vvdp.__version__)
    table.add_row("python", platform.python_version())
    for name, version in versions.items():
        table.add_row(name, version or "missing")
    table.add_row("cache folder", f"{cache} ({problem or 'writable'})")
    table.add_row("simulation loop", "compiled" if is_loop_compiled() else "not compiled yet; the first run does it")
    table.add_row("cores", str(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()))
    casadi = _version("casadi")
    table.add_row("casadi (optional)", casadi or "not found")
    for name, programs in PROGRAMS.items():
        place = next((found for program in programs if (found := shutil.which(program))), None)
        table.add_row(f"{name} (optional)", place or "not found")
    console().print(table)
    if problem or None in versions.values():
        typer.echo("something that vvdp needs is missing, see above", err=True)
        raise typer.Exit(1)


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _write_problem(folder: Path) -> str | None:
    """Why `folder` cannot be written, or None."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return None
    except OSError as problem:
        return f"not writable: {problem.strerror}; set VVDP_CACHE"
