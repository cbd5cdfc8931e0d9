"""`vvdp check`."""

import os
import platform
import shutil
import tempfile
from importlib import metadata
from pathlib import Path

import typer

from vvdp.cli.options import AsJson

REQUIRED = ("numpy", "numba", "scipy", "h5py", "matplotlib", "pint", "rich", "typer")
PROGRAMS = {
    "chromium": ("chromium", "chromium-browser", "google-chrome", "chrome"),
    "openfoam": ("simpleFoam",),
    "slurm": ("sbatch",),
}


def check(json: AsJson = False) -> None:
    """Show what vvdp finds on this machine.

    These are the versions of Python and libraries, the cache of compiled code, and the optional parts.
    """
    import vvdp
    from vvdp.cli.screen import console, grid, print_json
    from vvdp.simulation.link import default_cache
    from vvdp.simulation.run import is_loop_compiled

    versions = {name: _version(name) for name in REQUIRED}
    cache, compiled = default_cache(), is_loop_compiled()
    problem = _write_problem(cache)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    optional = {"casadi": _version("casadi")} | {name: _place(programs) for name, programs in PROGRAMS.items()}
    own = {"vvdp": vvdp.__version__, "python": platform.python_version()}
    if json:
        found = {"cache": str(cache), "cache_problem": problem, "loop_compiled": compiled, "cores": cores}
        print_json({**own, **versions, **found, "optional": optional})
    else:
        table = grid("part", "found")
        for name, version in (own | versions).items():
            table.add_row(name, version or "missing")
        table.add_row("cache folder", f"{cache} ({problem or 'writable'})")
        table.add_row("simulation loop", "compiled" if compiled else "not compiled yet; the first run does it")
        table.add_row("cores", str(cores))
        for name, place in optional.items():
            table.add_row(f"{name} (optional)", place or "not found")
        console().print(table)
    if problem or None in versions.values():
        typer.echo("something that vvdp needs is missing, see above", err=True)
        raise typer.Exit(1)


def _place(programs: tuple[str, ...]) -> str | None:
    """Where the first of some programs is that is installed."""
    return next((found for program in programs if (found := shutil.which(program))), None)


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
