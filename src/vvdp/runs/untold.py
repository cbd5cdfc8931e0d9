"""A run without its circuit: what its record and its summary say by themselves.

The circuit of a saved run may need code that is not run (`systems.own_modules`). Numbers, series and origin are data.
"""

from collections.abc import Iterator

from vvdp.base.display import number
from vvdp.results.chart import Chart
from vvdp.results.quick import quick_panel, stacked_chart
from vvdp.results.result import Finding, Grade, Listing, Result, Row, Table
from vvdp.runs.tables import record_table
from vvdp.simulation.results import Results

MOST_PANELS = 6
"""Series that a chart shows; all can be drawn by name."""
DRAWN = {"states": "States", "outputs": "Outputs", "commands": "Commands of programs"}
TITLE = "The circuit is not shown"


def untold_result(results: Results, why: str) -> Result:
    """A run as a result, its series as recorded [SI, pressures absolute]; `why` its circuit is not shown."""
    record = record_table(results.record)
    rows = tuple(Row(key, None, (_value_text(value),)) for key, value in sorted(results.summary.items()))
    note = "In SI units, as the end of each name says. Pressures are gauge."
    return Result(
        verb="run",
        title=str(results.meta.get("title", "")),
        system=str(results.meta.get("system", "")),
        listings={"numbers": Listing(title="Numbers", heads=("value",), rows=rows, note=note)},
        tables={"record": record},
        charts={chart.name: chart for chart in _charts(record)},
        findings=(Finding(text=why, grade=Grade.WARNING, title=TITLE),),
        finished=bool(results.meta["finished"]),
    )


def _value_text(value: float | bool) -> str:
    return ("yes" if value else "no") if isinstance(value, bool) else number(float(value), 6)


def _charts(record: Table) -> Iterator[Chart]:
    for group, words in DRAWN.items():
        keys = [key for key in record.columns if key.startswith(f"{group}.")][:MOST_PANELS]
        if keys and record.rows > 1:
            caption = f"{words} over time, the first {len(keys)} that were recorded; pressures are absolute."
            yield stacked_chart(group, caption, [quick_panel("record", record, key) for key in keys])
