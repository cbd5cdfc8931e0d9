"""Numbers in blocks of text, as pandas reads them, against Python's own, to the last bit."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.logs.dialect import NO_NUMBER
from vvdp.logs.text import _NO_NUMBERS, _numbers


def one_column(texts, decimal="."):
    found = _numbers("".join(f"{text}\n" for text in texts).encode(), b";", decimal, 1, [0])
    return None if found is None else found[0].tolist()


def same(a, b):
    return struct.pack("d", a) == struct.pack("d", b)


@st.composite
def written(draw):
    """Plain decimal numbers of up to 40 digits, with the point anywhere and perhaps a power of ten."""
    digits = draw(st.text("0123456789", min_size=1, max_size=40))
    place = draw(st.integers(0, len(digits)))
    point = draw(st.booleans())
    number = f"{digits[:place]}.{digits[place:]}" if point else digits
    power = draw(st.one_of(st.just(""), st.integers(-350, 270).map(lambda p: f"e{p}"), st.just("E+05")))
    return draw(st.sampled_from(["", "-", "+"])) + number + power


@given(st.lists(written(), min_size=1, max_size=20))
def test_decimal_numbers_are_rounded_as_python_does(texts):
    found = one_column(texts)
    assert found is not None
    for text, value in zip(texts, found, strict=True):
        assert same(value, float(text))


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=20))
def test_floats_come_back(values):
    for how in (repr, lambda x: f"{x:.18e}"):
        found = one_column([how(x) for x in values])
        assert found is not None and all(same(a, b) for a, b in zip(found, values, strict=True))


@given(st.integers(2**52, 2**53 - 1), st.integers(0, 10))
def test_halves_go_to_the_even_neighbour(mantissa, power):
    """2 m + 1 has one bit more than a float: exactly between two of them, also behind powers of ten."""
    half = 2 * mantissa + 1
    texts = [str(half), f"{half}e{power}"]
    found = one_column(texts)
    assert found is not None and all(same(value, float(text)) for value, text in zip(found, texts, strict=True))
    assert int(found[0]) % 4 == 0


def test_worked_by_hand():
    texts = ["0", "-0", "1", " 2.5 ", ".5", "5.", "1e3", "9007199254740993", "1e23", "nan", "NaN"]
    found = one_column(texts)
    # 2^53 + 1 lies between 2^53 and 2^53 + 2, the even one is 2^53; 1e23 lies between 99999999999999991611392 and
    # 100000000000000008388608.
    assert found[:9] == [0.0, 0.0, 1.0, 2.5, 0.5, 5.0, 1000.0, 9007199254740992.0, 99999999999999991611392.0]
    assert np.isnan(found[9:]).all() and same(found[1], -0.0)
    assert one_column(["1,5", "-2,25"], ",") == [1.5, -2.25]
    empty = _numbers(b"1,,3\n,2,\n", b",", ".", 3, [0, 1, 2])
    assert np.array_equal([empty[k] for k in range(3)], [[1, np.nan], [np.nan, 2], [3, np.nan]], equal_nan=True)


@pytest.mark.parametrize("text", ["x", ".", "-", "+", "1.2.3", "1_0", "0x1", "1e", "1e+", "1e5.0", "--1", "1 2", "1,5",
                                  "nano", "True", "<NA>", "1\x002", "1\r2", "1'000", "None1"])  # fmt: skip
def test_a_block_with_anything_else_is_left_to_the_careful_parser(text):
    assert _numbers(f"1;{text}\n2;3\n".encode(), b";", ".", 2, [1]) is None


def test_what_pandas_takes_for_no_number_is_none():
    assert all(not word or NO_NUMBER.fullmatch(word) for word in _NO_NUMBERS)
    assert np.isnan(one_column([word for word in _NO_NUMBERS if word])).all()


@pytest.mark.parametrize("block", [b"1,2,3\n", b"1\n", b"1,2\n\n", b"1,2\n3\n", b"1,2\n3,4", b"\n1,2\n",
                                   b"1\n1,2,3\n1,2\n"])  # fmt: skip
def test_rows_of_another_width_are_not_read(block):
    assert _numbers(block, b",", ".", 2, [0, 1]) is None


@pytest.mark.parametrize("block", [b"1 2 3\n", b"1\n1 2\n", b"1 2\n\n1 2\n", b"1 2\n3 4 5\n"])
def test_rows_of_another_width_between_blanks_are_not_read(block):
    assert _numbers(block, b"", ".", 2, [0]) is None


def test_columns_of_choice_and_blanks_between_them():
    found = _numbers(b" 1\t2   3 \r\n4 5\t6\n", b"", ".", 3, [2, 0])
    assert found[2].tolist() == [3.0, 6.0] and found[0].tolist() == [1.0, 4.0]
