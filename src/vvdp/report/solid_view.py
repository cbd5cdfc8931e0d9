"""Spool and sleeve in a page as solids that are turned with the mouse, without network."""

import base64
import json
import zlib
from collections.abc import Mapping

import numpy as np

from vvdp.geometry.files import patch_colour
from vvdp.geometry.mesh import Floats, Mesh
from vvdp.geometry.shape import ValveShape
from vvdp.geometry.solids import COARSEST, half_sleeve, spool
from vvdp.report.interactive import VIEWER, asset
from vvdp.report.shading import lying_frame
from vvdp.valve.rotary import RotaryValve

STEPS = 4095
"""Steps of the longest side to which corners are rounded: 0.04 mm of a spool, and a page of half the size."""
WORDS = (
    "Spool and sleeve, cut in half, as they stand at this angle and position; coarser than the files. Drag to turn, "
    "Ctrl and wheel to zoom, double click to reset, or use the arrow keys."
)


def solid_view(shape: ValveShape, valve: RotaryValve, angle: float, position: float) -> str:
    """HTML of spool and half sleeve, the spool at an angle [rad] and an axial position [m]; needs WebGL 2.

    It stays hidden on paper and in browsers that cannot show it.
    """
    turning, half = spool(shape, valve, COARSEST), half_sleeve(shape, valve, COARSEST)
    cos, sin = np.cos(angle), np.sin(angle)
    turned = turning.vertices @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    placed = Mesh(turned - (0.0, 0.0, position), turning.triangles, turning.patch, turning.names)
    return (
        f'<div class="solids" id="solids" hidden>\n<canvas tabindex="0" aria-label="Spool and sleeve"></canvas>\n'
        f'<p class="small">{WORDS}</p>\n</div>\n'
        f'<script type="application/json" id="solids-data">{_pack({"spool": placed, "sleeve": half})}</script>\n'
        f"<script>{asset(VIEWER)}</script>"
    )


def _pack(meshes: Mapping[str, Mesh]) -> str:
    """Corners as whole steps, three for each triangle, patch after patch, and the colours of the patches, as JSON."""
    corners: Floats = np.concatenate([mesh.vertices for mesh in meshes.values()])
    low, size = corners.min(axis=0), np.ptp(corners, axis=0)
    step = float(size.max()) / STEPS
    parts, content = [], b""
    for name, mesh in meshes.items():
        patches = []
        for patch in mesh.names:
            triangles = mesh.of(patch)
            patches.append({"colour": patch_colour(patch), "count": 3 * len(triangles)})
            content += np.rint((triangles - low) / step).astype("<u2").tobytes()
        parts.append({"name": name, "patches": patches})
    described = {
        "parts": parts,
        "centre": (0.5 * size / step).tolist(),
        "size": STEPS,
        "turn": lying_frame(30.0, 30.0).tolist(),
        "bytes": base64.b64encode(zlib.compress(content, 9)).decode("ascii"),
    }
    return json.dumps(described, separators=(",", ":"))
