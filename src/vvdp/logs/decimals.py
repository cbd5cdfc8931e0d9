"""Decimal numbers in text, compiled: a block of plain rows becomes an array without a detour over Python.

Every number is rounded correctly, as `float` does it: up to 15 digits by one exact product or quotient (Clinger), more
by the product of the digits with a power of five in 128 bits (Lemire). What neither decides, and every field that is no
plain number, is given back by its place in the text.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vvdp.base.arrays import Array

LEAST, MOST = -342, 308
"""Powers of ten beyond which 19 digits are zero or infinite."""
MOST_DIGITS = 19
"""Decimal digits that fit into 64 bits."""
LEFT, GIVEN_BACK = 4, 100
"""Fields given back: at most one in so many rows, and so many besides; else the block is not plain."""


class Table(NamedTuple):
    """Values, and the fields that are to be read otherwise: row, column, first and last byte."""

    values: Array  # (rows, columns)
    given_back: NDArray[np.int64]  # (fields, 4)


def decimals(block: bytes, delimiter: bytes, decimal: bytes, width: int, columns: NDArray[np.int64]) -> Table | None:
    """The chosen columns of the lines of `block`, each of `width` fields and complete; None where a line is not.

    An empty `delimiter` stands for blanks. Empty fields are NaN.
    """
    text = np.frombuffer(block, np.uint8)
    rows = block.count(b"\n")
    place = np.full(width, -1)
    place[columns] = np.arange(columns.size)
    values = np.empty((rows, columns.size))
    given_back = np.empty((rows // LEFT + GIVEN_BACK, 4), np.int64)
    mark = delimiter[0] if delimiter else 0
    found = _read(text, mark, decimal[0], width, place, values, given_back, HIGH, LOW, TENS)
    return None if found < 0 else Table(values, given_back[:found])


def _powers_of_five() -> tuple[Any, Any]:
    """The 128 leading bits of 5^q, those below zero rounded up, as high and low halves."""
    high, low = np.empty(MOST - LEAST + 1, np.uint64), np.empty(MOST - LEAST + 1, np.uint64)
    for q in range(LEAST, MOST + 1):
        power = 5 ** abs(q)
        bits = power.bit_length() if power & (power - 1) else power.bit_length() - 1
        if q >= 0:
            shift = 128 - power.bit_length()
            leading = power << shift if shift >= 0 else power >> -shift
        else:
            leading = (1 << (bits + 127 if q >= -27 else 2 * bits + 128)) // power + 1
            leading >>= max(leading.bit_length() - 128, 0)
        high[q - LEAST], low[q - LEAST] = leading >> 64, leading & (2**64 - 1)
    return high, low


HIGH, LOW = _powers_of_five()
TENS = 10.0 ** np.arange(23)
"""The powers of ten that a float holds exactly."""


@njit(cache=True)
def _read(text, mark, decimal, width, place, values, given_back, high, low, tens):  # type: ignore[no-untyped-def]
    """Fills `values`; how many fields were given back, or -1 where the block is not plain."""
    n, i, left = text.size, 0, 0
    for row in range(values.shape[0]):
        for column in range(width):
            while i < n and (text[i] == 32 or (mark == 0 and _blank(text[i]))):
                i += 1
            begin = i
            while i < n and text[i] != mark and text[i] != 10 and not (mark == 0 and _blank(text[i])):
                i += 1
            end = i
            while mark == 0 and i < n and _blank(text[i]):
                i += 1
            if i >= n or (text[i] == 10) != (column == width - 1):
                return -1
            if mark != 0 or text[i] == 10:
                i += 1
            while end > begin and (text[end - 1] == 32 or text[end - 1] == 13):
                end -= 1
            if end == begin and (mark == 0 or width == 1):
                return -1  # a blank line
            at = place[column]
            if at < 0:
                continue
            sound, value = _number(text, begin, end, decimal, high, low, tens)
            if sound:
                values[row, at] = value
            else:
                if left == given_back.shape[0]:
                    return -1
                given_back[left, 0], given_back[left, 1], given_back[left, 2], given_back[left, 3] = row, at, begin, end
                left += 1
    return left if i == n else -1


@njit(cache=True)
def _blank(c):  # type: ignore[no-untyped-def]
    """Blank, tabulator, and the CR of a line's end."""
    return c == 32 or c == 9 or c == 13


