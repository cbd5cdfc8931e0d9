"""Findings of a record: which fact of `facts` is reported, and the sentence in which."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from vvdp.logs.channel import Log
from vvdp.offline.config import Estimation
from vvdp.offline.diagnostics import numbers_in_doubt
from vvdp.offline.facts import (
    clock_facts,
    doubt_facts,
    no_result_facts,
    pattern_facts,
    record_facts,
    settings_facts,
    wheel_facts,
)
from vvdp.offline.sums import Sums, Tally
from vvdp.results.result import Finding, Grade

LOOK_AT_SHIFT = "If the wheel does have {described}, look at index_shift or widths."


class Rule(NamedTuple):
    """Shown where the `fact` holds, once for each item `it` of it where it is a list; facts stand in braces."""

    fact: str
    title: str
    text: str
    remedy: str
    grade: Grade = Grade.WARNING


# fmt: off
WHEEL = (
    Rule("alias", "Perhaps an alias",
        "There are only {per_sector:.2g} samples for each sector. If edges come as fast as samples or faster, the "
        "speed is an alias: {aliases} make the same samples as {pace}.",
        "Sample faster, ten times for each sector."),
    Rule("odd_kind", "Edges of one kind only",
        "By their index {passing} edges pass in a revolution, not {described}: rising edges only, or falling ones "
        "({likelier}). The speed is {described_to_passing:g} times what is shown.",
        "Log all edges: an odd number of them in a revolution cannot be followed.", Grade.BAD),
    Rule("even_kind", "Edges of one kind only",
        "By their index {passing} edges pass in a revolution, not {described}: rising edges only, or falling ones "
        "({likelier}); {passing} edges per revolution were taken.",
        "Nothing to do, if that is so. " + LOOK_AT_SHIFT),
    Rule("other_sectors", "Another number of sectors",
        "By their index {passing} edges pass in a revolution, not {described} ({likelier}); {passing} sectors were "
        "taken.",
        "Give --sectors {passing}, if that is so. " + LOOK_AT_SHIFT),
    Rule("assumed", "Sectors assumed",
        "No number of sectors was given: {sectors} sectors were assumed, {sectors} edges per revolution. Were rising "
        "edges alone logged, {half} per revolution, the speed is twice what is shown; with another number it is "
        "{sectors} over that number times what is shown.",
        "Count the bright and dark sectors of the wheel and give --sectors."),
    Rule("index_lost", "Index not found",
        "{index_lost}. So nothing confirms that {described} edges pass in a revolution: with half or twice as many the "
        "speed is twice or half of what is shown.",
        "Look at index_shift or widths, at the number of sectors ({described}), and whether rising and falling edges "
        "were both logged.", Grade.BAD),
    Rule("inverted", "The wave is inverted",
        "By the index of the wheel rising edges are falling ones ({likelier}); they were exchanged.",
        "{upright}An index on an edge of the other polarity looks the same; then nothing is to be done."),
    Rule("backwards", "The shaft turns backwards",
        "The edges follow each other in mirrored order ({likelier}): the shaft turns backwards, the angle falls, and "
        "the speed is negative.",
        "An index that is shifted the other way looks the same: if the shaft turns forward, give an index_shift of "
        "{mirrored_shift:.3g}, or the widths in the other order."),
    Rule("reversals", "The shaft reversed",
        "At about {it:.4g} s the shaft reversed: from there on the edges follow each other in mirrored order.",
        "Angle and speed have the sign of the direction."),
    Rule("more_reversals", "The shaft reversed", "And {more_reversals} times more.", "See piece and speed."),
    Rule("slow_passages", "Perhaps turned back",
        "At about {slow_passages} the shaft nearly stood still: the wheel cannot show whether it turned back.",
        "Speed and angle are those of a shaft that turns on. A wheel with an index would show."),
)
"""What the speed stands on, before everything else: which wheel it was, which way it turned, aliases."""
CLOCK = (
    Rule("even_clock", "An even clock in place of edges",
        "{evenly} of the times in {channel!r} are {even_clock:.6g} s apart, or a multiple of it: it is the clock of "
        "the log, and no edge passes then.",
        "Name the channel that holds the edges with --wave, --counts or --edges{others}.", Grade.BAD),
)
RECORD = (
    Rule("lost_sensor", "Sensor lost",
        "The sensor gave no edges {lost_sensor}. To stand still, the shaft would have to stop from {lost_speed} and to "
        "start again within one sector each, with {needed} rad/s^2. It is taken to have turned on (probability "
        "{lost_chance} or more). The revolutions in that time follow from the speed; their standard deviation is up to "
        "{lost_turns:.2g}.",
        "Check the sensor and its cable. If the shaft really stopped, give a largest_deceleration in [valve]."),
    Rule("standstills", "Standstill",
        "The shaft stood still {standstills}.",
        "Nothing to do, if so. A sensor that falls silent looks the same."),
    Rule("interruptions", "Interrupted", "{it}", "Run it again.", Grade.BAD),
    Rule("unsettled", "Too short",
        "{edges:edges} {edges:is} less than two revolutions of {sectors}: the filter has not settled, and means are "
        "over all that there is.",
        "Take a longer record.", Grade.BAD),
    Rule("unchecked", "The settings were not checked",
        "{edges:edges} {edges:is} fewer than the {fewest_checked} that a check needs: how far speed and angle may be "
        "off rests on the settings of the filter alone.",
        "Take a longer record, or give [filter] acceleration_density by what the drive can do."),
    Rule("hardly_possible", "Speed hardly possible",
        "The mean speed is {hardly_possible}.",
        "Look at the unit of the times, the sample rate, and the number of sectors ({sectors}).", Grade.BAD),
    Rule("gaps", "Gaps in the record",
        "{gaps:Times} no sample came for more than {gap:g} usual intervals; the longest gap is {longest_gap:.4g} s.",
        "Edges inside a gap count as missed; a gap that cannot be bridged starts the filter again."),
    Rule("not_numbers", "Values that are no numbers",
        "{not_numbers} of {samples} samples {not_numbers:is} NaN and {not_numbers:was} left out.",
        "Look at the logger."),
    Rule("backward", "Time runs backwards",
        "{backward:Times} the clock went back; the record was cut there, and each piece has its own times.",
        "Look at the column piece of result.h5 before joining anything over time.", Grade.BAD),
    Rule("started_anew", "Pauses without edges",
        "The filter was started {started_anew:times}: without an edge it can go on for {bridge:.3g} s at the mean "
        "speed, until three deviations of its angle reach half a sector.",
        "Between pieces the shaft is stated to stand where the last row has it; in a gap of the record the estimate is "
        "NaN, and revolutions that passed there are only guessed."),
    Rule("left_out", "Edges left out",
        "{left_out:edges} {left_out:is} too isolated to give a speed.",
        "Nothing to do, if the shaft was at rest."),
    Rule("doubled", "Double edges",
        "{doubled:edges} came much sooner after another than edges do there; {doubled:it was|they were} taken as "
        "{doubled:a bounce|bounces}.",
        "Widen the hysteresis, or look for noise on the line."),
    Rule("missed", "Missed edges",
        "{missed:edges} did not show, {missed_percent:.2g} % of all.",
        "The filter passes over them. Look at the threshold, the sample rate, and the wheel for dirt."),
    Rule("miscounted", "Edges may be counted wrongly",
        "By the times between edges the count is off by {miscounted:.2g} edges, root mean square; the standard "
        "deviation of the angle has it.",
        "Look at the sensor: many edges do not show."),
    Rule("few_samples", "Few samples",
        "There are {per_sector:.2g} samples for each sector at the mean speed.",
        "Sample faster: {few_samples}"),
    Rule("fractions", "Counts that are not whole",
        "{fractions} of {samples} values of the counter {fractions:is no whole number|are no whole numbers}.",
        "Is the channel a wave? Then name it with --wave.", Grade.BAD),
    Rule("resets", "Counter reset",
        "{resets:Times} the counter fell without rolling over, or jumped by more than {most_at_once:g} edges.",
        "Edges at a reset count as missed.", Grade.BAD),
    Rule("rollovers", "Counter rolled over",
        "The counter went over its end {rollovers:times}.",
        "The edges were counted on."),
    Rule("downward", "Counter counts down", "Its steps were taken as forward.", "Swap the lines of the counter."),
    Rule("against", "Counter went back",
        "The counter went against its way {against:times}.",
        "They were taken as jitter at an edge."),
    Rule("lost", "Edges in gaps",
        "{lost:edges} fell into gaps and {lost:was} not placed.",
        "Such edges count as missed."),
    Rule("drift_percent", "The wave drifts",
        "Midway between its plateaus went from {lowest_level:.4g} to {highest_level:.4g}, {drift_percent:.2g} % of the "
        "swing.",
        "The threshold followed it. Look at the lamp and its supply."),
    Rule("in_step", "Edges in step with the clock",
        "{in_step}.",
        "The angle may be off by up to {hidden}, and no deviation shows it. Stamp the edges, interpolate the crossings "
        "of a wave, or sample at another rate.", Grade.BAD),
    Rule("pressure_record", "The record of the pressure",
        "{pressure_record}.",
        "Look at the sensor's range and the logger: what was not measured is not in the fold and the duty ratio."),
)
SETTINGS = (
    Rule("misfit", "The settings of the filter do not fit this log",
        "The {fitted_edges} edges looked at are likeliest with an acceleration_density of {q} rad^2/s^3{constant} and "
        "an edge_variance of {at_most}{R} rad^2, in place of {q_used:.3g} and {R_used:.3g} (logarithm of the "
        "likelihood +{settings_gain:.3g}). As it is, a speed error of {true_error} is expected, where the filter "
        "states {stated_error}; with these {fitted_error}.",
        'Use --fit, or in the config [filter] acceleration_density = "{q} rad^2/s^3" and edge_variance = "{R} rad^2".'),
    Rule("ripple", "A ripple of the speed, or an uneven wheel",
        "{ripple}. The filter models neither: its speed is the mean over a ripple. The shaft's own goes {swing} up "
        "and down, which is part of the standard deviation of the speed.",
        "Use --fit, which takes it for a ripple, or in the config [filter] ripple_order = {ripple_order}, "
        'ripple_variance = {ripple_variance:.3g} and ripple_drift = "{ripple_drift:.3g} 1/s"; if it is the wheel, its '
        "widths."),
    Rule("ripple_unseen", "A ripple cannot be seen whole",
        "What repeats with every turn is taken for the wheel's. It may be a ripple as well: at {sections} per turn it "
        "takes more than {nyquist} edges per revolution to see it whole, and the wheel has {wheel_edges}.",
        "Take the speed for its mean over a ripple, or a wheel with more sectors."),
)
DOUBT = (
    Rule("hidden_ripple", "The wheel's offsets may hide a ripple",
        "The edges of the wheel lie elsewhere. A ripple of the speed with {hidden_orders} periods per turn may cause a "
        "part of it: at every mean speed it makes the same offsets. So {hidden_ripple} is part of the standard "
        "deviation of the speed.",
        "Give the measured widths in [sensor] widths, if they are known."),
)
PATTERN = (
    Rule("period", "Perhaps a wrong number of sectors",
        "The innovations repeat after {period} edges (correlation {correlation:.2f}), not after {sectors} "
        "({own_correlation:.2f}), and speed variation does not explain it.",
        "Count the sectors of the wheel; bright and dark ones together, {period} would fit.", Grade.BAD),
    Rule("bias", "The threshold is off",
        "Rising edges come {late} and falling ones {early} by {bias}, {bias_percent:.2g} % of a sector.",
        "{move_threshold}; bright sectors that are really wider or narrower than dark ones look the same."),
    Rule("far", "Edges lie elsewhere on the wheel",
        "Edge {worst} lies {far} {way} its place, {far_percent:.2g} % of a sector. {cause}",
        "Give the measured widths in [sensor] widths; the offsets of all edges stand in the report."),
)
NO_RESULT = (
    Rule("jumping", "",
        "channel {channel!r} goes through {jumping:.0f} % of its range from one sample to the next: there are too few "
        "samples for each sector (three at least are needed to see where the wave rises and falls), or it is noise",
        "sample faster, or give threshold.level in a config"),
    Rule("no_level", "",
        "channel {channel!r} does not go up and down between two levels, so there is no threshold and no edge",
        "name the right channel, or give threshold.level in a config"),
    Rule("no_samples", "", "channel {channel!r} has no samples", ""),
    Rule("fractions", "",
        "{found}, and {fractions} of its {samples} values are no whole numbers, so it is no counter",
        "if it is a wave, name it with --wave"),
    Rule("out_of_range", "", "no edges of {channel!r} lie in the time range that was asked for", ""),
    Rule("backward", "",
        "{found}, but time runs backwards there, {backward} times", "{needed}, and in the order of time"),
    Rule("few_steps", "", "{found}, in only {left_out} steps", "{needed}, so read the counter faster"),
    Rule("apart", "",
        "{found}, {apart:.4g} s apart on average: the shaft is not rotating",
        "look at the unit of the times ({needed} with less than {longest:g} s between them)"),
    Rule("too_few", "", "{found}", "{needed}"),
)
"""Why there is no estimate: the first that holds."""
# fmt: on
GRANTED = (Rule("remarks", "Taken for granted", "{it}.", "Nothing to do, if that is right."),)


def tell(rules: tuple[Rule, ...], facts: Mapping[str, object]) -> Iterator[Finding]:
    """The findings of those `rules` whose fact holds."""
    for rule in rules:
        fact = facts.get(rule.fact)
        for it in fact if isinstance(fact, list) else [fact] if fact else []:
            text, remedy = (words.format(it=it, **facts) for words in (rule.text, rule.remedy))
            yield Finding(title=rule.title, text=text, remedy=remedy, grade=rule.grade)


def explain_no_result(tally: Tally, wanted: Estimation) -> str:
    """The reason why there is no estimate."""
    told = next(tell(NO_RESULT, no_result_facts(tally, wanted)))
    return f"{told.text}; {told.remedy}" if told.remedy else told.text


def findings(found: Mapping[str, object], sums: Sums, wanted: Estimation, log: Log) -> tuple[Finding, ...]:
    """What is wrong with the record or in doubt, gravest first."""
    best = sums.explained
    clock = [*tell(CLOCK, clock_facts(best, wanted, log))]
    first = () if clock else tell(WHEEL, wheel_facts(found, sums, wanted))
    told = [*clock, *tell(RECORD, record_facts(found, sums, wanted))]
    if not clock:
        pattern = [*tell(PATTERN, pattern_facts(sums, wanted))]
        sure = best is not None and not numbers_in_doubt(best, sums, wanted)
        settings = [*tell(SETTINGS, settings_facts(best, wanted))] if best is not None and sure else []
        wheel_first = best is not None and best.wheel_gain > best.settings_gain
        told += pattern + settings if wheel_first else settings + pattern
        told += tell(DOUBT, doubt_facts(sums)) if sure else ()
    told += tell(GRANTED, {"remarks": list(log.remarks)})
    return (*first, *sorted(told, key=lambda finding: finding.grade is not Grade.BAD))
