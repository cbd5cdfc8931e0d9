"""The page about a valve's shape: what it measures, what it looks like, and where each length comes from."""

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vvdp.base.display import number
from vvdp.base.tables import Sourced
from vvdp.geometry.domains import Domain
from vvdp.geometry.measure import Comparison
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, row, table, text
from vvdp.report.page import opening, write_page

FILM = "period.gif"
SHOWN = {
    "m": ("mm", 1e3),
    "m^2": ("mm²", 1e6),
    "m^3": ("cm³", 1e6),
    "rad": ("deg", 57.29577951308232),
    "kg": ("g", 1e3),
}
"""The unit in which a person is shown a quantity, and the factor to it."""


@dataclass(frozen=True)
class Page:
    """All that the page shows."""

    title: str
    summary: Mapping[str, Any]
    comparisons: Sequence[Comparison]
    domains: Sequence[Domain]
    drawn: Sequence[Drawn]
    rows: Sequence[Sourced]
    shut: Sequence[str]
    finished: bool


def write_geometry_report(folder: Path, page: Page) -> Path:
    """Writes report.html and figures/ into a folder that holds the film, if there is one; the path of the page."""
    film = folder / FILM
    return write_page(folder, _lines(page, film.read_bytes() if film.is_file() else b""), page.drawn)


def shown(value: float, unit: str) -> str:
    """A quantity as a person reads it, with its unit."""
    name, factor = SHOWN.get(unit, (unit, 1.0))
    return f"{number(factor * value, 5)} {name}".rstrip()


def _lines(page: Page, film: bytes) -> Iterator[str]:
    title = f"Shape of the valve: {text(page.title)}"
    yield f"{opening(title)}\n<h1>{title}</h1>"
    s = page.summary
    facts = [
        f"duty ratio {number(s['duty_ratio'], 3)}",
        f"spool {number(1e3 * s['spool_diameter_m'], 4)} mm x {number(1e3 * s['spool_length_m'], 4)} mm",
        f"{number(1e3 * s['spool_mass_kg'], 4)} g",
        text(str(s["written"])[:10]),
        f"vvdp {text(s['vvdp'])}",
    ]
    yield f'<p class="facts">{" &middot; ".join(facts)}</p>'
    if not page.finished:
        yield '<div class="notice"><strong>Interrupted</strong><p>Not everything was made.</p></div>'
    yield f'<p class="lead">{LEAD}</p>'
    yield "<h2>Formula and mesh</h2>"
    yield table(("", "formula", "mesh", "difference"), list(_compared(page)), (1, 2, 3))
    for place, each in enumerate(page.drawn, 1):
        yield figure(each.svg, each.name, place, text(each.caption))
    if film:
        data = base64.b64encode(film).decode("ascii")
        yield "<h2>One PWM period</h2>"
        yield f'<p><img style="max-width:100%" alt="One PWM period" src="data:image/gif;base64,{data}"></p>'
    yield "<h2>Volumes of oil</h2>"
    yield table(("", "volume", "patches and their areas in mm²"), list(_domain_rows(page)), (1,))
    if page.shut:
        yield f'<p class="small">Shut at this angle and position, so not made: {text(", ".join(page.shut))}.</p>'
    yield '<h2 class="page">Lengths that only the shape needs</h2>'
    yield f'<p class="small">{ORIGINS}</p>'
    yield table(("", "value", "status", "note"), list(_origin_rows(page)), (1,))
    yield "</body>\n</html>"


LEAD = (
    "Spool, sleeve and the oil between them, built from the parameters of the hydraulic model. The table compares what "
    "the finished meshes measure with what the formulas say; where they differ, facets stand for curves."
)
ORIGINS = (
    "No hydraulic formula uses these. They are assumed, so that the shape holds together and reproduces published "
    "areas, volume and drops as noted."
)


def _compared(page: Page) -> Iterator[str]:
    for each in page.comparisons:
        cells = [shown(each.formula, each.unit), shown(each.measured, each.unit), f"{100.0 * each.difference:.2g} %"]
        yield row([text(each.title), *cells], ("", "n", "n", "n"))
    worst = page.summary.get("openings_difference")
    if worst is not None:
        cells = ["", "", f"{100.0 * worst:.2g} %"]
        yield row(["open share of the nozzles over a period, largest difference", *cells], ("", "n", "n", "n"))


def _domain_rows(page: Page) -> Iterator[str]:
    for domain in page.domains:
        areas = ", ".join(f"{name} {number(1e6 * area, 4)}" for name, area in sorted(domain.areas.items()))
        yield row([text(domain.name), shown(domain.volume, "m^3"), text(areas)], ("u", "n", "q"))


def _origin_rows(page: Page) -> Iterator[str]:
    for each in page.rows:
        note = "; ".join(part for part in (each.source, each.where, each.note) if part)
        yield row([text(each.key), text(each.displayed), text(each.status), text(note)], ("u", "n", "", "q"))
