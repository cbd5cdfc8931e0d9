"""Comparison of parts of the valve with the whole that they make up: the valve, or its sleeve without spool."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import (
    COUNT,
    DENSITY,
    FLOW,
    SIGNED_PRESSURE,
    SPEED,
    TORQUE,
    Kind,
)
from vvdp.cfd.centre import CentreOrder, centre_case, turned_centre
from vvdp.cfd.parts_study import PartRun
from vvdp.cfd.rail import RailOrder, rail_case, sleeve_case, turned_rail, turned_sleeve
from vvdp.cfd.rail_result import METHOD, Told
from vvdp.cfd.series import NamedCase
from vvdp.cfd.state_table import QUALITY, quality_listings, residual_findings, state_columns
from vvdp.cfd.turbine import TurbineOrder, turbine_case, turned_turbine, turned_valve, valve_case
from vvdp.geometry.shape import perpendicular_area
from vvdp.results.chart import Bars, Chart, Colour
from vvdp.results.result import Column, Finding, Grade, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.torque import inlet_torque, outlet_torque

SLEEVE, VALVE = "cfd sleeve", "cfd valve"
RAIL, CENTRE, TURBINE = "rail and nozzles", "centre section", "outlet turbine"
WITHOUT_SPOOL, WHOLE, SUM = "sleeve without spool", "whole valve", "sum of the sections"
REMOVED = (
    "On a test rig rail and nozzles are measured with the spool taken out: the jets enter the bore, which both "
    "collectors drain. What bore and collectors add to the drop is the difference from the rail alone, whose nozzles "
    "end in a bore of one pressure."
)
SECTIONS = (
    "The whole way of the oil to the load, solved as one, beside its sections solved one by one: a rail that ends in "
    "an open bore, jets that enter the centre section evenly, and a turbine that the oil enters without swirl. The "
    "centre section counts with its static drop: the dynamic pressure of the jets is lost in the rail's. The spool "
    "turns; its oil is solved in its frame, with the nozzles open."
)
LEFT_OUT = ("Leakage, cavitation, and the warming of the oil.", "What a finer mesh would change; compare the grids.")
COMMON = {
    "flow_m3_s": (FLOW, "flow"),
    "pressure_drop_Pa": (SIGNED_PRESSURE, "pressure drop"),
    "parts_drop_Pa": (SIGNED_PRESSURE, "pressure drop of the parts"),
    "drop_difference_Pa": (SIGNED_PRESSURE, "pressure drop that the parts do not have"),
    "laws_drop_Pa": (SIGNED_PRESSURE, "pressure drop by the system's own laws"),
    "density_kg_m3": (DENSITY, "density"),
}
TURNING = {
    "speed_rad_s": (SPEED, "spool speed"),
    "whole_torque_N_m": (TORQUE, "torque"),
    "whole_momentum_torque_N_m": (TORQUE, "torque, by angular momentum"),
    "parts_torque_N_m": (TORQUE, "torque of the parts"),
    "laws_torque_N_m": (TORQUE, "torque by the system's own laws"),
}


class PartLaw(NamedTuple):
    """Prediction of the system for a part: drop [Pa], and torque [N m], nan where none of it turns."""

    drop: float
    torque: float = math.nan


def sleeve_parts(order: RailOrder) -> tuple[NamedCase, ...]:
    """The sleeve without its spool, and the rail alone."""
    return (
        NamedCase(WITHOUT_SPOOL, sleeve_case(order, turned_sleeve(order))),
        NamedCase(RAIL, rail_case(order, turned_rail(order))),
    )


def valve_parts(rail: RailOrder, centre: CentreOrder, turbine: TurbineOrder) -> tuple[NamedCase, ...]:
    """The whole valve, and its sections."""
    return (
        NamedCase(WHOLE, valve_case(turbine, turned_valve(turbine))),
        NamedCase(RAIL, rail_case(rail, turned_rail(rail))),
        NamedCase(CENTRE, centre_case(centre, turned_centre(centre))),
        NamedCase(TURBINE, turbine_case(turbine, turned_turbine(turbine))),
    )


def sleeve_result(order: RailOrder, runs: Sequence[PartRun], told: Told) -> Result:
    """The result of runs of `sleeve_parts`; its sections name drawings that the page has."""
    law = PartLaw(_drops(order)[0])
    table = _table(runs, [run.solved.judgement.value for run in runs], [PartLaw(math.nan), law])
    whole, part = table["drop_Pa"]
    numbers = {
        "flow_m3_s": order.flow,
        "pressure_drop_Pa": whole,
        "parts_drop_Pa": part,
        "drop_difference_Pa": whole - part,
        "laws_drop_Pa": law.drop,
        "density_kg_m3": order.fluid.density,
    }
    added, share = with_unit(whole - part, SIGNED_PRESSURE), percent(whole / part - 1.0)
    finding = Finding(text=f"Bore and collectors change the drop of rail and nozzles by {added}, {share}.")
    return _result(SLEEVE, order, (numbers, COMMON), (table, REMOVED), (told, runs, [finding]))


def valve_result(order: TurbineOrder, runs: Sequence[PartRun], told: Told) -> Result:
    """The result of runs of `valve_parts`; its sections name drawings that the page has."""
    density, valve, flow = order.fluid.density, order.valve, order.flow
    nozzle, middle, outlet = _drops(order)
    laws = [
        PartLaw(nozzle),
        PartLaw(middle, inlet_torque(flow, 1.0, density, valve)),
        PartLaw(outlet, outlet_torque(flow, order.speed, density, valve)),
    ]
    law = PartLaw(sum(each.drop for each in laws), sum(each.torque for each in laws[1:]))
    jet = 0.5 * density * (flow / perpendicular_area(order.shape, valve)) ** 2
    drops = [run.solved.judgement.value - (jet if run.name == CENTRE else 0.0) for run in runs]
    table = _table(runs, drops, [law, *laws])
    numbers = {
        "flow_m3_s": flow,
        "speed_rad_s": order.speed,
        "pressure_drop_Pa": drops[0],
        "parts_drop_Pa": math.fsum(drops[1:]),
        "drop_difference_Pa": drops[0] - math.fsum(drops[1:]),
        "laws_drop_Pa": law.drop,
        "whole_torque_N_m": runs[0].torques.forces,
        "whole_momentum_torque_N_m": runs[0].torques.momentum,
        "parts_torque_N_m": float(np.nansum([run.torques.forces for run in runs[1:]])),
        "laws_torque_N_m": law.torque,
        "density_kg_m3": density,
    }
    return _result(VALVE, order, (numbers, {**COMMON, **TURNING}), (table, SECTIONS), (told, runs, [*_beside(numbers)]))


def _drops(order: RailOrder | TurbineOrder) -> tuple[float, float, float]:
    """Drops of rail with nozzles, centre section and outlet turbine by the laws of the system [Pa]."""
    drops = turbulent_drops(order.flow, 1.0, order.fluid.density, order.valve)
    return float(drops.nozzle), float(drops.centre_section), float(drops.outlet_turbine)


def _table(runs: Sequence[PartRun], drops: Sequence[float], laws: Sequence[PartLaw]) -> Table:
    columns = {
        "part": Column(np.array([run.name for run in runs], str), None, ""),
        "drop_Pa": Column(np.array(drops), SIGNED_PRESSURE, "drop"),
        "law_drop_Pa": Column(np.array([law.drop for law in laws]), SIGNED_PRESSURE, "drop, law of the system"),
        "torque_N_m": Column(np.array([run.torques.forces for run in runs]), TORQUE, "torque"),
        "momentum_torque_N_m": Column(
            np.array([run.torques.momentum for run in runs]), TORQUE, "torque, by angular momentum"
        ),
        "law_torque_N_m": Column(np.array([law.torque for law in laws]), TORQUE, "torque, law of the system"),
        "cells": Column(np.array([float(run.solved.mesh.cells) for run in runs]), COUNT, "cells"),
        **state_columns([run.solved for run in runs]),
    }
    return Table(title="The whole and its parts", columns=columns)


def _result(
    verb: str,
    order: RailOrder | TurbineOrder,
    found: tuple[dict[str, float], dict[str, tuple[Kind, str]]],
    shown: tuple[Table, str],
    said: tuple[Told, Sequence[PartRun], Sequence[Finding]],
) -> Result:
    (numbers, quantities), (table, words), (told, runs, findings) = found, shown, said
    whole = str(table.columns["part"].values[0])
    return Result(
        verb=verb,
        title=f"{whole[0].upper()}{whole[1:]} and its parts",
        system=told.system,
        manner=f"{METHOD} {words}",
        references=told.sources,
        conditions=told.conditions({"flow": with_unit(order.flow, FLOW)}, order),
        left_out=LEFT_OUT,
        numbers=numbers_of(numbers, quantities),
        listings={
            "found": listing_of(numbers, quantities),
            **quality_listings([run.name for run in runs], [run.solved for run in runs]),
        },
        tables={"parts": table},
        charts={"drops": _chart()},
        findings=(*findings, *_restless(runs), *residual_findings([run.solved for run in runs])),
        sections=(
            Section(title="The whole beside its parts", words=(words,), shows=("found", "drops", "parts")),
            Section(title="The oil", shows=("geometry",), starts_page=True),
            Section(title="The flow", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(METHOD,), shows=("conditions",)),
        ),
        seconds=math.fsum(run.seconds for run in runs),
    )


def _chart() -> Chart:
    return Chart(
        name="drops",
        caption="Pressure drops of the whole and its parts, computed and by the laws of the system.",
        table="parts",
        panels=(Bars(names="part", values=("drop_Pa", "law_drop_Pa"), colours=(Colour.LOAD, Colour.RELIEF)),),
        height=2.0,
    )


def _beside(numbers: dict[str, float]) -> Iterator[Finding]:
    for words, whole, parts, law, kind in (
        ("drop", "pressure_drop_Pa", "parts_drop_Pa", "laws_drop_Pa", SIGNED_PRESSURE),
        ("torque", "whole_torque_N_m", "parts_torque_N_m", "laws_torque_N_m", TORQUE),
    ):
        found, added, given = (with_unit(numbers[key], kind) for key in (whole, parts, law))
        off = percent(numbers[whole] / numbers[parts] - 1.0, 0)
        yield Finding(
            text=f"The {words} of the whole valve is {found}, {off} off the {added} of its sections; the laws of the "
            f"system say {given}."
        )


def _restless(runs: Sequence[PartRun]) -> Iterator[Finding]:
    if restless := [run.name for run in runs if not run.solved.settled]:
        text = f"Still changing after all iterations: {', '.join(restless)}."
        yield Finding(title="Not settled", grade=Grade.WARNING, text=text, remedy="Take a finer grid.")
