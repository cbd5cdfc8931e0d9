"""Plain functions as machine code, for tests that hold both forms against each other."""

from collections.abc import Callable
from typing import Any

from vvdp.generator import binding
from vvdp.generator.calls import Entry, callables
from vvdp.generator.kinds import kind_of
from vvdp.generator.llvm_writer import write_llvm
from vvdp.generator.unit import Unit
from vvdp.generator.verify import verify
from vvdp.simulation.dialect import model_options


def compiled(function: Callable[..., Any], *values: Any, checked: bool = False) -> Entry:
    """`function` as machine code for arguments like `values`, read as the functions of models are."""
    unit = Unit(model_options(checked=checked))
    unit.add(function, [kind_of(value) for value in values], "entry")
    module = verify(unit.module())
    code = binding.compile_text(write_llvm(module))
    return callables(module, binding.load_code(code, module.entries))["entry"]
