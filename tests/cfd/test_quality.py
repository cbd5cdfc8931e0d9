"""y+ at the walls and residuals of each field, from tables as OpenFOAM writes them."""

import math

import pytest
from tests.cfd.conftest import PIPE, say

from vvdp.cfd.numerics import FIRST_ORDER, PASSING, SCHEMES, SECOND_ORDER, UPWIND
from vvdp.cfd.quality import CRITERIA, Quality, WallDistance, quality_monitors, read_quality
from vvdp.cfd.turbulence import LAMINAR, MODELS, SHEAR_STRESS, STANDARD

WALLS = """\
# y+ ()
# Time          \tpatch           \tmin             \tmax             \taverage
140             \trail            \t3.0e-01\t1.3e+01\t3.5e+00
140             \tnozzles         \t1.2e+00\t1.4e+01\t5.1e+00
160             \trail            \t4.0e-01\t1.4e+01\t3.6e+00
160             \tnozzles         \t1.3e+00\t1.5e+01\t5.2e+00
"""
RESIDUALS = """\
# Solver information
# Time \tU_solver\tUx_initial\tUx_final\tUy_initial\tU_converged\tp_solver\tp_initial\tp_converged
{rows}
"""
BOUNDARY = "rail { type wall; nFaces 300; }\nnozzles { type wall; nFaces 100; }\n"


@pytest.fixture
def case(tmp_path):
    """150 iterations, the residual of Uy 1e-3 and that of p 4e-3, in the last 50 of them 2e-3 and 6e-3."""
    rows = [(n, 2e-4, (1e-3, 2e-3)[n > 100], (4e-3, 6e-3)[n > 100]) for n in range(1, 161)]
    lines = "\n".join(f"{n}\tsolver\t{x}\t0.0\t{y}\tfalse\tGAMG\t{p}\tfalse" for n, x, y, p in rows)
    for name, table, text in (
        ("yPlus", "yPlus.dat", WALLS),
        ("residuals", "solverInfo.dat", RESIDUALS.format(rows=lines)),
    ):
        folder = tmp_path / "postProcessing" / name / "0"
        folder.mkdir(parents=True)
        (folder / table).write_text(text)
    (tmp_path / "constant" / "polyMesh").mkdir(parents=True)
    (tmp_path / "constant" / "polyMesh" / "boundary").write_text(BOUNDARY)
    return tmp_path


def test_walls_are_those_of_the_first_state_at_the_end_or_after_it(case):
    found = read_quality(case, 150, 50)
    assert found.walls == (WallDistance("rail", 300, 0.4, 3.6, 14.0), WallDistance("nozzles", 100, 1.3, 5.2, 15.0))
    assert read_quality(case, 140, 50).walls[0].mean == 3.5
    assert read_quality(case, 999, 50).walls[0].mean == 3.6


def test_the_mean_counts_faces(case):
    """(300 * 3.6 + 100 * 5.2) / 400 = 4.0."""
    assert read_quality(case, 150, 50).over_all_walls == pytest.approx((0.4, 4.0, 15.0))


def test_residuals_are_means_of_the_last_window_and_the_largest_component_counts(case):
    """Iterations 101 to 150: Uy 2e-3, p 6e-3; 81 to 130 has 20 of 1e-3 and 30 of 2e-3, mean 1.6e-3."""
    found = read_quality(case, 150, 50)
    assert found.residuals == pytest.approx({"U": 2e-3, "p": 6e-3})
    assert read_quality(case, 130, 50).residuals["U"] == pytest.approx(1.6e-3)
    assert found.unmet == ("U",)
    assert found.residual_share == pytest.approx(2e-3 / CRITERIA["U"])


def test_a_case_without_tables_has_no_walls(tmp_path):
    found = read_quality(tmp_path, 10, 5)
    assert found.walls == ()
    assert all(map(math.isnan, (*found.over_all_walls, found.residual_share)))
    assert Quality((), {}).unmet == ()


@pytest.mark.parametrize("model", MODELS.values())
def test_every_field_that_a_model_solves_is_watched_and_has_a_criterion(model):
    watched = quality_monitors(model)["residuals"]["fields"]
    assert set(watched) == {"U", "p"} | ({"k", model.scale} if model.scale else set())
    assert set(watched) <= set(CRITERIA)


def test_a_laminar_case_watches_no_turbulence():
    assert quality_monitors(LAMINAR)["residuals"]["fields"] == ("U", "p")
    assert quality_monitors(SHEAR_STRESS)["residuals"]["fields"][-1] == "omega"
    assert quality_monitors(STANDARD)["residuals"]["fields"][-1] == "epsilon"


def test_schemes_end_with_the_order_that_names_them():
    assert {name: phases[-1].order.replace(" ", "-") for name, phases in SCHEMES.items()} == dict(
        zip(SCHEMES, SCHEMES, strict=True)
    )
    assert [each.order for each in (UPWIND, FIRST_ORDER, PASSING, SECOND_ORDER)] == [
        *3 * ["first order"],
        "second order",
    ]
    assert FIRST_ORDER.tolerance == SECOND_ORDER.tolerance


def test_y_plus_of_a_pipe_is_that_of_its_wall_shear(pipe, openfoam, tmp_path):
    """Wall shear 4 mu v / R = 77.4 Pa, u_tau = 0.2972 m/s; the first centre is R/16 from the wall: y+ = 0.841."""
    from vvdp.cfd.solve import solve

    solved = solve(pipe, tmp_path / "case", openfoam, 1, lambda now: None)
    (wall,) = solved.quality.walls
    u_tau = math.sqrt(4.0 * 0.0387 * PIPE.velocity / PIPE.radius / 876.0)
    assert u_tau == pytest.approx(0.2972, abs=1e-4)
    expected = u_tau * PIPE.radius / 16.0 / (0.0387 / 876.0)
    assert expected == pytest.approx(0.841, abs=1e-3)
    assert wall.mean == pytest.approx(expected, rel=0.03)
    assert set(solved.quality.residuals) == {"U", "p"}


def test_an_order_of_schemes_that_is_not_known_is_refused():
    said = say("prototype", "--scheme", "third-order")
    assert said.code == 2
    assert "first-order" in said.err
