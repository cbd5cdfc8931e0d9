"""Oil that is solved in the frame that turns with the spool: a zone of cells round the axis, and what does not turn."""

from collections.abc import Mapping, Sequence

from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.geometry.domains import TURNING, Domain

ROTOR, STATOR = "rotor", "stator"
"""Zones of cells: what turns, or is solved in the frame of the spool; what is meshed apart from it and stands still."""
ZONE_PROGRAM = ("topoSet",)
FAR = 100.0
"""Half the length of the zone over its radius: beyond any domain."""


def rotor_patches(domain: Domain) -> tuple[str, ...]:
    """The patches of a domain that turn with the spool."""
    return tuple(name for name in domain.mesh.names if name in TURNING)


def zone_files(radius: float) -> dict[str, str]:
    """Files for a zone of the cells within a radius [m] of the axis, made by `ZONE_PROGRAM`."""
    cells, far = f"{ROTOR}Cells", FAR * radius
    within: Mapping[str, Entry] = {
        "source": "cylinderToCell",
        "p1": (0, 0, -far),
        "p2": (0, 0, far),
        "radius": radius,
    }
    actions: tuple[Mapping[str, Entry], ...] = (
        {"name": cells, "type": "cellSet", "action": "new", **within},
        {"name": ROTOR, "type": "cellZoneSet", "action": "new", "source": "setToCellZone", "set": cells},
    )
    return {"system/topoSetDict": dictionary_text({"actions": actions}, "topoSetDict")}


def motion_files(speed: float) -> dict[str, str]:
    """File for the rotation of the mesh of the zone [rad/s]."""
    motion: Mapping[str, Entry] = {
        "dynamicFvMesh": "dynamicMotionSolverFvMesh",
        "motionSolverLibs": ("fvMotionSolvers",),
        "motionSolver": "solidBody",
        "cellZone": ROTOR,
        "solidBodyMotionFunction": "rotatingMotion",
        "origin": (0, 0, 0),
        "axis": (0, 0, 1),
        "omega": speed,
    }
    return {"constant/dynamicMeshDict": dictionary_text(motion, "dynamicMeshDict")}


def frame_files(speed: float, still: Sequence[str]) -> dict[str, str]:
    """The frame of the zone [rad/s] and the patches `still`; one that is not named is taken to turn with it."""
    frame: Mapping[str, Entry] = {
        "cellZone": ROTOR,
        "active": True,
        "nonRotatingPatches": tuple(still),
        "origin": (0, 0, 0),
        "axis": (0, 0, 1),
        "omega": speed,
    }
    return {"constant/MRFProperties": dictionary_text({ROTOR: frame}, "MRFProperties")}
