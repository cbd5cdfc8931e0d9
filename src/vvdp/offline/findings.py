"""What a person is told of a record."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.kinds import ANGLE, SPEED
from vvdp.estimation.commensurate import commensurate_warning, hidden_angle
from vvdp.logs.channel import Log
from vvdp.logs.clock import is_time_name
from vvdp.offline.bridging import bridged_time
from vvdp.offline.config import Estimation, Stamps
from vvdp.offline.diagnostics import (
    beside_alternation,
    in_step,
    numbers_in_doubt,
    settings_of,
    suggested_level,
    threshold_is_off,
    worst_edge,
)
from vvdp.offline.edges import GAP, MOST_AT_ONCE, CountEdges, WaveEdges
from vvdp.offline.guess import channels_of_edges
from vvdp.offline.noise_fit import CLEAR, Explained
from vvdp.offline.ripple_findings import ripple_findings
from vvdp.offline.sums import Sums
from vvdp.offline.wheel_findings import NAMED, grave, motion_findings, warning, wheel_findings
from vvdp.results.result import Finding, Grade
from vvdp.sensing.wheel import TURN

SLOWEST, FASTEST = TURN * 0.2, TURN * 200.0
"""Mean speeds outside of these [rad/s] suggest a wrong unit or number of sectors."""
LEVEL_DRIFT = 0.1
FEW_SAMPLES = 3.0


def findings(found: dict[str, Any], sums: Sums, wanted: Estimation, log: Log) -> tuple[Finding, ...]:
    """What is wrong with the record or in doubt, gravest first."""
    best = sums.noise_fit(settings_of(wanted))
    clock = list(_of_the_clock(best, wanted, log)) if best is not None else []
    told = [
        *clock,
        *motion_findings(sums),
        *_of_the_course(found, sums, wanted),
        *_of_the_record(sums, wanted),
        *_of_the_source(sums, wanted),
        *_of_the_pressure(sums),
    ]
    if not clock:
        wheel = list(_of_the_wheel(found, sums, wanted, best))
        sure = best is not None and not numbers_in_doubt(best, sums, wanted)
        settings = [*_of_the_filter(best), *ripple_findings(best, wanted)] if best is not None and sure else []
        wheel_first = best is not None and best.wheel_gain > best.settings_gain
        told += wheel + settings if wheel_first else settings + wheel
    told += [warning("Taken for granted", f"{remark}.", "Nothing to do, if that is right.") for remark in log.remarks]
    first = () if clock else wheel_findings(found, sums, wanted)
    return (*first, *sorted(told, key=lambda finding: finding.grade is not Grade.BAD))


def _angle(value: float) -> str:
    return with_unit(value, ANGLE, 3)


def _speed(value: float) -> str:
    return with_unit(value, SPEED, 3)


def _of_the_course(found: dict[str, Any], sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    for words in sums.interruptions:
        yield grave("Interrupted", words, "Run it again.")
    if not found["settled"]:
        yield grave(
            "Too short",
            f"{_edges(sums.edges)} {_are(sums.edges)} less than two turns of {sums.sectors}: the filter has not "
            "settled, and means are over all that there is.",
            "Take a longer record.",
        )
    speed = sums.usual_speed
    if not SLOWEST <= speed <= FASTEST:
        yield grave(
            "Speed hardly possible",
            f"The mean speed is {with_unit(speed, SPEED)}.",
            f"Look at the unit of the times, the sample rate, and the number of sectors ({sums.sectors}).",
        )


def _of_the_record(sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    if sums.gaps:
        yield warning(
            "Gaps in the record",
            f"{_times(sums.gaps).capitalize()} no sample came for more than {GAP:g} usual intervals; the longest gap "
            f"is {sums.longest_gap:.4g} s.",
            "Edges inside a gap count as missed; a gap that cannot be bridged starts the filter anew.",
        )
    if sums.not_numbers:
        yield warning(
            "Values that are no numbers",
            f"{sums.not_numbers} of {sums.samples} samples {_are(sums.not_numbers)} NaN and {_were(sums.not_numbers)} "
            "left out.",
            "Look at the logger.",
        )
    if sums.backward:
        yield grave(
            "Time runs backwards",
            f"{_times(sums.backward).capitalize()} the clock went back; the record was cut there, and each piece has "
            "its own times.",
            "Look at the column piece of result.h5 before joining anything over time.",
        )
    if sums.pieces > 1 + sums.backward + len(sums.reversals):
        bridge = bridged_time(TURN / sums.sectors / sums.pace.mean, wanted.filter) if sums.pace.mean > 0.0 else np.nan
        yield warning(
            "Pauses without edges",
            f"The filter was started {_times(sums.pieces)}: without an edge it can go on for {bridge:.3g} s at the "
            "mean speed, until three deviations of its angle reach half a sector.",
            "Between pieces the spool is said to stand where the last row has it; in a gap of the record the estimate "
            "is NaN, and turns that passed there are only guessed.",
        )
    if sums.left_out:
        yield warning(
            "Edges left out",
            f"{_edges(sums.left_out)} {_are(sums.left_out)} too isolated to give a speed.",
            "Nothing to do, if the spool was at rest.",
        )
    if sums.doubled:
        yield warning(
            "Double edges",
            f"{_edges(sums.doubled)} came much sooner after another than edges do there; "
            f"{'it was taken as a bounce' if sums.doubled == 1 else 'they were taken as bounces'}.",
            "Widen the hysteresis, or look for noise on the line.",
        )
    if sums.missed:
        yield warning(
            "Missed edges",
            f"{_edges(sums.missed)} did not show, {100.0 * sums.missed / (sums.edges + sums.missed):.2g} % of all.",
            "The filter passes over them. Look at the threshold, the sample rate, and the wheel for dirt.",
        )


def _of_the_source(sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    finder, speed = sums.finder, sums.pace.mean
    if sums.period and speed > 0.0 and isinstance(finder, WaveEdges | CountEdges):
        per_sector = TURN / sums.sectors / speed / sums.period
        if per_sector < FEW_SAMPLES:
            yield warning(
                "Few samples",
                f"There are {per_sector:.2g} samples for each sector at the mean speed.",
                "Sample faster: "
                + ("edges get lost." if isinstance(finder, WaveEdges) else "nothing is known of within a sample."),
            )
    if isinstance(finder, CountEdges):
        if finder.fractions:
            yield grave(
                "Counts that are not whole",
                f"{finder.fractions} of {sums.samples} values of the counter "
                f"{'is no whole number' if finder.fractions == 1 else 'are no whole numbers'}.",
                "Is the channel a wave? Then name it with --wave.",
            )
        if finder.resets:
            often = _times(finder.resets).capitalize()
            yield grave(
                "Counter reset",
                f"{often} the counter fell without rolling over, or jumped by more than {MOST_AT_ONCE:g} edges.",
                "Edges at a reset count as missed.",
            )
        if finder.rollovers:
            yield warning("Counter rolled over", f"The counter went over its end {_times(finder.rollovers)}.",
                          "The edges were counted on.")  # fmt: skip
        if finder.downward:
            yield warning("Counter counts down", "Its steps were taken as forward.", "Swap the lines of the counter.")
        if finder.backward:
            yield warning("Counter went back", f"The counter went against its way {_times(finder.backward)}.",
                          "They were taken as jitter at an edge.")  # fmt: skip
    if isinstance(finder, WaveEdges):
        if finder.lost:
            yield warning("Edges in gaps",
                          f"{_edges(finder.lost)} fell into gaps and {_were(finder.lost)} not placed.",
                          "Such edges count as missed.")  # fmt: skip
        if finder.plateaus is not None and len(finder.levels) > 1:
            drift = max(finder.levels) - min(finder.levels)
            if drift > LEVEL_DRIFT * finder.plateaus.swing:
                yield warning(
                    "The wave drifts",
                    f"Midway between its plateaus went from {min(finder.levels):.4g} to {max(finder.levels):.4g}, "
                    f"{100.0 * drift / finder.plateaus.swing:.2g} % of the swing.",
                    "The threshold followed it. Look at the lamp and its supply.",
                )
    if (step := in_step(sums, wanted)) is not None:
        words = commensurate_warning(step, TURN / sums.sectors)
        yield grave(
            "Edges in step with the clock",
            words.rpartition("; ")[0] + ".",
            f"The angle may be off by up to {_angle(hidden_angle(step, TURN / sums.sectors))}, and no deviation shows "
            "it. Stamp the edges, interpolate the crossings of a wave, or sample at another rate.",
        )


def _of_the_pressure(sums: Sums) -> Iterator[Finding]:
    told = [str(each) for each in sums.pressure_record]
    if told:
        more = f"; and {len(told) - NAMED} more" if len(told) > NAMED else ""
        yield warning(
            "The record of the pressure",
            f"{'; '.join(told[:NAMED])}{more}.",
            "Look at the sensor's range and the logger: what was not measured is not in the fold and the duty ratio.",
        )


def _of_the_filter(told: Explained) -> Iterator[Finding]:
    if not told.matters:
        return
    used, advised, now = told.used, told.advised, told.used_errors
    constant = " (less is as likely: the speed is constant as far as they tell)" if told.fit.at_floor[0] else ""
    R_most = "at most " if told.fit.at_floor[1] else ""
    yield warning(
        "The settings of the filter do not fit this log",
        f"The {told.fit.edges} edges looked at are likeliest with an acceleration_density of "
        f"{advised.acceleration_density:.3g} rad^2/s^3{constant} and an edge_variance of {R_most}"
        f"{advised.edge_variance:.3g} rad^2, in place of {used.acceleration_density:.3g} and "
        f"{used.edge_variance:.3g} (logarithm of the likelihood "
        f"+{told.settings_gain:.3g}). As it is, a speed error of {_speed(now.true)} is expected, where the filter "
        f"states {_speed(now.stated)}; with these {_speed(told.fitted_errors.true)}.",
        f"Use --fit, or in the config [filter] acceleration_density = "
        f'"{advised.acceleration_density:.3g} rad^2/s^3" and edge_variance = "{advised.edge_variance:.3g} rad^2".',
    )


def _of_the_clock(told: Explained, wanted: Estimation, log: Log) -> Iterator[Finding]:
    source, speed = wanted.source, told.likelihood.speed
    if not isinstance(source, Stamps) or source.falling or not told.even_clock:
        return
    if not is_time_name(source.channel.rpartition("/")[2]) and speed <= FASTEST:
        return
    others = ", ".join(repr(name) for name in channels_of_edges(log))
    yield grave(
        "An even clock in place of edges",
        f"All times in {source.channel!r} are {told.likelihood.period:.6g} s apart: it is the clock of the log, and no "
        "edge passes then.",
        f"Name the channel that holds the edges with --wave, --counts or --edges{f': {others}' if others else ''}.",
    )


def _of_the_wheel(found: dict[str, Any], sums: Sums, wanted: Estimation, best: Explained | None) -> Iterator[Finding]:
    hidden = max(sums.measured_variance.mean - wanted.filter.edge_variance, 0.0) if sums.nis.count else 0.0
    pattern = sums.period_of_pattern(hidden)
    if pattern is not None and best is not None and best.period_gain(pattern[0]) <= best.wheel_gain + CLEAR:
        pattern = None
    if pattern is not None:
        period, there, own = pattern
        yield grave(
            "Perhaps a wrong number of sectors",
            f"The innovations repeat after {period} edges (correlation {there:.2f}), not after {sums.sectors} "
            f"({own:.2f}), and speed variation does not explain it.",
            f"Count the sectors of the wheel; bright and dark ones together, {period} would fit.",
        )
    bias = -sums.alternating.mean if threshold_is_off(sums, wanted) else 0.0
    if bias:
        yield _bias_warning(sums, wanted, bias)
    offsets = sums.offsets if not bias else beside_alternation(sums)
    worst = worst_edge(sums, offsets)
    if worst is not None and pattern is None:
        yield _unequal(sums, wanted, offsets, worst)


def _edges(count: float) -> str:
    return "1 edge" if count == 1 else f"{count:.9g} edges"


def _are(count: float) -> str:
    return "is" if count == 1 else "are"


def _were(count: float) -> str:
    return "was" if count == 1 else "were"


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _bias_warning(sums: Sums, wanted: Estimation, bias: float) -> Finding:
    late, early = ("late", "early") if bias > 0.0 else ("early", "late")
    level = suggested_level(sums, wanted)
    remedy = (
        f"Set threshold.level to about {level:.4g}"
        if np.isfinite(level) and isinstance(sums.finder, WaveEdges)
        else "Move the threshold"
    )
    other = "; bright sectors that are really wider or narrower than dark ones look the same."
    return warning(
        "The threshold is off",
        f"Rising edges come {late} and falling ones {early} by {_angle(abs(bias))}, "
        f"{100.0 * abs(bias) * sums.sectors / TURN:.2g} % of a sector.",
        remedy + other,
    )


def _unequal(sums: Sums, wanted: Estimation, offsets: Array, worst: int) -> Finding:
    n, sector = sums.sectors, TURN / sums.sectors
    places = np.array(wanted.wheel.edges)
    wave = 2.0 * abs(np.nanmean(offsets * np.exp(-1j * places)))
    others, far = np.delete(offsets, worst), float(abs(offsets[worst]))
    way = "beyond" if offsets[worst] > 0.0 else "before"
    if wave > 0.7 * float(np.sqrt(2.0 * np.nanmean(offsets**2))) and n > 4:
        cause = f"They go up and down once in a turn by {_angle(float(wave))}: the wheel or the spot is eccentric."
    elif far > 4.0 * float(np.nanmax(np.abs(others - np.nanmean(others)))):
        cause = (
            "It stands alone: dirt, a damaged sector, or an index sector missing from the configuration (index_shift)."
        )
    else:
        cause = "The sectors are not as wide as the wheel has them."
    return warning(
        "Edges lie elsewhere on the wheel",
        f"Edge {worst} lies {_angle(far)} {way} its place, {100.0 * far / sector:.2g} % of a sector. {cause}",
        "Give the measured widths in [sensor] widths; the offsets of all edges stand in the report.",
    )
