"""A model with its loop as one WebAssembly module that imports nothing but its memory.

The texts are those that the command line compiles. What they call of the C library comes from `link`, and so does the
way in which products and sums are calculated that a processor rounds once.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

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
from vvdp.web.link import RELAXED, SOFTWARE, SPLIT, TRIPLE, Way, link

EXACT, FUSED, QUICK = "exact", "fused", "quick"
WAYS = {EXACT: SOFTWARE, FUSED: RELAXED, QUICK: SPLIT}
"""The modules of a page by name: with the bits of the command line, the same where a browser can, and for drafts."""


FMA = "llvm.fma.f64"


@dataclass(frozen=True)
class WebModules:
    """The modules of `WAYS`, and why their code may fail: file, line and reason by number."""

    codes: Mapping[str, bytes]
    reasons: Mapping[int, str]


def web_modules(model: Model, case: Case) -> WebModules:
    """The modules of a model for values of the shape of `case`.

    Each exports functions that take the address of their arguments, 8 bytes each, behind which they write their answer
    and the number of a failure: `vvdp_run` the loop, whose functions it knows, `vvdp_sample`, `vvdp_outputs` and
    `vvdp_stored` what `link` and `parts` have by these names.
    Raises MissingExtraError without the extra `web`, RunError where a function cannot be compiled.
    """
    refuse_partners(model.partners, "a page")
    found, shown = ModelAssemblies(model, case), _assembly_of_outputs(model, case)
    assemblies, reasons = [*found, shown], dict[int, str]()
    entries = _entry_texts(found, shown)
    # programs of one type and shape have one text
    texts = {fused: list(dict.fromkeys(_texts(assemblies, fused, reasons))) for fused in (True, False)}
    codes = {}
    for name, way in WAYS.items():
        objects = [_object(text, way) for text in (*texts[way.fused], *entries.values())]
        codes[name] = link(objects, [f"vvdp_{name}" for name in entries], way)
    return WebModules(codes, reasons)


def _texts(assemblies: Sequence[Assembly], fused: bool, reasons: dict[int, str]) -> Iterator[str]:
    """The texts of a module but its entries; why its code may fail is added to `reasons`."""
    yield _loop_text(fused)
    for each in assemblies:
        text, why = each.llvm_text(fused=fused)
        reasons.update((each.failure_number(place), words) for place, words in enumerate(why))
        yield _with_symbols(text, each)


def _entry_texts(found: ModelAssemblies, shown: Assembly) -> dict[str, str]:
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
    return texts


def _assembly_of_outputs(model: Model, case: Case) -> Assembly:
    """Code for values that are calculated from a run's rows: outputs, and the stored energy and oil."""
    parts = [outputs_part(model, case)]
    return Assembly(parts if model.stored is None else [*parts, stored_part(model.stored, case)])


@cache
def _loop_text(fused: bool) -> str:
    return Assembly([plain_part(loop.run, loop.RUN, INT)]).llvm_text(fused=fused)[0]


def _object(text: str, way: Way) -> bytes:
    """The object of a text; ways have the same one where nothing is multiplied and added with one rounding."""
    if not way.text or FMA not in text:
        return _object_of(text, SOFTWARE.llvm_features)
    lines = [line for line in text.split("\n") if not (line.startswith("declare ") and FMA in line)]
    text = "\n".join([*lines, way.text]).replace(f'"{FMA}"', FMA).replace(f"@{FMA}", "@vvdp_fma")
    return _object_of(text, way.llvm_features)


@lru_cache(maxsize=64)
def _object_of(text: str, features: str) -> bytes:
    return binding.compile_foreign(text, TRIPLE, features)


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
