"""Studies of systems that are no benches: networks that a file draws, and circuits of one's own."""

from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.studies.dask_engines import LocalDask
from vvdp.studies.run import run_study
from vvdp.studies.study import Study, load_study
from vvdp.systems.system import load_system

DRAWN = """
[nodes]
line = { type = "volume", volume = "1 l", start = "50 bar" }
tank = { type = "tank" }
sump = { type = "tank", pressure = "2 bar" }

[components.drain]
type = "orifice"
a = "line"
b = "tank"
area = "1 mm^2"
discharge_coefficient = 0.6
transition_pressure = "0.1 bar"

[run]
until = "0.1 s"
"""
STUDY = """
system = "drain.toml"
outputs = ["pressure_mean_line_Pa", "flow_mean_drain_m3_s", "loss_drain_W", "trusted"]

[settings]
nodes.line.volume = "0.5 l"

[grid]
components.drain.area = ["0.5 mm^2", "1 mm^2", { step = ["1 mm^2", "0 mm^2"], at = "50 ms" }]
"components.drain.discharge_coefficient" = ["0.6", "0.7"]
"""
OWN = """
from vvdp.base.kinds import Area, Pressure
from vvdp.base.params import Params
from vvdp.components.resistances import LAMINAR_GAP, LaminarGap
from vvdp.fluid.oil import Oil
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber


class Start(Params):
    pressure: Pressure


def leaking(oil: Oil, line: Chamber, gap: LaminarGap, initial: Start) -> Network:
    net = Network(oil, initial=initial)
    net.tank("tank")
    net.volume("line", line, start="initial.pressure")
    net.add("gap", LAMINAR_GAP, gap, a="line", b="tank")
    return net
"""
OWN_FILE = """
circuit = "leaking_line:leaking"
line = { volume = "1 l" }
gap = { conductance = "1e-12 m^3/(s*Pa)" }
initial = { pressure = "50 bar" }
run = { until = "0.1 s" }
[oil]
density = "870 kg/m^3"
thermal_expansion = "7e-4 1/K"
viscosity_40 = "46 cSt"
viscosity_100 = "6.8 cSt"
liquid_bulk_modulus = "1.4 GPa"
air_fraction = "0 %"
polytropic_exponent = 1.4
reference_pressure = "1.01325 bara"
"""


@pytest.fixture
def drawn(tmp_path: Path) -> Path:
    """A volume that drains through an orifice, drawn in a file, and a study beside it."""
    (tmp_path / "drain.toml").write_text(DRAWN)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


def alone(path: Path, settings: list[str]) -> dict:
    system = load_system(str(path), settings)
    return summary(system, simulate(system.model, system.case, system.stepping))


def test_a_drawn_network_is_varied_at_any_depth(drawn: Path) -> None:
    found = run_study(load_study(drawn / "study.toml"), drawn / "kept")
    assert found.is_finished and not found.failures
    assert list(found.inputs) == ["components.drain.area", "components.drain.discharge_coefficient"]
    areas = ('"0.5 mm^2"', '"1 mm^2"', '{ step = ["1 mm^2", "0 mm^2"], at = "50 ms" }')
    for case, (area, coefficient) in enumerate((a, c) for a in areas for c in ("0.6", "0.7")):
        changes = [f"components.drain.area={area}", f"components.drain.discharge_coefficient={coefficient}"]
        single = alone(drawn / "drain.toml", ["nodes.line.volume=0.5 l", *changes])
        # Cases in lanes take the same steps; their sums are rounded in another order.
        assert {name: column.values[case] for name, column in found.outputs.items()} == pytest.approx(
            {name: float(single[name]) for name in found.outputs}, rel=1e-12
        )
    assert np.all(found.outputs["trusted"].values == 1.0)
    again = run_study(load_study(drawn / "study.toml"), drawn / "kept")
    assert again.ran == 0


def test_cases_that_are_joined_otherwise_are_batches_apart(drawn: Path) -> None:
    """The same values at the same places, but another tank: the shape alone does not tell the circuits apart."""
    path = str(drawn / "drain.toml")
    cases = [{"components.drain.b": "tank"}, {"components.drain.b": "sump"}, {"components.drain.b": "tank"}]
    found = run_study(Study(path, cases, ("pressure_mean_line_Pa",), until="2 s"), drawn / "kept")
    assert found.ran == 2  # two of the three are one
    np.testing.assert_allclose(found.outputs["pressure_mean_line_Pa"].values, [0.0, 2e5, 0.0], atol=4e3)


def test_a_loaded_network_can_be_set_and_lengthened(drawn: Path) -> None:
    system = load_system(str(drawn / "drain.toml"))
    study = Study(system, {"nodes.line.volume": ["1 l", "2 l"]}, ("pressure_min_line_Pa", "duration_s"),
                  settings=("components.drain.area=2 mm^2",), until="0.05 s")  # fmt: skip
    found = run_study(study, drawn / "kept")
    single = alone(drawn / "drain.toml", ["components.drain.area=2 mm^2", "nodes.line.volume=2 l", "run.until=0.05 s"])
    assert found.outputs["duration_s"].values.tolist() == [0.05, 0.05]
    assert found.outputs["pressure_min_line_Pa"].values[1] == single["pressure_min_line_Pa"]


def test_what_a_network_does_not_have_is_refused(drawn: Path) -> None:
    path = str(drawn / "drain.toml")
    with pytest.raises(ConfigError, match=wording.study.no_such_output):  # a closed form of the rotary valve
        run_study(Study(path, [{"nodes.line.volume": "2 l"}], ("analytic_loss_total_W",)), drawn / "kept")
    with pytest.raises(ConfigError, match=r"components\.drain\.aera"):
        run_study(Study(path, [{"components.drain.aera": "2 mm^2"}], ("loss_drain_W",)), drawn / "kept")


def test_a_circuit_of_ones_own_travels_to_other_processes(tmp_path: Path) -> None:
    """Its functions are written anew where it arrives, from the module beside its file."""
    (tmp_path / "leaking_line.py").write_text(OWN)
    (tmp_path / "own.toml").write_text(OWN_FILE)
    study = Study(str(tmp_path / "own.toml"), {"line.volume": ["1 l", "2 l"]}, ("pressure_min_line_Pa", "loss_gap_W"))
    here = run_study(study, tmp_path / "here")
    there = run_study(study, tmp_path / "there", engine=LocalDask(1))
    assert here.outputs["loss_gap_W"].values.all()
    for name, column in here.outputs.items():
        assert np.array_equal(column.values, there.outputs[name].values)
