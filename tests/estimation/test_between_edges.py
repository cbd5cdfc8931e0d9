"""What is shown between edges: two beliefs beside each other, a manoeuvre suspected, an edge at its sample."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.estimation.between_edges import blur, doubtful, heard_plainly, inflate, suspected_density
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import event_filter
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel

PUBLISHED = event_filter(equal_wheel(8))


def test_two_beliefs_by_hand():
    """Odds of 3: w = 3/4. Angle 0 +- 1 and 4 +- 2: 3, variance 1/4 + 3 + 3/16 x 16; speed 10 +- 2 and 2 +- 2."""
    here, other = AngleSpeed(0.0, 10.0, 1.0, 0.0, 4.0), AngleSpeed(4.0, 2.0, 4.0, 0.0, 4.0)
    both = doubtful(heard_plainly(here)._replace(standstill=0.4, halt=0.8), other, np.log(3.0))
    assert both[:4] == pytest.approx((3.0, 4.0, 6.25, 4.0 + 12.0))
    assert (both.standstill, both.halt) == pytest.approx((0.1, 0.2))
    assert doubtful(heard_plainly(here), other, -60.0)[:4] == pytest.approx(heard_plainly(here)[:4])


def test_variances_that_are_added():
    assert blur(heard_plainly(AngleSpeed(1.0, 2.0, 3.0, 0.5, 4.0)), 0.25, 2.0)[:4] == (1.0, 2.0, 3.25, 6.0)


def test_an_inflated_belief_is_one_predicted_with_more():
    belief = AngleSpeed(1.0, 155.0, 0.01, 0.02, 3.0)
    assert inflate(predict(belief, 0.02, 0.25), 0.02, 2e4) == pytest.approx(predict(belief, 0.02, 2e4 + 0.25))


def test_a_suspicion_by_hand():
    """Sums of 3.5 are a likelihood ratio of e^7 = 1097; a change within a sector of 5 ms, 0.01 a second, has odds of
    5e-5 before and 0.0548 after, hence 0.0520 of 2e4 rad^2/s^3. Below e^2 nothing is suspected."""
    memory = event_filter_start(PUBLISHED, 0.0, 0.0, 155.0)
    for side in ("rise", "fall"):
        sums = memory.manoeuvre._replace(**{side: 3.5})
        found = suspected_density(memory._replace(manoeuvre=sums), 5e-3, PUBLISHED)
        assert found == pytest.approx(0.05198 * 2e4, rel=1e-3)
        few = memory.manoeuvre._replace(**{side: 0.99})
        assert suspected_density(memory._replace(manoeuvre=few), 5e-3, PUBLISHED) == 0.0


def test_an_edge_stamped_at_its_sample():
    """No time has passed since it, and a sector narrower than its noise is listened to at once: nothing is divided by
    that time, and the speed is as uncertain as the belief about it."""
    settings = replace(event_filter(equal_wheel(60)), speed_variance=1.0)
    memory = event_filter_start(settings, 0.0, 0.0, 155.0)
    for sample in range(1, 60):
        time = sample * 2.0 * np.pi / 60.0 / 155.0
        polarity = 1.0 - 2.0 * (sample % 2)
        with np.errstate(divide="raise", invalid="raise"):
            memory, shown = event_filter_step(memory, Reading(time, 1.0, time, 0.0, polarity), settings)
        assert abs(shown.speed - 155.0) < shown.speed_deviation < 1.05 * np.sqrt(memory.belief.speed_variance)
