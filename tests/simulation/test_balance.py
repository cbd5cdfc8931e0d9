"""The books balance where everything is entered, and show it where something is not."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import NOTHING, Books, Stored
from vvdp.base.errors import RunError
from vvdp.base.kinds import Angle, Energy, ExchangedEnergy, Fraction, Pressure
from vvdp.base.signal import constant, step
from vvdp.simulation.balance import LIMIT, balance, states_outside
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Stepping, simulate


def balanced(switching, wrong=None, tolerance=1e-7, **changes):
    model, case = switching
    found = replace(model, circuit=wrong) if wrong else model
    return balance(simulate(found, case(**changes), Stepping(until=0.1, relative_tolerance=tolerance)))


def test_books_of_the_switching_circuit_close(switching):
    books = balanced(switching)
    assert books.is_trusted
    assert abs(books.energy_residual) < 1e-7
    assert abs(books.mass_residual) < 1e-7
    assert books.falling == books.outside == ()


def test_residual_falls_with_the_tolerance(switching):
    """It is the error of the run and nothing else."""
    books = balanced(switching, tolerance=1e-10)
    assert abs(books.energy_residual) < 1e-10
    assert abs(books.mass_residual) < 1e-10


def test_coarse_run_is_not_trusted(switching):
    assert not balanced(switching, tolerance=1e-2).is_trusted


@pytest.mark.parametrize("tank", [constant(5e5), step(1e5, 4e5, 0.0203), constant(0.8e5)])
def test_books_balance_with_a_tank_that_is_not_at_the_reference_pressure(switching, tank):
    """Tank pressure is a condition: held from sample to sample, so that a step of it needs no sample of its own."""
    assert balanced(switching, tank_pressure=tank).is_trusted


# Circuits that forget an entry, or have one wrong, each a plain vessel with a pump and a leak


class Leak(NamedTuple):
    leak: Energy


class Handed(NamedTuple):
    leak: ExchangedEnergy


class Pump(NamedTuple):
    pump: Energy


class Opening(NamedTuple):
    opening: Fraction
    angle: Angle


class Vessel(NamedTuple):
    pressure: Pressure
    books: Books


CAPACITY = 1e-11
FLOW = 1e-4


def start(spent) -> Case:
    return Case(Vessel(2e5, Books(Pump(0.0), spent, 0.0, 0.0)), NOTHING)


def stored(s, p):
    return Stored(0.5 * CAPACITY * s.pressure**2, CAPACITY * s.pressure)


def entered(s, out, loss, spent):
    books = Books(Pump(FLOW * s.pressure), spent(loss), FLOW, out, NOTHING)
    return Vessel((FLOW - out) / CAPACITY, books), NOTHING


def leaking(t, s, u, p):
    out = 1e-10 * s.pressure
    return entered(s, out, out * s.pressure, Leak)


def forgetful(t, s, u, p):
    out = 1e-10 * s.pressure
    return entered(s, out, 0.9 * out * s.pressure, Leak)


def thirsty(t, s, u, p):
    out = 1e-10 * s.pressure
    rates, outputs = entered(s, out, out * s.pressure, Leak)
    return Vessel(0.99 * rates.pressure, rates.books), outputs


def uphill(t, s, u, p):
    """The leak runs the wrong way round: from a tank at 1 bar into a vessel of higher pressure."""
    out = -1e-10 * (s.pressure - 1e5)
    return entered(s, out, out * s.pressure, Leak)


def handing(t, s, u, p):
    out = -1e-10 * (s.pressure - 1e5)
    return entered(s, out, out * s.pressure, Handed)


def emptied(t, s, u, p):
    """A machine that draws a fixed flow, whatever is left."""
    out = 1.5 * FLOW
    return entered(s, out, out * s.pressure, Handed)


def found(circuit, spent=Leak, until=1.0):
    return simulate(Model(circuit, stored), start(spent(0.0)), Stepping(until=until))


def test_a_vessel_with_all_its_entries_is_trusted():
    assert balance(found(leaking)).is_trusted


def test_forgotten_loss_is_seen():
    books = balance(found(forgetful))
    assert books.energy_residual > 1e-2
    assert abs(books.mass_residual) < LIMIT
    assert not books.is_trusted


def test_oil_that_vanishes_is_seen():
    assert not balance(found(thirsty)).is_trusted


def test_a_sink_that_gives_energy_is_named_and_not_trusted():
    """Both residuals are small: only the sign of the loss tells that oil runs up the pressure."""
    books = balance(found(uphill, until=0.05))
    assert abs(books.energy_residual) < LIMIT and abs(books.mass_residual) < LIMIT
    assert books.falling == ("leak",)
    assert not books.is_trusted


def test_energy_that_is_handed_on_may_come_back():
    books = balance(found(handing, Handed, until=0.05))
    assert books.energy_out < 0.0
    assert books.falling == ()
    assert books.is_trusted


def test_a_run_stops_where_a_pressure_falls_below_absolute_zero():
    """It is named at the first step behind zero: at 2e5 Pa, falling by 5e6 Pa/s, t = 40 ms."""
    with pytest.raises(
        RunError, match=r"t = 0\.04\d* s: " + wording.systems.below_zero_absolute.format(place="pressure", limit="0 Pa")
    ):
        found(emptied, Handed, until=0.05)


def test_a_state_outside_the_range_of_its_kind_is_named_and_not_trusted():
    """An opening of -1 %, which has a range of 0 to 1; a little beyond is the tolerance of the run."""
    case = Case(Opening(0.5, 3.0), NOTHING)
    low, high = np.array([0.0, -50.0]), np.array([1.0, 50.0])
    assert states_outside(case, low - 1e-6, high + 1e-6) == ()
    assert states_outside(case, low - 0.01, high) == ("opening",)
    assert states_outside(case, low, high + 0.01) == ("opening",)
