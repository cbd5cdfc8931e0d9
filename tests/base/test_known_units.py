"""The factors of the units that are known without pint: pint's, and by hand."""

import subprocess
import sys

import pytest

from vvdp.base import kinds
from vvdp.base.kinds import Kind
from vvdp.base.known_units import KNOWN, SCALES, conversion, known_unit
from vvdp.base.units import _registry, _unit, is_unit

ALL = [kind for kind in vars(kinds).values() if isinstance(kind, Kind) and kind.unit not in ("1", "SI", "dB")]
WRITTEN = sorted(
    {unit for kind in ALL for unit in (kind.unit, kind.display_unit, *kind.units)} | {"mm2", "m**2", "s^-1", "(m)"}
)
ROUNDING = 6e-16  # pint multiplies its factors one by one: four roundings of 1.1e-16, and one of ours


def by_pint(text: str) -> tuple[float, dict[str, float]]:
    found = _registry().Quantity(1.0, _unit(text)).to_base_units()
    return found.magnitude, {name: float(power) for name, power in found.dimensionality.items() if power}


@pytest.mark.parametrize("text", [*KNOWN, *(unit for unit in WRITTEN if unit not in SCALES)])
def test_same_as_pint(text: str) -> None:
    unit = known_unit(text)
    assert unit is not None
    size, dimension = by_pint(text)
    assert float(unit.size) == pytest.approx(size, rel=ROUNDING, abs=0.0)
    named = dict(zip(("[mass]", "[length]", "[time]", "[temperature]"), map(float, unit.powers), strict=True))
    assert {name: power for name, power in named.items() if power} == dimension


@pytest.mark.parametrize("value", [-40.0, 0.0, 37.5, 212.0])
@pytest.mark.parametrize("one", [*SCALES, "K"])
@pytest.mark.parametrize("other", [*SCALES, "K"])
def test_scales_same_as_pint(one: str, other: str, value: float) -> None:
    a, b, c = conversion(one, other)
    expected = _registry().Quantity(value, one).to(other).magnitude
    assert (value * a + b) / c == pytest.approx(expected, abs=1e-12)


def test_by_hand():
    """1 psi is 0.45359237 kg x 9.80665 m/s^2 over (0.0254 m)^2 = 4.4482216152605 / 6.4516e-4 = 6894.757293168362 Pa."""
    assert conversion("psi", "Pa") == pytest.approx((6894.757293168362, 0.0, 1.0), rel=4e-16)
    assert conversion("cc/rev", "m^3/rad")[0] == pytest.approx(1e-6 / 6.283185307179586, rel=2e-16)
    assert conversion("km/h", "m/s")[0] == pytest.approx(1.0 / 3.6, rel=2e-16)
    assert conversion("m^3/(s*Pa^0.5)", "m^3/s/bar^0.5")[0] == pytest.approx(316.22776601683796, rel=4e-16)
    assert conversion("%", "") == (0.01, 0.0, 1.0)


@pytest.mark.parametrize(
    "text", ["", "cubit", "m^", "m**", "(m", "m)", "/s", "m*", "m^9^9", "degC/m", "(m/s)^2", "s-1", "GPa^99", "11"]
)
def test_what_is_not_known_is_left_to_pint(text: str) -> None:
    assert known_unit(text) is None
    assert conversion(text or "?", "m") is None


def test_other_dimensions_are_refused():
    with pytest.raises(ValueError, match="bar is not m"):
        conversion("bar", "m")


def test_a_unit_that_only_pint_knows_is_one():
    assert is_unit("furlong") and not is_unit("cubits_of_nothing")


def test_a_shipped_system_is_read_without_pint():
    code = "import sys; from vvdp.systems.system import load_system as l; l('prototype'); print('pint' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"
