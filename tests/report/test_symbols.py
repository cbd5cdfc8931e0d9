"""Symbols and diagrams are well-formed drawings, and show what is fitted."""

import xml.etree.ElementTree as ET

import pytest

from vvdp.report import symbols
from vvdp.report.bench_diagram import HEIGHT, WIDTH, circuit_diagram
from vvdp.report.reading import Reading, reading
from vvdp.systems.system import load_system

SYMBOLS = {
    "tank": symbols.tank(50, 60),
    "pump": symbols.pump(50, 60),
    "motor": symbols.electric_motor(50, 60),
    "shaft": symbols.shaft(10, 40, 20),
    "relief valve": symbols.relief_valve(80, 80),
    "rotary valve": symbols.rotary_valve(90, 90),
    "rotary drive": symbols.rotary_drive(60, 60),
    "set position": symbols.set_position(60, 60),
    "check valve": symbols.check_valve(50, 50),
    "hose": symbols.hose(10, 80, 20),
    "accumulator": symbols.accumulator(40, 80),
    "gauge": symbols.gauge(40, 80),
    "throttle": symbols.throttle(40, 80),
    "adjustable throttle": symbols.throttle(40, 80, adjustable=True),
    "pressure source": symbols.pressure_source(40, 10),
    "label": symbols.label(0, 0, ["<A & B>", "two"]),
}


@pytest.mark.parametrize("name", SYMBOLS)
def test_a_symbol_is_valid(name):
    assert len(ET.fromstring(f"<svg>{SYMBOLS[name]}</svg>")) > 0


def diagram(whole, *settings):
    return circuit_diagram(Reading(reading(whole).results, load_system("prototype", list(settings))))


def test_fitted_parts_are_drawn_and_others_are_not(whole):
    plain = diagram(whole)
    assert "Accumulator" in plain and "Check valve" not in plain
    assert "Check valve" in diagram(whole, "check_valve.reverse_opening=0")
    assert "Accumulator" not in diagram(whole, "load_line.gas_volume=0 cc")


def test_a_diagram_lies_within_its_sheet(whole):
    tree = ET.fromstring(diagram(whole, "check_valve.reverse_opening=0"))
    for line in tree.iter("{http://www.w3.org/2000/svg}polyline"):
        for point in line.get("points").split():
            x, y = map(float, point.split(","))
            assert 0 <= x <= WIDTH and 0 <= y <= HEIGHT


def test_values_of_the_system_stand_in_it(whole):
    text = diagram(whole, "relief_valve.cracking_pressure=140 bar")
    assert "140 bar" in text and "22.22 cm³/rev" in text and "12.7 cm³" in text and "1800 rpm" in text
