"""Text with a unit to SI and back: every kind, gauge and absolute, and what is refused."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.words import wording

from vvdp.base import kinds
from vvdp.base.display import value_text
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Kind
from vvdp.base.units import ATMOSPHERE, in_unit, number_and_unit, parse, parsed_difference

FITTED = Kind("fitted coefficient", "SI", 1e-12, 1.0, "1.45e-6 SI", units=("SI",))
ALL = {name: kind for name, kind in vars(kinds).items() if isinstance(kind, Kind)} | {"FITTED": FITTED}


@st.composite
def kinds_and_values(draw: st.DrawFn) -> tuple[Kind, float]:
    """A kind and a value within its range, of any size."""
    kind = draw(st.sampled_from(sorted(ALL.values(), key=lambda kind: kind.name)))
    within = st.floats(kind.low, kind.high)
    sizes = st.builds(lambda sign, e: sign * 10.0**e, st.sampled_from([-1.0, 1.0]), st.floats(-13.0, 12.0))
    return kind, draw(within | sizes.filter(lambda x: kind.low <= x <= kind.high))


@given(kinds_and_values())
def test_what_is_displayed_can_be_written(pair: tuple[Kind, float]) -> None:
    kind, value = pair
    text = value_text(value, kind).partition(" (")[0]
    number, _ = number_and_unit(text)
    again = parsed_difference(text, kind) + (ATMOSPHERE if kind is kinds.PRESSURE_LEVEL else 0.0)
    if kind is kinds.TEMPERATURE:
        again += 273.15
    # Six digits are shown: half of the last one, and the rounding of the shift to the zero of the scale.
    digit = 10.0 ** (math.floor(math.log10(abs(number))) - 5) if number else 0.0
    one = abs(parsed_difference(f"1 {number_and_unit(text)[1]}", kind))
    assert abs(again - value) <= 0.51 * digit * one + 1e-12 * (abs(value) + abs(again)) + 1e-300


@given(kinds_and_values())
def test_a_value_in_full_comes_back_to_rounding(pair: tuple[Kind, float]) -> None:
    kind, value = pair
    unit = kind.display_unit if kind.unit not in ("1", "SI") else kind.unit.replace("1", "")
    if kind in (kinds.PRESSURE_LEVEL, kinds.TEMPERATURE):  # scales with a shifted zero: take the absolute one
        text = f"{value!r} K" if kind is kinds.TEMPERATURE else f"{value / 1e5!r} bara"
    else:
        text = f"{in_unit(value, kind, unit) if unit != 'SI' else value!r} {unit}"
    try:
        assert parse(text, kind) == pytest.approx(value, rel=1e-14, abs=1e-300)
    except ParameterError as problem:  # rounded over the end of the range
        assert "outside" in str(problem) and (value in (kind.low, kind.high) or value == pytest.approx(kind.high))


@pytest.mark.parametrize("kind", ALL.values(), ids=ALL.keys())
def test_the_example_of_a_kind_is_a_value_of_it(kind: Kind) -> None:
    assert kind.low <= parse(kind.example, kind) <= kind.high


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("1 bar", kinds.PRESSURE_LEVEL, 201325.0),
        ("1 barg", kinds.PRESSURE_LEVEL, 201325.0),
        ("1 bara", kinds.PRESSURE_LEVEL, 1e5),
        ("0.1 MPa", kinds.PRESSURE_LEVEL, 201325.0),
        ("-1.01325 bar", kinds.PRESSURE_LEVEL, 0.0),
        ("1000 psi", kinds.PRESSURE_LEVEL, 101325.0 + 1000 * 0.45359237 * 9.80665 / 0.0254**2),
        ("1000 psig", kinds.PRESSURE_LEVEL, 101325.0 + 1000 * 0.45359237 * 9.80665 / 0.0254**2),
        ("14.6959488 psia", kinds.PRESSURE_LEVEL, 101325.0),
        ("1 bar", kinds.PRESSURE_DIFFERENCE, 1e5),
        ("1 cc/rev", kinds.DISPLACEMENT, 1e-6 / (2 * math.pi)),
        ("1 in^3/rev", kinds.DISPLACEMENT, 0.0254**3 / (2 * math.pi)),
        ("3.6 cSt", kinds.KINEMATIC_VISCOSITY, 3.6e-6),
        ("38.7 mPa*s", kinds.DYNAMIC_VISCOSITY, 0.0387),
        ("1 rpm", kinds.SPEED, 2 * math.pi / 60),
        ("360 deg/s", kinds.SPEED, 2 * math.pi),
        ("1 rev", kinds.ANGLE, 2 * math.pi),
        ("104 degF", kinds.TEMPERATURE, 313.15),
        ("40 degC", kinds.TEMPERATURE, 313.15),
        ("50%", kinds.FRACTION, 0.5),
        (0.5, kinds.FRACTION, 0.5),
        (3, kinds.COUNT, 3.0),
        (" 1.5e1  mm2 ", kinds.AREA, 15e-6),
        (".5 mm**2", kinds.AREA, 0.5e-6),
        ("2. l/min", kinds.FLOW, 2e-3 / 60),
    ],
)
def test_values_worked_by_hand(text: object, kind: Kind, value: float) -> None:
    assert parse(text, kind) == pytest.approx(value, rel=1e-8 if "psia" in str(text) else 1e-13, abs=1e-9)


@given(st.floats(-1.0, 5000.0))
@example(0.0)
def test_gauge_and_absolute_are_one_atmosphere_apart(number: float) -> None:
    gauge, absolute = (
        parse(f"{number!r} bar", kinds.PRESSURE_LEVEL),
        parse(f"{abs(number)!r} bara", kinds.PRESSURE_LEVEL),
    )
    if number >= 0.0:
        assert gauge - absolute == pytest.approx(ATMOSPHERE, abs=1e-6)
    assert value_text(gauge, kinds.PRESSURE_LEVEL).startswith(f"{(gauge - ATMOSPHERE) / 1e5:.6g} bar (")
    assert parse(f"{number!r} barg", kinds.PRESSURE_LEVEL) == gauge


@pytest.mark.parametrize(
    ("text", "kind", "told"),
    [
        ("22.5 Hz", kinds.SPEED, wording.files.write_instead.format(value="1350 rpm or 22.5 rev/s")),
        ("22.5 1/s", kinds.SPEED, wording.files.write_instead.format(value="1350 rpm or 22.5 rev/s")),
        ("60 rpm", kinds.FREQUENCY, wording.files.use_one_of.format(units="Hz, kHz, 1/s")),
        ("1 rad/s", kinds.FREQUENCY, wording.files.use_one_of.format(units="Hz, kHz, 1/s")),
        ("20 cc", kinds.DISPLACEMENT, "cc/rev"),
        ("2e-5 m^3", kinds.DISPLACEMENT, "m^3/rad"),
        ("5 bara", kinds.PRESSURE_DIFFERENCE, wording.files.has_no.format(unit="bara")),
        ("5 psig", kinds.PRESSURE_DIFFERENCE, wording.files.has_no.format(unit="psig")),
        ("5 barg", kinds.BULK_MODULUS, wording.files.has_no.format(unit="barg")),
        ("-2 bar", kinds.PRESSURE_LEVEL, wording.files.outside_from.format(low="-1.01325")),
        ("40", kinds.TEMPERATURE, wording.files.has_no_unit),
        (40, kinds.TEMPERATURE, wording.files.has_no_unit),
        ("100", kinds.PRESSURE_LEVEL, wording.files.level_example.format(example="100 bar")),
        (1e-6, kinds.VOLUME, wording.files.has_no_unit),
        ("5 bar", kinds.VOLUME, wording.files.is_not_a.format(quantity="a volume")),
        ("12.7 parsecs_", kinds.LENGTH, wording.files.unknown_unit),
        ("5 delta_degC", kinds.TEMPERATURE, wording.files.use_one_of.format(units="degC, K, degF")),
        ("0.5 rad", kinds.DUTY_RATIO, wording.files.plain_number),
        ("1 dB", kinds.RATIO, wording.files.plain_number),
        ("3 rpm*s", kinds.COUNT, wording.files.plain_number),
        ("1.45e-6", FITTED, wording.files.with_si),
        ("12,7 mm", kinds.LENGTH, wording.files.unknown_unit),
        ("1e999 m", kinds.LENGTH, wording.files.is_not_finite),
        ("nan", kinds.RATIO, wording.files.is_no_number_with_unit),
        (float("inf"), kinds.RATIO, wording.files.is_no_number_with_unit),
        ("", kinds.RATIO, wording.files.is_no_number_with_unit),
        ("bar", kinds.PRESSURE_LEVEL, wording.files.is_no_number_with_unit),
        (True, kinds.RATIO, "True " + wording.files.is_not_a.format(quantity="a ratio")),
        (None, kinds.RATIO, "None " + wording.files.is_not_a.format(quantity="a ratio")),
        ([1.0], kinds.RATIO, wording.files.is_not_a.format(quantity="a ratio")),
        ("1 " + "m" * 300, kinds.LENGTH, "302 characters"),
        ("1 m^9^9^9^9", kinds.LENGTH, wording.files.unknown_unit),
        ("1 __import__('os')", kinds.LENGTH, wording.files.unknown_unit),
    ],
)
def test_what_is_wrong_or_misleading_is_refused_with_what_to_write(text: object, kind: Kind, told: str) -> None:
    with pytest.raises(ParameterError) as caught:
        parse(text, kind)
    assert told in str(caught.value)


@given(st.text(max_size=30) | st.builds(lambda n, u: f"{n} {u}", st.floats(), st.text(max_size=12)))
def test_any_text_is_a_value_or_a_parameter_error(text: str) -> None:
    for kind in (kinds.PRESSURE_LEVEL, kinds.SPEED, kinds.RATIO, kinds.LENGTH):
        try:
            assert kind.low <= parse(text, kind) <= kind.high
        except ParameterError as problem:
            assert kind.name in str(problem) or kind.example in str(problem)


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("5 bar", kinds.PRESSURE_LEVEL, 5e5),
        ("5 bara", kinds.PRESSURE_LEVEL, 5e5),
        ("-5 bar", kinds.PRESSURE_LEVEL, -5e5),
        ("5 K", kinds.TEMPERATURE, 5.0),
        ("5 degC", kinds.TEMPERATURE, 5.0),
        ("9 degF", kinds.TEMPERATURE, 5.0),
        ("60 rpm", kinds.SPEED, 2 * math.pi),
        ("10 %", kinds.FRACTION, 0.1),
    ],
)
def test_a_difference_knows_no_zero(text: str, kind: Kind, value: float) -> None:
    assert parsed_difference(text, kind) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("text", ["5", "5 Hz", "1e999 bar", "wide"])
def test_a_difference_is_as_strict_as_a_value(text: str) -> None:
    with pytest.raises(ParameterError):
        parsed_difference(text, kinds.PRESSURE_LEVEL)
