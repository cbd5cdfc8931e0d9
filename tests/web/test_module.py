"""The module of a system gives the bits of the command line: every row, memory and mark."""

import numpy as np
import pytest
from tests.web.node import InNode, differing, left_by

from vvdp.generator.binding import compile_foreign
from vvdp.generator.library import C_LIBRARY
from vvdp.simulation.prepare import prepare
from vvdp.simulation.run import simulate
from vvdp.systems.changeable import changeable_values
from vvdp.systems.library_examples import FOLDER
from vvdp.systems.system import load_system, shipped_systems
from vvdp.web.link import TRIPLE, link
from vvdp.web.module import EXACT, QUICK, WAYS, web_modules
from vvdp.web.page import run_model

pytestmark = pytest.mark.heavy

SHORT = ("accumulator-charging", "prototype-constant-load")

MEMORY_ONLY = [{"module": "env", "name": "memory", "kind": "memory"}]


def in_node(system, folder, values=()):
    return InNode(run_model(system, web_modules(system.model, system.case), values), folder)


@pytest.mark.parametrize("name", SHORT)
def test_no_bit_differs(name, tmp_path):
    system = load_system(name, (), "0.5 s")
    run = simulate(system.model, system.case, system.stepping)
    assert run.times.size > 1000
    left, model = left_by(run), run_model(system, web_modules(system.model, system.case), ())
    for relaxed in (False, True):
        node = InNode(model, tmp_path, relaxed=relaxed)
        assert node.ask("imports") == [MEMORY_ONLY, relaxed]
        assert not differing(node.rows(), left)


def test_programs_of_one_type_and_shape_are_linked_once(tmp_path):
    """Two comparators of the press read a position, and have one text."""
    test_no_bit_differs(str(FOLDER / "programs" / "stages.toml"), tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(set(shipped_systems()) - set(SHORT)))
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


@pytest.mark.parametrize("name", [pytest.param(SHORT[0], marks=pytest.mark.thorough), SHORT[1]])
def test_the_quick_level_is_within_1e_12_of_a_step(name, tmp_path):
    """Relative to the state and to the scale of its kind."""
    system = load_system(name, (), "0.5 s")
    node, ready = in_node(system, tmp_path), prepare(system.model, system.case, system.stepping)
    exact, quick = (np.array(node.ask("step", {"steps": 1}, level)) for level in (EXACT, QUICK))
    assert np.all(np.abs(quick - exact) <= 1e-12 * (np.abs(exact) + ready.scale))
    assert differing(node.rows(level=QUICK), node.rows())


@pytest.mark.parametrize("name", WAYS)
def test_every_function_of_the_c_library_is_there(name):
    """A drawn circuit may call any of them; a module that lacks one does not link."""
    lines, total = [], "0.0"
    for number, (each, count) in enumerate(C_LIBRARY.items()):
        given = ", ".join(["double %x"] * count)
        lines += [f"  %a{number} = call double @{each}({given})", f"  %s{number} = fadd double {total}, %a{number}"]
        total = f"%s{number}"
    declared = [f"declare double @{each}({', '.join(['double'] * count)})" for each, count in C_LIBRARY.items()]
    text = "\n".join([*declared, "define double @vvdp_all(double %x) {", *lines, f"  ret double {total}", "}"])
    way = WAYS[name]
    assert link([compile_foreign(text, TRIPLE, way.llvm_features)], ["vvdp_all"], way).startswith(b"\0asm")
