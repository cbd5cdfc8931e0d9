"""All that is used of llvmlite: LLVM text becomes object code, and object code functions in this process."""

import itertools
import os
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite.binding as llvm

from vvdp.base.errors import RunError

_numbers = itertools.count()
_one_at_a_time = threading.Lock()
"""Held while LLVM works on a module: all modules share its global context, and an interrupted compilation goes on."""
LEVEL = "VVDP_PROCESSOR"
"""The variable of the environment that names a processor level, for a cache that different processors share."""
LEVELS = {"x86-64-v2": (), "x86-64-v3": ("fma", "avx2"), "x86-64-v4": ("fma", "avx2", "avx512f")}
"""The levels, and which of the features asked for by name they have."""


@dataclass(frozen=True)
class Loaded:
    """Functions in memory, for as long as this value lives."""

    addresses: dict[str, int]
    keeper: Any


def processor_level() -> tuple[str, str]:
    """The processor that code is made for and its features: this one, unless the environment names a level.

    Raises RunError where it names none of `LEVELS`.
    """
    if level := os.environ.get(LEVEL):
        if level not in LEVELS:
            raise RunError(f"{LEVEL} is {level}; expected one of {', '.join(LEVELS)}")
        return level, ""
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


@cache
def _machine(level: int) -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    cpu, features = processor_level()
    return target.create_target_machine(cpu=cpu, features=features, opt=level, jit=True)


@cache
def _jit() -> Any:
    return llvm.create_lljit_compiler(_machine(2))


def processor() -> str:
    """The processor that code is made for, with its features."""
    return " ".join([llvm.get_process_triple(), *processor_level()])


def has_feature(name: str) -> bool:
    """Whether the processor that code is made for has a feature, such as "avx512f"."""
    level, _ = processor_level()
    return name in LEVELS[level] if level in LEVELS else bool(llvm.get_host_cpu_features().get(name))


def is_fused() -> bool:
    """Whether the processor that code is made for multiplies and adds in one."""
    return has_feature("fma") or not llvm.get_process_triple().startswith("x86")


def version() -> str:
    """The versions of llvmlite and LLVM."""
    import llvmlite

    return f"{llvmlite.__version__} {'.'.join(map(str, llvm.llvm_version_info))}"


def optimise(text: str, level: int = 2) -> Any:
    """The module of LLVM text at an optimisation level from 0 to 3. Raises RuntimeError where LLVM refuses the text."""
    return _optimise_for(text, llvm.get_process_triple(), _machine(level), level)


def _optimise_for(text: str, triple: str, machine: Any, level: int) -> Any:
    module = llvm.parse_assembly(text)
    module.verify()
    module.triple, module.data_layout = triple, str(machine.target_data)
    tuning = llvm.create_pipeline_tuning_options(speed_level=level)
    tuning.loop_vectorization = False  # it takes as long again as all else; sums in order gain nothing by it
    tuning.slp_vectorization = level > 0
    tuning.loop_unrolling = level > 2
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return module


def compile_foreign(text: str, triple: str, features: str) -> bytes:
    """Object code for another machine, at speed level 2. Raises RuntimeError where LLVM refuses the text.

    triple, features  the machine as LLVM names it, such as "wasm32-unknown-unknown" and "+bulk-memory"
    """
    with _one_at_a_time:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        machine = llvm.Target.from_triple(triple).create_target_machine(features=features, opt=2, reloc="static")
        code: bytes = machine.emit_object(_optimise_for(text, triple, machine, 2))
    return code


def compile_text(text: str, level: int = 2) -> bytes:
    """Object code for this processor. Raises RuntimeError where LLVM refuses the text."""
    with _one_at_a_time:
        code: bytes = _machine(level).emit_object(optimise(text, level))
    return code


def load_code(code: bytes, names: Sequence[str], symbols: Mapping[str, int] | None = None) -> Loaded:
    """The functions of these names in object code, which may call those of the C library of this process.

    symbols  the addresses of functions of other modules, by the names under which the code calls them
    """
    library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
    for name in names:
        library.export_symbol(name)
    for name, address in (symbols or {}).items():
        library.import_symbol(name, address)
    tracker = library.link(_jit(), f"generated_{next(_numbers)}")
    return Loaded({name: tracker[name] for name in names}, tracker)
