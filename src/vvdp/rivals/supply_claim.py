"""Claim: on which flows, loads and duty cycles the PWM valve loses less than what else could be bought."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import EFFICIENCY, FLAG, FLOW, GAUGE_PRESSURE, MEAN_POWER, NUMBER, PRESSURE_DIFFERENCE, Kind
from vvdp.control.duty_cycle import cycle_demand
from vvdp.machines.duties import Duty, known_cylinder, shipped_duties
from vvdp.results.chart import Chart, Colour, Field, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Number, Table, sentences
from vvdp.results.verdict import bound_statement
from vvdp.rivals.claim import Claim
from vvdp.rivals.supply_ways import RANGES, RIVALS, Assumed, Demand, Spread, spread_of
from vvdp.simulation.link import quiet
from vvdp.steady.test_stand import Stand

FLOW_SHARES = np.linspace(0.05, 1.0, 20)
PRESSURE_SHARES = np.linspace(0.05, 0.95, 19)
"""Of the map: delivered flow over pump flow, and load pressure over the relief setting."""
WAYS: Mapping[str, str] = {"switched": "PWM valve", **RIVALS}
COLOURS = (Colour.INLET, Colour.RELIEF, Colour.TANK, Colour.LOAD, Colour.PURPLE, Colour.OLIVE, Colour.GREEN)
STEPS = (-4000.0, -2000.0, -1500.0, -1000.0, -500.0, 0.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0)
IDEAL = "displacement"
"""The rival without throttle or switch."""
ASSUMED_KINDS: Mapping[str, tuple[Kind, str]] = {
    "margin": (PRESSURE_DIFFERENCE, "margin of load sensing"),
    "heavier": (EFFICIENCY, "heavier load over relief setting"),
    "leakage": (NUMBER, "leakage of a variable pump over that of the fixed one"),
    "drag": (EFFICIENCY, "torque of every pump that no oil takes, over that of its full displacement"),
}


@dataclass(frozen=True)
class Cycles:
    """Mean losses over duty cycles [W]: of each way, and what each rival loses more, at least and at most."""

    duties: tuple[Duty, ...]
    means: Mapping[str, Array]
    lowest: Mapping[str, Array]
    highest: Mapping[str, Array]


def supply_claim(
    stand: Stand,
    duties: Sequence[Duty] = (),
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Claim:
    """The map over flow and load, and the mean losses over `duties`, the shipped ones unless given."""
    rise, pump_flow = stand.relief_pressure - stand.tank_pressure, stand.pump_flow(stand.set_point)
    share, level = (np.ravel(each) for each in np.meshgrid(FLOW_SHARES, PRESSURE_SHARES))
    found = spread_of(Demand(share * pump_flow, level * rise), stand, cores, say)
    cycles = cycle_losses(stand, tuple(duties) or shipped_duties(), cores)
    table = _map_table(stand, share, level * rise, found)
    numbers = dict(_numbers(table, found))
    return Claim(
        tables={"supply": table, "duty_cycles": _cycle_table(cycles), "supply_assumed": _assumed_table()},
        charts=(_gain_chart(), _winner_chart(table)),
        numbers=numbers,
        findings=(*sentences(tuple(_words(numbers))), *_cycle_words(cycles)),
        statements=(
            (
                "section-1.1",
                bound_statement(
                    "share of flows and loads on which it loses less than displacement control",
                    numbers[f"won_over_{IDEAL}"].value,
                    EFFICIENCY,
                    low=0.5,
                    source="keeps the efficiency of variable displacement machines",
                    because="half of all points (ours)",
                    note="what the ports lose while they are partly closed: docs/when-switching-pays.md",
                ),
            ),
        ),
    )


def cycle_losses(stand: Stand, duties: Sequence[Duty], cores: int | None = None) -> Cycles:
    """Mean losses over duty cycles of the cylinder that all circuits move, at this pump.

    The relief setting is that of each duty; a load that overruns counts as none, and at rest the pump sees none.
    nan where the pump gives too little.
    """
    cylinder, friction = known_cylinder()
    rows: list[dict[str, dict[str, float]]] = []
    for duty in duties:
        demand = cycle_demand(duty.cycle, cylinder, friction)
        held = stand.with_tables(relief_valve={"cracking_pressure": stand.reference + duty.relief_pressure})
        found = spread_of(Demand(demand.flow, demand.rise), held, cores)
        ways = {"switched": found.nominal.switched, **found.nominal.rivals}
        parts = {"means": ways, "lowest": found.lowest, "highest": found.highest}
        rows.append({part: {name: _mean(each, demand.time) for name, each in of.items()} for part, of in parts.items()})
    columns = {part: {name: np.array([row[part][name] for row in rows]) for name in rows[0][part]} for part in rows[0]}
    return Cycles(tuple(duties), **columns)


def _mean(values: Array, weights: Array) -> float:
    return float(np.sum(values * weights) / np.sum(weights))


def _map_table(stand: Stand, share: Array, rise: Array, found: Spread) -> Table:
    """A row for each flow and load: losses, gains with their spread, and who loses least but for the ideal one."""
    losses = {"switched": found.nominal.switched, **found.nominal.rivals}
    columns = {
        "load_pressure_Pa": Column(rise + stand.tank_pressure - stand.reference, GAUGE_PRESSURE, "load pressure"),
        "delivered_share": Column(share, EFFICIENCY, "delivered flow / pump flow"),
        "delivered_flow_m3_s": Column(share * stand.pump_flow(stand.set_point), FLOW, "delivered flow"),
    }
    columns |= {f"loss_{key}_W": Column(losses[key], MEAN_POWER, f"loss, {WAYS[key]}") for key in WAYS}
    for rival, name in RIVALS.items():
        low, high = found.lowest[rival], found.highest[rival]
        open_question = ((low < 0.0) & (high > 0.0)).astype(float)
        columns[f"gain_over_{rival}_W"] = Column(found.gain(rival), MEAN_POWER, f"extra loss, {name}")
        columns[f"gain_over_{rival}_low_W"] = Column(low, MEAN_POWER, f"extra loss, minimum over assumptions, {name}")
        columns[f"gain_over_{rival}_high_W"] = Column(high, MEAN_POWER, f"extra loss, maximum over assumptions, {name}")
        columns[f"undecided_{rival}"] = Column(open_question, FLAG, f"result depends on assumptions, {name}")
    columns["winner"] = Column(np.array(_winners(losses)), None, "least lost, but for displacement control")
    shown = ("load_pressure_Pa", "delivered_share", *(f"loss_{key}_W" for key in WAYS), "winner")
    axes = ("load_pressure_Pa", "delivered_share")
    return Table(title="Ways to supply a load", columns=columns, shown=shown, axes=axes, is_data=True)


def _winners(losses: Mapping[str, Array]) -> list[str]:
    """At each point the way that loses least without displacement control; nothing where the PWM valve is unknown."""
    ways = [key for key in WAYS if key != IDEAL]
    grid = np.array([losses[key] for key in ways])
    least = np.argmin(np.where(np.isfinite(grid), grid, np.inf), axis=0)
    known = np.isfinite(losses["switched"])
    return [WAYS[ways[place]] if seen else "" for place, seen in zip(least, known, strict=True)]


def _numbers(table: Table, found: Spread) -> Iterator[tuple[str, Number]]:
    """Shares of the map where the PWM valve loses less than each rival, as it is and with the spread."""
    known = np.isfinite(found.nominal.switched)
    for rival, name in RIVALS.items():
        cases = (("", found.gain(rival)), ("_low", found.lowest[rival]), ("_high", found.highest[rival]))
        for ending, gain in cases:
            label = {"": "", "_low": ", whatever is assumed", "_high": ", at best"}[ending]
            share = float(np.mean(gain[known] > 0.0))
            yield f"won_over_{rival}{ending}", Number(share, EFFICIENCY, f"won over {name}{label}")
    won = np.array([name == WAYS["switched"] for name in table["winner"]])
    share = float(np.mean(won[known]))
    yield "won_over_all_but_displacement", Number(share, EFFICIENCY, "won over all but displacement control")


def _words(numbers: Mapping[str, Number]) -> Iterator[str]:
    yield (
        "Share of the map over flow and load on which the PWM valve loses less: "
        + ", ".join(f"{_share_words(numbers, key)} than {name}" for key, name in RIVALS.items())
        + ". In brackets: with one value of the valve and one of the rivals at the worst and at the best end."
    )
    share = numbers["won_over_all_but_displacement"].value
    yield (
        f"It loses less than all of them but displacement control on {percent(share, 0)} of the map."
        if share > 0.0
        else "Nowhere on the map it loses less than all of them together, displacement control left out."
    )


def _share_words(numbers: Mapping[str, Number], key: str) -> str:
    share, low, high = (percent(numbers[f"won_over_{key}{ending}"].value, 0) for ending in ("", "_low", "_high"))
    return f"{share} ({low} to {high})"


def _cycle_words(cycles: Cycles) -> Iterator[Finding]:
    for row, duty in enumerate(cycles.duties):
        mine = float(cycles.means["switched"][row])
        if not np.isfinite(mine):
            yield Finding(text=f"{duty.name}: the pump gives less than the cycle asks for.")
            continue
        order = sorted(RIVALS, key=lambda rival: cycles.means[rival][row])
        told = ", ".join(f"{RIVALS[rival]} {with_unit(cycles.means[rival][row], MEAN_POWER, 3)}" for rival in order)
        yield Finding(text=f"On {duty.name} the PWM valve loses {with_unit(mine, MEAN_POWER, 3)}; {told}.")


def _cycle_table(cycles: Cycles) -> Table:
    columns = {"cycle": Column(np.array([duty.name for duty in cycles.duties]), None, "cycle")}
    columns |= {f"loss_{key}_W": Column(cycles.means[key], MEAN_POWER, WAYS[key]) for key in WAYS}
    for rival, name in RIVALS.items():
        for ending, values in (("low", cycles.lowest), ("high", cycles.highest)):
            label = f"{name}: extra loss, {'minimum' if ending == 'low' else 'maximum'} over assumptions"
            columns[f"gain_over_{rival}_{ending}_W"] = Column(values[rival], MEAN_POWER, label)
    shown = ("cycle", *(f"loss_{key}_W" for key in WAYS))
    return Table(title="Mean loss over duty cycles", columns=columns, shown=shown)


def _assumed_table() -> Table:
    """Assumed values of the rivals; of four kinds, so each value stands as a text with its unit."""

    def cells(values: Sequence[float]) -> Array:
        written = [with_unit(value, ASSUMED_KINDS[name][0]) for name, value in zip(RANGES, values, strict=True)]
        return np.array(written)

    low, high = zip(*RANGES.values(), strict=True)
    columns = {
        "assumed": Column(np.array([ASSUMED_KINDS[name][1] for name in RANGES]), None, "assumed"),
        "value": Column(cells([getattr(Assumed(), name) for name in RANGES]), None, "value"),
        "from": Column(cells(low), None, "from"),
        "to": Column(cells(high), None, "to"),
    }
    return Table(title="What is assumed of the rivals", columns=columns)


def _gain_chart() -> Chart:
    return Chart(
        name="supply-gains",
        caption="What each rival loses more than the PWM valve [W], over delivered flow and load pressure; below 0 the "
        "rival wins. Hatched: which of both wins depends on assumptions; grey: more than the valve delivers.",
        table="supply",
        panels=tuple(
            Field(
                x="delivered_share",
                y="load_pressure_Pa",
                z=f"gain_over_{rival}_W",
                hatch=f"undecided_{rival}",
                title=name,
                steps=STEPS,
            )
            for rival, name in RIVALS.items()
        ),
        side_by_side=True,
        share=True,
        columns=3,
        height=5.4,
    )


def _winner_chart(table: Table) -> Chart:
    lines = []
    for colour, name in zip(COLOURS, WAYS.values(), strict=True):
        rows = tuple(int(row) for row in np.flatnonzero(table["winner"] == name))
        if rows:
            lines.append(
                Line(
                    x="delivered_share",
                    y="load_pressure_Pa",
                    label=name,
                    rows=rows,
                    colour=colour,
                    stroke=Stroke.POINTS,
                )
            )
    return Chart(
        name="supply-winners",
        caption="Circuit with the lowest loss versus delivered flow and load pressure, without displacement control "
        "(lowest everywhere).",
        table="supply",
        panels=(Lines(lines=tuple(lines), legend="least lost", left=0.0, right=1.02, low=0.0),),
        height=3.2,
    )
