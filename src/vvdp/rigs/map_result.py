"""A map as a result: tables, findings and figures."""

from collections.abc import Iterator, Mapping

import numpy as np

from vvdp.base import kinds
from vvdp.base.display import number, percent, plain, with_unit
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Row, Table, numbers_of
from vvdp.rigs.conditions import axis_words, conditions, limit_findings, validity_findings
from vvdp.rigs.map_charts import map_charts
from vvdp.rigs.maps import NOT_RUN, PumpMap, usable
from vvdp.steady.shooting import DISTANCE, LIMIT
from vvdp.steady.steady_states import HELD

MANNER = (
    "Steady characteristics, based on ISO 17559, ISO 4409 and ISO 8426: delivered flow and efficiencies over the "
    "electrical control signal, here the duty ratio, and the load pressure. The commanded flow at duty ratio d is d "
    "times displacement times speed. Against it, volumetric efficiency is delivered over commanded flow, overall "
    "efficiency the power that the load takes over that of pump shaft and spool motor. By ISO, the derived flow is "
    "speed times the derived capacity of the setting, its flow per angle extrapolated to no pressure difference; "
    "volumetric efficiency is the flow, as a volume under the outlet's pressure, over the derived flow, overall "
    "efficiency that volume flow times the pressure difference over the same power. Hydromechanical efficiency is "
    "overall over volumetric efficiency in both."
)
SIMULATED = (
    "Every point is the periodic steady state of the PWM-resolved circuit, found by shooting over one period, with a "
    f"relative residual of at most {plain(LIMIT)} and a distance of at most {plain(DISTANCE)}; means are over that "
    "period. Derived capacities come from simulated points as well."
)
ANALYTIC = (
    "Every point is a quasi-steady average over a PWM period: constant load pressure, stiff oil, a relief valve "
    "without lag. The compressibility loss is nominal and not part of the efficiencies, and the flow at the outlet is "
    "the delivered one."
)
LEFT_OUT = (
    "The test rig itself: flow meters, hoses and their drops, uncertainty of instruments, thermal settling.",
    "Losses of the pump beyond those in its parameters; with none given, the input power is the hydraulic one.",
    "The actuator that sets the spool's axial position: the duty ratio is held exactly.",
    "The pump's own flow ripple, which has no common period with the valve.",
)
LEFT_OUT_ANALYTIC = "The load line and its pressure ripple, the compressibility of the oil, the spool's own ripple."
COLUMNS: Mapping[str, tuple[kinds.Kind, str]] = {
    "duty_ratio": (kinds.DUTY_RATIO, "duty ratio"),
    "load_pressure_Pa": (kinds.GAUGE_PRESSURE, "load pressure"),
    "pump_speed_rad_s": (kinds.SPEED, "pump speed"),
    "oil_temperature_K": (kinds.TEMPERATURE, "oil temperature"),
    "delivered_flow_m3_s": (kinds.FLOW, "delivered flow"),
    "outlet_flow_m3_s": (kinds.FLOW, "delivered flow at the outlet's pressure"),
    "commanded_flow_m3_s": (kinds.FLOW, "commanded flow"),
    "derived_capacity_m3_rad": (kinds.DISPLACEMENT, "derived capacity of the setting"),
    "volumetric_efficiency_commanded": (kinds.EFFICIENCY, "volumetric efficiency, commanded"),
    "hydromechanical_efficiency_commanded": (kinds.EFFICIENCY, "hydromechanical efficiency, commanded"),
    "overall_efficiency": (kinds.EFFICIENCY, "overall efficiency"),
    "volumetric_efficiency_iso": (kinds.EFFICIENCY, "volumetric efficiency, ISO"),
    "hydromechanical_efficiency_iso": (kinds.EFFICIENCY, "hydromechanical efficiency, ISO"),
    "overall_efficiency_iso": (kinds.EFFICIENCY, "overall efficiency, ISO"),
    "input_power_W": (kinds.MEAN_POWER, "input power"),
    "spool_motor_power_W": (kinds.MEAN_POWER, "power of the spool motor"),
    "load_power_W": (kinds.MEAN_POWER, "load power"),
    "loss_total_W": (kinds.MEAN_POWER, "total loss"),
    "pwm_frequency_Hz": (kinds.FREQUENCY, "PWM frequency"),
    "pressure_mean_load_line_Pa": (kinds.GAUGE_PRESSURE, "mean load pressure"),
    "pressure_mean_inlet_Pa": (kinds.GAUGE_PRESSURE, "mean inlet pressure"),
    "mean_pump_flow_m3_s": (kinds.FLOW, "pump flow"),
    "mean_tank_flow_m3_s": (kinds.FLOW, "flow through the tank port"),
    "flow_mean_relief_valve_m3_s": (kinds.FLOW, "flow over the relief valve"),
    "mean_leakage_flow_m3_s": (kinds.FLOW, "leakage of the valve"),
    "motor_overloaded": (kinds.FLAG, "above the motor's rated power"),
    "loss_compressibility_W": (kinds.MEAN_POWER, "nominal compressibility loss"),
    "estimated_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "estimated ripple of the load pressure, peak to peak"),
    "ripple_reaches_relief": (kinds.FLAG, "ripple reaches the relief valve"),
    "load_area_m2": (kinds.AREA, "area of the load orifice"),
    "pressure_min_inlet_Pa": (kinds.GAUGE_PRESSURE, "lowest inlet pressure"),
    "pressure_max_inlet_Pa": (kinds.GAUGE_PRESSURE, "highest inlet pressure"),
    "pressure_min_load_line_Pa": (kinds.GAUGE_PRESSURE, "lowest load pressure"),
    "pressure_max_load_line_Pa": (kinds.GAUGE_PRESSURE, "highest load pressure"),
    "cavitation_volume": (kinds.FLAG, "a pressure falls below the cavitation limit"),
    "cavitation_port_share": (kinds.FRACTION, "port cavitation, share of time"),
    "cavitation_number_lowest": (kinds.NUMBER, "cavitation number of the ports, lowest"),
    "second_law": (kinds.FLAG, "no loss gives energy back"),
    "within_validity": (kinds.FLAG, "all laws within their range"),
    "trusted": (kinds.FLAG, "trusted"),
    "periodic_residual": (kinds.NUMBER, "residual of the periodic state"),
    "periodic_distance": (kinds.NUMBER, "distance of the periodic state"),
}
SHOWN = (
    "oil_temperature_K",
    "pump_speed_rad_s",
    "load_pressure_Pa",
    "duty_ratio",
    "delivered_flow_m3_s",
    "volumetric_efficiency_commanded",
    "volumetric_efficiency_iso",
    "overall_efficiency",
    "overall_efficiency_iso",
    "pwm_frequency_Hz",
    "ripple_reaches_relief",
    "remark",
)
AXES = ("duty_ratio", "load_pressure_Pa", "pump_speed_rad_s", "oil_temperature_K")
QUANTITIES: Mapping[str, tuple[kinds.Kind, str]] = {
    "points": (kinds.COUNT, "points"),
    "points_without_result": (kinds.COUNT, "points without an efficiency"),
    "points_above_motor_power": (kinds.COUNT, "points above the motor's rated power"),
    "points_with_ripple_at_relief": (kinds.COUNT, "points whose ripple reaches the relief valve"),
    "motor_rated_power_W": (kinds.POWER, "rated power of the motor"),
    "best_efficiency": (kinds.EFFICIENCY, "best efficiency within the motor's rating"),
    "best_efficiency_duty_ratio": (kinds.DUTY_RATIO, "duty ratio there"),
    "best_efficiency_load_pressure_Pa": (kinds.GAUGE_PRESSURE, "load pressure there"),
    "best_efficiency_pump_speed_rad_s": (kinds.SPEED, "pump speed there"),
    "best_efficiency_oil_temperature_K": (kinds.TEMPERATURE, "oil temperature there"),
    "highest_delivered_flow_m3_s": (kinds.FLOW, "largest delivered flow"),
    "largest_periodic_residual": (kinds.NUMBER, "largest residual of the periodic states"),
    "untrusted_points": (kinds.COUNT, "points that are not trusted"),
}
MOST_LISTINGS, MOST_HEADS = 8, 12
"""Pairs of pump speed and oil temperature that have a listing, and duty ratios in it."""


