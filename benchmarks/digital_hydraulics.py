"""vvdp's own answers to the benchmark set in benchmarks/digital-hydraulics.

python -m benchmarks.digital_hydraulics [CASE ...]    works them out and writes answers/vvdp/CASE.csv
python -m benchmarks.digital_hydraulics --records     makes the records of `event-filter` anew
"""

import argparse
import csv
import json
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import curve_fit

import vvdp
from benchmarks.hard_circuits import HARD
from vvdp.comparison.estimators import READING, contenders
from vvdp.comparison.scenarios import Record, Scenario, scenarios
from vvdp.comparison.trials import compiled_encoder, compiled_step, simulate_record
from vvdp.hydraulics.flow_control_unit import (
    OnOffValve,
    UnitValve,
    binary_valves,
    code_count,
    code_flow,
    equal_valves,
    pulse_volume,
)

SET = Path(__file__).parent / "digital-hydraulics"
ANSWERS = SET / "answers" / "vvdp"
SEED = 7
DUTY_RATIOS = (0.2, 0.4, 0.6)
"""Of the converters without losses."""
BUCK_DUTY_RATIOS = (0.1, 0.2, 0.3, 0.5)
VALVE = "prototype-constant-load"
PUMP_FLOW = 6.66666666e-4
"""Of that valve's pump [m^3/s]."""
STIFF: Mapping[str, Mapping[str, float]] = {
    "oil": {"liquid_bulk_modulus": 1e12, "air_fraction": 0.0},
    "inlet": {"volume": 0.2e-6},
}

Answer = Mapping[str, float]


def ran(system: str | Path, **tables: Mapping[str, Any]) -> Any:
    """A run of a shipped system, or of that of a case, with other values."""
    return vvdp.load(system, **tables).run()


def own_system(case: str) -> Path:
    """The system file that a case brings along for vvdp."""
    return SET / case / "vvdp.toml"


def volume_blowdown() -> Answer:
    """The pressure at three times."""
    run = ran(own_system("volume-blowdown"))
    pressure = run.to_pandas()["states.full_Pa"]
    gauge = pressure - pressure.iloc[0] + 200e5
    return {f"pressure_{at}_ms": float(np.interp(at * 1e-3, gauge.index, gauge)) for at in (10, 20, 40)}


def hose_swing() -> Answer:
    """The frequency of the cosine that fits the difference of pressures best."""
    series = ran(own_system("hose-swing")).to_pandas()
    difference = (series["states.left_Pa"] - series["states.right_Pa"]) / 1e5

    def swing(t: Any, a: float, b: float, f: float) -> Any:
        return a * np.cos(2 * np.pi * f * t) + b * np.sin(2 * np.pi * f * t)

    best, _ = curve_fit(swing, series.index, difference, p0=(1.0, 0.0, 40.0))
    return {"frequency": float(best[2])}


def converter_limit(case: str) -> Answer:
    """Ratios of mean pressures over three duty ratios."""
    found = {}
    for duty in DUTY_RATIOS:
        summary = ran(own_system(case), components={"valve.duty_ratio": duty}).summary
        found[f"ratio_{100 * duty:.0f}"] = summary["pressure_mean_load_Pa"] / summary["pressure_mean_supply_Pa"]
    return found


def buck_converter() -> Answer:
    """Flows and efficiencies of the shipped system over four duty ratios."""
    found = {}
    for duty in BUCK_DUTY_RATIOS:
        summary = ran("buck-converter", components={"valve.duty_ratio": duty}).summary
        found[f"flow_{100 * duty:.0f}"] = summary["flow_mean_tube_m3_s"]
        found[f"efficiency_{100 * duty:.0f}"] = -summary["power_load_W"] / summary["power_supply_W"]
    return found


def pwm_pump_limit() -> Answer:
    """The valve turning by itself, and driven at two frequencies."""
    free, slow, fast = (ran(VALVE, **STIFF, **drive).summary for drive in ({}, driven(20.0), driven(150.0)))
    share = (free["mean_load_flow_m3_s"] + free["mean_leakage_flow_m3_s"]) / PUMP_FLOW
    return {"loss": throttled(free), "load_share": share, "loss_20_hz": throttled(slow), "loss_150_hz": throttled(fast)}


def driven(frequency: float) -> dict[str, Mapping[str, Any]]:
    """A spool turned by a motor at a PWM frequency [Hz], three periods a turn."""
    speed = f"{20.0 * frequency:g} rpm"
    return {
        "spool_drive": {"coupling": "10 N*m*s"},
        "operation": {"spool_motor_speed": speed},
        "initial": {"spool_speed": speed},
    }


def throttled(summary: Mapping[str, Any]) -> float:
    """What is lost in the valve's drops and over the relief valve [W]."""
    return float(summary["loss_full_open_W"] + summary["loss_transition_W"])


