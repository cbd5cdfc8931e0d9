"""Results of the hard circuits of the benchmark set: closed forms, and integrations that share nothing with vvdp."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Given = Mapping[str, float]
Answer = dict[str, float]


def volume_ratio(P: float, g: Given) -> float:
    """V/V0 of oil with air, which boils below its vapour pressure where it has one."""
    P0, phi, n = g["atmosphere"], g.get("air_fraction", 0.0), g.get("exponent", 1.4)
    low = max(P, 0.01 * P0)
    air = (low / P0) ** (-1.0 / n) * (1.0 + (low - P) / (n * low))
    vapour = 4.0 * np.log(g.get("vapour_pressure", 0.0) / P) ** 2 if g.get("vapour_pressure", 0.0) > P else 0.0
    return float(phi * air + (1.0 - phi) * np.exp((P0 - P) / g["bulk_modulus"]) + vapour)


def stiffness(P: float, g: Given) -> float:
    """-V/(dV/dP) of the oil [Pa], by a difference."""
    h = 1e-4 * P
    return float(-volume_ratio(P, g) * 2.0 * h / (volume_ratio(P + h, g) - volume_ratio(P - h, g)))


def smooth_root(dp: float, transition: float) -> float:
    return dp / (dp * dp + transition * transition) ** 0.25


def integrated(rates: Callable[..., Any], start: list[float], until: tuple[float, float], **options: Any) -> Any:
    found = solve_ivp(rates, until, start, **{"method": "LSODA", "rtol": 1e-9, "atol": 1e-10} | options)
    assert found.success, found.message
    return found


def valve_closure(g: Given) -> Answer:
    rise = g["density"] * g["sound_speed"] * g["flow"] / (0.25 * np.pi * g["diameter"] ** 2)
    return {"highest_pressure": g["supply_pressure"] + rise, "lowest_pressure": g["supply_pressure"] - rise}


def closed_end(g: Given) -> Answer:
    high = g["start_pressure"] + 2.0 * g["step"]
    arrival = g["length"] / g["sound_speed"]
    return {"highest_pressure": high, "lowest_pressure": g["start_pressure"], "arrival": arrival}


def dead_head(g: Given) -> Answer:
    P0, setting = g["atmosphere"], g["setting"] + g["atmosphere"]

    def rates(t: float, y: Any, area: float) -> list[float]:
        P, nu = y[0], volume_ratio(y[0], g)
        over = g["rated_flow"] * y[1] * np.sqrt(max(P - P0, 0.0) / (g["setting"] + g["override"]))
        out = g["discharge_coefficient"] * area * np.sqrt(2.0 / g["density"]) * smooth_root(P - P0, 5e4)
        wanted = max(P - setting, 0.0) / g["override"]
        q = g["pump_flow"] * nu - out - over
        return [q * stiffness(P, g) / g["volume"], (wanted - y[1]) / g["opening_time"]]

    first = integrated(rates, [P0, 0.0], (0.0, g["closes_at"]), args=(g["orifice_area"],))
    then = integrated(rates, list(first.y[:, -1]), (g["closes_at"], 0.5), args=(0.0,), max_step=2e-4)
    return {"ideal_highest": g["setting"], "lag_highest": then.y[0].max() - P0, "lag_end": then.y[0][-1] - P0}


def vacuum_and_refilling(g: Given) -> Answer:
    A, P0 = g["area"], g["atmosphere"]

    def rates(t: float, y: Any, force: float) -> list[float]:
        P, x, v = max(y[0], 1e-3), y[1], y[2]
        swelling = (volume_ratio(P, g) * g["feed"] - A * v) * stiffness(P, g) / (g["volume"] + A * x)
        return [swelling, v, ((P - P0) * A - g["friction"] * v + force) / g["mass"]]

    state, courses = [g["start_pressure"] + P0, 0.0, 0.0], []
    for since, until, force in ((0.0, 0.1, 0.0), (0.1, 0.3, g["pull"]), (0.3, 0.6, g["push"])):
        options = {"method": "Radau", "atol": [1e-4, 1e-12, 1e-10], "max_step": 1e-3, "args": (force,)}
        found = integrated(rates, state, (since, until), **options)
        state = list(found.y[:, -1])
        courses.append(found.y[0] - P0)
    return {"lowest_pressure": min(map(np.min, courses)), "spike": courses[-1].max()}


def end_stop(g: Given) -> Answer:
    c, v0, ratio = g["damping"], g["speed"], g["mass"] / g["stiffness"]
    kept = np.log(1.0 + c * v0) - c * v0
    rebound = brentq(lambda v: np.log(1.0 - c * v) + c * v - kept, 1e-3, v0)
    return {"rebound": rebound, "depth": np.sqrt(-2.0 * ratio / c**2 * kept)}


def gas_volume(P: float, g: Given) -> float:
    """Of the gas behind a bladder, which goes over to its full volume within a hundredth of its precharge."""
    first = g["precharge"] + g["atmosphere"]
    d = P - first
    return float(g["gas_volume"] * (1.0 + 0.5 * (d + np.hypot(d, 0.01 * first)) / first) ** (-1.0 / 1.3))


def check_valves_in_a_ring(g: Given) -> Answer:
    P0 = g["atmosphere"]

    def over(dp: float, cracking: float, rated: float) -> float:
        lift = np.clip((dp - cracking) / (rated - cracking), 0.0, 1.0)
        return float(g["rated_flow"] * lift * smooth_root(dp / rated, 0.01) / smooth_root(1.0, 0.01))

    def rates(t: float, y: Any) -> list[float]:
        P, acc = y
        drawn = over(P0 - P, g["suction_cracking"], g["suction_rated"])
        given = over(P - acc, g["delivery_cracking"], g["delivery_rated"]) / volume_ratio(P, g)
        orifice = g["discharge_coefficient"] * g["orifice_area"] * np.sqrt(2.0 / g["density"])
        left = orifice * smooth_root(acc - P0, g["transition"]) / volume_ratio(acc, g)
        swing = g["amplitude"] * np.sin(2.0 * np.pi * g["frequency"] * t)
        h = 1e-4 * acc
        room = g["oil_volume"] + g["gas_volume"] - gas_volume(acc, g)
        gives = (gas_volume(acc - h, g) - gas_volume(acc + h, g)) / (2.0 * h) + room / stiffness(acc, g)
        chamber = volume_ratio(P, g) * (swing + drawn - given) * stiffness(P, g) / g["chamber"]
        return [chamber, volume_ratio(acc, g) * (given - left) / gives]

    found = integrated(rates, [P0, P0], (0.0, 1.0), max_step=2e-4, rtol=1e-8, atol=1e-2)
    late = found.t >= 0.8
    chamber = found.y[0] - P0
    mean = np.trapezoid(found.y[1][late], found.t[late]) / np.ptp(found.t[late]) - P0
    return {"mean_pressure": mean, "chamber_lowest": chamber.min(), "chamber_highest": chamber.max()}


def chattering_relief_valve(g: Given) -> Answer:
    P0, opens = g["atmosphere"], g["setting"] + g["atmosphere"]
    shuts, times, courses = opens - g["reseat_drop"], [], []

    def rates(t: float, y: Any, is_open: bool) -> list[float]:
        P = y[0]
        wanted = (P - shuts) / (g["override"] + g["reseat_drop"]) if is_open else 0.0
        root = smooth_root(P - P0, 1.0) / np.sqrt(g["setting"] + g["override"])
        q = volume_ratio(P, g) * g["flow"] - g["rated_flow"] * y[1] * root
        return [q * stiffness(P, g) / g["volume"], (wanted - y[1]) / g["opening_time"]]

    t, state, is_open = 0.0, [P0, 0.0], False
    while t < 0.1:

        def turns(t: float, y: Any, is_open: bool) -> float:
            return float(y[0] - (shuts if is_open else opens))

        turns.terminal, turns.direction = True, -1.0 if is_open else 1.0  # type: ignore[attr-defined]
        found = integrated(rates, state, (t, 0.1), args=(is_open,), events=turns, atol=[1e-3, 1e-12], max_step=1e-4)
        times.append(found.t)
        courses.append(found.y[0] - P0)
        t, state, is_open = found.t[-1], list(found.y[:, -1]), not is_open
    time, course = np.concatenate(times), np.concatenate(courses)
    late = course[time > 0.05]
    return {"first_peak": course.max(), "late_lowest": late.min(), "late_highest": late.max()}


def gas_corner(g: Given) -> Answer:
    P0 = g["atmosphere"]

    def amount(P: float) -> float:
        room = g["oil_volume"] + g["gas_volume"] - gas_volume(P, g)
        return float(room * np.exp((P - P0) / g["bulk_modulus"]))

    def after(t: float) -> float:
        return float(brentq(lambda P: amount(P) - amount(P0) - g["flow"] * t, P0, 3e7)) - P0

    return {"pressure_end": after(2.6), "pressure_corner": after(0.05)}


def line_on_a_source(g: Given) -> Answer:
    angle = 2.0 * np.pi * g["frequency"] * g["length"] / g["sound_speed"]
    impedance = g["density"] * g["sound_speed"] / (0.25 * np.pi * g["diameter"] ** 2)
    ratio = 1.0 / abs(np.cos(angle) + 1j * impedance * g["conductance"] * np.sin(angle))
    return {"amplitude_end": g["amplitude"] * float(ratio)}


def pilot_ratio_limit(g: Given) -> Answer:
    opens = (g["load_pressure"] + g["cracking"]) / (g["ratio"] * g["pilot_rate"])
    return {"opens_at": opens, "left": 0.0, "held": g["load_pressure"]}


REFERENCES: Mapping[str, Callable[[Given], Answer]] = {
    "valve-closure": valve_closure,
    "closed-end": closed_end,
    "dead-head": dead_head,
    "vacuum-and-refilling": vacuum_and_refilling,
    "end-stop": end_stop,
    "check-valves-in-a-ring": check_valves_in_a_ring,
    "chattering-relief-valve": chattering_relief_valve,
    "gas-corner": gas_corner,
    "line-on-a-source": line_on_a_source,
    "pilot-ratio-limit": pilot_ratio_limit,
}
