"""Rates in C at many random states: the numbers of the page on export."""

import ctypes
from dataclasses import replace

import numpy as np
import pytest
from tests.generator.c_way import compile_c, compilers

from vvdp.export.c_parts import OUT, circuit_entries, module_of
from vvdp.export.c_powers import C_INTRINSICS
from vvdp.generator import binding
from vvdp.generator.c_writer import write_c
from vvdp.generator.llvm_writer import write_llvm
from vvdp.simulation.values import flat
from vvdp.systems.system import load_system

FAST = ("-std=gnu11", "-ffp-contract=fast")


def states(first, count):
    draw = np.random.default_rng(3)
    scale = np.where(first == 0.0, 1.0, 0.3 * abs(first))
    return first + scale * draw.standard_normal((count, first.size))


class Rates:
    """The rates of a system at random states, by the address of any function that calculates them."""

    def __init__(self, name, count):
        system = load_system(name)
        self.entry = circuit_entries(system.model, system.case)[0]
        self.module = module_of([self.entry])
        self.drawn = states(flat(system.case.state), count)
        self.made = write_c(self.module, "m", C_INTRINSICS)

    def bits(self, address):
        """The bits of all results, a row for each state; one pattern for all that is not a number."""
        blocks = self.entry.arguments
        values = {block.name: flat(block.value) for block in blocks}
        places = [values[block.name].ctypes.data for block in blocks]
        trouble = ctypes.c_int64(0)
        kinds = [ctypes.c_void_p] * (len(blocks) + 1)
        run = ctypes.CFUNCTYPE(None, ctypes.c_double, *kinds)(address)
        rows = []
        for state in self.drawn:
            values["state"][:] = state
            run(0.0123, *places, ctypes.addressof(trouble))
            rows.append(np.concatenate([values[block.name] for block in blocks if block.role == OUT]))
        found = np.array(rows)
        return np.where(np.isnan(found), np.nan, found).view(np.uint64)

    def expected(self):
        code = binding.compile_text(write_llvm(self.module), 2)
        loaded = binding.load_code(code, self.module.entries)
        return self.bits(loaded.addresses["rates"])

    def in_c(self, compiler, flags, made=None):
        library = compile_c(made or self.made, compiler, flags)
        function = getattr(library, self.made.functions["rates"])
        return self.bits(ctypes.cast(function, ctypes.c_void_p).value)

    def differing(self, *build):
        return int(np.any(self.in_c(*build) != self.expected(), axis=1).sum())


@pytest.mark.thorough
@pytest.mark.skipif(not compilers(), reason="no C compiler")
@pytest.mark.parametrize("name", ["prototype", "displacement-control"])
def test_no_row_of_twenty_thousand_differs(name):
    rates = Rates(name, 20_000)
    for compiler in compilers():
        for flags in (("-O2",), ("-O3", "-march=native")):
            assert rates.differing(compiler, flags) == 0, (compiler, flags)
    contracting = replace(rates.made, flags=FAST)
    assert rates.differing(compilers()[0], ("-O2", "-march=native"), contracting) > 10_000


@pytest.mark.skipif(not compilers(), reason="no C compiler")
def test_contraction_is_seen():
    rates = Rates("buck-converter", 200)
    assert rates.differing(compilers()[0], ("-O2",)) == 0
    contracting = replace(rates.made, flags=FAST)
    assert rates.differing(compilers()[0], ("-O2", "-march=native"), contracting) > 0
