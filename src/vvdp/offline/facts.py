"""Facts to report of a record: facts by name, for the sentences of `findings`; what does not hold is empty."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import ANGLE, SPEED
from vvdp.estimation.commensurate import commensurate_warning, hidden_angle
from vvdp.logs.channel import Log
from vvdp.logs.clock import is_time_name
from vvdp.offline.bridging import LONGEST_BRIDGED, bridged_time
from vvdp.offline.config import Estimation, Stamps, Wave
from vvdp.offline.cutting import FEWEST_EDGES
from vvdp.offline.diagnostics import (
    MISCOUNTED,
    beside_alternation,
    in_step,
    suggested_level,
    threshold_is_off,
    worst_edge,
)
from vvdp.offline.edges import GAP, JUMPING, MOST_AT_ONCE, CountEdges, WaveEdges
from vvdp.offline.guess import channels_of_edges
from vvdp.offline.hypotheses import Sectors
from vvdp.offline.lost_sensor import WANDERS
from vvdp.offline.noise_fit import WORTH, Explained, fitted_filter
from vvdp.offline.passed_edges import FEWEST_FITTED
from vvdp.offline.pattern_fit import CLEAR
from vvdp.offline.sums import Sums, Tally, repeats_after
from vvdp.offline.turn_pattern import Candidate, SpeedRipple, is_whole
from vvdp.sensing.wheel import TURN

SLOWEST, FASTEST = TURN * 0.2, TURN * 200.0
"""Mean speeds outside of these [rad/s] suggest a wrong unit or number of sectors."""
LEVEL_DRIFT = 0.1
FEW_SAMPLES = 3.0
ALIAS_SAMPLES = 4.0
"""With fewer samples for each sector, and no index that fits, the wave may be one of a faster wheel."""
ALIASES = 3
NAMED = 3
"""So many times are named; the rest is counted."""
SURE = 3.0
"""Standard errors beyond which a ripple is reported."""


class Amount(float):
    """A number with the words that go with it: `edges`, `is`, `was`, `times`, `Times`, or `one|many`."""

    def __format__(self, words: str) -> str:
        singular, bar, plural = {"is": "is|are", "was": "was|were"}.get(words, words).partition("|")
        if bar:
            return singular if self == 1.0 else plural
        if words == "edges":
            return "1 edge" if self == 1.0 else f"{float(self):.9g} edges"
        if words.lower() == "times":
            often = {1.0: "once", 2.0: "twice"}.get(self, f"{float(self):.9g} times")
            return often.capitalize() if words == "Times" else often
        return format(float(self), words or ".9g")


def _amounts(counted: Tally | CountEdges) -> dict[str, Any]:
    """What was counted, by name."""
    return {name: Amount(value) for name, value in vars(counted).items() if isinstance(value, int | float)}


def ripple_words(ripple: SpeedRipple, alike: tuple[Candidate, ...] = ()) -> str:
    """What a pattern of the edges is, as far as they show, with ripples of other orders that fit `alike`."""
    others = [each.ripple for each in alike if each.ripple.order != ripple.order]
    same = ", ".join(f"{percent(each.amplitude)} at {each.order}" for each in sorted(others, key=lambda r: r.order))
    also = f" (the same edges as {same})" if same else ""
    return (
        f"a ripple of {percent(ripple.amplitude)} at {ripple.order} per turn{also}, or a wheel with offsets of the "
        "same pattern: edges alone cannot show"
    )


def _list_words(words: list[str], separator: str = ", ", rest: str = "{} times more") -> str:
    left = len(words) - NAMED
    return separator.join([*words[:NAMED], *([f"and {rest.format(left)}"] if left > 0 else [])])


def _samples_per_sector(sums: Sums) -> float:
    """At the mean speed; NaN where there are no samples or no speed."""
    speed, tally = sums.rows.pace.mean, sums.tally
    return TURN / tally.sectors / speed / tally.period if tally.period and speed > 0.0 else np.nan


def wheel_facts(found: Mapping[str, object], sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """Which wheel it was, which way it turned, aliases."""
    verdict, tally, index_found = sums.tally.verdict, sums.tally, found["index_found"]
    if verdict is None:
        return {}
    described, likeliest = verdict.described, verdict.likeliest
    told, edges, one_kind = len(described.edges), len(likeliest.edges), likeliest.sectors is Sectors.ONE_KIND
    lost = "No first edge makes the turns agree with the sectors of the wheel; the angle is counted from an edge that "
    lost += "was chosen"
    if verdict.index_shows is False or all(each.index_found for each in tally.alignments):
        lost = "The edges are explained better by a wheel whose sectors are all alike"
    more = len(tally.reversals) - NAMED
    passages = _list_words([f"{time:.4g} s" for time in tally.slow_passages])
    return {
        **({} if index_found else _alias_facts(sums, wanted)),
        "passing": edges,
        "described": told,
        "described_to_passing": told / edges,
        "likelier": f"ln L {verdict.gain:+.3g}",
        "odd_kind": one_kind and edges % 2 == 1,
        "even_kind": one_kind and edges % 2 == 0,
        "other_sectors": not one_kind and likeliest.sectors is not Sectors.AS_TOLD,
        "assumed": wanted.sectors_assumed and not index_found,
        "sectors": tally.sectors,
        "half": tally.sectors // 2,
        "index_lost": lost if index_found is False and not one_kind else "",
        "inverted": likeliest.polarity < 0.0,
        "upright": _upright_words(wanted),
        "backwards": likeliest.direction < 0.0 and not tally.reversals,
        "mirrored_shift": 1.0 - described.edges[1] * told / TURN,
        "reversals": tally.reversals[:NAMED],
        "more_reversals": max(more, 0),
        "slow_passages": "" if index_found else passages,
    }


def _upright_words(wanted: Estimation) -> str:
    match wanted.source:
        case Wave(comparator=comparator):
            return f"Set inverted = {'true' if comparator.inverted else 'false'} in [sensor]. "
        case Stamps():
            return "Exchange --edges and --falling. "
    return ""


def _alias_facts(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    speed, per_sector = sums.rows.pace.mean, _samples_per_sector(sums)
    if not (isinstance(wanted.source, Wave) and per_sector < ALIAS_SAMPLES):
        return {}
    # A wave of f makes the same samples as one of k f_s - f or k f_s + f.
    full = 2.0 * TURN / sums.tally.sectors / sums.tally.period
    others = sorted(k * full + sign * speed for k in range(1, ALIASES) for sign in (-1.0, 1.0))[:ALIASES]
    aliases = ", ".join(with_unit(each, SPEED, 4) for each in others)
    return {"alias": True, "per_sector": per_sector, "aliases": aliases, "pace": with_unit(speed, SPEED, 4)}


def clock_facts(told: Explained | None, wanted: Estimation, log: Log) -> dict[str, Any]:
    """Whether the times are those of a clock, and pass for edges."""
    source = wanted.source
    if told is None or not isinstance(source, Stamps) or source.falling or not told.even_clock:
        return {}
    if not is_time_name(source.channel.rpartition("/")[2]) and told.likelihood.speed <= FASTEST:
        return {}
    others = ", ".join(repr(name) for name in channels_of_edges(log))
    return {
        "even_clock": told.likelihood.period,
        "evenly": "All" if told.even_share == 1.0 else percent(told.even_share, 3),
        "channel": source.channel,
        "others": f": {others}" if others else "",
    }


def record_facts(found: Mapping[str, object], sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """The course of the record, its samples and edges, its pressure."""
    tally, rows, pace = sums.tally, sums.rows, sums.rows.pace.mean
    again = tally.pieces > 1 + tally.backward + len(tally.reversals)
    passed = tally.edges + tally.missed
    complaints = [str(each) for each in tally.pressure_record]
    return {
        **_amounts(tally),
        **_finder_facts(sums),
        **_step_facts(sums, wanted),
        **_lost_facts(sums),
        "standstills": _list_words([f"from {begin:.4g} to {end:.4g} s" for begin, end in rows.standstills]),
        "interruptions": tally.interruptions,
        "unsettled": not found["settled"],
        "unchecked": found["settled"] and sums.explained is None,
        "fewest_checked": FEWEST_FITTED,
        "hardly_possible": "" if SLOWEST <= rows.usual_speed <= FASTEST else with_unit(rows.usual_speed, SPEED),
        "gap": GAP,
        "started_anew": Amount(tally.pieces if again else 0),
        "bridge": bridged_time(TURN / tally.sectors / pace, wanted.filter) if again and pace > 0.0 else np.nan,
        "miscounted": sums.doubt.miscounted if sums.doubt.miscounted > MISCOUNTED else 0.0,
        "missed_percent": 100.0 * tally.missed / passed if passed else np.nan,
        "pressure_record": _list_words(complaints, "; ", "{} more"),
    }


def _lost_facts(sums: Sums) -> dict[str, Any]:
    if not sums.lost_sensors:
        return {}
    speed = max(abs(each.before) for each in sums.lost_sensors)
    return {
        "lost_sensor": _list_words([f"from {each.begin:.4g} to {each.end:.4g} s" for each in sums.lost_sensors]),
        "lost_speed": with_unit(speed, SPEED, 3),
        "needed": f"{speed * speed * sums.tally.sectors / (2.0 * TURN):.3g}",
        "lost_chance": percent(min(each.lost for each in sums.lost_sensors)),
        "lost_turns": max(WANDERS / np.sqrt(3.0) * abs(each.travel) / TURN for each in sums.lost_sensors),
    }


def _step_facts(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    step, width = in_step(sums, wanted), TURN / sums.tally.sectors
    if step is None:
        return {}
    words = commensurate_warning(step, width).rpartition("; ")[0]
    return {"in_step": words, "hidden": with_unit(hidden_angle(step, width), ANGLE, 3)}


def _finder_facts(sums: Sums) -> dict[str, Any]:
    finder, per_sector = sums.tally.finder, _samples_per_sector(sums)
    few = "edges get lost." if isinstance(finder, WaveEdges) else "nothing is known of within a sample."
    sampled = {"per_sector": per_sector, "few_samples": few if per_sector < FEW_SAMPLES else ""}
    match finder:
        case CountEdges():
            facts = _amounts(finder) | {"against": Amount(finder.backward), "most_at_once": MOST_AT_ONCE}
            return sampled | {name: value for name, value in facts.items() if name != "backward"}
        case WaveEdges(plateaus=plateaus, levels=levels):
            lowest, highest = min(levels, default=np.nan), max(levels, default=np.nan)
            drift = (highest - lowest) / plateaus.swing if plateaus is not None and len(levels) > 1 else 0.0
            return sampled | {
                "lost": Amount(finder.lost),
                "drift_percent": 100.0 * drift if drift > LEVEL_DRIFT else 0.0,
                "lowest_level": lowest,
                "highest_level": highest,
            }
    return {}


def settings_facts(told: Explained, wanted: Estimation) -> dict[str, Any]:
    """Settings of the filter that fit the log better, and a ripple that it leaves out or that cannot be determined."""
    ripple, edges, used, now = told.ripple, told.likelihood.sectors, told.used, told.used_errors
    sure = ripple is not None and ripple.amplitude > SURE * ripple.error
    facts = {
        "misfit": told.matters,
        "fitted_edges": told.fit.edges,
        "q": f"{told.advised.acceleration_density:.3g}",
        "R": f"{told.advised.edge_variance:.3g}",
        "q_used": used.acceleration_density,
        "R_used": used.edge_variance,
        "constant": " (less is as likely: the speed is constant as far as they show)" if told.fit.at_floor[0] else "",
        "at_most": "at most " if told.fit.at_floor[1] else "",
        "settings_gain": told.settings_gain,
        "true_error": with_unit(now.true, SPEED, 3),
        "stated_error": with_unit(now.stated, SPEED, 3),
        "fitted_error": with_unit(told.fitted_errors.true, SPEED, 3),
        "ripple_unseen": told.wheel is not None and ripple is None and not is_whole(wanted.sections, edges),
        "sections": wanted.sections,
        "nyquist": 2 * wanted.sections,
        "wheel_edges": edges,
    }
    if ripple is None or not sure or wanted.filter.ripple_order == ripple.order:
        return facts
    fitted = fitted_filter(wanted.filter, told)
    return facts | {
        "ripple": ripple_words(ripple, told.candidates).capitalize(),
        "ripple_order": ripple.order,
        "ripple_variance": fitted.ripple_variance,
        "ripple_drift": fitted.ripple_drift,
        "swing": with_unit(ripple.amplitude * told.likelihood.speed, SPEED, 3),
    }


def doubt_facts(sums: Sums) -> dict[str, Any]:
    """A ripple that may be part of what is taken for the wheel's offsets."""
    told = sums.explained
    if told is None or told.ripple is not None or not sums.doubt.speed_ratio > WORTH**2:
        return {}
    orders = sorted(each.ripple.order for each in told.candidates)
    return {
        "hidden_ripple": with_unit(sums.doubt.speed_deviation(sums.rows.usual_speed), SPEED, 3),
        "hidden_orders": _list_words([str(order) for order in orders], rest="{} more"),
    }


