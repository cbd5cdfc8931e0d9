"""Systems of a controlled chamber drive, made of the shipped ones; and the trapezoid of the specification."""

import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vvdp.programs.axial_numbers import Controlled, ExactLaw
from vvdp.programs.chamber_report import ChamberLawReport
from vvdp.programs.spool_report import rows_at_samples
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system, shipped_systems

HELIX = 20.32
"""Length of the helix [mm]."""
TURN = 2.0 * np.pi
RAW_RATE = 60.0 * TURN
"""Filter of the raw feedback: 60 Hz."""
TABLE = {
    "error_rate": "50 1/s",
    "position_gain": "550 N/m",
    "velocity_gain": "45 N*s/m",
    "pressure_weight": "3e-12 m^3/Pa",
    "flow_gain": "4e-10 m^3/(s*Pa)",
}
"""Gains of backstepping, table 5.1."""
MILD = TABLE | {"position_gain": "55 N/m", "velocity_gain": "4 N*s/m"}
"""Those of the passivity law."""


PLACES = {
    ("operation", "duty_ratio"): "parts.drive",
    ("operation", "spool_speed"): "nodes.spool",
    ("axial_friction", "viscous_friction"): "parts.drive",
    ("axial_reference", "filter_rate"): "parts.drive",
    ("axial_sequence", "learn_time"): "parts.drive",
    ("axial_observer", ""): "programs.drive.observer",
    ("axial_sequence", ""): "programs.drive.observer",
    ("axial_sensor", ""): "programs.drive.sensor",
    ("passivity", ""): "programs.drive.law",
}
"""Where the drawn drive has what the tables of the other systems have."""
GEROTOR_PLACES = {
    ("operation", "duty_ratio"): "parts.drive",
    ("operation", "spool_speed"): "nodes.spool",
    ("axial_observer", ""): "programs.drive.observer",
    ("axial_observer", "sample_period"): "parts.drive",
    ("axial_sequence", ""): "programs.drive.observer",
    ("axial_sensor", ""): "programs.drive.sensor",
    ("axial_reference", ""): "programs.drive.reference",
    ("gerotor", ""): "components.drive.gerotor",
    ("characteristic", ""): "components.drive.gerotor",
    ("calibration", ""): "parts.drive",
}
"""The same of the drive with a gerotor pump."""
NAMES = {("operation", "spool_speed"): "speed"} | {
    ("calibration", key): f"believed_{key}"
    for key in ("lag", "largest_flow", "forward_dead_band", "backward_dead_band", "backward_gain")
}


def change(text: str, table: str, **values: str) -> str:
    """A system's text with other values in a table, which is added where there is none; that of the drawn drive in the
    places that these have there."""
    if "[parts.drive]" not in text:
        return change_table(text, table, **values)
    places = GEROTOR_PLACES if 'type = "gerotor-drive"' in text else PLACES
    for key, value in values.items():
        place = places.get((table, key), places.get((table, ""), table))
        text = change_table(text, place, **{NAMES.get((table, key), key): value})
    return text


def change_table(text: str, table: str, **values: str) -> str:
    """A system's text with other values in a table, which is added where there is none."""
    parts = re.split(r"(?m)^(?=\[)", text)
    rows = dict(values)
    for i, part in enumerate(parts):
        if part.startswith(f"[{table}]"):
            lines = [line for line in part.rstrip().splitlines() if line.partition(" = ")[0] not in rows]
            parts[i] = "\n".join([*lines, *(row(key, value) for key, value in rows.items())]) + "\n\n"
            return "".join(parts)
    return "\n".join([text.rstrip() + "\n", f"[{table}]", *(row(key, value) for key, value in rows.items())]) + "\n"


def row(key: str, value: str) -> str:
    return f"{key} = {value}" if value.startswith("{") else f'{key} = "{value}"'


def without(text: str, table: str) -> str:
    """A system's text without a table."""
    return "".join(part for part in re.split(r"(?m)^(?=\[)", text) if not part.startswith(f"[{table}]"))


def told_truth(text: str, velocity_rate: float) -> str:
    """The drawn drive with a law that is told the true position, and the true velocity behind a filter [1/s]."""
    text = change_table(text, "programs.drive.law", position="drive.slide.position", velocity="told.value")
    told = {"type": "low-pass", "reads": "drive.slide.velocity", "time_constant": f"{1.0 / velocity_rate!r} s"}
    return change_table(text, "programs.told", **told)


def told_sensor(text: str, velocity_rate: float) -> str:
    """The drawn drive with a law that is told what the sensor shows, and its slope behind a filter [1/s]."""
    text = change_table(text, "programs.drive.law", position="drive.sensor.position", velocity="told.rate")
    told = {"type": "derivative", "reads": "drive.sensor.position", "time_constant": f"{1.0 / velocity_rate!r} s"}
    return change_table(text, "programs.told", **told)


