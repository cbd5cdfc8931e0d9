"""Steps of displacement control give the same numbers in plain Python and compiled."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from tests.compiled import compiled
from tests.displacement_case import numbers, random_sample, settings_of_chapter_6

from vvdp.base.conservation import NOTHING
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import SupplyLine
from vvdp.control.displacement import (
    SupplySupport,
    displacement_start,
    displacement_step,
    idle_demand,
    printed_displacement_step,
)
from vvdp.estimation.load_observer import LoadObserver, load_observer_start, load_observer_step
from vvdp.estimation.period_average import average_start, average_step, pwm_window
from vvdp.simulation.replay import Replay


@pytest.mark.parametrize("step", [displacement_step, printed_displacement_step])
def test_displacement_step_compiles(step):
    """With everything on, memories carried along."""
    plain = settings_of_chapter_6()
    line = SupplyLine(oil_volume=4e-4, hose_compliance=0.0, gas_volume=5e-5, precharge_pressure=5e5, gas_exponent=1.3)
    settings = settings_of_chapter_6(
        cylinder=replace(plain.cylinder, line=line),
        split=replace(plain.split, feeds_forward=1.0),
        support=SupplySupport(support_conductance=1.67e-10, support_pressure=1.6e6),
        adaptation=Adaptation(load_gain=4e4, mass_gain=2e4, compliance_gain=1e-19, pause=2e-3),
    )
    rng = np.random.default_rng(1)
    memory = mirrored = displacement_start(settings)
    fast = compiled(step, memory, *random_sample(rng), settings)
    for _ in range(100):
        seen, reference = random_sample(rng)
        memory, demand = step(memory, seen, reference, settings)
        mirrored, mirrored_demand = fast(mirrored, seen, reference, settings)
        assert numbers((mirrored, mirrored_demand)) == pytest.approx(numbers((memory, demand)), rel=1e-9, abs=1e-12)


def test_start_and_idle_demand_compile():
    settings = settings_of_chapter_6()
    start = numbers(displacement_start(settings))
    assert numbers(compiled(displacement_start, settings)(settings)) == pytest.approx(start)
    assert numbers(compiled(idle_demand)()) == numbers(idle_demand()) == [0.0] * 12


def test_observer_and_means_compile():
    settings = LoadObserver(
        moving_mass=100.0, viscous_friction=2000.0, observer_rate=80.0, load_rate=15.0, sample_period=1e-3
    )
    memory = load_observer_start(0.1, -1000.0)
    found = compiled(load_observer_step, memory, 0.101, 900.0, settings)(memory, 0.101, 900.0, settings)
    assert numbers(found) == pytest.approx(numbers(load_observer_step(memory, 0.101, 900.0, settings)), rel=1e-12)

    turning = 130.0, 3.0, 1e-3
    assert compiled(pwm_window, *turning)(*turning) == pytest.approx(pwm_window(*turning), rel=1e-15)


class Values(NamedTuple):
    values: np.ndarray
    speed: float


class Means(NamedTuple):
    first: float
    second: float
    third: float


def averaged(memory, now, settings):
    memory, means = average_step(memory, now.values, pwm_window(now.speed, 3.0, 1e-3))
    return memory, Means(means[0], means[1], means[2])


def test_means_compile():
    rng, plain, start = np.random.default_rng(2), average_start(3), average_start(3)
    rows = np.column_stack([rng.uniform(0.0, 1.0, (100, 3)), rng.uniform(50.0, 200.0, 100)])
    found = Replay(averaged, start, Values(rows[0, :3], 0.0), NOTHING)(start, rows)
    for row, means in zip(rows, found.shown, strict=True):
        plain, expected = averaged(plain, Values(row[:3], row[3]), NOTHING)
        assert np.allclose(means, expected, rtol=1e-13)
    assert np.array_equal(plain.samples, found.memory.samples)
