"""Care of the oil: a tank with a level, a filter that clogs, a cooler."""

from typing import NamedTuple

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Flow, Kink, Length, Power, Pressure, Volume
from vvdp.base.select import select
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cooler import Cooler, cooler_flow
from vvdp.hydraulics.filter_element import FilterElement, FilterState, bypass_side, clogging_rate, filter_flows
from vvdp.hydraulics.flow import Passage, passage
from vvdp.hydraulics.heat import Coolant
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.reservoir import (
    Reservoir,
    dipped_share,
    dry_side,
    reservoir_air,
    reservoir_flow,
    reservoir_head,
    reservoir_level,
    reservoir_stored,
)
from vvdp.network.component import Component


class TankState(NamedTuple):
    """Oil in a tank."""

    tank_volume: Volume


class TankFlows(NamedTuple):
    """Flows out of a tank into the nodes at its ports, the loss there, its level and air, and whether it is dry."""

    suction: Flow
    inlet: Flow
    loss: Power
    rates: TankState
    level: Length
    air: Pressure
    dry: Kink


class FilterPassage(NamedTuple):
    """Flow through a filter, how fast it clogs, the part that goes past its element, and whether any does."""

    flow: Flow
    loss: Power
    rates: FilterState
    bypassed: Flow
    bypass: Kink


def tank_with_level(
    suction: FluidState, inlet: FluidState, state: TankState, oil: Oil, medium: Medium, values: Reservoir
) -> TankFlows:
    """A tank with a level, from which a pump draws at `suction` and into which oil returns at `inlet`.

    Both open below the level, and have the head of the oil. As the level nears the lower edge of the suction mouth,
    less and less oil comes out of it.
    """
    V, reference = state.tank_volume, oil.reference_pressure
    head = reservoir_head(V, medium.density, reference, values)
    drop_s, drop_i = suction.enthalpy - head, inlet.enthalpy - head
    covered = select(drop_s > 0.0, 1.0, dipped_share(V, values))
    into_s = covered * reservoir_flow(drop_s, medium.density, values)
    into_i = reservoir_flow(drop_i, medium.density, values)
    return TankFlows(
        suction=-into_s,
        inlet=-into_i,
        loss=into_s * drop_s + into_i * drop_i,
        rates=TankState(into_s + into_i),
        level=reservoir_level(V, values),
        air=reservoir_air(V, values),
        dry=dry_side(V, values),
    )


def tank_start(values: Reservoir) -> TankState:
    """Filled as its values say."""
    return TankState(values.tank_volume)


def tank_stored(state: TankState, oil: Oil, medium: Medium, values: Reservoir) -> Stored:
    """Oil of the tank, its height, and the work on its air."""
    return reservoir_stored(state.tank_volume, medium.density, oil.reference_pressure, values)


def filter_(a: FluidState, b: FluidState, state: FilterState, values: FilterElement) -> FilterPassage:
    """A filter from a to b that clogs, with a bypass valve."""
    drop = a.pressure - b.pressure
    parts = filter_flows(drop, state.clogging, values)
    flow, loss = passage(parts.element + parts.bypass, a, b)
    rates = FilterState(clogging_rate(parts.element, values))
    return FilterPassage(flow, loss, rates, parts.bypass, bypass_side(drop, values))


def cooler(a: FluidState, b: FluidState, medium: Medium, values: Cooler) -> Passage:
    """Flow and loss of a cooler from a to b."""
    return passage(cooler_flow(a.pressure - b.pressure, medium.viscosity, values), a, b)


def cooler_coolant(values: Cooler) -> Coolant:
    """Coolant to which the cooler gives heat, if there is a heat balance."""
    return Coolant(values.heat_conductance, values.coolant_temperature)


TANK_WITH_LEVEL = Component(tank_with_level, symbol="level_tank", start=tank_start, stored=tank_stored)
FILTER = Component(filter_, symbol="filter")
COOLER = Component(cooler, symbol="cooler", cooling=cooler_coolant)
