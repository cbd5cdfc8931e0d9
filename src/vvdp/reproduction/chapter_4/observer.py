"""Sections 4.2 to 4.4: the signal generator, reference, gains, stability and observability of the augmented systems."""

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, NUMBER, POSITION, RATIO
from vvdp.estimation.noise_basis import fourier_basis
from vvdp.estimation.signal_generator import samples_in_period, signal_generator
from vvdp.reproduction.chapter_4.noise import rows_of
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.results.verdict import bound_statement, number_statement

TURN = 2.0 * np.pi
INCH = 25.4e-3
ROUNDING = "rounding"
SAMPLES = 1000
"""In a turn of 0.1 s."""


def equation_4_3() -> Reproduction:
    """How many states the signal generator has."""
    sizes = [signal_generator(samples_in_period(period, 2e-3))[0].shape[0] for period in (0.1, 0.04)]
    return Reproduction(
        statements=(
            number_statement(
                "states of the noise, 10 Hz and 2 ms",
                50,
                sizes[0],
                COUNT,
                inconsistency="50 with the position: one sample of a period follows from its mean of zero",
                contradiction=("4.2.2: 50 states", "(4.3): N − 1 states"),
            ),
            number_statement("states with the position, 25 Hz and 2 ms (4.5.1)", 20, sizes[1] + 1, COUNT),
        )
    )


def equation_4_6() -> Reproduction:
    """The determinant of the observability matrix, and its last row."""
    N = 20
    A, C = np.eye(N), np.ones(N)
    A[1:, 1:], C[1:] = signal_generator(N)
    rows = [C @ np.linalg.matrix_power(A, k) for k in range(N)]
    printed = [*rows[:-1], C @ np.linalg.matrix_power(A, N)]
    return Reproduction(
        statements=(
            number_statement(
                "determinant for N = 20",
                (-1) ** (N + 1) * N,
                float(np.linalg.det(rows)),
                NUMBER,
                tolerance=1e-9,
                because=ROUNDING,
            ),
            number_statement(
                "determinant with C A^N as the last row, as printed",
                (-1) ** (N + 1) * N,
                float(np.linalg.det(printed)),
                NUMBER,
                tolerance=1e-9,
                because=ROUNDING,
                inconsistency="C A^N is C again; the row displayed is that of C A^(N−1)",
                contradiction=("(4.6): C A^N as the last row", "(4.6): the rows as displayed, and their determinant"),
            ),
        )
    )


def printed_trapezoid(t: float) -> float:
    """r(t) of eq. 4.16 as printed [m]: its branches take mod(t, 5), its ramps mod(t, 1)."""
    phase, ramp = t % 5.0, t % 1.0
    if phase < 1.0:
        return 0.8 * INCH
    if phase <= 2.0:
        return (0.8 + 0.8 * (ramp - 1.0)) * INCH
    if phase < 4.0:
        return 1.6 * INCH
    return (1.6 - 0.8 * (ramp - 4.0)) * INCH


def printed_jump(t: float) -> float:
    """By how much r(t) as printed changes at `t` [m]."""
    return printed_trapezoid(t) - printed_trapezoid(t - 1e-9)


def equation_4_16() -> Reproduction:
    """A trapezoid goes on where its last branch ended."""
    return Reproduction(
        statements=tuple(
            bound_statement(
                f"jump of the reference at {begin:.0f} s, as printed",
                abs(printed_jump(begin)),
                POSITION,
                high=1e-6,
                source="a trapezoid",
                inconsistency="in (4.16) the branches take mod(t, 5), their ramps mod(t, 1)",
                contradiction=("(4.16): ramps over mod(t, 1)", "(4.16): branches by mod(t, 5)"),
            )
            for begin in (1.0, 4.0)
        )
    )


def settled_coefficients(drift: float, samples: int) -> tuple[float, float]:
    """Variance and gain of the coefficients after so many samples of the filter: two functions, R = 1."""
    P = np.eye(3)
    K: Array = np.zeros(3)
    rows = np.column_stack([np.ones(100), rows_of(fourier_basis(1), TURN * np.arange(100.0) / 100.0)])
    for k in range(samples):
        C = rows[k % 100]
        P = P + np.diag([0.01, drift, drift])
        K = P @ C / (C @ P @ C + 1.0)
        left = np.eye(3) - np.outer(K, C)
        P = left @ P @ left.T + np.outer(K, K)
    return float(P[1, 1]), float(np.abs(K[1:]).sum())


