"""Drawings of the source, drawn again from what is simulated: circuits from their networks, valves from their
solids.
"""

from collections.abc import Callable

import vvdp
from vvdp.base.extras import MissingExtraError
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
from vvdp.report.drawing import Drawn
from vvdp.report.raster import diagram_png
from vvdp.reproduction.item import Reproduction
from vvdp.results.chart import Picture
from vvdp.results.verdict import Statement, drawing_statement


def solid_drawing(what: str, name: str, draw: Callable[[], Drawn], *more: Statement) -> Reproduction:
    """A drawing that is made from solids; without the libraries that it takes it is not drawn, and states this."""
    try:
        made = draw()
    except MissingExtraError as problem:
        return Reproduction(statements=(drawing_statement(what, str(problem)), *more))
    picture = Picture(name=name, caption=made.caption, svg=made.svg, png=made.png)
    return Reproduction(
        statements=(drawing_statement(what, made.caption.partition(". ")[0]), *more), pictures=(picture,)
    )


def circuit_drawing(what: str, name: str, *systems: str) -> Reproduction:
    """The circuits of systems, drawn from their networks; of one with a single part what is inside of the part."""
    pictures = []
    for number, system in enumerate(systems):
        loaded = vvdp.load(system)
        suffix = "abc"[number] if len(systems) > 1 else ""
        network = loaded.circuit.network
        part = next(iter(network.circuits)) if len(network.circuits) == 1 else ""
        svg = diagram(graph_of(network, loaded.title, part), {})
        picture = Picture(name=f"{name}{suffix}", caption=loaded.title, svg=svg, png=diagram_png(svg))
        pictures.append(picture)
    words = " and ".join(f"`{system}`" for system in systems)
    return Reproduction(statements=(drawing_statement(what, f"the circuit of {words}"),), pictures=tuple(pictures))
