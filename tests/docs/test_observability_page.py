"""Numbers that docs/models/observability.md spells out."""

import re
from pathlib import Path

import numpy as np
import pytest

from vvdp.estimation.observability import (
    Plant,
    margin_with_pressure,
    natural_frequency,
    observability_margin,
    unobservable_speeds,
)

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "models" / "observability.md").read_text("utf-8").split())
TURN = 2.0 * np.pi
SPOOL = Plant(mass=0.5, stiffness=2594.0)
GAMMA = natural_frequency(SPOOL)


def test_table_of_margins():
    rows = re.findall(r"\| ([\d.]+) \| (\d+) \| ([\d.]+) \|", PAGE)
    assert len(rows) == 8
    for speed, k, margin in rows:
        digits = len(margin.partition(".")[2])
        assert f"{observability_margin(GAMMA, TURN * float(speed), int(k)):.{digits}f}" == margin


def test_natural_frequency_and_lost_speeds():
    assert f"$\\gamma$ = {GAMMA:.2f} rad/s, {GAMMA / TURN:.3f} Hz" in PAGE
    speeds = [f"{f:.3f}" for f in unobservable_speeds(GAMMA, 5) / TURN]
    assert f"lost at {', '.join(speeds[:4])} and {speeds[4]} rev/s" in PAGE


def test_margin_of_an_integrator():
    assert f"{observability_margin(0.0, TURN * 10.0, 5):.4f} with five harmonics" in PAGE


def test_margin_with_friction():
    damped = SPOOL._replace(damping=20.0)
    at_resonance, above = (margin_with_pressure(damped, omega, 5) for omega in (GAMMA, TURN * 22.5))
    assert f"{at_resonance:.4f} at resonance, in place of 0, and {above:.3f} at 22.5 rev/s, in place of 0.074" in PAGE


def test_margin_with_pressure():
    stiffness = 1.74e-4**2 / 4.995e-13
    assert f"it is {stiffness / 1e3:.1f} kN/m" in PAGE
    assert f"the margin is {margin_with_pressure(SPOOL, GAMMA, 5, [stiffness]):.2f} at resonance" in PAGE
    speeds = TURN * np.linspace(1.5, 60.0, 60)
    least = min(margin_with_pressure(SPOOL, omega, 5, [stiffness]) for omega in speeds)
    assert np.floor(100.0 * least) / 100.0 == 0.69 and "at least 0.69 up to 60 rev/s" in PAGE


def test_short_turns_hide_the_velocity():
    """Goes with the square of r."""
    margins = [observability_margin(GAMMA, ratio * GAMMA, 5) for ratio in (50.0, 100.0)]
    assert margins[0] / margins[1] == pytest.approx(4.0, rel=5e-3)
