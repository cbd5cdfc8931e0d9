"""The module of the tree as LLVM text, with opaque pointers and nothing that depends on the machine.

A number is handed over in a register, an array as its address and its open lengths, a record by the address of its
numbers. An entry has the C convention of the same, and behind its arguments the address of a whole number, to which the
number of a failure is written. There is no global memory but constants: arrays that outlive a function have room in
the frame of the entry, which functions are handed as their `context`: next free byte, end, what was taken beyond it
from the C library, place of a failure.
"""

import re

from vvdp.generator.kinds import Record, registers_of
from vvdp.generator.library import C_LIBRARY
from vvdp.generator.llvm_expressions import declare_library
from vvdp.generator.llvm_statements import locate, needs_of, scope_of, statements_in, write_block
from vvdp.generator.llvm_text import (
    SELDOM,
    TYPES,
    Needs,
    Shared,
    Text,
    is_held_in_memory,
    result_type,
)
from vvdp.generator.tree import Function, Module
from vvdp.generator.verify import calls_in, statement_operands

ROOM = 8192
"""Numbers for which an entry has room in its frame."""

PRELUDE = """\
define internal ptr @generator_room(ptr %context, i64 %wanted) nounwind {
  %some = icmp sgt i64 %wanted, 0
  %count = select i1 %some, i64 %wanted, i64 0
  %free = load ptr, ptr %context, align 8
  %next = getelementptr i64, ptr %free, i64 %count
  %place = getelementptr i64, ptr %context, i64 1
  %end = load ptr, ptr %place, align 8
  %from = ptrtoint ptr %free to i64
  %to = ptrtoint ptr %end to i64
  %bytes = sub i64 %to, %from
  %left = sdiv i64 %bytes, 8
  %fits = icmp sle i64 %count, %left
  br i1 %fits, label %here, label %beyond
here:
  store ptr %next, ptr %context, align 8
  ret ptr %free
beyond:
  %numbers = add i64 %count, 1
  %size = mul i64 %numbers, 8
  %made = call ptr @malloc(i64 %size)
  %chain = getelementptr i64, ptr %context, i64 2
  %before = load ptr, ptr %chain, align 8
  store ptr %before, ptr %made, align 8
  store ptr %made, ptr %chain, align 8
  %usable = getelementptr i64, ptr %made, i64 1
  ret ptr %usable
}
define internal void @generator_free(ptr %context) nounwind {
  %chain = getelementptr i64, ptr %context, i64 2
  br label %head
head:
  %made = load ptr, ptr %chain, align 8
  %none = icmp eq ptr %made, null
  br i1 %none, label %done, label %one
one:
  %before = load ptr, ptr %made, align 8
  store ptr %before, ptr %chain, align 8
  call void @free(ptr %made)
  br label %head
done:
  ret void
}
declare noalias ptr @malloc(i64) nounwind
declare void @free(ptr) nounwind
"""


def write_llvm(module: Module, *, debug: bool = False, inline: bool = False, base: int = 0) -> str:
    """The LLVM text of a module.

    debug   gives each instruction the file and line of its Python text
    inline  copies every function to where it is called: formulas without loops run a sixth faster and compile in half
            the time; what has many calls in branches and loops grows
    base    added to the number of each failure, so that those of modules that call each other differ
    """
    shared, needs = Shared(debug=debug, inline=inline, base=base), dict[str, Needs]()
    shared.metadata('!{!"branch_weights", i32 1, i32 1000000}')  # the first, which is `SELDOM`
    functions = []
    for function in module.functions:
        needs[function.name] = needs_of(function, needs)
        functions.append(_function(function, needs, shared, is_entry=function.name in module.entries))
    supplied = [_definitions(intrinsic.text, shared) for intrinsic in module.intrinsics.values()]
    parts = [*shared.tables.values(), *shared.declared.values(), *supplied]
    if any(each.room for each in needs.values()):
        parts.append(PRELUDE)
    return "\n".join([*parts, *functions, *_metadata(shared)]) + "\n"


def written_out(module: Module) -> int:
    """How many statements the largest entry has if every call in it is copied to its place."""
    sizes: dict[str, int] = {}
    for function in module.functions:
        statements = list(statements_in(function.body))
        called = [
            each for statement in statements for value in statement_operands(statement) for each in calls_in(value)
        ]
        sizes[function.name] = len(statements) + sum(sizes[each.name] for each in called if not each.apart)
    return max((sizes[name] for name in module.entries), default=0)


