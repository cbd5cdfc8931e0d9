"""A model with its loop as one WebAssembly module that imports nothing but its memory.

The texts are those that the command line compiles. What they call of the C library comes from `link`; products and
sums that a processor rounds once are rounded once in software, so that the numbers keep their bits.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from vvdp.generator import binding
from vvdp.generator.kinds import INT, Address, Known, registers_of
from vvdp.generator.llvm_text import TYPES, result_type
from vvdp.simulation import loop
from vvdp.simulation.assembly import Assembly
from vvdp.simulation.exchange import refuse_partners
from vvdp.simulation.link import ModelAssemblies
from vvdp.simulation.loops import plain_part
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import outputs_part, stored_part
from vvdp.web.link import FEATURES, TRIPLE, link


@dataclass(frozen=True)
class WebModule:
    """A module, and why its code may fail: file, line and reason by number."""

    code: bytes
    reasons: Mapping[int, str]


def web_module(model: Model, case: Case) -> WebModule:
    """The module of a model for values of the shape of `case`.

    It exports functions that take the address of their arguments, 8 bytes each, behind which they write their answer
    and the number of a failure: `vvdp_run` the loop, whose functions it knows, `vvdp_sample`, `vvdp_outputs` and
    `vvdp_stored` what `link` and `parts` have by these names.
    Raises MissingExtraError without the extra `web`, RunError where a function cannot be compiled.
    """
    refuse_partners(model.partners, "a page")
    found = ModelAssemblies(model, case)
    shown = _assembly_of_outputs(model, case)
    objects, reasons = [_loop_object()], dict[int, str]()
    for each in (*found, shown):
        text, why = each.llvm_text()
        reasons |= {each.failure_number(place): words for place, words in enumerate(why)}
        objects.append(_object(_with_symbols(text, each)))
    known = [
        (assembly.symbol(name), kind)
        for assembly, name, kind in (
            (found.circuit, "rates", loop.RATES),
            (found.sample, "sample", loop.SAMPLE),
            (found.circuit, "events", loop.EVENT_LIST),
            (found.circuit, "stop", loop.STOP),
        )
    ]
    texts = {
        "run": _entry_text("run", "run", Address(loop.RUN, INT), known),
        "sample": _entry_text("sample", *known[1]),
    }
    for part in shown.parts:
        texts[part.name] = _entry_text(part.name, shown.symbol(part.name), Address(part.kinds, None))
    objects += [_object(text) for text in texts.values()]
    return WebModule(link(objects, [f"vvdp_{name}" for name in texts]), reasons)


def _assembly_of_outputs(model: Model, case: Case) -> Assembly:
    """What is worked out from a run's rows: outputs, and what is in store."""
    parts = [outputs_part(model, case)]
    return Assembly(parts if model.stored is None else [*parts, stored_part(model.stored, case)])


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


def _entry_text(name: str, symbol: str, kind: Address, known: Sequence[tuple[str, Address]] = ()) -> str:
    """The text of an entry that calls a function with arguments from memory, behind the addresses of `known` ones."""
    registers = [TYPES[each] for argument in kind.arguments[len(known) :] for each in registers_of(argument)]
    count = len(registers)
    places = [f"  %p{i} = getelementptr i64, ptr %slots, i64 {i}" for i in range(count + 2)]
    loads = [f"  %a{i} = load {register}, ptr %p{i}, align 8" for i, register in enumerate(registers)]
    given = [f"ptr @{each}" for each, _ in known] + [f"{register} %a{i}" for i, register in enumerate(registers)]
    call = f"call {result_type(kind.result or Known(None))} @{symbol}({', '.join(given)}, ptr %p{count + 1})"
    answer = [f"  %answer = {call}", f"  store i64 %answer, ptr %p{count}, align 8"] if kind.result else [f"  {call}"]
    declared = [_declaration(each, type_) for each, type_ in ((symbol, kind), *known)]
    head = f"define void @vvdp_{name}(ptr %slots) nounwind {{"
    return "\n".join([*declared, head, *places, *loads, *answer, "  ret void", "}"])


def _declaration(symbol: str, kind: Address) -> str:
    types = [TYPES[each] for argument in kind.arguments for each in registers_of(argument)]
    return f"declare {result_type(kind.result or Known(None))} @{symbol}({', '.join([*types, 'ptr'])})"
