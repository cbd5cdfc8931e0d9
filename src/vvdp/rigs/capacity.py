"""Derived capacity of the pump at a setting: its flow per angle, extrapolated to no pressure difference.

Based on ISO 8426: several pressure differences at one speed, a straight line through the flows, and where it begins.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.simulation.link import quiet
from vvdp.steady.averages import averages
from vvdp.steady.test_stand import SetPoint, Stand

PRESSURES = 5
HIGHEST = 1.0 / 6.0
"""Pressure differences of a capacity, evenly spaced up to this share of the relief setting over the tank: the flow is
a straight line over them within half a thousandth of its beginning, but for duty ratios that hardly deliver."""


def capacity_pressures(stand: Stand) -> Array:
    """Load pressures at which the flows of a capacity are taken, absolute [Pa]."""
    rise = stand.relief_pressure - stand.tank_pressure
    return stand.tank_pressure + HIGHEST * rise * np.arange(1.0, PRESSURES + 1.0) / PRESSURES


def capacity_points(
    stand: Stand, duty_ratios: Sequence[float], pump_speeds: Sequence[float], temperatures: Sequence[float]
) -> list[SetPoint]:
    """Operating points of all settings, the pressure fastest, then duty ratio, speed [rad/s] and temperature [K]."""
    pressures = capacity_pressures(stand).tolist()
    return [SetPoint(d, p, n, t) for t in temperatures for n in pump_speeds for d in duty_ratios for p in pressures]


def derived_capacities(stand: Stand, points: Sequence[SetPoint], flows: Array) -> Array:
    """Capacity of each setting of `capacity_points` [m^3/rad]; nan where a flow is missing or nothing is left over.

    flows  delivered at the points, in volumes at the tank's pressure [m^3/s]

    Source  ours, docs/rigs.md, based on iso8426
    """
    speeds = np.array([point.pump_speed for point in points[::PRESSURES]])
    found = zero_pressure_flow(flows.reshape(-1, PRESSURES), capacity_pressures(stand) - stand.tank_pressure) / speeds
    with np.errstate(invalid="ignore"):
        return np.where(found > 0.0, found, np.nan)


def zero_pressure_flow(flows: Array, differences: Array) -> Array:
    """Where the straight lines that come closest to the flows begin, at no pressure difference [m^3/s].

    flows        shape (..., differences) [m^3/s]
    differences  of pressure [Pa]
    """
    apart = differences - differences.mean()
    mean = flows.mean(axis=-1)
    slope = (flows - mean[..., np.newaxis]) @ apart / (apart @ apart)
    beginning: Array = mean - slope * differences.mean()
    return beginning


def averaged_flows(
    stand: Stand,
    points: Sequence[SetPoint],
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Array:
    """Delivered flow at each point as quasi-steady averages give it, leakage taken off [m^3/s].

    Source  ours, docs/models/rotary-valve.md
    """
    each: Any = np.array(points, float).T
    columns: Any = SetPoint(*each)
    rows = np.column_stack(np.broadcast_arrays(*stand.cycle_point(columns)))
    means = averages(rows, stand.bench.valve, cores=cores, say=say)
    return np.asarray(means.load_flow - stand.leakage(columns), float)
