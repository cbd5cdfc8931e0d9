"""Steps and laws give the same numbers in plain Python and compiled."""

import numpy as np
import pytest
from tests.compiled import compiled

from vvdp.control.backstepping import backstepping_law
from vvdp.control.chamber import ChamberReading
from vvdp.control.feedforward_pi import FeedforwardPI, PIMemory, pi_step
from vvdp.control.orifice import valve_command, valve_flow
from vvdp.control.passivity import passivity_law, printed_passivity_law
from vvdp.control.reference import Reference, ReferenceFilter, reference_step
from vvdp.control.storage import loop_balance


def numbers(result):
    return [x for part in result for x in numbers(part)] if isinstance(result, tuple) else [float(result)]


@pytest.fixture
def draw():
    """Makes a random reference and reading."""
    rng = np.random.default_rng(4)

    def drawn():
        reference = Reference(*(rng.uniform(-1.0, 1.0, 4) * (5e-3, 0.05, 5.0, 500.0)).tolist())
        return reference, ChamberReading(*rng.uniform((0.0, -0.05, 9e5), (5e-3, 0.05, 14e5)).tolist())

    return drawn


def test_laws_compile(draw, drive, passive, backstepping):
    learnt = 2e-6  # m^3, volume beside that of the drive
    rows = [
        (passivity_law, (passive, drive, learnt)),
        (printed_passivity_law, (passive, drive)),
        (backstepping_law, (backstepping, drive)),
    ]
    for law, settings in rows:
        fast = compiled(law, *draw(), *settings)
        for _ in range(20):
            seen = draw()
            plain = numbers(law(*seen, *settings))
            assert numbers(fast(*seen, *settings)) == pytest.approx(plain, rel=1e-11, abs=1e-16)


def test_everything_else_compiles(draw, drive, passive):
    pi = FeedforwardPI(area=5e-4, proportional_rate=30.0, integral_rate=90.0, lowest_flow=-3e-5, highest_flow=3e-5)
    reference, reading = draw()
    steps = [
        (reference_step, (reference, 1e-3, 1e-3), (ReferenceFilter(filter_rate=150.0),)),
        (pi_step, (PIMemory(1e-6), reference, 2e-3, 1e-3), (pi,)),
        (valve_command, (2e-5, 12e5), (drive.valve,)),
        (valve_flow, (0.3, 12e5), (drive.valve,)),
        (loop_balance, (2e-5, reference, reading), (passive, drive)),
    ]
    for function, inputs, settings in steps:
        plain = numbers(function(*inputs, *settings))
        found = numbers(compiled(function, *inputs, *settings)(*inputs, *settings))
        assert found == pytest.approx(plain, rel=1e-11, abs=1e-16), function.__name__
