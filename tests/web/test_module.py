"""The module of a system gives the bits of the command line: every row, memory and mark."""

import pytest
from tests.web.node import InNode, differing, left_by

from vvdp.generator.binding import compile_foreign
from vvdp.generator.library import C_LIBRARY
from vvdp.simulation.run import simulate
from vvdp.systems.changeable import changeable_values
from vvdp.systems.system import load_system, shipped_systems
from vvdp.web.link import FEATURES, TRIPLE, link
from vvdp.web.module import web_module
from vvdp.web.page import run_model

QUICK = ("accumulator-charging", "buck-converter", "cylinder-stops", "prototype-constant-load")


def in_node(system, folder, values=()):
    return InNode(run_model(system, web_module(system.model, system.case), values), folder)


@pytest.mark.parametrize("name", QUICK)
def test_no_bit_differs(name, tmp_path):
    system = load_system(name, (), "0.5 s")
    run = simulate(system.model, system.case, system.stepping)
    assert run.times.size > 1000
    assert not differing(in_node(system, tmp_path).rows(), left_by(run))


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(set(shipped_systems()) - set(QUICK)))
def test_no_bit_of_any_other_system_differs(name, tmp_path):
    test_no_bit_differs(name, tmp_path)


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


def test_every_function_of_the_c_library_is_there(tmp_path):
    """A drawn circuit may call any of them; a module that lacks one does not link."""
    lines, total = [], "0.0"
    for number, (name, count) in enumerate(C_LIBRARY.items()):
        given = ", ".join(["double %x"] * count)
        lines += [f"  %a{number} = call double @{name}({given})", f"  %s{number} = fadd double {total}, %a{number}"]
        total = f"%s{number}"
    declared = [f"declare double @{name}({', '.join(['double'] * count)})" for name, count in C_LIBRARY.items()]
    text = "\n".join([*declared, "define double @vvdp_all(double %x) {", *lines, f"  ret double {total}", "}"])
    assert link([compile_foreign(text, TRIPLE, FEATURES)], ["vvdp_all"]).startswith(b"\0asm")
