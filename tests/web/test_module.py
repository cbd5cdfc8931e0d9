"""The module of a system gives the bits of the command line: every row, memory and mark."""

import pytest
from tests.web.node import InNode, differing, left_by

from vvdp.simulation.run import simulate
from vvdp.systems.changeable import changeable_values
from vvdp.systems.system import load_system, shipped_systems
from vvdp.web.module import web_module
from vvdp.web.page import run_model

QUICK = ("accumulator-charging", "buck-converter", "cylinder-stops", "prototype-constant-load")

WITH_SINES = {
    "axial-chamber", "axial-gerotor", "displacement-control", "displacement-control-gerotor", "long-hose", "prototype",
    "vvdp-duty-control", "vvdp-duty-control-gerotor",
}  # fmt: skip
"""Systems that work out sines in their steps, of which the C library of a machine has its own last digits."""


def in_node(system, folder, values=()):
    return InNode(run_model(system, web_module(system.model, system.case), values), folder)


@pytest.mark.parametrize("name", QUICK)
def test_no_bit_differs(name, tmp_path):
    system = load_system(name, (), "0.5 s")
    run = simulate(system.model, system.case, system.stepping)
    assert run.times.size > 1000
    assert not differing(in_node(system, tmp_path).rows(), left_by(run))


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_no_bit_of_any_system_differs_but_by_sines(name, tmp_path):
    system = load_system(name, (), "0.5 s")
    run = simulate(system.model, system.case, system.stepping)
    rows, left = in_node(system, tmp_path).rows(), left_by(run)
    if name not in WITH_SINES:
        assert not differing(rows, left)
    for array in ("low", "high"):
        assert rows[array] == pytest.approx(left[array], rel=1e-6, abs=1e-6)


def test_changed_values_reach_the_module_to_the_last_bit(tmp_path):
    changed = {
        "oil.density": (870.5, "kg/m^3"),
        "nodes.shaft.speed": (1477.0, "rpm"),
        "nodes.pump_line.start": (80.3, "bar"),
    }
    system = load_system("accumulator-charging", (), "0.5 s")
    values = [v for v in changeable_values(system, lambda each: each.circuit.text) if v.row.setting in changed]
    node = in_node(system, tmp_path, values)
    settings = [f'{key}="{x!r} {unit}"' for key, (x, unit) in changed.items()]
    other = load_system("accumulator-charging", settings, "0.5 s")
    run = simulate(other.model, other.case, other.stepping)
    assert not differing(node.rows({key: x for key, (x, _) in changed.items()}), left_by(run))
    assert differing(node.rows(), left_by(run))
    assert node.ask("imports") == [{"module": "env", "name": "memory", "kind": "memory"}]
