"""Effect of the model of turbulence and of the scheme on the laws of drop and torque of a part of the valve."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent
from vvdp.base.kinds import COUNT, DENSITY, EFFICIENCY, FLOW, NUMBER
from vvdp.cfd.grids_result import OnGrids
from vvdp.cfd.numerics import SCHEMES, Phase
from vvdp.cfd.rail import RailOrder
from vvdp.cfd.rail_result import Told
from vvdp.cfd.solve import Solved
from vvdp.cfd.state_table import QUALITY, quality_listings, restless_findings, state_columns
from vvdp.cfd.turbulence import LAMINAR, SHEAR_STRESS, STANDARD, Turbulence
from vvdp.numerics.square_law import square_law
from vvdp.results.chart import Chart, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Result, Section, Table, numbers_of

VERB = "cfd models"
EFFECT = (
    "Each approach is solved at all flows on one mesh. To its drops, and to its torques, c Q^2 and k Q^m are fitted by "
    "least squares, of the logarithm for the power. The ratio is that of c to the first approach, the standard "
    "k-epsilon model with a scheme of second order; a discharge coefficient goes with one over the root of it."
)
SQUARES = {"pressure_drop_Pa": "drop", "static_drop_Pa": "static drop", "torque_N_m": "torque"}
"""Columns that grow about as the square of the flow, and their names."""
ENDS: Mapping[str, Callable[[Array], float]] = {"low": np.nanmin, "high": np.nanmax}
"""Ends of a range over all approaches."""
QUANTITIES = {
    "drop_ratio_low": (EFFICIENCY, "drop, ratio to the first approach, least"),
    "drop_ratio_high": (EFFICIENCY, "drop, ratio to the first approach, largest"),
    "drop_exponent_low": (NUMBER, "exponent of the flow in the drop, least"),
    "drop_exponent_high": (NUMBER, "exponent of the flow in the drop, largest"),
    "static_drop_ratio_low": (EFFICIENCY, "static drop, ratio to the first approach, least"),
    "static_drop_ratio_high": (EFFICIENCY, "static drop, ratio to the first approach, largest"),
    "static_drop_exponent_low": (NUMBER, "exponent of the flow in the static drop, least"),
    "static_drop_exponent_high": (NUMBER, "exponent of the flow in the static drop, largest"),
    "torque_ratio_low": (EFFICIENCY, "torque, ratio to the first approach, least"),
    "torque_ratio_high": (EFFICIENCY, "torque, ratio to the first approach, largest"),
    "torque_exponent_low": (NUMBER, "exponent of the flow in the torque, least"),
    "torque_exponent_high": (NUMBER, "exponent of the flow in the torque, largest"),
    "cells": (COUNT, "cells"),
    "density_kg_m3": (DENSITY, "density"),
}


class Approach(NamedTuple):
    """How a flow is solved: model of turbulence, and schemes."""

    turbulence: Turbulence
    phases: tuple[Phase, ...]


APPROACHES: Mapping[str, Approach] = {
    "k-epsilon": Approach(STANDARD, SCHEMES["second-order"]),
    "k-epsilon, first order": Approach(STANDARD, SCHEMES["first-order"]),
    "k-omega SST": Approach(SHEAR_STRESS, SCHEMES["second-order"]),
    "laminar": Approach(LAMINAR, SCHEMES["second-order"]),
}
"""Turbulence model and schemes of each approach; the first is the one of all other studies, the second that of the
source."""


def models_result(order: RailOrder, part: OnGrids, flows: Sequence[float], about: Told) -> Result:
    """The result of a part of the valve by each of `APPROACHES` at each of `flows` [m^3/s], in this order.

    Sections name drawings that the page has.
    """
    table = _runs(part, flows)
    laws = _laws(table, len(flows))
    numbers = {**_numbers(laws), "cells": float(table["cells"][0]), "density_kg_m3": order.fluid.density}
    words, lengths = part.lengths
    names = [
        f"{model}, {flow * 60e3:.3g} lpm" for model, flow in zip(table["approach"], table["flow_m3_s"], strict=True)
    ]
    return Result(
        verb=VERB,
        title=f"{part.title} by several models of turbulence",
        system=about.system,
        manner=part.manner,
        references=("wang2017",),
        conditions={"oil": about.oil, "grid": about.grid, "turbulence": "; ".join(APPROACHES)},
        left_out=("Cavitation, and the warming of the oil.", "What a finer mesh would change; compare the grids."),
        numbers=numbers_of(numbers, QUANTITIES),
        listings={"lengths": lengths, **quality_listings(names, part.solved)},
        tables={"laws": laws, "runs": table},
        charts={"drop-over-flow": _chart(len(flows))},
        findings=tuple(_findings(numbers, part.solved)),
        sections=(
            Section(title="Laws by each approach", words=(EFFECT,), shows=("laws", "drop-over-flow", "runs")),
            Section(title=part.title, words=(words,), shows=("geometry", "lengths"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(part.manner,), shows=("conditions",)),
        ),
        seconds=sum(run.took for run in part.solved),
    )


def _runs(part: OnGrids, flows: Sequence[float]) -> Table:
    names = np.repeat(list(APPROACHES), len(flows))
    columns = {
        "approach": Column(names.astype(str), None, "approach"),
        "flow_m3_s": Column(np.tile(np.array(flows), len(APPROACHES)), FLOW, "flow"),
        **part.columns,
        "cells": Column(np.array([float(run.mesh.cells) for run in part.solved]), COUNT, "cells"),
        **state_columns(part.solved),
    }
    return Table(title="Runs", columns=columns)


def _laws(table: Table, flows: int) -> Table:
    """A row for each approach: of each value that goes about with the square, the ratio to the first, and exponent."""
    columns: dict[str, Column] = {"approach": Column(table["approach"][::flows], None, "approach")}
    for key in (key for key in SQUARES if key in table.columns):
        pieces = [slice(start, start + flows) for start in range(0, len(table[key]), flows)]
        found = [square_law(table["flow_m3_s"][piece], table[key][piece]) for piece in pieces]
        stem = SQUARES[key].replace(" ", "_")
        ratios = np.array([each.coefficient / found[0].coefficient for each in found])
        columns[f"{stem}_ratio"] = Column(ratios, EFFICIENCY, f"{SQUARES[key]}, ratio to the first")
        exponents = np.array([each.exponent for each in found])
        columns[f"{stem}_exponent"] = Column(exponents, NUMBER, f"{SQUARES[key]}, exponent of the flow")
    return Table(title="Laws", columns=columns)


def _numbers(laws: Table) -> dict[str, float]:
    """The range of each column of the laws over all approaches."""
    keys = [key for key in laws.columns if key != "approach"]
    return {f"{key}_{end}": float(over(laws[key])) for key in keys for end, over in ENDS.items()}


def _chart(flows: int) -> Chart:
    line = Line(x="flow_m3_s", y="pressure_drop_Pa", stroke=Stroke.POINTS, label="computed", width=2)
    return Chart(
        name="drop-over-flow",
        caption=f"Pressure drop versus flow, by {len(APPROACHES)} approaches at {flows} flows.",
        table="runs",
        panels=(Lines(lines=(line,), label="pressure drop", low=0.0, left=0.0),),
    )


def _findings(numbers: Mapping[str, float], solved: Sequence[Solved]) -> Iterator[Finding]:
    for stem, words in ((label.replace(" ", "_"), label) for label in SQUARES.values()):
        if f"{stem}_ratio_low" in numbers:
            low, high = (numbers[f"{stem}_ratio_{end}"] - 1.0 for end in ("low", "high"))
            least, most = (number(numbers[f"{stem}_exponent_{end}"], 3) for end in ("low", "high"))
            yield Finding(
                text=f"The {words} is {percent(low)} to {percent(high)} off that of the first approach, and goes with "
                f"the flow to the power {least} to {most}."
            )
    yield from restless_findings(solved)
