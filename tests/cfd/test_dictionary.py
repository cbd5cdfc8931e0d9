"""Dictionaries: what is written, and that OpenFOAM itself reads it."""

import subprocess

import pytest
from tests.cfd.conftest import OIL, PAIR

from vvdp.cfd.case import phase_files, start_files, write_files
from vvdp.cfd.dictionary import dictionary_text
from vvdp.cfd.numerics import SECOND_ORDER
from vvdp.cfd.turbulence import C_MU, MODELS, STANDARD, duct_turbulence
from vvdp.cfd.verification import cylinders_case


def test_blanks_stand_round_every_brace():
    text = dictionary_text({"list": (1, 2.5, ("a", {"b": (0, 1), "c": {"d": True}})), "grad(U)": "Gauss linear"}, "x")
    assert "list ( 1 2.5 ( a { b ( 0 1 ); c { d yes; } } ) );" in text
    assert "grad(U) Gauss linear;" in text
    assert "    object x;\n" in text


def test_a_dictionary_below_a_key_has_lines_of_its_own():
    text = dictionary_text({"solvers": {"p": {"solver": "GAMG", "relTol": 0.05}}}, "fvSolution")
    assert text.endswith("solvers\n{\n    p\n    {\n        solver GAMG;\n        relTol 0.05;\n    }\n}\n")


@pytest.mark.parametrize("model", MODELS)
def test_openfoam_reads_every_dictionary(model, openfoam, tmp_path):
    """By its own reader, each file of a case."""
    case = cylinders_case(PAIR, OIL, 4)._replace(turbulence=MODELS[model], start=duct_turbulence(1.0, 4e-3))
    files = {**case.mesh_files, **start_files(case), **phase_files(case, SECOND_ORDER, 20)}
    write_files(tmp_path, files)
    for path in files:
        read = subprocess.run(
            ["foamDictionary", "-keywords", path],
            cwd=tmp_path,
            env=openfoam.environment,
            capture_output=True,
            text=True,
        )
        assert read.returncode == 0, read.stderr
        assert "FoamFile" in read.stdout
    wanted = {"U", "p"} | ({"k", "nut", MODELS[model].scale} if MODELS[model].scale else set())
    assert {path.name for path in (tmp_path / "0").iterdir()} == wanted


def test_turbulence_that_enters_has_the_viscosity_of_its_length():
    """nu_t = C_mu k^2 / epsilon = C_mu^(1/4) k^(1/2) l, and epsilon = C_mu omega k."""
    found = duct_turbulence(8.0, 0.01)
    assert C_MU * found.k**2 / found.epsilon == pytest.approx(C_MU**0.25 * found.k**0.5 * 0.07 * 0.01)
    assert found.epsilon == pytest.approx(C_MU * found.omega * found.k)
    assert STANDARD.scale == "epsilon"
