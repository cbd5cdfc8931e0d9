"""Pure resistances between two volumes: orifices, one of which opens with a port, and laminar gaps."""

from vvdp.base.kinds import Area, Conductance, Fraction
from vvdp.base.params import Params
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import Passage, passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.soft_switching import Mouth, released_area
from vvdp.network.component import Component


class LaminarGap(Params):
    """A gap whose flow is proportional to its drop."""

    conductance: Conductance


def orifice(a: FluidState, b: FluidState, area: Area, medium: Medium, values: Orifice) -> Passage:
    """Flow and loss of an orifice of `area` [m^2] from a to b; see `orifice_flow`."""
    return passage(orifice_flow(area, a.pressure - b.pressure, medium.density, values), a, b)


def released_orifice(a: FluidState, b: FluidState, opening: Fraction, medium: Medium, values: Mouth) -> Passage:
    """Orifice from a to b that is closed with a port, and fully open from a small `opening` of that port on."""
    return passage(orifice_flow(released_area(opening, values), a.pressure - b.pressure, medium.density, values), a, b)


def laminar_gap(a: FluidState, b: FluidState, values: LaminarGap) -> Passage:
    """Flow and loss of a laminar gap from a to b: Q = G dp."""
    return passage(values.conductance * (a.pressure - b.pressure), a, b)


ORIFICE = Component(orifice, symbol="orifice")
RELEASED_ORIFICE = Component(released_orifice, symbol="orifice")
LAMINAR_GAP = Component(laminar_gap, symbol="throttle")
