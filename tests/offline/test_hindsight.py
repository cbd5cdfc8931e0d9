"""Rows that later edges contradict, and edges that are counted wrongly."""

import h5py
import numpy as np
import pytest

from vvdp.offline.course import Explanation
from vvdp.offline.hindsight import View, contradictions, count_deviation, look_back, sudden
from vvdp.offline.passage import Noise
from vvdp.offline.speed_doubt import NO_DOUBT, Doubt

TURN = 2.0 * np.pi
PITCH, SPEED = TURN / 8, 157.0


def rows_at(times, speed=SPEED, deviation=0.2):
    size = len(times)
    columns = {"speed": speed, "standstill": 0.0, "speed_deviation": deviation, "angle_deviation": 0.01}
    return {"time": np.asarray(times, float)} | {name: np.full(size, value) for name, value in columns.items()}


def edges_at(times, variance=1e-6):
    times = np.asarray(times, float)
    return np.array([times, PITCH * np.arange(times.size), np.full(times.size, variance)])


def test_a_late_edge_by_hand():
    """A sector in 20 ms is pi/4/0.02 = 39.3 rad/s: 117.7 less than the row has; after 10 ms that is 1.18 rad."""
    edges = edges_at([0.0, 0.005, 0.025, 0.045, 0.065, 0.085])
    more = contradictions(rows_at([0.004, 0.015]), edges, 0.0)
    assert np.sqrt(more["speed_deviation"][1]) == pytest.approx(SPEED - PITCH / 0.02, rel=1e-6)
    assert np.sqrt(more["angle_deviation"][1]) == pytest.approx(0.01 * (SPEED - PITCH / 0.02), rel=1e-6)
    # the row before belongs to a sector of 157 rad/s; the fourth edge from there lies 65 ms ahead
    assert np.sqrt(more["speed_deviation"][0]) == pytest.approx(SPEED - 4 * PITCH / 0.065, rel=1e-6)


def test_what_agrees_with_the_edges_is_left():
    """An even speed, jitter within three deviations, a row at a standstill, and rows outside of the edges."""
    even = edges_at(np.arange(20) * PITCH / SPEED, variance=1e-4)
    even[0] += np.random.default_rng(3).normal(0.0, 5e-3 / SPEED, 20)  # so it takes six of its deviations
    inside = rows_at(np.linspace(even[0, 0], even[0, -1] - 1e-6, 50))
    assert not np.any(contradictions(inside, even, 0.0)["speed_deviation"])
    stopped = rows_at([0.015]) | {"standstill": np.array([0.9])}
    late = edges_at([0.0, 0.005, 0.025, 0.045])
    assert not np.any(contradictions(stopped, late, 0.0)["speed_deviation"])
    assert not np.any(contradictions(rows_at([-0.01, 0.5]), late, 0.0)["speed_deviation"])


def test_a_ripple_that_the_filter_knows_is_no_contradiction():
    """A row 5 rad/s above the mean of its turn: one of a filter that knows of 3.5 % says nothing new."""
    even = edges_at(np.arange(20) * PITCH / SPEED)
    fast = rows_at([0.02], speed=SPEED + 5.0)
    assert contradictions(fast, even, 0.0)["speed_deviation"][0] == pytest.approx(25.0, rel=1e-2)
    assert contradictions(fast, even, 0.5 * 0.035**2)["speed_deviation"][0] == 0.0


def kept_file(path, times, numbers, rows):
    with h5py.File(path, "w") as file:
        ones = np.ones(len(times))
        columns = {"time": times, "number": numbers, "angle": PITCH * np.asarray(numbers), "variance": 1e-6 * ones}
        columns["sector"] = np.mod(numbers, 8)
        rows["angle"] = np.zeros(rows["time"].size)
        for name, values in (columns | {"piece": ones}).items():
            file[f"edges/{name}"] = values
        for name, values in (rows | {"piece": np.ones(rows["time"].size)}).items():
            file[name] = values
    return path


def test_a_piece_that_ends_at_a_standstill_has_an_edge_more(tmp_path):
    """The last rows after the last edge had 157 rad/s, and the spool stands 0.2 s later: half a sector in that time."""
    times = np.arange(10) * PITCH / SPEED
    rows = rows_at(times[-1] + np.array([0.002, 0.2]))
    rows["standstill"] = np.array([0.0, 0.99])
    with h5py.File(kept_file(tmp_path / "kept.h5", times, np.arange(10.0), rows), "r+") as file:
        look_back(file, View(None, NO_DOUBT, 0.0, PITCH))
        found = file["speed_deviation"][:]
    assert found[0] == pytest.approx(SPEED - 0.5 * PITCH / 0.2, rel=5e-3)
    assert found[1] == pytest.approx(0.2, rel=1e-12)


