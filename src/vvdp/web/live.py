"""The report of a run with its system in it: the values of its parameter table are sliders, and its numbers follow."""

from collections.abc import Callable

from vvdp.base.errors import VvdpError
from vvdp.report.references import bibliography
from vvdp.report.result_page import Additions, Page, listing_html
from vvdp.report.tables import Cells, parameter_table
from vvdp.runs.run import RecordedRun
from vvdp.simulation.link import quiet
from vvdp.systems.changeable import Changeable
from vvdp.web.followed import followed_cells, followed_texts
from vvdp.web.page import asset, page_head, scripts_html, shown_model, slider_html


def live_page(run: RecordedRun, page: Page, command: str, say: Callable[[str], None] = quiet) -> Page:
    """The page of a run's report with the module of its system, which a reader's browser carries out.

    command  the line that repeats the run, to which the page adds what is set there
    The page stays as it is, and `say` is informed why, where the run was interrupted or its system cannot be
    compiled so. Raises MissingExtraError without the extra `web`.
    """
    if not run.has("finished"):
        say("interrupted; the report is not interactive")
        return page
    try:
        model, values, _ = shown_model(run, page.result, command)
    except VvdpError as problem:
        if isinstance(problem, ImportError):
            raise
        say(f"the report is not interactive: {problem}")
        return page
    model |= {"cells": followed_cells(run, page.result), "texts": followed_texts(run), "report": True}
    listings = {
        name: f'<div data-listing="{name}">{listing_html(page.result.listings[name])}</div>' for name in model["cells"]
    }
    ready = {"parameters": parameter_table(run.system, bibliography(), _cells(values))}
    added = Additions(
        head=page_head(),
        style=asset("page.css"),
        begin=f'<h2 id="run">Run in this page</h2>\n{asset("controls.html")}',
        end=scripts_html(model),
        opened=frozenset(ready),
    )
    return Page(page.result, page.meta, {**page.ready, **listings, **ready}, page.drawings, added)


def _cells(values: tuple[Changeable, ...]) -> dict[str, Cells]:
    """Value and unit of each value that has a slider, for the parameter table."""
    return {
        value.row.setting: (slider_html(place, value), value.flat["symbol"])
        for place, value in enumerate(values)
        if not value.why_not
    }
