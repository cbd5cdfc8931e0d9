"""What the page says of loss models that are derived from the sources: its numbers, worked out anew."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from vvdp.evaluation.summary import summary
from vvdp.fluid import mixture, modulus
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
from vvdp.valve.geometry import wedge_opening

TANK, HIGH = 101325.0, 1e7 + 101325.0
BENCH = "prototype-constant-load"


def found_by(*settings):
    system = load_system(BENCH, settings, until="1 s")
    return summary(system, simulate(system.model, system.case, system.stepping))


@pytest.fixture(scope="module")
def words(page):
    """The page without its line breaks."""
    return " ".join(page.split())


def test_products_of_ramps_count_images_twice(words):
    """Zero lap: d_c = kappa/2 pitches. The sum over the wedges' images, roles swapped above duty ratio 1/2, against the
    staircase; places 0 to 1/2 of a pitch, duty ratios 0 to 1."""

    def ramp(x):
        return np.clip(0.5 + x, 0.0, 1.0)

    def worst(kappa):
        delta, t, images = 0.5 * kappa, np.linspace(0.0, 0.5, 201), np.arange(-3, 4)
        off = []
        for d in np.linspace(0.0, 1.0, 201):
            h, swapped = 0.5 * (d - delta), 0.5 * (1.0 - d + delta)
            x, own = (t[:, None] - images, h) if d <= 0.5 else (t[:, None] - 0.5 - images, swapped)
            total = np.sum(ramp((own - x) / delta) * ramp((own + x) / delta), axis=1)
            staircase = [wedge_opening(place, h, delta) for place in t.tolist()]
            off.append(np.max(np.abs((total if d <= 0.5 else 1.0 - total) - staircase)))
        return max(off)

    assert worst(0.3) < 1e-14 and worst(0.5) < 1e-14
    assert f"{worst(0.605):.3f} off at 0.605 and {worst(0.756):.3f} at 0.756" in words


def test_volumes_against_mass(words):
    """int p/beta dp and what is stored with mass conserved; the mean moduli of (2.10) and (5.19); what an orifice makes
    that passes the same volume on both sides."""
    oil = load_system(BENCH).case.params.oil
    larger, apart = [], []
    for air in (0.001, 0.01, 0.05, 0.1):
        here = replace(oil, air_fraction=air)
        volumes = quad(lambda p, here=here: (p - TANK) / mixture.bulk_modulus(p, here), TANK, HIGH, epsrel=1e-10)[0]
        larger.append(100.0 * (mixture.compression_energy_per_volume(HIGH, TANK, here) / volumes - 1.0))
        both = mixture.mean_bulk_modulus(HIGH, here), modulus.mean_modulus(HIGH, TANK, mixture.bulk_modulus, here)
        apart.append(100.0 * (both[0] / both[1] - 1.0))
    assert " / ".join(f"{x:.1f}" for x in larger[1:]) + " % at 1 / 5 / 10 % air" in words
    assert f"differ by {apart[0]:.2f} to {apart[-1]:.1f} %" in words
    assert f"creates {100.0 * (1.0 - mixture.specific_volume_ratio(HIGH, oil)):.1f} % of oil" in words


def test_budget_at_a_modulus_of_1_gpa(words):
    """The drops and the relief valve, in the order of the page."""
    stiff = ("oil.liquid_bulk_modulus=1e9 Pa", "oil.air_fraction=0")
    runs = [found_by(*stiff, f"valve.lap_ratio={lap}") for lap in (1.0, 0.8, 0.5, 1.2)]
    watts = [found["loss_full_open_W"] + found["loss_transition_W"] for found in runs]
    assert f"{watts[0]:.1f} W, and " + " / ".join(f"{x:.0f}" for x in watts[1:]) + " W" in words


@pytest.mark.parametrize("ratio", [1e-3, 1e-4])
def test_yus_law_holds_to_first_order(ratio):
    """Against the law that conserves mass, at P/E = air content = `ratio`: what is apart goes with their squares."""
    E, P0 = 1.7e9, 1e5
    P = ratio * E
    yu = modulus.YuAir(
        liquid_bulk_modulus=E, air_fraction=ratio, polytropic_exponent=1.4, reference_pressure=P0, dissolving_rate=0.0
    )
    cho = modulus.PolytropicAir(
        liquid_bulk_modulus=E, air_fraction=ratio / (1.0 - ratio), polytropic_exponent=1.4, reference_pressure=P0
    )
    compliances = [E / modulus.yu_bulk_modulus(P, yu), E / modulus.cho_bulk_modulus(P, cho)]
    assert 0.0 < abs(compliances[0] - compliances[1]) < 3.0 * ratio


def test_a_balance_says_less_than_a_finer_run():
    """1.4e-6 and 1.4e-5 on the page, to a factor of 2.5: both hang on where single steps end."""
    coarse, fine = found_by("run.relative_tolerance=1e-4"), found_by("run.relative_tolerance=1e-9")
    nozzles = coarse["loss_nozzle_W"] / fine["loss_nozzle_W"] - 1.0
    assert 0.6e-6 < abs(coarse["energy_residual"]) < 3.5e-6
    assert 0.6e-5 < abs(nozzles) < 3.5e-5
