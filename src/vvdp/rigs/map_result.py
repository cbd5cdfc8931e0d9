"""A map in the form in which every rig leaves its results."""

import numpy as np

from vvdp.base.units import ATMOSPHERE
from vvdp.rigs.conditions import BAR, CELSIUS, LPM, RPM, conditions, span
from vvdp.rigs.maps import NOT_RUN, PumpMap, usable
from vvdp.rigs.result import Column, RigResult, Sheet
from vvdp.steady.shooting import DISTANCE, LIMIT
from vvdp.steady.steady_states import HELD
from vvdp.systems.summary import summary_unit

MANNER = (
    "Steady characteristics in the manner of ISO 17559 and ISO 4409: delivered flow and efficiencies over the "
    "electrical control signal, here the duty ratio, and the load pressure. The derived flow at duty ratio d is d "
    "times displacement times speed; volumetric efficiency is delivered over derived flow, overall efficiency load "
    "power over the power of pump shaft and spool motor, hydromechanical efficiency the second over the first."
)


def written(value: float) -> str:
    """A small number as people write it: 3e-4."""
    return f"{value:.0e}".replace("e-0", "e-")


SIMULATED = (
    "Every point is the periodic steady state of the PWM-resolved circuit, found by shooting over one period, with a "
    f"relative residual of at most {written(LIMIT)} and a distance of at most {written(DISTANCE)}; means are over that "
    "period."
)
ANALYTIC = (
    "Every point is a quasi-steady average over a PWM period: constant load pressure, stiff oil, a relief valve "
    "without lag. The compressibility loss is nominal and not part of the efficiencies."
)
LEFT_OUT = (
    "The test stand itself: flow meters, hoses and their drops, uncertainty of instruments, thermal settling.",
    "Losses of the pump beyond those in its parameters; with none given, the input power is the hydraulic one.",
    "The actuator that sets the spool's axial position: the duty ratio is held exactly.",
    "The pump's own flow ripple, which has no common period with the valve.",
)
UNITS = {"duty_ratio": "", "oil_temperature_K": "K", "load_area_m2": "m^2"}


def map_result(found: PumpMap) -> RigResult:
    """The map as tables, conditions and findings."""
    axes, stand = found.axes, found.stand
    columns = {name: Column(values, _unit(name), label_of(name)) for name, values in found.columns.items()}
    reasons = np.array([reason or "" for reason in found.reasons])
    columns["remark"] = Column(reasons, "", "remark")
    said = conditions(stand) | {
        "duty ratio": span(axes.duty_ratios, 1.0, ""),
        "load pressure": span(axes.load_pressures, BAR, "bar", ATMOSPHERE),
        "pump speed": span(axes.pump_speeds, RPM, "rpm"),
        "temperature": span(axes.temperatures, 1.0, "°C", CELSIUS),
    }
    if found.simulated and stand.makes_pressure:
        said["load"] += f", sized to hold the mean load pressure within {100.0 * HELD:.2g} %"
    left_out = list(LEFT_OUT)
    if not found.simulated:
        left_out.append(
            "The load line and its pressure ripple, the compressibility of the oil, the spool's own ripple."
        )
    kind = "simulated" if found.simulated else "analytic"
    return RigResult(
        rig="map",
        title=f"Map of the pump, {kind}",
        system=stand.name,
        manner=f"{MANNER} {SIMULATED if found.simulated else ANALYTIC}",
        references=("iso17559", "iso4409"),
        conditions=said,
        left_out=tuple(left_out),
        sheets={"map": Sheet("All points", columns)},
        numbers=_numbers(found),
        findings=_findings(found),
        seconds=found.seconds,
        finished=found.finished,
    )


ENDINGS = ("_m3_s", "_rad_s", "_Pa", "_Hz", "_W", "_K", "_m2")


def label_of(name: str) -> str:
    """What a key says without its unit, in words."""
    ending = next((each for each in ENDINGS if name.endswith(each)), "")
    return name.removesuffix(ending).replace("_", " ").replace("pwm", "PWM")


def _unit(name: str) -> str:
    if name in UNITS:
        return UNITS[name]
    unit = summary_unit(name)
    return "" if unit == "1" else unit


def _numbers(found: PumpMap) -> dict[str, float]:
    overall = found.columns["overall_efficiency"]
    bears = usable(found).ravel()
    allowed = np.where(bears, overall, np.nan)
    numbers = {
        "points": float(found.axes.count),
        "points_without_result": float(sum(reason is not None for reason in found.reasons)),
        "points_above_motor_power": float(np.nansum(found.columns["motor_overloaded"])),
        "motor_rated_power_W": float(found.stand.bench.motor.rated_power),
    }
    if np.isfinite(allowed).any():
        best = int(np.nanargmax(allowed))
        numbers |= {
            "best_efficiency": float(allowed[best]),
            "best_efficiency_duty_ratio": float(found.columns["duty_ratio"][best]),
            "best_efficiency_load_pressure_Pa": float(found.columns["load_pressure_Pa"][best]),
            "best_efficiency_pump_speed_rad_s": float(found.columns["pump_speed_rad_s"][best]),
            "best_efficiency_oil_temperature_K": float(found.columns["oil_temperature_K"][best]),
            "highest_delivered_flow_m3_s": float(np.nanmax(found.columns["delivered_flow_m3_s"])),
        }
    if found.simulated:
        numbers["largest_periodic_residual"] = float(np.nanmax([*found.columns.get("periodic_residual", []), 0.0]))
        numbers["untrusted_points"] = float(np.sum(found.columns.get("trusted", np.ones(1)) == 0.0))
    return numbers


def _where(found: PumpMap, numbers: dict[str, float]) -> str:
    """Pump speed and oil temperature of the best point, where the map has several of them."""
    words = ""
    if len(found.axes.pump_speeds) > 1:
        words += f", {numbers['best_efficiency_pump_speed_rad_s'] / RPM:.5g} rpm"
    if len(found.axes.temperatures) > 1:
        words += f", {numbers['best_efficiency_oil_temperature_K'] - CELSIUS:.4g} °C"
    return words


def _findings(found: PumpMap) -> tuple[str, ...]:
    numbers, sentences = _numbers(found), []
    if "best_efficiency" in numbers:
        sentences.append(
            f"The best efficiency that the motor bears is {100.0 * numbers['best_efficiency']:.3g} %, at duty ratio "
            f"{numbers['best_efficiency_duty_ratio']:.3g} and "
            f"{numbers['best_efficiency_load_pressure_Pa'] / BAR:.4g} bar{_where(found, numbers)}; at most "
            f"{numbers['highest_delivered_flow_m3_s'] / LPM:.4g} lpm are delivered."
        )
    if over := int(numbers["points_above_motor_power"]):
        sentences.append(
            f"{over} of {found.axes.count} points need more than the motor's rated power; they are marked."
        )
    for reason in dict.fromkeys(r for r in found.reasons if r and r != NOT_RUN):
        count = sum(r == reason for r in found.reasons)
        sentences.append(f"{count} point{'s' if count > 1 else ''} without an efficiency: {reason}.")
    if not found.finished:
        missing = sum(r == NOT_RUN for r in found.reasons)
        sentences.append(f"Interrupted: {missing} of {found.axes.count} points were not run yet.")
    if numbers.get("untrusted_points"):
        sentences.append(f"At {numbers['untrusted_points']:.0f} points the balances are above the limit.")
    return tuple(sentences)
