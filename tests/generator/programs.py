# ruff: noqa: B007, TID251
"""Functions that show each construct of the language, with arguments to run them at."""

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.generator.kinds import stand_in

INF, NAN = math.inf, math.nan
TABLE = np.array([1.5, -2.0, 4.0])
WEIGHTS = (0.25, 0.5, 8.0)
GRID = np.array([[1, 2], [3, 4]])


class Side(enum.IntEnum):
    LEFT = 0
    RIGHT = 1


class Point(NamedTuple):
    x: float
    y: float

    @property
    def length(self):
        return np.sqrt(self.x * self.x + self.y * self.y)

    def scaled_by(self, factor):
        return Point(self.x * factor, self.y * factor)


class Memory(NamedTuple):
    count: int
    at: Point
    is_on: bool


class Held(NamedTuple):
    row: np.ndarray
    level: float


@dataclass(frozen=True)
class Valve:
    area: float
    lap: float


def sums(x, y):
    return x + y - x * y / (x - 0.1) + (-y) - (+x)


def whole_sums(a, b):
    return a + b * 3 - (a - 7) * b, -a, +b


def floor_division(a, b):
    return a // b, a % b


def shifts(a, b):
    return a << 3, a >> b, a & b, a | b, a ^ b, ~a


def true_division(a, b):
    return a / b


def powers(x):
    return x**0, x**1, x**-1, 2**10


def comparisons(x, y):
    return x < y, x <= y, x > y, x >= y, x == y, x != y


def chain(x, low, high):
    return low < x <= high, low < x < high < 2.0


def truths(a, b):
    return a and b, a or b, not a, (a and not b) or b, a == b, a & b, a | b


def conversions(x, n, ok):
    return int(x), float(n), bool(n), int(ok), float(ok), x + n, n + ok, ok * x


def branches(x):
    y = 0.0
    if x > 2.0:
        y = 1.0
    elif x > 1.0:
        y = 2.0
        y = y * x
    else:
        y = -y
    return y if x < 5.0 else -1.0 if x > 6.0 else x


def branch_types(x, n):
    y = n if x > 0.0 else x
    return y * 1.0


def early_return(x, row):
    for value in row:
        if value > x:
            return value
        if value < 0.0:
            return -value
    return x


def for_loops(n, start, step):
    total = 0
    for i in range(start, n, step):
        total = total * 3 + i
        total = total % 1000003
    for i in range(3):
        total += i
    for i in range(n, -1, -1):
        total -= i
    return total


def loop_exits(row, stop):
    total, seen = 0.0, 0
    for i in range(row.size):
        if row[i] < 0.0:
            continue
        seen += 1
        if row[i] > stop:
            break
        total += row[i]
    else:
        total = -total
    return total, seen


def loop_over_tuple(x, y, z):
    found = 0.0
    for value in (x, y, z):
        if value < 0.0:
            continue
        if value > 10.0:
            break
        found = found + value
    else:
        found = found + 100.0
    return found


def while_loops(x, n):
    count = 0
    while x > 1.0 and count < n:
        x = x * 0.5
        count += 1
        if count == 7:
            break
    else:
        x = -x
    while True:
        count += 1
        if count % 3 == 0:
            break
    return x, count


def swapped(n):
    a, b = 1.0, 2.0
    for _ in range(n):
        a, b = b, a + b
    return a, b


def rotated(n):
    a, b, c = 1.0, 2.0, 3.0
    for _ in range(n):
        a, b, c = b, c, a
    return a, b, c


def nested_loops(n):
    total = 0
    for i in range(n):
        for j in range(i):
            if j > 3:
                break
            if (i + j) % 2:
                continue
            total += i * j
    return total


def whole_becomes_float(n):
    total = 0
    for i in range(n):
        total = total + 0.5
    return total + 0.0


def tuples(x, y):
    pair = (x, y)
    a, (b, c) = pair[1], (x + 1.0, *pair[:1])
    return len(pair), a + b, c, (pair + (a,))[-1], x in (1.0, 2.0)


def named_tuples(p, m, factor):
    q = p.scaled_by(factor)._replace(y=p.y)
    m = m._replace(count=m.count + 1, at=q, is_on=not m.is_on)
    return m, q.length, Point(y=q.x, x=0.5), m[1].x


def tuple_branches(p, ok):
    q = p if ok else Point(p.y, 1.0)
    if ok:
        q = q._replace(x=2.0)
    return q


