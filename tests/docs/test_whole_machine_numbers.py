"""Numbers that docs/models/whole-machine.md spells out, from runs of the machine."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.systems.displacement.machine_texts import change, system_of
from tests.systems.displacement.test_flow_table import delivered, the_map
from tests.systems.displacement.test_machine import idle

from vvdp.control.flow_map import flow_for_duty
from vvdp.programs.machine.phases import CONTROL
from vvdp.programs.machine.power import mean_powers, whole_periods
from vvdp.simulation.run import simulate
from vvdp.systems.system import shipped_systems

PAGE = (Path(__file__).parents[2] / "docs" / "models" / "whole-machine.md").read_text("utf-8")
WORDS = " ".join(PAGE.split())
HERTZ = 3.0 / (2.0 * np.pi)


def test_idling():
    low, zero = idle("-6.2 mm"), idle("0 mm")
    found = [(each["power_pump_shaft_W"], each["speed_mean_spool_rad_s"] * HERTZ) for each in (low, zero)]
    (p1, f1), (p2, f2) = found
    assert f"{p1:.0f} W and {f1:.1f} Hz at $-6.2$ mm, {p2:.0f} W and {f2:.1f} Hz at 0" in WORDS


def test_map():
    assert f"{len(the_map().duty_ratios)} duty ratios" in WORDS
    more = []
    for duty, opening in ((0.12, 0.3), (0.2, 0.8), (0.5, 0.9)):
        flow, pressure = delivered(duty, opening)
        more.append(100.0 * (flow / 6e4 / flow_for_duty(duty, 101325.0 + 1e5 * pressure, the_map()) - 1.0))
    text = f"{more[0]:.1f} % more than its map at 0.12, {more[1]:.1f} % at 0.2 and {more[2]:.1f} % at 0.5"
    assert text in WORDS


@cache
def powers() -> dict:
    """Over a whole period of the reference from the first second of control on, nothing supervised."""
    text = re.sub(r"(?ms)^\[supervision\].*?(?=^\[)", "", shipped_systems()["displacement-control"])
    text = change(text, supply_support__support_conductance="0 m^3/(s*Pa)", valve__jet_exponent="0")
    system = system_of(text, "11 s")
    run = simulate(system.model, system.case, system.stepping)
    begin = float(run.times[np.argmax(run.command.displacement.phase >= CONTROL)]) + 1.0
    return mean_powers(run, *whole_periods(run, begin, 8.0))


@pytest.mark.thorough
def test_powers():
    """To the last figure of the table, or half a per cent; those specified within 3 % above 50 W, and within 2 W."""
    keys = ("pump_power", "full_open_loss", "transition_loss", "relief_loss", "leakage_loss", "directional_loss")
    keys += ("return_loss", "friction_loss", "actuator_power", "ideal_pump_power")
    found = [powers()[f"{key}_mean_W"] for key in keys]
    here, other = (
        re.findall(r"[\d.]+", next(row for row in PAGE.splitlines() if row.startswith(f"| {name} |")))
        for name in ("here", "independent implementation")
    )
    for value, shown, specified in zip(found, here, map(float, other), strict=True):
        figures = len(shown.partition(".")[2])
        assert value == pytest.approx(float(shown), abs=max(0.6 * 10.0**-figures, 5e-3 * value))
        assert value == pytest.approx(specified, abs=max(2.0, 0.03 * specified if specified > 50.0 else 0.0))
