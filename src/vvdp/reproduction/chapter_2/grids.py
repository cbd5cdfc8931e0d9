"""Figs. 2.7 to 2.10: how the computed drops depend on the grid, and the scaled section."""

from vvdp.base.kinds import COUNT, NUMBER
from vvdp.cfd.kept import KeptStudy
from vvdp.reproduction.chapter_2.computed import kept_or_none, kept_table, live_rail
from vvdp.reproduction.chapter_2.shapes import surface_drawing
from vvdp.reproduction.drawings import solid_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.chart import Chart, Line, Lines, Stroke
from vvdp.results.result import Table
from vvdp.results.verdict import Statement, bound_statement, missing_statement, number_statement

DROP = "pressure_drop_Pa"
SETTLED = 0.05
"""Share of the drop that grids may leave open while it counts as independent of them (ours) [1]."""
SMALL = 5.0
"""Cells per spool radius of the case that is computed at once: 16 000 in all, half a minute on one core."""
GEOMETRY = "other elements, of a shape that the text gives in part"


def _grid_statement(kept: KeptStudy | None) -> Statement:
    """Statement on the uncertainty of the drop by the three finest grids: the convergence index, or the spread if
    values do not converge monotonically."""
    what, source = "what the grids leave open of the drop", "independent of the grid"
    if kept is None:
        return missing_statement(what, source, "a study of three grids")
    return bound_statement(
        what,
        kept.grid_index,
        NUMBER,
        high=SETTLED,
        source=source,
        because="5 % (ours)",
        note=f"{int(kept['cells'].max())} cells",
    )


def _cell_statement(kept: KeptStudy | None, cells: int) -> Statement:
    """The cells of the finest grid here, beside those of the source's."""
    what, source = "cells of the refined grid", f"{cells} tetrahedra"
    if kept is None:
        return missing_statement(what, source, "a study of three grids")
    most = int(kept["cells"].max())
    return number_statement(what, cells, most, COUNT, source=source, result=f"{most} hexahedra", note=GEOMETRY)


def _grids(number: str, name: str, study: str, cells: int, live: Table | None = None) -> Reproduction:
    """The drop of a section on grids of different fineness, and that of a case computed `live`."""
    kept = kept_or_none(study)
    statements = (_grid_statement(kept), _cell_statement(kept, cells))
    if kept is None:
        return Reproduction(statements=statements)
    lines = [Line(x="cells", y=DROP, label="kept", stroke=Stroke.MARKED)]
    if live:
        lines.append(Line(x="cells", y=DROP, label="computed just now", stroke=Stroke.POINTS, table="live"))
    chart = Chart(
        name=f"figure-{number}",
        caption=f"Drop of the {name} at 40 lpm over the number of cells.",
        table="grids",
        panels=(Lines(lines=tuple(lines), label="pressure drop", low=0.0),),
        height=2.3,
    )
    tables = {"grids": kept_table(kept)} | ({"live": live} if live else {})
    return Reproduction(statements=statements, tables=tables, charts=(chart,))


def figure_2_7() -> Reproduction:
    """The grids of the rail, and where OpenFOAM is at hand a small case that is computed at once."""
    return _grids("2.7", "inlet rail with its nozzles", "rail-grids", 995_983, live_rail(SMALL))


def figure_2_8() -> Reproduction:
    """The grids of the centre section."""
    return _grids("2.8", "centre section", "centre-grids", 1_018_093)


def figure_2_9() -> Reproduction:
    """The grids of the outlet turbine."""
    return _grids("2.9", "outlet turbine", "turbine-grids", 1_772_910)


def figure_2_10() -> Reproduction:
    """The centre section, scaled in radius alone: the surface of the spool rolled out, as wide as the diameter."""
    return solid_drawing("scaling of the centre section in radius", "figure-2.10", surface_drawing)


ITEMS = (
    Item(ItemKind.FIGURE, "2.7", "Grid independence, inlet rail and nozzles", figure_2_7),
    Item(ItemKind.FIGURE, "2.8", "Grid independence, centre PWM section", figure_2_8),
    Item(ItemKind.FIGURE, "2.9", "Grid independence, outlet turbine", figure_2_9),
    Item(ItemKind.FIGURE, "2.10", "Scaling of the centre section", figure_2_10),
)
