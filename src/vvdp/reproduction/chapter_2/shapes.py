"""The drawings of chapters 1 and 2 that show the valve: made from its solids, which an extra brings."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from vvdp.base.extras import require_solids
from vvdp.base.kinds import AREA
from vvdp.geometry.shape_tables import given_shape, valve_shape
from vvdp.report.drawing import Drawn
from vvdp.reproduction.chapter_2.valve import valve
from vvdp.reproduction.drawings import circuit_drawing, solid_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.verdict import number_statement

if TYPE_CHECKING:
    from vvdp.geometry.mesh import Mesh

DUTY = 0.5


def shape() -> Any:
    """The shape of the prototype."""
    return valve_shape(valve()).shape


@cache
def oil() -> "Mapping[str, Mesh]":
    """Oil volumes on the way to an outlet: the whole valve, and its three sections."""
    require_solids()
    from vvdp.geometry.domains import centre_domain, rail_domain, turbine_domain, valve_domain

    v, s, position = valve(), shape(), DUTY * valve().helix_length
    return {
        "whole valve": valve_domain(s, v, 0.0, position).mesh,
        "inlet rail": rail_domain(s, v).mesh,
        "centre section": centre_domain(s, v, 0.0, position).mesh,
        "outlet turbine": turbine_domain(s, v, 0.0, position).mesh,
    }


def surface_drawing() -> Drawn:
    """The spool's surface rolled out, with its lengths."""
    require_solids()
    from vvdp.report.geometry_figures import unwrapped_figure

    return unwrapped_figure(shape(), valve(), DUTY * valve().helix_length)


def solids() -> Drawn:
    """Spool and cut sleeve."""
    require_solids()
    from vvdp.geometry.solids import half_sleeve, spool
    from vvdp.report.geometry_figures import solids_figure

    return solids_figure(spool(shape(), valve()), half_sleeve(shape(), valve()))


def rail_designs(designs: Sequence[str]) -> Drawn:
    """The oil of the rail in some of the source's designs."""
    require_solids()
    from vvdp.geometry.domains import rail_domain
    from vvdp.report.geometry_figures import oil_figure

    rails = {
        f"({design})": rail_domain(given_shape(valve(), f"rail-{design}", ()).shape, valve()).mesh for design in designs
    }
    return oil_figure(rails)


def figure_2_1() -> Reproduction:
    """The key measures: those that the text names."""
    area = number_statement("area of the three nozzles", 36.5e-6, valve().nozzle_area, AREA, because="as printed")
    return solid_drawing("key geometry of the prototype", "figure-2.1", surface_drawing, area)


def figure_2_2() -> Reproduction:
    """The oil within the valve."""

    def draw() -> Drawn:
        domains = oil()
        from vvdp.report.geometry_figures import oil_figure

        return oil_figure(domains)

    return solid_drawing("fluid domain of the valve", "figure-2.2", draw)


def _section(number: str, name: str) -> Callable[[], Reproduction]:
    def work() -> Reproduction:
        """A section of the oil, with its patches."""

        def draw() -> Drawn:
            domain = oil()[name]
            from vvdp.report.geometry_figures import patches_figure

            return patches_figure(domain)

        return solid_drawing(f"fluid domain, {name}", f"figure-{number}", draw)

    return work


def figure_2_6() -> Reproduction:
    """The apparatus: the circuit that stands for it."""
    return circuit_drawing("experimental apparatus", "figure-2.6", "prototype")


def figure_2_16() -> Reproduction:
    """Impulse turbine and reaction turbine: the spool that has both."""
    return solid_drawing("impulse and reaction turbine", "figure-2.16", solids)


def figure_2_18() -> Reproduction:
    """Lands and pockets of the spool."""
    return solid_drawing("bearing surface and pockets", "figure-2.18", surface_drawing)


ITEMS = (
    Item(ItemKind.FIGURE, "2.1", "3-way rotary valve prototype, key geometry", figure_2_1),
    Item(ItemKind.FIGURE, "2.2", "Fluid domain of the valve", figure_2_2),
    Item(ItemKind.FIGURE, "2.3", "Inlet rail with nozzles, fluid domain", _section("2.3", "inlet rail")),
    Item(ItemKind.FIGURE, "2.4", "Centre PWM section, fluid domain", _section("2.4", "centre section")),
    Item(ItemKind.FIGURE, "2.5", "Outlet turbine with flow rail, fluid domain", _section("2.5", "outlet turbine")),
    Item(ItemKind.FIGURE, "2.6", "Experimental apparatus", figure_2_6),
    Item(ItemKind.FIGURE, "2.16", "Impulse turbine and reaction turbine", figure_2_16),
    Item(ItemKind.FIGURE, "2.18", "Bearing surface and pocket fluid", figure_2_18),
)
