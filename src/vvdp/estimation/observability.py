"""Whether the position of a spool can be distinguished from a noise that repeats itself with every turn, and how well.

The plant is M x'' + b x' + K x = known force; its position is measured with a noise of k harmonics of the spool speed.
What the Grammian over one turn leaves of the plant once the noise may be anything is its observability. Derived in
docs/models/observability.md.

Source  ours, docs/models/observability.md, where a function names no other.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import SPEED, Mass, Stiffness, Time, ViscousFriction
from vvdp.base.rules import require_positive_value

WARN_BELOW = 0.01
"""Margin below which an observer is uncertain."""
FREEZE_BELOW = 1e-3
"""Margin below which the estimate of the noise should stay unchanged."""
MOST_HARMONICS = 200
CLOSEST = 1e-8
"""Relative distance from a unobservable speed at which rounding hides the margin, which goes with its square."""
NODES, TERMS = 10, 25
"""Of the quadrature of a piece in which the fastest motion turns by a radian, and of the exponential there: exact to
rounding."""


class Plant(NamedTuple):
    """Moving parts: mass [kg], stiffness [N/m], 0 for an integrator, and damping [N s/m]; the source has none."""

    mass: Mass
    stiffness: Stiffness
    damping: ViscousFriction = 0.0


class Grammian(NamedTuple):
    """The Grammian over one turn, [[plant, coupling], [coupling', T/2]]: of the plant's states, shape (n, n), and of
    these with the cosine and sine of each harmonic, shape (n, 2 k). `period` is T.
    """

    plant: Array
    coupling: Array
    period: Time


def natural_frequency(plant: Plant) -> float:
    """Angular frequency of the plant without its damping [rad/s]: sqrt(K/M).

    Source  wang2017, appendix A
    """
    return float(np.sqrt(plant.stiffness / plant.mass))


def check_noise(spool_speed: float, harmonics: float) -> None:
    """Raises ParameterError where a noise has no turn to repeat itself in, or no whole number of harmonics.

    spool_speed  [rad/s]
    """
    require_positive_value("spool speed", spool_speed, SPEED)
    if not (1 <= harmonics <= MOST_HARMONICS and float(harmonics).is_integer()):
        raise ParameterError(f"harmonics: {harmonics:g}; expected a whole number, 1 to {MOST_HARMONICS}")


def unobservable_speeds(natural_frequency: float, harmonics: int) -> Array:
    """Spool speeds at which position and velocity are lost, fastest first [rad/s]; none where nothing draws back.

    natural_frequency  [rad/s]
    """
    return natural_frequency / np.arange(1, harmonics + 1) if natural_frequency > 0.0 else np.zeros(0)


def is_observable(natural_frequency: float, spool_speed: float, harmonics: int) -> bool:
    """Whether 2/T is no eigenvalue of the pencil (Psi, L L'): no harmonic has the plant's own frequency.

    natural_frequency  [rad/s]
    spool_speed        [rad/s]

    Source  wang2017, theorem 5.5.1
    """
    distance = np.abs(unobservable_speeds(natural_frequency, harmonics) - spool_speed)
    return bool(np.all(distance > CLOSEST * spool_speed))


def observability_margin(natural_frequency: float, spool_speed: float, harmonics: int) -> float:
    """Smallest eigenvalue of (2/T)(Psi - (2/T) L L'), velocity divided by the natural frequency [1].

    1 is as good as without a noise over many swings, 0 is lost; 0 as well where the spool does not turn. Without a
    natural frequency the velocity is divided by the spool speed. Plain arithmetic, for compiled steps.

    natural_frequency  of a plant without damping [rad/s]
    spool_speed        in either direction [rad/s]
    """
    if spool_speed == 0.0:
        return 0.0
    r = natural_frequency / abs(spool_speed)
    if r == 0.0:
        return _margin_of_integrator(harmonics)
    even, odd = 1.0 + np.sinc(2.0 * r), 1.0 - np.sinc(2.0 * r)
    for g in range(1, harmonics + 1):
        share = 2.0 * np.sinc(r - g) / (r + g)
        even -= (r * share) ** 2
        odd -= (g * share) ** 2
    return float(max(min(even, odd), 0.0))


def _margin_of_integrator(harmonics: int) -> float:
    """The margin of a mass without a spring [1]: of [[2, 2 pi], [2 pi, 2 pi^2 + c]], state at the turn's beginning."""
    c = 2.0 * np.pi**2 / 3.0
    for g in range(1, harmonics + 1):
        c -= 4.0 / g**2
    half = 1.0 + np.pi**2 + 0.5 * c
    return float(2.0 * c / (half + np.sqrt(half * half - 2.0 * c)))


def analytic_grammian(natural_frequency: float, spool_speed: float, harmonics: int) -> Grammian:
    """The Grammian of position [m] and velocity [m/s] of a plant without damping, in closed form.

    natural_frequency  gamma > 0 [rad/s]
    spool_speed        omega > 0 [rad/s]

    Source  wang2017, eqs. 5.47 and A.9 to A.12, with a corrected Psi_22 and the limits at gamma = g omega
    """
    gamma, omega, T = natural_frequency, spool_speed, 2.0 * np.pi / spool_speed
    swing = np.sin(2.0 * gamma * T) / (4.0 * gamma)
    cross = np.sin(gamma * T) ** 2 / (2.0 * gamma**2)
    plant = np.array([[0.5 * T + swing, cross], [cross, (0.5 * T - swing) / gamma**2]])
    coupling = np.zeros((2, 2 * harmonics))
    for g in range(1, harmonics + 1):
        between, above = 0.5 * (gamma - g * omega) * T, gamma + g * omega
        sine = T * np.cos(between) * np.sinc(between / np.pi) / above
        square = T * np.sin(between) * np.sinc(between / np.pi) / above
        coupling[:, 2 * g - 2] = gamma * sine, square
        coupling[:, 2 * g - 1] = -g * omega * square, g * omega * sine / gamma
    return Grammian(plant, coupling, T)


def scaled_dynamics(plant: Plant, spool_speed: float, oil_stiffnesses: Sequence[float] = ()) -> Array:
    """Rates of a plant's states, all in metres, by these states [1/s]: x, v/gamma, and each chamber's A P/K.

    Without a stiffness the spool speed stands for gamma, and M gamma^2 for K.

    spool_speed      [rad/s]
    oil_stiffnesses  A^2 beta/V of each chamber whose pressure is measured [N/m]
    """
    gamma = natural_frequency(plant) or spool_speed
    M, K, b = plant.mass, plant.stiffness, plant.damping
    size = 2 + len(oil_stiffnesses)
    rates = np.zeros((size, size))
    rates[0, 1] = gamma
    rates[1, 0], rates[1, 1], rates[1, 2:] = -K / (M * gamma), -b / M, gamma
    rates[2:, 1] = [-stiffness / (M * gamma) for stiffness in oil_stiffnesses]
    return rates


def numeric_grammian(rates: Array, spool_speed: float, harmonics: int) -> Grammian:
    """The Grammian of any linear plant by quadrature: its first state is measured with the noise, those from the third
    on (pressures) without.

    rates        of the states by the states, shape (n, n) [1/s]
    spool_speed  [rad/s]
    """
    T = 2.0 * np.pi / spool_speed
    fastest = max(harmonics * spool_speed, float(np.max(np.abs(np.linalg.eigvals(rates)))))
    pieces = 1 + int(fastest * T)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    within, width = (0.5 * T / pieces) * (nodes + 1.0), T / pieces
    passages = _transitions(rates, np.array([*within, width]))
    begun = [np.eye(len(rates))]
    for _ in range(pieces - 1):
        begun.append(passages[-1] @ begun[-1])
    states = (passages[:-1] @ np.array(begun)[:, None]).reshape(-1, *rates.shape)
    times = (np.arange(pieces)[:, None] * width + within).ravel()
    weights = np.tile(0.5 * width * weights, pieces)
    seen = states[:, [0, *range(2, len(rates))]]
    angles = np.outer(np.arange(1, harmonics + 1), spool_speed * times)
    basis = np.stack([np.cos(angles), np.sin(angles)], axis=1).reshape(2 * harmonics, -1)
    plant = np.einsum("t,tmi,tmj->ij", weights, seen, seen)
    return Grammian(plant, np.einsum("t,ti,bt->ib", weights, seen[:, 0], basis), T)


def _transitions(rates: Array, times: Array) -> Array:
    """exp(A t) of short times, within which nothing turns by more than a radian, shape (times, n, n)."""
    term = np.broadcast_to(np.eye(len(rates)), (len(times), *rates.shape))
    found = term
    for order in range(1, TERMS):
        term = term @ rates * (times[:, None, None] / order)
        found = found + term
    return found


def without_noise(grammian: Grammian) -> Array:
    """Grammian of the plant with the noise projected out, over half a period: (2/T)(Psi - (2/T) L L') [1]."""
    L, T = grammian.coupling, grammian.period
    return (2.0 / T) * (grammian.plant - (2.0 / T) * L @ L.T)


def smallest_eigenvalue(grammian: Grammian) -> float:
    """The margin of a Grammian of states in one unit [1]."""
    return float(np.linalg.eigvalsh(without_noise(grammian))[0])


def rank(grammian: Grammian) -> int:
    """Rank of the whole Grammian of states in one unit: less than all states and coefficients where some are lost."""
    L, half = grammian.coupling, 0.5 * grammian.period
    whole = np.block([[grammian.plant, L], [L.T, half * np.eye(L.shape[1])]])
    return int(np.linalg.matrix_rank(whole, hermitian=True, rtol=1e-12))


def margin_with_pressure(
    plant: Plant, spool_speed: float, harmonics: int, oil_stiffnesses: Sequence[float] = ()
) -> float:
    """The margin of any plant, its damping included, where the pressures of its chambers are measured as well [1].

    A pressure counts as the displacement A P/K that it holds against the spring, and is measured as well as the
    position then. The flows into the chambers are known.

    spool_speed      [rad/s]
    oil_stiffnesses  A^2 beta/V of each chamber [N/m]
    """
    rates = scaled_dynamics(plant, spool_speed, oil_stiffnesses)
    return smallest_eigenvalue(numeric_grammian(rates, spool_speed, harmonics))