def map_result(found: PumpMap, table: str = "map") -> Result:
    """The map as a result whose table has the name `table`."""
    axes, stand = found.axes, found.stand
    columns = {name: Column(values, *COLUMNS[name]) for name, values in found.columns.items()}
    columns["remark"] = Column(np.array([reason or "" for reason in found.reasons]), None, "note")
    whole = Table(title="All points", columns=columns, shown=SHOWN, axes=AXES)
    numbers = _numbers(found)
    said = conditions(stand) | {
        "duty ratio": axis_words(axes.duty_ratios, kinds.DUTY_RATIO),
        "load pressure": axis_words(axes.load_pressures, kinds.PRESSURE_LEVEL),
        "pump speed": axis_words(axes.pump_speeds, kinds.SPEED),
        "temperature": axis_words(axes.temperatures, kinds.TEMPERATURE),
    }
    if found.simulated and stand.makes_pressure:
        said["load"] += f", sized to hold the mean load pressure within {plain(100.0 * HELD, 2)} %"
    return Result(
        verb="map",
        title=f"Map of the pump, {'simulated' if found.simulated else 'analytic'}",
        system=stand.name,
        manner=f"{MANNER} {SIMULATED if found.simulated else ANALYTIC}",
        references=("iso17559", "iso4409", "iso8426"),
        conditions=said,
        left_out=LEFT_OUT if found.simulated else (*LEFT_OUT, LEFT_OUT_ANALYTIC),
        tables={table: whole},
        listings=_listings(found),
        charts={each.name: each for each in map_charts(found, table)},
        numbers=numbers_of(numbers, QUANTITIES),
        findings=tuple(_findings(found, numbers)),
        seconds=found.seconds,
        finished=found.is_finished,
    )


