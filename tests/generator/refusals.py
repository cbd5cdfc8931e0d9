# ruff: noqa: C416, F821, PTH123
"""Functions that use what the language does not have."""

import numpy as np

STRIDED = np.arange(8.0)[::2]


def tries(x):
    try:
        return 1.0 / x
    except ZeroDivisionError:
        return 0.0


def opens(x):
    with open(x):
        pass


def nests(x):
    def inner():
        return x

    return inner()


def recursive(x):
    return recursive(x - 1.0) if x > 0.0 else x


def anonymous(x):
    return (lambda y: y)(x)


def dictionary(x):
    return {"a": x}["a"]


def unlisted(x):
    return np.linalg.norm(x)


def formatted(x):
    return x.hex()


def mutable(p):
    p.x = 1.0
    return p


def element_of_tuple(p):
    p[0] = 1.0
    return p


def undefined(x):
    if x > 0.0:
        y = 1.0
    return y


def unknown(x):
    return x + missing


def changing_type(x):
    value = x
    if x > 0.0:
        value = (x, x)
    return value


def two_results(x):
    if x > 0.0:
        return x
    return (x, x)


def unknown_index(p, n):
    return (p, 1.0)[n]


def behind_the_end(x):
    return (x, 1.0)[2]


def float_index(row, x):
    return row[x]


def array_truth(row):
    return 1.0 if row else 0.0


def strided(row):
    return row[::2]


def ranks(row, grid):
    return row + grid


def unpacked(x):
    a, b = (x, x, x)
    return a + b


def more_arguments(x):
    return undefined(x, x)


def fewer_arguments():
    return undefined()


def star(*values):
    return values


def operand(x, n):
    return n or x


def float_bits(x):
    return x & 1


def array_method(row):
    return row.cumsum()


def field(p):
    return p.z


def table(x):
    return STRIDED + x


def endless(row):
    return [v for v in row]


def global_change(x):
    global STRIDED
    STRIDED = x


def comparison(x):
    return x is STRIDED


def large(n):
    return n + 2**70


def changed_table(x):
    STRIDED[0] = x


def matches(x):
    match x:
        case 0.0:
            return 1.0
    return x


def asynchronous(x):
    yield x


def walrus(x):
    return (y := x) + y


def returned_array(n):
    return np.zeros(n)
