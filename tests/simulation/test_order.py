"""Both methods converge with their order, at fixed steps, against closed forms.

Steps are fixed by a tolerance that does not bite and by samples at every step, since a step ends on each sample.
"""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from vvdp.base.conservation import Nothing
from vvdp.base.kinds import Kind
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Method, Stepping, simulate

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]


class Point(NamedTuple):
    x: Plain
    y: Plain


def growth(t: float, s: Point, u: Nothing, p: Nothing) -> tuple[Point, Nothing]:
    """Nonlinear, does not depend on time."""
    return Point(s.x * (1.0 - s.x * s.x), -s.x * s.x * s.y), Nothing(0.0)


def growth_exact(t):
    # with x^2 = z: z' = 2 z (1 - z), z = e^2t/(e^2t + 15) from 1/16; (ln y)' = -z, y = 4/sqrt(e^2t + 15) from 1
    e = np.exp(2.0 * t)
    return np.array([np.sqrt(e / (e + 15.0)), 4.0 / np.sqrt(e + 15.0)])


def turning(t: float, s: Point, u: Nothing, p: Nothing) -> tuple[Point, Nothing]:
    """Nonlinear and dependent on time: on the unit circle, at the angle t + sin(2 t)/4."""
    rate = (s.x * s.x + s.y * s.y) * (1.0 + 0.5 * np.cos(2.0 * t))
    return Point(-s.y * rate, s.x * rate), Nothing(0.0)


def turning_exact(t):
    angle = t + 0.25 * np.sin(2.0 * t)
    return np.array([np.cos(angle), np.sin(angle)])


END = 4.0


def mean_error(circuit, exact, start, method, steps):
    """Root mean square of the error at eight ends of steps, so that no crossing of zero error is taken for accuracy."""
    stepping = Stepping(
        until=END,
        relative_tolerance=1e-2,
        sample_period=END / steps,
        record_interval=END / 8,
        window=END,
        window_interval=END / 8,
        method=method,
    )
    run = simulate(Model(circuit), Case(start, Nothing()), stepping)
    assert steps <= run.steps <= steps + 8  # only the first sample is reached in several, growing steps
    assert run.rejected == 0
    return np.sqrt(np.mean((run.states - exact(run.times).T) ** 2))


@pytest.mark.parametrize(
    ("circuit", "exact", "start"),
    [(growth, growth_exact, Point(0.25, 1.0)), (turning, turning_exact, Point(1.0, 0.0))],
    ids=["autonomous", "dependent on time"],
)
@pytest.mark.parametrize(("method", "order"), [(Method.EXPLICIT, 5), (Method.STIFF, 4)])
def test_error_falls_with_the_order(circuit, exact, start, method, order):
    """The slope of log error over log step, least squares over 32 to 256 steps.

    error = C h^p (1 + C' h): with C' h up to 1/4 at the largest step and falling in proportion, the fitted slope is off
    by at most log2((1 + 1/4)/(1 + 1/32))/3 = 0.09; the fine first sample takes 1/32 off the first error and up to 0.02
    off the slope. A quarter is safe, and a lost order is a whole one away.
    """
    steps = np.array([32, 64, 128, 256])
    errors = [mean_error(circuit, exact, start, method, int(n)) for n in steps]
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.25)
