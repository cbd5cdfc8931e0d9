"""Kinds, and the classes made of them."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.words import wording

from vvdp.base import kinds
from vvdp.base.errors import ConfigError, Fault, ParameterError, VvdpError
from vvdp.base.kinds import Kind, Length, Pressure, PressureSignal, Time
from vvdp.base.params import Params, field_kinds, field_types
from vvdp.base.signal import Signal, constant, sine

ALL = [kind for kind in vars(kinds).values() if isinstance(kind, Kind)]


class Tube(Params):
    """A pressure and a length."""

    pressure: Pressure
    length: Length


class Source(Tube):
    """A tube with a prescribed pressure."""

    drive: PressureSignal


@given(st.sampled_from(ALL), st.floats())
def test_a_fault_is_told_exactly_outside_the_range(kind: Kind, value: float) -> None:
    fault = kind.fault(value)
    assert (fault is None) == (kind.low <= value <= kind.high)
    if fault:
        assert kind.name in fault


def test_kinds_are_told_apart_by_name_and_have_sound_ranges() -> None:
    assert len({kind.name for kind in ALL}) == len(ALL)
    for kind in ALL:
        assert kind.low < kind.high and kind.scale > 0.0 and math.isfinite(kind.low) and math.isfinite(kind.high)
        assert not kind.units or kind.display_unit in kind.units


def test_a_class_is_frozen_keyword_only_and_checked() -> None:
    tube = Tube(pressure=1e5, length=0.1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        tube.length = 1.0  # type: ignore[misc]
    with pytest.raises(TypeError):
        Tube(1e5, 0.1)  # type: ignore[misc]
    with pytest.raises(
        ParameterError,
        match="Tube.length: " + wording.files.outside_range.format(value="1000 m", low=0, high="100 m"),
    ):
        Tube(pressure=1e5, length=1000.0)
    with pytest.raises(ParameterError, match="Tube.pressure: nan is " + wording.files.is_not_finite):
        Tube(pressure=math.nan, length=0.1)
    assert tube == Tube(pressure=1e5, length=0.1) and hash(tube) == hash(Tube(pressure=1e5, length=0.1))


def test_checks_of_all_classes_are_made_once_those_built_on_first() -> None:
    made: list[str] = []

    class Size(Params):
        length: Length

        def check(self) -> None:
            made.append("size")

    class Left(Size):
        def check(self) -> None:
            made.append("left")

    class Right(Size):
        def check(self) -> None:
            made.append("right")

    class Both(Left, Right):
        def check(self) -> None:
            made.append("both")

    class Inheriting(Both):
        pass

    Inheriting(length=1.0)
    assert made == ["size", "left", "right", "both"]


def test_signals_are_checked_at_their_extremes() -> None:
    assert Source(pressure=1e5, length=0.1, drive=sine(2e5, 1e5, 1.0)).drive.base == 2e5
    with pytest.raises(ParameterError, match="Source.drive: -100000 Pa " + wording.files.is_outside):
        Source(pressure=1e5, length=0.1, drive=sine(2e5, 3e5, 1.0))
    with pytest.raises(ParameterError, match=r"Source\.length"):
        Source(pressure=1e5, length=-1.0, drive=constant(1e5))


def test_fields_know_their_kinds_and_types() -> None:
    assert field_kinds(Source) == {
        "pressure": kinds.PRESSURE_LEVEL,
        "length": kinds.LENGTH,
        "drive": kinds.PRESSURE_LEVEL,
    }
    assert field_types(Source)["drive"] is Signal


def test_faults_read_as_places_in_a_file() -> None:
    assert str(Fault("a.toml", 3, "x.y", "is odd")) == "a.toml:3: x.y: is odd"
    assert str(Fault("a.toml", 0, "", "is odd")) == "a.toml: is odd"
    both = ConfigError([Fault("a", 1, "", "b"), Fault("a", 2, "", "c")])
    assert str(both) == "a:1: b\na:2: c" and isinstance(both, VvdpError | ValueError) and len(both.faults) == 2


def test_a_quantity_may_be_none_where_that_is_its_default() -> None:
    class Window(Params):
        begin: Time
        end: Time | None = None

    assert field_kinds(Window)["end"] is field_kinds(Window)["begin"]
    assert Window(begin=1.0).end is None and Window(begin=1.0, end=2.0).end == 2.0
    with pytest.raises(ParameterError, match=r"Window\.end: 1e\+99"):
        Window(begin=1.0, end=1e99)
    with pytest.raises(TypeError):
        Window(begin=None)
