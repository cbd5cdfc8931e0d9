"""The module of the tree as C99, for people to read and for any compiler: its header and its source.

An argument that is a number is handed over as such, an array by its address and its open lengths, a record by its
address. A result that is no number is written to the address `result` behind the arguments. A function that can fail
writes the number of the reason to `failure`. Arrays of known size are on the stack; what needs others is handed a
`workspace` of the caller. Nothing is kept between two calls, and nothing is taken from the heap.

Text and flags together give the bits of the other writers: `FLAGS`, without `-ffast-math` and its parts.
"""

import ast
import linecache
import re
from collections import Counter
from collections.abc import Container, Mapping
from dataclasses import dataclass
from functools import lru_cache

from vvdp.generator.c_arithmetic import GUARD, HELPERS, ROOM, SELDOM
from vvdp.generator.c_joining import join_steps
from vvdp.generator.c_room import room_of
from vvdp.generator.c_scopes import callees, expressions_in
from vvdp.generator.c_statements import result_record, write_block
from vvdp.generator.c_text import Shared, Text, identifier, length_names, wrap
from vvdp.generator.kinds import Kind, Known, Record, Row, Scalar
from vvdp.generator.library import C_LIBRARY
from vvdp.generator.llvm_statements import needs_of, statements_in
from vvdp.generator.llvm_text import Needs
from vvdp.generator.tree import Function, Library, Module, Variable
from vvdp.generator.verify import statement_operands

FLAGS = ("-std=c99", "-ffp-contract=off")
"""Flags of every compiler, besides that it leaves functions of the C library alone (`flags_for`)."""


LAST_NUMBER = re.compile(r"_f\d+$")
"""Suffix behind the name that a function has in Python."""
NAMES = re.compile(r"(?<![.\w])(?<!->)\w+")
"""Names in a line of C, without those of fields."""


@dataclass(frozen=True)
class CModule:
    """A module in C.

    header      types and entries
    source      the functions; it includes `<prefix>.h`
    functions   by name, the C name of each function
    flags       flags of the compiler
    needs       by name, whether a function takes `failure` and `workspace`
    types       the C names of records
    """

    header: str
    source: str
    functions: Mapping[str, str]
    flags: tuple[str, ...]
    needs: Mapping[str, Needs]
    types: Mapping[Kind, str]


def write_c(
    module: Module, prefix: str, supplied: Mapping[str, str] | None = None, often: Container[str] | None = None
) -> CModule:
    """The C text of a module.

    prefix     begins the name of everything that other text can see
    supplied   by the names of intrinsics, their C text, which defines a static function of that name
    often      names, in Python, of functions that run most of the time: the compiler is asked to make all others short
               but entries and what these call

    Raises ValueError where an intrinsic has no C text.
    """
    supplied = supplied or {}
    if missing := [name for name in module.intrinsics if name not in supplied]:
        raise ValueError(f"no C text for {', '.join(missing)}")
    module = join_steps(module)
    shared = Shared(prefix, len(module.reasons))
    for function in module.functions:
        entry = f"{prefix}_{function.name}" if function.name in module.entries else function.name
        shared.names[function.name] = identifier(entry, shared.names.values())
    functions, heads = list[str](), list[str]()
    visible, seldom = 0, set[str]() if often is None else _seldom(module, often)
    for function in module.functions:
        found = needs_of(function, shared.needs)
        shared.needs[function.name] = Needs(found.room, found.trouble or found.room)
        head, body = _function(function, shared, is_entry=function.name in module.entries)
        functions.append(f"{_comment(function)}{'SELDOM ' if function.name in seldom else ''}{head}\n{body}")
        if function.name in module.entries:
            heads.append(f"{_comment(function)}{head};\n")
            visible = len(shared.types)
    return CModule(
        header=_header(shared, visible, heads, module),
        source=_source(shared, visible, functions, [supplied[name] for name in module.intrinsics]),
        functions=dict(shared.names),
        flags=flags_for(module, supplied),
        needs=dict(shared.needs),
        types=dict(shared.structs),
    )


