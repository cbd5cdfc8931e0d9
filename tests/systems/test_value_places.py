"""Values of a drawn rig changed among its parameters: as if they stood in its file."""

import pytest

from vvdp.base.errors import ParameterError
from vvdp.evaluation.bench import rotary_bench
from vvdp.systems.changed import with_numbers
from vvdp.systems.system import load_system
from vvdp.systems.value_places import value_place

NUMBERS = {
    "oil.density": 870.0,
    "pump.displacement": 3e-6,
    "inlet.volume": 2e-5,
    "relief_valve.override_pressure": 5e5,
    "valve.helix_length": 0.02,
    "spool_drive.coupling": 0.01,
    "check_valve.rated_drop": 2e4,
    "load.pressure": 9e6,
    "operation.pump_speed": 150.0,
    "operation.oil_temperature": 320.0,
    "operation.duty_ratio": 0.4,
    "operation.spool_motor_speed": 10.0,
    "operation.tank_pressure": 2e5,
    "initial.inlet_pressure": 6e6,
    "initial.spool_speed": 120.0,
    "initial.spool_angle": 0.5,
}


@pytest.fixture(scope="module")
def bench():
    return rotary_bench(load_system("prototype-constant-load"), "test")


@pytest.mark.parametrize("path", NUMBERS)
def test_a_value_goes_where_the_file_puts_it(bench, path):
    changed = bench.with_values({path: NUMBERS[path]})
    written = with_numbers(bench.system, {path: NUMBERS[path]})
    assert changed.params == written.case.params != bench.params
    assert changed.case.state == written.case.state


def test_what_is_changed_twice_has_the_last_value(bench):
    twice = bench.with_values({"oil.density": 860.0, "valve.lap_ratio": 0.9}).with_values({"oil.density": 870.0})
    assert (twice.oil.density, twice.valve.lap_ratio) == (870.0, 0.9)


def test_a_value_that_stands_in_no_equation_is_changed_beside_others(bench):
    """The rated power of the motor; what was changed before stays."""
    changed = bench.with_values({"oil.density": 860.0}).with_values({"motor.rated_power": 5e3, "valve.lap_ratio": 0.9})
    assert changed.rated_power == pytest.approx(5e3)
    assert bench.with_values({"nodes.pump_shaft.rated_power": 6e3}).rated_power == pytest.approx(6e3)
    assert (changed.oil.density, changed.valve.lap_ratio) == (860.0, 0.9)


@pytest.mark.parametrize("path", ["components.valve.size", "nodes.nothing.start", "programs.encoder.sectors"])
def test_a_path_that_leads_to_no_value_is_refused(bench, path):
    with pytest.raises(ParameterError, match=f"{path}: the circuit has no such value"):
        value_place(bench.system.circuit, path)
