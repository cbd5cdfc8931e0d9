"""Circuits whose oil boils, or loses and gains free air: what is in them, and that both books close."""

import numpy as np
import pytest
from scipy.optimize import brentq

from vvdp.base.signal import step, table
from vvdp.components.library import UsualOil
from vvdp.components.lines import LINE
from vvdp.components.machines import PUMP
from vvdp.components.pipes import add_pipe
from vvdp.components.resistances import ORIFICE
from vvdp.components.rods import LOAD_FORCE, PLUNGER
from vvdp.fluid.dissolving import equilibrium_air
from vvdp.fluid.mixture import aerated_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.line import Line
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pipe import LinePipe
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.volume import Vessel
from vvdp.network.build import Circuit, build
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.simulation.balance import balance
from vvdp.simulation.run import Run, Stepping, simulate

ATMOSPHERE = 101325.0
BOILING = {"vapour_pressure": 1e4}
DISSOLVING = {"bunsen_coefficient": 0.09, "dissolving_time": 0.05, "release_time": 0.01}


def suction(oil: Oil) -> Circuit:
    """A pump behind three metres of suction line that is suddenly turned three times as fast."""
    net = Network(oil)
    net.tank("tank")
    net.volume("inlet", Chamber(volume=2e-4), start=ATMOSPHERE)
    net.volume("outlet", Chamber(volume=5e-4), start=1e6)
    net.driven_shaft("shaft", step(100.0, 300.0, 0.05))
    net.add("suction", LINE, Line(length=3.0, diameter=0.02), a="tank", b="inlet")
    pump = Pump(displacement=3.63e-6, leakage_conductance=0.0, friction_torque=0.0)
    net.add("pump", PUMP, pump, inlet="inlet", outlet="outlet", shaft="shaft")
    net.add("load", ORIFICE, Orifice(), a="outlet", b="tank", area=6e-6)
    return build(net)


def pulled(oil: Oil) -> Circuit:
    """A closed cylinder from which a load is pulled, and into which it falls back."""
    net = Network(oil)
    net.tank("tank")
    net.volume("chamber", Chamber(volume=1e-4), start=20e5)
    net.rod("rod", position=0.1)
    net.add("cylinder", PLUNGER, Plunger(area_a=1e-3, moving_mass=20.0), a="chamber", rod="rod")
    force = table([0.0, 0.02, 0.02, 0.06, 0.06, 0.2], [-1900.0, -1900.0, 600.0, 600.0, -1900.0, -1900.0])
    net.add("load", LOAD_FORCE, rod="rod", force=force)
    net.add("leak", ORIFICE, Orifice(), a="tank", b="chamber", area=2e-7)
    return build(net)


def run(circuit: Circuit, until: float, tolerance: float = 1e-7) -> Run:
    stepping = Stepping(until=until, record_interval=1e-3, relative_tolerance=tolerance)
    return simulate(circuit.model, circuit.case, stepping)


@pytest.mark.parametrize("drawn", [suction, pulled])
@pytest.mark.parametrize(
    "options",
    [
        BOILING,
        DISSOLVING,
        BOILING | DISSOLVING,
        {"vapour_pressure": 1e3, "air_fraction": 0.0},
        {"bulk_modulus_slope": 11.0, "vapour_pressure": 5e4},
    ],
)
def test_both_books_close_where_oil_cavitates(drawn, options):
    found = run(drawn(UsualOil(**options)), 0.2)
    books = balance(found)
    assert abs(books.energy_residual) < 1e-6 and abs(books.mass_residual) < 1e-6
    lowest = found.low[0]
    assert 0.0 < lowest < ATMOSPHERE


def test_vapour_keeps_the_pressure_up_and_is_reported():
    """Without vapour and air the pressure would fall far below that of vapour; with it, the cylinder draws a void."""
    boiling = run(pulled(UsualOil(air_fraction=0.0, vapour_pressure=5e3)), 0.05)
    assert 0.2 * 5e3 < boiling.low[0] < 5e3
    vapour = boiling.outputs.chamber_vapour
    assert vapour.max() == pytest.approx(1e-3 * (boiling.state.rod.position.max() - 0.1), rel=0.05)
    assert vapour[0] == 0.0


