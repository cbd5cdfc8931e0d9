"""Both readings of the fit of section 2.4.2."""

import numpy as np
import pytest

from vvdp.reproduction.chapter_2.drops import centre_fits

FLOW, DIAMETER = (each.ravel() for each in np.meshgrid(np.linspace(2e-4, 1.2e-3, 6), [0.020, 0.0254, 0.032]))


def study(drop):
    return {"flow_m3_s": FLOW, "diameter_m": DIAMETER, "static_drop_Pa": drop}


def test_an_exact_law_is_found_either_way():
    """40 lpm and 25.4 mm with (2.4): 0.8105 bar; neither fit misses any drop."""
    drop = FLOW**1.91 / (1.45e-6 * DIAMETER**3.22)
    for found in centre_fits(study(drop)):
        assert found[:2] == pytest.approx((1.91, 3.22), rel=1e-8)
        assert found.misfit < 1e-2


def test_a_surface_misses_the_largest_drops_by_less_than_a_plane():
    """Drops 10 % larger from half of the largest flow on: logarithms weigh small drops as much as large ones."""
    drop = FLOW**1.91 / (1.45e-6 * DIAMETER**3.22) * np.where(FLOW > 6e-4, 1.1, 1.0)
    plane, surface = centre_fits(study(drop))
    assert surface.misfit < plane.misfit
