"""Faults of the whole machine: what tells them, how soon, and that it comes to rest with all pressures bounded.

All faults stand in one text that is compiled once; each run gives one of them its time. The cylinder retracts at 6 s;
the directional valve changes over at 5.178 s, about which a stuck valve is asked to move.
"""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from vvdp.evaluation.summary import summary
from vvdp.programs.machine.supervision import WATCHED
from vvdp.simulation.run import Run, simulate
from vvdp.simulation.values import flat
from vvdp.systems.system import System, load_system, shipped_systems

pytestmark = pytest.mark.slow

SENSORS = {
    "position": ("displacement.position", "-60 mm", "5 mm"),
    "pressure_a": ("displacement.pressure_a", "0 bara", "10 bar"),
    "pressure_b": ("displacement.pressure_b", "0 bara", "10 bar"),
    "line": ("displacement.line_pressure", "0 bara", "10 bar"),
    "light": ("axial_sensor.instrument", "true", "4 %"),
    "pilot": ("axial_observer.pressure", "0 bara", "2 bar"),
    "pilot_law": ("passivity.pressure", "0 bara", "2 bar"),
    "pilot_shown": ("displacement.chamber_pressure", "0 bara", "2 bar"),
}
"""What each sensor reads when its wire is broken, and by how much it is off when it is biased."""
OTHERS = {
    "encoder_lost": 'sensor = "encoder.encoder"\nmissed = "100 %"',
    "spool_stalled": 'jams = "spool"\ntorque = "5 N*m"',
    "spool_stuck": 'jams = "slide"\nforce = "2000 N"',
    "directional_stuck": 'actuator = "displacement.direction"\nstuck = true',
    "return_stuck": 'actuator = "displacement.opening"\nstuck = true',
    "pilot_stuck": 'actuator = "passivity.command"\nstuck = true',
    "power_pump": 'actuator = "displacement.pump"\nlost = "0"',
    "power_directional": 'actuator = "displacement.direction"\nlost = "0"',
    "power_return": 'actuator = "displacement.opening"\nlost = "0"',
    "power_pilot": 'actuator = "passivity.command"\nlost = "-1"',
}
POWER = tuple(name for name in OTHERS if name.startswith("power"))

# Faults that come together, when they begin [s], what tells them, and how soon [ms].
TOLD = {
    "position_lost": (("position_lost",), 6.0, 1, 1),
    "position_frozen": (("position_frozen",), 6.0, 3, 21),
    "position_biased": (("position_biased",), 6.0, 6, 1),
    "pressure_a_lost": (("pressure_a_lost",), 6.0, 2, 1),
    "pressure_a_frozen": (("pressure_a_frozen",), 6.0, 4, 21),
    "pressure_a_biased": (("pressure_a_biased",), 6.0, 14, 1),
    "pressure_b_lost": (("pressure_b_lost",), 6.0, 2, 1),
    "pressure_b_frozen": (("pressure_b_frozen",), 6.0, 4, 21),
    "pressure_b_biased": (("pressure_b_biased",), 6.0, 14, 1),
    "line_lost": (("line_lost",), 6.0, 2, 1),
    "line_frozen": (("line_frozen",), 6.0, 4, 21),
    "line_biased": (("line_biased",), 6.0, 14, 1),
    "light_lost": (("light_lost",), 6.0, 9, 2),
    "light_frozen": (("light_frozen",), 6.0, 5, 22),
    "light_biased": (("light_biased",), 6.0, 9, 2),
    "pilot_lost": (("pilot_lost", "pilot_law_lost", "pilot_shown_lost"), 6.0, 2, 1),
    "pilot_frozen": (("pilot_frozen", "pilot_law_frozen", "pilot_shown_frozen"), 6.0, 4, 21),
    "pilot_biased": (("pilot_biased", "pilot_law_biased", "pilot_shown_biased"), 6.0, 10, 40),
    "encoder_lost": (("encoder_lost",), 6.0, 11, 24),
    "spool_stalled": (("spool_stalled",), 6.0, 11, 24),
    "spool_stuck": (("spool_stuck",), 5.165, 10, 44),
    "directional_stuck": (("directional_stuck",), 5.165, 8, 152),
    "return_stuck": (("return_stuck",), 5.185, 8, 154),
    "pilot_stuck": (("pilot_stuck",), 5.165, 10, 72),
    "power_lost": (POWER, 6.0, 9, 9),
}
PAGE = Path(__file__).parents[2] / "docs" / "models" / "faults.md"