def test_air_in_a_closed_volume_comes_to_rest_where_henry_has_it():
    """Mass and volume of a rigid chamber are given; its pressure falls until the free air is that of equilibrium."""
    oil = UsualOil(air_fraction=0.05, **DISSOLVING)
    net = Network(oil)
    net.tank("tank")
    net.volume("chamber", Chamber(volume=1e-3), start=1.5e5)
    net.add("shut", ORIFICE, Orifice(), a="tank", b="chamber", area=0.0)
    found = run(build(net), 3.0)
    held = 1.0 / aerated_state(1.5e5, 0.05, oil).volume_ratio

    def surplus(pressure: float) -> float:
        return held * aerated_state(pressure, equilibrium_air(pressure, oil), oil).volume_ratio - 1.0

    rest = brentq(surplus, 2e4, 2e5)
    assert 0.0 < equilibrium_air(rest, oil) < 0.05
    assert found.final_state.chamber == pytest.approx(rest, rel=1e-6)
    assert found.final_state.chamber_air == pytest.approx(equilibrium_air(rest, oil), rel=1e-5)
    assert found.final_state.books.spent.chamber_air > 0.0  # what was strained and is no more
    assert balance(found).is_trusted


def test_air_dissolves_at_its_time_constant():
    """In a vessel whose gas holds the pressure, free air falls as e^(-t/tau)."""
    oil = UsualOil(**(DISSOLVING | {"dissolving_time": 0.2}))
    net = Network(oil)
    net.tank("tank")
    vessel = Vessel(oil_volume=1e-5, hose_compliance=0.0, gas_volume=0.5, precharge_pressure=20e5, gas_exponent=1.0)
    net.volume("vessel", vessel, start=50e5)
    net.add("shut", ORIFICE, Orifice(), a="tank", b="vessel", area=0.0)
    circuit = build(net)
    found = run(circuit, 0.4)
    assert found.final_state.vessel_air == pytest.approx(0.01 * np.exp(-2.0), rel=1e-4)
    assert balance(found).is_trusted


def test_a_pump_draws_air_out_of_its_oil_and_the_line_behind_dissolves_it():
    found = run(suction(UsualOil(**DISSOLVING)), 0.3).final_state
    assert found.inlet < ATMOSPHERE < found.outlet
    assert found.inlet_air > 0.01 > found.outlet_air


def test_a_pipe_of_boiling_and_dissolving_oil():
    net = Network(UsualOil(**BOILING, **DISSOLVING))
    net.tank("tank")
    net.pressure_source("source", step(3e5, 2e4, 0.01))
    add_pipe(net, "pipe", LinePipe(length=5.0, diameter=0.01, hose_compliance=1e-10), {"a": "source", "b": "tank"}, 2e5)
    found = run(build(net), 0.1)
    assert balance(found).is_trusted
    assert found.final_state.pipe_1_air != 0.01


def test_plain_oils_have_none_of_it():
    text = suction(UsualOil()).text
    assert "air" not in text and "vapour" not in text


def test_a_run_keeps_the_modulus_of_its_first_temperature():
    oil = UsualOil(bulk_modulus_fall=5.5e-3)
    net = Network(oil, temperature=step(333.15, 313.15, 0.1))
    net.tank("tank")
    net.volume("chamber", Chamber(volume=1e-3), start=1e5, oil=oil)
    net.add("shut", ORIFICE, Orifice(), a="tank", b="chamber", area=0.0)
    params = build(net).case.params
    assert params.oil.liquid_bulk_modulus == pytest.approx(1.4e9 * np.exp(-0.11), rel=1e-12)
    assert not hasattr(params, "chamber_oil")
