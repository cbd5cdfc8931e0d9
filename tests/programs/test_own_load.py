"""A load of a circuit as an FMU that vvdp exported, beside the same load in one system."""

import numpy as np
import pytest
from tests.generator.c_way import compilers

from vvdp.export.fmu import fmu
from vvdp.export.fmu_model import fmu_model
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

pytestmark = pytest.mark.skipif(not compilers(), reason="no C compiler")
RUN = """
[run]
until = "0.5 s"
sample_period = "PERIOD"
record_interval = "1 ms"
window = "0 s"
"""
LOAD = """
title = "A chamber behind a throttle"
[components]
inlet = { type = "orifice", a = "supply", b = "chamber", area = "8 mm^2" }
outlet = { type = "orifice", a = "chamber", b = "tank", area = "6 mm^2" }
[nodes]
tank = { type = "tank" }
supply = { type = "pressure-source", pressure = "50 bar" }
chamber = { type = "volume", volume = "2 l", start = "0 bar" }
"""
WHOLE = """
title = "A pump with this load"
[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = FLOW }
bypass = { type = "orifice", a = "line", b = "tank", area = "1 mm^2" }
inlet = { type = "orifice", a = "line", b = "chamber", area = "8 mm^2" }
outlet = { type = "orifice", a = "chamber", b = "tank", area = "6 mm^2" }
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }
chamber = { type = "volume", volume = "2 l", start = "0 bar" }
"""
PARTED = """
title = "A pump whose load is an FMU"
[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = FLOW }
bypass = { type = "orifice", a = "line", b = "tank", area = "1 mm^2" }
draw = { type = "flow-source", a = "line", b = "tank", flow = { from = "load.flow" } }
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "0 bar" }
[programs.load]
fmu = "load.fmu"
inputs = { pressure = "nodes.supply.pressure" }
outputs = { flow = "inlet_flow" }
power = { flow = "pressure" }
pressure = "line.pressure"
period = "PERIOD"
"""
FLOW = '{ sine = "20 lpm", amplitude = "5 lpm", frequency = "10 Hz" }'


def run_of(folder, name, text, period):
    path = folder / f"{name}.toml"
    path.write_text((text + RUN).replace("FLOW", FLOW).replace("PERIOD", period))
    system = load_system(str(path))
    return simulate(system.model, system.case, system.stepping)


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=pytest.mark.thorough), 3])
def test_it_is_within_a_hundredth_of_the_same_load_in_one_system(fmi, tmp_path):
    """The flow is held for a period, so that the pressure is off in proportion to it, and so is the energy."""
    (tmp_path / "load.toml").write_text((LOAD + RUN).replace("PERIOD", "1 ms"))
    (tmp_path / "load.fmu").write_bytes(fmu(fmu_model(load_system(str(tmp_path / "load.toml"))), fmi).content)
    off, energies = [], []
    for period in ("1 ms", "0.5 ms"):
        expected = run_of(tmp_path, "whole", WHOLE, period).state.line
        found = run_of(tmp_path, "parted", PARTED, period)
        off.append(np.max(np.abs(found.state.line - expected)) / np.max(expected))
        memory = found.final_memory["load"]
        energies.append(memory.exchange)
        assert abs(memory.exchange) < 1e-2 * memory.exchanged
    assert off[0] < 1e-2
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.05)
    assert energies[0] / energies[1] == pytest.approx(2.0, rel=0.05)
