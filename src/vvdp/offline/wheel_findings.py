"""What a person is told of how the wheel was taken: its sectors, polarity, direction and index, aliases, stops."""

from collections.abc import Iterator, Mapping
from typing import Any

from vvdp.base.display import with_unit
from vvdp.base.kinds import SPEED
from vvdp.offline.config import Estimation, Stamps, Wave
from vvdp.offline.hypotheses import Sectors, Verdict
from vvdp.offline.sums import Sums
from vvdp.results.result import Finding, Grade
from vvdp.sensing.wheel import TURN

ALIAS_SAMPLES = 4.0
"""With fewer samples for each sector, and no index that fits, the wave may be one of a faster wheel."""
ALIASES = 3
NAMED = 3
"""So many times are named; the rest is counted."""


def warning(title: str, text: str, remedy: str) -> Finding:
    """A finding that may matter."""
    return Finding(title=title, text=text, remedy=remedy, grade=Grade.WARNING)


def grave(title: str, text: str, remedy: str) -> Finding:
    """A finding that does."""
    return Finding(title=title, text=text, remedy=remedy, grade=Grade.BAD)


def wheel_findings(found: Mapping[str, Any], sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    """What the speed stands on, before everything else: which wheel it was, which way it turned, aliases."""
    verdict = sums.verdict
    if verdict is None:
        return
    yield from _alias(found, sums, wanted)
    yield from _sectors(verdict)
    if wanted.sectors_assumed and not found["index_found"]:
        yield _sectors_assumed(verdict, sums)
    if found["index_found"] is False and verdict.likeliest.sectors is not Sectors.ONE_KIND:
        yield _index_not_found(verdict, sums)
    if verdict.likeliest.polarity < 0.0:
        yield _wave_inverted(verdict, wanted)
    if verdict.likeliest.direction < 0.0 and not sums.reversals:
        yield _backwards(verdict)
    for time in sums.reversals[:NAMED]:
        yield warning(
            "The spool reversed",
            f"At about {time:.4g} s the spool reversed: from there on the edges follow each other in mirrored order.",
            "Angle and speed have the sign of the direction.",
        )
    if len(sums.reversals) > NAMED:
        yield warning("The spool reversed", f"And {len(sums.reversals) - NAMED} times more.", "See piece and speed.")
    if not found["index_found"]:
        yield from _perhaps_back(sums)


def _sectors(verdict: Verdict) -> Iterator[Finding]:
    told, edges, by = len(verdict.described.edges), len(verdict.likeliest.edges), f"ln L {verdict.gain:+.3g}"
    if verdict.likeliest.sectors is Sectors.ONE_KIND:
        if edges % 2:
            yield grave(
                "Edges of one kind only",
                f"By their index {edges} edges pass in a turn, not {told}: rising edges only, or falling ones ({by}). "
                f"The speed is {told / edges:g} times what is shown.",
                "Log all edges: an odd number of them in a turn cannot be followed.",
            )
        else:
            yield warning(
                "Edges of one kind only",
                f"By their index {edges} edges pass in a turn, not {told}: rising edges only, or falling ones "
                f"({by}); {edges} edges a turn were taken.",
                f"Nothing to do, if that is so. If really {told} pass, look at index_shift or widths.",
            )
    elif verdict.likeliest.sectors is not Sectors.AS_TOLD:
        yield warning(
            "Another number of sectors",
            f"By their index {edges} edges pass in a turn, not {told} ({by}); {edges} sectors were taken.",
            f"Give --sectors {edges}, if that is so. If really {told} pass, look at index_shift or widths.",
        )


def _sectors_assumed(verdict: Verdict, sums: Sums) -> Finding:
    n = sums.sectors
    return warning(
        "Sectors assumed",
        f"No number of sectors was given: {n} sectors were assumed, {n} edges a turn. Were rising edges alone logged, "
        f"{n // 2} a turn, the speed is twice what is shown; with another number of edges a turn it is {n} over that "
        "number times what is shown.",
        "Count the bright and dark sectors of the wheel and give --sectors.",
    )


def _index_not_found(verdict: Verdict, sums: Sums) -> Finding:
    told = len(verdict.described.edges)
    if verdict.index_shows is False or all(each.index_found for each in sums.alignments):
        words = "The edges are explained better by a wheel whose sectors are all alike"
    else:
        words = (
            "No first edge makes the turns agree with the sectors of the wheel; the angle is counted from an edge that "
            "was chosen"
        )
    return grave(
        "Index not found",
        f"{words}. So nothing confirms that {told} edges pass in a turn: with half or twice as many the speed is twice "
        "or half of what is shown.",
        f"Look at index_shift or widths, at the number of sectors ({told}), and whether rising and falling edges were "
        "both logged.",
    )


def _wave_inverted(verdict: Verdict, wanted: Estimation) -> Finding:
    remedy = "An index on an edge of the other polarity looks the same; then nothing is to be done."
    if isinstance(wanted.source, Wave):
        value = "true" if wanted.source.comparator.inverted else "false"
        remedy = f"Set inverted = {value} in [sensor]. {remedy}"
    elif isinstance(wanted.source, Stamps):
        remedy = f"Exchange --edges and --falling. {remedy}"
    return warning(
        "The wave is inverted",
        f"By the index of the wheel rising edges are falling ones (ln L {verdict.gain:+.3g}); they were exchanged.",
        remedy,
    )


def _backwards(verdict: Verdict) -> Finding:
    wheel = verdict.described
    shift = wheel.edges[1] * len(wheel.edges) / TURN - 1.0
    return warning(
        "The spool turns backwards",
        f"The edges follow each other in mirrored order (ln L {verdict.gain:+.3g}): the spool turns backwards, the "
        "angle falls, and the speed is negative.",
        "An index that is shifted the other way looks the same: if the spool turns forward, give an index_shift of "
        f"{-shift:.3g}, or the widths in the other order.",
    )


def _alias(found: Mapping[str, Any], sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    speed = sums.pace.mean
    if not isinstance(wanted.source, Wave) or not sums.period or not speed > 0.0 or found["index_found"]:
        return
    per_sector = TURN / sums.sectors / speed / sums.period
    if per_sector >= ALIAS_SAMPLES:
        return
    # A wave of f makes the same samples as one of k f_s - f or k f_s + f.
    full = 2.0 * TURN / sums.sectors / sums.period
    others = sorted(k * full + sign * speed for k in range(1, ALIASES) for sign in (-1.0, 1.0))[:ALIASES]
    yield warning(
        "Perhaps an alias",
        f"There are only {per_sector:.2g} samples for each sector. If edges come as fast as samples or faster, the "
        f"speed is an alias: {', '.join(with_unit(each, SPEED, 4) for each in others)} make the same samples as "
        f"{with_unit(speed, SPEED, 4)}.",
        "Sample faster, ten times for each sector.",
    )


def _perhaps_back(sums: Sums) -> Iterator[Finding]:
    times = sums.slow_passages
    if times:
        yield warning(
            "Perhaps turned back",
            f"At about {_enumerate([f'{time:.4g} s' for time in times])} the spool nearly stood still: the wheel "
            "cannot tell whether it turned back.",
            "Speed and angle are those of a spool that turns on. A wheel with an index would tell.",
        )


def motion_findings(sums: Sums) -> Iterator[Finding]:
    """Stretches in which the spool stood still."""
    if sums.standstills:
        stretches = [f"from {begin:.4g} to {end:.4g} s" for begin, end in sums.standstills]
        yield warning(
            "Standstill",
            f"The spool stood still {_enumerate(stretches)}.",
            "Nothing to do, if so. A sensor that falls silent looks the same.",
        )


def _enumerate(words: list[str]) -> str:
    more = len(words) - NAMED
    return ", ".join(words[:NAMED]) + (f", and {more} times more" if more > 0 else "")