def raw_text(text: str) -> str:
    """The pump unit whose law is told what the sensor shows, and its slope behind a filter."""
    text = change_table(text, "programs.passivity", position="axial_sensor.position", velocity="told.rate")
    told = {"type": "derivative", "reads": "axial_sensor.position", "time_constant": f"{1.0 / RAW_RATE!r} s"}
    return change_table(text, "programs.told", **told)


def told_estimate(text: str) -> str:
    """The drawn drive with a law that is told what the observer estimates."""
    text = without(text, "programs.told")
    return change_table(
        text, "programs.drive.law", position="drive.observer.position", velocity="drive.observer.velocity"
    )


def rename(text: str, table: str, new: str) -> str:
    for law in ("programs.drive.law", f"programs.{table}"):
        if f"[{law}]" in text or (law == "programs.drive.law" and "[parts.drive]" in text):
            return change_table(text, law, type=new.replace("_", "-"))
    return text.replace(f"\n[{table}]\n", f"\n[{new}]\n")


def table_signal(points: list[tuple[float, float]]) -> str:
    """A duty ratio over time from times [s] and positions [mm]."""
    return "{ table = [" + ", ".join(f'["{t:.9g} s", "{x / HELIX:.12g}"]' for t, x in points) + "] }"


def trapezoid_text(periods: int = 3, pause: float = 0.2) -> str:
    """0.25 to 5.25 mm in ramps of 50 ms from 0.6 s on, the drive of the specification: no friction, lambda_3 of the
    table, reference filter 250 1/s, no learning; the law is told the truth."""
    points, now = [(0.0, 0.25), (0.6, 0.25)], 0.6
    for _ in range(periods):
        for duration, end in ((0.05, 5.25), (pause, 5.25), (0.05, 0.25), (pause, 0.25)):
            now += duration
            points.append((now, end))
    text = change(shipped_systems()["axial-chamber"], "operation", duty_ratio=table_signal(points))
    text = change(text, "axial_friction", viscous_friction="0 N*s/m")
    text = change(text, "axial_reference", filter_rate="250 1/s")
    text = change(text, "passivity", flow_gain="4e-10 m^3/(s*Pa)", pressure_rate="0 1/s")
    text = change(text, "axial_sequence", learn_time="0 s")
    return change(told_truth(text, 1e6), "run", until=f"{now:.6g} s", average_from=f"{now - 0.1:.6g} s")


def backstepping_text(text: str, gains: dict[str, str]) -> str:
    kept = [line for line in text.splitlines() if not line.startswith(("flow_gain", "pressure_rate"))]
    return change_table("\n".join(kept) + "\n", "programs.drive.law", type="backstepping", **gains)


def sample_text(text: str, milliseconds: float) -> str:
    """The same with another sample period."""
    text = change(text, "run", record_interval=f"{milliseconds} ms", sample_period=f"{milliseconds} ms")
    return change(text, "axial_observer", sample_period=f"{milliseconds} ms")


def system_of(text: str) -> System:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "own.toml"
        path.write_text(text, "utf-8")
        return load_system(str(path))


@cache
def run_of(text: str) -> tuple[System, Run]:
    system = system_of(text)
    return system, simulate(system.model, system.case, system.stepping)


def report_of(system: System) -> ChamberLawReport:
    """What the law of the drawn drive reports."""
    return ChamberLawReport(system.circuit.network, "drive_law", system.stepping.sample_period)


def law_of(system: System) -> ExactLaw:
    """The law of the drawn drive."""
    found = report_of(system).law
    assert found is not None
    return found


def rows_from(text: str, begin: float) -> Controlled:
    """The samples of the drawn drive from `begin` [s] on."""
    system, run = run_of(text)
    found = report_of(system).run_rows(run)
    return found.rows(found.times >= begin - 1e-9)


def tracking(text: str, begin: float = 0.6) -> float:
    """Error of the spool against the reference, rms [um]."""
    found = rows_from(text, begin)
    return rms(found.true.position - found.reference.position)


def estimation(text: str, begin: float) -> float:
    """Error of the estimate, rms [um]."""
    system, run = run_of(text)
    report = report_of(system)
    now, after = rows_at_samples(run, report.program, report.period)
    late = run.times[now] >= begin - 1e-9
    return rms((run.command.drive_observer.position[after] - run.state.drive_slide.position[now])[late])


def rms(metres: np.ndarray) -> float:
    return 1e6 * float(np.sqrt(np.mean(metres**2)))
