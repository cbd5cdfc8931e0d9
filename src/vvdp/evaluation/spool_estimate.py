"""How good the estimate of a watched spool is, and what a run says of it."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import ANGLE, COUNT, DURATION, EFFICIENCY, NUMBER, SPEED, Kind
from vvdp.estimation.event_settings import EventFilter
from vvdp.network.network import Network
from vvdp.numerics.kalman import chance_band
from vvdp.systems.extras import Line, Summary

SETTLED = 0.5
"""From this time of a run on the errors of the estimate are counted [s]: the filter has found speed and index."""
STATED = 2.0
"""Within so many stated standard deviations 95 % of the errors lie if they are Gaussian and the deviations true."""
COVERAGE = (0.90, 0.99)
"""Between these the share of the errors within so many deviations lies where the estimate knows how good it is."""
MODEST = 2.0
"""Stated standard deviation over the errors from which on, beyond chance, an estimate is far less sure than it may
be.
"""
UNITS: Mapping[str, tuple[Kind, str]] = {"angle": (ANGLE, "rad"), "speed": (SPEED, "rad_s")}


class SpoolWatch(NamedTuple):
    """An event filter that watches a spool through an encoder: the names of both programs, and the filter's values."""

    filter: str
    encoder: str
    settings: EventFilter


def spool_watch(network: Network, spool: str) -> SpoolWatch | None:
    """The first event filter that knows the angle of a shaft, as its wheel has an index; None where there is none."""
    for name, program in network.programs.items():
        source = program.reads.get("edges")
        encoder = source.partition(".")[0] if isinstance(source, str) else ""
        if (
            isinstance(program.settings, EventFilter)
            and program.settings.wheel.has_index
            and encoder in network.programs
            and network.programs[encoder].reads.get("angle") == f"{spool}.angle"
        ):
            return SpoolWatch(name, encoder, program.settings)
    return None


class EstimateErrors(NamedTuple):
    """Errors of the estimates shown at the recorded times, at their samples: angle within half a turn [rad], speed
    [rad/s]; `true_speed` is what the estimated one is held against [rad/s]."""

    angle: Array
    speed: Array
    true_speed: Array


def estimate_errors(estimate: Mapping[str, Array], sampled: Mapping[str, Array], pitch: float) -> EstimateErrors:
    """Errors of the estimates of a watched spool.

    The wheel cannot show which way it turns: they are against the angle turned through and the magnitude of the speed.

    estimate  columns of `Estimate` over the recorded rows
    sampled   the spool's `angle` [rad] and `speed` [rad/s] at the last sample and its `time` [s], over the same rows
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
    times: Array, estimate: Mapping[str, Array], sampled: Mapping[str, Array], pitch: float
) -> Summary:
    """Results of the estimate of a run, from `SETTLED` on; empty for a shorter run.

    Means over time are by the trapezoidal rule over the recorded rows. Errors in a row with one sign count as one.
    Arguments as those of `estimate_errors`, and `times` [s] of the rows.
    """
    late = times >= SETTLED
    if np.count_nonzero(late) < 2:
        return {}
    t = times[late]

    def mean(values: Array) -> float:
        return float(np.trapezoid(values, t) / (t[-1] - t[0]))

    found: Summary = {}
    errors = estimate_errors(estimate, sampled, pitch)
    for name, error in (("angle", errors.angle[late]), ("speed", errors.speed[late])):
        unit, deviation = UNITS[name][1], estimate[f"{name}_deviation"][late]
        squared = (error / deviation) ** 2
        found |= {
            f"spool_{name}_error_rms_{unit}": mean(error**2) ** 0.5,
            f"spool_{name}_deviation_rms_{unit}": mean(deviation**2) ** 0.5,
            f"spool_{name}_coverage": mean(np.asarray(squared <= STATED**2, float)),
            f"spool_{name}_nees": mean(squared),
            f"spool_{name}_errors": float(1 + np.count_nonzero(np.diff(np.signbit(error)))),
        }
    stands = np.trapezoid(np.asarray(estimate["standstill"] > 0.5, float), times)
    return found | {"spool_missed_edges": float(estimate["missed_edges"][-1]), "standstill_time_s": float(stands)}


def estimate_quantities(pitch: float) -> dict[str, tuple[Kind, str]]:
    """Kind and label of the keys of `estimate_numbers`, whose `pitch` [rad] is given."""
    found: dict[str, tuple[Kind, str]] = {}
    for name, words in (("angle", "estimated angle"), ("speed", f"estimated speed{of_what(pitch)}")):
        kind, unit = UNITS[name]
        found |= {
            f"spool_{name}_error_rms_{unit}": (kind, f"{words}: error"),
            f"spool_{name}_deviation_rms_{unit}": (kind, f"{words}: stated standard deviation"),
            f"spool_{name}_coverage": (EFFICIENCY, f"{words}: errors within ±2σ"),
            f"spool_{name}_nees": (NUMBER, f"{words}: squared errors over stated variance"),
            f"spool_{name}_errors": (COUNT, f"{words}: independent errors"),
        }
    return found | {
        "spool_missed_edges": (COUNT, "edges that the encoder missed"),
        "standstill_time_s": (DURATION, "time for which the spool is estimated to stand"),
    }


def of_what(pitch: float) -> str:
    """What an estimated speed is, to be put behind the word; `pitch` [rad] as that of `estimate_errors`."""
    return ", mean over a PWM period" if pitch > 0.0 else " of the instant"


def estimate_lines(pitch: float) -> tuple[Line, ...]:
    """What a user is shown of the estimate; `pitch` [rad] as that of `estimate_errors`."""
    shown = {key: each for key, each in estimate_quantities(pitch).items() if not key.endswith(("_nees", "_errors"))}
    return tuple(Line(label, (key,), kind, (), "Estimate of the spool") for key, (kind, label) in shown.items())


def estimate_doubts(found: Mapping[str, float | bool], pitch: float) -> Iterator[str]:
    """Where the estimate of a run is surer than it may be, or far less sure, and not by chance: a sentence each.

    found  numbers of the run
    pitch  as that of `estimate_errors` [rad]
    """
    for name, words in (("angle", "angle"), ("speed", f"speed{of_what(pitch)}")):
        kind, unit = UNITS[name]
        share = found.get(f"spool_{name}_coverage")
        if share is None or COVERAGE[0] <= share <= COVERAGE[1]:
            continue
        nees, (low, high) = found[f"spool_{name}_nees"], chance_band(int(found[f"spool_{name}_errors"]))
        if nees > high if share < COVERAGE[0] else MODEST**2 * nees < low:
            stated, true = (found[f"spool_{name}_{which}_rms_{unit}"] for which in ("deviation", "error"))
            yield (
                f"the estimate of the spool states {with_unit(stated, kind, 3)} ({words}) and errs by "
                f"{with_unit(true, kind, 3)}: {percent(share)} of the errors lie within two stated standard "
                "deviations, where "
                f"{percent(COVERAGE[0], 0)} to {percent(COVERAGE[1], 0)} should"
            )
