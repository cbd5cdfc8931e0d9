"""What rotary valves add to the numbers of circuits that a file draws."""

import math

import numpy as np
import pytest

from vvdp.base.tables import Table
from vvdp.simulation.run import simulate
from vvdp.systems.quantities import quantities
from vvdp.systems.summary import summary
from vvdp.systems.system import built_system, load_system
from vvdp.systems.validity import bounds
from vvdp.systems.valve_numbers import placed_valves
from vvdp.valve.geometry import port_openings


def unit(**values):
    """A pump unit of its own against a pressure source of 70 bar."""
    circuit = {
        "nodes": {
            "tank": {"type": "tank"},
            "line": {"type": "pressure-source", "pressure": "70 bar"},
            "motor": {"type": "driven-shaft", "speed": "1800 rpm"},
        },
        "parts": {
            "unit": {
                "type": "pump-unit", "load": "line", "tank": "tank", "shaft": "motor", "axial_position": "10 mm",
            }
            | values
        },
        "run": {"until": "0.3 s", "average_from": "0.2 s"},
    }  # fmt: skip
    return built_system(Table("unit", circuit, {}), "unit")


def numbers(system):
    return summary(system, simulate(system.model, system.case, system.stepping))


@pytest.fixture(scope="module")
def half():
    system = unit()
    return system, numbers(system)


def test_frequency_is_that_of_the_spool_and_losses_add_up_to_the_drops(half):
    """By hand: three sections, so three periods in a turn; what is not lost fully open is lost by transition."""
    system, found = half
    assert found["unit_pwm_frequency_Hz"] == pytest.approx(
        3.0 * found["speed_mean_unit_spool_rad_s"] / (2.0 * math.pi), rel=1e-12
    )
    drops = sum(found[f"loss_unit_valve_{part}_W"] for part in ("nozzle", "centre_section", "outlet_turbine"))
    beyond = found["loss_unit_full_open_W"] + found["loss_unit_transition_W"]
    assert beyond == pytest.approx(drops, rel=1e-12)
    assert {"unit_pwm_frequency_Hz", "unit_load_opening"} <= quantities(system).keys()


def test_the_load_port_is_open_as_its_geometry_says(half):
    """Mean over a turn of the spool at 10 mm; over time a little else, as the spool is not evenly fast."""
    system, found = half
    valve = next(placed_valves(system.circuit.network)).values
    angles = np.linspace(0.0, 2.0 * np.pi, 3600, endpoint=False)
    opening = np.mean([port_openings(angle, 0.010, valve).load for angle in angles])
    assert found["unit_load_opening"] == pytest.approx(opening, abs=0.02)


def test_the_laws_of_the_valve_have_their_bounds_by_the_name_of_the_part(half):
    system, found = half
    labels = [bound.label for bound in bounds(system, found)]
    assert "Taylor number of the clearance of unit" in labels
    assert "Reynolds number of the nozzles of unit" in labels


def test_a_system_that_tells_its_own_numbers_tells_them_once():
    system = load_system("prototype-constant-load", until="0.1 s")
    assert "valve_pwm_frequency_Hz" not in numbers(system)
