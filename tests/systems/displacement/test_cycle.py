"""The cycle that the cylinder follows: its course, and what is refused of one's own."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.programs.machine.cycle import (
    OwnCycle,
    Triangle,
    cycle_position,
    points_of,
    refuse_fast_points,
)

TRIANGLE = Triangle(lower_end=0.05, stroke=0.216, stroke_time=4.0)


def cycle_positions(cycle: Triangle | OwnCycle, times: np.ndarray) -> list[float]:
    return [cycle_position(float(t), points_of(cycle)) for t in times]


def test_a_triangle_goes_there_and_back_again() -> None:
    # 21.6 cm in 4 s: a quarter of the way after 1 s, back at 7 s, the same in the second period
    assert cycle_positions(TRIANGLE, np.array([0.0, 1.0, 4.0, 7.0, 8.0, 9.0])) == pytest.approx(
        [0.05, 0.104, 0.266, 0.104, 0.05, 0.104]
    )


def test_a_preview_reads_ahead() -> None:
    ahead = points_of(Triangle(lower_end=0.05, stroke=0.216, stroke_time=4.0, preview=0.16))
    assert cycle_position(1.0, ahead) == pytest.approx(cycle_position(1.16, points_of(TRIANGLE)))


def test_thousands_of_points_are_found_as_numpy_finds_them() -> None:
    times = np.cumsum(np.concatenate([[0.0], np.random.default_rng(3).uniform(1e-3, 5e-3, 5000)]))
    positions = 0.15 + 0.1 * np.sin(times)
    cycle = OwnCycle(times=tuple(times), positions=tuple(positions))
    asked = np.linspace(0.0, times[-1] + 1.0, 777)
    np.testing.assert_allclose(cycle_positions(cycle, asked), np.interp(asked, times, positions), rtol=1e-12)


@pytest.mark.parametrize(
    ("times", "positions", "message"),
    [
        ((0.0, 1.0, 1.0), (0.1, 0.2, 0.3), "row 3: the time is 1 s after 1 s"),
        ((0.0, 1.0), (0.1, 0.2, 0.3), "2 times and 3 positions"),
        ((0.5, 1.0), (0.1, 0.2), "row 1: the time is 0.5 s"),
    ],
)
def test_points_that_make_no_cycle_are_refused_with_their_row(
    times: tuple[float, ...], positions: tuple[float, ...], message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        OwnCycle(times=times, positions=positions)


def test_one_that_repeats_ends_where_it_began() -> None:
    with pytest.raises(ParameterError, match="repeats = 1"):
        OwnCycle(times=(0.0, 1.0), positions=(0.1, 0.2), repeats=1.0)


def test_a_jump_beyond_the_speed_is_refused_with_its_row() -> None:
    cycle = OwnCycle(times=(0.0, 1.0, 1.1, 2.0), positions=(0.1, 0.1, 0.2, 0.2))
    with pytest.raises(ParameterError, match=r"cycle: row 3: 1000 mm/s .* reach 300 mm/s"):
        refuse_fast_points(cycle, 0.3)


def test_a_gap_is_refused_with_its_row() -> None:
    times = (*np.arange(0.0, 1.0, 0.01), *np.arange(4.0, 5.0, 0.01))
    cycle = OwnCycle(times=tuple(map(float, times)), positions=(0.1,) * len(times))
    with pytest.raises(ParameterError, match=r"cycle: row 101: 3.01 s after the row before"):
        refuse_fast_points(cycle, 0.3)
