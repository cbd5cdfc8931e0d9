"""Preparation of a sparse Jacobian: groups of columns to difference together, and the steps of its elimination."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int64]


class Pattern(NamedTuple):
    """Where the Jacobian of n rates over the first m of them has entries, and how I/h - J is eliminated.

    Entry e is at `rows[e]`, `columns[e]`; those of group g are `first[g]` up to `first[g + 1]`, and no two of a group
    share a row. `places[e]` is where it stands among the numbers of the factors, -1 for a row below the square part.
    `pairs` are entries (i, j) and (j, i). `diagonal[c]` is the place of a pivot, pivots go by `order`.
    `steps` are (target, factor, row): row < 0: number[target] /= number[factor], a multiplier; else
    number[target] -= number[factor] number[row]. `lower` (row, column, place) in the order of their use, `upper`
    likewise, those of pivot q of `order` from `upper_first[q]` on.
    """

    group: Ints  # (m,)
    first: Ints  # (groups + 1,)
    rows: Ints  # (entries,)
    columns: Ints
    places: Ints
    pairs: Ints  # (pairs, 2)
    order: Ints  # (m,)
    diagonal: Ints  # (m,)
    steps: Ints  # (steps, 3)
    lower: Ints  # (entries, 3)
    upper: Ints
    upper_first: Ints  # (m + 1,)


def pattern(depends: npt.NDArray[np.bool_]) -> Pattern:
    """The pattern of a Jacobian.

    depends  shape (n, m), m at most n: whether rate i depends on state j
    """
    m = depends.shape[1]
    group = column_groups(depends)
    entries = sorted(zip(*np.nonzero(depends), strict=True), key=lambda e: (group[e[1]], e[1], e[0]))
    rows, columns = (np.array([e[k] for e in entries], np.int64) for k in (0, 1))
    counts = np.bincount(group[columns], minlength=int(group.max(initial=-1)) + 1)
    filled, order = elimination_order(depends[:m] | depends[:m].T)
    at = {pair: number for number, pair in enumerate(sorted(filled))}
    known = {pair: number for number, pair in enumerate(entries)}
    steps, lower, upper, upper_first = _program(order, at)
    return Pattern(
        group=group,
        first=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        rows=rows,
        columns=columns,
        places=np.array([at.get(pair, -1) for pair in entries], np.int64),
        pairs=_table([(e, known[j, i]) for (i, j), e in known.items() if i <= j and (j, i) in known], 2),
        order=np.array(order, np.int64),
        diagonal=np.array([at[c, c] for c in range(m)], np.int64),
        steps=_table(steps, 3),
        lower=_table(lower, 3),
        upper=_table(upper, 3),
        upper_first=np.array(upper_first, np.int64),
    )


def column_groups(depends: npt.NDArray[np.bool_]) -> Ints:
    """A group for each column, shape (m,): no two of a group have an entry in the same row (Curtis et al. 1974)."""
    taken: list[npt.NDArray[np.bool_]] = []
    group = np.zeros(depends.shape[1], np.int64)
    for column in np.argsort(-depends.sum(axis=0), kind="stable"):
        mine = depends[:, column]
        number = next((g for g, rows in enumerate(taken) if not (rows & mine).any()), len(taken))
        if number == len(taken):
            taken.append(np.zeros(depends.shape[0], bool))
        taken[number] |= mine
        group[column] = number
    return group


def elimination_order(linked: npt.NDArray[np.bool_]) -> tuple[set[tuple[int, int]], list[int]]:
    """Entries of the factors, filled ones included, and pivots by the fewest neighbours left (Tinney and Walker 1967).

    linked  shape (m, m), symmetric: the graph of the matrix
    """
    neighbours = [set(map(int, np.flatnonzero(row))) - {number} for number, row in enumerate(linked)]
    filled = {(c, c) for c in range(len(neighbours))}
    order: list[int] = []
    left = set(range(len(neighbours)))
    while left:
        pivot = min(left, key=lambda c: (len(neighbours[c]), c))
        left.remove(pivot)
        order.append(pivot)
        for other in neighbours[pivot]:
            filled |= {(pivot, other), (other, pivot)}
            neighbours[other] |= neighbours[pivot] - {other}
            neighbours[other].discard(pivot)
    return filled, order


def _program(order: list[int], at: dict[tuple[int, int], int]) -> tuple[list, list, list, list[int]]:  # type: ignore[type-arg]
    rank = {c: number for number, c in enumerate(order)}
    later: dict[int, list[int]] = {c: [] for c in order}
    for i, j in at:
        if rank[i] > rank[j]:
            later[j].append(i)
    steps: list[tuple[int, int, int]] = []
    lower: list[tuple[int, int, int]] = []
    upper: list[tuple[int, int, int]] = []
    upper_first = [0]
    for pivot in order:
        below = sorted(later[pivot], key=rank.__getitem__)
        for i in below:
            steps.append((at[i, pivot], at[pivot, pivot], -1))
            steps += [(at[i, j], at[i, pivot], at[pivot, j]) for j in below]
            lower.append((i, pivot, at[i, pivot]))
        upper += [(pivot, j, at[pivot, j]) for j in below]
        upper_first.append(len(upper))
    return steps, lower, upper, upper_first


def _table(rows: list[tuple[int, ...]], columns: int) -> Ints:
    return np.array(rows, np.int64).reshape(-1, columns)
