import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from vvdp.base.errors import ParameterError
from vvdp.sensing.photodiode import LightSpot, photodiode_signal, ramp_width, spot_share, swept_distance
from vvdp.sensing.wheel import equal_wheel, sector_widths, wheel_of_widths


def spot(width, roundness):
    return LightSpot(width=width, track_radius=0.01, roundness=roundness)


def test_ramp_of_a_spot_of_5_mm_on_sectors_of_8_mm():
    """Eight sectors of 8 mm: track radius 64 mm / (2 pi); 5 mm over that is 5/8 of pi/4 = 0.4909 rad."""
    track = LightSpot(width=5e-3, track_radius=64e-3 / (2 * np.pi), roundness=0.0)
    assert ramp_width(track) == pytest.approx(5.0 / 8.0 * np.pi / 4.0)


@pytest.mark.parametrize("x", [-0.5, -0.31, 0.0, 0.12, 0.5])
def test_share_of_a_disc_is_the_area_of_the_segment(x):
    """Chords of a circle of diameter 1 from -0.5 to x, over its area pi/4."""
    area, _ = quad(lambda u: 2.0 * np.sqrt(max(0.25 - u * u, 0.0)), -0.5, x, epsabs=1e-12)
    assert spot_share(x, 1.0) == pytest.approx(area / (np.pi / 4.0), abs=1e-9)


def test_share_of_a_strip_is_a_straight_line():
    assert [spot_share(x, 0.0) for x in (-0.7, -0.5, -0.25, 0.0, 0.5, 0.9)] == [0.0, 0.0, 0.25, 0.5, 1.0, 1.0]


@given(st.floats(0.01, 0.99), st.sampled_from([0.0, 0.3, 1.0]))
def test_swept_distance_is_the_inverse(share, roundness):
    assert spot_share(swept_distance(share, roundness), roundness) == pytest.approx(share, abs=1e-9)


@pytest.mark.parametrize("roundness", [0.0, 1.0])
@pytest.mark.parametrize("width", [0.003, 0.009, 0.02])  # narrower than each sector; wider than some; than two
def test_signal_is_the_bright_share_of_the_spot(width, roundness):
    """Against points all over the spot, each looked up on the wheel: within the width of a strip of them."""
    wheel, track = wheel_of_widths([1.0, 0.7, 2.0, 1.1, 0.6, 1.9]), spot(width, roundness)
    points = 4001
    x = (np.arange(points) + 0.5) / points - 0.5
    weight = np.sqrt(0.25 - x * x) if roundness else np.ones(points)
    for angle in np.linspace(-3.0, 9.0, 40):
        places = (angle + x * ramp_width(track)) % (2 * np.pi)
        bright = np.searchsorted(wheel.edges, places, side="right") % 2
        expected = np.sum(weight * bright) / np.sum(weight)
        assert photodiode_signal(angle, wheel, track) == pytest.approx(expected, abs=3.0 / points)


@pytest.mark.parametrize("roundness", [0.0, 1.0])
def test_mean_light_is_the_bright_share_of_the_wheel(roundness):
    """A rectangle rule over a whole turn; corners of the ramp cost less than one point of it."""
    wheel, track = equal_wheel(8, 0.25), spot(0.004, roundness)
    angles = np.arange(20000) / 20000 * 2 * np.pi
    bright = sum(sector_widths(wheel)[::2]) / (2 * np.pi)
    assert np.mean(photodiode_signal(angles, wheel, track)) == pytest.approx(bright, abs=1e-4)


def test_arrays_give_what_numbers_give():
    wheel, track = equal_wheel(8, 0.25), spot(0.004, 1.0)
    angles = np.linspace(-9.0, 9.0, 101)
    assert photodiode_signal(angles, wheel, track) == pytest.approx(
        [photodiode_signal(a, wheel, track) for a in angles.tolist()], abs=1e-14
    )


def test_a_track_without_a_radius_is_refused():
    with pytest.raises(ParameterError, match=r"LightSpot\.track_radius: 0 mm must be greater than 0"):
        LightSpot(width=5e-3, track_radius=0.0, roundness=0.0)
