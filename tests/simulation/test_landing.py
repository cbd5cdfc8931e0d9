"""Steps that end where a mode or a kink changes: against closed forms, and the order of the methods across them."""

import re
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import NOTHING, Nothing
from vvdp.base.errors import RunError
from vvdp.base.kinds import Angle, Kind, Kink, Mode, Ratio
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.select import maximum, minimum, select
from vvdp.simulation import places
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Method, Stepping, simulate
from vvdp.simulation.schedule import landing_time

PLAIN = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
BOTH = (Method.EXPLICIT, Method.STIFF)


class Level(NamedTuple):
    x: PLAIN


class Turning(NamedTuple):
    direction: Mode


class Held(NamedTuple):
    modes: Turning


class Rates(Params):
    up: Ratio
    down: Ratio


def sawtooth(t: float, s: Level, u: Held, p: Rates) -> tuple[Level, Nothing, Turning]:
    """Up at one rate to 1, down at another to 0, and again."""
    falling = u.modes.direction
    position = side(select(falling > 0.5, s.x, s.x - 1.0))
    return Level(select(falling > 0.5, -p.down, p.up)), NOTHING, Turning(position)


@pytest.mark.parametrize(
    ("stop", "due", "expected"),
    [
        (2.0, 3.0, 2.0),
        (3.0, 2.0, 2.0),
        (np.inf, np.inf, 4.0),
        (2.0, np.nextafter(2.0, 0.0), 2.0),  # a jump a hair behind a sample: both at the jump
        (np.nextafter(2.0, 0.0), 2.0, np.nextafter(2.0, 0.0)),
        (np.nextafter(4.0, 9.0), np.inf, np.nextafter(4.0, 9.0)),
        (2.0, 2.0 * (1.0 - 1e-14), 2.0 * (1.0 - 1e-14)),  # further apart than rounding: two steps
    ],
)
def test_a_step_between_two_instants_that_differ_by_rounding_is_not_taken(stop, due, expected):
    assert landing_time(stop, due, 4.0) == expected


def run_of(circuit, command, params, until, state=None, **stepping):
    case = Case(state or Level(0.0), params, command)
    usual = {"record_interval": until, "window": 1e-9, "relative_tolerance": 1e-6}
    return simulate(Model(circuit), case, Stepping(until=until, **(usual | stepping)))


@pytest.mark.parametrize("method", BOTH)
def test_a_sawtooth_turns_where_it_should(method):
    """By hand: 1/2 s up and 1/3 s down; after 100 teeth and 0.25 s it stands at 0.5."""
    until = 100.0 * (1.0 / 2.0 + 1.0 / 3.0) + 0.25
    run = run_of(sawtooth, Held(Turning(0.0)), Rates(up=2.0, down=3.0), until, method=method)
    # Each turn is landed on within 1e-7 of a step, and a step is at most half a second.
    assert run.final[0] == pytest.approx(0.5, abs=200 * 1e-7 * 0.5 * 5.0)
    assert run.low[0] >= -3e-7 and run.high[0] <= 1.0 + 3e-7
    assert run.reached.clock[places.EVENTS] == 200.0


def test_a_run_in_portions_and_one_that_goes_on_land_alike():
    params, command = Rates(up=2.0, down=3.0), Held(Turning(0.0))
    whole = run_of(sawtooth, command, params, 10.0)
    case = Case(Level(0.0), params, command)
    stepping = Stepping(until=10.0, record_interval=10.0, window=1e-9, relative_tolerance=1e-6)
    pieces = simulate(Model(sawtooth), case, stepping, portion=1.0)
    assert np.array_equal(pieces.final, whole.final) and pieces.evaluations == whole.evaluations
    first = run_of(sawtooth, command, params, 4.0)
    second = simulate(Model(sawtooth), case, stepping, continue_from=first)
    assert second.final[0] == whole.final[0]


class Swing(NamedTuple):
    angle: Angle
    x: PLAIN


