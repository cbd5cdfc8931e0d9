"""The report of a rig or a map: one page, from the files that it left."""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from vvdp.base.display import number
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure, row, table, text
from vvdp.report.page import opening, write_page
from vvdp.report.references import bibliography
from vvdp.report.rig_figures import rig_figures
from vvdp.rigs.conditions import CELSIUS, RPM
from vvdp.rigs.result import RigResult, Sheet, read_rig

BAR = 1e5
LPM = 1e-3 / 60.0

MOST_ROWS = 150
WRAPPED = "th.n { white-space: normal; }\n"
"""Heads of wide tables may wrap; their numbers may not."""
ONCE = ("oil_temperature_K", "pump_speed_rad_s")
"""Columns of a map that the page shows only where they vary; else they stand among the conditions."""
LONG = ("waveform", "step_up", "step_down")
"""Tables that are courses over time: the page has their figures only."""
MAP = (
    "oil_temperature_K",
    "pump_speed_rad_s",
    "load_pressure_Pa",
    "duty_ratio",
    "delivered_flow_m3_s",
    "volumetric_efficiency",
    "hydromechanical_efficiency",
    "overall_efficiency",
    "input_power_W",
    "pwm_frequency_Hz",
    "remark",
)
SHOWN: Mapping[str, Sequence[str]] = {"map": MAP, "steady": MAP}
"""Columns of a table that the page shows, where not all; the files have all."""
SCALES: Mapping[str, tuple[float, float, str]] = {
    "Pa gauge": (BAR, 0.0, "bar"),
    "Pa": (BAR, 0.0, "bar"),
    "m^3/s": (LPM, 0.0, "lpm"),
    "rad/s": (RPM, 0.0, "rpm"),
    "K": (1.0, CELSIUS, "°C"),
    "m^2": (1e-6, 0.0, "mm²"),
    "m^3": (1e-6, 0.0, "cm³"),
    "s": (1e-3, 0.0, "ms"),
    "rad": (np.pi / 180.0, 0.0, "°"),
}
"""Unit of a column: scale, datum and unit on the page."""


def write_rig_report(directory: Path) -> Path:
    """Writes report.html and figures/ beside the files of a rig and gives the path of the page.

    Raises ConfigError where the directory holds no result of a rig.
    """
    result = read_rig(directory)
    meta = json.loads((directory / "meta.json").read_text("utf-8"))
    pictures = tuple(rig_figures(result))
    return write_page(directory, _page(result, meta, pictures), pictures)


def _page(result: RigResult, meta: Mapping[str, str], pictures: tuple[Drawn, ...]) -> Iterator[str]:
    title = text(result.title)
    yield f"{opening(title, WRAPPED)}\n<h1>{title}</h1>"
    facts = [f"System <b>{text(result.system)}</b>", text(meta["written"][:10]), f"vvdp {text(meta['vvdp'])}"]
    yield f'<p class="facts">{" &middot; ".join(facts)}</p>'
    if not result.finished:
        goes_on = "The same command goes on from here." if result.rig == "map" else "Run again for the whole."
        words = f"<p>{goes_on}</p>"
        yield f'<div class="notice"><strong>Interrupted: not all was run</strong>{words}</div>'
    for sentence in result.findings:
        yield f'<p class="lead">{text(sentence)}</p>'
    yield f"<h2>How it was done</h2>\n<p>{text(result.manner)}</p>"
    yield '<div class="columns">\n<div><h3>Conditions</h3>'
    yield table(("", ""), [row([text(name), text(value)], ("q", "")) for name, value in result.conditions.items()])
    yield "</div>\n<div><h3>Left out</h3>\n<ul>"
    yield from (f"<li>{text(each)}</li>" for each in result.left_out)
    yield "</ul></div>\n</div>"
    for count, each in enumerate(pictures, 1):
        yield figure(each.svg, each.name, count, text(each.caption))
    for name, sheet in result.sheets.items():
        if name in LONG:
            continue
        yield from _sheet(result.rig, name, sheet)
    yield from _references(result.references)
    yield "</body>\n</html>"


