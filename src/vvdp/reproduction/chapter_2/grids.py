"""Figs. 2.7 to 2.10: how the computed drops depend on the grid, and the scaled section."""

from collections.abc import Callable

from vvdp.base.kinds import NUMBER
from vvdp.cfd.kept import KeptStudy
from vvdp.reproduction.chapter_2.computed import kept_or_none, kept_table
from vvdp.reproduction.chapter_2.shapes import unwrapped
from vvdp.reproduction.drawings import solid_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.chart import Chart, Line, Lines, Stroke
from vvdp.results.verdict import Statement, bound_statement, missing_statement, open_statement

DROP = "pressure_drop_Pa"
SETTLED = 0.05
"""Change of the drop from the second finest grid to the finest that counts as none (ours) [1]."""
GEOMETRY = "the shape, which the text gives in part, and the element: tetrahedra there, hexahedra here"


def _grid_statement(kept: KeptStudy | None) -> Statement:
    """Whether the drop stands still from the second finest grid to the finest."""
    what, source = "change of the drop on the finest grid", "independent of the grid"
    if kept is None:
        return missing_statement(what, source, "a study of three grids")
    order = kept["cells"].argsort()
    last, before = kept[DROP][order][-1], kept[DROP][order][-2]
    return bound_statement(
        what,
        abs(float(last / before) - 1.0),
        NUMBER,
        high=SETTLED,
        source=source,
        because="5 % (ours)",
        note=f"{int(kept['cells'].max())} cells",
    )


def _grids(number: str, name: str, study: str, cells: int) -> Callable[[], Reproduction]:
    def work() -> Reproduction:
        """The drop of a section on grids of different fineness."""
        kept = kept_or_none(study)
        own = f"{int(kept['cells'].max())} hexahedra here" if kept else "none here"
        most = open_statement("cells of the refined grid", f"{cells} tetrahedra", own, GEOMETRY)
        statements = (_grid_statement(kept), most)
        if kept is None:
            return Reproduction(statements=statements)
        chart = Chart(
            name=f"figure-{number}",
            caption=f"Drop of the {name} at 40 lpm over the number of cells.",
            table="grids",
            panels=(Lines(lines=(Line(x="cells", y=DROP, stroke=Stroke.MARKED),), label="pressure drop", low=0.0),),
            height=2.3,
        )
        return Reproduction(statements=statements, tables={"grids": kept_table(kept)}, charts=(chart,))

    return work


def figure_2_10() -> Reproduction:
    """The centre section, scaled in radius alone: the surface of the spool rolled out, as wide as the diameter."""
    return solid_drawing("scaling of the centre section in radius", "figure-2.10", unwrapped)


ITEMS = (
    Item(
        ItemKind.FIGURE,
        "2.7",
        "Grid independence, inlet rail and nozzles",
        _grids(
            "2.7",
            "inlet rail with its nozzles",
            "rail-grids",
            995_983,
        ),
    ),
    Item(
        ItemKind.FIGURE,
        "2.8",
        "Grid independence, centre PWM section",
        _grids("2.8", "centre section", "centre-grids", 1_018_093),
    ),
    Item(
        ItemKind.FIGURE,
        "2.9",
        "Grid independence, outlet turbine",
        _grids("2.9", "outlet turbine", "turbine-grids", 1_772_910),
    ),
    Item(ItemKind.FIGURE, "2.10", "Scaling of the centre section", figure_2_10),
)
