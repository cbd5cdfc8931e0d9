"""Sections 3.3 and 3.4: the model of the measurement and the equations of the filter."""

import numpy as np
from scipy.integrate import quad

from vvdp.base.kinds import ANGLE_ERROR, ANGULAR_VARIANCE, COUNT, NUMBER, TIME
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.reproduction.chapter_3.published_filter import DENSITY, NOISE, SAMPLE, SECTOR, START_VARIANCE, TURNS
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.verdict import Statement, bound_statement, digit_statement, drawing_statement, number_statement
from vvdp.sensing.wheel import TURN

SPEED = TURN * TURNS
BELIEF = AngleSpeed(0.3, 150.0, 2e-3, 3e-3, 0.4)
LAG = 5e-3
TOLERANCE = 1e-9
ROUNDING = "rounding"
UPDATED = update(BELIEF, 0.05, NOISE)


def covariance(belief: AngleSpeed) -> np.ndarray:
    """The covariance of a belief as a matrix."""
    return np.array([[belief.angle_variance, belief.covariance], [belief.covariance, belief.speed_variance]])


P, H = covariance(BELIEF), np.array([[1.0], [0.0]])
F, Q = np.array([[0.0, 1.0], [0.0, 0.0]]), np.diag([0.0, DENSITY])
TRANSITION = np.eye(2) + LAG * F
"""Exact, since F F = 0."""


def figure_3_6() -> Reproduction:
    """Names of the instants: a drawing."""
    drawing = drawing_statement("names of the instants", "the same instants in docs/models/event-filter.md")
    return Reproduction(statements=(drawing,))


def figure_3_8() -> Reproduction:
    """The order of prediction and update: a drawing."""
    drawing = drawing_statement("time line of the filter", "the same steps in docs/models/event-filter.md")
    return Reproduction(statements=(drawing,))


def _one(*statements: Statement) -> Reproduction:
    return Reproduction(statements=statements)


def _residual(what: str, found: float, source: str) -> Statement:
    """A statement that holds where what two ways give differs by rounding alone."""
    equal = "equal to rounding" if abs(found) <= TOLERANCE else ""
    return bound_statement(what, abs(found), high=TOLERANCE, because=ROUNDING, source=source, result=equal)


def equation_3_1() -> Reproduction:
    """A shaft of constant speed: what `predict` does to the mean."""
    ahead = predict(BELIEF, LAG, 0.0)
    exact = TRANSITION @ np.array([BELIEF.angle, BELIEF.speed])
    off = float(np.max(np.abs(exact - (ahead.angle, ahead.speed))))
    return _one(_residual("mean after 5 ms, less that of the double integrator", off, "a double integrator"))


def equation_3_2() -> Reproduction:
    """An edge is detected where the count has grown: with the wheel at 40 Hz by one at most."""
    counts = np.floor(np.arange(0.0, 1.0, SAMPLE) * 8.0 * 40.0 + 0.3)
    return _one(
        bound_statement(
            "largest growth of the count within 1 ms at 40 Hz",
            float(np.max(np.diff(counts))),
            COUNT,
            high=1.0,
            source="one edge between two samples at most",
            note="vvdp counts all edges, and a counter that overflows",
        )
    )


def equation_3_3() -> Reproduction:
    """The measured angle is that of the edge at the middle of the interval: the noise this brings is a speed times a
    time."""
    delay = np.linspace(-0.5, 0.5, 11) * SAMPLE
    noise = SECTOR - (SECTOR - SPEED * delay)
    off = float(np.max(np.abs(noise - SPEED * delay)))
    return _one(_residual("noise less speed times delay", off, "n₁ is the turn within the delay"))


def equation_3_4() -> Reproduction:
    """The variances of an even and of a triangular error."""
    even = 2.0 * quad(lambda x: 0.5 * x * x, 0.0, 1.0)[0]
    triangle = 2.0 * quad(lambda x: x * x * (1.0 - x), 0.0, 1.0)[0]
    return _one(
        number_statement(
            "variance of n₁ over its bound squared", 1.0 / 3.0, even, tolerance=TOLERANCE, because=ROUNDING
        ),
        number_statement(
            "variance of n₂ over its bound squared",
            0.25,
            triangle,
            tolerance=TOLERANCE,
            because=ROUNDING,
            inconsistency="a symmetric triangle has 1/6; it is no normal density either (docs/errata.md)",
            contradiction=("3.3: a triangular density on ±a", "(3.4): a variance of a²/4"),
        ),
    )


