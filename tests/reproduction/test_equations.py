"""The table of the numbered equations: what it names exists; and equations that no other test works out."""

import ast
import csv
import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from vvdp.control.capacities import capacities
from vvdp.control.chamber import ChamberReading, desired_pressure
from vvdp.control.cylinder_force import Motion, desired_force
from vvdp.control.cylinder_storage import force_measure
from vvdp.control.reference import Reference
from vvdp.fluid.modulus import specific_volume_exponent, yu_bulk_modulus
from vvdp.reproduction.chapter_5.chamber import experiment, known_drive, law_of
from vvdp.reproduction.chapter_5.compressed_oil import aerated_oil
from vvdp.reproduction.chapter_6.cylinder import nominal_settings

ROOT = Path(__file__).parents[2]
NUMBERED = {2: 10, 3: 10, 4: 25, 5: 69, 6: 41}
UNUSED = {"4.21", "4.22", "4.23"}
"""Equations that nothing in the code uses, each with a reason in the table."""


@pytest.fixture(scope="module")
def equations():
    return list(csv.DictReader((ROOT / "docs" / "equations.csv").read_text("utf-8").splitlines()))


@pytest.fixture(scope="module")
def tests():
    """The source of the file of each test, by name."""
    found = {}
    for path in (ROOT / "tests").rglob("test_*.py"):
        text = path.read_text("utf-8")
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                found.setdefault(node.name, []).append(text)
    return found


@pytest.fixture(scope="module")
def page():
    """The module that writes the page."""
    sys.path.insert(0, str(ROOT / "docs" / "site"))
    return importlib.import_module("equations")


def test_every_numbered_equation_has_a_line(equations):
    numbers = [f"{chapter}.{place}" for chapter, count in NUMBERED.items() for place in range(1, count + 1)]
    assert [each["equation"] for each in equations] == numbers and len(numbers) == 155


def test_every_line_has_tests_and_a_place_or_a_reason(equations):
    assert [each["equation"] for each in equations if not each["tests"]] == []
    assert all(bool(each["code"]) is not bool(each["reason"]) for each in equations)
    assert {each["equation"] for each in equations if not each["code"]} == UNUSED


def test_the_code_that_is_named_exists(equations):
    for module, _, name in (each["code"].partition(":") for each in equations if each["code"]):
        assert callable(getattr(importlib.import_module(module), name)), f"{module}:{name}"


def test_the_tests_that_are_named_exist_once(equations, tests):
    named = {test for each in equations for test in each["tests"].split()}
    assert {name: len(tests.get(name, [])) for name in named if len(tests.get(name, [])) != 1} == {}


def test_the_code_that_is_named_stands_beside_a_test_that_is_named(equations, tests):
    """Its name, or for an item of the reproduction the item's, occurs in the file of one of the tests."""

    def names(code):
        name = code.partition(":")[2]
        return rf"\b{name}\b|\b{name.replace('_', '-', 1).replace('_', '.')}\b"

    def is_beside(each):
        return any(re.search(names(each["code"]), tests[test][0]) for test in each["tests"].split())

    assert [each["equation"] for each in equations if each["code"] and not is_beside(each)] == []


def test_what_is_corrected_is_an_erratum_and_what_is_an_erratum_is_corrected(equations, page):
    """A change of either alone fails; each link leads to a heading of the errata."""
    errata = (ROOT / "docs" / "errata.md").read_text("utf-8")
    assert {each["form"] for each in equations} == {"printed", "corrected"}
    corrected = {each["equation"] for each in equations if each["form"] == "corrected"}
    assert page.corrections(errata).keys() == corrected


def test_places_of_errata_by_hand(page):
    assert page.equations_of("(4.21) to (4.23)") == ["4.21", "4.22", "4.23"]
    assert page.equations_of("(5.35), (5.36), below (5.66)") == ["5.35", "5.36"]
    assert page.equations_of("proof of (5.1), (5.25)") == page.equations_of("4.3.2") == []
    assert page.anchor("The dissertation (wang2017), chapters 1 and 2") == "the-dissertation-wang2017-chapters-1-and-2"


