"""The result of an estimation: numbers, findings, tables and figures, from what was summed up on the way."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.display import plain, with_unit
from vvdp.base.kinds import (
    ACCELERATION_DENSITY,
    ANGLE,
    ANGULAR_VARIANCE,
    COUNT,
    DURATION,
    DUTY_RATIO,
    EFFICIENCY,
    FLAG,
    FREQUENCY,
    GAUGE_PRESSURE,
    NUMBER,
    RATIO,
    SPEED,
    Kind,
)
from vvdp.offline.charts import (
    Excerpt,
    Figure,
    innovation_figure,
    pressure_figure,
    pressure_fold,
    seen_stretch,
    speed_detail,
    speed_figure,
    wave_figure,
)
from vvdp.offline.config import Counts, Estimation, Stamps, Wave, source_channels
from vvdp.offline.sums import Sums
from vvdp.offline.wheel_charts import RIPPLES, TABLE, ripple_table, wheel_figure, wheel_table
from vvdp.results.result import Badge, Finding, Grade, Listing, Number, Result, Row, Section, numbers_of

SOURCES: Mapping[type, tuple[str, str]] = {
    Wave: ("wave", "a photodiode's wave"),
    Counts: ("counts", "a counter"),
    Stamps: ("edges", "edge times"),
}
"""What holds the edges: in a word, and for a user."""
QUANTITIES: Mapping[str, tuple[Kind, str]] = {
    "duration_s": (DURATION, "length of the log"),
    "estimated_share": (EFFICIENCY, "share of time with an estimate"),
    "samples": (COUNT, "samples"),
    "sample_rate_Hz": (FREQUENCY, "sample rate"),
    "output_rate_Hz": (FREQUENCY, "rate of the result"),
    "sectors": (COUNT, "sectors of the wheel"),
    "sectors_assumed": (FLAG, "number of sectors assumed"),
    "polarity": (NUMBER, "polarity, 1 as logged, -1 inverted"),
    "direction": (NUMBER, "direction, 1 forward, -1 backward"),
    "edges": (COUNT, "edges"),
    "missed_edges": (COUNT, "missed edges"),
    "double_edges": (COUNT, "double edges"),
    "gaps": (COUNT, "gaps"),
    "not_numbers": (COUNT, "samples that are not numbers"),
    "backward_times": (COUNT, "places where time runs backwards"),
    "pieces": (COUNT, "pieces of the record"),
    "spool_speed_mean_rad_s": (SPEED, "shaft speed, mean"),
    "spool_speed_std_rad_s": (SPEED, "shaft speed, standard deviation"),
    "spool_speed_min_rad_s": (SPEED, "shaft speed, lowest"),
    "spool_speed_max_rad_s": (SPEED, "shaft speed, highest"),
    "settled": (FLAG, "filter settled"),
    "pwm_frequency_mean_Hz": (FREQUENCY, "PWM frequency, mean"),
    "angle_deviation_mean_rad": (ANGLE, "standard deviation of the angle, mean"),
    "speed_deviation_mean_rad_s": (SPEED, "standard deviation of the speed, mean"),
    "speed_deviation_rms_rad_s": (SPEED, "standard deviation of the speed, root mean square"),
    "speed_doubt_rad_s": (SPEED, "standard deviation of the speed, doubt in it"),
    "standstill_time_s": (DURATION, "time at a standstill"),
    "lost_sensor_s": (DURATION, "time without a sensor"),
    "nis_mean": (RATIO, "normalised innovation squared, mean"),
    "nis_edges": (COUNT, "edges in that mean"),
    "nis_low": (RATIO, "by chance it would lie above"),
    "nis_high": (RATIO, "by chance it would lie below"),
    "index_found": (FLAG, "index of the wheel found"),
    "commensurate": (FLAG, "edges commensurate with the sampling"),
    "edge_offset_max_rad": (ANGLE, "largest offset of an edge"),
    "acceleration_density_rad2_s3": (ACCELERATION_DENSITY, "acceleration noise of the filter, spectral density"),
    "edge_variance_rad2": (ANGULAR_VARIANCE, "variance of an edge's angle in the filter"),
    "acceleration_density_fitted_rad2_s3": (ACCELERATION_DENSITY, "acceleration noise that fits the log best"),
    "edge_variance_fitted_rad2": (ANGULAR_VARIANCE, "variance of an edge's angle that fits the log best"),
    "likelihood_gain": (NUMBER, "logarithm of the likelihood gained by these"),
    "ripple_order_fitted": (COUNT, "ripples of the speed per revolution, found"),
    "ripple_amplitude_fitted": (RATIO, "amplitude of the speed's ripple over the mean speed, found"),
    "ripple_amplitude_fitted_error": (RATIO, "standard error of that amplitude"),
    "settings_fit": (FLAG, "settings of the filter fit the log"),
    "threshold": (NUMBER, "threshold"),
    "threshold_suggested": (NUMBER, "threshold, suggested"),
    "wave_swing": (NUMBER, "swing of the wave"),
    "wave_noise": (NUMBER, "noise of the wave"),
    "threshold_bias_rad": (ANGLE, "rising edges late by"),
    "duty_ratio_mean": (DUTY_RATIO, "duty ratio of the pressure, mean"),
    "duty_ratio_std": (DUTY_RATIO, "duty ratio of the pressure, standard deviation"),
    "pressure_pulses": (COUNT, "pulses of the pressure"),
    "pressure_mean_inlet_Pa": (GAUGE_PRESSURE, "inlet pressure, mean"),
    "pressure_min_inlet_Pa": (GAUGE_PRESSURE, "inlet pressure, lowest"),
    "pressure_max_inlet_Pa": (GAUGE_PRESSURE, "inlet pressure, highest"),
}
"""Kind and label of every number; `docs/keys.md` says what they mean."""
OF_VALVES = ("pwm_frequency_mean_Hz",)
"""Numbers that are listed for the spool of a rotary valve only."""
IN_CHANNEL_UNIT = ("threshold", "threshold_suggested", "wave_swing", "wave_noise")
LISTED: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "speed-numbers": ("Speed", (
        "spool_speed_mean_rad_s", "spool_speed_std_rad_s", "spool_speed_min_rad_s", "spool_speed_max_rad_s",
        "pwm_frequency_mean_Hz", "angle_deviation_mean_rad", "speed_deviation_mean_rad_s", "speed_deviation_rms_rad_s",
        "speed_doubt_rad_s", "standstill_time_s", "lost_sensor_s",
    )),
    "edge-numbers": ("Edges", (
        "sectors", "polarity", "direction", "edges", "missed_edges", "double_edges", "pieces",
        "edge_offset_max_rad", "nis_mean", "acceleration_density_rad2_s3", "edge_variance_rad2",
    )),
    "record-numbers": ("Record", (
        "duration_s", "estimated_share", "samples", "sample_rate_Hz", "output_rate_Hz", "gaps", "not_numbers",
    )),
    "signal-numbers": ("Signals", (
        *IN_CHANNEL_UNIT, "threshold_bias_rad", "duty_ratio_mean", "duty_ratio_std", "pressure_mean_inlet_Pa",
        "pressure_min_inlet_Pa", "pressure_max_inlet_Pa",
    )),
}  # fmt: skip
"""Title and numbers of each listing."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What an estimation came to: its datasets, what was summed up, and the numbers and findings made of that."""

    log: Path
    wanted: Estimation
    wave_unit: str
    file: Any
    """result.h5, open."""
    sums: Sums
    excerpt: Excerpt | None
    summary: Mapping[str, float | None]
    findings: tuple[Finding, ...]
    config: str
    remarks: tuple[str, ...]
    log_sha256: str
    seconds: float


