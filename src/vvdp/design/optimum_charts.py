"""The charts of an optimum and the tables that they draw."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.kinds import (
    DUTY_RATIO,
    EFFICIENCY,
    FLOW,
    MEAN_POWER,
    NUMBER,
    PRESSURE_DIFFERENCE,
    PRESSURE_LEVEL,
    TEMPERATURE,
    Kind,
)
from vvdp.design.optimise import Optimum
from vvdp.design.problem import Bound, Limit, Side
from vvdp.design.proof import Proof
from vvdp.design.quantities import KINDS, LABELS, key
from vvdp.design.sensitivity import AT, LimitCurve
from vvdp.design.variables import value_in
from vvdp.results.chart import Bars, Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table

DROPS = {
    "pressure_drop_nozzle": "nozzles",
    "pressure_drop_centre_section": "centre section",
    "pressure_drop_outlet_turbine": "outlet turbine",
    "pressure_drop_total": "total",
}
LOSSES = {
    "loss_full_open": "fully open",
    "loss_transition": "transitions",
    "loss_leakage": "leakage",
    "loss_compressibility": "compressibility",
    "spool_drive_power": "spool's motor",
    "loss_total": "total",
}
COLOURS = (Colour.RELIEF, Colour.INLET)


def chart_tables(found: Optimum, proven: Sequence[Proof], curves: Sequence[LimitCurve]) -> dict[str, Table]:
    """Operating points, drops and losses before and after, ways between the bounds, and the moved limits."""
    losses = _before_and_after(found, LOSSES)
    simulated = {each.design: each.found.get("loss_total_W") for each in proven if each.point == 0}
    if len(found.problem.points) == 1 and len(simulated) == 2 and None not in simulated.values():
        losses["total, simulated"] = tuple(float(value) for value in simulated.values() if value is not None)
    tables = {
        "points": _points(found),
        "drops": _parts("Pressure drop of the fully open valve", _before_and_after(found, DROPS), PRESSURE_DIFFERENCE),
        "losses": _parts("Losses", losses, MEAN_POWER),
        "bounds": _bounds(found),
    }
    return tables | ({"curves": _curves(found, curves)} if curves else {})


def optimum_charts(found: Optimum, curves: Sequence[LimitCurve]) -> Iterator[Chart]:
    """Drops and losses before and after, the variables between their bounds, and the optimum over moved limits."""
    labels = ("before", "optimum")
    yield Chart(
        name="before-and-after",
        caption="Before and at the optimum: pressure drop of the fully open valve, and losses. All are analytic but "
        "the simulated total loss.",
        table="losses",
        panels=(
            Bars(table="drops", names="part", values=("before_Pa", "optimum_Pa"), labels=labels, colours=COLOURS),
            Bars(names="part", values=("before_W", "optimum_W"), labels=labels, colours=COLOURS),
        ),
        side_by_side=True,
        height=3.0,
    )
    yield Chart(
        name="between-bounds",
        caption="Where the variables lie between their lower (0 %) and upper bound (100 %), in logarithms.",
        table="bounds",
        panels=(Bars(names="label", values=("before", "optimum"), labels=labels, colours=COLOURS),),
        height=0.9 + 0.45 * len(found.problem.bounds),
    )
    for first in range(0, len(curves), 2):
        name = "limits" if not first else f"limits-{first // 2 + 1}"
        yield _curve_chart(name, found, range(first, min(first + 2, len(curves))), curves)


def _before_and_after(found: Optimum, names: Mapping[str, str]) -> dict[str, tuple[float, ...]]:
    pairs = {
        label: tuple(float(found.problem.mean(each, name)) for each in (found.before, found.after))
        for name, label in names.items()
    }
    return {label: pair for label, pair in pairs.items() if any(pair)}


def _parts(title: str, parts: Mapping[str, tuple[float, ...]], kind: Kind) -> Table:
    before, after = (np.array(column) for column in zip(*parts.values(), strict=True))
    columns = {
        "part": Column(np.array(list(parts)), None, "part"),
        key("before", kind): Column(before, kind, title.lower()),
        key("optimum", kind): Column(after, kind, title.lower()),
    }
    return Table(title=title, columns=columns, is_data=True)


def _points(found: Optimum) -> Table:
    points = found.problem.points

    def column(name: str, kind: Kind, label: str) -> tuple[str, Column]:
        values: Array = np.array([float(getattr(point.setup, name)) for point in points])
        return key(name, kind), Column(values, kind, label)

    columns = {"weight": Column(np.array([point.weight for point in points]), NUMBER, "weight")}
    columns |= dict(
        (
            column("flow", FLOW, "pump flow"),
            column("temperature", TEMPERATURE, "oil"),
            column("duty_ratio", DUTY_RATIO, "duty ratio"),
            column("load_pressure", PRESSURE_LEVEL, "load"),
            column("relief_pressure", PRESSURE_LEVEL, "relief setting"),
            column("tank_pressure", PRESSURE_LEVEL, "tank"),
        )
    )
    return Table(title="Operating points", columns=columns)


def _bounds(found: Optimum) -> Table:
    at, bounds = found.problem.points[0].setup, found.problem.bounds
    held = {each.source.bound.variable.name for each in found.active if isinstance(each.source, Side)}
    labels = [f"{b.variable.label}{' *' if b.variable.name in held else ''}" for b in bounds]
    columns = {
        "label": Column(np.array(labels), None, "variable (* at its bound)"),
        "before": _way([value_in(at, b.variable.name) for b in bounds], bounds),
        "optimum": _way([found.values[b.variable.name] for b in bounds], bounds),
    }
    return Table(title="Variables between their bounds", columns=columns, is_data=True)


def _way(values: Sequence[float], bounds: Sequence[Bound]) -> Column:
    """How far each value has come from its lower to its upper bound, in logarithms."""
    ways = [
        float(np.log(value / b.low) / np.log(b.high / b.low)) if b.high > b.low else 0.5
        for value, b in zip(values, bounds, strict=True)
    ]
    return Column(np.array(ways), EFFICIENCY, "position between lower and upper bound")


def _sensitivity_axis(source: Limit | Side) -> tuple[str, Kind, str]:
    """Key, kind and label of what a curve moves."""
    if isinstance(source, Limit):
        kind = KINDS[source.quantity]
        return key(source.quantity, kind), kind, LABELS[source.quantity]
    variable = source.bound.variable
    return key(variable.name, variable.kind), variable.kind, variable.label


def _curves(found: Optimum, curves: Sequence[LimitCurve]) -> Table:
    """All curves below each other: what is moved, each kind in a column of its own, and the least objective."""
    count = len(curves[0].values)
    columns: dict[str, Column] = {
        "moved": Column(np.repeat([each.source.words for each in curves], count), None, "moved")
    }
    for place, each in enumerate(curves):
        name, kind, label = _sensitivity_axis(each.source)
        if name not in columns:
            columns[name] = Column(np.full(count * len(curves), np.nan), kind, label)
        columns[name].values[place * count : (place + 1) * count] = each.values
    kind = KINDS[found.problem.objective]
    least: Any = np.concatenate([each.objectives for each in curves])
    label = f"least {LABELS[found.problem.objective]}"
    columns[key(f"least_{found.problem.objective}", kind)] = Column(least, kind, label)
    return Table(title="The optimum over its limits", columns=columns, is_data=True)


def _curve_chart(name: str, found: Optimum, places: range, curves: Sequence[LimitCurve]) -> Chart:
    objective = key(f"least_{found.problem.objective}", KINDS[found.problem.objective])
    panels = []
    for place in places:
        each = curves[place]
        x, count = _sensitivity_axis(each.source)[0], len(each.values)
        rows = tuple(range(place * count, (place + 1) * count))
        panels.append(
            Lines(
                lines=(
                    Line(x=x, y=objective, rows=rows, colour=Colour.LOAD),
                    Line(
                        x=x, y=objective, rows=(rows[AT],), label="optimum", colour=Colour.INLET, stroke=Stroke.POINTS
                    ),
                ),
                title=each.source.words,
            )
        )
    best = with_unit(found.objective, KINDS[found.problem.objective])
    return Chart(
        name=name,
        caption="The least objective when one limit or bound is moved and all else stays. The dot is the optimum, "
        f"{best}; a line ends where no design is left.",
        table="curves",
        panels=tuple(panels),
        side_by_side=True,
        height=2.4,
    )
