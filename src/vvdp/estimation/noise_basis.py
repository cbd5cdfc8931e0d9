"""Basis of the periodic sensor error of the axial sensor: functions of the spool angle, periodic with a revolution, of
mean zero.

A periodic sensor error that is periodic in time has a clock's phase for the angle. Derived in
docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

from math import erf

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Angle, Count
from vvdp.base.params import Params
from vvdp.base.rules import refuse, refuse_together

TURN = 2.0 * np.pi


class NoiseBasis(Params):
    """Cosine and sine of 1 to `harmonics` times the angle, and all but one of `bumps` Gaussian bells at equal distances
    over the turn.

    A bell has fallen to 1/e at `bump_width` from its centre. Its mean is taken off, for the mean of a turn belongs to
    the position. Then all bells together are nearly 0 everywhere, so that the last one is left out.
    """

    harmonics: Count
    bumps: Count = 0.0
    bump_width: Angle = 1.0

    def check(self) -> None:
        whole = self.harmonics % 1.0 == 0.0 and self.bumps % 1.0 == 0.0
        if not (whole and (self.harmonics >= 1.0 or self.bumps >= 2.0)) or self.bumps == 1.0:
            refuse_together(
                self,
                f"{self.harmonics:g} harmonics and {self.bumps:g} bumps must be whole numbers, at least 1 harmonic or "
                "2 bumps",
            )
        if not 0.0 < self.bump_width < 0.5 * TURN:
            refuse(self, "bump_width", "must lie between 0 and 180 deg, half a revolution")


def fourier_basis(harmonics: int) -> NoiseBasis:
    """Cosines and sines of the first `harmonics` multiples of the angle.

    Source  wang2017, eq. 4.8
    """
    return NoiseBasis(harmonics=float(harmonics))


def gaussian_basis(bumps: int, width: float) -> NoiseBasis:
    """`bumps` functions: bells of `width` [rad] and mean zero.

    Source  wang2017, eq. 4.9, completed: docs/errata.md
    """
    return NoiseBasis(harmonics=0.0, bumps=bumps + 1.0, bump_width=width)


def function_count(basis: NoiseBasis) -> int:
    """Number of functions of a basis."""
    return int(2.0 * basis.harmonics) + bell_count(basis)


def bell_count(basis: NoiseBasis) -> int:
    """Number of bells among the functions."""
    return max(int(basis.bumps) - 1, 0)


def bump_mean(width: float) -> float:
    """Mean of a bell over the turn: w/(2 sqrt(pi)) erf(pi/w) [1]; `width` [rad]."""
    mean: float = width / (2.0 * np.sqrt(np.pi)) * erf(np.pi / width)
    return mean


def write_basis(phase: float, basis: NoiseBasis, row: Array, first: int) -> None:
    """Write the values of the functions at `phase` [rad] into `row`, from place `first` on."""
    c1, s1 = np.cos(phase), np.sin(phase)
    c, s, place = c1, s1, first
    for _ in range(int(basis.harmonics)):
        row[place], row[place + 1] = c, s
        c, s = c * c1 - s * s1, s * c1 + c * s1
        place += 2
    if basis.bumps > 0.0:
        mean = bump_mean(basis.bump_width)
        for i in range(bell_count(basis)):
            z = from_centre(phase, i, basis)
            row[place + i] = np.exp(-z * z) - mean


def turned_variance(number: int, squares: Array, slip: float, basis: NoiseBasis) -> float:
    """Mean square change of coefficient `number` if the angle has a Gaussian error.

    The pair of harmonic k turns by k times as much: (a^2 + b^2)(1 - exp(-k^2 s/2)) for each of the two. Bells become
    others of that size: 2 c^2 (1 - exp(-s/(2 w^2))), c^2 their mean square.

    squares  of all coefficients, as far as they are known (n,)
    slip     variance s of the error of the angle [rad^2]
    """
    pairs = int(basis.harmonics)
    if number < 2 * pairs:
        k, first = number // 2 + 1, number - number % 2
        turned: float = (squares[first] + squares[first + 1]) * -np.expm1(-0.5 * k * k * slip)
        return turned
    whole = 0.0
    for i in range(2 * pairs, squares.size):
        whole += squares[i]
    changed: float = -2.0 * whole / (squares.size - 2 * pairs) * np.expm1(-0.5 * slip / basis.bump_width**2.0)
    return changed


def from_centre(phase: float, number: int, basis: NoiseBasis) -> float:
    """Distance of `phase` [rad] to the nearest centre of bell `number`, counted in widths [1]."""
    turns = phase / TURN - number / basis.bumps
    distance: float = TURN * (turns - np.floor(turns + 0.5)) / basis.bump_width
    return distance


def basis_slope(phase: float, basis: NoiseBasis, mean: Array, row: Array, first: int) -> float:
    """Slope of the periodic sensor error over the phase [m/rad].

    mean, row  coefficients and values of the functions, both from place `first` on
    """
    slope, place = 0.0, first
    for h in range(1, int(basis.harmonics) + 1):
        slope += h * (mean[place + 1] * row[place] - mean[place] * row[place + 1])
        place += 2
    if basis.bumps > 0.0:
        offset = bump_mean(basis.bump_width)
        for i in range(bell_count(basis)):
            z = from_centre(phase, i, basis)
            slope -= 2.0 * z / basis.bump_width * (row[place + i] + offset) * mean[place + i]
    return slope