def _seldom(module: Module, often: Container[str]) -> set[str]:
    """The names of functions that are neither entries, nor run often, nor called by any of these that is no entry."""
    found = set[str]()
    for function in reversed(module.functions):  # callers first
        if function.name in found or LAST_NUMBER.sub("", function.name) in often:
            found |= {function.name, *(each.name for each in callees(function))}
    return {each.name for each in module.functions} - found - set(module.entries)


def flags_for(module: Module, supplied: Mapping[str, str]) -> tuple[str, ...]:
    """Flags of the compiler: no contraction, no other functions in place of those of the C library."""
    words = {word for name in module.intrinsics for word in re.findall(r"\w+(?=\()", supplied[name])}
    used = {
        each.name
        for function in module.functions
        for statement in statements_in(function.body)
        for operand in statement_operands(statement)
        for each in expressions_in(operand)
        if isinstance(each, Library) and each.name in C_LIBRARY
    }
    used |= {name for name in C_LIBRARY if name in words}
    return (*FLAGS, *(f"-fno-builtin-{name}" for name in sorted(used)))


def _function(function: Function, shared: Shared, *, is_entry: bool) -> tuple[str, str]:
    text = Text(function, shared)
    write_block(text, function.body)
    text.optional.add("entered")
    needs = shared.needs[function.name]
    start = ["    *failure = 0;"] if needs.trouble and is_entry else []
    start += [f"    const {shared.prefix}_workspace entered = *workspace;"] if needs.room else []
    body = text.lines[:-1] if text.lines[-1:] == ["    return;"] else text.lines
    lines = _without_unused([*text.rooms, *start, *body], text.optional)
    words = set(NAMES.findall("\n".join(lines)))
    names = [name for each in function.parameters for name in _argument_names(text, each)]
    names += ["failure"] * needs.trouble + ["workspace"] * needs.room
    unused = [f"    (void){name};" for name in names if name not in words]
    kind = shared.type_of(function.result) if isinstance(function.result, Scalar) else "void"
    arguments = ", ".join(_parameters(text, needs)) or "void"
    head = wrap(f"{'' if is_entry else 'static '}{kind} {shared.names[function.name]}({arguments})")
    return head, "\n".join(["{", *unused, *map(wrap, lines), "}\n"])


def _without_unused(lines: list[str], optional: set[str]) -> list[str]:
    """The lines without those that only assign what is not read."""
    while True:
        reads = Counter(word for line in lines for word in _words_read(line, optional))
        kept = [line for line in lines if not ((name := _target(line, optional)) and not reads[name])]
        if len(kept) == len(lines):
            return kept
        lines = kept


def _target(line: str, optional: set[str]) -> str:
    """The name that a line declares or assigns, if it may be left out."""
    found = re.match(r"\s*(?:[\w ]+ \*?)?(\w+)(?: = [^;]*)?;$", line)
    return found[1] if found and found[1] in optional and "return " not in line else ""


def _words_read(line: str, optional: set[str]) -> list[str]:
    words = NAMES.findall(line)
    if name := _target(line, optional):
        words.remove(name)
    return words


def _argument_names(text: Text, parameter: Variable) -> list[str]:
    name = text.name(parameter)
    return [name, *length_names(name, parameter.kind)] if isinstance(parameter.kind, Row) else [name]


def _parameters(text: Text, needs: Needs) -> list[str]:
    function, shared = text.function, text.shared
    found = []
    for each in function.parameters:
        name = text.name(each)
        if isinstance(each.kind, Row):
            found.append(f"{text.row_type(each)}{name}")
            found += [f"int64_t {length}" for length in length_names(name, each.kind)]
        elif isinstance(each.kind, Record):
            found.append(f"const {shared.type_of(each.kind)} *{name}")
        else:
            found.append(f"{shared.type_of(each.kind)} {name}")
    if isinstance(function.result, Record | Row) and not isinstance(function.result, Known):
        found.append(f"{shared.type_of(result_record(function.result))} *result")
    found += ["int64_t *failure"] * needs.trouble
    return found + [f"{shared.prefix}_workspace *workspace"] * needs.room


