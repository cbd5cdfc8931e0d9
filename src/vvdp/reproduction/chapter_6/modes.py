"""Section 6.4: the control modes over both pressures, and whether flow and opening are continuous between them."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, FLOW, GAUGE_PRESSURE
from vvdp.base.units import ATMOSPHERE
from vvdp.control.capacities import Sides, capacities
from vvdp.control.flow_split import Authority, authority
from vvdp.control.pressure_modes import (
    PRESSURE_MODE,
    Actuation,
    Guards,
    PressureBounds,
    Swept,
    acting_mode,
    guarded_actuation,
    guards,
    limit_actuation,
    mode_ends,
    swept_flows,
)
from vvdp.control.printed_modes import first_match, printed_actuation
from vvdp.reproduction.chapter_6.cylinder import nominal_settings
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of
from vvdp.results.chart import Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, drawing_statement, number_statement

BAR, LPM = 1e5, 1e-3 / 60.0
NUDGE = 1e-3
"""By which a pressure is moved over the border of a mode, either way [Pa]."""
STATES, SEED = 2000, 11
LARGEST_JUMP = 1e-3 * LPM
"""Largest jump that counts as none [m^3/s]."""
HIGHEST, POINTS = 100.0, 41
COLOURS = ("#c8c8c8", "#1f4e9c", "#8fb3e8", "#2e7d4f", "#9ad0ad", "#b5472f", "#ecab98", "#6b4c9a", "#c4b2e0")
"""A hue for each bound, pale for the band beside it."""

Law = Callable[..., Actuation]


def figure_6_2() -> Reproduction:
    """Both positions of the directional valve."""
    return Reproduction(
        statements=(
            drawing_statement(
                "head or rod chamber connected to the pump",
                "components `directed-source` and `directed-return` in the circuit of figure-6.1",
            ),
        )
    )


def mode_plane() -> Table:
    """The mode that acts, over the pressures of supply and return; bounds and bands are widened to be seen."""
    bounds = replace(
        nominal_settings().bounds,
        lowest_pressure=10.0 * BAR + ATMOSPHERE,
        highest_pressure=90.0 * BAR + ATMOSPHERE,
        transition_band=10.0 * BAR,
    )
    axis: Array = np.linspace(0.0, HIGHEST, POINTS) * BAR
    rows = [
        (supply, returned, acting_mode(guards(Sides(1e-3, 1e-3, supply + ATMOSPHERE, returned + ATMOSPHERE), bounds)))
        for supply in axis
        for returned in axis
    ]
    supply, returned, mode = np.array(rows).T
    columns = {
        "supply_Pa": Column(supply, GAUGE_PRESSURE, "supply chamber"),
        "return_Pa": Column(returned, GAUGE_PRESSURE, "return chamber"),
        "mode": Column(mode, PRESSURE_MODE, "mode"),
    }
    return Table(title="Modes", columns=columns, axes=("supply_Pa", "return_Pa"))


def figure_6_3() -> Reproduction:
    """The plane of both pressures with its nine modes."""
    table = mode_plane()
    modes = np.unique(table["mode"])
    lines = tuple(
        Line(
            x="supply_Pa",
            y="return_Pa",
            label=f"mode {mode:g}",
            rows=tuple(np.flatnonzero(table["mode"] == mode).tolist()),
            colour=colour,
            stroke=Stroke.POINTS,
            width=3.0,
        )
        for mode, colour in zip(modes, COLOURS, strict=True)
    )
    statement = number_statement("modes that occur", 9, modes.size, COUNT, source="1 to 5 and four between them")
    return figure_of(
        "figure-6.3",
        "Control modes over both pressures, with bounds of 10 and 90 bar and bands of 10 bar.",
        {"modes": table},
        (statement,),
        Lines(lines=lines, label="return chamber"),
        height=4.6,
    )


def cited_mode_3(
    effort: float, flow: float, swept: Swept, acting: Guards, means: Authority, bounds: PressureBounds
) -> Actuation:
    """The law as printed, mode 3.5 mended to go over to the opening of mode 3."""
    ends = mode_ends(swept, means.full_return, 0.0, bounds)
    return first_match(effort, flow, ends, acting, means, ends.holding)


def actuation(law: Law, direction: float, state: Array, supply: float, returned: float) -> Actuation:
    """Flow and opening of a law at a state (position, velocity, effort, flow) and both pressures [Pa], limited."""
    settings = nominal_settings()
    cylinder, split = settings.cylinder, settings.split
    position, velocity, effort, flow = (float(value) for value in state)
    supplied, emptied = (cylinder.area_a, cylinder.area_b)[:: int(direction)]
    at = Sides(supplied, emptied, supply, returned)
    full = max(cylinder.return_conductance * max(returned - ATMOSPHERE, 0.0) ** 0.5, split.least_return_flow)
    means = authority(capacities(direction, position, ATMOSPHERE, cylinder), full)
    wanted = law(
        direction * effort,
        flow,
        swept_flows(direction, velocity, at),
        guards(at, settings.bounds),
        means,
        settings.bounds,
    )
    return limit_actuation(direction * effort, wanted, means, split.largest_flow)


def largest_jump(law: Law, places: Callable[[np.random.Generator], tuple[float, float, float, float]]) -> float:
    """The largest change of the flow [m^3/s] over a border, at random states; `places` gives supply and return
    pressure and which of them is nudged."""
    random, most = np.random.default_rng(SEED), 0.0
    for _ in range(STATES):
        direction = float(random.choice((-1.0, 1.0)))
        state = np.array(
            (random.uniform(0.05, 0.25), random.uniform(-0.1, 0.1), random.uniform(0.0, 2e5), random.uniform(0.0, 6e-4))
        )
        supply, returned, move_supply, move_return = places(random)
        sides = (
            actuation(law, direction, state, supply + sign * move_supply, returned + sign * move_return)
            for sign in (-NUDGE, NUDGE)
        )
        below, above = sides
        most = max(most, abs(above.flow - below.flow))
    return most


def at_return_bound(random: np.random.Generator) -> tuple[float, float, float, float]:
    """Between modes 3 and 3.5, the supply in its normal range."""
    bounds = nominal_settings().bounds
    low, high, band = bounds.lowest_pressure, bounds.highest_pressure, bounds.transition_band
    return float(random.uniform(low + band, high - band)), low, 0.0, 1.0


def where_two_apply(random: np.random.Generator) -> tuple[float, float, float, float]:
    """Where a guard of the supply begins while one of the return acts."""
    bounds = nominal_settings().bounds
    low, high, band = bounds.lowest_pressure, bounds.highest_pressure, bounds.transition_band
    returned = random.choice((random.uniform(ATMOSPHERE, low + band), random.uniform(high - band, high + 5.0 * BAR)))
    return float(random.choice((low + band, high - band))), float(returned), 1.0, 0.0


def _jump(
    what: str,
    law: Law,
    places: Callable[..., tuple[float, float, float, float]],
    contradiction: tuple[str, str] | None = None,
    note: str = "",
) -> Statement:
    return bound_statement(
        what,
        largest_jump(law, places),
        FLOW,
        high=LARGEST_JUMP,
        source="the control efforts are continuous",
        because="a thousandth of a lpm over 2 mPa (ours)",
        contradiction=contradiction,
        note=note,
    )


@cache
def _statements() -> tuple[Statement, ...]:
    both = "the text does not say which of two modes applies"
    return (
        _jump(
            "jump of the flow between modes 3 and 3.5, as printed",
            printed_actuation,
            at_return_bound,
            ("6.4, mode 3.5: u₂ from (6.34)", "6.4, continuity: with mode 3.5 the efforts are continuous"),
        ),
        _jump("the same, (6.36) cited", cited_mode_3, at_return_bound),
        _jump("jump where both pressures leave their range, (6.36) cited", cited_mode_3, where_two_apply, note=both),
        _jump("the same, blended as built", guarded_actuation, where_two_apply),
    )


def section_6_4() -> Reproduction:
    """Continuity of flow and opening over the borders of the modes."""
    return Reproduction(statements=_statements())


def equation_6_36() -> Reproduction:
    """Mode 3.5 goes over to the opening of mode 3, which (6.36) gives, and not (6.34)."""
    return Reproduction(statements=_statements()[:2])


ITEMS = (
    Item(ItemKind.FIGURE, "6.2", "Hydraulic configurations", figure_6_2),
    Item(ItemKind.FIGURE, "6.3", "Control modes over both chamber pressures", figure_6_3),
    Item(ItemKind.EQUATION, "6.36", "Modes 3 and 3.5", equation_6_36),
    Item(ItemKind.SECTION, "6.4", "Continuity of the control efforts", section_6_4),
)
