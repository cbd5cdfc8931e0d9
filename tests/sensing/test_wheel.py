import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.sensing.wheel import (
    TURN,
    CodeWheel,
    edge_angle,
    edge_below,
    edge_polarity,
    equal_wheel,
    mirror_wheel,
    nearest_edge,
    sector_widths,
    wheel_of_widths,
)

widths = st.lists(st.floats(0.1, 10.0), min_size=1, max_size=6).map(lambda half: half + half[::-1])


def test_eight_sectors_with_an_index():
    """A sector of pi/4; edge 1 moved by a quarter of it: the first sector 1.25, the second 0.75 of the others."""
    wheel = equal_wheel(8, 0.25)
    assert sector_widths(wheel) == pytest.approx(np.pi / 4 * np.array([1.25, 0.75, 1, 1, 1, 1, 1, 1]))
    assert sum(sector_widths(wheel)) == pytest.approx(TURN)
    assert wheel.has_index
    assert not equal_wheel(8).has_index


def test_a_wheel_that_repeats_itself_has_no_index():
    """Two and one in turn, four times: looks the same after a quarter of a turn."""
    assert not wheel_of_widths([2, 1, 2, 1, 2, 1, 2, 1]).has_index
    assert wheel_of_widths([2, 1, 2, 1, 2, 1, 2, 1.5]).has_index


def test_edges_along_the_unwrapped_angle():
    """Edge 9 is edge 1 a turn later, 1.25 pi/4 + 2 pi; edge -1 is edge 7 a turn earlier, -pi/4."""
    wheel = equal_wheel(8, 0.25)
    assert edge_angle(9.0, wheel) == pytest.approx(1.25 * np.pi / 4 + 2 * np.pi)
    assert edge_angle(-1.0, wheel) == pytest.approx(-np.pi / 4)
    assert [edge_polarity(n) for n in (0.0, 1.0, -1.0, -2.0)] == [1.0, -1.0, -1.0, 1.0]


@given(widths, st.floats(-60.0, 60.0))
def test_every_angle_lies_between_two_edges(parts, angle):
    wheel = wheel_of_widths(parts)
    below = edge_below(angle, wheel)
    assert edge_angle(below, wheel) <= angle + 1e-12
    assert edge_angle(below + 1.0, wheel) > angle - 1e-12


@given(widths, st.floats(-60.0, 60.0), st.sampled_from([-1.0, 0.0, 1.0]))
def test_the_nearest_edge_is_found_among_all(parts, angle, polarity):
    wheel = wheel_of_widths(parts)
    n = len(parts)
    turn = int(np.floor(angle / TURN))
    candidates = [float(m) for m in range((turn - 1) * n, (turn + 2) * n) if polarity * edge_polarity(m) >= 0.0]
    least = min(abs(edge_angle(m, wheel) - angle) for m in candidates)
    found = nearest_edge(angle, polarity, wheel)
    assert polarity * edge_polarity(found) >= 0.0
    assert abs(edge_angle(found, wheel) - angle) == pytest.approx(least, abs=1e-9)


@given(widths, st.floats(-60.0, 60.0))
def test_a_turn_further_is_a_turn_of_edges_further(parts, angle):
    wheel = wheel_of_widths(parts)
    off_edge = min(abs(edge_angle(nearest_edge(angle, 0.0, wheel), wheel) - angle), 1.0)
    if off_edge > 1e-9:
        assert edge_below(angle + TURN, wheel) == edge_below(angle, wheel) + len(parts)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: equal_wheel(7), "7 sectors"),
        (lambda: equal_wheel(8, 0.95), "0.95 sectors"),
        (lambda: CodeWheel((0.0, 1.0, 2.0)), "3 edges"),
        (lambda: CodeWheel((0.0, 2.0, 1.0, 3.0)), "increasing"),
        (lambda: CodeWheel((0.0, 7.0)), "less than 360 deg"),
        (lambda: wheel_of_widths([1.0, 0.0]), "each must be greater than 0"),
    ],
)
def test_what_is_no_wheel_is_refused(make, message):
    with pytest.raises(ParameterError, match=message):
        make()


@given(widths.map(wheel_of_widths))
def test_a_mirrored_wheel_is_met_in_the_other_order(wheel):
    """Edge k lies as far before edge 0 as edge -k did beyond it; even numbers, the rising ones, stay even."""
    mirrored = mirror_wheel(wheel)
    for k in range(-20, 21):
        assert edge_angle(float(k), mirrored) == pytest.approx(-edge_angle(float(-k), wheel), abs=1e-12)
    assert mirror_wheel(mirrored).edges == pytest.approx(wheel.edges)
    assert sector_widths(mirrored) == pytest.approx(sector_widths(wheel)[::-1])


def test_a_mirrored_index_by_hand():
    """Widths 1.25, 0.75, 1, ... of pi/4 come backwards as 1, ..., 0.75, 1.25: edge 7 lies at 6.75 pi/4."""
    mirrored = mirror_wheel(equal_wheel(8, 0.25))
    assert mirrored.edges == pytest.approx(np.pi / 4 * np.array([0, 1, 2, 3, 4, 5, 6, 6.75]))
    assert mirror_wheel(equal_wheel(8)).edges == pytest.approx(equal_wheel(8).edges)


def test_a_wheel_that_begins_beyond_an_edge_has_no_mirror_image():
    with pytest.raises(ParameterError, match="less than 360 deg"):
        mirror_wheel(CodeWheel((0.5, 0.6, 2.0, 4.0)))
