"""What is prescribed over time acts at every instant, however seldom conditions are sampled."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
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


def test_a_temperature_too_fast_for_its_sampling_is_refused():
    fast = 'operation.oil_temperature={sine="40 degC", amplitude="5 K", frequency="60 Hz"}'
    with pytest.raises(ConfigError, match=r"swings at 60 Hz and is read once per sample; expected at most 0.00083 s"):
        load_system("prototype", [fast])
    assert load_system("prototype", [fast, "run.sample_period=0.5 ms"]).stepping.sample_period == 5e-4
