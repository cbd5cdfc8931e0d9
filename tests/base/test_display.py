"""Numbers are written as people read them."""

import pytest

from vvdp.base.display import fixed_point, number, plain, value_and_unit
from vvdp.base.kinds import PRESSURE_LEVEL, SPEED, TIME


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.0, "0"), (12.3456, "12.35"), (-0.5, "−0.5000"), (99.999, "100.0"), (3.2e-9, "3.200·10⁻⁹"), (float("nan"), "–")],
)
def test_significant_digits(value, expected):
    assert number(value) == expected


def test_places_and_no_negative_zero():
    assert fixed_point(-0.04, 1) == "0.0"
    assert fixed_point(-1.25, 2) == "−1.25"


def test_parameters_keep_no_trailing_zeros():
    assert plain(1e-7) == "1·10⁻⁷"
    assert plain(22.2222222) == "22.2222"
    assert plain(100.0) == "100"


def test_units():
    assert value_and_unit(100e5 + 101325.0, PRESSURE_LEVEL) == ("100", "bar")
    assert value_and_unit(0.3e5, PRESSURE_LEVEL, absolute=True) == ("0.3", "bar abs.")
    assert value_and_unit(188.49555921538757, SPEED) == ("1800", "rpm")
    assert [value_and_unit(t, TIME) for t in (0.0, 1.0, 0.25, 2e-5)] == [
        ("0", "s"),
        ("1", "s"),
        ("250", "ms"),
        ("20", "µs"),
    ]
