"""The page of a result: one layout for all that vvdp finds, from the files in its directory."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from vvdp.base.kinds import GAUGE_PRESSURE, PRESSURE_LEVEL
from vvdp.base.manifest import open_directory
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, group, row, share_letters, table, text
from vvdp.report.interactive import live_body, live_head
from vvdp.report.page import opening, write_page
from vvdp.report.plot import draw_chart, paper_chart
from vvdp.report.references import bibliography
from vvdp.results.cells import column_head, row_unit, shown_cell, shown_columns, table_cell, thinned_rows
from vvdp.results.result import Finding, Grade, Listing, Result, Row, Section, Table
from vvdp.results.store import read_meta, read_result

MOST_SPACED, MOST_BESIDE = 6, 3
"""Columns of a listing that stand wide apart, and with which it has room beside another one."""
LEAD = "Result"
"""Title of the section at the head of a page."""
MOST_LEAD, MOST_OPEN = 12, 3
"""Lines of a listing that may lead a page, and notes of its box that are not folded."""
LONG = 12
"""Lines of a listing from which on it is better halved."""


@dataclass(frozen=True)
class Additions:
    """Additions of scripts to a page beside the charts: for its head, its style, above its sections and at its end.

    opened  what is shown by sections that are not folded
    """

    head: str = ""
    style: str = ""
    begin: str = ""
    end: str = ""
    opened: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Page:
    """Content of a page. `ready` is HTML that sections name, placed before that of the result, `drawings` ready SVG."""

    result: Result
    meta: Mapping[str, Any]
    ready: Mapping[str, str] = field(default_factory=dict)
    drawings: Mapping[str, Drawn] = field(default_factory=dict)
    added: Additions = field(default_factory=Additions)


def write_result_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of a result and gives the path of the page.

    Raises ConfigError where the directory holds no result.
    """
    opened = open_directory(directory)
    return write_result_page(directory, Page(read_result(opened), read_meta(opened)))


def write_result_page(directory: Path, page: Page) -> Path:
    """Writes a page and the files of its figures into `directory`."""
    result = page.result
    charts = ((name, paper_chart(chart, result.tables)) for name, chart in result.charts.items())
    drawn = {name: draw_chart(chart, result.tables) for name, chart in charts} | dict(page.drawings)
    return write_page(directory, [share_letters("\n".join(_lines(page, drawn)))], tuple(drawn.values()))


def _lines(page: Page, drawn: Mapping[str, Drawn]) -> Iterator[str]:
    result, added = page.result, page.added
    title = text(result.title)
    sections = (*_lead(result), *(result.sections or usual_sections(result)))
    yield f"{opening(title, added.style, added.head or live_head())}\n<h1>{title}</h1>"
    yield f'<p class="facts">{" &middot; ".join(_facts(page))}</p>'
    if result.badges:
        marks = (f'<li class="{each.grade}">{text(each.words)}</li>' for each in result.badges)
        yield f'<ul class="badges">{"".join(marks)}</ul>'
    yield from _state(result)
    yield from _notes(result)
    yield from filter(None, [added.begin])
    sections = tuple(_without_repetition(sections))
    yield _contents(sections)
    figures = [name for section in sections for name in section.shows if name in drawn]
    numbers = {name: place for place, name in enumerate(figures, 1)}
    for section in sections:
        parts = [_part(page, drawn, name, numbers.get(name, 0)) for name in section.shows]
        fold = None if section.title == LEAD else _fold(is_open=not added.opened.isdisjoint(section.shows))
        yield from _section(section, parts, fold)
    yield from _references(result.references)
    yield live_body(result.charts.values(), result.tables)
    yield from filter(None, [added.end])
    yield "</body>\n</html>"


def _lead(result: Result) -> Iterator[Section]:
    """The head of a page whose result has none of its own: a short listing or table, and the first figure."""
    if result.sections and result.sections[0].title == LEAD:
        return
    order = [name for section in result.sections for name in section.shows]
    order += [name for name in (*result.charts, *result.listings, *result.tables) if name not in order]
    charts = [name for name in order if name in result.charts]
    short = [name for name in order if 0 < _lines_of(result, name) <= MOST_LEAD]
    if charts or short:
        yield Section(title=LEAD, shows=(*short[:1], *charts[:1]))


def _lines_of(result: Result, name: str) -> int:
    """Lines of a listing, or of a table that pages show; 0 for anything else."""
    if name in result.listings:
        return len(result.listings[name].rows)
    found = result.tables.get(name)
    return 0 if found is None or found.is_data else found.rows