def rotary_valve_2012() -> Answer:
    """From the laws of the valve."""
    command = [sys.executable, "-m", "vvdp", "valve", VALVE, "--json"]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {
        "transition_time": found["transition_fraction"] / 100.0,
        "pressure_drop": found["pressure_drop_total_Pa"],
        "friction_power": found["spool_friction_power_W"],
    }


def self_spinning_frequency() -> Answer:
    """Of the shipped prototype, whose relief valve opens at once."""
    return {"pwm_frequency": ran("prototype").summary["pwm_frequency_Hz"]}


def digital_flow_control_unit() -> Answer:
    """Codes and flows of both units, and the volume of a pulse."""
    smallest = OnOffValve(rated_flow=1.6666666667e-5, rated_drop=5e5, opening_time=2e-3, closing_time=3e-3)
    binary, equal, drop = binary_valves(5, smallest), equal_valves(5, smallest), 20e5

    def flows(valves: tuple[UnitValve, ...]) -> set[float]:
        return {round(code_flow(float(code), drop, valves), 12) for code in range(code_count(valves))}

    return {
        "binary_states": float(len(flows(binary))),
        "equal_states": float(len(flows(equal))),
        "binary_largest": max(flows(binary)),
        "equal_largest": max(flows(equal)),
        "binary_19": code_flow(19.0, drop, binary),
        "pulse_15_16": pulse_volume(15.0, 16.0, drop, binary),
    }


CASES: Mapping[str, Callable[[], Answer]] = {
    "volume-blowdown": volume_blowdown,
    "hose-swing": hose_swing,
    "step-up-limit": partial(converter_limit, "step-up-limit"),
    "step-down-limit": partial(converter_limit, "step-down-limit"),
    "buck-converter": buck_converter,
    "pwm-pump-limit": pwm_pump_limit,
    "digital-flow-control-unit": digital_flow_control_unit,
    "rotary-valve-2012": rotary_valve_2012,
    "self-spinning-frequency": self_spinning_frequency,
    **HARD,
}
"""Those whose answer is numbers. That of `event-filter` is a file for each record."""


def write_numbers(path: Path, answer: Answer) -> None:
    """An answer as a table of quantity and value."""
    write_rows(path, ("quantity", "value"), [(name, f"{value:.9g}") for name, value in answer.items()])


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """A CSV file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(header)
        table.writerows(rows)


def scenario_records() -> dict[str, tuple[Scenario, Record]]:
    """The records of `event-filter`, simulated."""
    wanted = tomllib.loads((SET / "event-filter" / "case.toml").read_text("utf-8"))["records"]
    chosen = [scenario for scenario in scenarios() if scenario.name in wanted]
    return {each.name: (each, simulate_record(each, compiled_encoder(each), SEED)) for each in chosen}


def write_records() -> None:
    """Readings and truth of each record, in files that any program reads."""
    for name, (_, record) in scenario_records().items():
        times = [f"{time:.6f}" for time in record.truth.time]
        column = {field: place for place, field in enumerate(READING._fields)}
        edges = record.readings[:, column["edges"]]
        polarity = np.where(edges > 0, record.readings[:, column["polarity"]], 0.0)
        rows = zip(times, edges.astype(int), polarity.astype(int), strict=True)
        write_rows(SET / "event-filter" / f"{name}.csv", ("time_s", "edges", "polarity"), rows)
        speeds = (f"{speed:.6f}" for speed in np.abs(record.truth.speed))
        truth = zip(times, speeds, strict=True)
        write_rows(SET / "event-filter" / f"{name}-truth.csv", ("time_s", "speed_rad_s"), truth)


def write_speeds(folder: Path) -> None:
    """What the event filter makes of the records as they lie in their files."""
    contender = next(each for each in contenders() if each.name == "event-filter")
    step = compiled_step(contender)
    for path in sorted((SET / "event-filter").glob("*-truth.csv")):
        name = path.stem.removesuffix("-truth")
        time, edges, polarity = np.loadtxt(path.with_name(f"{name}.csv"), delimiter=",", skiprows=1).T
        period = np.full_like(time, 1e-3)
        rows = np.column_stack((time, edges, time - 0.5 * period, period, polarity))
        shown = step(contender.memory, rows).shown
        speeds = shown[:, step.columns.index("speed")]
        pairs = ((f"{t:.6f}", f"{speed:.6f}") for t, speed in zip(time, speeds, strict=True))
        write_rows(folder / f"{name}.csv", ("time_s", "speed_rad_s"), pairs)


def main() -> None:
    """Writes the answers to the cases named, or to all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", choices=[*CASES, "event-filter", []])
    parser.add_argument("--records", action="store_true")
    given = parser.parse_args()
    if given.records:
        write_records()
        return
    for case in given.cases or (*CASES, "event-filter"):
        print(case, flush=True)
        if case in CASES:
            write_numbers(ANSWERS / f"{case}.csv", CASES[case]())
        else:
            write_speeds(ANSWERS / case)


if __name__ == "__main__":
    main()
