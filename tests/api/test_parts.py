"""Values of parts from a script."""

import pytest

import vvdp


def test_values_of_parts_are_numbers_in_si_or_texts():
    found = vvdp.load("two-cylinders", parts={"lift.force": -7e3, "lift_unit.displacement": "20 cc/rev"})
    values = {row.setting: row.nominal for row in found.rows}
    assert values["components.lift_load.force"] == -7e3
    assert values["components.lift_unit_pump.displacement"] == pytest.approx(20e-6 / 6.283185307179586)
