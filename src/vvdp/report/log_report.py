"""The report of an estimation from a log, from its result directory to a page that stands alone."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.display import fixed, number, percent, plain
from vvdp.base.units import ATMOSPHERE
from vvdp.logs.kept import Finding, Kept, read_kept
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, row, table, text
from vvdp.report.log_figures import RPM, log_figures
from vvdp.report.page import opening, write_page

BAR = 1e5

FORM = ("", "n", "u")
SOURCES = {"wave": "a photodiode's wave", "counts": "a counter", "edges": "a column of edge times"}


def write_log_report(directory: Path) -> Path:
    """Writes report.html and figures/ into the result directory of an estimation and gives the path of the page.

    All is made from the files in the directory; made again, it has the same bytes.
    Raises ConfigError where the directory is no result of an estimation.
    """
    kept = read_kept(directory)
    drawn = tuple(log_figures(kept))
    return write_page(directory, _page(kept, drawn), drawn)


def _page(kept: Kept, drawn: tuple[Drawn, ...]) -> Iterator[str]:
    log = Path(str(kept.meta.get("log", "log"))).name
    title = f"Angle and speed from {text(log)}"
    yield opening(title)
    yield f'<h1>{title}</h1>\n<p class="facts">{" &middot; ".join(_facts(kept))}</p>'
    marks = "".join(f'<li class="{grade}">{text(words)}</li>' for words, grade in _badges(kept))
    yield f'<ul class="badges">{marks}</ul>'
    for finding in kept.findings:
        if finding.grave:
            yield _notice(finding)
    yield f'<p class="lead">{text(_in_words(kept))}</p>'
    yield f'<section class="together">\n<h2>Key numbers</h2>\n{_key_numbers(kept)}\n</section>'
    minor = [finding for finding in kept.findings if not finding.grave]
    if minor:
        yield "<h2>Findings</h2>"
        yield from (_notice(finding) for finding in minor)
    yield "<h2>Figures</h2>"
    for place, each in enumerate(drawn, 1):
        yield figure(each.svg, each.name, place, text(each.caption))
    yield "<h2>Edges of the wheel</h2>"
    yield _wheel_table(kept)
    yield "<h2>Settings</h2>\n<p>As a config for the next estimation, with all defaults.</p>"
    yield f'<pre class="keys">{text(kept.config)}</pre>'
    yield f'<p class="small">SHA-256 of the log: <span class="keys">{text(kept.meta.get("log_sha256", "-"))}</span></p>'
    yield "</body>\n</html>"


def _facts(kept: Kept) -> Iterator[str]:
    yield f"{plain(_of(kept, 'duration_s'), 5)} s of log"
    yield f"edges from {SOURCES.get(str(kept.summary.get('edge_source')), 'a log')}"
    yield _date(kept.meta.get("written"))
    yield f"vvdp {text(kept.meta.get('vvdp', '-'))}"


def _date(date: Any) -> str:
    try:
        when = datetime.fromisoformat(str(date))
    except ValueError:
        return "date not recorded"
    return f"{when.day} {when:%B %Y, %H:%M}"


def _of(kept: Kept, key: str) -> float:
    value = kept.summary.get(key)
    return float("nan") if value is None else float(value)


def _badges(kept: Kept) -> Iterator[tuple[str, str]]:
    grave = sum(finding.grave for finding in kept.findings)
    if grave:
        yield (f"{grave} grave finding{'s' if grave > 1 else ''}", "bad")
    if not kept.summary.get("finished", True):
        yield ("interrupted", "bad")
    fits = kept.summary.get("settings_fit")
    if fits is not None:
        yield ("settings of the filter fit", "good") if fits else ("settings of the filter do not fit", "warn")
    missed = _of(kept, "missed_edges")
    yield ("no edge missed", "good") if not missed else (f"{_count(missed, 'edge')} missed", "warn")
    index = kept.summary.get("index_found")
    if index is not None:
        yield ("index found", "good") if index else ("index not found", "bad")
    else:
        yield ("no index on the wheel", "")
    if kept.summary.get("commensurate"):
        yield ("edges in step with the clock", "bad")


def _count(number_of: float, word: str) -> str:
    return f"{plain(number_of)} {word}{'' if number_of == 1 else 's'}"


def _notice(finding: Finding) -> str:
    grade = "notice bad" if finding.grave else "notice"
    words = f"<p>{text(finding.found)}</p><p>{text(finding.remedy)}</p>"
    return f'<div class="{grade}"><strong>{text(finding.title)}</strong>{words}</div>'


def _in_words(kept: Kept) -> str:
    speed, spread = _of(kept, "spool_speed_mean_rad_s") / RPM, _of(kept, "spool_speed_std_rad_s") / RPM
    counted = f"{_count(_of(kept, 'edges'), 'edge')} of a wheel with {plain(_of(kept, 'sectors'))} sectors"
    missed = _of(kept, "missed_edges")
    without = f", {plain(missed)} more did not show" if missed else ""
    settled = (
        f"The angle is known to {number(_of(kept, 'angle_deviation_mean_rad'), 3)} rad and the speed to "
        f"{number(_of(kept, 'speed_deviation_mean_rad_s') / RPM, 3)} rpm (one standard deviation)."
        if kept.summary.get("settled")
        else "The record is too short for the filter to settle."
    )
    return (
        f"In {plain(_of(kept, 'duration_s'), 4)} s, {counted} passed{without}. The spool turned at {fixed(speed, 1)} "
        f"rpm on average, standard deviation {number(spread, 3)} rpm, which is a PWM frequency of "
        f"{fixed(_of(kept, 'pwm_frequency_mean_Hz'), 2)} Hz. {settled}"
    )


def _key_numbers(kept: Kept) -> str:
    def line(name: str, key: str, unit: str = "", scale: float = 1.0, digits: int = 5, offset: float = 0.0) -> str:
        value = (_of(kept, key) - offset) / scale
        return row([name, plain(value, digits) if np.isfinite(value) else "–", unit], FORM)

    def part(title: str, lines: list[str]) -> str:
        return f"<div><h3>{title}</h3>\n<table><tbody>\n" + "\n".join(lines) + "\n</tbody></table></div>"

    speed = [
        line("Spool speed, mean", "spool_speed_mean_rad_s", "rpm", RPM),
        line("Spool speed, standard deviation", "spool_speed_std_rad_s", "rpm", RPM, 3),
        line("Spool speed, lowest", "spool_speed_min_rad_s", "rpm", RPM),
        line("Spool speed, highest", "spool_speed_max_rad_s", "rpm", RPM),
        line("PWM frequency, mean", "pwm_frequency_mean_Hz", "Hz"),
        line("Deviation of the angle, mean", "angle_deviation_mean_rad", "rad", digits=3),
        line("Deviation of the speed, mean", "speed_deviation_mean_rad_s", "rpm", RPM, 3),
    ]
    edges = [
        line("Edges", "edges", digits=9),
        line("Missed edges", "missed_edges", digits=9),
        line("Double edges", "double_edges", digits=9),
        line("Pieces of the record", "pieces", digits=9),
        line("Squared innovations, mean", "nis_mean", digits=3),
        line("acceleration_density of the filter", "acceleration_density_rad2_s3", "rad²/s³", digits=3),
        line("edge_variance of the filter", "edge_variance_rad2", "rad²", digits=3),
        line("Largest offset of an edge", "edge_offset_max_rad", "rad", digits=3),
    ]
    record = [
        line("Length of the log", "duration_s", "s"),
        line("Samples", "samples", digits=12),
        line("Sample rate", "sample_rate_Hz", "Hz"),
        line("Rate of the result", "output_rate_Hz", "Hz"),
        line("Gaps", "gaps", digits=9),
        line("Samples that are no numbers", "not_numbers", digits=9),
    ]
    parts = [part("Speed", speed), part("Edges", edges), part("Record", record)]
    other = []
    if "threshold" in kept.summary:
        other += [
            line("Threshold", "threshold", digits=4),
            line("Threshold, suggested", "threshold_suggested", digits=4),
            line("Swing of the wave", "wave_swing", digits=4),
            line("Noise of the wave", "wave_noise", digits=3),
        ]
    if "threshold_bias_rad" in kept.summary:
        other.append(line("Rising edges late by", "threshold_bias_rad", "rad", digits=3))
    if "duty_ratio_mean" in kept.summary:
        other += [
            line("Duty ratio of the pressure, mean", "duty_ratio_mean", digits=3),
            line("Duty ratio, standard deviation", "duty_ratio_std", digits=3),
            line("Inlet pressure, mean", "inlet_pressure_mean_Pa", "bar", BAR, 4, ATMOSPHERE),
            line("Inlet pressure, lowest", "inlet_pressure_min_Pa", "bar", BAR, 4, ATMOSPHERE),
            line("Inlet pressure, highest", "inlet_pressure_max_Pa", "bar", BAR, 4, ATMOSPHERE),
        ]
    if other:
        parts.append(part("Signals", other))
    return '<div class="columns">\n' + "\n".join(parts) + "\n</div>"


def _wheel_table(kept: Kept) -> str:
    offsets, errors, counts = (kept.column(f"wheel/{name}") for name in ("offset", "offset_deviation", "edges"))
    sector = 2.0 * np.pi / offsets.size
    names = ("rising", "falling") if np.any(kept.column("edges/polarity") != 0.0) else ("even", "odd")
    rows = [
        row(
            [
                f"{i} ({names[i % 2]})",
                plain(float(counts[i])),
                fixed(1e3 * float(offsets[i]), 2),
                fixed(1e3 * float(errors[i]), 2),
                percent(float(offsets[i]) / sector, 2),
            ],
            ("", "n", "n", "n", "n"),
        )
        for i in range(min(offsets.size, 64))
    ]
    head = ["Edge of the wheel", "edges", "offset mrad", "standard error mrad", "of a sector"]
    return table(head, rows, (1, 2, 3, 4))
