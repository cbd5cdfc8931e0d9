"""Cases in one directory: carried out by any engine, told of together."""

from dataclasses import replace

import pytest
from tests.cfd.conftest import OIL, PIPE
from tests.slurm import told

from vvdp.base.errors import RunError
from vvdp.cfd import series
from vvdp.cfd.section import Plane
from vvdp.cfd.series import PROGRESS, NamedCase, SeriesStopped, case_folder, solve_series
from vvdp.cfd.verification import pipe_case
from vvdp.studies.dask_engines import LocalDask, Slurm
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


def test_a_stopped_series_says_what_is_missing_and_goes_on(pipes, openfoam, tmp_path, monkeypatch):
    """The third has a mesh of its own and is computed second, when the series is stopped."""
    solve, begun = series.solve, []

    def stop(case, folder, *rest):
        begun.append(folder.name)
        if len(begun) == 2:
            raise KeyboardInterrupt
        return solve(case, folder, *rest)

    monkeypatch.setattr(series, "solve", stop)
    with pytest.raises(SeriesStopped) as stopped:
        solve_series(pipes, ACROSS, tmp_path, ThisProcess(1), lambda now: None)
    assert stopped.value.missing == ("thick", "coarse")
    assert stopped.value.words == "2 of 3 cases are missing: thick; coarse"
    found = solve_series(pipes, ACROSS, tmp_path, ThisProcess(1), lambda now: None)
    assert len(found) == 3
    assert (tmp_path / "case" / "log.simpleFoam").read_text().count("Create time") == 1


@pytest.mark.thorough
def test_workers_find_what_this_process_finds(pipes, openfoam, tmp_path):
    here = solve_series(pipes[:2], ACROSS, tmp_path / "here", ThisProcess(1), lambda now: None)
    there = solve_series(pipes[:2], ACROSS, tmp_path / "there", LocalDask(2, 1), lambda now: None)
    assert [each.judgement for each in there] == [each.judgement for each in here]
    again = solve_series(pipes[:2], ACROSS, tmp_path / "there", ThisProcess(1), lambda now: None)
    assert [each.seconds for each in again] == [each.seconds for each in there]


@pytest.fixture
def jobs(tmp_path):
    return Slurm(2, memory="1 GiB", options=["--partition=short"], interface="lo", logs=tmp_path / "slurm")


@pytest.mark.slow
def test_jobs_of_slurm_find_what_this_process_finds(own_slurm, pipes, jobs, openfoam, tmp_path):
    """Each on two cores: the solver is one of several processes within a job."""
    here = solve_series(pipes, ACROSS, tmp_path / "here", ThisProcess(1), lambda now: None)
    there = solve_series(pipes, ACROSS, tmp_path / "there", replace(jobs, jobs=1, cores=2), lambda now: None)
    values = [[each.judgement.value for each in found] for found in (here, there)]
    assert values[1] == pytest.approx(values[0], rel=1e-6)
    assert "blockMesh" not in there[1].seconds
    assert list((tmp_path / "slurm").glob("*.err"))


@pytest.mark.slow
def test_a_job_that_is_cancelled_is_gone_on_with_by_another(own_slurm, pipes, jobs, openfoam, tmp_path):
    thin = pipes[0].case
    patient = thin._replace(phases=(thin.phases[0]._replace(most=4000, tolerance=0.0),))
    cancelled = []

    def cancel(now):
        if now.judgement and now.done > 100 and not cancelled:
            cancelled.extend(told("squeue", "-h", "-o", "%i").split())
            told("scancel", *cancelled)

    (found,) = solve_series([NamedCase("", patient)], ACROSS, tmp_path / "flow", jobs, cancel)
    assert cancelled
    assert found.history.iterations.tolist() == list(range(1, 4001))
    assert (tmp_path / "flow" / "case" / "log.simpleFoam").read_text().count("Create time") == 2


@pytest.mark.slow
def test_a_job_that_fails_is_named_with_its_log(own_slurm, pipes, jobs, openfoam, tmp_path):
    sound, thick, _ = pipes
    wild = thick.case.phases[0]._replace(relaxation=(1.0, 1.99, 1.0), most=400)
    cases = [sound, NamedCase("wild", thick.case._replace(phases=(wild,), largest=1.0))]
    with pytest.raises(RunError, match=r"diverged.*; see .*/case-2/log\.simpleFoam"):
        solve_series(cases, ACROSS, tmp_path / "flow", jobs, lambda now: None)
    assert (tmp_path / "flow" / "case-2" / "log.simpleFoam").is_file()
    kept = solve_series(cases[:1], ACROSS, tmp_path / "flow", ThisProcess(1), lambda now: None)
    assert kept[0].settled
