"""All that is used of llvmlite: LLVM text becomes object code, and object code functions in this process."""

import itertools
from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite.binding as llvm

_numbers = itertools.count()


@dataclass(frozen=True)
class Loaded:
    """Functions in memory, for as long as this value lives."""

    addresses: dict[str, int]
    keeper: Any


@cache
def _machine(level: int) -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    features = llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=level, jit=True)


@cache
def _jit() -> Any:
    return llvm.create_lljit_compiler(_machine(2))


def processor() -> str:
    """The processor that code is made for, with its features."""
    return f"{llvm.get_process_triple()} {llvm.get_host_cpu_name()} {llvm.get_host_cpu_features().flatten()}"


def version() -> str:
    """The versions of llvmlite and LLVM."""
    import llvmlite

    return f"{llvmlite.__version__} {'.'.join(map(str, llvm.llvm_version_info))}"


def optimise(text: str, level: int = 2) -> Any:
    """The module of LLVM text at an optimisation level from 0 to 3. Raises RuntimeError where LLVM refuses the text."""
    module = llvm.parse_assembly(text)
    module.verify()
    machine = _machine(level)
    module.triple, module.data_layout = llvm.get_process_triple(), str(machine.target_data)
    tuning = llvm.create_pipeline_tuning_options(speed_level=level)
    tuning.loop_vectorization = tuning.slp_vectorization = False
    tuning.loop_unrolling = level > 2
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return module


def compile_text(text: str, level: int = 2) -> bytes:
    """Object code for this processor. Raises RuntimeError where LLVM refuses the text."""
    code: bytes = _machine(level).emit_object(optimise(text, level))
    return code


def load_code(code: bytes, names: tuple[str, ...]) -> Loaded:
    """The functions of these names in object code, which may call those of the C library of this process."""
    library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
    for name in names:
        library.export_symbol(name)
    tracker = library.link(_jit(), f"generated_{next(_numbers)}")
    return Loaded({name: tracker[name] for name in names}, tracker)