def _sheet(rig: str, name: str, sheet: Sheet) -> Iterator[str]:
    shown = [key for key in SHOWN.get(name, SHOWN.get(rig, tuple(sheet.columns))) if key in sheet.columns]
    if name in ("map", "steady"):
        shown = [key for key in shown if key not in ONCE or np.ptp(sheet[key]) > 0.0]
    yield f'<h2 class="page">{text(sheet.title)}</h2>'
    more = "" if len(shown) == len(sheet.columns) else "; all columns are there"
    words = f"Pressures are gauge. The table is in {text(name)}.csv, in SI{more}."
    places, thinned = thinned_rows(sheet)
    if len(places) < sheet.rows:
        words += f" Shown are {len(places)} of {sheet.rows} rows{thinned}."
    yield f'<p class="small">{words}</p>'
    numeric = [i for i, key in enumerate(shown) if sheet[key].dtype.kind == "f"]
    heads = [_head(sheet, key) for key in shown]
    lines = [
        row([_cell(sheet, key, place) for key in shown], ["n" if i in numeric else "q" for i in range(len(shown))])
        for place in places
    ]
    yield table(heads, lines, numeric)


AXES = ("flow_m3_s", "duty_ratio", "load_pressure_Pa", "pump_speed_rad_s", "oil_temperature_K", "opening")
"""Columns that a table goes through in every combination."""


def thinned_rows(sheet: Sheet) -> tuple[list[int], str]:
    """Rows that the page shows, at most `MOST_ROWS`, and how they were chosen, in words.

    Where a table goes through axes, every n-th value of one of them stays, the last among them, and so whole courses.
    """
    values = {key: np.unique(sheet[key], return_inverse=True) for key in AXES if key in sheet.columns}
    counts = {key: each.size for key, (each, _) in values.items() if each.size > 1}
    if sheet.rows <= MOST_ROWS:
        return list(range(sheet.rows)), ""
    if int(np.prod(list(counts.values()))) != sheet.rows:
        return [round(x) for x in np.linspace(0, sheet.rows - 1, MOST_ROWS).tolist()], ""
    every = dict.fromkeys(counts, 1)
    while np.prod([-(-counts[key] // every[key]) for key in counts]) > MOST_ROWS:
        every[max(counts, key=lambda key: -(-counts[key] // every[key]))] += 1
    kept = np.ones(sheet.rows, bool)
    for key, count in counts.items():
        kept &= (count - 1 - values[key][1]) % every[key] == 0
    words = [f"1 in {step} of the values of {sheet.columns[key].label}" for key, step in every.items() if step > 1]
    return np.flatnonzero(kept).tolist(), f", {' and '.join(words)}"


def _head(sheet: Sheet, key: str) -> str:
    column = sheet.columns[key]
    unit = "%" if key.endswith("efficiency") else SCALES.get(column.unit, (1.0, 0.0, column.unit))[2]
    return text(f"{column.label} {unit}".replace("_", " ").strip())


def _cell(sheet: Sheet, key: str, place: int) -> str:
    column = sheet.columns[key]
    value = column.values[place]
    if isinstance(value, str):
        return text(value)
    if key.endswith("efficiency"):
        return number(100.0 * float(value), 3)
    scale, datum, _ = SCALES.get(column.unit, (1.0, 0.0, ""))
    return number((float(value) - datum) / scale, 4)


def _references(keys: Sequence[str]) -> Iterator[str]:
    known = bibliography()
    items = [
        f'<li><span class="keys">{text(key)}</span> {text(known[key].authors)}: <i>{text(known[key].title)}</i>. '
        f"{text(known[key].place)}, {text(known[key].year)}.</li>"
        for key in keys
        if key in known
    ]
    if items:
        yield f'<h2>References</h2>\n<ol class="references">\n{chr(10).join(items)}\n</ol>'