def equation_3_5() -> Reproduction:
    """The estimate runs on to the edge, not to the sample before it."""
    edge = 7.0 * SECTOR / SPEED
    start = AngleSpeed(0.0, SPEED, 0.0, 0.0, 0.0)
    behind = 7.0 * SECTOR - predict(start, edge - 0.5 * SAMPLE, 0.0).angle
    return _one(
        _residual("angle at the edge, predicted up to it", predict(start, edge, 0.0).angle - 7.0 * SECTOR, "ẋ = F x"),
        bound_statement(
            "error where it is predicted to t(k−1), as the range is printed",
            behind,
            ANGLE_ERROR,
            high=TOLERANCE,
            source="for t(k−m) < t < t(k−1)",
            inconsistency="the update is at τ, half a sample later (docs/errata.md)",
            contradiction=("(3.5): for t(k−m) < t < t(k−1)", "(3.3): the measurement is of τ(j), after t(k−1)"),
        ),
    )


def equation_3_6() -> Reproduction:
    """The covariance between two edges, against the integral of its own rate."""
    step, now = 1e-6, P.copy()
    for _ in range(round(LAG / step)):  # the midpoint rule, of second order
        middle = now + 0.5 * step * (now @ F.T + F @ now + Q)
        now = now + step * (middle @ F.T + F @ middle + Q)
    off = float(np.max(np.abs(now - covariance(predict(BELIEF, LAG, DENSITY)))))
    return _one(_residual("integrated covariance less that of `predict`", off, "Ṗ = P Fᵀ + F P + Q"))


def equation_3_7() -> Reproduction:
    """Its closed form; the initial value diag(p, p) holds before the first edge only."""
    h, q = LAG, DENSITY
    P22 = q * h + P[1, 1]
    P12 = 0.5 * q * h**2 + P[1, 1] * h + P[0, 1]
    P11 = q * h**3 / 3.0 + P[1, 1] * h**2 + 2.0 * P[0, 1] * h + P[0, 0]
    off = float(np.max(np.abs(np.array([[P11, P12], [P12, P22]]) - covariance(predict(BELIEF, h, q)))))
    return _one(
        _residual("closed form less that of `predict`", off, "the four entries"),
        bound_statement(
            "speed's deviation after 100 edges, with diag(p, p) at each",
            _forgetful_deviation(),
            high=1.0,
            source="P(t(k−m)) = diag(p, p)",
            inconsistency="only at t = 0: at every later edge it is what the last update left (docs/errata.md)",
        ),
    )


def _forgetful_deviation() -> float:
    """Standard deviation of the speed [rad/s] where the covariance begins again at each edge."""
    start = AngleSpeed(0.0, 50.0, START_VARIANCE, 0.0, START_VARIANCE)
    belief = start
    for number in range(1, 101):
        belief = predict(start._replace(angle=belief.angle, speed=belief.speed), SECTOR / SPEED, DENSITY)
        belief = update(belief, number * SECTOR - belief.angle, NOISE)
    return float(np.sqrt(belief.speed_variance))


def equation_3_8() -> Reproduction:
    """The gain: with that of the print the estimate runs away."""
    K = P @ H / (P[0, 0] + NOISE)
    right = np.array([UPDATED.angle - BELIEF.angle, UPDATED.speed - BELIEF.speed]) / 0.05
    return _one(
        _residual("K = P H/(Hᵀ P H + R), less that of `update`", float(np.max(np.abs(K[:, 0] - right))), "corrected"),
        bound_statement(
            "error of the angle after 1 s with K = P H",
            _printed_gain_error(),
            ANGLE_ERROR,
            high=SECTOR,
            source="K = P H",
            because="a sector",
            inconsistency="P H has not the unit of a gain (docs/errata.md)",
        ),
    )


def _printed_gain_error() -> float:
    """Error of the angle [rad] after a second of edges without noise, with the gain as printed."""
    belief = AngleSpeed(0.0, 50.0, START_VARIANCE, 0.0, START_VARIANCE)
    number = 0
    for number in range(1, round(1.0 * SPEED / SECTOR) + 1):
        belief = predict(belief, SECTOR / SPEED, DENSITY)
        innovation = number * SECTOR - belief.angle
        after = update(belief, innovation, NOISE)
        angle = belief.angle + belief.angle_variance * innovation
        belief = after._replace(angle=angle, speed=belief.speed + belief.covariance * innovation)
    return abs(belief.angle - number * SECTOR)


