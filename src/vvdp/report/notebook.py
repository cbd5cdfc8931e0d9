"""A live chart in a frame of its own, as a notebook shows it: the page's styles and scripts touch nothing outside."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

from vvdp.report.html import text
from vvdp.report.interactive import SCRIPTS, Columns, asset, described_chart, live_head, page_text
from vvdp.results.chart import Chart
from vvdp.results.result import Table

OWN_SCRIPT, OWN_STYLE = "notebook.js", "notebook.css"
PANEL, AROUND = 165, 185
"""Height of a panel, and of what is around all of them [px]."""


class Step(NamedTuple):
    """One place of a slider: its words, and the chart that belongs to it with its tables."""

    words: str
    chart: Chart
    tables: Mapping[str, Table]


def live_frame(steps: Sequence[Step], label: str = "") -> str:
    """A frame with the live chart of the middle one of `steps`; with several, a slider called `label` above it."""
    columns = Columns()
    charts = [described_chart(each.chart, each.tables, columns) for each in steps]
    panels = len(steps[0].chart.panels)
    height = PANEL * panels
    own = asset(OWN_SCRIPT)
    body = (
        f'<div id="words" data-words="{escape(json.dumps([each.words for each in steps]))}" data-label="{text(label)}">'
        f'</div><figure><svg height="{height}"></svg></figure>'
        f'<script type="application/json" id="chart-data">{page_text(charts, columns)}</script>'
        + "".join(f"<script>{script}</script>" for script in (*map(asset, SCRIPTS), own))
    )
    page = (
        f'<!doctype html><meta charset="utf-8">{live_head([own])}<style>{asset(OWN_STYLE)}</style><body>{body}</body>'
    )
    return (
        f'<iframe title="{text(steps[0].chart.name)}, live chart" sandbox="allow-scripts" width="100%" '
        f'height="{height + AROUND}" style="border:0" srcdoc="{escape(page, quote=True)}"></iframe>'
    )
