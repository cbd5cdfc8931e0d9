"""Output of `vvdp valve` for a user."""

from collections.abc import Mapping, Sequence
from typing import Any

from vvdp.base import kinds
from vvdp.base.display import display_unit, number, plain, with_unit
from vvdp.cli.screen import console, grid, tell, warn
from vvdp.evaluation.ranges import Ranges
from vvdp.evaluation.valve_unit import ValveUnit

SHOWN = (
    ("pressure drop, nozzles", "pressure_drop_nozzle_Pa", kinds.PRESSURE_DIFFERENCE),
    ("pressure drop, centre section", "pressure_drop_centre_section_Pa", kinds.PRESSURE_DIFFERENCE),
    ("pressure drop, outlet turbine", "pressure_drop_outlet_turbine_Pa", kinds.PRESSURE_DIFFERENCE),
    ("pressure drop, total", "pressure_drop_total_Pa", kinds.PRESSURE_DIFFERENCE),
    ("torque, inlet turbine", "torque_inlet_N_m", kinds.TORQUE),
    ("torque, outlet turbine", "torque_outlet_N_m", kinds.TORQUE),
    ("torque, friction", "torque_friction_N_m", kinds.TORQUE),
    ("spool speed, fully open", "spool_speed_rad_s", kinds.SPEED),
    ("PWM frequency, fully open", "pwm_frequency_Hz", kinds.FREQUENCY),
    ("PWM frequency, averaged", "pwm_frequency_averaged_Hz", kinds.FREQUENCY),
    ("transition fraction", "transition_fraction", kinds.FRACTION),
    ("loss, fully open", "loss_full_open_W", kinds.MEAN_POWER),
    ("loss, transition", "loss_transition_W", kinds.MEAN_POWER),
    ("loss, compressibility, at the averaged frequency", "loss_compressibility_W", kinds.MEAN_POWER),
    ("loss, leakage", "loss_leakage_W", kinds.MEAN_POWER),
    ("loss, total", "loss_total_W", kinds.MEAN_POWER),
    ("spool friction, part of fully open", "spool_friction_power_W", kinds.MEAN_POWER),
    ("Reynolds number of the nozzles", "nozzle_reynolds_number", kinds.RATIO),
    ("mean flow to the load", "mean_load_flow_m3_s", kinds.FLOW),
)
"""Lines for one point: label, key, kind."""
SPANS = ("lowest", "highest", "all low", "all high")
"""Heads of what ranges of values do to a number: each alone, all together."""
RANGES = (
    "lowest, highest: each of {count} values alone at both ends of its range; all low, all high: all at once at the "
    "ends that move the number so. Lag and reseat of the relief valve are in no formula: `vvdp run` has them."
)
COLUMNS = (
    ("flow", "flow_m3_s", kinds.FLOW),
    ("oil", "temperature_K", kinds.TEMPERATURE),
    ("nozzle", "pressure_drop_nozzle_Pa", kinds.PRESSURE_DIFFERENCE),
    ("centre", "pressure_drop_centre_section_Pa", kinds.PRESSURE_DIFFERENCE),
    ("outlet", "pressure_drop_outlet_turbine_Pa", kinds.PRESSURE_DIFFERENCE),
    ("total", "pressure_drop_total_Pa", kinds.PRESSURE_DIFFERENCE),
    ("PWM open", "pwm_frequency_Hz", kinds.FREQUENCY),
    ("PWM mean", "pwm_frequency_averaged_Hz", kinds.FREQUENCY),
    ("open", "loss_full_open_W", kinds.MEAN_POWER),
    ("transition", "loss_transition_W", kinds.MEAN_POWER),
    ("compr.", "loss_compressibility_W", kinds.MEAN_POWER),
    ("leakage", "loss_leakage_W", kinds.MEAN_POWER),
    ("total", "loss_total_W", kinds.MEAN_POWER),
)
"""Columns for several points: label, key, kind."""
KEYS = 2
"""Leading columns that distinguish one row from another."""


def _print_head(title: str, unit: ValveUnit, row: Mapping[str, Any]) -> None:
    which = "the initial one; the load makes its own" if unit.makes_pressure else "prescribed"
    load, relief = (with_unit(row[f"{name}_pressure_Pa"], kinds.GAUGE_PRESSURE) for name in ("load", "relief"))
    tell(title)
    tell(f"duty ratio {plain(row['duty_ratio'], 4)}, load pressure {load} ({which}), relief valve {relief}")


def _point(row: Mapping[str, Any]) -> str:
    return f"{with_unit(row['flow_m3_s'], kinds.FLOW)}, {with_unit(row['temperature_K'], kinds.TEMPERATURE)}"


def print_point(title: str, unit: ValveUnit, row: Mapping[str, Any], ranges: Ranges | None) -> None:
    """Prints the valve at one flow and temperature, a line for each quantity, with how far `ranges` of values move it.

    A number that they move by no more than 1 % stands alone.
    """
    _print_head(title, unit, row)
    tell(f"flow and oil: {_point(row)}")
    heads = ("value",) if ranges is None else ("value", *SPANS)
    table = grid("quantity", *heads, "unit", right=heads, ends=1)
    for label, key, kind in SHOWN:
        shown = display_unit(kind)
        moved = ranges is not None and ranges.moves(key)
        spans = (*ranges.span(key), *ranges.together[key]) if ranges is not None and moved else ()
        cells = [number(shown.from_si(value)) for value in spans] or [""] * (len(heads) - 1)
        table.add_row(label, number(shown.from_si(row[key])), *cells, shown.symbol)
    console().print(table)
    if ranges is not None:
        tell(RANGES.format(count=len(ranges.rows)))
    for text in row["warnings"]:
        warn(text)


def print_points(title: str, unit: ValveUnit, rows: Sequence[Mapping[str, Any]]) -> None:
    """Prints the valve at several flows and temperatures, a row for each."""
    _print_head(title, unit, rows[0])
    heads = [f"{label}{display_unit(kind).bracketed_symbol}" for label, _, kind in COLUMNS]
    table = grid(*heads, right=heads, keys=KEYS, transpose=True)
    for row in rows:
        values = [display_unit(kind).from_si(row[key]) for _, key, kind in COLUMNS]
        table.add_row(*(plain(x) for x in values[:KEYS]), *(number(x) for x in values[KEYS:]))
    console().print(table)
    for row in rows:
        for text in row["warnings"]:
            warn(f"{_point(row)}: {text}")
