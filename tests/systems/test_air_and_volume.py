"""What air and switched volume cost, as docs/models/fluid.md tells it, and the trends of Van de Ven 2013."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

PAGE = " ".join((Path(__file__).parents[2] / "docs/models/fluid.md").read_text("utf-8").split())
AIR = ("0.01 %", "1 %", "5 %", "10 %")
VOLUMES = ("12.7 cc", "60 cc")


@cache
def found(precompression, volume, air, dead="0 cc/rev"):
    settings = [f"pump.precompression={precompression}", f"inlet.volume={volume}", f"oil.air_fraction={air}"]
    system = load_system("prototype-constant-load", [*settings, f"pump.dead_volume={dead}"], until="1 s")
    numbers = summary(system, simulate(system.model, system.case, system.stepping))
    assert abs(numbers["energy_residual"]) < 1e-6 and abs(numbers["mass_residual"]) < 1e-6
    return numbers


def efficiencies(precompression):
    return np.array([[found(precompression, v, a)["efficiency"] for a in AIR] for v in VOLUMES])


def test_efficiency_falls_with_air_and_volume_where_chambers_are_not_compressed():
    efficiency = efficiencies(0)
    assert np.all(np.diff(efficiency, axis=1) < -1e-3)
    assert np.all(efficiency[1] < efficiency[0] + 1e-4)  # alike up to 1 % of air, where the relief valve takes less
    assert np.all(efficiency[1, 2:] < efficiency[0, 2:] - 0.03)
    dead = [found(0, "12.7 cc", air, "10 cc/rev")["efficiency"] for air in ("1 %", "10 %")]
    assert np.all(dead < efficiency[0, [1, 3]] - 2e-3)


def test_with_a_pump_that_compresses_air_raises_it_at_small_volumes():
    efficiency = efficiencies(1)
    assert np.all(np.diff(efficiency[0]) > 1e-3)
    assert efficiency[1, 3] < efficiency[1, 2] < efficiency[1, 1]


@pytest.mark.parametrize("precompression", [1, 0])
@pytest.mark.parametrize("row", [0, 1])
def test_the_table_of_the_page(precompression, row):
    shown = re.search(rf"\| {precompression} \| {VOLUMES[row]} \| ([\d.| ]+?) \|(?= \||\s+The)", PAGE)[1].split(" | ")
    assert [float(x) for x in shown] == pytest.approx(efficiencies(precompression)[row], abs=1e-4)


def test_the_balance_between_little_and_much_air():
    few, much = (found(0, "12.7 cc", air) for air in ("0.01 %", "10 %"))
    ideal = [found(1, "12.7 cc", air) for air in ("0.01 %", "10 %")]
    less = {key: few[key] - much[key] for key in ("load_power_W", "loss_relief_valve_W", "input_power_W")}
    filling = much["loss_pump_compression_W"] - few["loss_pump_compression_W"]
    passages = less["input_power_W"] - less["load_power_W"] - less["loss_relief_valve_W"] + filling
    told = (
        f"the load gets {less['load_power_W']:.0f} W less; the relief valve loses {less['loss_relief_valve_W']:.0f} W",
        f"less and the valve's own passages {passages:.0f} W",
        f"filling the chambers takes {filling:.0f} W more",
    )
    assert all(words in PAGE for words in told), told
    # the two pumps differ in nothing but the filling
    assert ideal[0]["input_power_W"] - ideal[1]["input_power_W"] == pytest.approx(
        less["input_power_W"] + filling, abs=1e-3
    )