def _definitions(text: str, shared: Shared) -> str:
    """The text of an intrinsic without what it only declares, which the module does once, and without metadata."""
    found = []
    for line in text.splitlines():
        if declared := re.match(r'declare .*@"?([\w.]+)"?\(', line):
            name = declared[1]
            if name in C_LIBRARY:
                declare_library(shared, name, C_LIBRARY[name])
            shared.declared.setdefault(name, line)
        elif not line.startswith(("!", ";", "target ")):
            found.append(re.sub(r", !prof !\d+", f", !prof !{SELDOM}", line))
    return "\n".join(found)


def _metadata(shared: Shared) -> list[str]:
    lines = [f"!{number} = {text}" for text, number in shared.located.items()]
    if shared.debug:
        flags = shared.metadata('!{i32 2, !"Debug Info Version", i32 3}')
        lines += [f'!{flags} = !{{i32 2, !"Debug Info Version", i32 3}}', f"!llvm.module.flags = !{{!{flags}}}"]
        units = [f"!{number}" for text, number in shared.located.items() if "!DICompileUnit" in text]
        lines.append(f"!llvm.dbg.cu = !{{{', '.join(units)}}}")
    return lines


def _function(function: Function, needs: dict[str, Needs], shared: Shared, *, is_entry: bool) -> str:
    text = Text(function, needs, shared)
    locate(text, function.line)
    _begin(text, is_entry=is_entry)
    write_block(text, function.body)
    if text.is_open:
        text.end("unreachable")
    copied = " alwaysinline" if shared.inline and not is_entry else ""
    attributes = "noinline cold nounwind memory(read)" if function.apart else f"nounwind{copied}"
    scope = f" !dbg !{scope_of(text)}" if shared.debug else ""
    kind = "define" if is_entry else "define internal"
    head = (
        f'{kind} {result_type(function.result)} @"{function.name}"({_parameters(text, is_entry)}) {attributes}{scope}'
    )
    lines = _free_before_returns(text.lines) if is_entry and needs[function.name].room else text.lines
    return "\n".join([f"{head} {{", *text.slots, *lines, "}"])


def _parameters(text: Text, is_entry: bool) -> str:
    function = text.function
    found = ["ptr noalias %result"] if is_held_in_memory(function.result) else []
    for number, parameter in enumerate(function.parameters):
        extra = " noalias readonly captures(none)" if isinstance(parameter.kind, Record) else ""
        leaves = registers_of(parameter.kind)
        found += [f"{TYPES[leaf]}{extra} %a{number}.{i}" for i, leaf in enumerate(leaves)]
    if is_entry:
        found.append("ptr %trouble")
    elif text.needs[function.name].context:
        found.append("ptr %context")
    return ", ".join(found)


def _begin(text: Text, *, is_entry: bool) -> None:
    for number, parameter in enumerate(text.function.parameters):
        leaves = registers_of(parameter.kind)
        text.held[parameter] = tuple(f"%a{number}.{i}" for i in range(len(leaves)))
    needs = text.needs[text.function.name]
    if is_entry and needs.context:
        text.slots.append("  %context = alloca [4 x i64], align 8")
        text.put(f"store ptr %trouble, ptr {text.offset('%context', 3)}, align 8")
        if needs.room:
            room = text.slot(ROOM, "room")
            text.put(f"store ptr {room}, ptr %context, align 8")
            text.put(f"store ptr {text.offset(room, ROOM)}, ptr {text.offset('%context', 1)}, align 8")
            text.put(f"store ptr null, ptr {text.offset('%context', 2)}, align 8")
    if needs.room:
        text.lines.append(f"  %entered = load ptr, ptr %context, align 8{text.location}")


def _free_before_returns(lines: list[str]) -> list[str]:
    """An entry gives back what was taken from the C library before each of its returns."""
    found = []
    for line in lines:
        if line.startswith("  ret "):
            location = line[line.index(", !dbg") :] if ", !dbg" in line else ""
            found.append(f"  call void @generator_free(ptr %context){location}")
        found.append(line)
    return found