def faulty_text() -> str:
    """The shipped machine with all faults, none of which begins."""
    tables = dict(OTHERS)
    for name, (sensor, lost, bias) in SENSORS.items():
        told = lost if lost == "true" else f'"{lost}"'
        tables[f"{name}_lost"] = f'sensor = "{sensor}"\nlost = {told}'
        tables[f"{name}_frozen"] = f'sensor = "{sensor}"\nfrozen = true'
        tables[f"{name}_biased"] = f'sensor = "{sensor}"\nbias = "{bias}"'
    text = shipped_systems()["displacement-control"]
    return text + "".join(f'\n[faults.{name}]\n{body}\nbegin = "1e5 s"\n' for name, body in tables.items())


@pytest.fixture(scope="module")
def run_with(tmp_path_factory):
    """Runs the machine with faults from a time on, for so long after."""
    path = tmp_path_factory.mktemp("faults") / "machine.toml"
    path.write_text(faulty_text(), "utf-8")

    @cache
    def run(names: tuple[str, ...], begin: float, until: float, *settings: str) -> tuple[System, Run]:
        begins = (f"faults.{name}.begin={begin} s" for name in names)
        system = load_system(str(path), [*begins, *settings], until=f"{until} s")
        return system, simulate(system.model, system.case, system.stepping)

    return run


def bounded(run: Run, highest: float) -> bool:
    """Whether every number is one, and no pressure leaves what the machine stands [bar, gauge]."""
    pressures = [getattr(run.state, name) for name in ("inlet", "line", "chamber_a", "chamber_b", "pilot_chamber")]
    return bool(np.all(np.isfinite(flat(run.final)))) and all(
        p.min() > 0.0 and (p.max() - 101325.0) / 1e5 < highest for p in pressures
    )


@pytest.mark.parametrize("name", TOLD)
def test_each_fault_is_told_soon_and_the_machine_comes_to_rest(run_with, name):
    names, begin, number, soon = TOLD[name]
    system, run = run_with(names, begin, begin + 0.6)
    found = summary(system, run)
    assert found["alarm"] == number, WATCHED[number - 1]
    after = found["alarm_time_s"] - begin
    assert 0.0 <= after < 0.2 and 1e3 * after == pytest.approx(soon, abs=4.0)
    if name == "power_lost":
        assert after < 0.02
    assert bounded(run, 95.0)
    assert abs(found["energy_residual"]) < 1e-6 and abs(found["mass_residual"]) < 1e-6
    command = run.command.displacement
    assert (command.pump[-1], command.energised[-1], command.dump[-1]) == (0.0, 0.0, 0.0) or name == "power_lost"
    assert abs(run.state.rod.velocity[-1]) < 5e-3
    if name != "spool_stuck":
        assert run.state.slide.position[-1] < -6e-3  # all flow goes to the tank


def test_the_page_has_these_numbers():
    rows = dict(re.findall(r"^\| `(\w+)` \|.*\| (\d+) \|$", PAGE.read_text("utf-8"), re.MULTILINE))
    assert rows == {name: str(soon) for name, (_, _, _, soon) in TOLD.items()}


def test_missed_edges_are_borne(run_with):
    """A fifth of the edges for the rest of the run: no alarm, and 0.1 cm after a reversal."""
    _, run = run_with(("encoder_lost",), 4.0, 7.0, "faults.encoder_lost.missed=20 %")
    command = run.command.displacement
    assert np.all(command.alarm == 0.0) and bounded(run, 70.0)
    assert np.max(np.abs(run.state.rod.position - command.reference)[run.times > 4.0]) < 1.5e-3


@pytest.mark.parametrize("seed", range(1, 6))
def test_no_false_alarm(run_with, seed):
    seeds = (f"{table}.seed={seed}" for table in ("axial_sensor", "encoder", "cylinder_sensors"))
    _, run = run_with((), 0.0, 12.0, *seeds)
    assert np.all(run.command.displacement.alarm == 0.0)
