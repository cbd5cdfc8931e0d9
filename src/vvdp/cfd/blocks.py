"""Meshes of a few blocks, as blockMesh makes them."""

from collections.abc import Mapping, Sequence

from vvdp.cfd.dictionary import Entry, dictionary_text

BLOCK_MESH = "system/blockMeshDict"
Point = tuple[float, float, float]
Faces = Mapping[str, tuple[str, Sequence[tuple[int, ...]]]]
"""Type and faces of each patch, a face as places of its corners."""


EVEN = (1.0, 1.0, 1.0)


def block(corners: Sequence[int], cells: tuple[int, int, int], growth: tuple[float, float, float] = EVEN) -> str:
    """A block between eight corners, given by their places, with so many cells along its directions.

    `growth` is the size of the last cell over that of the first, along each.
    """
    return f"hex ( {_words(corners)} ) ( {_words(cells)} ) simpleGrading ( {_words(growth)} )"


def arc(ends: tuple[int, int], middle: Point) -> str:
    """An edge between two corners that is an arc of a circle through a point."""
    return f"arc {_words(ends)} ( {_words(middle)} )"


def block_mesh_text(vertices: Sequence[Point], blocks: Sequence[str], faces: Faces, edges: Sequence[str] = ()) -> str:
    """system/blockMeshDict, lengths in metres."""
    boundary: list[Entry] = []
    for name, (kind, corners) in faces.items():
        boundary += [name, {"type": kind, "faces": corners}]
    content: Mapping[str, Entry] = {
        "scale": 1,
        "vertices": vertices,
        "blocks": blocks,
        "edges": edges,
        "boundary": boundary,
    }
    return dictionary_text(content, "blockMeshDict")


def _words(numbers: Sequence[float]) -> str:
    return " ".join(map(repr, numbers))
