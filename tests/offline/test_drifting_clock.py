"""A recorder whose clock runs fast, and ever faster: the angle stays true, the speed is off by what the clock is.

The clock shows s(t) = t + r t + d t^2 / 2. Edges pin the angle at the instants at which they pass, whatever the clock
calls them, so no turn is won or lost; but a speed is per second of that clock, omega / (1 + r + d t).
"""

import numpy as np
import pytest
from tests.offline.records import TURN, Motion, counted, crossings, even_edges, titles
from tests.words import wording

SPEED, UNTIL = 155.0, 20.0
FAST, DRIFT = 1e-4, 2e-5
"""By how much the clock runs fast at the beginning, and how much faster in a second [1/s]."""
LOST = {wording.estimate.pauses, wording.estimate.missed_edges, "Edges come twice", wording.estimate.time_backwards}


def clock(times):
    return times + FAST * times + 0.5 * DRIFT * times**2


def instants(shown):
    """When the clock shows a time: the root of its square, by hand."""
    return (np.sqrt((1.0 + FAST) ** 2 + 2.0 * DRIFT * shown) - (1.0 + FAST)) / DRIFT


def edge_log(motion):
    times, _ = crossings(motion, even_edges(8))
    return {"edge": (clock(times), "s")}


def counter_log(motion):
    channels = counted(motion, even_edges(8), 2000.0)
    return channels | {"time": (clock(channels["time"][0]), "s")}


def test_the_clock_and_its_inverse():
    assert clock(20.0) == pytest.approx(20.0 + 0.002 + 0.004, abs=1e-12)  # 20 + 1e-4 x 20 + 2e-5 x 400 / 2
    assert instants(clock(np.array([0.0, 3.0, 20.0]))) == pytest.approx([0.0, 3.0, 20.0], abs=1e-10)


@pytest.mark.parametrize(("record", "source"), [
    (edge_log, {"sensor__edges": "edge"}), (counter_log, {"sensor__counts": "n"}),
])  # fmt: skip
def test_a_drifting_clock_costs_no_angle_and_its_own_share_of_the_speed(estimated, record, source):
    motion = Motion(lambda t: SPEED, UNTIL)
    kept = estimated(record(motion), **source)
    assert kept.summary["pieces"] == 1 and not titles(kept) & LOST
    shown = kept.column("time")
    rows = (shown > 1.0) & (shown < UNTIL - 0.1)
    shown = shown[rows]
    true = instants(shown)
    error = kept.column("angle")[rows] - motion.angle_at(true)
    error -= TURN / 8 * np.round(np.median(error) / (TURN / 8))  # edge 0 is none in particular
    assert np.mean(np.abs(error) < 2.0 * kept.column("angle_deviation")[rows]) > 0.95
    assert abs(np.mean(error[-200:]) - np.mean(error[:200])) < 0.01  # no turn is won or lost in 490
    told, stated = kept.column("speed")[rows], kept.column("speed_deviation")[rows]
    assert told == pytest.approx(SPEED / (1.0 + FAST + DRIFT * true), abs=3.0 * np.max(stated))
    mean = (motion.angle_at(true[-1]) - motion.angle_at(true[0])) / (shown[-1] - shown[0])
    assert np.mean(told) == pytest.approx(mean, rel=2e-5)
    # As read it is 3e-4 of itself too low at the middle, a quarter of a stated deviation: no estimate can see that.
    assert np.mean(told) / SPEED - 1.0 == pytest.approx(-(FAST + DRIFT * 0.5 * UNTIL), abs=4e-5)


def test_two_clocks_of_one_log_are_each_believed(tmp_path):
    """A pressure on a clock of its own keeps its times; nothing is resampled or brought into line."""
    import h5py

    from vvdp.logs.source import open_log

    true = np.arange(0.0, 2.0, 1e-2)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["edges/time"], file["edges/v"] = true, np.sin(true)
        file["rail/time"], file["rail/p"] = clock(true), np.cos(true)
        for group in ("edges", "rail"):
            file[f"{group}/time"].attrs["units"] = "s"
    with open_log(tmp_path / "log.h5") as log:
        (portion,) = log.portions(["v", "p"], 1000)
    assert np.array_equal(portion["v"].times, true) and np.array_equal(portion["p"].times, clock(true))
