"""Laws of a drop come back from what they gave."""

import math

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.numerics.power_laws import drop_laws

FLOWS = np.array([10.0, 20.0, 40.0, 60.0]) / 60e3


def test_an_exact_law_is_found_with_no_scatter():
    laws = drop_laws(FLOWS, 1.3e8 * FLOWS + 9.1e11 * FLOWS**2)
    assert laws.two_term.coefficients == pytest.approx([1.3e8, 9.1e11])
    assert laws.two_term.half_widths == pytest.approx([0.0, 0.0], abs=1e3)
    laws = drop_laws(FLOWS, 7e11 * FLOWS**2)
    assert laws.orifice.coefficients == pytest.approx([7e11])
    assert laws.power.coefficients == pytest.approx([math.log(7e11), 2.0])
    assert laws.two_term.coefficients[0] == pytest.approx(0.0, abs=1e-3)


def test_too_few_values_are_refused():
    with pytest.raises(ParameterError, match="2 values; a law with 2 coefficients needs more"):
        drop_laws(FLOWS[:2], FLOWS[:2] ** 2)
