"""Report of an event filter: errors of its estimate of a shaft, and sentences on them."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import ANGLE, COUNT, DURATION, EFFICIENCY, NUMBER, SPEED, Kind
from vvdp.estimation.event_settings import EventFilter
from vvdp.network.network import Network, ProgramPart
from vvdp.numerics.kalman import chance_band
from vvdp.programs.report import ProgramReport, origin
from vvdp.valve.rotary import RotaryValve

if TYPE_CHECKING:
    from vvdp.simulation.run import Run

SETTLED = 0.5
"""Time of a run from which on the errors of the estimate are counted [s]: the filter has found speed and index."""
STATED = 2.0
"""Within so many stated standard deviations 95 % of the errors lie if they are Gaussian and the deviations true."""
COVERAGE = (0.90, 0.99)
"""Range of the share of the errors within ±2σ if the stated standard deviation is right."""
MODEST = 2.0
"""Stated standard deviation over the errors from which on, beyond chance, an estimate is far less sure than it may
be.
"""
UNITS: Mapping[str, tuple[Kind, str]] = {"angle": (ANGLE, "rad"), "speed": (SPEED, "rad_s")}


class ShaftWatch(NamedTuple):
    """An event filter that watches a shaft through an encoder: names of filter, encoder and shaft, and the angle over
    which the estimated speed is a mean, 0 where it is that of the instant [rad]."""

    filter: str
    encoder: str
    shaft: str
    pitch: float


def watch_of(network: Network, name: str) -> ShaftWatch | None:
    """The shaft that an event filter watches; None if its wheel has no index, or if it reads no encoder on a shaft.

    Without ripples in a turn of a rotary valve's spool, it estimates the mean speed over a PWM period.
    """
    program = network.programs[name]
    encoder, _ = origin(network, program.reads.get("edges"))
    shaft, _, word = str(encoder.reads.get("angle")).rpartition(".") if encoder else ("", "", "")
    if not isinstance(program.settings, EventFilter) or not program.settings.wheel.has_index:
        return None
    if encoder is None or word != "angle" or shaft not in network.nodes:
        return None
    valves = [each for part in network.parts.values() if shaft in part.nodes.values() for each in part.values]
    sections = [each.sections for each in valves if isinstance(each, RotaryValve)]
    pitch = 2.0 * np.pi / sections[0] if sections and program.settings.ripple_order == 0.0 else 0.0
    return ShaftWatch(name, encoder.name, shaft, pitch)


def shaft_watch(network: Network, shaft: str) -> ShaftWatch | None:
    """The first event filter that watches a shaft; None where there is none."""
    found = (watch_of(network, name) for name in network.programs)
    return next((each for each in found if each is not None and each.shaft == shaft), None)


class EstimateErrors(NamedTuple):
    """Errors of the estimates shown at the recorded times, at their samples: angle within half a revolution [rad],
    speed [rad/s]; `true_speed` is the speed with which the estimate is compared [rad/s]."""

    angle: Array
    speed: Array
    true_speed: Array


def estimate_errors(estimate: Mapping[str, Array], sampled: Mapping[str, Array], pitch: float) -> EstimateErrors:
    """Errors of the estimates of a watched shaft.

    The wheel cannot show which way it turns: they are against the angle turned through and the magnitude of the speed.

    estimate  columns of `Estimate` over the recorded rows
    sampled   the shaft's `angle` [rad] and `speed` [rad/s] at the last sample and its `time` [s], over the same rows
    pitch     angle over which the estimated speed is a mean, 0 where it is that of the instant [rad]
    """
    angle = sampled["angle"]
    turned = angle[0] + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    error = estimate["angle"] - turned
    speed = mean_speed(sampled["time"], turned, pitch) if pitch > 0.0 else np.abs(sampled["speed"])
    return EstimateErrors(np.pi - np.mod(np.pi - error, 2.0 * np.pi), estimate["speed"] - speed, speed)


def mean_speed(times: Array, angle: Array, pitch: float) -> Array:
    """Mean speed over the `pitch` [rad] around each angle, at the ends over the first and the last [rad/s].

    times, angle  the angle never falls [s, rad]
    """
    if angle[-1] - angle[0] < pitch:
        return np.full(angle.shape, (angle[-1] - angle[0]) / max(times[-1] - times[0], np.finfo(float).tiny))
    centre = np.clip(angle, angle[0] + 0.5 * pitch, angle[-1] - 0.5 * pitch)
    begin, end = (np.interp(centre + half, angle, times) for half in (-0.5 * pitch, 0.5 * pitch))
    return np.asarray(pitch / (end - begin), float)


def estimate_numbers(
    times: Array, estimate: Mapping[str, Array], sampled: Mapping[str, Array], watch: ShaftWatch
) -> dict[str, float]:
    """Results of the estimate of a run, from `SETTLED` on; empty for a shorter run.

    Means over time are by the trapezoidal rule over the recorded rows. Errors in a row with one sign count as one.
    Arguments as those of `estimate_errors`, and `times` [s] of the rows.
    """
    shaft = watch.shaft
    late = times >= SETTLED
    if np.count_nonzero(late) < 2:
        return {}
    t = times[late]

    def mean(values: Array) -> float:
        return float(np.trapezoid(values, t) / (t[-1] - t[0]))

    found: dict[str, float] = {}
    errors = estimate_errors(estimate, sampled, watch.pitch)
    for name, error in (("angle", errors.angle[late]), ("speed", errors.speed[late])):
        unit, deviation = UNITS[name][1], estimate[f"{name}_deviation"][late]
        squared = (error / deviation) ** 2
        found |= {
            f"{shaft}_{name}_error_rms_{unit}": mean(error**2) ** 0.5,
            f"{shaft}_{name}_deviation_rms_{unit}": mean(deviation**2) ** 0.5,
            f"{shaft}_{name}_coverage": mean(np.asarray(squared <= STATED**2, float)),
            f"{shaft}_{name}_nees": mean(squared),
            f"{shaft}_{name}_errors": float(1 + np.count_nonzero(np.diff(np.signbit(error)))),
        }
    stands = np.trapezoid(np.asarray(estimate["standstill"] > 0.5, float), times)
    return found | {f"{shaft}_missed_edges": float(estimate["missed_edges"][-1]), "standstill_time_s": float(stands)}


def estimate_quantities(watch: ShaftWatch) -> dict[str, tuple[Kind, str]]:
    """Kind and label of the keys of `estimate_numbers`."""
    shaft, found = watch.shaft, dict[str, tuple[Kind, str]]()
    for name, words in (("angle", "estimated angle"), ("speed", f"estimated speed{of_what(watch.pitch)}")):
        kind, unit = UNITS[name]
        found |= {
            f"{shaft}_{name}_error_rms_{unit}": (kind, f"{words}: error"),
            f"{shaft}_{name}_deviation_rms_{unit}": (kind, f"{words}: stated standard deviation"),
            f"{shaft}_{name}_coverage": (EFFICIENCY, f"{words}: errors within ±2σ"),
            f"{shaft}_{name}_nees": (NUMBER, f"{words}: squared errors over stated variance"),
            f"{shaft}_{name}_errors": (COUNT, f"{words}: independent errors"),
        }
    return found | {
        f"{shaft}_missed_edges": (COUNT, "edges that the encoder missed"),
        "standstill_time_s": (DURATION, f"time for which the {shaft.replace('_', ' ')} is estimated to stand"),
    }


def of_what(pitch: float) -> str:
    """Words to put behind an estimated speed: which speed is meant; `pitch` [rad] as that of `estimate_errors`."""
    return ", mean over a PWM period" if pitch > 0.0 else " of the instant"


def estimate_doubts(found: Mapping[str, float | bool], watch: ShaftWatch) -> Iterator[str]:
    """Warnings, a sentence each, if the stated standard deviation of a run is too small, or far too large, and not by
    chance.

    found  numbers of the run
    """
    shaft = watch.shaft
    for name, words in (("angle", "angle"), ("speed", f"speed{of_what(watch.pitch)}")):
        kind, unit = UNITS[name]
        share = found.get(f"{shaft}_{name}_coverage")
        if share is None or COVERAGE[0] <= share <= COVERAGE[1]:
            continue
        nees, (low, high) = found[f"{shaft}_{name}_nees"], chance_band(int(found[f"{shaft}_{name}_errors"]))
        if nees > high if share < COVERAGE[0] else MODEST**2 * nees < low:
            stated, true = (found[f"{shaft}_{name}_{which}_rms_{unit}"] for which in ("deviation", "error"))
            yield (
                f"the estimate of the {shaft.replace('_', ' ')} states {with_unit(stated, kind, 3)} ({words}) and errs "
                f"by {with_unit(true, kind, 3)}: {percent(share)} of the errors lie within two stated standard "
                "deviations, where "
                f"{percent(COVERAGE[0], 0)} to {percent(COVERAGE[1], 0)} should; see edge_variance, "
                f"acceleration_density and ripple_variance of {watch.filter}"
            )


def wheel_doubt(network: Network, program: ProgramPart) -> str:
    """A warning that an event filter takes the wheel of its encoder for another one; empty if it does not."""
    encoder, _ = origin(network, program.reads.get("edges"))
    assumed = getattr(program.settings, "wheel", None)
    wheel = getattr(getattr(encoder and encoder.settings, "encoder", None), "wheel", None)
    if encoder is None or wheel is None or assumed is None or np.array_equal(wheel.edges, assumed.edges):
        return ""
    first, second = len(assumed.edges), len(wheel.edges)
    shown = f"{first} sectors, {encoder.name} has {second}" if first != second else "other edges"
    return (
        f"{program.name} takes the code wheel of {encoder.name} for another one ({shown}), so that angle and speed are "
        "wrong; give both the same sectors and index_shift"
    )


class EstimateReport(ProgramReport):
    """Report of an event filter that knows the angle of a shaft: errors, stated standard deviation, coverage."""

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        self.watch, self.doubt = watch_of(network, name), wheel_doubt(network, self.program)
        if self.watch:
            self.GROUP = f"Estimate of the {self.watch.shaft.replace('_', ' ')}"
            self.QUANTITIES = estimate_quantities(self.watch)
            self.UNSHOWN = frozenset(key for key in self.QUANTITIES if key.endswith(("_nees", "_errors")))

    def numbers(self, run: "Run") -> dict[str, float]:
        """Errors and coverage of the estimate; empty for a short run."""
        if self.watch is None:
            return {}
        estimate, sampled = getattr(run.command, self.watch.filter), run.memory[self.watch.encoder]
        return estimate_numbers(run.times, estimate._asdict(), sampled._asdict(), self.watch)

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Another wheel than that of the encoder; a stated standard deviation that is too small, or far too large."""
        if self.doubt:
            yield self.doubt
        if self.watch:
            yield from estimate_doubts(found, self.watch)
