"""`vvdp check`."""

import platform
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from vvdp.base.errors import VvdpError
from vvdp.cli.options import AsJson

if TYPE_CHECKING:
    from vvdp.cli.table import Grid

OPENS = {
    "bench": "make bench, against other solvers",
    "cad": "geometry --step",
    "daq": "estimate, of TDMS and MDF4",
    "data": "estimate, of Parquet",
    "docs": "make docs, the documentation as a site",
    "fmi": "FMUs run in Python",
    "fmi-cross": "export fmu without a C compiler",
    "geometry": "geometry",
    "notebook": "Run.to_xarray",
    "opt": "design, its pareto and tolerance",
    "scale": "--on dask, --on slurm",
    "web": "export web, run --live",
    "workbench": "workbench",
}
"""The verbs and options that each extra opens. `dev` is left out: it is all of them and the tools of development."""
PROGRAMS = {
    "chromium": (("chromium", "chromium-browser", "google-chrome", "chrome"), "tests of pages"),
    "openfoam": (("simpleFoam",), "cfd"),
    "slurm": (("sbatch",), "--on slurm"),
}
"""Programs beside Python: the commands that each may have, and what it is for."""


@dataclass(frozen=True)
class Requirement:
    """A distribution that vvdp, or one of its extras, asks for."""

    package: str
    extra: str | None

    @property
    def version(self) -> str | None:
        """The version that is installed, None where there is none."""
        try:
            return metadata.version(self.package)
        except metadata.PackageNotFoundError:
            return None


def requirements() -> Iterator[Requirement]:
    """The requirements that the installed vvdp states. Raises VvdpError where it is not installed."""
    try:
        lines = metadata.requires("vvdp") or ()
    except metadata.PackageNotFoundError:
        raise VvdpError("vvdp is not installed here, so what it asks for is not known: pip install .") from None
    for line in lines:
        if package := re.match(r"[\w.-]+", line):
            extra = re.search(r"extra == ['\"]([\w-]+)", line)
            yield Requirement(package[0], extra[1] if extra else None)


def check(json: AsJson = False) -> None:
    """Show what vvdp finds on this machine.

    Versions of Python and libraries, the cache of compiled code, and the optional parts: which are there, what opens
    with the others, and how they are installed.
    """
    from vvdp.cli.screen import print_json

    found = _installed_version()
    if json:
        print_json(found)
    else:
        _print(found)
    if found["cache_problem"] or None in found["libraries"].values():
        typer.echo("something that vvdp needs is missing, see above", err=True)
        raise typer.Exit(1)


def _installed_version() -> dict[str, Any]:
    from vvdp.base.version import VERSION
    from vvdp.generator.binding import processor_level
    from vvdp.simulation.cache import kept_bytes
    from vvdp.simulation.crew import all_cores
    from vvdp.simulation.link import default_cache

    cache, asked = default_cache(), list(requirements())
    return {
        "vvdp": VERSION,
        "python": platform.python_version(),
        "cores": all_cores(),
        "cache_folder": str(cache),
        "cache_problem": _write_problem(cache),
        "cache_bytes": kept_bytes(cache),
        "processor_level": processor_level()[0],
        "libraries": {each.package: each.version for each in asked if each.extra is None},
        "extras": {
            extra: {"opens": opens, "packages": {each.package: each.version for each in asked if each.extra == extra}}
            for extra, opens in OPENS.items()
        },
        "programs": {
            name: {"opens": opens, "path": next(filter(None, map(shutil.which, commands)), None)}
            for name, (commands, opens) in PROGRAMS.items()
        },
    }


def _print(found: dict[str, Any]) -> None:
    from vvdp.cli.screen import console, grid
    from vvdp.simulation.cache import MOST_BYTES

    out, table = console(), grid("part", "found")
    for name in ("vvdp", "python"):
        table.add_row(name, found[name])
    for package, version in found["libraries"].items():
        table.add_row(package, version or "missing")
    table.add_row("cache folder", f"{found['cache_folder']} ({found['cache_problem'] or 'writable'})")
    size = f"{found['cache_bytes'] / 1e6:.1f} MB of at most {MOST_BYTES / 1e6:.0f}"
    table.add_row("compiled code", f"{size}, for {found['processor_level']} processors")
    table.add_row("cores", str(found["cores"]))
    out.print(table)
    out.print(_optional(found))
    wanted = [extra for extra, part in found["extras"].items() if None in part["packages"].values()]
    if wanted:
        out.print(f"what is missing comes with pip install 'vvdp[{','.join(wanted)}]'", soft_wrap=True)


def _optional(found: dict[str, Any]) -> "Grid":
    """Extras and programs: what each opens, and what of it is there."""
    from vvdp.cli.screen import grid

    table = grid("optional", "opens", "package", "found")
    for extra, part in found["extras"].items():
        names = (f"[{extra}]", part["opens"])
        for package, version in part["packages"].items():
            table.add_row(*names, package, version or "missing")
            names = ("", "")
    for name, part in found["programs"].items():
        table.add_row(name, part["opens"], "", part["path"] or "not found")
    return table


def _write_problem(folder: Path) -> str | None:
    """Why `folder` cannot be written, or None."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return None
    except OSError as problem:
        return f"not writable: {problem.strerror}; set VVDP_CACHE"
