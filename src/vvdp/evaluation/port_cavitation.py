"""The lowest cavitation number at the ports of the rotary valve, from the extremes of a run."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vvdp.evaluation.bench_values import BenchValues
from vvdp.fluid.oil import density
from vvdp.valve.branch import branch_law, law_flow
from vvdp.valve.gap_flow import cavitation_number
from vvdp.valve.geometry import Openings, port_openings

ANGLES = 720
"""Angles of a PWM period at which the openings are looked at."""


def lowest_cavitation_number(
    bench: BenchValues, found: Mapping[str, float | bool], angles: tuple[float, float]
) -> float:
    """A lower bound of the cavitation number of the nozzles over a run [1]; nan where no port is open.

    It belongs to the highest inlet pressure, the lowest pressure behind the port, and the smallest opening: a port that
    closes takes the whole drop with its nozzles just before, however little flows.

    found   the numbers of the run
    angles  the least and the greatest angle of the spool [rad]
    """
    highest = float(found["pressure_max_inlet_Pa"]) + bench.reference
    smallest = smallest_openings(bench, angles)
    rho = density(bench.temperature, bench.oil)
    law = branch_law(rho, bench.valve, bench.oil.vapour_pressure)
    numbers = []
    for opening, node in ((smallest.load, "load_line"), (smallest.tank, "tank")):
        lowest = float(found[f"pressure_min_{node}_Pa"]) + bench.reference
        if np.isfinite(opening) and highest > lowest:
            share = float(law_flow(highest - lowest, opening, law).nozzle_share) if opening > 0.0 else 1.0
            behind = highest - share * (highest - lowest)
            numbers.append(cavitation_number(highest, behind, bench.cavitation_pressure))
    return float(min(numbers, default=np.nan))


def smallest_openings(bench: BenchValues, angles: tuple[float, float]) -> Openings:
    """The smallest openings of both ports while the spool turns between two `angles` [rad]; 0 for one that closes.

    One that never opens has nan.
    """
    period = 2.0 * np.pi / bench.valve.sections
    begin, end = angles[0], min(angles[1], angles[0] + period)
    turn = np.linspace(begin, end, ANGLES + 1)
    position = np.array(bench.axial_position.extremes)[:, np.newaxis]
    found: Any = port_openings(turn, position, bench.valve)  # type: ignore[arg-type]  # on arrays too
    return Openings(*(float(np.min(port)) if np.max(port) > 0.0 else float("nan") for port in found))
