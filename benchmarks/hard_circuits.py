"""vvdp's answers to the circuits of the benchmark set on which simulators usually fail; their balances close."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import vvdp

SET = Path(__file__).parent / "digital-hydraulics"
ATMOSPHERE = 101325.0
CLOSES = 1e-6

Answer = Mapping[str, float]


def ran(case: str, **tables: Mapping[str, Any]) -> Any:
    """A run of a case whose energy and oil balances close. Raises ValueError where they do not."""
    run = vvdp.load(SET / case / "vvdp.toml", **tables).run()
    if not run.summary["trusted"] or abs(run.summary["mass_residual"]) > CLOSES:
        raise ValueError(f"{case}: its balances do not close, or a law is used outside its range")
    return run


def course(run: Any, state: str) -> tuple[Any, Any]:
    """Times [s] and values of a state; of a pressure its gauge values [Pa]."""
    series = run.to_pandas()[f"states.{state}"]
    return series.index.to_numpy(), series.to_numpy() - (ATMOSPHERE if state.endswith("_Pa") else 0.0)


def extremes(case: str, state: str, since: float, names: tuple[str, str]) -> Answer:
    """The lowest and the highest value of a state from a time on."""
    t, x = course(ran(case), state)
    late = x[t >= since]
    return dict(zip(names, (float(late.min()), float(late.max())), strict=True))


def closed_end() -> Answer:
    """Extremes, and when half of the first rise is reached."""
    t, x = course(ran("closed-end"), "end_Pa")
    arrived = int(np.argmax(x > 150e5))
    at = np.interp(150e5, x[arrived - 1 : arrived + 1], t[arrived - 1 : arrived + 1])
    late = x[t > 25e-3]
    return {"highest_pressure": float(x.max()), "lowest_pressure": float(late.min()), "arrival": float(at) - 8e-3}


def dead_head() -> Answer:
    """Both relief valves."""
    ideal = ran("dead-head").summary
    lagging = ran("dead-head", components={"relief.override_pressure": "5 bar", "relief.opening_time": "5 ms"})
    _, x = course(lagging, "rail_Pa")
    highest = lagging.summary["pressure_max_rail_Pa"]
    return {"ideal_highest": ideal["pressure_max_rail_Pa"], "lag_highest": highest, "lag_end": float(x[-1])}


def summary_of(case: str, keys: Mapping[str, str]) -> Answer:
    """Numbers of the summary of a run under the names of the case."""
    found = ran(case).summary
    return {name: float(found[key]) for name, key in keys.items()}


def end_stop() -> Answer:
    """The first impact."""
    found = ran("end-stop").summary
    return {"rebound": -found["velocity_min_mass_m_s"], "depth": found["position_max_mass_m"] - 0.1}


def chattering_relief_valve() -> Answer:
    """The first peak, and the swing that stays."""
    late = extremes("chattering-relief-valve", "spot_Pa", 0.05, ("late_lowest", "late_highest"))
    return {**summary_of("chattering-relief-valve", {"first_peak": "pressure_max_spot_Pa"}), **late}


def gas_corner() -> Answer:
    """The pressure at two times."""
    t, x = course(ran("gas-corner"), "acc_Pa")
    return {"pressure_end": float(x[-1]), "pressure_corner": float(np.interp(0.05, t, x))}


def line_on_a_source() -> Answer:
    """Half of the swing at the end."""
    found = extremes("line-on-a-source", "end_Pa", 0.5, ("low", "high"))
    return {"amplitude_end": 0.5 * (found["high"] - found["low"])}


def pilot_ratio_limit() -> Answer:
    """Just enough, and just not enough."""
    t, x = course(ran("pilot-ratio-limit"), "load_Pa")
    _, held = course(ran("pilot-ratio-limit", components={"valve.pilot_ratio": "4.005"}), "load_Pa")
    return {"opens_at": float(t[np.argmax(x < 199e5)]), "left": float(x[-1]), "held": float(held[-1])}


HARD: Mapping[str, Callable[[], Answer]] = {
    "valve-closure": partial(extremes, "valve-closure", "end_Pa", 0.1, ("lowest_pressure", "highest_pressure")),
    "closed-end": closed_end,
    "dead-head": dead_head,
    "vacuum-and-refilling": partial(
        summary_of,
        "vacuum-and-refilling",
        {"lowest_pressure": "pressure_min_chamber_Pa", "spike": "pressure_max_chamber_Pa"},
    ),
    "end-stop": end_stop,
    "check-valves-in-a-ring": partial(
        summary_of,
        "check-valves-in-a-ring",
        {
            "mean_pressure": "pressure_mean_acc_Pa",
            "chamber_lowest": "pressure_min_chamber_Pa",
            "chamber_highest": "pressure_max_chamber_Pa",
        },
    ),
    "chattering-relief-valve": chattering_relief_valve,
    "gas-corner": gas_corner,
    "line-on-a-source": line_on_a_source,
    "pilot-ratio-limit": pilot_ratio_limit,
}
