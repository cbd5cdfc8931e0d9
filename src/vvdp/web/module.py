"""A model with its loop as one WebAssembly module that imports nothing but its memory.

The texts are those that the command line compiles. What they call of the C library comes from `link`; products and
sums that a processor rounds once are rounded once in software, so that the numbers keep their bits.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from vvdp.generator import binding
from vvdp.generator.kinds import INT, Address, Known, registers_of
from vvdp.generator.llvm_text import TYPES, result_type
from vvdp.simulation import loop
from vvdp.simulation.assembly import Assembly
from vvdp.simulation.link import ModelAssemblies
from vvdp.simulation.loops import plain_part
from vvdp.simulation.model import Case, Model
from vvdp.web.link import FEATURES, TRIPLE, link

ENTRY = "vvdp_run"
"""The function of a module that a page calls."""


@dataclass(frozen=True)
class WebModule:
    """A module, and why its code may fail: file, line and reason by number."""

    code: bytes
    reasons: Mapping[int, str]


def web_module(model: Model, case: Case) -> WebModule:
    """The module of a model for values of the shape of `case`.

    Raises ExtraMissing without the extra `web`, RunError where a function cannot be compiled.
    """
    found = ModelAssemblies(model, case)
    objects, reasons = [_loop_object()], dict[int, str]()
    for each in found:
        text, why = each.llvm_text()
        reasons |= {each.failure_number(place): words for place, words in enumerate(why)}
        objects.append(_object(_with_symbols(text, each)))
    objects.append(_object(_entry_text(found)))
    return WebModule(link(objects, ENTRY), reasons)


def _loop_assembly() -> Assembly:
    return Assembly([plain_part(loop.run, loop.RUN, INT)])


@cache
def _loop_object() -> bytes:
    return _object(_loop_assembly().llvm_text()[0])


def _object(text: str) -> bytes:
    return binding.compile_foreign(text, TRIPLE, FEATURES)


def _with_symbols(text: str, assembly: Assembly) -> str:
    """The text with its entries under the names by which other modules call them."""
    for part in assembly.parts:
        text = text.replace(f'@"{part.name}"(', f'@"{assembly.symbol(part.name)}"(')
    return text


def _entry_text(model: ModelAssemblies) -> str:
    """The text of `vvdp_run(slots)`: the loop with its arguments from memory, 8 bytes each.

    Behind the arguments are written its answer and the number of a failure.
    """
    symbols = [model.circuit.symbol("rates"), model.sample.symbol("sample")]
    symbols += [model.circuit.symbol("events"), model.circuit.symbol("stop")]
    addresses, others = loop.RUN[: len(symbols)], loop.RUN[len(symbols) :]
    registers = [TYPES[each] for kind in others for each in registers_of(kind)]
    places = [f"  %p{i} = getelementptr i64, ptr %slots, i64 {i}" for i in range(len(registers) + 2)]
    loads = [f"  %a{i} = load {register}, ptr %p{i}, align 8" for i, register in enumerate(registers)]
    given = [f"ptr @{symbol}" for symbol in symbols] + [f"{kind} %a{i}" for i, kind in enumerate(registers)]
    answer = f"  %answer = call i64 @run({', '.join(given)}, ptr %p{len(registers) + 1})"
    types = ", ".join(["ptr"] * len(symbols) + registers + ["ptr"])
    declared = [_declaration(symbol, kind) for symbol, kind in zip(symbols, addresses, strict=True)]
    return "\n".join([
        *declared, f"declare i64 @run({types})", f"define void @{ENTRY}(ptr %slots) nounwind {{", *places, *loads,
        answer, f"  store i64 %answer, ptr %p{len(registers)}, align 8", "  ret void", "}",
    ])  # fmt: skip


def _declaration(symbol: str, kind: Address) -> str:
    types = [TYPES[each] for argument in kind.arguments for each in registers_of(argument)]
    return f"declare {result_type(kind.result or Known(None))} @{symbol}({', '.join([*types, 'ptr'])})"