def test_the_doubt_is_added_to_the_variances(tmp_path):
    """Of 0.2 rad/s and 0.01 rad: 157 rad/s have 0.01 times that more, and the angle 0.03 rad; at a standstill the speed
    has none."""
    times = np.arange(40) * PITCH / SPEED
    rows = rows_at([0.05, 0.06])
    rows["standstill"] = np.array([0.0, 0.9])
    with h5py.File(kept_file(tmp_path / "kept.h5", times, np.arange(40.0), rows), "r+") as file:
        look_back(file, View(None, Doubt(1e-4, 9e-4), 0.0, PITCH))
        assert file["speed_deviation"][:] == pytest.approx([np.hypot(0.2, 1.57), 0.2], rel=1e-12)
        assert file["angle_deviation"][:] == pytest.approx(np.hypot(0.01, 0.03), rel=1e-12)


def test_a_long_piece_is_judged_part_by_part(tmp_path, monkeypatch):
    """In parts of 40 rows, with 30 edges beside each, as in one; the mean over eight edges ends with a part."""
    times = np.arange(400) * PITCH / SPEED
    jitter = np.random.default_rng(1).normal(0.0, 0.01, 400) / SPEED
    view, found = View(Explanation(Noise(0.1, 1e-4), 1e-6, np.zeros(8), None), NO_DOUBT, 0.0, PITCH), []
    for rows, margin in ((10_000, 5000), (40, 30)):
        monkeypatch.setattr("vvdp.offline.hindsight.ROWS", rows)
        monkeypatch.setattr("vvdp.offline.hindsight.MARGIN", margin)
        at = rows_at(np.linspace(0.2, 1.8, 400), speed=SPEED + 1.0)
        with h5py.File(kept_file(tmp_path / f"{rows}.h5", times + jitter, np.arange(400.0), at), "r+") as file:
            file["angle"][:] = SPEED * file["time"][:]
            look_back(file, view)
            found.append(file["speed_deviation"][:])
    assert found[0] == pytest.approx(1.0, abs=0.15)
    assert found[1] == pytest.approx(found[0], rel=0.15)


def test_a_sudden_change_by_hand():
    """pi/4 in 5, 20 and 5 ms: 157 rad/s, 39.3 and 157. The turning point, 2 39.3 - 157, would be backwards, so it is 0,
    and a row of 100 rad/s may be off by that much. With 8 ms in the middle it is 2 98.2 - 157.1 = 39.3 rad/s."""
    for middle, most in ((0.02, 100.0), (0.008, 2.0 * PITCH / 0.008 - PITCH / 0.005 - 100.0)):
        edges = edges_at(np.cumsum([0.0, 0.005, middle, 0.005]))
        more = sudden(rows_at([0.007], speed=100.0), edges)
        assert np.sqrt(more["speed_deviation"][0]) == pytest.approx(abs(most), rel=1e-9)
        assert np.sqrt(more["angle_deviation"][0]) == pytest.approx(0.002 * abs(most), rel=1e-9)
    assert not np.any(sudden(rows_at([-0.01, 0.5]), edges)["speed_deviation"])


@pytest.mark.parametrize("lost", [0, 4])
def test_edges_that_were_passed_over_are_counted_by_the_times(tmp_path, lost):
    """Of 400 edges every third is missed; where the filter passed over `lost` in the middle, half the edges are off by
    so many: about their mean, by half of it."""
    shown = np.flatnonzero(np.arange(400) % 3 != 0)
    numbers = shown - lost * (shown > 200).astype(float)
    rows = rows_at([0.0])
    with h5py.File(kept_file(tmp_path / "kept.h5", shown * PITCH / SPEED, numbers, rows)) as file:
        assert count_deviation(file, many=True) == pytest.approx(0.5 * lost, rel=1e-2)


def test_an_edge_that_the_filter_takes_to_be_missed_counts_if_the_times_say_otherwise(tmp_path):
    """Of 400 regular edges the filter takes one in the middle for missed: half of them are off by one. At a pause of
    three sectors that it counts as one nothing is wrong, unless many edges are missed: then two are."""
    numbers = np.arange(400) + (np.arange(400) > 200)
    times = np.arange(400) * PITCH / SPEED
    with h5py.File(kept_file(tmp_path / "kept.h5", times, numbers, rows_at([0.0]))) as file:
        assert count_deviation(file, many=False) == pytest.approx(0.5, rel=1e-2)
    times[201:] += 2.0 * PITCH / SPEED
    with h5py.File(kept_file(tmp_path / "pause.h5", times, np.arange(400), rows_at([0.0]))) as file:
        assert count_deviation(file, many=False) == 0.0
        assert count_deviation(file, many=True) == pytest.approx(1.0, rel=1e-2)
