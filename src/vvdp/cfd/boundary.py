"""Boundary conditions on the patches of a mesh, field by field, as OpenFOAM's files have them."""

from collections.abc import Mapping
from typing import NamedTuple

from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.cfd.turbulence import Inflow, Turbulence

Conditions = Mapping[str, Mapping[str, Entry]]
"""The condition of each field on one patch."""
DIMENSIONS = {
    "U": "[0 1 -1 0 0 0 0]",
    "p": "[0 2 -2 0 0 0 0]",
    "k": "[0 2 -2 0 0 0 0]",
    "epsilon": "[0 2 -3 0 0 0 0]",
    "omega": "[0 0 -1 0 0 0 0]",
    "nut": "[0 2 -1 0 0 0 0]",
}
NO_GRADIENT: Mapping[str, Entry] = {"type": "zeroGradient"}
CALCULATED: Mapping[str, Entry] = {"type": "calculated", "value": "uniform 0"}


class Patch(NamedTuple):
    """A patch: its type in the mesh, and the conditions on it."""

    kind: str
    conditions: Conditions


def uniform(value: float | tuple[float, float, float]) -> str:
    """A value that is the same everywhere."""
    return f"uniform {value!r}" if isinstance(value, float) else "uniform ( {!r} {!r} {!r} )".format(*value)


def flow_inlet(flow: float, inflow: Inflow) -> Patch:
    """Where a flow [m^3/s] enters, spread evenly."""
    fixed = {name: {"type": "fixedValue", "value": uniform(value)} for name, value in inflow._asdict().items()}
    velocity: Mapping[str, Entry] = {
        "type": "flowRateInletVelocity",
        "volumetricFlowRate": flow,
        "value": uniform((0.0, 0.0, 0.0)),
    }
    return Patch("patch", {"U": velocity, "p": NO_GRADIENT, "nut": CALCULATED, **fixed})


def pressure_inlet(total: float, inflow: Inflow) -> Patch:
    """Where the oil enters across the patch, under a total pressure over its density [m^2/s^2]."""
    velocity = {"type": "pressureInletOutletVelocity", "value": uniform((0.0, 0.0, 0.0))}
    pressure = {"type": "totalPressure", "p0": uniform(total), "value": uniform(total)}
    return Patch("patch", {"U": velocity, "p": pressure, "nut": CALCULATED, **_both_ways(inflow)})


def pressure_outlet(inflow: Inflow) -> Patch:
    """Where the oil leaves at pressure 0; what flows back has no velocity along the patch, and `inflow`."""
    still = uniform((0.0, 0.0, 0.0))
    velocity = {"type": "inletOutlet", "inletValue": still, "value": still}
    pressure = {"type": "fixedValue", "value": uniform(0.0)}
    return Patch("patch", {"U": velocity, "p": pressure, "nut": CALCULATED, **_both_ways(inflow)})


def _both_ways(inflow: Inflow) -> Conditions:
    """Turbulence that oil brings along where it enters, and takes away where it leaves."""
    return {
        name: {"type": "inletOutlet", "inletValue": uniform(value), "value": uniform(value)}
        for name, value in inflow._asdict().items()
    }


def rotation(speed: float) -> Mapping[str, Entry]:
    """The velocity of a wall that turns about z [rad/s]."""
    axis: Mapping[str, Entry] = {"origin": (0, 0, 0), "axis": (0, 0, 1)}
    return {"type": "rotatingWallVelocity", **axis, "omega": speed, "value": uniform((0.0, 0.0, 0.0))}


MOVING: Mapping[str, Entry] = {"type": "movingWallVelocity", "value": uniform((0.0, 0.0, 0.0))}
"""The velocity of a wall whose mesh moves."""


def wall(inflow: Inflow, velocity: Mapping[str, Entry] | None = None) -> Patch:
    """A wall at rest, or with a `velocity` of its own; k, epsilon, omega and viscosity by wall functions."""
    functions = {
        "k": {"type": "kqRWallFunction", "value": uniform(inflow.k)},
        "epsilon": {"type": "epsilonWallFunction", "value": uniform(inflow.epsilon)},
        "omega": {"type": "omegaWallFunction", "value": uniform(inflow.omega)},
        "nut": {"type": "nutkWallFunction", "value": uniform(0.0)},
    }
    return Patch("wall", {"U": velocity or {"type": "noSlip"}, "p": NO_GRADIENT, **functions})


def slip() -> Patch:
    """A wall along which the oil slides without friction."""
    fields = dict.fromkeys(("p", "k", "epsilon", "omega"), NO_GRADIENT)
    return Patch("patch", {"U": {"type": "slip"}, "nut": CALCULATED, **fields})


def constraint(kind: str) -> Patch:
    """A patch that only says how the mesh goes on there: "empty", "wedge", "symmetry"."""
    return Patch(kind, {name: {"type": kind} for name in DIMENSIONS})


def meeting(inflow: Inflow) -> Patch:
    """Where one mesh sees another that slides along it, as far as that covers it; at rest at the start."""
    kind = "cyclicACMI"
    values = {"U": uniform((0.0, 0.0, 0.0)), "p": uniform(0.0), "nut": uniform(0.0)}
    values |= {name: uniform(value) for name, value in inflow._asdict().items()}
    return Patch(kind, {name: {"type": kind, "value": value} for name, value in values.items()})


def field_files(patches: Mapping[str, Patch], turbulence: Turbulence, start: Inflow) -> dict[str, str]:
    """The fields at the start, by path: at rest, with the turbulence `start` everywhere."""
    values = {"U": uniform((0.0, 0.0, 0.0)), "p": uniform(0.0)}
    if turbulence.scale:
        scale: float = getattr(start, turbulence.scale)
        values |= {"k": uniform(start.k), turbulence.scale: uniform(scale), "nut": uniform(0.0)}
    return {f"0/{name}": _field_text(name, value, patches) for name, value in values.items()}


def _field_text(name: str, value: str, patches: Mapping[str, Patch]) -> str:
    content: Mapping[str, Entry] = {
        "dimensions": DIMENSIONS[name],
        "internalField": value,
        "boundaryField": {patch: each.conditions[name] for patch, each in patches.items()},
    }
    return dictionary_text(content, name, "volVectorField" if name == "U" else "volScalarField")