def equation_3_9() -> Reproduction:
    """The covariance after an update: the inverse of the sum of informations, whose second term is a matrix."""
    information = np.linalg.inv(np.linalg.inv(P) + H @ H.T / NOISE)
    off = float(np.max(np.abs(information - covariance(UPDATED))))
    return _one(
        _residual("(P⁻¹ + H R⁻¹ Hᵀ)⁻¹ less that of `update`", off, "corrected"),
        bound_statement(
            "rows of Hᵀ R⁻¹ H",
            float((H.T @ H / NOISE).shape[0]),
            COUNT,
            low=2.0,
            source="Hᵀ R⁻¹ H is added to P⁻¹",
            inconsistency="with the column H = (1 0)ᵀ that is a number; H R⁻¹ Hᵀ is meant (docs/errata.md)",
            contradiction=("(3.3): H = (1 0)ᵀ", "(3.9): P⁻¹ + Hᵀ R⁻¹ H"),
        ),
    )


def equation_3_10() -> Reproduction:
    """From the edge on to the sample at which it is reported: the same prediction, in two parts or in one."""
    whole = predict(UPDATED, LAG, DENSITY)
    parts = predict(predict(UPDATED, 0.5 * SAMPLE, DENSITY), LAG - 0.5 * SAMPLE, DENSITY)
    off = float(np.max(np.abs(np.subtract(whole, parts))))
    return _one(_residual("prediction at once, less that in two parts", off, "as (3.5) and (3.6)"))


def section_3_3() -> Reproduction:
    """The numbers of the model: time of a sector, bounds and variances of the noises."""
    bound = 0.5 * SPEED * SAMPLE
    slowest, fastest = 1.0 / (8.0 * 20.0), 1.0 / (8.0 * 40.0)
    sector = digit_statement(
        "time of a sector at 40 Hz",
        2.9e-3,
        fastest,
        TIME,
        tolerance=5e-5,
        inconsistency="1/(8 · 40 Hz) is 3.125 ms",
        contradiction=("3.3: 2.9 ms at 40 Hz", "3.2: 8 sectors"),
    )
    seen = bound_statement(
        "samples in that time at 1 kHz", fastest / SAMPLE, NUMBER, low=1.0, source="1 kHz sees every edge"
    )
    variance = number_statement(
        "variance of n₁ at 25 Hz and 1 ms",
        bound**2 / 3.0,
        (SPEED * SAMPLE) ** 2 / 12.0,
        ANGULAR_VARIANCE,
        share=TOLERANCE,
        because=ROUNDING,
        source="(0.5 ω ΔT)²/3",
    )
    light = bound_statement(
        "longest transition of the light from 20 to 40 Hz",
        5.0 / 8.0 * slowest,
        TIME,
        high=SAMPLE,
        inconsistency="5 mm of light on sectors of 8 mm take 5/8 of a sector's time: 2.0 to 3.9 ms",
        contradiction=("3.3: within 1 ms", "3.2: 5 mm of light on sectors of 8 mm"),
    )
    return _one(sector, seen, variance, light, _friction())


def _friction() -> Statement:
    return bound_statement(
        "exponent of the speed in the friction torque",
        1.0,
        NUMBER,
        low=2.0,
        high=2.0,
        source="friction goes with the square of the speed",
        inconsistency="it is linear in (2.9) and 2.5; friction power goes with the square (docs/errata.md)",
        contradiction=("3.3: the square of the speed", "(2.9): linear in the speed"),
    )


EQUATION = ItemKind.EQUATION
ITEMS = (
    Item(ItemKind.FIGURE, "3.6", "Event-based Kalman filter, time denotations", figure_3_6),
    Item(ItemKind.FIGURE, "3.8", "Event-based Kalman filter, time line", figure_3_8),
    Item(EQUATION, "3.1", "Angle and speed of the spool", equation_3_1),
    Item(EQUATION, "3.2", "Detection of an edge", equation_3_2),
    Item(EQUATION, "3.3", "Measurement at an edge", equation_3_3),
    Item(EQUATION, "3.4", "Variances of the noises", equation_3_4),
    Item(EQUATION, "3.5", "Estimate between edges", equation_3_5),
    Item(EQUATION, "3.6", "Covariance between edges", equation_3_6),
    Item(EQUATION, "3.7", "Covariance between edges, in closed form", equation_3_7),
    Item(EQUATION, "3.8", "Gain and estimate at an edge", equation_3_8),
    Item(EQUATION, "3.9", "Covariance after an edge", equation_3_9),
    Item(EQUATION, "3.10", "From the edge to the sample", equation_3_10),
    Item(ItemKind.SECTION, "3.3", "Numbers of the measurement's model", section_3_3),
)
