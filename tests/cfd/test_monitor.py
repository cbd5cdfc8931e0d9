"""Tables and words of OpenFOAM, as it has written them."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import RunError
from vvdp.cfd.monitor import forget_from, patch_faces, read_mesh_check, read_monitor, read_table, states
from vvdp.cfd.watching import read_drop

FLOW = """\
# Region type :   patch outlet1
# Faces           : 49
# Area            : 1.1626341808e-05
# Scale factor    : 1.0000000000e+00
# Time            \tsum(phi)
1                 \t2.4448064575e-04
2                 \t2.2267074881e-04
3                 \t2.22
"""
FORCE = """\
# Force
# CofR                : (0.0 0.0 0.0)
#
# Time            \t(total_x total_y total_z)\t(pressure_x pressure_y pressure_z)
1                 \t(1.0e-01 -2.0e-01 3.0e-01)\t(1.0e-02 2.0e-02 3.0e-02)
"""
CHECK = """\
Mesh stats
    points:           1
    cells:            11
Mesh OK.
Mesh stats
    points:           36125
    cells:            28163
Checking geometry...
    Mesh non-orthogonality Max: 64.86312029 average: 14.3
    Max skewness = 3.542563876 OK.
Mesh OK.
"""
SKEWED = """\
Mesh stats
    cells:            28163
    Mesh non-orthogonality Max: 64.9 average: 14.3
 ***Max skewness = 4.564482237, 2 highly skew faces detected which may impair the quality of the results
  <<Writing 2 skew faces to set skewFaces
Failed 1 mesh checks.
"""
BOUNDARY = """\
FoamFile
{
    class       polyBoundaryMesh;
}
3
(
    inlet
    {
        type            patch;
        nFaces          300;
        startFace       80000;
    }
    rail
    {
        type            wall;
        inGroups        1(wall);
        nFaces          0;
        startFace       80300;
    }
)
"""


def write(folder, start, name, text, table="surfaceFieldValue.dat"):
    path = folder / "postProcessing" / name / str(start) / table
    path.parent.mkdir(parents=True)
    path.write_text(text)
    return path


def test_a_line_that_is_being_written_is_left_out(tmp_path):
    found = read_table(write(tmp_path, 0, "flow", FLOW[:-1]))
    assert found.iterations.tolist() == [1, 2]
    assert found.values[:, 0] == pytest.approx([2.4448064575e-04, 2.2267074881e-04])
    assert found.area == 1.1626341808e-05


def test_vectors_lie_flat(tmp_path):
    found = read_table(write(tmp_path, 0, "forces", FORCE, "force.dat"))
    assert found.values[0].tolist() == [0.1, -0.2, 0.3, 0.01, 0.02, 0.03]
    assert np.isnan(found.area)


def test_what_was_repeated_takes_the_place_of_what_was_lost(tmp_path):
    write(tmp_path, 0, "flow", FLOW)
    write(tmp_path, 2, "flow", "3 \t7\n4 \t8\n")
    found = read_monitor(tmp_path, "flow")
    assert found.iterations.tolist() == [1, 2, 3, 4]
    assert found.values[2:, 0].tolist() == [7, 8]
    forget_from(tmp_path, 2)
    assert read_monitor(tmp_path, "flow").iterations.tolist() == [1, 2, 3]


def test_before_the_solver_writes_there_are_no_rows(tmp_path):
    assert read_monitor(tmp_path, "flow").iterations.size == 0


def test_a_drop_is_pressure_times_density_as_far_as_all_tables_reach(tmp_path):
    write(tmp_path, 0, "pressure", "1 \t100\n2 \t200\n3 \t300\n")
    write(tmp_path, 0, "flow-inlet", "1 \t-1\n2 \t-1\n")
    found = read_drop(("inlet",), 876.0, tmp_path)
    assert found.value.tolist() == [87600.0, 175200.0]
    assert found.flows["inlet"].tolist() == [-1, -1]


def test_the_last_words_of_a_mesh_check_count():
    found = read_mesh_check(CHECK)
    assert (found.cells, found.faults) == (28163, ())
    assert found.skewness == 3.542563876
    assert found.non_orthogonality == 64.86312029


def test_a_fault_of_a_mesh_is_told_in_its_words():
    (fault,) = read_mesh_check(SKEWED).faults
    assert fault.startswith("Max skewness = 4.564482237, 2 highly skew faces")


def test_a_mesh_check_without_cells_is_refused():
    with pytest.raises(RunError, match=wording.cfd.no_number_of_cells):
        read_mesh_check("--> FOAM FATAL ERROR")


def test_faces_of_patches_are_counted(tmp_path):
    (tmp_path / "constant" / "polyMesh").mkdir(parents=True)
    (tmp_path / "constant" / "polyMesh" / "boundary").write_text(BOUNDARY)
    assert patch_faces(tmp_path) == {"inlet": 300, "rail": 0}


def test_a_state_that_was_being_written_does_not_count(tmp_path):
    for time, text in (("0", ""), ("20", "0.1\n// * * //\n"), ("40", "0.1\n")):
        (tmp_path / time).mkdir()
        (tmp_path / time / "U").write_text(text)
        (tmp_path / time / "p").write_text("1\n// * * //\n")
    (tmp_path / "60").mkdir()
    assert [path.name for path in states(tmp_path)] == ["0", "20"]


def test_what_checkmesh_leaves_beside_the_start_is_no_field(tmp_path):
    """Of a mesh in pieces; else no later state would ever count as whole, and a run would begin anew."""
    for time in ("0", "20"):
        (tmp_path / time).mkdir()
        (tmp_path / time / "U").write_text("1\n// * * //\n")
    (tmp_path / "0" / "cellToRegion").write_text("1\n")
    assert [path.name for path in states(tmp_path)] == ["0", "20"]
