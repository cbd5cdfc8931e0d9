"""Symbols and diagrams are well-formed drawings, and show what is fitted."""

import xml.etree.ElementTree as ET

import pytest

from vvdp.report import symbols
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
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


def drawn(*settings):
    network = load_system("prototype", list(settings)).circuit.network
    return diagram(graph_of(network, "Prototype"))


def test_what_is_fitted_is_drawn():
    assert "gas 50 cm³" in drawn()
    assert "gas" not in drawn("load_line.gas_volume=0 cc")


def test_values_of_the_system_stand_in_it():
    text = drawn("relief_valve.cracking_pressure=140 bar")
    assert "140 bar" in text and "22.8 cm³/rev" in text and "12.7 cm³" in text and "1800 rpm" in text
    assert "area: 3.041 mm²" in text