def _comment(function: Function) -> str:
    """Comment on a function: the first sentence of its docstring, and where its Python text stands."""
    words = _summaries(function.file, tuple(linecache.getlines(function.file))).get(function.line, "")
    where = f"{shown_file(function.file)}:{function.line}"
    return wrap(f"/* {words.replace('*/', '* /')} {where} */".replace("/*  ", "/* ")) + "\n"


def shown_file(file: str) -> str:
    """The name of a file as text that travels shows it: from its package on."""
    if file.startswith("<"):
        return "text written for this module"
    return file[file.rindex("/vvdp/") + 1 :] if "/vvdp/" in file else file.rpartition("/")[2]


@lru_cache(maxsize=512)
def _summaries(file: str, lines: tuple[str, ...]) -> dict[int, str]:
    """By the line of its `def`, the first sentence of a function's docstring."""
    found = {}
    for node in ast.walk(ast.parse("".join(lines), file)):
        if isinstance(node, ast.FunctionDef) and (words := ast.get_docstring(node)):
            first = re.split(r"(?<=[.!?])\s|\n\n", words, maxsplit=1)[0]
            found[node.lineno] = " ".join(first.split())
    return found


WORKSPACE = """\
/* Room for arrays whose lengths are known only when the code runs: free numbers, and how many.
{amounts} */
typedef struct {{
    double *reals;
    int64_t reals_left;
    int64_t *wholes;
    int64_t wholes_left;
}} {prefix}_workspace;
"""


def _header(shared: Shared, visible: int, heads: list[str], module: Module) -> str:
    guard, room, reasons = f"{shared.prefix.upper()}_H", "", module.reasons
    if any(needs.room for needs in shared.needs.values()):
        room = WORKSPACE.format(prefix=shared.prefix, amounts=_amounts(shared, module))
    failures = [f" * {number}: {_shown_reason(reason)}\n" for number, reason in enumerate(reasons, 1)]
    if room:
        failures.append(f" * {len(reasons) + 1}: the workspace is too small\n")
    said = f"/* Numbers of failures:\n{''.join(failures)} */\n" if failures else ""
    parts = [f"#ifndef {guard}\n#define {guard}\n\n#include <stdbool.h>\n#include <stdint.h>\n", said, room]
    return "\n".join([*filter(None, parts), *shared.types[:visible], *heads, "#endif\n"])


def _amounts(shared: Shared, module: Module) -> str:
    """How much room each entry takes, in the lines of a comment."""
    lines, found = [], room_of(module)
    for name in module.entries:
        amount = found[name]
        words = "depends on the arguments" if amount is None else f"{amount[0]} reals, {amount[1]} wholes at most"
        lines += [f" * {shared.names[name]}: {words}\n"] if shared.needs[name].room else []
    return "".join(lines)


def _shown_reason(reason: str) -> str:
    file, _, rest = reason.partition(":")
    return f"{shown_file(file)}:{rest}".replace("*/", "* /")


def _source(shared: Shared, visible: int, functions: list[str], supplied: list[str]) -> str:
    heads = ["#include <float.h>\n#include <math.h>\n#include <stddef.h>\n#include <string.h>\n"]
    heads = [f'#include "{shared.prefix}.h"\n\n{heads[0]}', GUARD]
    words = set(re.findall(r"\w+", "\n".join([*supplied, *functions])))
    helpers = [SELDOM] * ("SELDOM" in words) + [text for name, text in HELPERS.items() if name in words]
    rooms = {"take_reals": ("double", "reals"), "take_wholes": ("int64_t", "wholes")}
    for name, (kind, free) in rooms.items():
        if name in words:
            said = {"words": "floats" if kind == "double" else "whole numbers", "number": shared.failures + 1}
            own = f"{shared.prefix}_workspace"
            helpers.append(ROOM.format(kind=kind, name=name, workspace=own, free=free, left=f"{free}_left", **said))
    return "\n".join(
        [
            *heads,
            *helpers,
            *supplied,
            *shared.types[visible:],
            *shared.symbols.values(),
            *shared.tables.values(),
            *functions,
        ]
    )
