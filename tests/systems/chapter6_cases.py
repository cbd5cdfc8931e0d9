"""The cases of chapter 6 as settings of the shipped system, and what they come to."""

import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tests.systems.axial_texts import change

from vvdp.evaluation.summary import summary
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system, shipped_systems

NAME = "displacement-chapter6"
AREA_A, AREA_B = 20.26e-4, 10.77e-4
OUT_OF_REACH = (
    "pressure_bounds.lowest_pressure=0 bara",
    "pressure_bounds.transition_band=0.001 bar",
    "pressure_bounds.highest_pressure=1000 bar",
)
"""Bounds that no chamber comes near: no pressure mode acts."""
PRINTED = (
    "direction.hysteresis=0 N/s",
    "flow_split.expected_flow=0 lpm",
    "flow_split.uses_delivered_flow=0",
)
"""The law as printed: sign(U*), no mean flow in the split, the opening from what the split asks of the pump."""


def loaded(force: float, pressure: float) -> tuple[str, ...]:
    """A load [N] that is known, and chambers that hold it at rest, a at this pressure [bar]."""
    other = (1e5 * pressure * AREA_A + force) / (1e5 * AREA_B)
    return (
        f"operation.load_force={force} N",
        f"belief.load_force={force} N",
        f"initial.pressure_a={pressure} bar",
        f"initial.pressure_b={other:.4f} bar",
    )


OVERRUNNING = loaded(3000.0, 10.0)
SLOW = ("cycle.stroke_time=16 s",)
HEAVY = loaded(-6000.0, 40.0)
ALL_MODES = (
    'operation.load_force={ table = [["0 s", "-1000 N"], ["8 s", "-1000 N"], ["9 s", "3000 N"], ["30 s", "3000 N"], '
    '["31 s", "-1000 N"], ["50 s", "-1000 N"], ["51 s", "-6000 N"], ["72 s", "-6000 N"], ["73 s", "-1000 N"]] }',
    "adaptation.load_gain=4e4 N/m",
    "adaptation.lowest_load=-9000 N",
    "pressure_bounds.lowest_pressure=3 bar",
    "pressure_bounds.highest_pressure=70 bar",
    "pressure_bounds.transition_band=4 bar",
)
"""A load that overruns in either direction: all modes act."""
HEAVIEST = (*loaded(-10000.0, 60.0), "cycle.stroke_time=2.5 s")


@cache
def ran(*settings: str, until: str = "16 s") -> tuple[dict, Run]:
    """Summary and run of the shipped system with settings; the same one is run once."""
    return found_in(load_system(NAME, settings, until=until))


def found_in(system: System) -> tuple[dict, Run]:
    run = simulate(system.model, system.case, system.stepping)
    return summary(system, run), run


def in_mode(found: dict, mode: int) -> float:
    """Share of the time in a mode and its transition."""
    return float(found[f"mode_{mode}_share"] + found[f"mode_{mode}_5_share"])


def sample_rows(run: Run) -> np.ndarray:
    """The rows of a run at samples, one every millisecond."""
    rows = np.flatnonzero(np.abs(1e3 * run.times - np.round(1e3 * run.times)) < 1e-6)
    assert np.all(np.diff(np.round(1e3 * run.times[rows])) == 1.0)
    return rows


def pressures(run: Run, begin: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Pressures of both chambers after a time [bar, gauge]."""
    late = run.times > begin
    return tuple((values[late] - 101325.0) / 1e5 for values in (run.state.chamber_a, run.state.chamber_b))  # type: ignore[return-value]


def sine_text() -> str:
    """The shipped system with a sine of 0.5 Hz and 5 cm as its cycle, and a plant of which its controller knows little.

    Mass 300 kg and load -2500 N for 100 kg and -1000 N believed, modulus 400 MPa for 700 MPa.
    """
    times = np.linspace(0.0, 2.0, 201)
    positions = 15.8 + 5.0 * np.sin(np.pi * times)
    positions[-1] = positions[0]
    rows = [
        "[cycle]",
        'times = { value = ["' + '", "'.join(f"{t:.2f} s" for t in times) + '"], status = "assumed" }',
        'positions = { value = ["' + '", "'.join(f"{x:.9f} cm" for x in positions) + '"], status = "assumed" }',
        'repeats = { value = "1", status = "assumed" }',
    ]
    parts = re.split(r"(?m)^(?=\[)", shipped_systems()[NAME])
    text = "".join("\n".join(rows) + "\n\n" if part.startswith("[cycle]") else part for part in parts)
    text = change(text, "return_valve", conductance="2e-7 m^3/(s*Pa^0.5)")
    text = change(text, "load", mass="300 kg")
    text = change(text, "oil", liquid_bulk_modulus="400 MPa")
    text = change(text, "operation", load_force="-2500 N")
    text = change(text, "initial", position="15.8 cm", pressure_a="20 bar", pressure_b="14.41 bar")
    return change(text, "run", until="24 s", average_from="16 s")


LEARNS_LOAD = {"load_gain": "4e4 N/m"}
LEARNS_MASS = LEARNS_LOAD | {"mass_gain": "2e4 kg*s^2/m^2"}
LEARNS_ALL = LEARNS_MASS | {"compliance_gain": "1e-19 m/(N^2*Pa)"}
KNOWN = {"load_force": "-2500 N", "moving_mass": "300 kg", "bulk_modulus": "400 MPa"}


@cache
def learned(gains: tuple[tuple[str, str], ...] = (), known: bool = False) -> tuple[float, float, Run]:
    """Error from 16 to 24 s of the sine, rms and largest [cm], and the run."""
    text = change(sine_text(), "adaptation", **dict(gains)) if gains else sine_text()
    text = change(text, "belief", **KNOWN) if known else text
    with TemporaryDirectory() as folder:
        path = Path(folder) / "sine.toml"
        path.write_text(text, "utf-8")
        _, run = found_in(load_system(str(path)))
    rows = sample_rows(run)
    rows = rows[run.times[rows] > 16.0]
    error = 100.0 * (run.state.rod.position[rows[:-1]] - run.command.reference.value[rows[1:]])
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error))), run
