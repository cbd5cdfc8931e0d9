"""The examples in the descriptions of formulas print what they say."""

import doctest

import pytest

from vvdp.fluid.oil import Oil
from vvdp.valve.rotary import RotaryValve

FEWEST = 20
"""Formulas with an example, at least."""
OIL = Oil(
    density=876.0,
    thermal_expansion=7e-4,
    viscosity_40=44.178e-6,
    viscosity_100=6.65e-6,
    liquid_bulk_modulus=1.4e9,
    air_fraction=0.01,
    polytropic_exponent=1.4,
    reference_pressure=101325.0,
    pressure_viscosity=2e-8,
)
VALVE = RotaryValve(
    spool_radius=12.7e-3,
    sections=3.0,
    nozzle_area=36.5e-6,
    nozzle_discharge_coefficient=0.61,
    centre_coefficient=1.45e-6,
    centre_flow_exponent=1.91,
    centre_diameter_exponent=3.22,
    outlet_area=46.8e-6,
    outlet_discharge_coefficient=0.677,
    outlet_effective_area=61.8e-6,
    rail_coefficient=0.0,
    inlet_radius=12.7e-3,
    outlet_radius=12.7e-3,
    helix_length=20.32e-3,
    lap_ratio=1.0,
    radial_clearance=12.7e-6,
    friction_area=2.716e-3,
    spool_mass=0.5,
    jet_exponent=0.0,
    land_length=10e-3,
    eccentricity=0.0,
    transition_pressure=5e3,
)
"""What the examples call `oil` (grade 46 with 1 % air) and `valve` (the one that was built)."""


@pytest.fixture(scope="module")
def examples(formula_modules) -> list[doctest.DocTest]:
    finder = doctest.DocTestFinder(recurse=True, exclude_empty=True)
    given = {"oil": OIL, "valve": VALVE}
    return [each for module in formula_modules for each in finder.find(module, extraglobs=given)]


def test_examples_print_what_they_say(examples):
    said: list[str] = []
    runner = doctest.DocTestRunner(verbose=False)
    for example in examples:
        runner.run(example, out=said.append, clear_globs=False)
    assert not said, "".join(said)


def test_the_main_formulas_have_an_example(examples):
    assert len(examples) >= FEWEST