def pattern_facts(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """What repeats with every turn and is no ripple: another number of sectors, a threshold that is off, edges that lie
    elsewhere."""
    variance, best = sums.edges.measured_variance.mean, sums.explained
    hidden = max(variance - wanted.filter.edge_variance, 0.0) if sums.edges.nis.count else 0.0
    pattern = repeats_after(sums, hidden)
    if pattern is not None and best is not None and best.period_gain(pattern[0]) <= best.wheel_gain + CLEAR:
        pattern = None
    bias, facts = -sums.edges.alternating.mean if threshold_is_off(sums, wanted) else 0.0, {}
    if pattern is not None:
        names = ("period", "correlation", "own_correlation")
        facts = dict(zip(names, pattern, strict=True)) | {"sectors": sums.tally.sectors}
    if bias:
        facts |= _bias_facts(sums, wanted, bias)
    offsets = sums.edges.offsets if not bias else beside_alternation(sums)
    worst = worst_edge(sums, offsets)
    return facts if worst is None or pattern is not None else facts | _far_facts(sums, wanted, offsets, worst)


def _bias_facts(sums: Sums, wanted: Estimation, bias: float) -> dict[str, Any]:
    level, wave = suggested_level(sums, wanted), isinstance(sums.tally.finder, WaveEdges)
    known = wave and np.isfinite(level)
    return {
        "late": "late" if bias > 0.0 else "early",
        "early": "early" if bias > 0.0 else "late",
        "bias": with_unit(abs(bias), ANGLE, 3),
        "bias_percent": 100.0 * abs(bias) * sums.tally.sectors / TURN,
        "move_threshold": f"Set threshold.level to about {level:.4g}" if known else "Move the threshold",
    }


def _far_facts(sums: Sums, wanted: Estimation, offsets: Any, worst: int) -> dict[str, Any]:
    n, places = sums.tally.sectors, np.array(wanted.wheel.edges)
    wave = float(2.0 * abs(np.nanmean(offsets * np.exp(-1j * places))))
    others, far = np.delete(offsets, worst), float(abs(offsets[worst]))
    if wave > 0.7 * float(np.sqrt(2.0 * np.nanmean(offsets**2))) and n > 4:
        swing = with_unit(wave, ANGLE, 3)
        cause = f"They go up and down once in a turn by {swing}: the wheel or the spot is eccentric."
    elif far > 4.0 * float(np.nanmax(np.abs(others - np.nanmean(others)))):
        cause = (
            "It stands alone: dirt, a damaged sector, or an index sector missing from the configuration (index_shift)."
        )
    else:
        cause = "The sectors are not as wide as the wheel has them."
    return {
        "far": with_unit(far, ANGLE, 3),
        "worst": worst,
        "way": "beyond" if offsets[worst] > 0.0 else "before",
        "far_percent": 100.0 * far * n / TURN,
        "cause": cause,
    }


def no_result_facts(tally: Tally, wanted: Estimation) -> dict[str, Any]:
    """What may have kept a log from giving an estimate."""
    finder, edges = tally.finder, tally.edges
    wave = finder if isinstance(finder, WaveEdges) else None
    counter = finder if isinstance(finder, CountEdges) else None
    apart = (tally.end - tally.begin) / (edges - 1.0) if edges > FEWEST_EDGES else np.nan
    ranged = wanted.begin is not None or wanted.end is not None
    return _amounts(tally) | {
        "channel": wanted.source.channel,
        "found": f"{edges:g} edges were found in channel {wanted.source.channel!r}",
        "needed": f"an estimate needs at least {FEWEST_EDGES} on one clock",
        "jumping": 100.0 * wave.jumps if wave is not None and not edges and wave.jumps > JUMPING else 0.0,
        "no_level": wave is not None and not np.isfinite(wave.level),
        "no_samples": not tally.samples,
        "fractions": Amount(counter.fractions if counter is not None else 0),
        "out_of_range": not edges and ranged,
        "few_steps": counter is not None and apart < LONGEST_BRIDGED,
        "apart": apart if np.isfinite(apart) else 0.0,
        "longest": LONGEST_BRIDGED,
        "too_few": True,
    }