class Half(NamedTuple):
    half: Kink


class KinkHeld(NamedTuple):
    modes: Half


def humps(t: float, s: Swing, u: KinkHeld, p: Rates) -> tuple[Swing, Nothing, Half]:
    """x' = x |sin(angle)|, angle' = 1: over a whole turn ln x grows by 4."""
    sine = np.sin(s.angle)
    return Swing(1.0, s.x * maximum(sine, -sine)), NOTHING, Half(side(sine))


class Unnamed(NamedTuple):
    nothing: PLAIN


def smeared(t: float, s: Swing, u: Unnamed, p: Rates) -> tuple[Swing, Nothing]:
    sine = np.sin(s.angle)
    return Swing(1.0, s.x * maximum(sine, -sine)), NOTHING


def errors(circuit, command, method, tolerances):
    """Steps taken and error of ln x over two turns from 0.3 rad on, for each tolerance."""
    start, found = 0.3, []
    for tolerance in tolerances:
        run = run_of(
            circuit, command, Rates(up=1.0, down=1.0), 4.0 * np.pi, Swing(start, 1.0),
            relative_tolerance=tolerance, method=method, sample_period=4.0 * np.pi,
        )  # fmt: skip
        found.append((run.steps, abs(np.log(run.final[1]) - 8.0)))
    return np.array(found)


@pytest.mark.parametrize(("method", "order"), [(Method.EXPLICIT, 5.0), (Method.STIFF, 4.0)])
def test_the_order_is_kept_across_kinks(method, order):
    steps, error = np.log(errors(humps, KinkHeld(Half(0.0)), method, 10.0 ** -np.arange(4.0, 10.0))).T
    slope = np.polyfit(steps, error, 1)[0]
    assert slope < -(order - 0.7)


def test_without_a_name_a_kink_costs_accuracy():
    tolerances = (1e-5, 1e-7)
    named = errors(humps, KinkHeld(Half(0.0)), Method.EXPLICIT, tolerances)[:, 1]
    unnamed = errors(smeared, Unnamed(0.0), Method.EXPLICIT, tolerances)[:, 1]
    assert (unnamed > 10.0 * named).all()


def restless(t: float, s: Level, u: Held, p: Rates) -> tuple[Level, Nothing, Turning]:
    """From 1 on each mode leads to the other."""
    near = side(s.x - 1.0)
    return Level(1.0), NOTHING, Turning(select(u.modes.direction > 0.5, 0.5, near))


def test_modes_that_lead_to_each_other_are_named():
    with pytest.raises(RunError, match=re.escape("t = 1 s: the mode 'direction' " + wording.simulation.chattering)):
        run_of(restless, Held(Turning(0.0)), Rates(up=1.0, down=1.0), 2.0)


def sliding(t: float, s: Level, u: Held, p: Rates) -> tuple[Level, Nothing, Turning]:
    """Towards 1 from either side: behind it at once back before it."""
    return Level(select(u.modes.direction > 0.5, -1.0, 1.0)), NOTHING, Turning(side(s.x - 1.0))


def test_modes_that_change_within_no_time_are_named():
    with pytest.raises(RunError, match="chattering"):
        run_of(sliding, Held(Turning(0.0)), Rates(up=1.0, down=1.0), 2.0)


def resting(t: float, s: Swing, u: KinkHeld, p: Rates) -> tuple[Swing, Nothing, Half]:
    """Comes to rest on the boundary itself."""
    return Swing(1.0, 2.0 * (1.0 - s.x)), NOTHING, Half(side(minimum(s.x, 2.0) - 1.0))


def test_what_rests_on_a_boundary_takes_no_steps_for_it():
    run = run_of(resting, KinkHeld(Half(0.0)), Rates(up=1.0, down=1.0), 100.0, Swing(0.0, 0.0), sample_period=100.0)
    assert run.final[1] == pytest.approx(1.0, abs=1e-5)
    assert run.evaluations < 4000
