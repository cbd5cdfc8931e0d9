from dataclasses import replace

import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError


@pytest.mark.parametrize(
    ("change", "message"),
    [
        # d_c = sqrt(36.5e-6 * 26.6e-3 / (3 * 1.5e-3)) = 14.7 mm; twice of it is more than 26.6 mm, and at 2 mm 25.4 mm
        ({"helix_length": 1.5e-3}, "do not fit into the pitch of 26.6 mm"),
        ({"lap_ratio": 6.0}, "barrier width 23.9 mm do not fit"),
        ({"sections": 2.5}, "2.5 must be a whole number"),
        ({"sections": 0.0}, "sections: " + wording.files.must_be_greater_than_zero.format(value="0")),
        ({"inlet_radius": 15e-3}, "15 mm must be at most spool_radius, 12.7 mm"),
        ({"outlet_radius": 15e-3}, "15 mm must be at most spool_radius, 12.7 mm"),
        ({"radial_clearance": 1e-3, "spool_radius": 9e-3, "inlet_radius": 9e-3, "outlet_radius": 9e-3}, "1000 um"),
        ({"lap_ratio": 0.0}, "lap_ratio: " + wording.files.must_be_greater_than_zero.format(value="0")),
        (
            {"transition_pressure": 0.0},
            "transition_pressure: 0 bar must be greater than 0",
        ),
        ({"centre_flow_exponent": 1.2}, "outside 1.7 to 2 for a flow exponent with which the branch law is inverted"),
        ({"jet_exponent": 1.1}, "outside 0 to 1"),
    ],
)
def test_impossible_valves_are_refused_with_numbers(prototype, change, message):
    with pytest.raises(ParameterError, match=message):
        replace(prototype, **change)


def test_a_narrow_helix_that_just_fits_is_allowed(prototype):
    replace(prototype, helix_length=2e-3)
