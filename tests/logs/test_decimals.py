"""The compiled parser of numbers against Python's own, to the last bit."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.logs.decimals import decimals


def one_column(texts, decimal="."):
    """What is read of a column of texts; None where a text was given back."""
    block = "".join(f"{text}\n" for text in texts).encode()
    table = decimals(block, b";", decimal.encode(), 1, np.array([0]))
    assert table is not None and table.values.shape == (len(texts), 1)
    back = {row: block[begin:end].decode() for row, _, begin, end in table.given_back.tolist()}
    assert all(back[row] == texts[row].strip() for row in back)
    return [None if row in back else float(table.values[row, 0]) for row in range(len(texts))]


def same(a, b):
    return struct.pack("d", a) == struct.pack("d", b)


@st.composite
def written(draw):
    """Plain decimal numbers of up to 19 digits, with the point anywhere and perhaps a power of ten."""
    digits = draw(st.text("0123456789", min_size=1, max_size=19))
    place = draw(st.integers(0, len(digits)))
    point = draw(st.booleans())
    number = f"{digits[:place]}.{digits[place:]}" if point else digits
    power = draw(st.one_of(st.just(""), st.integers(-290, 270).map(lambda p: f"e{p}"), st.just("E+05")))
    return draw(st.sampled_from(["", "-", "+"])) + number + power


@given(st.lists(written(), min_size=1, max_size=20))
def test_decimal_numbers_are_rounded_as_python_does(texts):
    """Nothing of this size is given back, or hardly ever: undecided are the products with 64 ones below the cut."""
    for text, found in zip(texts, one_column(texts), strict=True):
        assert found is not None and same(found, float(text))


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20))
def test_floats_come_back(values):
    """The smallest and the largest are given back: what is subnormal or might overflow."""
    for how in (repr, lambda x: f"{x:.18e}"):
        for value, found in zip(values, one_column([how(x) for x in values]), strict=True):
            assert same(found, value) if found is not None else not 1e-307 < abs(value) < 8e307


@given(st.integers(2**52, 2**53 - 1), st.integers(0, 10))
def test_halves_go_to_the_even_neighbour(mantissa, power):
    """2 m + 1 has one bit more than a float: exactly between two of them, also behind powers of ten."""
    half = 2 * mantissa + 1
    texts = [str(half), f"{half}e{power}"]
    for text, found in zip(texts, one_column(texts), strict=True):
        assert found is not None and same(found, float(text))
    assert int(one_column([str(half)])[0]) % 4 == 0


def test_worked_by_hand():
    texts = ["0", "-0", "1", " 2.5 ", ".5", "5.", "1e3", "9007199254740993", "1e23", "nan", "NaN"]
    found = one_column(texts)
    # 2^53 + 1 lies between 2^53 and 2^53 + 2, the even one is 2^53; 1e23 lies between 99999999999999991611392 and
    # 100000000000000008388608.
    assert found[:9] == [0.0, 0.0, 1.0, 2.5, 0.5, 5.0, 1000.0, 9007199254740992.0, 99999999999999991611392.0]
    assert np.isnan(found[9:]).all() and same(found[1], -0.0)
    assert one_column(["1,5", "-2,25"], ",") == [1.5, -2.25]
    empty = decimals(b"1,,3\n,2,\n", b",", b".", 3, np.arange(3))
    assert empty is not None and np.array_equal(empty.values, [[1, np.nan, 3], [np.nan, 2, np.nan]], equal_nan=True)


@pytest.mark.parametrize("text", ["x", ".", "-", "+", "1.2.3", "1_0", "0x1", "1e", "1e+", "1e5.0", "--1", "1 2", "inf",
                                  "1,5", "12345678901234567890", "n/a", "nano", "1e99999"])  # fmt: skip
def test_what_is_no_plain_number_is_given_back(text):
    table = decimals(f"1;{text}\n2;3\n".encode(), b";", b".", 2, np.array([1]))
    assert table is not None
    assert table.given_back.tolist() == [[0, 0, 2, 2 + len(text)]] and table.values[1, 0] == 3.0


@pytest.mark.parametrize("block", [b"1,2,3\n", b"1\n", b"1,2\n\n", b"1,2\n3\n", b"1,2\n3,4", b"\n1,2\n"])
def test_rows_that_are_not_plain_are_not_read(block):
    assert decimals(block, b",", b".", 2, np.array([0, 1])) is None


def test_columns_of_choice_and_blanks_between_them():
    found = decimals(b" 1\t2   3 \r\n4 5\t6\n", b"", b".", 3, np.array([2, 0]))
    assert found is not None and found.values.tolist() == [[3.0, 1.0], [6.0, 4.0]]
    none = decimals(b"a,b\nc,d\n", b",", b".", 2, np.array([], int))
    assert none is not None and none.values.shape == (2, 0)


def test_a_block_of_words_is_not_read_word_by_word():
    assert decimals(b"word\n" * 1000, b",", b".", 1, np.array([0])) is None