def estimate_result(outcome: Outcome) -> Result:
    """Everything that is to be said and drawn of an estimation."""
    values = {key: np.nan if value is None else float(value) for key, value in outcome.summary.items()}
    numbers = numbers_of(values, QUANTITIES)
    listed = {key: each for key, each in numbers.items() if outcome.wanted.is_of_valve or key not in OF_VALVES}
    listings = dict(_listings(listed, outcome.wave_unit))
    polarity_known = isinstance(outcome.wanted.source, Wave) or _has_falling(outcome.wanted)
    wheel = wheel_table(outcome.sums, polarity_known=polarity_known)
    tables = {TABLE: wheel, RIPPLES: ripple_table(outcome.sums.explained)}
    figures = tuple(_figures(outcome))
    if np.isfinite(wheel["offset_rad"]).any():
        figures += (wheel_figure(wheel, outcome.wanted.wheel),)
    return Result(
        verb="estimate",
        title=f"Angle and speed from {outcome.log.name}",
        system="",
        conditions=_conditions(outcome),
        numbers=numbers,
        listings=listings,
        tables=tables | {name: table for each in figures for name, table in each.tables.items()},
        charts={each.chart.name: each.chart for each in figures},
        badges=tuple(_badges(outcome)),
        findings=(*outcome.findings, Finding(text=_in_words(outcome, numbers["pwm_frequency_mean_Hz"]))),
        sections=_sections(tuple(listings), tuple(each.chart.name for each in figures), outcome),
        seconds=outcome.seconds,
        finished=not outcome.sums.tally.interruptions,
    )


def _has_falling(wanted: Estimation) -> bool:
    return isinstance(wanted.source, Stamps) and bool(wanted.source.falling)


def _figures(outcome: Outcome) -> Iterator[Figure]:
    excerpt, sums, wanted = outcome.excerpt, outcome.sums, outcome.wanted
    if excerpt is not None and excerpt.times.size and isinstance(wanted.source, Wave):
        yield wave_figure(excerpt, outcome.wave_unit, automatic=wanted.source.comparator.level is None)
    yield speed_figure(outcome.file, sums)
    periods = wanted.sections if wanted.is_of_valve else 0
    yield speed_detail(outcome.file, seen_stretch(outcome.file, excerpt, sums.tally.sectors), periods)
    if sums.edges.nis.count:
        yield innovation_figure(outcome.file, sums)
    if wanted.pressure is not None:
        if excerpt is not None and excerpt.pressure is not None and excerpt.pressure.times.size > 1:
            yield pressure_figure(excerpt.pressure)
        yield pressure_fold(sums, wanted.sections)


