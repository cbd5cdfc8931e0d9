"""Meshes that slide along each other on a cylinder: their sides see each other, wholly or where they happen to meet."""

from collections.abc import Mapping
from typing import NamedTuple

from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.cfd.rotor import ZONE_PROGRAM

RING, RING_PATCHES = "ring", ("ring1", "ring2")
"""The faces along which one mesh is parted, and its two sides."""
LEAST_SEEN = 0.3
"""Share of a face on the ring below which it sees only itself: rims are not quite round, and slide off each other."""
BAFFLES_PROGRAM = ("createBaffles", "-overwrite")
PARTING_PROGRAMS = (BAFFLES_PROGRAM, ("mergeOrSplitBaffles", "-split", "-overwrite"))
MEETING_PROGRAMS = (ZONE_PROGRAM, BAFFLES_PROGRAM)


class Side(NamedTuple):
    """A side of two meshes that meet: its patch in the mesh as it is made, and what takes the patch's place.

    open  where it sees the other side
    closed  where it does not, a wall
    """

    patch: str
    open: str
    closed: str


def parting_files() -> dict[str, str]:
    """Files that split the mesh along its ring, by `PARTING_PROGRAMS`, into two coupled patches."""
    seeing: Mapping[str, Entry] = {
        "type": "cyclicAMI",
        "transform": "noOrdering",
        "lowWeightCorrection": LEAST_SEEN,
    }
    sides: Mapping[str, Entry] = {
        side: {**seeing, "name": name, "neighbourPatch": other}
        for side, name, other in zip(("master", "slave"), RING_PATCHES, RING_PATCHES[::-1], strict=True)
    }
    return _baffle_files({RING: sides}, inside=True)


def meeting_files(one: Side, other: Side) -> dict[str, str]:
    """Files that couple two patches of one mesh where they meet, by `MEETING_PROGRAMS`.

    Each face of a patch becomes two: one that is open as far as the other side covers it, one that is closed for the
    rest (cyclicACMI).
    """
    actions: list[Mapping[str, Entry]] = []
    for side in (one, other):
        faces = f"{side.patch}Faces"
        actions += [
            {"name": faces, "type": "faceSet", "action": "new", "source": "patchToFace", "patch": side.patch},
            {"name": side.patch, "type": "faceZoneSet", "action": "new", "source": "setToFaceZone", "faceSet": faces},
        ]
    zones = {side.patch: _open_and_closed(side, facing) for side, facing in ((one, other), (other, one))}
    chosen = {"system/topoSetDict": dictionary_text({"actions": tuple(actions)}, "topoSetDict")}
    return chosen | _baffle_files(zones, inside=False)


def _open_and_closed(side: Side, facing: Side) -> Mapping[str, Entry]:
    """The patches of a side; slaves are asked for, and have no faces."""
    seeing: Mapping[str, Entry] = {
        "type": "cyclicACMI",
        "transform": "noOrdering",
        "neighbourPatch": facing.open,
        "nonOverlapPatch": side.closed,
    }
    # OpenFOAM wants the patch that sees before the wall that stands for its rest.
    return {
        "master": {"name": side.open, **seeing},
        "slave": {"name": side.open, "type": "patch"},
        "master2": {"name": side.closed, "type": "wall"},
        "slave2": {"name": side.closed, "type": "wall"},
    }


def _baffle_files(zones: Mapping[str, Mapping[str, Entry]], *, inside: bool) -> dict[str, str]:
    """File that makes patches of zones of faces, `inside` the mesh or on its surface."""
    baffles: Mapping[str, Entry] = {
        name: {"type": "faceZone", "zoneName": name, "patches": patches} for name, patches in zones.items()
    }
    content: Mapping[str, Entry] = {"internalFacesOnly": inside, "noFields": True, "baffles": baffles}
    return {"system/createBafflesDict": dictionary_text(content, "createBafflesDict")}