def record_in_loop(m, n):
    for i in range(n):
        if i % 2 == 0:
            m = step_memory(m, i * 0.5)
        else:
            m = m._replace(is_on=not m.is_on)
    return m


def step_memory(m, x):
    return Memory(m.count + 1, Point(m.at.y, x), m.is_on)


def swapped_records(p, q, n):
    for _ in range(n):
        p, q = q, p.scaled_by(2.0)
    return p, q


def parameters(valve, x):
    return valve.area * x if x > valve.lap else valve.lap


def arrays(row, x):
    row[0] = x
    row[-1] += 2.0
    part = row[1:3]
    part[0] = part[1] * 2.0
    other = row.copy()
    other[:] = 1.0
    row[2:] = other[2:] + row[:2]
    return row.size, part[0], row[row.size - 2], other[0]


def array_sums(row):
    double = 2.0 * row + row / 4.0 - 1.0
    wide = np.abs(-row)
    return double[1], wide.sum(), wide.max(), min(row), np.sum(double[:2])


def new_arrays(n, x):
    a, b, c, d = np.zeros(n), np.ones(3), np.full(2, x), np.array([x, 2.0 * x, -1.0])
    e = np.empty(n)
    e[:] = x
    c *= 3.0
    return a[0] + b[1] + c[1] + d[2] + e[n - 1], a.size, np.array([(1.0, x), (3.0, 4.0)])[1, 0]


def grids(grid, i):
    total = 0.0
    grid[i, 1] = 9.0
    for row in range(grid.shape[0]):
        line = grid[row]
        for column in range(grid.shape[1]):
            total += line[column] * (1.0 + column)
    return total, grid.ravel()[3], grid.reshape((3, 2))[2, 1], grid[i, 1:][0]


def held_arrays(held, n):
    for i in range(n):
        held = push(held, i * 1.5)
    return held.row.sum() + held.level, held.row[0]


def push(held, value):
    row = held.row.copy()
    for i in range(row.size - 1):
        row[i] = row[i + 1]
    row[row.size - 1] = value
    return Held(row, held.level + value)


def tables(i, x):
    return TABLE[i] * x, WEIGHTS[i], GRID[i, 1], (x, 2.0 * x, 3.0)[i], TABLE[1]


def comprehensions(x, y):
    doubled = [2.0 * v for v in (x, y)]
    crossed = tuple(a * b for a in doubled for b in (1.0, x))
    picked = np.array([float(i) + x for i in range(5) if i % 2 == 0])
    return sum(doubled), crossed[3], picked[2], [k * v for k, v in enumerate(doubled)][1]


def exact_functions(x):
    return np.sqrt(x), math.floor(x), np.floor(x), np.ceil(x), math.trunc(x), abs(x), math.copysign(2.0, x), np.rint(x)


def library_functions(x):
    return np.exp(-x), np.log(x), np.sin(x), math.erfc(x), np.arctan2(x, 2.0), np.tanh(x), x**1.5, math.hypot(x, 3.0)


def extremes(x, y, n):
    return min(x, y), max(x, y), min(x, y, 0.0), max(n, 2), min((x, y)), np.minimum(x, y), np.maximum(x, y)


def questions(x):
    return np.isfinite(x), np.isnan(x), math.isinf(x), np.where(x > 1.0, 2.0, 3.0), np.sinc(0.0)


def enums(n):
    return (Side.RIGHT.value + n) if n == Side.LEFT else int(Side.RIGHT)


def defaults(x):
    return helper(x) + helper(x, scale=2.0) + helper(offset=x, x=x)


def helper(x, offset=1.0, *, scale=3.0):
    """A docstring has no effect."""
    return scale * x - offset


def without_result(row):
    for i in range(row.size):
        if row[i] > 2.0:
            return
        row[i] = 0.0


def assigned_on_all_ways(x):
    if x > 0.0:
        y, word = 1.0, "a"
    else:
        y, word = 2.0, "a"
    return y, word == "a"


def many_arrays(n):
    total = 0.0
    for i in range(n):
        total += made(100, i)[50]
    return total


def made(n, x):
    row = np.zeros(n)
    row[:] = x
    return row