def _without_repetition(sections: Sequence[Section]) -> Iterator[Section]:
    """The sections without what an earlier one shows, and without those that are then empty."""
    before = set[str]()
    for section in sections:
        left = replace(section, shows=tuple(name for name in section.shows if name not in before))
        before.update(section.shows)
        if left.shows or left.words or left.text:
            yield left


def _fold(*, is_open: bool) -> str:
    return f'<details class="fold"{" open" if is_open else ""}>'


def _section(section: Section, parts: Sequence[str], fold: str | None) -> Iterator[str]:
    """The lead of the page, or a section in a `fold` that is opened by its links and in print."""
    body = [f"<p>{text(words)}</p>" for words in section.words] + list(parts)
    if section.text:
        body.append(f'<pre class="keys">{text(section.text)}</pre>')
    heading = f"<h2{' class=page' if section.starts_page else ''}>{text(section.title)}</h2>"
    if fold is None:
        yield f'{heading}\n<section id="{_anchor(section)}">'
        yield from body
        yield "</section>"
    else:
        yield f'{fold}<summary>{heading}</summary>\n<section id="{_anchor(section)}">'
        yield from body
        yield "</section></details>"


def usual_sections(result: Result) -> Iterator[Section]:
    """How it was done, all figures, then all listings and tables: the order where a result gives none."""
    shown = tuple(name for name, each in result.tables.items() if not each.is_data)
    if result.charts:
        yield Section(title="Figures", shows=tuple(result.charts))
    if result.listings:
        yield Section(title="Numbers", shows=tuple(result.listings))
    if result.manner:
        yield Section(title="How it was done", words=(result.manner,), shows=("conditions",))
    for name in shown:
        yield Section(title=result.tables[name].title, shows=(name,), starts_page=True)


def _facts(page: Page) -> Iterator[str]:
    result, meta = page.result, page.meta
    yield from (f"{label} <b>{text(meta[key])}</b>" for key, label in (("project", "Project"), ("customer", "For"))
                if meta.get(key))  # fmt: skip
    if result.system:
        yield f"System <b>{text(result.system)}</b>"
    yield text(str(meta.get("written", ""))[:10])
    yield f"vvdp {text(meta.get('vvdp', ''))}"
    if meta.get("command"):
        yield f"<code>{text(' '.join(map(_quote, meta['command'])))}</code>"


def _quote(word: str) -> str:
    return f'"{word}"' if " " in word or not word else word


def _state(result: Result) -> Iterator[str]:
    if not result.finished:
        words = (
            "<p>Rerun the same command to resume.</p>"
            if result.verb in ("map", "study")
            else "<p>Run it again to complete them.</p>"
        )
        yield f'<div class="notice bad"><strong>Run interrupted: results are partial</strong>{words}</div>'
    yield from (f'<p class="lead">{text(f.text)}</p>' for f in result.findings if f.grade in (Grade.PLAIN, Grade.GOOD))


def _notes(result: Result) -> Iterator[str]:
    """All warnings in one box, the gravest first; those beyond the first few are folded in it."""
    found = [each for grade in (Grade.BAD, Grade.WARNING) for each in result.findings if each.grade is grade]
    if not found:
        return
    notes = [_note(each) for each in found]
    rest = notes[MOST_OPEN:]
    folded = f'<details class="fold"><summary>{len(rest)} more</summary>{"".join(rest)}</details>' if rest else ""
    grade = " bad" if found[0].grade is Grade.BAD else ""
    yield f'<div class="notice{grade}">{"".join(notes[:MOST_OPEN])}{folded}</div>'


def _note(finding: Finding) -> str:
    title = f"<strong>{text(finding.title)}</strong>" if finding.title else ""
    return title + "".join(f"<p>{text(each)}</p>" for each in (finding.text, finding.remedy) if each)


def _contents(sections: Sequence[Section]) -> str:
    links = (f'<a href="#{_anchor(section)}">{text(section.title)}</a>' for section in sections)
    return f'<nav class="contents">{" ".join(links)}</nav>'


def _anchor(section: Section) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in section.title.lower())


def _part(page: Page, drawn: Mapping[str, Drawn], name: str, count: int) -> str:
    """The content of a section under a name."""
    result = page.result
    if name in page.ready:
        return page.ready[name]
    if name in drawn:
        return figure(drawn[name].svg, drawn[name].name, count, text(drawn[name].caption))
    if name in result.listings:
        return listing_html(result.listings[name])
    if name in result.tables:
        return table_html(name, result.tables[name])
    return _conditions(result)


def _conditions(result: Result) -> str:
    rows = [row([text(name), text(value)], ("q", "")) for name, value in result.conditions.items()]
    left = "".join(f"<li>{text(each)}</li>" for each in result.left_out)
    first = f"<div><h3>Conditions</h3>\n{table(('', ''), rows)}\n</div>"
    second = f"\n<div><h3>Left out</h3>\n<ul>{left}</ul></div>" if left else ""
    return f'<div class="columns">\n{first}{second}\n</div>'


