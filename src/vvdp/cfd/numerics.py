"""How the equations of steady flow are solved: schemes, solvers, relaxation, and what is written on the way."""

from collections.abc import Mapping
from typing import NamedTuple

from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.cfd.turbulence import Turbulence

STOP = "stop"
"""File in a case that makes its solver write what it has reached, and end."""
INTERVAL = 20
"""Iterations from one state on the disk to the next; what is lost where a solver is killed."""
KEPT = 2
"""States that are kept on the disk beside the start."""


STEADY = 1.0
"""Counts iterations instead of seconds."""


def solver(step: float) -> str:
    """The program that solves steady flow, or unsteady flow in steps of so many seconds."""
    return "simpleFoam" if step == STEADY else "pimpleFoam"


class Phase(NamedTuple):
    """A part of a run with one set of schemes, until it has settled or `most` iterations are done.

    convection  scheme of the velocity's convection
    relaxation  of pressure, velocity and turbulence; in unsteady flow of none
    window      iterations over which means are taken
    tolerance   change from one such mean of the drop to the next, over the mean, at which it has settled
    """

    name: str
    convection: str
    relaxation: tuple[float, float, float]
    most: int
    window: int = 50
    tolerance: float = 2e-3

    @property
    def order(self) -> str:
        """Order of the convection's scheme, in words."""
        return "first order" if self.convection.endswith("upwind") else "second order"


UPWIND = Phase("upwind start", "bounded Gauss upwind", (0.3, 0.7, 0.5), most=60, window=20, tolerance=0.0)
"""Robust, and about a tenth too high in drop: only to begin with, always as long."""
SECOND_ORDER = Phase(
    "second order", "bounded Gauss linearUpwind grad(U)", (0.3, 0.6, 0.5), most=600, window=50, tolerance=1e-3
)
"""With a limited gradient, without which it does not settle."""
FIRST_ORDER = UPWIND._replace(name="first order", most=600, window=50, tolerance=1e-3)
"""Upwind to the end, as the source has it."""
SCHEMES: Mapping[str, tuple[Phase, ...]] = {"second-order": (UPWIND, SECOND_ORDER), "first-order": (FIRST_ORDER,)}
"""Phases of a steady run, by the order of the convection's scheme at its end."""


PASSING = Phase("passing", "Gauss upwind", (0.7, 0.8, 0.8), most=240, window=120, tolerance=0.0)
"""Unsteady flow of so many steps, means over the last of them; where meshes slide, schemes of second order blow up."""
OUTER = 3
"""Rounds of pressure and velocity in a step of unsteady flow."""


def schemes_text(phase: Phase, *, unsteady: bool = False) -> str:
    """system/fvSchemes."""
    upwind = "Gauss upwind" if unsteady else "bounded Gauss upwind"
    convection = {f"div(phi,{name})": upwind for name in ("k", "epsilon", "omega")}
    content: Mapping[str, Entry] = {
        "ddtSchemes": {"default": "Euler" if unsteady else "steadyState"},
        "gradSchemes": {"default": "leastSquares", "grad(U)": "cellLimited leastSquares 1"},
        "divSchemes": {
            "default": "none",
            "div(phi,U)": phase.convection,
            **convection,
            "div((nuEff*dev2(T(grad(U)))))": "Gauss linear",
        },
        "laplacianSchemes": {"default": "Gauss linear limited 0.5"},
        "interpolationSchemes": {"default": "linear"},
        "snGradSchemes": {"default": "limited 0.5"},
        "wallDist": {"method": "meshWave"},
    }
    return dictionary_text(content, "fvSchemes")


def solution_text(phase: Phase) -> str:
    """system/fvSolution; in unsteady flow the last round of a step, and the flow through a mesh that moves, as any."""
    pressure, velocity, turbulence = phase.relaxation
    smooth: Mapping[str, Entry] = {
        "solver": "smoothSolver",
        "smoother": "symGaussSeidel",
        "tolerance": 1e-9,
        "relTol": 0.1,
    }
    content: Mapping[str, Entry] = {
        "solvers": {
            '"(p|pcorr).*"': {"solver": "GAMG", "smoother": "GaussSeidel", "tolerance": 1e-8, "relTol": 0.05},
            '"(U|k|epsilon|omega).*"': smooth,
        },
        "SIMPLE": {"nNonOrthogonalCorrectors": 1, "consistent": False, "pRefCell": 0, "pRefValue": 0},
        "PIMPLE": {"correctPhi": False, "nOuterCorrectors": OUTER, "nCorrectors": 1, "nNonOrthogonalCorrectors": 1},
        "relaxationFactors": {
            "fields": {'"p.*"': pressure},
            "equations": {'"U.*"': velocity, '"(k|epsilon|omega).*"': turbulence},
        },
    }
    return dictionary_text(content, "fvSolution")


def control_text(end: int, functions: Mapping[str, Mapping[str, Entry]], step: float = STEADY) -> str:
    """system/controlDict: goes on from the last state to the iteration `end`, and writes now and then and there.

    `step` is the time of an iteration [s], `STEADY` where there is none.
    """
    stop: Mapping[str, Entry] = {
        "type": "abort",
        "libs": ("utilityFunctionObjects",),
        "file": f'"<case>/{STOP}"',
        "action": "writeNow",
    }
    content: Mapping[str, Entry] = {
        "application": solver(step),
        "startFrom": "latestTime",
        "startTime": 0,
        "stopAt": "endTime",
        "endTime": end * step,
        "deltaT": step,
        "writeControl": "timeStep",
        "writeInterval": INTERVAL,
        "purgeWrite": KEPT,
        "writeFormat": "binary",
        "writePrecision": 10,
        "writeCompression": "off",
        "timeFormat": "general",
        "timePrecision": 8,
        "runTimeModifiable": False,
        "functions": {**functions, "stop": stop},
    }
    return dictionary_text(content, "controlDict")


def parts_text(cores: int) -> str:
    """system/decomposeParDict: so many parts of one size, cut across x; other ways are missing in Debian's build."""
    content: Mapping[str, Entry] = {
        "numberOfSubdomains": cores,
        "method": "hierarchical",
        "coeffs": {"n": (cores, 1, 1)},
    }
    return dictionary_text(content, "decomposeParDict")


def patch_mean(patch: str, operation: str, field: str) -> dict[str, Entry]:
    """A function object that writes `operation` of a field over a patch at every iteration."""
    return {
        "type": "surfaceFieldValue",
        "libs": ("fieldFunctionObjects",),
        "regionType": "patch",
        "name": patch,
        "operation": operation,
        "fields": (field,),
        "writeFields": False,
        "log": False,
        "executeControl": "timeStep",
        "writeControl": "timeStep",
    }


def property_files(viscosity: float, turbulence: Turbulence) -> dict[str, str]:
    """Fluid [kinematic viscosity in m^2/s] and turbulence, by path."""
    fluid: Mapping[str, Entry] = {"transportModel": "Newtonian", "nu": viscosity}
    steady: Mapping[str, Entry] = {"RASModel": turbulence.model, "turbulence": True, "printCoeffs": False}
    model: Mapping[str, Entry] = {"simulationType": "RAS", "RAS": steady}
    if not turbulence.scale:
        model = {"simulationType": "laminar"}
    return {
        "constant/transportProperties": dictionary_text(fluid, "transportProperties"),
        "constant/turbulenceProperties": dictionary_text(model, "turbulenceProperties"),
    }
