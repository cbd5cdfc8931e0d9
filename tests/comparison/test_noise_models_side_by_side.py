"""Four noise models on one pollution: errors in the order that theory has, states and margins as counted."""

from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.comparison.noise_models import NoiseTrial, basis_margin, noise_model_table
from vvdp.estimation.noise_basis import fourier_basis, gaussian_basis
from vvdp.estimation.observability import observability_margin

PAGE = " ".join((Path(__file__).parents[2] / "docs/models/axial-observer.md").read_text("utf-8").split())
PLACES = np.arange(360) / 360.0 * 2.0 * np.pi
SIZES = 1e-3 / 1.6 * np.array([1.0, 0.55, 0.30, 0.15, 0.08])
PHASES = np.array([0.3, 1.1, -0.7, 2.0, 0.5])
SHAPE = np.sin(np.multiply.outer(PLACES, np.arange(1, 6)) + PHASES) @ SIZES


def scratched(size):
    """The same with a scratch on the spool's end, 20 deg wide: what few functions cannot follow."""
    shape = SHAPE + size * np.exp(-(((PLACES - 2.0) / np.radians(10.0)) ** 2))
    return shape - shape.mean()


@pytest.fixture(scope="module")
def table():
    return noise_model_table(scratched(0.2e-3), NoiseTrial())


@pytest.mark.thorough
def test_models_states_and_margins(table):
    assert list(table["model"]) == [
        "lumped",
        wording.compare.signal_generator,
        *(f"Fourier, {n}" for n in (10, 20, 40)),
        *(f"Gaussian, {n}" for n in (10, 20, 40)),
    ]
    assert list(table["states"]) == [1, 100, 11, 21, 41, 11, 21, 41]
    assert np.all(np.diff(table["margin"][2:5]) < 0.0)
    assert np.all(np.diff(table["margin"][5:]) < 0.0)
    assert np.all(table["cost_s"] > 0.0)


def test_page_has_these_figures(table):
    for i, name in enumerate(table["model"]):
        margin = "" if np.isnan(table["margin"][i]) else f"{table['margin'][i]:.3f}"
        errors = [f"{1e6 * table[key][i]:.1f}" for key in ("position_error_rms_m", "pollution_error_rms_m")]
        row = " | ".join([name, f"{table['states'][i]:.0f}", margin, *errors])
        assert f"| {' '.join(row.split())} |" in PAGE


def test_more_functions_follow_the_scratch(table):
    errors = dict(zip(table["model"], table["pollution_error_rms_m"], strict=True))
    assert errors["Fourier, 40"] < errors["Fourier, 20"] < errors["Fourier, 10"] < 0.1 * errors["lumped"]
    assert errors["Gaussian, 40"] < errors["Gaussian, 20"] < errors["Gaussian, 10"]


def test_periodic_filters_hold_the_position(table):
    errors = dict(zip(table["model"], table["position_error_rms_m"], strict=True))
    assert errors["lumped"] > 20.0 * errors["Fourier, 10"]
    assert errors["lumped"] > 10.0 * errors["Gaussian, 20"]
    assert errors["Fourier, 10"] < 15e-6


def test_generator_refuses_a_period_between_samples():
    with pytest.raises(ParameterError, match=wording.compare.needs_whole_number):
        noise_model_table(SHAPE, NoiseTrial(spool_speed=2.0 * np.pi * 9.7), ())


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("hertz", "harmonics"), [(22.5, 5), (13.0, 5), (11.6, 5), (22.5, 20)])
def test_margin_of_a_basis_is_the_analytic_one(hertz, harmonics):
    speed, own = 2.0 * np.pi * hertz, np.sqrt(2594.0 / 0.5)
    found = basis_margin(fourier_basis(harmonics), own, speed)
    assert found == pytest.approx(observability_margin(own, speed, harmonics), rel=1e-2, abs=1e-5)
    assert basis_margin(gaussian_basis(10, 0.6), own, speed) < 1.0
