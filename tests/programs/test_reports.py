"""Numbers of a law by hand: errors of a made-up motion, and where a program's truth stands."""

import numpy as np
import pytest

from vvdp.base.signal import constant
from vvdp.components.library import UsualOil
from vvdp.network.network import Network
from vvdp.programs.axial_numbers import Moved, motion_numbers
from vvdp.programs.report import origin

TIMES = np.arange(0.0, 3.0, 0.5)
NOTHING = np.full(TIMES.size, np.nan)


def moved(**columns):
    usual = {
        "true": 0.0 * TIMES,
        "reference": 0.0 * TIMES,
        "position": NOTHING,
        "deviation": NOTHING,
        "pollution": NOTHING,
    }
    return Moved(times=TIMES, **{**usual, **columns})


def test_errors_count_a_second_after_the_start():
    """From 1 s on errors of 3, -1, 1 and 3 mm: rms sqrt(20/4), largest 3; those before do not count."""
    errors = 1e-3 * np.array([9.0, -9.0, 3.0, -1.0, 1.0, 3.0])
    found = motion_numbers(moved(true=errors), 20e-3)
    assert found["spool_position_error_rms_m"] == pytest.approx(1e-3 * np.sqrt(5.0), rel=1e-12)
    assert found["spool_position_error_max_m"] == pytest.approx(3e-3, rel=1e-12)
    assert found["duty_error_rms"] == pytest.approx(np.sqrt(5.0) / 20.0, rel=1e-12)
    assert "spool_estimate_error_rms_m" not in found


def test_coverage_is_the_share_within_two_deviations():
    estimates = np.array([0.0, 0.0, 1.9, -2.1, 0.5, 3.0])
    found = motion_numbers(moved(position=estimates, deviation=1.0 + 0.0 * TIMES), np.nan)
    assert found["spool_estimate_coverage"] == 0.5
    assert "duty_error_rms" not in found


def test_a_short_run_has_no_numbers():
    short = moved()._replace(times=0.1 * TIMES)
    assert motion_numbers(short, 20e-3) == {}


def test_a_state_has_no_program_behind_it():
    net = Network(UsualOil())
    net.driven_shaft("spool", constant(10.0))
    assert origin(net, "spool.angle") == (None, "spool.angle")
