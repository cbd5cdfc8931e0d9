"""A log of a spool whose speed ripples: what is said, and how far an estimate with fitted settings can be trusted."""

import numpy as np
import pytest
from tests.offline.rippling import passing_times
from tests.words import wording

from vvdp.offline.config import Option, load_estimation
from vvdp.offline.facts import ripple_words, settings_facts
from vvdp.offline.findings import SETTINGS, tell
from vvdp.offline.noise_fit import fit_noise
from vvdp.offline.passage import Noise
from vvdp.offline.passed_edges import Passed
from vvdp.offline.turn_pattern import SpeedRipple

TURN = 2.0 * np.pi
SPEED = 155.0


def stamped(order, amplitude, jitter=0.0, turns=250, sectors=8):
    """Edges stamped by a timer, the wheel's second one moved by a quarter of a sector."""
    places = np.arange(sectors) * TURN / sectors
    places[1] += 0.25 * TURN / sectors
    angles = (TURN * np.arange(turns)[:, None] + places).ravel()[1:]
    angles = angles + np.random.default_rng(3).normal(0.0, jitter, angles.size)
    return {"edge": (passing_times(angles, order, amplitude, SPEED), "s")}


@pytest.fixture
def load_edges():
    """An estimation from edges, of a wheel with 8 sectors by default."""

    def load(**keys):
        keys = {"sensor__edges": "edge", "sensor__sectors": 8} | keys
        return load_estimation(None, [Option(key.replace("__", "."), key, value) for key, value in keys.items()])

    return load


def titles(kept):
    return [finding.title for finding in kept.findings]


def errors_of_speed(kept, order, amplitude, smoothed=""):
    """Over their stated deviations, after the first half second."""
    t = kept.column("time")
    fine = np.linspace(0.0, SPEED * (t[-1] + 0.1), 400_000)
    true = SPEED * (1.0 + amplitude * np.cos(order * np.interp(t, passing_times(fine, order, amplitude, SPEED), fine)))
    z = (kept.column(f"{smoothed}speed") - true) / kept.column(f"{smoothed}speed_deviation")
    return z[(t > 0.5) & np.isfinite(z)]


def test_a_ripple_that_the_filter_is_not_told_of_is_told(estimated):
    kept = estimated(stamped(3, 0.032), sensor__edges="edge", sensor__index_shift=0.25)
    (finding,) = [each for each in kept.findings if each.title == wording.estimate.ripple_or_wheel]
    assert finding.text.startswith(wording.estimate.ripple_of.format(amplitude="3.2 %", order=3))
    assert "--fit" in finding.remedy and "ripple_order = 3" in finding.remedy
    found = [kept.summary[f"ripple_{key}"] for key in ("order_fitted", "amplitude_fitted")]
    assert found == pytest.approx([3.0, 0.032], rel=2e-3)


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("order", "amplitude", "jitter"), [(3, 0.032, 0.0), (3, 0.032, 0.01), (2, 0.02, 0.003)])
def test_with_fitted_settings_the_speed_within_the_ripple_is_known_as_well_as_is_stated(
    estimated, order, amplitude, jitter
):
    """Twice the stated deviation covers 95 % of a Gaussian error; of exact edges only what a ripple of the first order
    leaves out remains, which is bounded."""
    kept = estimated(
        stamped(order, amplitude, jitter), sensor__edges="edge", sensor__index_shift=0.25, filter__fit=True
    )
    assert titles(kept) == [wording.estimate.taken_for_granted]
    assert kept.findings[0].text == wording.estimate.ripple_taken.format(
        ripple=ripple_words(SpeedRipple(order, amplitude, 0.0, 0.0))
    )
    z = errors_of_speed(kept, order, amplitude)
    assert np.mean(np.abs(z) < 2.0) > 0.9
    assert np.mean(z * z) < 2.0
    # the error is small against the ripple itself
    deviation = np.median(kept.column("speed_deviation"))
    assert deviation < 0.25 * amplitude * SPEED
    assert f"ripple_order = {order}" in kept.config


def test_the_smoother_takes_the_ripple_off_and_puts_it_back(estimated):
    log = stamped(3, 0.032, 0.005)
    kept = estimated(log, sensor__edges="edge", sensor__index_shift=0.25, filter__fit=True, output__smooth=True)
    z = errors_of_speed(kept, 3, 0.032, "smoothed_")
    assert np.mean(np.abs(z) < 2.0) > 0.9
    assert np.mean(z * z) < 2.0
    # a ripple of 5 rad/s is known to what is left of the second order, 155 0.032^2/2 = 0.08 rad/s, and its error
    assert np.median(kept.column("smoothed_speed_deviation")) < 0.2


def ripple_findings(told, wanted):
    """What is said of ripples."""
    return [each for each in tell(SETTINGS, settings_facts(told, wanted)) if "ripple" in each.title]


def edges_of(places, turns=200):
    """Edges of an even wheel at a constant speed, that lie `places` [rad] further on."""
    n = places.size
    numbers = np.arange(turns * n)
    angles = numbers * (TURN / n)
    zero, one = np.zeros(numbers.size), np.ones(numbers.size)
    return Passed((angles + places[numbers % n]) / SPEED, numbers.astype(float), angles, zero, one)


def test_what_too_few_edges_cannot_tell_is_told(load_edges):
    told = fit_noise(edges_of(0.02 * np.array([1.0, -1.0, 0.5, -0.5])), 4, Noise(0.25, 3.47e-3), 3)
    assert told.ripple is None
    (finding,) = ripple_findings(told, load_edges(sensor__sectors=4))
    assert finding.title == wording.estimate.ripple_not_whole
    assert (
        wording.estimate.ripple_takes.format(count=6) in finding.text
        and wording.estimate.wheel_has.format(count=4) in finding.text
    )
    told = fit_noise(edges_of(np.zeros(4)), 4, Noise(0.25, 3.47e-3), 3)
    assert not ripple_findings(told, load_edges(sensor__sectors=4))


def test_one_edge_elsewhere_is_no_ripple(load_edges):
    told = fit_noise(edges_of(0.1 * (np.arange(8) == 5)), 8, Noise(0.25, 3.47e-3), 3)
    assert told.wheel is not None and not ripple_findings(told, load_edges())
