"""The report of a run, from its result directory to a page that can be printed."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from vvdp.report.bench_contents import BenchContents
from vvdp.report.circuit import graph_of
from vvdp.report.contents import Contents
from vvdp.report.diagram import diagram
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, text
from vvdp.report.page import opening, write_page
from vvdp.report.reading import Reading, reading
from vvdp.report.references import bibliography
from vvdp.report.tables import (
    assumed_table,
    balances,
    component_table,
    node_table,
    parameter_table,
    reference_list,
    share_of_assumed,
)
from vvdp.report.verdict import remarks
from vvdp.systems.bench import RotaryBench

DIAGRAM = "circuit"


def write_report(directory: Path) -> Path:
    """Writes report.html and figures/ into a result directory and gives the path of the page.

    All is made from the files in the directory; made again, it has the same bytes.
    Raises ConfigError where the directory is no result directory or the system in it cannot be read.
    """
    read = reading(directory)
    shown = contents(read)
    course, losses = tuple(shown.course()), tuple(shown.losses())
    drawing = diagram(graph_of(read.network, read.system.title), shown.values())
    return write_page(directory, _page(shown, drawing, course, losses), (*course, *losses), {DIAGRAM: drawing})


def contents(read: Reading) -> Contents:
    """What the page shows of what was simulated."""
    extras = read.system.extras
    return BenchContents(read, extras) if isinstance(extras, RotaryBench) else Contents(read)


def _page(shown: Contents, drawing: str, course: tuple[Drawn, ...], losses: tuple[Drawn, ...]) -> Iterator[str]:
    read = shown.reading
    title = text(read.system.title)
    yield opening(title)
    yield from _head(shown, title)
    yield "<h2>Circuit</h2>"
    yield figure(drawing, DIAGRAM, 1, shown.circuit_caption())
    yield '<section class="together">\n<h2>Key numbers</h2>'
    means = "Means over the averaging window; lowest and highest over every step of the run, its start included."
    yield f'<p class="small">{means} Pressures are gauge.</p>'
    yield f"{shown.key_numbers()}\n</section>"
    yield f"<h3>Nodes</h3>\n{node_table(read)}\n<h3>Components</h3>\n{component_table(read)}"
    yield from _course(shown, course)
    yield '<h2 class="page">Losses</h2>'
    yield from (figure(each.svg, each.name, len(course) + 2, text(each.caption)) for each in losses)
    yield shown.loss_tables()
    yield "<h2>Computation</h2>\n<p>A residual above the limit marks the run as not to be trusted.</p>"
    yield balances(read)
    if found := remarks(read):
        yield f"<h3>Remarks of the run</h3>\n<ul>{''.join(f'<li>{text(remark)}</li>' for remark in found)}</ul>"
    yield from _origin(read)
    yield from _equations(read)
    yield "</body>\n</html>"


def _equations(read: Reading) -> Iterator[str]:
    """The text that the circuit is made into, folded away."""
    yield "<h2>Equations</h2>\n<p>The network as it is written out and simulated.</p>"
    words = "Show the text of the circuit"
    yield f'<details class="code"><summary>{words}</summary>\n<pre>{text(read.system.circuit.text)}</pre></details>'


def _head(shown: Contents, title: str) -> Iterator[str]:
    read = shown.reading
    meta = read.results.meta
    name = f"System <b>{text(read.system.name)}</b>, " if read.system.name else ""
    circuit = f"circuit {text(read.system.circuit_name)}"
    facts = [f"{name}{circuit}", _date(meta.get("written")), f"vvdp {text(meta['vvdp'])}"]
    yield f'<h1>{title}</h1>\n<p class="facts">{" &middot; ".join(facts)}</p>'
    marks = "".join(
        f'<li class="{b.grade}">{text(b.words)}</li>' if b.grade else f"<li>{text(b.words)}</li>"
        for b in shown.badges()
    )
    yield f'<ul class="badges">{marks}</ul>'
    for notice in shown.notices():
        grade = "notice bad" if notice.grave else "notice"
        words = f"<p>{text(notice.found)}</p><p>{text(notice.remedy)}</p>"
        yield f'<div class="{grade}"><strong>{text(notice.title)}</strong>{words}</div>'
    yield f'<p class="lead">{text(shown.in_words())}</p>'


def _date(date: Any) -> str:
    if not date:
        return "date of the run not recorded"
    try:
        when = datetime.fromisoformat(str(date))
    except ValueError:
        return f"run of {text(date)}"
    zone = f" {when.tzname()}" if when.tzinfo else ""
    return f"run of {when.day} {when:%B %Y, %H:%M}{zone}"


def _course(shown: Contents, drawn: tuple[Drawn, ...]) -> Iterator[str]:
    yield '<h2 class="page">Course of the run</h2>'
    for number, each in enumerate(drawn, 2):
        yield figure(each.svg, each.name, number, text(each.caption))
    yield shown.remark_on_course(drawn)


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
