"""Streamlines as OpenFOAM writes them."""

import pytest

from vvdp.base.errors import RunError
from vvdp.cfd.streamlines import read_streamlines

WRITTEN = """# vtk DataFile Version 2.0
track0
ASCII
DATASET POLYDATA
POINTS 5 double
0 0 0
1 0 0
1 1 0
2 0 0
2 0 1
LINES 3 8
3 0 1 2
2 3 4
1 4
POINT_DATA 5
 FIELD attributes 1
U 3 5 float
3 4 0 0 0 2
0 0 1
6 8 0 0 0 0
"""


@pytest.fixture
def path(tmp_path):
    folder = tmp_path / "postProcessing" / "sets" / "streamlines" / "160"
    folder.mkdir(parents=True)
    return folder / "track0_U.vtk"


def test_lines_have_their_points_and_speeds(path, tmp_path):
    path.write_text(WRITTEN)
    first, second = read_streamlines(tmp_path)
    assert first.points.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert first.speed.tolist() == [5.0, 2.0, 1.0]
    assert second.speed.tolist() == [10.0, 0.0]


def test_none_were_followed(tmp_path):
    assert read_streamlines(tmp_path) == []


@pytest.mark.parametrize(
    "text", ["", WRITTEN[:200], WRITTEN.replace("0 0 1\n6 8", "x y z\n6 8"), WRITTEN.replace("LINES", "L")]
)
def test_a_damaged_file_is_named(path, tmp_path, text):
    path.write_text(text)
    with pytest.raises(RunError, match=r"track0_U\.vtk is damaged"):
        read_streamlines(tmp_path)
