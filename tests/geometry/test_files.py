"""Files of meshes, written and read back."""

import json
import struct

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.geometry.domains import rail_domain
from vvdp.geometry.files import read_glb, read_stl, write_ascii_stl, write_binary_stl, write_glb
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
    write_glb(path, spool_mesh, "spool", {"chamber": (0.5, 0.7, 0.9)})
    content = path.read_bytes()
    magic, version, length = struct.unpack("<4sII", content[:12])
    assert (magic, version, length) == (b"glTF", 2, len(content))
    size = struct.unpack("<I", content[12:16])[0]
    assert size % 4 == 0
    document = json.loads(content[20 : 20 + size])
    assert {each["name"] for each in document["materials"]} == set(spool_mesh.names)
    assert document["buffers"][0]["byteLength"] <= len(content) - 28 - size
    again = read_glb(path)
    assert volume(again) == pytest.approx(volume(spool_mesh), rel=1e-6)
    assert np.allclose(again.vertices.max(0), spool_mesh.vertices.max(0), rtol=1e-6)


@pytest.mark.parametrize("reader", [read_stl, read_glb])
@pytest.mark.parametrize("content", [b"", b"solid\nendsolid\n", b"\0" * 100, b"hello" * 50])
def test_other_files_are_refused(reader, content, tmp_path):
    path = tmp_path / "wrong"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match="is not a"):
        reader(path)