ROW = np.array([1.0, 2.0, 3.0, 4.0])
CASES = [
    (sums, [(1.5, -2.25), (0.1, 3.0), (0.0, -0.0), (INF, NAN)]),
    (whole_sums, [(5, -3), (0, 0)]),
    (floor_division, [(7, 2), (-7, 2), (7, -2), (-7, -2), (0, -5), (9, 3), (-(2**63), 3), (6, -1)]),
    (
        floor_division,
        [
            (7.5, 2.0),
            (-7.5, 2.0),
            (7.5, -2.0),
            (-7.5, -2.0),
            (0.0, -3.0),
            (-0.0, 3.0),
            (1.0, 0.0),
            (-1.0, 0.0),
            (0.0, 0.0),
        ],
    ),
    (floor_division, [(1.0, 0.1), (0.3, 0.1), (1e300, 1e-10), (INF, 2.0), (2.0, INF), (-2.0, INF), (NAN, 1.0)]),
    (shifts, [(5, 2), (-5, 1), (1 << 40, 40)]),
    (true_division, [(1.0, 3.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), (1.0, -0.0)]),
    (true_division, [(7, 2), (-1, 3)]),
    (powers, [(2.5,), (-0.5,), (0.0,)]),
    (comparisons, [(1.0, 2.0), (2.0, 2.0), (NAN, 1.0), (NAN, NAN), (0.0, -0.0)]),
    (comparisons, [(1, 2), (-1, -2), (3, 3)]),
    (comparisons, [(True, False), (True, True)]),
    (chain, [(0.5, 0.0, 1.0), (1.0, 0.0, 1.0), (NAN, 0.0, 1.0)]),
    (truths, [(True, False), (False, True), (True, True), (False, False)]),
    (conversions, [(-2.7, 3, True), (2.7, 0, False)]),
    (branches, [(0.5,), (1.5,), (3.0,), (7.0,), (5.5,), (NAN,)]),
    (branch_types, [(1.0, 3), (-1.5, 3)]),
    (early_return, [(2.5, ROW), (9.0, ROW), (9.0, -ROW)]),
    (for_loops, [(10, 0, 1), (10, 7, -2), (0, 0, 5), (25, 3, 4)]),
    (loop_exits, [(ROW, 10.0), (ROW, 2.5), (np.array([-1.0, 5.0, -2.0, 3.0]), 10.0), (np.zeros(0), 1.0)]),
    (loop_over_tuple, [(1.0, -2.0, 3.0), (1.0, 20.0, 3.0), (-1.0, -2.0, -3.0)]),
    (while_loops, [(100.0, 20), (1e9, 50), (100.0, 2), (0.5, 5)]),
    (swapped, [(0,), (1,), (7,)]),
    (rotated, [(0,), (1,), (20,)]),
    (nested_loops, [(0,), (9,)]),
    (whole_becomes_float, [(0,), (5,)]),
    (tuples, [(1.0, 2.0), (3.0, -4.0)]),
    (named_tuples, [(Point(3.0, 4.0), Memory(2, Point(0.0, 1.0), True), 2.0)]),
    (tuple_branches, [(Point(3.0, 4.0), True), (Point(3.0, 4.0), False)]),
    (record_in_loop, [(Memory(2, Point(0.0, 1.0), True), n) for n in (0, 1, 2, 7)]),
    (swapped_records, [(Point(1.0, 2.0), Point(3.0, 4.0), n) for n in (0, 1, 2, 5)]),
    (parameters, [(stand_in(Valve)(0.5, 0.1), 1.0), (stand_in(Valve)(0.5, 0.1), 0.05)]),
    (arrays, [(ROW, 7.0)]),
    (array_sums, [(ROW,), (np.array([-0.0, 3.0]),)]),
    (new_arrays, [(4, 1.5), (20, -2.0)]),
    (grids, [(np.arange(6.0).reshape(2, 3), 0), (np.arange(6.0).reshape(2, 3), 1)]),
    (held_arrays, [(Held(ROW, 1.0), 0), (Held(ROW, 1.0), 3), (Held(ROW, 1.0), 6)]),
    (tables, [(0, 2.0), (1, 0.5)]),
    (comprehensions, [(1.5, -2.0)]),
    (exact_functions, [(2.25,), (0.0,), (1e10,), (2.5,)]),
    (extremes, [(1.0, 2.0, 3), (2.0, -1.0, 1), (NAN, 1.0, 0), (1.0, NAN, 0), (0.0, -0.0, 0), (-0.0, 0.0, 0)]),
    (questions, [(0.5,), (2.0,), (INF,), (NAN,)]),
    (enums, [(0,), (1,)]),
    (defaults, [(1.5,)]),
    (without_result, [(ROW,)]),
    (assigned_on_all_ways, [(1.0,), (-1.0,)]),
    (many_arrays, [(0,), (1000,)]),
]