def _listings(found: PumpMap) -> dict[str, Listing]:
    """The overall efficiency over load pressure and duty ratio at each oil temperature and pump speed."""
    axes = found.axes
    pairs = list(np.ndindex(len(axes.temperatures), len(axes.pump_speeds)))[:MOST_LISTINGS]
    count = len(axes.duty_ratios)
    places = [round(x) for x in np.linspace(0, count - 1, min(MOST_HEADS, count)).tolist()]
    listings: dict[str, Listing] = {}
    for i, k in pairs:
        where = (
            f", {with_unit(axes.pump_speeds[k], kinds.SPEED, 5)}, {with_unit(axes.temperatures[i], kinds.TEMPERATURE)}"
        )
        grids = [found.grid(name)[i, k] for name in ("overall_efficiency", "motor_overloaded", *_ripple_flag(found))]
        rows = tuple(
            Row(
                with_unit(pressure, kinds.PRESSURE_LEVEL),
                kinds.EFFICIENCY,
                tuple(_mark_efficiency(*(float(grid[row, place]) for grid in grids)) for place in places),
            )
            for row, pressure in enumerate(axes.load_pressures)
        )
        name = "overall-efficiency" + (f"-{len(listings) + 1}" if len(pairs) > 1 else "")
        listings[name] = Listing(
            title="Overall efficiency over load pressure and duty ratio" + (where if len(pairs) > 1 else ""),
            heads=tuple(plain(axes.duty_ratios[place], 3) for place in places),
            rows=rows,
            note=" ".join(words for mark, words in NOTES.items() if any(mark in str(row.values) for row in rows)),
        )
    return listings


NOTES = {
    "*": "* above the motor's rated power.",
    "†": "† the ripple of the load pressure reaches the relief valve; simulate these points.",
}
"""Meaning of the marks of a listing."""


def _ripple_flag(found: PumpMap) -> tuple[str, ...]:
    return tuple(name for name in ("ripple_reaches_relief",) if name in found.columns)


def _mark_efficiency(efficiency: float, overloaded: float, ripples: float = 0.0) -> str:
    """An efficiency in % with its marks."""
    return number(100.0 * efficiency, 3) + "*" * (overloaded > 0.0) + "†" * (ripples > 0.0)


