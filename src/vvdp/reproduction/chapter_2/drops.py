"""Section 2.4: pressure drop of the open valve and of its sections."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.kinds import DISCHARGE_COEFFICIENT, FLOW, LENGTH, NUMBER, PRESSURE_DIFFERENCE, SIGNED_PRESSURE
from vvdp.cfd.kept import KeptStudy
from vvdp.numerics.least_squares import fit
from vvdp.numerics.power_laws import drop_laws, power_columns
from vvdp.numerics.square_law import square_law
from vvdp.reproduction.chapter_2 import valve as here
from vvdp.reproduction.chapter_2.computed import kept_or_none, kept_table, turbine_over
from vvdp.reproduction.chapter_2.valve import DENSITY, LPM
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Table
from vvdp.results.verdict import (
    Statement,
    bound_statement,
    digit_statement,
    drawing_statement,
    missing_statement,
    number_statement,
    open_statement,
)
from vvdp.rigs.pressure_drop import DROPS, pressure_drop
from vvdp.valve.branch import centre_resistance

WHOLE, LAWS = 6.61e5, "half of the last digit of each coefficient and of the sum"
WHOLE_WIDTH = 11955.0
"""What these digits make of the sum of eqs. 2.3 to 2.5 at 40 lpm [Pa]; its arithmetic is in expected.csv."""
RAIL_INDEX, CENTRE_INDEX, TURBINE_INDEX = 0.10634, 0.03131, 0.02382
RAIL, CENTRE, TURBINE = (
    f"the grids' convergence index of the {section} (fig. {figure})"
    for section, figure in (("rail, R/5.66 to R/11.3", "2.7"), ("centre section", "2.8"), ("outlet turbine", "2.9"))
)
ARM, WINDOWS = "the nozzles' arm", "the shape of the windows"
"""What was chosen so that computed drops come out as printed: docs/models/cfd.md."""
PLANE = "the plane of section 2.4.2 is one through logarithms; in the second run a surface through the drops"
M, N, K = 1.91, 3.22, 1.45e-6
"""Exponents of flow and diameter, and the coefficient, of eq. 2.4."""


def _curve_chart(number: str, caption: str, *lines: Line) -> Chart:
    panel = Lines(lines=lines, label="pressure drop", low=0.0, left=0.0)
    return Chart(name=f"figure-{number}", caption=caption, table="drops", panels=(panel,), height=2.6)


def _law_tables() -> Mapping[str, Table]:
    """Drops of the open valve and its sections over the flow, by the laws, as the rig has them."""
    return {"drops": pressure_drop(here.stand(), openings=(1.0,)).tables[DROPS]}


def _law(section: str, label: str, colour: str) -> Line:
    return Line(x="flow_m3_s", y=f"pressure_drop_{section}_Pa", label=label, colour=colour)


def _with_study(study: KeptStudy | None, drop: str) -> tuple[dict[str, Table], tuple[Line, ...]]:
    """The table and the marks of a kept study, where it is there."""
    if study is None:
        return {}, ()
    return {"computed": kept_table(study)}, (
        Line(x="flow_m3_s", y=drop, label="computed", stroke=Stroke.POINTS, colour=Colour.RED, table="computed"),
    )


def figure_2_11() -> Reproduction:
    """The drop of the whole valve; the measured curves are lost."""
    lost = "the measured drops, which no number of the text gives"
    statements = (
        number_statement(
            "drop of the whole valve at 40 lpm",
            WHOLE,
            sum(here.open_drops()),
            PRESSURE_DIFFERENCE,
            tolerance=WHOLE_WIDTH,
            because=LAWS,
            note="section 2.6 has the number",
        ),
        open_statement(
            "rail and nozzles, computed less measured", "0.1 bar lower", "no measured value in the text", lost
        ),
        open_statement(
            "whole valve, computed beside measured", "a very good match", "no measured value in the text", lost
        ),
    )
    lines = (
        _law("total", "whole valve", Colour.INK),
        _law("nozzle", "rail and nozzles", Colour.INLET),
        _law("outlet_turbine", "outlet turbine", Colour.TANK),
    )
    caption = "Drop of the open valve and two of its sections by eqs. 2.3 to 2.5."
    return Reproduction(statements=statements, tables=_law_tables(), charts=(_curve_chart("2.11", caption, *lines),))


def figure_2_12() -> Reproduction:
    """Rail and nozzles over the flow: a parabola, and its discharge coefficient."""
    study = kept_or_none("rail-flows")
    what = "discharge coefficient of the computed drops"
    if study is None:
        found: tuple[Statement, ...] = (missing_statement(what, "0.61, a parabola", "the study rail-flows"),)
    else:
        laws = drop_laws(study["flow_m3_s"], study["pressure_drop_Pa"])
        coefficient = np.sqrt(0.5 * DENSITY / laws.orifice.coefficients[0]) / here.valve().nozzle_area
        found = (
            number_statement(
                what,
                0.61,
                float(coefficient),
                DISCHARGE_COEFFICIENT,
                share=0.5 * RAIL_INDEX,
                because=f"half of {RAIL}",
                calibration=ARM,
                note=_range_note(study, _by_approach("rail-models", float(coefficient))),
            ),
            bound_statement(
                "exponent of the flow in the computed drops",
                float(laws.power.coefficients[1]),
                NUMBER,
                low=1.85,
                high=2.0,
                source="a parabola",
                because="the margin of ours that a parabola may miss by",
                note="flows of one mesh, whose error changes with the flow",
            ),
        )
    tables, marks = _with_study(study, "pressure_drop_Pa")
    lines = (_law("nozzle", "eq. 2.3", Colour.INLET), *marks)
    chart = _curve_chart("2.12", "Drop of inlet rail and nozzles over the flow.", *lines)
    return Reproduction(statements=found, tables={**_law_tables(), **tables}, charts=(chart,))


def _by_approach(study: str, coefficient: float) -> dict[str, float]:
    """A discharge coefficient as each approach of a kept study of models has it; empty where there is none."""
    models = kept_or_none(study)
    if models is None:
        return {}
    names = dict.fromkeys(models["approach"].tolist())
    rows = {name: models["approach"] == name for name in names}
    drops = {
        name: square_law(*(models[key][row] for key in ("flow_m3_s", "pressure_drop_Pa"))).coefficient
        for name, row in rows.items()
    }
    first = next(iter(drops.values()))
    return {name: coefficient * (first / drop) ** 0.5 for name, drop in drops.items()}


def _range_note(study: KeptStudy, found: Mapping[str, float]) -> str:
    """The range over models and schemes, and what the grids leave open."""
    left = f"the grids leave {100.0 * study.grid_index:.1f} % of the drop open"
    if not found:
        return left
    return f"{min(found.values()):.3f} to {max(found.values()):.3f} by models and schemes ({'; '.join(found)}); {left}"


def scaled_table() -> Table:
    """Drop of the centre section by eq. 2.4 over the flow, at three diameters."""
    flow, diameter = (a.ravel() for a in np.meshgrid(np.linspace(10, 80, 36) * LPM, DIAMETERS, indexing="ij"))
    drop = flow**M / (K * diameter**N)
    columns = {
        "flow_m3_s": Column(flow, FLOW, "flow"),
        "diameter_m": Column(diameter, LENGTH, "spool diameter"),
        "drop_Pa": Column(drop, PRESSURE_DIFFERENCE, "drop"),
    }
    return Table(title="Centre section", columns=columns, axes=("flow_m3_s", "diameter_m"))


DIAMETERS = 25.4e-3 * np.array([0.8, 1.0, 1.25])
"""Of the spool, scaled in radius alone [m]."""


class CentreFit(NamedTuple):
    """Exponents of flow and diameter of eq. 2.4 as fitted to computed drops, and the largest misfit [Pa]."""

    flow: float
    diameter: float
    misfit: float


def centre_fits(study: KeptStudy) -> tuple[CentreFit, CentreFit]:
    """A plane through the logarithms of the computed drops, and a surface through the drops, each by least squares."""
    from scipy.optimize import least_squares

    flow, diameter, drop = (study[key] for key in ("flow_m3_s", "diameter_m", "static_drop_Pa"))
    columns = np.column_stack([*power_columns(flow), -np.log(diameter)])

    def misfits(coefficients: Array) -> Array:
        found: Array = np.exp(columns @ coefficients) - drop
        return found

    def as_fitted(coefficients: Array) -> CentreFit:
        _, m, n = coefficients.tolist()
        return CentreFit(m, n, float(np.abs(misfits(coefficients)).max()))

    plane = fit(list(columns.T), np.log(drop)).coefficients
    return as_fitted(plane), as_fitted(least_squares(misfits, plane, method="lm").x)


def _centre_statements(study: KeptStudy | None) -> tuple[Statement, ...]:
    if study is None:
        source = "m = 1.91, n = 3.22, error below 0.05 bar"
        return (missing_statement("law of the computed drops", source, "the study centre-flows"),)
    plane, surface = centre_fits(study)
    exponents: Any = {"share": CENTRE_INDEX, "because": CENTRE, "calibration": WINDOWS, "assumption": PLANE}
    return (
        number_statement("exponent of the flow", M, plane.flow, other=surface.flow, **exponents),
        number_statement("exponent of the diameter", N, plane.diameter, other=surface.diameter, **exponents),
        bound_statement(
            "largest misfit",
            plane.misfit,
            PRESSURE_DIFFERENCE,
            high=0.05e5,
            other=surface.misfit,
            assumption=PLANE,
        ),
        _finer_exponent(kept_or_none("centre-flows-medium")),
    )


def _finer_exponent(study: KeptStudy | None) -> Statement:
    """The exponent of the flow on a finer grid, where one diameter was computed."""
    what = "exponent of the flow on a finer grid, one diameter"
    if study is None:
        return missing_statement(what, f"{M}", "the study centre-flows-medium")
    m = fit(power_columns(study["flow_m3_s"]), np.log(study["static_drop_Pa"])).coefficients[1]
    return number_statement(what, M, float(m), NUMBER, share=CENTRE_INDEX, because=CENTRE, calibration=WINDOWS)


def figure_2_13() -> Reproduction:
    """The centre section over flow and diameter, and the law that is fitted to it."""
    study = kept_or_none("centre-flows")
    table = scaled_table()
    lines = tuple(
        Line(
            x="flow_m3_s",
            y="drop_Pa",
            label=f"{1e3 * d:.1f} mm",
            colour=colour,
            rows=tuple(np.flatnonzero(table["diameter_m"] == d).tolist()),
        )
        for d, colour in zip(DIAMETERS, shades(DIAMETERS.size), strict=True)
    )
    tables, marks = _with_study(study, "static_drop_Pa")
    chart = _curve_chart("2.13", "Drop of the centre section by eq. 2.4, at three spool diameters.", *lines, *marks)
    return Reproduction(statements=_centre_statements(study), tables={"drops": table, **tables}, charts=(chart,))


def figure_2_14() -> Reproduction:
    """The outlet turbine over the flow: a parabola, and its discharge coefficient."""
    study = turbine_over("flow_m3_s")
    tables, marks = _with_study(study, "turbine_drop_Pa")
    lines = (_law("outlet_turbine", "eq. 2.5", Colour.TANK), *marks)
    chart = _curve_chart("2.14", "Drop of the outlet turbine over the flow.", *lines)
    return Reproduction(statements=(_turbine_statement(study),), tables={**_law_tables(), **tables}, charts=(chart,))


def _turbine_statement(study: KeptStudy | None) -> Statement:
    """The discharge coefficient over all flows, the spool at rest, where they were computed; else at 40 lpm."""
    area, printed = here.valve().outlet_area, 0.677
    if study is not None:
        at_rest = study["speed_rad_s"] == 0.0
        laws = drop_laws(study["flow_m3_s"][at_rest], study["turbine_drop_Pa"][at_rest])
        found = float(np.sqrt(0.5 * DENSITY / laws.orifice.coefficients[0]) / area)
        what = "discharge coefficient of the computed drops"
        approaches = _by_approach("turbine-models", found)
        return number_statement(
            what,
            printed,
            found,
            DISCHARGE_COEFFICIENT,
            share=0.5 * TURBINE_INDEX,
            because=f"half of {TURBINE}",
            other=approaches.get("k-epsilon, first order"),
            assumption="convection of second order; in the second run of first order, as in the source",
            note=_range_note(study, approaches),
        )
    grids = kept_or_none("turbine-grids")
    what = "discharge coefficient of the computed drop at 40 lpm"
    if grids is None:
        return missing_statement(what, "0.677, a parabola", "a study of the turbine")
    finest = int(grids["cells"].argmax())
    drop = float(grids["pressure_drop_Pa"][finest])
    found = here.FLOW / (area * float(np.sqrt(2.0 * drop / DENSITY)))
    return number_statement(
        what, printed, found, DISCHARGE_COEFFICIENT, share=0.5 * TURBINE_INDEX, because=f"half of {TURBINE}"
    )


def figure_2_15() -> Reproduction:
    """The outlet rail, whose curve is lost; computed for the shape that is assumed here."""
    study = kept_or_none("turbine-flows") or kept_or_none("turbine-lengths")
    shape = "the shape of the rail, which the text does not give"
    if study is None:
        return Reproduction(
            statements=(open_statement("drop of the outlet rail", "a curve", "no study of the turbine is kept", shape),)
        )
    flow: Any = study["flow_m3_s"]
    row = int(np.argmin(np.abs(flow - here.FLOW)))  # of several, the spool at rest
    drop = with_unit(float(study["collector_drop_Pa"][row]), SIGNED_PRESSURE)
    found = drawing_statement("drop of the outlet rail and its port, a curve without numbers", f"{drop} at 40 lpm")
    marks = Line(x="flow_m3_s", y="collector_drop_Pa", stroke=Stroke.POINTS)
    chart = _curve_chart("2.15", "Drop of the outlet rail with its port, as computed.", marks)
    return Reproduction(statements=(found,), tables={"drops": kept_table(study)}, charts=(chart,))


def equation_2_3() -> Reproduction:
    """The nozzles as one orifice with the area of all."""
    by_hand = 0.5 * DENSITY * (here.FLOW / (0.61 * 36.5e-6)) ** 2
    drop = here.open_drops()[0]
    return Reproduction(
        statements=(
            number_statement("drop at 40 lpm", by_hand, drop, PRESSURE_DIFFERENCE, share=1e-6, because="rounding"),
            number_statement(
                "the same beside the computed 4.17 bar of 2.7",
                4.17e5,
                drop,
                PRESSURE_DIFFERENCE,
                tolerance=0.005e5 + 2.0 * 0.005 / 0.61 * drop,
                because="half of the last digit of 4.17 bar and of 0.61",
            ),
        )
    )


def equation_2_4() -> Reproduction:
    """The centre section: its coefficient has no unit in the text; with SI units it makes sense."""
    si = here.FLOW**M / (K * 25.4e-3**N)
    other = 1e5 * 40.0**M / (K * 25.4**N)
    drop = float(centre_resistance(here.valve()) * here.FLOW**M)
    whole = sum(here.open_drops())
    return Reproduction(
        statements=(
            number_statement("drop at 40 lpm", si, drop, PRESSURE_DIFFERENCE, share=1e-6, because="rounding"),
            bound_statement(
                "drop at 40 lpm with k in SI units",
                si,
                PRESSURE_DIFFERENCE,
                low=0.0,
                high=whole,
                source="k = 1.45e-6 without a unit",
                other=other,
                assumption="m³/s, m and Pa; in the second run lpm, mm and bar",
            ),
        )
    )


def equation_2_5() -> Reproduction:
    """The outlet turbine as an orifice."""
    by_hand = 0.5 * DENSITY * (here.FLOW / (0.677 * 46.8e-6)) ** 2
    found = number_statement(
        "drop at 40 lpm", by_hand, here.open_drops()[2], PRESSURE_DIFFERENCE, share=1e-6, because="rounding"
    )
    return Reproduction(statements=(found,))


def _computed_flows() -> tuple[Statement, ...]:
    """The largest flows of the computed sections, where the text names them."""
    found = []
    for part, study, lpm in (("inlet rail", "rail-flows", 80.0), ("outlet turbine", "turbine-flows", 60.0)):
        kept, what = kept_or_none(study), f"largest computed flow of the {part}"
        if kept is None:
            found.append(missing_statement(what, f"{lpm:g} lpm", f"the study {study}"))
            continue
        found.append(
            digit_statement(what, lpm * here.LPM, float(np.max(kept["flow_m3_s"])), FLOW, tolerance=0.5 * here.LPM)
        )
    return tuple(found)


def section_2_4() -> Reproduction:
    """The coefficients, within what they are stated to lie, and the flows that they rest on."""
    v = here.valve()
    coefficients = (("nozzles", v.nozzle_discharge_coefficient), ("outlet turbine", v.outlet_discharge_coefficient))
    exponents = (("flow", v.centre_flow_exponent, 1.0, 2.0), ("diameter", v.centre_diameter_exponent, 2.0, 4.0))
    return Reproduction(
        statements=(
            *(
                bound_statement(
                    f"discharge coefficient of the {name}",
                    value,
                    DISCHARGE_COEFFICIENT,
                    low=0.6,
                    high=0.7,
                    because="the band that the text names for orifices",
                )
                for name, value in coefficients
            ),
            *(
                bound_statement(
                    f"exponent of the {name} in the centre section",
                    value,
                    NUMBER,
                    low=low,
                    high=high,
                    because="pipe at one end, orifice at the other",
                )
                for name, value, low, high in exponents
            ),
            *_computed_flows(),
        )
    )


EQUATION, FIGURE = ItemKind.EQUATION, ItemKind.FIGURE
ITEMS = (
    Item(FIGURE, "2.11", "Comparison of valve pressure drop", figure_2_11),
    Item(FIGURE, "2.12", "Pressure drop across the inlet rail with nozzles", figure_2_12),
    Item(FIGURE, "2.13", "Pressure drop of the centre PWM section", figure_2_13),
    Item(FIGURE, "2.14", "Pressure drop across the spool outlet turbine", figure_2_14),
    Item(FIGURE, "2.15", "Pressure drop across the outlet pressure rail", figure_2_15),
    Item(EQUATION, "2.3", "Drop of the nozzles", equation_2_3),
    Item(EQUATION, "2.4", "Drop of the centre section", equation_2_4),
    Item(EQUATION, "2.5", "Drop of the outlet turbine", equation_2_5),
    Item(ItemKind.SECTION, "2.4", "Coefficients of the drops", section_2_4),
)
