"""A case for OpenFOAM as data: its files, what makes its mesh, its phases, and what is watched."""

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from vvdp.base.files import write_whole
from vvdp.cfd.boundary import Patch, field_files
from vvdp.cfd.convergence import History
from vvdp.cfd.dictionary import Entry
from vvdp.cfd.numerics import STEADY, Phase, control_text, property_files, schemes_text, solution_text
from vvdp.cfd.quality import quality_monitors
from vvdp.cfd.turbulence import Inflow, Turbulence


class Fluid(NamedTuple):
    """The oil: density [kg/m^3] and dynamic viscosity [Pa s], both constant."""

    density: float
    viscosity: float


class Case(NamedTuple):
    """A flow to be computed.

    mesh_files     dictionaries of the programs that make the mesh, and the surface where there is one, by path
    mesh_programs  what makes the mesh, one after the other
    monitors       function objects by name, which write what is watched at each iteration
    read_history   reads what they have written in the folder of the case
    largest        size of the value that is watched beyond which the run diverges
    further_files  what else the solver reads, by path
    step           of time [s] where the flow is unsteady; it begins with the flow of the case whose mesh it has
    """

    mesh_files: Mapping[str, str]
    mesh_programs: tuple[tuple[str, ...], ...]
    patches: Mapping[str, Patch]
    monitors: Mapping[str, Mapping[str, Entry]]
    read_history: Callable[[Path], History]
    fluid: Fluid
    turbulence: Turbulence
    start: Inflow
    phases: tuple[Phase, ...]
    largest: float
    further_files: Mapping[str, str] = MappingProxyType({})
    step: float = STEADY

    @property
    def identity(self) -> str:
        """The identity of this case: all its files, and its phases."""
        files = sorted({**self.mesh_files, **start_files(self)}.items())
        pace = () if self.step == STEADY else (self.step,)
        parts = (files, self.mesh_programs, self.monitors, self.phases, *pace)
        return hashlib.sha256(repr(parts).encode()).hexdigest()


def start_files(case: Case) -> dict[str, str]:
    """Fields at the start and properties, by path."""
    nu = case.fluid.viscosity / case.fluid.density
    fields = field_files(case.patches, case.turbulence, case.start)
    return fields | property_files(nu, case.turbulence) | dict(case.further_files)


def phase_files(case: Case, phase: Phase, end: int) -> dict[str, str]:
    """The control files, by path, of a phase that ends at the iteration `end`."""
    monitors = {**case.monitors, **quality_monitors(case.turbulence)}
    return {
        "system/controlDict": control_text(end, monitors, case.step),
        "system/fvSchemes": schemes_text(phase, unsteady=case.step != STEADY),
        "system/fvSolution": solution_text(phase),
    }


def write_files(folder: Path, files: Mapping[str, str]) -> None:
    """Writes files by their paths below a folder."""
    for path, text in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        write_whole(folder / path, text)
