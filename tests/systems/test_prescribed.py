"""What is prescribed over time acts at every instant, however seldom conditions are sampled."""

from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

PULSING = [
    'operation.tank_pressure={sine="3 bar", amplitude="2 bar", frequency="62 Hz"}',
    'operation.duty_ratio="0.5"',
]


def test_a_tank_pressure_that_pulses_with_the_valve_is_not_held_between_samples():
    """Held for 1 ms it moved the load's power by 0.45 %; the sample period may matter as little as the tolerance."""
    system = load_system("prototype-constant-load", PULSING, until="0.1 s")
    finals = []
    for period in (1e-3, 2.5e-4):
        stepping = replace(system.stepping, relative_tolerance=1e-9, sample_period=period)
        finals.append(simulate(system.model, system.case, stepping).final_state.books)
    rows = ([*b.totals._replace(valve_cavitating=0.0), b.taken_in, b.given_out, *b.spent.valve] for b in finals)
    mine, finer = map(np.array, rows)
    assert mine == pytest.approx(finer, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize(("frequency", "phase"), [("62 Hz", "0 deg"), ("1000 Hz", "90 deg")])
def test_a_return_line_that_pulses_costs_the_same_however_seldom_it_is_sampled(frequency, phase):
    """Held for 1 ms, 62 Hz moved the load's power by 0.45 % and 1 kHz by 4.7 %."""
    pulse = f'{{sine="5 bar", amplitude="4.5 bar", frequency="{frequency}", phase="{phase}"}}'
    found = []
    for period in ("1 ms", "0.05 ms"):
        settings = [f"operation.tank_pressure={pulse}", "run.average_from=0.3 s", f"run.sample_period={period}"]
        system = load_system("prototype-constant-load", settings, until="0.6 s")
        numbers = summary(system, simulate(system.model, system.case, system.stepping))
        found.append([numbers[key] for key in ("loss_total_W", "load_power_W", "loss_nozzle_W")])
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_a_temperature_too_fast_for_its_sampling_is_refused():
    fast = 'operation.oil_temperature={sine="40 degC", amplitude="5 K", frequency="60 Hz"}'
    with pytest.raises(
        ConfigError, match=wording.systems.swings_once_per_sample.format(frequency="60 Hz", limit="0.00083 s")
    ):
        load_system("prototype", [fast])
    assert load_system("prototype", [fast, "run.sample_period=0.5 ms"]).stepping.sample_period == 5e-4