def _numbers(found: PumpMap) -> dict[str, float]:
    overall = found.columns["overall_efficiency"]
    allowed = np.where(usable(found).ravel(), overall, np.nan)
    numbers = {
        "points": float(found.axes.count),
        "points_without_result": float(sum(reason is not None for reason in found.reasons)),
        "points_above_motor_power": float(np.nansum(found.columns["motor_overloaded"])),
        "motor_rated_power_W": float(found.stand.bench.rated_power),
    }
    for flag in _ripple_flag(found):
        numbers["points_with_ripple_at_relief"] = float(np.nansum(found.columns[flag]))
    if np.isfinite(allowed).any():
        best = int(np.nanargmax(allowed))
        numbers |= {"best_efficiency": float(allowed[best])}
        numbers |= {f"best_efficiency_{name}": float(found.columns[name][best]) for name in AXES}
        numbers["highest_delivered_flow_m3_s"] = float(np.nanmax(found.columns["delivered_flow_m3_s"]))
    if found.simulated:
        numbers["largest_periodic_residual"] = float(np.nanmax([*found.columns.get("periodic_residual", []), 0.0]))
        numbers["untrusted_points"] = float(np.sum(found.columns.get("trusted", np.ones(1)) == 0.0))
    return numbers


def _where(found: PumpMap, numbers: Mapping[str, float]) -> str:
    """Pump speed and oil temperature of the best point, where the map has several of them."""
    words = ""
    if len(found.axes.pump_speeds) > 1:
        words += f", {with_unit(numbers['best_efficiency_pump_speed_rad_s'], kinds.SPEED, 5)}"
    if len(found.axes.temperatures) > 1:
        words += f", {with_unit(numbers['best_efficiency_oil_temperature_K'], kinds.TEMPERATURE)}"
    return words


def _marked_words(found: PumpMap) -> str:
    """Over which duty ratios and load pressures the points lie whose ripple reaches the relief valve."""
    marked = found.columns["ripple_reaches_relief"] > 0.0
    duty, pressure = (np.unique(found.columns[name][marked]) for name in ("duty_ratio", "load_pressure_Pa"))
    at = axis_words(pressure.tolist(), kinds.GAUGE_PRESSURE)
    return f"duty ratio {axis_words(duty.tolist(), kinds.DUTY_RATIO)}; load pressure {at}"


def _findings(found: PumpMap, numbers: Mapping[str, float]) -> Iterator[Finding]:
    if "best_efficiency" in numbers:
        pressure = with_unit(numbers["best_efficiency_load_pressure_Pa"], kinds.GAUGE_PRESSURE)
        yield Finding(
            text=f"The best efficiency within the motor's rating is {percent(numbers['best_efficiency'])}, at duty "
            f"ratio {plain(numbers['best_efficiency_duty_ratio'], 3)} and {pressure}{_where(found, numbers)}; at most "
            f"{with_unit(numbers['highest_delivered_flow_m3_s'], kinds.FLOW)} are delivered."
        )
    count = found.axes.count
    if over := int(numbers["points_above_motor_power"]):
        yield Finding(text=f"{over} of {count} points need more than the motor's rated power; they are marked.")
    if ripples := int(numbers.get("points_with_ripple_at_relief", 0.0)):
        yield Finding(
            text=f"At {ripples} of {count} points ({_marked_words(found)}) the ripple of the load pressure reaches "
            "the relief valve, so that more oil goes over it than the averages say: the efficiencies there, which are "
            "marked, may be ten points and more too high.",
            grade=Grade.WARNING,
            title="Too high near the relief setting",
            remedy="Simulate the map: the same command without --analytic.",
        )
    if found.simulated:
        yield from validity_findings(found.columns.get("within_validity", np.ones(count)).tolist())
    else:
        yield from limit_findings(found.stand)
    for reason in dict.fromkeys(r for r in found.reasons if r and r != NOT_RUN):
        alike = sum(r == reason for r in found.reasons)
        yield Finding(text=f"{alike} point{'s' if alike > 1 else ''} without an efficiency: {reason}.")
    if not found.is_finished:
        missing = sum(r == NOT_RUN for r in found.reasons)
        yield Finding(text=f"Interrupted: {missing} of {count} points were not run yet.")
    if doubtful := int(numbers.get("untrusted_points", 0.0)):
        yield Finding(
            text=f"{doubtful} of {count} points are not to be trusted.",
            grade=Grade.BAD,
            title="Not trusted",
            remedy="See the columns second_law and within_validity; `vvdp run` at such a point says what is amiss.",
        )
