"""What rotary valves add to the numbers of circuits that a file draws."""

import math
import tomllib
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.quantities import quantities
from vvdp.evaluation.summary import summary
from vvdp.evaluation.validity import bounds
from vvdp.evaluation.valve_forms import unit_forms
from vvdp.evaluation.valve_numbers import placed_valves
from vvdp.evaluation.valve_unit import valve_unit
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system, load_system
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


def driven(speed):
    """The same unit, its spool turned by a motor."""
    part = tomllib.loads(resources.files("vvdp.systems").joinpath("parts", "pump-unit.toml").read_text("utf-8"))
    nodes = {
        "tank": {"type": "tank"},
        "load": {"type": "pressure-source", "pressure": "70 bar"},
        "shaft": {"type": "driven-shaft", "speed": "1800 rpm"},
        "spool": {"type": "driven-shaft", "speed": speed},
    }
    run = {"until": "0.3 s", "average_from": "0.2 s"}
    circuit = {"nodes": part["nodes"] | nodes, "components": part["components"], "run": run}
    return built_system(Table("driven", circuit, {}), "driven")


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


@pytest.mark.parametrize(
    ("speed", "mean", "fastest"),
    [
        ("1500 rpm", 75.0, 75.0),
        ({"ramp": ["1200 rpm", "1800 rpm"], "from": "0 s", "to": "0.3 s"}, 8.0 / (math.sqrt(0.8) - 0.8), 90.0),
    ],
)
def test_a_spool_may_be_turned_by_a_motor(speed, mean, fastest):
    """Three periods in a turn: 75 Hz at 1500 rpm. Of the ramp 60 t + 50 t^2 have passed, 14 at 0.2 s; the mean is over
    whole periods, 8 until 0.3 s."""
    system = driven(speed)
    found = numbers(system)
    assert found["valve_pwm_frequency_Hz"] == pytest.approx(mean, rel=1e-9)
    assert 3.0 * found["speed_max_spool_rad_s"] / (2.0 * math.pi) == pytest.approx(fastest, rel=1e-12)
    assert "speed_max_spool_rad_s" in quantities(system) and "speed_max_shaft_rad_s" not in found


def test_efficiency_is_what_reaches_the_load_of_what_the_shaft_takes(half):
    """By the pressure source, which the losses inside of the unit do not know of."""
    system, found = half
    assert found["unit_efficiency"] == pytest.approx(-found["power_line_W"] / found["power_motor_W"], abs=1e-5)
    assert 0.4 < found["unit_efficiency"] < 0.6
    assert "unit_efficiency" in quantities(system)


def test_efficiency_with_a_spool_that_a_motor_turns():
    """What the turbine gives its motor comes off the power put in."""
    found = numbers(driven("1500 rpm"))
    put_in = found["power_shaft_W"] + found["power_spool_W"]
    assert found["valve_efficiency"] == pytest.approx(-found["power_load_W"] / put_in, abs=1e-5)


def test_two_pumps_on_one_shaft_have_no_efficiency_each():
    """What one of them takes of the shaft is not known."""
    system = load_system("two-cylinders", until="0.05 s")
    assert not [key for key in numbers(system) if key.endswith("_efficiency")]


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


def test_the_unit_is_found_in_the_network(half):
    """Its own values, pump and relief valve: 1800 rpm, 10 of 20 mm, 70 bar at the load, as the file has them."""
    found = valve_unit(half[0], "valve")
    assert found.nominal_flow == pytest.approx(22.8e-6 * 30.0, rel=1e-9)
    assert (found.duty_ratio, found.inlet_volume) == pytest.approx((0.5, 12.7e-6))
    assert found.load_pressure == pytest.approx(70e5 + 101325.0)
    assert found.relief_valve.cracking_pressure == pytest.approx(120e5 + 101325.0)
    assert not found.makes_pressure and not found.is_softened


@pytest.mark.parametrize("name", ["prototype", "prototype-constant-load", "vvdp-duty-control"])
def test_the_bench_says_what_is_found_in_the_network(name):
    system = load_system(name)
    found, said = valve_unit(system, "valve"), rotary_bench(system, "valve").unit
    assert vars(found.oil) == vars(said.oil)
    assert replace(found, oil=said.oil) == said


def test_of_several_one_is_asked_for():
    system = load_system("two-cylinders")
    assert valve_unit(system, "valve", "swing_unit").duty_ratio == pytest.approx(0.3)
    assert valve_unit(system, "valve", "lift_unit").duty_ratio == pytest.approx(0.5)
    with pytest.raises(ConfigError, match="give --part, one of lift_unit, swing_unit"):
        valve_unit(system, "valve")
    with pytest.raises(ConfigError, match="did you mean 'lift_unit'"):
        valve_unit(system, "valve", "lift_unt")


def test_closed_forms_stand_beside_the_run(half):
    """Frequency within 5 %, loss an upper estimate, flow as the ports share it; no form where something changes."""
    system, found = half
    assert found["unit_analytic_load_flow_m3_s"] == pytest.approx(found["flow_mean_unit_valve_load_m3_s"], rel=2e-3)
    assert found["unit_analytic_pwm_frequency_Hz"] == pytest.approx(found["unit_pwm_frequency_Hz"], rel=0.06)
    assert 0.95 < found["unit_analytic_loss_total_W"] / found["loss_unit_W"] < 1.08
    assert found["unit_analytic_loss_leakage_W"] == pytest.approx(found["loss_unit_valve_leakage_W"], rel=0.01)
    assert {key for key in found if "analytic" in key} <= quantities(system).keys()
    ramp = {"ramp": ["9 mm", "10 mm"], "from": "0 s", "to": "0.3 s"}
    assert not [key for key in numbers(unit(axial_position=ramp)) if "analytic" in key]
    assert not [key for key in numbers(driven("1500 rpm")) if "analytic" in key]


def test_forms_are_those_of_the_bench():
    """The same unit as a bench and drawn: the same numbers at the same mean load pressure."""
    bench = load_system("prototype-constant-load", until="0.5 s")
    own = numbers(bench)
    alone = unit_forms(valve_unit(bench, "run"), own["pressure_mean_load_line_Pa"] + 101325.0)
    assert alone == {key: own[key] for key in alone} and len(alone) == 9
