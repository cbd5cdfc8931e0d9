"""The VVDP as an electrically controlled pump, based on ISO 17559 and ISO 4409: steady and dynamic."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import CONDUCTANCE, DUTY_RATIO, EFFICIENCY, FLOW, PRESSURE_DIFFERENCE
from vvdp.results.result import Finding, Result, numbers_of
from vvdp.rigs.map_axes import Axes, default_axes
from vvdp.rigs.map_result import map_result
from vvdp.rigs.maps import PumpMap, simulated_map
from vvdp.rigs.step import STEPS, checked_steps, dynamics
from vvdp.simulation.link import quiet
from vvdp.steady.test_stand import Stand
from vvdp.studies.engine import ThisProcess
from vvdp.studies.run import silent

DUTY_RATIOS = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
PRESSURES = 4
SPAN = 10e5
"""Of load pressure, over which the loss of flow is stated [Pa]."""
SPEED_SHARES = (0.6, 1.0)
"""Pump speeds, over that of the system."""
LOWEST_SHARE, STRAIGHT = 0.01, (0.3, 0.95)
"""Share of the largest flow that ends the dead band, and the duty ratios between which the flow should be a line."""
QUANTITIES = {
    "dead_band_duty_ratio": (DUTY_RATIO, "duty ratio up to which hardly any flow is delivered"),
    "flow_gain_lowest_m3_s": (FLOW, "smallest slope of the flow over the duty ratio, at constant load pressure"),
    "flow_gain_highest_m3_s": (FLOW, "largest slope of the flow over the duty ratio, at constant load pressure"),
    "linearity_error": (EFFICIENCY, "largest distance from a straight line, over the span"),
    "flow_loss_per_pressure_m3_s_Pa": (CONDUCTANCE, "what the load pressure takes off the flow, at most"),
}


def pump_axes(stand: Stand) -> Axes:
    """Duty ratios closer together where the flow begins, four load pressures, two pump speeds, one temperature."""
    axes = replace(default_axes(stand), duty_ratios=DUTY_RATIOS)
    rise = stand.relief_pressure - stand.tank_pressure
    pressures = tuple(float(stand.tank_pressure + share * rise) for share in np.linspace(0.2, 0.8, PRESSURES))
    speeds = tuple(float(share * stand.set_point.pump_speed) for share in SPEED_SHARES)
    return replace(axes, pump_speeds=speeds, load_pressures=pressures)


@dataclass(frozen=True)
class PumpTest:
    """What a test of a pump covers: the points of its steady maps, and the duty ratios between which it steps.

    Raises ParameterError where there is no such step.
    """

    axes: Axes
    steps: tuple[float, float] = STEPS

    def __post_init__(self) -> None:
        checked_steps(self.steps)


def pump(
    stand: Stand,
    directory: Path,
    test: PumpTest,
    *,
    cores: int | None = None,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
) -> Result:
    """Steady maps over duty ratio and load pressure (pump speed, temperature), then step and frequency response.

    Finished points of the maps are kept in `directory`; where the maps were interrupted the dynamics are left for the
    next time. Raises ConfigError where the directory cannot be used.

    Source  ours, docs/rigs.md, based on iso17559 and iso4409
    """
    began = time.perf_counter()
    steady = simulated_map(stand, test.axes, directory, engine=ThisProcess(cores), progress=progress, say=say)
    found = map_result(steady, "steady")
    numbers = control_numbers(steady)
    result = replace(
        found,
        verb="rig pump",
        title="The VVDP as an electrically controlled pump",
        numbers={**found.numbers, **numbers_of(numbers, QUANTITIES)},
        findings=(*found.findings, *_findings(numbers)),
    )
    if not steady.is_finished:
        return replace(result, seconds=time.perf_counter() - began)
    moving = dynamics(stand, test.steps, cores=cores, say=say)
    return replace(
        result,
        manner=f"{found.manner} {moving.manner}",
        conditions={**found.conditions, "step": moving.conditions["duty ratio"]},
        left_out=(*found.left_out, *moving.left_out[1:]),
        tables={**result.tables, **moving.tables},
        charts={**result.charts, **moving.charts},
        numbers={**result.numbers, **moving.numbers},
        findings=(*result.findings, *moving.findings),
        seconds=time.perf_counter() - began,
    )


def dead_band(duty_ratios: Array, flow: Array, share: float = LOWEST_SHARE) -> float:
    """Duty ratio at which the flow reaches a share of its largest, by straight lines between points [1].

    nan where it never does, or is there from the first point on.
    """
    level = share * np.nanmax(flow)
    there = np.flatnonzero(flow >= level)
    if not there.size or there[0] == 0:
        return np.nan
    k = int(there[0])
    return float(np.interp(level, flow[k - 1 : k + 1], duty_ratios[k - 1 : k + 1]))


def linearity(duty_ratios: Array, flow: Array) -> tuple[float, float]:
    """Gain [m^3/s per unit] of the straight line that comes closest, and the largest residual over its span."""
    gain, offset = np.polyfit(duty_ratios, flow, 1)
    apart = np.max(np.abs(flow - gain * duty_ratios - offset))
    return float(gain), float(apart / (np.ptp(flow) or np.nan))


def control_numbers(found: PumpMap) -> dict[str, float]:
    """Characteristics of a controlled pump for its user: dead band, gain, linearity, sensitivity to the load pressure.

    At the highest pump speed and the first temperature; dead band and linearity are the worst of all pressures.
    """
    duty = np.array(found.axes.duty_ratios)
    delivered = found.grid("delivered_flow_m3_s")[0, -1]
    numbers: dict[str, float] = {}
    bands, gains, bends = [], [], []
    straight = (duty >= STRAIGHT[0]) & (duty <= STRAIGHT[1])
    for flow in delivered:
        known = np.isfinite(flow)
        if known.any():
            bands.append(dead_band(duty, np.nan_to_num(flow)))
        if np.count_nonzero(known & straight) >= 3:
            gain, bend = linearity(duty[known & straight], flow[known & straight])
            gains.append(gain)
            bends.append(bend)
    if np.isfinite(bands).any():
        numbers["dead_band_duty_ratio"] = float(np.nanmax(bands))
    if gains:
        numbers["flow_gain_lowest_m3_s"] = min(gains)
        numbers["flow_gain_highest_m3_s"] = max(gains)
        numbers["linearity_error"] = max(bends)
    if len(found.axes.load_pressures) > 1:
        drop = delivered[0] - delivered[-1]
        if np.isfinite(drop).any():
            span = found.axes.load_pressures[-1] - found.axes.load_pressures[0]
            numbers["flow_loss_per_pressure_m3_s_Pa"] = float(np.nanmax(drop) / span)
    return numbers


def _findings(n: Mapping[str, float]) -> Iterator[Finding]:
    if "dead_band_duty_ratio" in n:
        yield Finding(
            text=f"Up to a duty ratio of {number(n['dead_band_duty_ratio'], 3)} less than {percent(LOWEST_SHARE, 0)} "
            "of the largest flow is delivered."
        )
    if "linearity_error" in n:
        low, high = (with_unit(n[f"flow_gain_{end}_m3_s"], FLOW) for end in ("lowest", "highest"))
        yield Finding(
            text=f"Between duty ratios of {STRAIGHT[0]:g} and {STRAIGHT[1]:g} the flow lies within "
            f"{percent(n['linearity_error'])} of a straight line; at a constant load pressure its gain is {low} to "
            f"{high} per unit of duty ratio."
        )
    if "flow_loss_per_pressure_m3_s_Pa" in n:
        lost = with_unit(n["flow_loss_per_pressure_m3_s_Pa"] * SPAN, FLOW, 3)
        yield Finding(text=f"The load pressure takes at most {lost} per {with_unit(SPAN, PRESSURE_DIFFERENCE)}.")