@njit(cache=True)
def _number(text, begin, end, decimal, high, low, tens):  # type: ignore[no-untyped-def]
    """Whether the field was understood, and its value."""
    if begin == end:
        return True, np.nan
    i = begin
    negative = text[i] == 45
    if negative or text[i] == 43:
        i += 1
    digits, count, exponent, seen, fraction = np.uint64(0), 0, 0, False, False
    while i < end:
        c = text[i]
        if 48 <= c <= 57:
            seen = True
            if count or c != 48:
                count += 1
                if count > MOST_DIGITS:
                    return False, 0.0
                digits = digits * np.uint64(10) + np.uint64(c - 48)
            if fraction:
                exponent -= 1
        elif c == decimal and not fraction:
            fraction = True
        else:
            break
        i += 1
    if not seen:
        nan = (
            end - begin == 3 and text[begin] | 32 == 110 and text[begin + 1] | 32 == 97 and text[begin + 2] | 32 == 110
        )
        return nan, np.nan
    if i < end:
        if (text[i] != 69 and text[i] != 101) or i + 1 == end:
            return False, 0.0
        i += 1
        below = text[i] == 45
        if below or text[i] == 43:
            i += 1
        if i == end or end - i > 4:
            return False, 0.0
        power = 0
        while i < end:
            if not 48 <= text[i] <= 57:
                return False, 0.0
            power = 10 * power + int(text[i]) - 48
            i += 1
        exponent += -power if below else power
    if digits == np.uint64(0):
        value = 0.0
    elif digits <= np.uint64(9007199254740992) and -22 <= exponent <= 22:
        value = np.float64(digits) / tens[-exponent] if exponent < 0 else np.float64(digits) * tens[exponent]
    else:
        sound, value = _round(digits, exponent, high, low)
        if not sound:
            return False, 0.0
    return True, -value if negative else value


@njit(cache=True)
def _product(a, b):  # type: ignore[no-untyped-def]
    """High and low half of the product of two unsigned numbers of 64 bits."""
    half, mask = np.uint64(32), np.uint64(0xFFFFFFFF)
    a1, a0, b1, b0 = a >> half, a & mask, b >> half, b & mask
    lowest = a0 * b0
    middle = a1 * b0 + (lowest >> half)
    other = a0 * b1 + (middle & mask)
    return a1 * b1 + (middle >> half) + (other >> half), a * b


@njit(cache=True)
def _round(digits, exponent, high, low):  # type: ignore[no-untyped-def]
    """Whether it is decided here, and `digits` times ten to the `exponent`, rounded to even.

    Source  lemire2021, section 5
    """
    one = np.uint64(1)
    if not LEAST <= exponent <= MOST:
        return False, 0.0
    shift = 0
    while not digits >> np.uint64(63):
        digits <<= one
        shift += 1
    top, rest = _product(digits, high[exponent - LEAST])
    if top & np.uint64(0x1FF) == np.uint64(0x1FF):
        more = _product(digits, low[exponent - LEAST])[0]
        rest += more
        if more > rest:
            top += one
        if rest == np.uint64(0xFFFFFFFFFFFFFFFF):
            return False, 0.0
    upper = top >> np.uint64(63)
    cut = upper + np.uint64(9)
    mantissa = top >> cut
    power = ((217706 * exponent) >> 16) + 63 + np.int64(upper) - shift + 1023
    if power <= 0 or power >= 2046:
        return False, 0.0
    if rest <= one and -4 <= exponent <= 23 and mantissa & np.uint64(3) == one and mantissa << cut == top:
        mantissa &= ~one  # halfway between two floats: to the even one
    mantissa = (mantissa + (mantissa & one)) >> one
    return True, np.ldexp(np.float64(mantissa), power - 1075)
