"""OpenFOAM as separate programs: where it is, which version, and the environment that its programs need."""

import os
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.base.errors import VvdpError

OLDEST = 1912
"""The version that everything was tried on; later ones of openfoam.com read the same dictionaries."""
INSTALL = "apt-get install openfoam"
SHIPPED = Path("/usr/share/openfoam")
FOLDER = "WM_PROJECT_DIR"
PROGRAMS = ("blockMesh", "surfaceFeatureExtract", "snappyHexMesh", "renumberMesh", "checkMesh", "simpleFoam")


class MissingProgramError(VvdpError):
    """A program that vvdp starts is not on this machine, or too old."""


class OpenFoam(NamedTuple):
    """An installed OpenFOAM: its version as YYMM, and the folder of what all cases share."""

    version: int
    folder: Path

    @property
    def environment(self) -> Mapping[str, str]:
        """The variables with which its programs are started.

        Those of a SLURM job are left out: mpirun would start its processes by srun, one for each task, and vvdp has
        one task with several cores. Nor does it bind them, since cases side by side would all be bound to core 0.
        """
        root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"} if os.geteuid() == 0 else {}
        own = {name: value for name, value in os.environ.items() if not name.startswith("SLURM_")}
        return {**own, FOLDER: str(self.folder), "OMPI_MCA_hwloc_base_binding_policy": "none", **root}

    def command(self, words: Sequence[str], cores: int = 1) -> tuple[str, ...]:
        """The command that starts a program, on several cores where there are."""
        return tuple(words) if cores == 1 else ("mpirun", "-np", str(cores), *words, "-parallel")


def find_openfoam() -> OpenFoam:
    """The OpenFOAM of this machine. Raises MissingProgramError, with the command that installs it."""
    for program in PROGRAMS:
        if shutil.which(program) is None:
            raise MissingProgramError(
                f"the flow is computed by OpenFOAM, and its program {program} is not installed: {INSTALL} "
                f"(Debian, version {OLDEST}; any later version of openfoam.com will do)"
            )
    told = os.environ.get(FOLDER)
    folder = Path(told) if told else SHIPPED
    if not (folder / "etc" / "controlDict").is_file():
        raise MissingProgramError(f"OpenFOAM has no file etc/controlDict in {folder}: set {FOLDER} to its folder")
    found = OpenFoam(_version(folder), folder)
    if found.version < OLDEST:
        raise MissingProgramError(
            f"OpenFOAM {found.version} is too old; version {OLDEST} or later is needed: {INSTALL}"
        )
    return found


def _version(folder: Path) -> int:
    """The version as simpleFoam shows it; openfoam.org counts differently, and its dictionaries differ."""
    help_text = subprocess.run(
        ["simpleFoam", "-help"], capture_output=True, text=True, env={**os.environ, FOLDER: str(folder)}, check=False
    ).stdout
    match = re.search(r"OpenFOAM-\S*\s+\((\d{4})\)", help_text)
    if match is None:
        raise MissingProgramError(
            f"simpleFoam does not show a version of openfoam.com ({OLDEST} or later is needed): {INSTALL}"
        )
    return int(match[1])