def equation_4_13() -> Reproduction:
    """Without noise on the coefficients their gains die."""
    early, later = settled_coefficients(0.0, 2000), settled_coefficients(0.0, 20_000)
    kept = settled_coefficients(1e-4, 2000)[0] / settled_coefficients(1e-4, 20_000)[0]
    return Reproduction(
        statements=(
            bound_statement(
                "gain after ten times as long, no noise on the coefficients",
                later[1] / early[1],
                RATIO,
                low=0.9,
                source="Q₁ without a condition",
                because="a gain that stays (ours)",
                inconsistency="all of its entries have to be above 0: the model's eigenvalues lie on the unit circle",
            ),
            number_statement(
                "variance after ten times as long, with noise",
                1.0,
                1.0 / kept,
                RATIO,
                tolerance=1e-3,
                because="a thousandth (ours): settled",
            ),
        )
    )


def equation_4_18() -> Reproduction:
    """The matrix of the tracking errors is Hurwitz, and never negative definite."""
    Ki, Kp = 90.0, 30.0
    A = np.array([[0.0, 1.0], [-Ki, -Kp]])
    return Reproduction(
        statements=(
            bound_statement(
                "largest eigenvalue of the symmetric part, 1/s",
                float(np.linalg.eigvalsh(0.5 * (A + A.T)).max()),
                NUMBER,
                high=0.0,
                source="A_dyn is negative definite",
                inconsistency="its first entry is 0, so it cannot be for any gains; it is Hurwitz",
                contradiction=("4.4: A_dyn is negative definite", "(4.18): A_dyn, whose first entry is 0"),
            ),
            bound_statement(
                "largest real part of its eigenvalues, 1/s",
                float(np.linalg.eigvals(A).real.max()),
                NUMBER,
                high=0.0,
                source="the errors fade",
            ),
        )
    )


def equation_4_19() -> Reproduction:
    """The integral of the position as a state of the estimator."""
    harmonics = 2
    size = 2 * harmonics + 2
    times = 0.1 * np.arange(SAMPLES) / SAMPLES
    C = np.column_stack([np.zeros(SAMPLES), np.ones(SAMPLES), rows_of(fourier_basis(harmonics), TURN * times / 0.1)])
    transition = np.tile(np.eye(size), (SAMPLES, 1, 1))
    transition[:, 0, 1] = times
    seen = np.einsum("ki,kij->kj", C, transition)
    return Reproduction(
        statements=(
            number_statement(
                "rank of the Grammian, two harmonics",
                size,
                int(np.linalg.matrix_rank(seen.T @ seen)),
                COUNT,
                source="observable: 6",
                inconsistency="no output shows the integral; the controller integrates r − x̂, a known signal",
            ),
        )
    )


def equation_4_20() -> Reproduction:
    """The rank of the matrix that (4.22) wants positive."""
    rng = np.random.default_rng(3)
    n = 11
    P = rng.normal(size=(n, n))
    P = P @ P.T + np.eye(n)
    told, seen = (
        np.linalg.solve(P, np.eye(n)[0]),
        np.concatenate([[1.0], rows_of(fourier_basis(5), np.array([0.3]))[0]]),
    )
    both = np.outer(told, told) / (told @ told) + np.outer(seen, seen) / (seen @ seen)
    return Reproduction(
        statements=(
            number_statement(
                "rank of Γ with noise through the input alone",
                n,
                int(np.linalg.matrix_rank(both)),
                COUNT,
                source="positive definite: 11",
                inconsistency="B Q Bᵀ has rank 1 and CᵀR⁻¹C another; noise on all states is needed",
            ),
        )
    )


ITEMS = (
    Item(ItemKind.EQUATION, "4.3", "Signal generator", equation_4_3),
    Item(ItemKind.EQUATION, "4.6", "Observability matrix", equation_4_6),
    Item(ItemKind.EQUATION, "4.13", "Gains of the generator's filter", equation_4_13),
    Item(ItemKind.EQUATION, "4.16", "The trapezoid", equation_4_16),
    Item(ItemKind.EQUATION, "4.18", "Dynamics of the tracking errors", equation_4_18),
    Item(ItemKind.EQUATION, "4.19", "The augmented system with its integral", equation_4_19),
    Item(ItemKind.EQUATION, "4.20", "Noise through the input", equation_4_20),
)
