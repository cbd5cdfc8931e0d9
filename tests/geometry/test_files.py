"""Files of meshes, written and read back."""

import json
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from vvdp.base.errors import ConfigError
from vvdp.geometry.domains import rail_domain
from vvdp.geometry.files import patch_colour, read_glb, read_stl, write_ascii_stl, write_binary_stl, write_glb
from vvdp.geometry.mesh import open_edges, patch_areas, volume


@pytest.fixture(scope="module")
def rail_oil(built_shape, built_valve):
    return rail_domain(built_shape, built_valve, 12.0).mesh


def test_ascii_stl_keeps_patches_and_every_digit(rail_oil, tmp_path):
    path = tmp_path / "rail.stl"
    write_ascii_stl(path, rail_oil)
    again = read_stl(path)
    assert set(again.names) == set(rail_oil.names)
    assert volume(again) == pytest.approx(volume(rail_oil), rel=1e-14)
    assert patch_areas(again) == pytest.approx(patch_areas(rail_oil), rel=1e-14)
    assert open_edges(again) == 0


def test_binary_stl_is_closed_in_single_precision(spool_mesh, tmp_path):
    path = tmp_path / "spool.stl"
    write_binary_stl(path, spool_mesh)
    again = read_stl(path)
    assert volume(again) == pytest.approx(volume(spool_mesh), rel=1e-6)
    assert path.stat().st_size == 84 + 50 * len(spool_mesh.triangles)
    assert len(again.triangles) > 0.999 * len(spool_mesh.triangles)


def test_glb_is_as_the_standard_has_it_and_reads_back(spool_mesh, tmp_path):
    path = tmp_path / "spool.glb"
    write_glb(path, spool_mesh, "spool")
    content = path.read_bytes()
    magic, version, length = struct.unpack("<4sII", content[:12])
    assert (magic, version, length) == (b"glTF", 2, len(content))
    size = struct.unpack("<I", content[12:16])[0]
    assert size % 4 == 0
    document = json.loads(content[20 : 20 + size])
    painted = {each["name"]: each["pbrMetallicRoughness"]["baseColorFactor"] for each in document["materials"]}
    assert set(painted) == set(spool_mesh.names)
    assert painted["chamber"] == pytest.approx([*patch_colour("chamber"), 1.0], abs=0.5 / 255.0)
    assert document["buffers"][0]["byteLength"] <= len(content) - 28 - size
    again = read_glb(path)
    assert volume(again) == pytest.approx(volume(spool_mesh), rel=1e-6)
    assert np.allclose(again.vertices.max(0), spool_mesh.vertices.max(0), rtol=1e-6)


def test_glb_turns_every_patch_upright(spool_mesh, tmp_path):
    """A spool has a patch "spool": node and patch of one name must not be taken for each other."""
    write_glb(tmp_path / "spool.glb", spool_mesh, "spool")
    scene = trimesh.load_scene(tmp_path / "spool.glb")
    for place, name in enumerate(spool_mesh.names):
        x, y, z = spool_mesh.vertices[np.unique(spool_mesh.triangles[spool_mesh.patch == place])].T
        node = f"spool, {name}"
        matrix, geometry = scene.graph[node]
        assert geometry == name
        shown = trimesh.transform_points(scene.geometry[name].vertices, matrix)
        assert shown.min(0) == pytest.approx([x.min(), z.min(), (-y).min()], rel=1e-6)
        assert shown.max(0) == pytest.approx([x.max(), z.max(), (-y).max()], rel=1e-6)


WRITE_ALL = """
import sys
from pathlib import Path
from vvdp.geometry.facets import Faceted
from vvdp.geometry.files import write_ascii_stl, write_binary_stl, write_glb
kernel = Faceted(0.2)
mesh = (kernel.cylinder("inner", 2.0, 0.0, 1.0) - kernel.cylinder("hole", 1.0, -1.0, 2.0)).mesh()
folder = Path(sys.argv[1])
write_binary_stl(folder / "a.stl", mesh)
write_ascii_stl(folder / "b.stl", mesh)
write_glb(folder / "c.glb", mesh, "ring")
"""


def test_files_are_the_same_to_the_last_byte_in_another_process(tmp_path):
    written = []
    for seed in ("1", "2"):
        folder = tmp_path / seed
        folder.mkdir()
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", WRITE_ALL, str(folder)], env=environment, check=True)
        written.append([(folder / name).read_bytes() for name in ("a.stl", "b.stl", "c.glb")])
    assert written[0] == written[1]
    assert written[0][0].startswith(b"vvdp, lengths in metres")


@pytest.mark.parametrize("reader", [read_stl, read_glb])
@pytest.mark.parametrize("content", [b"", b"solid\nendsolid\n", b"\0" * 100, b"hello" * 50])
def test_other_files_are_refused(reader, content, tmp_path):
    path = tmp_path / "wrong"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match="is not a"):
        reader(path)
