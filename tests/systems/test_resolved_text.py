"""The resolved text of a system loads again to an equal system."""

import numpy as np
import pytest

from vvdp.base.tables import parsed_table
from vvdp.simulation.values import flat
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import built_system, load_system, shipped_systems

BENCHES = ("prototype", "prototype-constant-load")
SETTINGS = [
    'pump.friction_torque="0.5 N*m"',
    'operation.pump_speed={step=["1200 rpm", "1800 rpm"], at="0.1 s"}',
    'operation.oil_temperature={table=[["0 s", "20 degC"], ["1 s", "60 degC"]]}',
    'operation.duty_ratio={sine=0.5, amplitude=0.1, frequency="5 Hz", note="quote \\" backslash \\\\ é"}',
    "relief_valve.cracking_pressure=90 bar",
]


def again(system):
    return built_system(parsed_table(resolved_text(system), "again.toml"), system.name)


def same(a, b):
    assert a.case == b.case
    assert np.array_equal(flat(a.case.params), flat(b.case.params))
    assert (a.rows, a.stepping, a.average_from, a.title) == (b.rows, b.stepping, b.average_from, b.title)
    assert a.circuit.digest == b.circuit.digest


@pytest.mark.parametrize(
    ("name", "settings"), [*((name, []) for name in shipped_systems()), *((n, SETTINGS) for n in BENCHES)]
)
def test_it_loads_to_the_same_system(name, settings):
    system = load_system(name, settings, until="0.3 s")
    same(system, again(system))
    assert resolved_text(again(system)) == resolved_text(system)


def test_a_setting_is_marked_as_given_and_the_rest_keeps_its_origin():
    text = resolved_text(load_system("prototype", ["pump.friction_torque=0.5 N*m"]))
    assert 'friction_torque = { value = "0.5 N*m", status = "given" }' in text
    assert 'nozzle_discharge_coefficient = { value = "0.61", range = ["0.58", "0.64"], status = "published"' in text


def test_the_method_and_an_axial_position_are_kept():
    system = load_system("prototype", ["run.method=stiff"])
    same(system, again(system))
    table = system.content["operation"] | {"axial_position": "10 mm"}
    del table["duty_ratio"]
    content = {**system.content, "operation": table}
    axial = built_system(type(parsed_table("a = 1", ""))("x", content, {}), "x")
    same(axial, again(axial))
