"""Shipped systems as C: every function of a model has the bits of the machine code, and no compiler warns."""

import numpy as np
import pytest
from tests.generator.c_way import CLEAN, c_entries, compilers
from tests.generator.systems import unit_of
from tests.generator.ways import machine_code

from vvdp.base.powers import expm1, power
from vvdp.export.c_powers import C_INTRINSICS
from vvdp.generator.binding import is_fused
from vvdp.generator.kinds import FLOAT
from vvdp.generator.unit import Unit
from vvdp.generator.verify import verify
from vvdp.simulation.dialect import model_options
from vvdp.simulation.layout import blocks, vectors
from vvdp.simulation.values import flat
from vvdp.systems.system import load_system, shipped_systems

pytestmark = [
    pytest.mark.skipif(not compilers(), reason="no C compiler"),
    pytest.mark.skipif(not is_fused(), reason="machine code has other bits on a processor without fused operations"),
]
STATES = 200
SAMPLES = 300


def two(x, y):
    return power(x, y)


def one(x):
    return expm1(x)


def test_powers_have_the_bits_of_the_machine_code():
    unit = Unit(model_options())
    unit.add(two, [FLOAT, FLOAT], "two")
    unit.add(one, [FLOAT], "one")
    module = verify(unit.module())
    native = machine_code(module, 2)
    draw = np.random.default_rng(3)
    bases = np.concatenate([10.0 ** draw.uniform(-300, 300, 1000), draw.uniform(0.0, 3.0, 1000), [0.0, np.inf, 1.0]])
    exponents = np.concatenate([draw.uniform(-4.0, 4.0, 2000), [0.5, 1.5, -2.0]])
    for compiler in compilers():
        found = c_entries(module, compiler, ("-O2", *CLEAN), C_INTRINSICS)
        for x, y in zip(bases, exponents, strict=True):
            assert same(found["two"](x, y), native["two"](x, y)), (x, y)
        for x in np.concatenate([draw.uniform(-2.0, 2.0, 1000), [0.0, 0.35, -0.35, 1e-300, 700.0]]):
            assert same(found["one"](x), native["one"](x)), x


def same(a, b):
    return np.float64(a).tobytes() == np.float64(b).tobytes()


def shaken(values, draw):
    return values * (1.0 + 0.3 * draw.standard_normal(values.size))


SHORT = ["buck-converter", "displacement-chapter6", "prototype"]


@pytest.mark.parametrize("name", [*SHORT, *(pytest.param(n, marks=pytest.mark.thorough) for n in
                                            sorted(set(shipped_systems()) - set(SHORT)))])  # fmt: skip
def test_every_function_of_a_system_has_the_bits_of_the_machine_code(name):
    system = load_system(name)
    module = verify(unit_of(system.model, system.case, model_options()).module())
    native = machine_code(module, 2)
    for compiler in compilers():
        found = c_entries(module, compiler, ("-O2", *CLEAN), C_INTRINSICS)
        draw = np.random.default_rng(11)
        for _ in range(STATES):
            assert_same_circuit(found, native, vectors(system.case), draw)
        for number, program in enumerate(system.case.memory):
            assert_same_samples(found, native, system, (number, program))


def assert_same_circuit(found, native, numbers, draw):
    """Rates, events, stop and conditions at a random state."""
    t, y = draw.uniform(0.0, 0.5), shaken(numbers.state, draw)
    for entry, handed in (("rates", (y, numbers.command)), ("events", (y, numbers.command)), ("hold", ())):
        results = []
        for entries in (found, native):
            room = np.zeros(numbers.state.size + numbers.command.size + 64)
            entries[entry](t, *handed, numbers.params, room)
            results.append(room.tobytes())
        assert results[0] == results[1], entry
    assert same(*(entries["stop"](t, numbers.command, numbers.params) for entries in (found, native)))


def assert_same_samples(found, native, system, program):
    """Samples of a program, each with the memory that the one before has left, of states that wander."""
    (number, name), case = program, system.case
    outputs = flat(system.model.circuit(0.0, case.state, case.command, case.params)[1])
    kept = []
    for entries in (found, native):
        draw, numbers = np.random.default_rng(5), vectors(case)
        memory, command = numbers.memory.copy(), numbers.command.copy()
        for sample in range(SAMPLES):
            y, reading = shaken(numbers.state, draw), np.zeros(400)
            seen = shaken(outputs, draw)
            entries[f"measure_{number}"](sample * 1e-3, y, command, numbers.params, seen, reading)
            entries[f"step_{number}"](
                sample * 1e-3, memory, reading, numbers.params, command, blocks(case).programs[name]
            )
        kept.append(memory.tobytes() + command.tobytes())
    assert kept[0] == kept[1], name