def listing_html(listing: Listing) -> str:
    """Quantities of different kinds, a line each, as HTML; on a wide screen narrow ones stand side by side."""
    title = f"<h3>{text(listing.title)}</h3>\n" if listing.title else ""
    note = f'<p class="small">{text(listing.note)}</p>\n' if listing.note else ""
    if not listing.rows:
        return f'{title}<p class="small">None.</p>'
    is_narrow = len(listing.heads) + any(row.note for row in listing.rows) <= MOST_BESIDE
    halves = _halves(listing.rows) if is_narrow else [listing.rows]
    if len(halves) > 1:
        return title + note + "\n".join(f'<div class="beside">{_listing_table(listing, rows)}</div>' for rows in halves)
    body = title + note + _listing_table(listing, listing.rows)
    return f'<div class="beside">{body}</div>' if is_narrow else body


def _halves(rows: Sequence[Row]) -> list[Sequence[Row]]:
    """The lines of a long listing in two parts, parted where a group begins; one part where no group does."""
    begins = [place for place in range(1, len(rows)) if rows[place].group != rows[place - 1].group]
    if len(rows) <= LONG or not begins:
        return [rows]
    middle = min(begins, key=lambda place: abs(2 * place - len(rows)))
    return [rows[:middle], rows[middle:]]


def _listing_table(listing: Listing, rows: Sequence[Row]) -> str:
    noted = any(each.note for each in listing.rows)
    last = listing.unit_place
    names = [*map(text, listing.heads)]
    heads = ["", *names[:last], "", *names[last:], *([""] if noted else [])]
    numeric = [1 + place for place in range(last) if any(_is_number(row, place) for row in rows)]
    lines, before = [], ""
    for each in rows:
        if each.group != before:
            lines.append(group(text(each.group), len(heads)))
            before = each.group
        lines.append(_listing_row(each, last, noted))
    return table(heads, lines, numeric, "listing" if len(listing.heads) <= MOST_SPACED else "wide")


def _is_number(row: Row, place: int) -> bool:
    return row.kind is not None or not isinstance(row.values[place], str)


def _listing_row(each: Row, last: int, noted: bool) -> str:
    """A line with its unit behind `last` values; values behind the unit are words."""
    label = f"&emsp;{text(each.label)}" if each.is_part else text(each.label)
    values = [text(shown_cell(value, each.kind)) for value in each.values]
    cells = [label, *values[:last], text(row_unit(each)), *values[last:]]
    classes = ["", *("n" if _is_number(each, place) else "" for place in range(last)), "u", *[""] * len(values[last:])]
    if noted:
        cells, classes = [*cells, text(each.note)], [*classes, "q"]
    return row(cells, classes, "part" if each.is_part else "sum" if each.is_sum else "")


def table_html(name: str, each: Table) -> str:
    """A table as HTML, thinned where it is long."""
    keys = shown_columns(each)
    places, thinned = thinned_rows(each)
    words = [each.note] if each.note else []
    if any(each.columns[key].kind in (PRESSURE_LEVEL, GAUGE_PRESSURE) for key in keys):
        words.append("Pressures are gauge.")
    more = "" if len(keys) == len(each.columns) else "; all columns are there"
    words.append(f"The table is in {name}.csv, in SI{more}.")
    if len(places) < each.rows:
        words.append(f"Shown are {len(places)} of {each.rows} rows{thinned}.")
    classes = ["q" if each.columns[key].kind is None else "n" for key in keys]
    lines = [row([text(table_cell(each, key, place)) for key in keys], classes) for place in places]
    numeric = [place for place, key in enumerate(keys) if each.columns[key].kind]
    heads = [text(column_head(each.columns[key])) for key in keys]
    return f'<p class="small">{text(" ".join(words))}</p>\n' + table(heads, lines, numeric)


def _references(keys: Sequence[str]) -> Iterator[str]:
    known = bibliography()
    items = [
        f'<li id="ref-{text(key)}"><span class="keys">{text(key)}</span> {text(known[key].authors)}: '
        f"<i>{text(known[key].title)}</i>. {text(known[key].place)}, {text(known[key].year)}.</li>"
        for key in keys
        if key in known
    ]
    unknown = ", ".join(text(key) for key in keys if key not in known)
    if items or unknown:
        yield f'<h2 id="references">References</h2>\n<ol class="references">\n{chr(10).join(items)}\n</ol>'
    if unknown:
        yield f'<p class="small">Sources that are not in the bibliography: {unknown}.</p>'