def test_links_lead_to_headings_as_the_site_names_them(page):
    toc = pytest.importorskip("markdown.extensions.toc")
    headings = set(page.corrections((ROOT / "docs" / "errata.md").read_text("utf-8")).values())
    assert {page.anchor(each) for each in headings} == {toc.slugify(each, "-") for each in headings}


def test_the_page_is_that_of_the_table(page):
    assert (ROOT / "docs" / "equations.md").read_text("utf-8") == page.page_text()


def test_density_exponents_add_up_and_change_sign():
    """(5.6), (5.7): g(P3, P2) + g(P2, P1) = g(P3, P1), and g(P1, P2) = -g(P2, P1)."""
    low, middle, high, oil = 1e5, 14e5, 350e5, aerated_oil(0.1)

    def g(end, begin):
        return specific_volume_exponent(end, begin, yu_bulk_modulus, oil)

    assert g(high, middle) + g(middle, low) == pytest.approx(g(high, low), rel=1e-9)
    assert g(low, high) == pytest.approx(-g(high, low), rel=1e-9)


@pytest.mark.parametrize("error", [-3e5, 0.0, 2e5])
def test_velocity_error_moves_by_the_pressure_error(error):
    """(5.30): M e_v' = -(K + K_p) e - K_v e_v + A (P - P_d), the motion (5.1) under the pressure (5.29)."""
    drive, gains = known_drive(), law_of(experiment()).gains
    reference, place, speed = Reference(2.75e-3, 0.02, 0.5, 3.0), 2.77e-3, 0.021
    wanted = desired_pressure(reference, ChamberReading(place, speed, 13e5), gains, drive)
    pressure = wanted.pressure + error
    force = drive.area * (pressure - drive.oil.reference_pressure) - drive.stiffness * place - drive.preload
    r_rate = reference.acceleration - gains.error_rate * (speed - reference.velocity)
    restoring = (drive.stiffness + gains.position_gain) * wanted.position_error
    damping = gains.velocity_gain * wanted.velocity_error
    left = force - drive.moving_mass * r_rate
    assert left == pytest.approx(-restoring - damping + drive.area * error, abs=1e-9)


@pytest.mark.parametrize("error", [-5e3, 0.0, 2e3])
def test_velocity_error_of_the_cylinder_moves_by_the_force_error(error):
    """(6.7) with (6.9): m e_v' = F_H - F_v - K_v e_v - K_p e, the motion (6.1) without disturbance."""
    settings = nominal_settings()
    cylinder, gains = settings.cylinder, settings.gains
    motion = Motion(0.15, 0.04, -1000.0, 300.0)
    reference = Reference(0.149, 0.05, 0.3, 0.0)
    wanted = desired_force(reference, motion, 0.0, gains, cylinder)
    moved = wanted.force + error - cylinder.viscous_friction * motion.velocity + motion.load_force
    left = moved - motion.moving_mass * wanted.reference_acceleration
    restoring = gains.velocity_gain * wanted.velocity_error + gains.position_gain * wanted.position_error
    assert left == pytest.approx(error - restoring, rel=1e-9, abs=1e-9)


def test_stiffness_takes_its_mean_between_both_positions():
    """(6.15): h(x) - h(x_fd) = L(alpha) (x - x_fd) for an alpha between both."""
    cylinder = nominal_settings().cylinder
    begin, end = 0.05, 0.12
    slope = (force_measure(end, cylinder) - force_measure(begin, cylinder)) / (end - begin)
    between = [
        capacities(1.0, x, 1e5, cylinder).stiffness / cylinder.bulk_modulus
        for x in np.linspace(begin, end, 50).tolist()
    ]
    assert min(between) < slope < max(between)
