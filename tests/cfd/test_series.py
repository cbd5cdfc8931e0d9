"""Cases in one directory: carried out by any engine, told of together."""

import pytest
from tests.cfd.conftest import OIL, PIPE

from vvdp.cfd.section import Plane
from vvdp.cfd.series import PROGRESS, NamedCase, case_folder, solve_series
from vvdp.cfd.verification import pipe_case
from vvdp.studies.dask_engines import LocalDask
from vvdp.studies.engine import ThisProcess

ACROSS = Plane((0.0, 0.0, 10e-3), (0.0, 0.0, 1.0))


@pytest.fixture
def pipes():
    """One mesh at two viscosities, and another mesh; each is solved in a second."""
    thicker = OIL._replace(viscosity=0.0774)
    cases = (pipe_case(PIPE, OIL, 8), pipe_case(PIPE, thicker, 8), pipe_case(PIPE, OIL, 6))
    return [NamedCase(name, case) for name, case in zip(("thin", "thick", "coarse"), cases, strict=True)]


def test_cases_come_back_in_their_order_and_share_a_mesh(pipes, openfoam, tmp_path):
    told = []
    thin, thick, coarse = solve_series(pipes, ACROSS, tmp_path, ThisProcess(1), told.append)
    assert thick.judgement.value == pytest.approx(2.0 * thin.judgement.value, rel=1e-3)
    assert "blockMesh" in coarse.seconds
    assert "blockMesh" not in thick.seconds
    assert thick.mesh == thin.mesh != coarse.mesh
    assert thin.took == pytest.approx(sum(thin.seconds.values()))
    assert all((case_folder(tmp_path, place) / PROGRESS).is_file() for place in range(3))
    dones = [each.done for each in told]
    assert all(each.most == 9000 for each in told)
    assert max(dones, default=0) <= 9000


def test_workers_find_what_this_process_finds(pipes, openfoam, tmp_path):
    here = solve_series(pipes[:2], ACROSS, tmp_path / "here", ThisProcess(1), lambda now: None)
    there = solve_series(pipes[:2], ACROSS, tmp_path / "there", LocalDask(2, 1), lambda now: None)
    assert [each.judgement for each in there] == [each.judgement for each in here]
    again = solve_series(pipes[:2], ACROSS, tmp_path / "there", ThisProcess(1), lambda now: None)
    assert [each.seconds for each in again] == [each.seconds for each in there]
