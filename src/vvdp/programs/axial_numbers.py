"""How well an axial drive is controlled: errors of position and estimate, and whether the storage obeys passivity."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, DUTY_RATIO, EFFICIENCY, ENERGY, LENGTH, NUMBER, TIME
from vvdp.base.select import maximum
from vvdp.control.backstepping import backstepping_law
from vvdp.control.chamber import (
    ChamberDrive,
    ChamberReading,
    chamber_volume,
    desired_pressure,
    desired_rate_sensitivities,
    volume_compliance,
)
from vvdp.control.orifice import valve_flow
from vvdp.control.passivity import PassivityGains, exact_feedforward, passivity_law, pressure_error_gain
from vvdp.control.storage import StorageBalance, pressure_balance, storage_excess
from vvdp.control.tuning import held_sampling_limits, sampling_limits, sampling_warning
from vvdp.programs.axial_stages import SETTLED
from vvdp.programs.report import Quantities

EXPLAINED = 3.0
"""So many of the deviations that an observer states explain a flow that is off."""
MOTION: Quantities = MappingProxyType(
    {
        "control_begin_s": (TIME, "start of control"),
        "duty_error_rms": (DUTY_RATIO, "duty ratio: error against the reference"),
        "spool_position_error_rms_m": (LENGTH, "spool position: error against the reference"),
        "spool_position_error_max_m": (LENGTH, "spool position: largest error"),
        "spool_estimate_error_rms_m": (LENGTH, "spool position: error of the estimate"),
        "spool_estimate_deviation_rms_m": (LENGTH, "spool position: stated standard deviation"),
        "spool_estimate_coverage": (EFFICIENCY, "spool position: errors within ±2σ"),
        "pollution_rms_m": (LENGTH, "periodic sensor error of the axial sensor"),
        "real_time_factor": (NUMBER, "simulated over computing time"),
    }
)
"""Numbers of any controlled drive."""
CHAMBER: Quantities = MappingProxyType(
    {
        **MOTION,
        "observability_margin_lowest": (NUMBER, "observability margin, lowest"),
        "storage_rises": (COUNT, "samples in which the storage rose beyond its supply"),
        "storage_rise_largest_J": (ENERGY, "largest such rise"),
        "storage_rise_time_s": (TIME, "time of the largest rise, or of the closest to one"),
        "storage_largest_J": (ENERGY, "storage of the chamber, largest"),
    }
)
"""Numbers of a controlled chamber drive."""


class ExactLaw(Protocol):
    """A law with the drive as it believes it; `gains` are those of passivity or of backstepping."""

    @property
    def drive(self) -> ChamberDrive: ...
    @property
    def gains(self) -> Any: ...


class Controlled(NamedTuple):
    """What a run of a controlled drive has recorded, while it was controlled: true motion and chamber pressure, and the
    program's commands and reference, each of shape (rows,)."""

    times: Array
    true: Any
    shown: Any
    reference: Any

    def rows(self, chosen: Any) -> "Controlled":
        """The same with some of the rows; `chosen` are flags or places."""

        def of(record: Any) -> Any:
            return type(record)(**{name: column[chosen] for name, column in record._asdict().items()})

        return Controlled(self.times[chosen], of(self.true), of(self.shown), of(self.reference))


class Moved(NamedTuple):
    """How a spool moved while it was controlled, at its samples: time [s], true position and reference [m], and what
    an observer believed [m]; NaN where there is none. Each (rows,)."""

    times: Array
    true: Array
    reference: Array
    position: Array
    deviation: Array
    pollution: Array


def motion_numbers(moved: Moved, helix_length: float) -> dict[str, float]:
    """How well a spool was held, from `SETTLED` after the start of control on; empty where it was not that long.

    helix_length  duty ratio 0 to 1 [m]; NaN: not known
    """
    if moved.times.size < 2 or moved.times[-1] - moved.times[0] < SETTLED:
        return {}
    is_late = moved.times >= moved.times[0] + SETTLED
    late = Moved(**{name: column[is_late] for name, column in moved._asdict().items()})
    tracking, estimation = late.true - late.reference, late.position - late.true

    def rms(values: Array) -> float:
        return float(np.sqrt(np.mean(values**2)))

    found = {
        "control_begin_s": float(moved.times[0]),
        "duty_error_rms": rms(tracking) / helix_length,
        "spool_position_error_rms_m": rms(tracking),
        "spool_position_error_max_m": float(np.max(np.abs(tracking))),
        "spool_estimate_error_rms_m": rms(estimation),
        "pollution_rms_m": rms(late.pollution),
        "spool_estimate_deviation_rms_m": rms(late.deviation),
    }
    if np.all(np.isfinite(late.deviation)):
        found["spool_estimate_coverage"] = float(np.mean(np.abs(estimation) <= 2.0 * late.deviation))
    return {key: value for key, value in found.items() if np.isfinite(value)}


