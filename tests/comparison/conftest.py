"""Two tiny estimators whose errors are known beforehand, and scenarios short enough for a test."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.kinds import Speed
from vvdp.base.params import Params
from vvdp.comparison.estimators import Contender
from vvdp.comparison.scenarios import scenarios
from vvdp.estimation.estimator import Estimate


class StillMemory(NamedTuple):
    start: float


class Still(Params):
    speed: Speed


def still_step(memory, reading, settings):
    """Believes in one speed whatever comes; the angle stays where it is."""
    estimate = Estimate(
        angle=memory.start,
        speed=settings.speed,
        angle_deviation=np.nan,
        speed_deviation=np.nan,
        innovation=0.1,
        innovation_deviation=0.1 if reading.edges > 0.0 else 0.0,
        missed_edges=0.0,
        standstill=np.nan,
    )
    return memory, estimate


def contender(name, speed):
    return Contender(name, f"always {speed:g} rad/s", still_step, StillMemory(0.0), Still(speed=speed))


@pytest.fixture
def known_contenders():
    """One that believes in 100 rad/s, one that believes in 150."""
    return [contender("slow", 100.0), contender("fast", 150.0)]


@pytest.fixture
def short_scenarios():
    """Constant speed and the step, each long enough to be scored."""
    by_name = {each.name: each for each in scenarios()}
    return [replace(by_name["constant"], until=1.0), replace(by_name["step"], until=1.5)]
