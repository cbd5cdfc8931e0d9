"""The generator takes every shipped system, and gives the same bits for it in every way."""

import numpy as np
import pytest
from tests.generator.systems import unit_of
from tests.generator.ways import machine_code

from vvdp.base.powers import expm1, power
from vvdp.generator import binding
from vvdp.generator.calls import callables
from vvdp.generator.kinds import FLOAT
from vvdp.generator.llvm_writer import write_llvm
from vvdp.generator.python_writer import run_python
from vvdp.generator.unit import Unit
from vvdp.generator.verify import verify
from vvdp.simulation.dialect import model_options
from vvdp.simulation.layout import vectors
from vvdp.systems.system import load_system, shipped_systems


def model_of(name):
    system = load_system(name)
    return system.model, system.case


def two(x, y):
    return power(x, y)


def one(x):
    return expm1(x)


@pytest.fixture(scope="module")
def plain():
    """The functions worked out in place, as Python functions that call the very instructions."""
    unit = Unit(model_options())
    unit.add(two, [FLOAT, FLOAT], "two")
    unit.add(one, [FLOAT], "one")
    entries = machine_code(verify(unit.module()), 2)
    return {
        "power": lambda x, y: np.float64(entries["two"](x, y)),
        "expm1": lambda x: np.float64(entries["one"](x)),
    }


@pytest.mark.parametrize("name", ["buck-converter", "long-hose", "prototype-constant-load"])
def test_rates_are_the_same_in_every_way(name, plain):
    model, case = model_of(name)
    module = verify(unit_of(model, case, model_options(plain)).module())
    ways = {"tree": run_python(module), "level 2": machine_code(module, 2)}
    numbers = vectors(case)
    draw = np.random.default_rng(7)
    for _ in range(20):
        y = numbers.state * (1.0 + 0.2 * draw.standard_normal(numbers.state.size))
        found = {way: rates_of(entries["rates"], y, numbers) for way, entries in ways.items()}
        assert found["tree"].tobytes() == found["level 2"].tobytes()
        assert np.any(found["tree"] != 0.0)


def rates_of(rates, y, numbers):
    dy = np.zeros(y.size + 64)
    with np.errstate(all="ignore"):
        rates(np.float64(0.3141), y, numbers.command, numbers.params, dy)
    return dy


def test_copied_functions_have_the_same_rates():
    model, case = model_of("buck-converter")
    numbers, module = vectors(case), verify(unit_of(model, case, model_options()).module())
    found = set()
    for chosen in ({}, {"inline": True}, {"debug": True}):
        code = binding.compile_text(write_llvm(module, **chosen), 2)
        rates = callables(module, binding.load_code(code, module.entries))["rates"]
        found.add(rates_of(rates, numbers.state, numbers).tobytes())
    assert len(found) == 1


def test_checked_code_has_the_same_rates():
    model, case = model_of("buck-converter")
    numbers = vectors(case)
    found = []
    for checked in (False, True):
        module = verify(unit_of(model, case, model_options(checked=checked)).module())
        found.append(rates_of(machine_code(module, 1)["rates"], numbers.state, numbers))
    assert found[0].tobytes() == found[1].tobytes()


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_every_shipped_system_is_written(name):
    model, case = model_of(name)
    module = verify(unit_of(model, case, model_options()).module())
    assert machine_code(module, 1).keys() >= {"rates", "stop", "events"}
    assert write_llvm(module) == write_llvm(verify(unit_of(model, case, model_options()).module()))