def storage_numbers(found: Controlled, law: ExactLaw, period: float) -> dict[str, float]:
    """How often W_P of the true states rose, from sample to sample, beyond what is allowed.

    Empty where rows are not one sample apart.

    Allowed is what the spool gave, eq. 5.27: W_P' <= -(P - P_d) A e_v; and what the exact law does not answer for: that
    the flow is held over a sample, and that its estimate is off, by up to `EXPLAINED` of the deviations it states.

    period  of the samples [s]

    Source  ours, docs/models/axial-control.md
    """
    drive = law.drive
    if np.any(np.abs(np.diff(found.times) - period) > 1e-6 * period):
        return {}
    desired = desired_pressure(found.reference, found.true, law.gains, drive)
    flow = valve_flow(found.shown.drive, found.true.pressure, drive.valve)
    stored: Any = pressure_balance(flow, desired, found.true, drive).storage
    error = found.true.pressure - desired.pressure
    given: Any = -error * drive.area * desired.velocity_error
    effort: Any = np.abs(error + stored / chamber_volume(found.true.position, drive))
    held = np.abs(np.diff(exact_feedforward(desired, found.true, drive)))
    doubt = EXPLAINED * flow_deviation(found, law)[:-1]
    before, after = StorageBalance(stored[:-1], given[:-1]), StorageBalance(stored[1:], given[1:])
    excess: Any = storage_excess(before, after, period)
    excess = excess - period * maximum(effort[:-1], effort[1:]) * (held + doubt)
    late = found.times[1:] >= found.times[0] + SETTLED
    worst = int(np.argmax(excess[late]))
    return {
        "storage_rises": float(np.count_nonzero(excess[late] > 0.0)),
        "storage_rise_largest_J": float(max(excess[late][worst], 0.0)),
        "storage_rise_time_s": float(found.times[1:][late][worst]),
        "storage_largest_J": float(np.max(stored[1:][late])),
    }


def flow_deviation(found: Controlled, law: ExactLaw) -> Array:
    """How far the flow that the law asks for may be off [m^3/s], by the observer's stated standard deviations; shape
    (rows,).
    """
    gains, true, shown = law.gains, found.true, found.shown
    flow_of: Any = passivity_law if isinstance(gains, PassivityGains) else backstepping_law

    def law_flow(reading: ChamberReading) -> Array:
        flow: Array = flow_of(found.reference, reading, gains, law.drive).flow
        return flow

    right = law_flow(true)
    by_position = law_flow(true._replace(position=true.position + shown.position_deviation)) - right
    by_velocity = law_flow(true._replace(velocity=true.velocity + shown.velocity_deviation)) - right
    return np.hypot(by_position, by_velocity)


def control_merits(found: Mapping[str, float | bool]) -> Iterator[str]:
    """That the storage never rose, where that is so."""
    if found.get("storage_rises") == 0.0:
        yield (
            "what the chamber stores against its desired pressure never rose beyond what the spool gave it: at every "
            "sample the control was passive"
        )


def control_warnings(law: ExactLaw, position: float, period: float, found: Mapping[str, float | bool]) -> Iterator[str]:
    """What limits the control, a sentence each: a pressure loop too fast for its samples where the oil is stiffest, at
    the highest `position` [m] that is asked for; and a storage that rose. `period` of the samples [s]."""
    gains, drive = law.gains, law.drive
    pressure = drive.oil.reference_pressure + (drive.preload + drive.stiffness * position) / drive.area
    compliance = volume_compliance(position, pressure, drive)
    is_passive = isinstance(gains, PassivityGains)
    gain = gains.flow_gain
    if is_passive:  # the exact feedforward adds what the errors add to the rate of the desired pressure
        damping = -desired_rate_sensitivities(gains, drive).pressure
        gain = pressure_error_gain(position, pressure, gains, drive) + damping * compliance
    limits = sampling_limits(gain, compliance)
    if is_passive and gains.flow_hold > 0.0:
        limits = held_sampling_limits(compliance, gains, drive)
    if warning := sampling_warning(limits, period):
        yield warning
    if rises := found.get("storage_rises"):
        yield (
            f"what the chamber stores rose beyond what the spool gave it in {rises:.0f} samples, most by "
            f"{found['storage_rise_largest_J']:.2g} J at {found['storage_rise_time_s']:.4g} s: it is not passive"
        )