def _listings(numbers: Mapping[str, Number], wave_unit: str) -> Iterator[tuple[str, Listing]]:
    for name, (title, keys) in LISTED.items():
        rows = tuple(_row(key, numbers[key], wave_unit) for key in keys if key in numbers)
        if rows:
            yield name, Listing(title=title, heads=("value",), rows=rows)


def _row(key: str, each: Number, wave_unit: str) -> Row:
    label = f"{each.label} [{wave_unit}]" if key in IN_CHANNEL_UNIT and wave_unit else each.label
    return Row(label, each.kind, (each.value,))


def _conditions(outcome: Outcome) -> dict[str, str]:
    wanted, sums = outcome.wanted, outcome.sums
    channels = " and ".join(repr(name) for name in source_channels(wanted))
    found = {
        "log": f"{outcome.log.name}, {with_unit(sums.tally.measured, DURATION, 6)}",
        "edges": f"from {SOURCES[type(wanted.source)][1]}, {channels}",
        "wheel": f"{sums.tally.sectors} sectors, {'with' if wanted.wheel.has_index else 'without'} an index",
        "speed": _speed_meant(wanted),
    }
    if wanted.pressure is not None:
        found["inlet pressure"] = repr(wanted.pressure.channel) + (", fused" if wanted.pressure.fused else "")
    return found


def _speed_meant(wanted: Estimation) -> str:
    """Which speed is estimated, in words."""
    order = wanted.filter.ripple_order
    if order > 0.0:
        return f"of the instant, {plain(order)} ripples per revolution"
    return "mean over a PWM period" if wanted.is_of_valve else "without its ripple"


def _badges(outcome: Outcome) -> Iterator[Badge]:
    sums, summary = outcome.sums, outcome.summary
    grave = sum(finding.grade is Grade.BAD for finding in outcome.findings)
    if grave:
        yield Badge(_count_text(grave, "grave finding"), Grade.BAD)
    if sums.tally.interruptions:
        yield Badge("interrupted", Grade.BAD)
    if (fits := summary["settings_fit"]) is not None:
        yield (
            Badge("settings of the filter fit", Grade.GOOD)
            if fits
            else Badge("settings of the filter do not fit", Grade.WARNING)
        )
    missed = Badge(f"{_count_text(sums.tally.missed, 'edge')} missed", Grade.WARNING)
    yield missed if sums.tally.missed else Badge("no edge missed", Grade.GOOD)
    if (index := summary["index_found"]) is not None:
        yield Badge("index found", Grade.GOOD) if index else Badge("index not found", Grade.BAD)
    else:
        yield Badge("no index on the wheel")
    if summary["commensurate"]:
        yield Badge("edges in step with the clock", Grade.BAD)


def _count_text(count: float, word: str) -> str:
    return f"{plain(count, 12)} {word}{'' if count == 1 else 's'}"


def _in_words(outcome: Outcome, frequency: Number) -> str:
    sums = outcome.sums
    speed = sums.rows.speed if sums.rows.speed.count else sums.rows.every_speed
    passed = f"{_count_text(sums.tally.edges, 'edge')} of a wheel with {sums.tally.sectors} sectors passed"
    missed = f", {plain(sums.tally.missed)} more did not show" if sums.tally.missed else ""
    settled = (
        f"The angle is known to {with_unit(sums.rows.angle_deviation.mean, ANGLE, 3)} and the speed, "
        f"{_speed_meant(outcome.wanted)}, to {with_unit(sums.rows.speed_deviation.mean, SPEED, 3)} (one standard "
        "deviation)."
        if sums.rows.speed.count
        else "The record is too short for the filter to settle."
    )
    is_of_valve = outcome.wanted.is_of_valve
    of_valve = f", which is a PWM frequency of {with_unit(frequency.value, FREQUENCY)}" if is_of_valve else ""
    return (
        f"In {with_unit(sums.tally.measured, DURATION)}, {passed}{missed}. The shaft turned at "
        f"{with_unit(speed.mean, SPEED, 5)} on average, standard deviation {with_unit(speed.deviation, SPEED, 3)}"
        f"{of_valve}. {settled}{_granted_words(outcome)}"
    )


def _granted_words(outcome: Outcome) -> str:
    """What the edges themselves cannot show of how many of them pass in a turn."""
    n = outcome.sums.tally.sectors
    if outcome.summary["index_found"]:
        return ""
    return f" That {n} edges pass per revolution, rising and falling ones, is assumed: such a wheel does not show it."


def _sections(listings: tuple[str, ...], charts: tuple[str, ...], outcome: Outcome) -> tuple[Section, ...]:
    origin = f"SHA-256 of the log: {outcome.log_sha256}."
    return (
        Section(title="Key numbers", shows=listings),
        Section(title="Figures", shows=charts),
        Section(title="Edges of the wheel", shows=(TABLE,)),
        Section(title="How it was done", words=(origin,), shows=("conditions",)),
        Section(
            title="Settings",
            words=("All settings with their defaults, as a file for the next estimation (--config).",),
            text=outcome.config,
        ),
    )
