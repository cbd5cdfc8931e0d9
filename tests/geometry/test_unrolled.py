"""The unwrapped surface: clipping polygons is another way to the openings of the hydraulic model."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vvdp.geometry.unrolled import (
    area,
    clip_polygon,
    clipped_openings,
    load_wedge,
    nozzle_outline,
    nozzle_positions,
    open_parts,
)
from vvdp.systems.system import load_system
from vvdp.valve.geometry import barrier_width, nozzle_width, pitch, port_openings

VALVE = load_system("prototype", ()).case.params.valve


@given(
    angle=st.floats(-20.0, 20.0),
    duty=st.floats(-0.5, 1.5),
    sections=st.sampled_from([1.0, 2.0, 3.0, 4.0, 5.0]),
    lap=st.floats(0.05, 2.0),
    size=st.floats(0.1, 2.5),
)
def test_clipping_agrees_with_the_formula(angle, duty, sections, lap, size):
    kappa = 0.5 * 0.3001 * np.sqrt(size) * (1.0 + lap)
    assume(kappa < 0.99)
    valve = replace(VALVE, sections=sections, lap_ratio=lap, nozzle_area=size * VALVE.nozzle_area)
    x = duty * valve.helix_length
    found, formula = clipped_openings(angle, x, valve), port_openings(angle, x, valve)
    assert found.load == pytest.approx(formula.load, abs=1e-9)
    assert found.tank == pytest.approx(formula.tank, abs=1e-9)


def test_half_a_nozzle_by_hand():
    """At zero lap and half of the pitch the nozzle's middle is on the barrier's edge when P/4 - b/2 past the apex."""
    u = 0.25 * pitch(VALVE) - 0.5 * barrier_width(VALVE)
    parts, tank = open_parts(nozzle_outline(VALVE, u, 0.5 * VALVE.helix_length), VALVE)
    assert tank == []
    # The edge runs through the middle along a diagonal of the skew square: half of 36.5 mm^2 / 3.
    assert sum(area(part) for part in parts) == pytest.approx(0.5 * 36.5e-6 / 3.0)


def test_outline_has_the_area_of_one_nozzle():
    assert area(nozzle_outline(VALVE)) == pytest.approx(VALVE.nozzle_area / 3.0)
    assert area(nozzle_outline(VALVE, scale=1.5)) == pytest.approx(2.25 * VALVE.nozzle_area / 3.0)


def test_nothing_is_left_outside_the_wedge():
    outline = nozzle_outline(VALVE, 0.0, -VALVE.helix_length)
    assert len(clip_polygon(outline, load_wedge(0, VALVE))) == 0


def test_nozzles_pass_against_the_rotation():
    """A spool turned by a little sees the nozzle at u = 0 a little behind."""
    before, after = nozzle_positions(0.0, 0.01, VALVE), nozzle_positions(0.1, 0.01, VALVE)
    assert after[0, 0] - before[0, 0] == pytest.approx(-0.1 * VALVE.spool_radius)
    assert nozzle_width(VALVE) < pitch(VALVE)
