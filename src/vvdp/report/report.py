"""The report of a run, from its result directory to a page that can be printed."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from vvdp.report.diagram import circuit_diagram
from vvdp.report.drawing import Drawn
from vvdp.report.figures import figures
from vvdp.report.html import figure, text
from vvdp.report.page import opening, write_page
from vvdp.report.reading import Reading, reading
from vvdp.report.references import bibliography
from vvdp.report.tables import (
    assumed_table,
    balances,
    key_numbers,
    loss_tables,
    parameter_table,
    reference_list,
    share_of_assumed,
)
from vvdp.report.verdict import badges, in_words, notices, range_notes

DIAGRAM = "circuit"


def write_report(directory: Path) -> Path:
    """Writes report.html and figures/ into a result directory and gives the path of the page.

    All is made from the files in the directory; made again, it has the same bytes.
    Raises ConfigError where the directory is no result directory or the system in it cannot be read.
    """
    read = reading(directory)
    diagram, drawn = circuit_diagram(read), tuple(figures(read))
    return write_page(directory, _page(read, diagram, drawn), drawn, {DIAGRAM: diagram})


def _page(read: Reading, diagram: str, drawn: tuple[Drawn, ...]) -> Iterator[str]:
    title = text(read.system.title)
    yield opening(title)
    yield from _head(read, title)
    yield "<h2>Circuit</h2>"
    caption = (
        "The bench with the values of this run. Pressures are gauge; flows are counted in volumes at tank conditions."
    )
    yield figure(diagram, DIAGRAM, 1, caption)
    yield '<section class="together">\n<h2>Key numbers</h2>'
    means = "Means over the averaging window; lowest and highest over every step of the run, its start included."
    yield f'<p class="small">{means}</p>'
    yield f"{key_numbers(read)}\n</section>"
    yield from _course(drawn)
    yield from _losses(read, drawn)
    yield "<h2>Computation</h2>\n<p>A residual above the limit marks the run as not to be trusted.</p>"
    yield balances(read)
    yield from _origin(read)
    yield "</body>\n</html>"


def _head(read: Reading, title: str) -> Iterator[str]:
    meta = read.results.meta
    name = f"System <b>{text(read.system.name)}</b>, " if read.system.name else ""
    circuit = f"circuit {text(read.system.circuit)}"
    facts = [f"{name}{circuit}", _date(meta.get("written")), f"vvdp {text(meta['vvdp'])}"]
    yield f'<h1>{title}</h1>\n<p class="facts">{" &middot; ".join(facts)}</p>'
    marks = "".join(
        f'<li class="{b.grade}">{text(b.words)}</li>' if b.grade else f"<li>{text(b.words)}</li>" for b in badges(read)
    )
    yield f'<ul class="badges">{marks}</ul>'
    for notice in notices(read):
        grade = "notice bad" if notice.grave else "notice"
        words = f"<p>{text(notice.found)}</p><p>{text(notice.remedy)}</p>"
        yield f'<div class="{grade}"><strong>{text(notice.title)}</strong>{words}</div>'
    yield f'<p class="lead">{text(in_words(read))}</p>'


def _date(date: Any) -> str:
    if not date:
        return "date of the run not recorded"
    try:
        when = datetime.fromisoformat(str(date))
    except ValueError:
        return f"run of {text(date)}"
    zone = f" {when.tzname()}" if when.tzinfo else ""
    return f"run of {when.day} {when:%B %Y, %H:%M}{zone}"


def _course(drawn: tuple[Drawn, ...]) -> Iterator[str]:
    yield '<h2 class="page">Course of the run</h2>'
    shown = [each for each in drawn if each.name != "losses"]
    for number, each in enumerate(shown, 2):
        yield figure(each.svg, each.name, number, text(each.caption))
    if not any(each.name == "spectrum" for each in drawn):
        yield '<p class="small">No spectrum: too few finely recorded rows.</p>'


def _losses(read: Reading, drawn: tuple[Drawn, ...]) -> Iterator[str]:
    yield '<h2 class="page">Losses</h2>'
    yield from (
        figure(each.svg, each.name, len(drawn) + 1, text(each.caption)) for each in drawn if each.name == "losses"
    )
    yield loss_tables(read)
    if "analytic_loss_total_W" not in read.results.summary:
        yield "<p>There are no analytic losses here: they need a running pump and a load pressure above the tank's.</p>"
        return
    yield (
        "<p>The analytic formulas count volumes (the oil keeps its volume under pressure), with ideal conditions: "
        "constant load pressure, an ideal relief valve, ports that open at constant speed. Differences of 1 to 2 % are "
        "to be expected. Their sum is an upper estimate, because part of the compression happens while flow would be "
        "lost over the relief valve anyway. In the simulation compression shows as throttling, so it is counted within "
        "the transition.</p>"
    )
    if read.varies:
        yield "<p>Something prescribed changes during this run; the analytic values belong to its start.</p>"
    if read.supply.spool_drive.coupling > 0.0:
        yield "<p>The analytic values are those of a spool that nothing drives but the flow.</p>"
    if notes := range_notes(read):
        yield '<div class="notice"><strong>The analytic transition loss is in doubt here</strong>'
        yield "".join(f"<p>{text(note[:1].upper() + note[1:])}.</p>" for note in notes) + "</div>"


def _origin(read: Reading) -> Iterator[str]:
    known = bibliography()
    yield f"<h2>Assumed values</h2>\n<p>{share_of_assumed(read)} are merely assumed. Results hang on them.</p>"
    if read.system.assumed:
        yield assumed_table(read)
    yield "<h2>Parameters</h2>"
    levels = "Pressure levels are gauge, against 1.01325 bar, unless marked abs."
    yield f'<p class="small">{levels} Given: by the user, without a source.</p>'
    yield parameter_table(read, known)
    yield f"<h2>References</h2>\n{reference_list(read, known)}"
