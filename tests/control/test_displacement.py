"""The composed step: which pressures act where, support, learning, memory from sample to sample."""

from dataclasses import replace

import numpy as np
import pytest
from tests.displacement_case import ATMOSPHERE, BAR, LPM, random_sample, settings_of_chapter_6

from vvdp.base.errors import ParameterError
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import CircuitPressures, capacities, return_flow, sides
from vvdp.control.displacement import (
    CylinderSeen,
    SupplySupport,
    displacement_start,
    displacement_step,
    printed_displacement_step,
)
from vvdp.control.flow_split import SplitMemory
from vvdp.control.reference import Reference

SETTINGS = settings_of_chapter_6()


def sight(pressure_a, pressure_b, line=ATMOSPHERE, **changes):
    """The cylinder on its way out, at pressures [bar, gauge]."""
    P = CircuitPressures(pressure_a * BAR + ATMOSPHERE, pressure_b * BAR + ATMOSPHERE, line)
    seen = CylinderSeen(position=0.15, velocity=0.05, load_force=-1000.0, fast=P, slow=P, delivered_flow=6.0 * LPM)
    return seen._replace(**changes)


ON_ITS_WAY = displacement_start(SETTINGS)._replace(split=SplitMemory(5.0 * LPM, 0.1))
"""The memory of a split that has settled about."""
MOVING = Reference(0.1502, 0.05, 0.0, 0.0)


def test_effort_is_given_by_what_is_delivered():
    """H Q + G Psi u = U* with the delivered flow wherever the opening is within its limits, random states."""
    rng, given, memory = np.random.default_rng(6), 0, displacement_start(SETTINGS)
    for _ in range(500):
        seen, reference = random_sample(rng)
        _, demand = displacement_step(memory, seen, reference, SETTINGS)
        if demand.saturated or demand.mode != 1.0:
            continue
        found = capacities(demand.direction, seen.position, ATMOSPHERE, SETTINGS.cylinder)
        at = sides(demand.direction, seen.slow, SETTINGS.cylinder)
        out = demand.opening * return_flow(at.return_pressure, 1e-5, SETTINGS.cylinder)
        total = found.supply_gain * seen.delivered_flow + found.return_gain * out
        assert total == pytest.approx(demand.effort, rel=1e-9)
        given += 1
    assert given > 20


def test_direction_and_effort_agree_at_the_start_and_demands_are_possible():
    rng, memory = np.random.default_rng(7), displacement_start(SETTINGS)
    for step in (displacement_step, printed_displacement_step):
        for _ in range(300):
            seen, reference = random_sample(rng)
            _, demand = step(memory, seen, reference, SETTINGS)
            assert demand.direction == np.sign(demand.effort)
            assert 0.0 <= demand.opening <= 1.0
            assert 0.0 <= demand.flow <= SETTINGS.split.largest_flow
            assert demand.saturated == float(demand.opening in (0.0, 1.0))


def test_raw_pressures_act_in_the_force_and_averaged_ones_in_the_rest():
    memory, seen = ON_ITS_WAY, sight(16.0, 20.0)
    rippled = seen._replace(fast=seen.fast._replace(pressure_a=16.2 * BAR + ATMOSPHERE))
    averaged = seen._replace(slow=seen.slow._replace(pressure_b=22.0 * BAR + ATMOSPHERE))
    base = displacement_step(memory, seen, MOVING, SETTINGS)[1]
    ripple = displacement_step(memory, rippled, MOVING, SETTINGS)[1]
    assert ripple.force_error - base.force_error == pytest.approx(0.2 * BAR * SETTINGS.cylinder.area_a, rel=1e-9)
    slow = displacement_step(memory, averaged, MOVING, SETTINGS)[1]
    assert (slow.force_error, slow.effort) == (base.force_error, base.effort)
    assert slow.opening != base.opening


def test_support_adds_flow_only_below_its_pressure():
    """1 lpm/bar below 15 bar gauge: 1 bar short gives 1 lpm on top of the split."""
    supported = replace(
        SETTINGS, support=SupplySupport(support_conductance=LPM / BAR, support_pressure=15.0 * BAR + ATMOSPHERE)
    )
    memory = ON_ITS_WAY
    for line, more in ((14.0, 1.0), (15.0, 0.0), (20.0, 0.0)):
        seen = sight(16.0, 20.0, line * BAR + ATMOSPHERE)
        plain, with_it = (displacement_step(memory, seen, MOVING, s)[1] for s in (SETTINGS, supported))
        assert with_it.split_flow == plain.split_flow
        assert with_it.flow - plain.flow == pytest.approx(more * LPM, abs=1e-12)


def test_feedforward_is_what_the_reference_needs():
    """Extending at 5 cm/s: 20.26e-4 0.05; with a split that hardly sees the effort the flow settles there."""
    split = replace(SETTINGS.split, feeds_forward=1.0, flow_deviation=1e-9)
    settings, memory = replace(SETTINGS, split=split, sample_period=10.0), displacement_start(SETTINGS)
    _, demand = displacement_step(memory, sight(16.0, 20.0), MOVING, settings)
    assert demand.direction == 1.0
    assert demand.split_flow == pytest.approx(20.26e-4 * 0.05, rel=1e-4)
    _, back = displacement_step(memory, sight(40.0, 5.0), Reference(0.14, -0.05, 0.0, 0.0), settings)
    assert back.direction == -1.0
    assert back.split_flow == pytest.approx(10.77e-4 * 0.05, rel=1e-4)


def test_learning_pauses_at_an_end_and_after_a_switch():
    settings = replace(SETTINGS, adaptation=Adaptation(load_gain=4e4, pause=2.5e-3))
    memory = displacement_start(settings)
    free, demand = displacement_step(memory, sight(16.0, 20.0), MOVING._replace(velocity=0.0505), settings)
    assert demand.saturated == 0.0
    assert free.adaptation.load_correction == pytest.approx(4e4 * 1e-3 * (-0.0005 - 10.0 * 0.0002))
    at_end, _ = displacement_step(memory._replace(saturated=1.0), sight(16.0, 20.0), MOVING, settings)
    assert at_end.adaptation == memory.adaptation
    switched = memory._replace(direction=memory.direction._replace(direction=1.0, held_for=1e-3))
    for learns in (False, True):
        after, _ = displacement_step(switched, sight(16.0, 20.0), MOVING, settings)
        assert (after.adaptation != switched.adaptation) == learns
        switched = after


def test_a_step_leaves_its_memory_alone_and_repeats_itself():
    memory, seen = displacement_start(SETTINGS), sight(16.0, 20.0)
    one, other = (displacement_step(memory, seen, MOVING, SETTINGS) for _ in range(2))
    assert one == other
    assert memory == displacement_start(SETTINGS)


def test_a_sample_period_of_zero_is_refused():
    with pytest.raises(ParameterError, match="sample_period"):
        replace(SETTINGS, sample_period=0.0)
