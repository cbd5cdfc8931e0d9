"""C names, types and numbers, what the functions of a module share, and the text of one of them."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from vvdp.generator.c_scopes import Scopes, changed_rows, scopes_of
from vvdp.generator.kinds import BOOL, FLOAT, INT, Address, Kind, Known, Record, Row, Scalar
from vvdp.generator.library import C_LIBRARY, EXACT
from vvdp.generator.llvm_text import Needs
from vvdp.generator.tree import Function, Table, Variable

TYPES = {FLOAT: "double", INT: "int64_t", BOOL: "bool"}
WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false
NULL NAN INFINITY asm typeof SELDOM
"""
WORDS_OF_C = frozenset(WORDS.split())
RESERVED = WORDS_OF_C.union(
    ["fma", "j0", "j1", "jn", "y0", "y1", "yn", "gamma", "main", "result", "failure", "workspace", "entered"],
    C_LIBRARY,
    EXACT,
)
"""Words of C, functions of its library, and names of arguments that a function may have besides its own."""
Held = tuple[str, ...]
"""The form in which a value is written: a number or record, or the address of an array and its open lengths."""


class RowResult(NamedTuple):
    """An array as the result of a function."""

    at: Any


def identifier(name: str, taken: Iterable[str] = (), reserved: frozenset[str] = RESERVED) -> str:
    """A name in C like `name`, other than those that are taken or reserved."""
    plain = re.sub(r"\W", lambda m: f"u{ord(m[0]):x}", name, flags=re.ASCII) or "value"
    plain = f"v{plain}" if plain[0].isdigit() or plain.startswith("__") else plain
    found, number = plain, 1
    while found in reserved or found in taken:
        number += 1
        found = f"{plain}{number}" if not plain[-1].isdigit() else f"{plain}_{number}"
    return found


def member_name(name: str) -> str:
    """The name of a field in C."""
    return identifier(name, reserved=WORDS_OF_C)


def length_names(name: str, kind: Row) -> list[str]:
    """The names of the open lengths of an array."""
    open_ = [axis for axis, length in enumerate(kind.shape) if length is None]
    return [f"{name}_length"] if len(kind.shape) == 1 and open_ else [f"{name}_length_{axis}" for axis in open_]


def constant(kind: Scalar, value: Any) -> str:
    """A number in C: the shortest decimal that gives its bits."""
    if kind is BOOL:
        return "true" if value else "false"
    if kind is INT:
        if value == -(2**63):
            return "INT64_MIN"
        return str(value) if -(2**31) < value < 2**31 else f"INT64_C({value})"
    if math.isfinite(value):
        return repr(float(value))
    return "NAN" if math.isnan(value) else "INFINITY" if value > 0 else "-INFINITY"


@dataclass
class Shared:
    """Requirements of the functions of a module besides themselves."""

    prefix: str
    failures: int
    structs: dict[Kind, str] = field(default_factory=dict)
    types: list[str] = field(default_factory=list)  # definitions in order
    tables: dict[str, str] = field(default_factory=dict)
    symbols: dict[str, str] = field(default_factory=dict)  # addresses of functions of other modules
    needs: dict[str, Needs] = field(default_factory=dict)
    changed: dict[str, set[Variable]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)  # of functions

    def type_of(self, kind: Kind) -> str:
        """The C type of a number, a record or an address of a function; of an array that of its numbers."""
        if isinstance(kind, Scalar):
            return TYPES[kind]
        if isinstance(kind, Row):
            return TYPES[kind.element]
        if kind not in self.structs:
            assert isinstance(kind, Record | Address)
            text = self._record(kind) if isinstance(kind, Record) else self._address(kind)
            self.types.append(text)
        return self.structs[kind]

    def _record(self, kind: Record) -> str:
        members = [line for name, each in self.members(kind) for line in self._members_of(name, each)]
        name = self._name(kind, kind.cls.__name__)
        return f"typedef struct {{\n{''.join(members) or '    char none;' + chr(10)}}} {name};\n"

    def _members_of(self, name: str, kind: Kind) -> list[str]:
        if isinstance(kind, Row):
            lengths = [f"    int64_t {each};\n" for each in length_names(name, kind)]
            return [f"    {self.type_of(kind)} *{name};\n", *lengths]
        return [f"    {self.type_of(kind)} {name};\n"]

    def _address(self, kind: Address) -> str:
        arguments = [self.type_of(k) if isinstance(k, Scalar) else "" for k in kind.arguments]
        for number, each in enumerate(kind.arguments):
            if isinstance(each, Row):
                arguments[number] = ", ".join([f"{self.type_of(each)} *", *["int64_t"] * len(length_names("", each))])
            elif not isinstance(each, Scalar):
                arguments[number] = f"const {self.type_of(each)} *"
        result = "void" if kind.result is None else TYPES[kind.result]
        name = self._name(kind, "function")
        return f"typedef {result} (*{name})({', '.join([*filter(None, arguments), 'int64_t *'])});\n"

    def _name(self, kind: Kind, name: str) -> str:
        found = identifier(f"{self.prefix}_{name}", self.structs.values())
        self.structs[kind] = found
        return found

    @staticmethod
    def members(kind: Record) -> list[tuple[str, Kind]]:
        """Name and type of each field that is not known."""
        names = getattr(kind.cls, "_fields", None) or [f"item_{i}" for i in range(len(kind.fields))]
        pairs = zip(names, kind.fields, strict=True)
        return [(member_name(name), each) for name, each in pairs if not isinstance(each, Known)]

    @staticmethod
    def member(kind: Record, number: int) -> str:
        """The name of a field."""
        names = getattr(kind.cls, "_fields", None)
        return member_name(names[number]) if names else f"item_{number}"

    def table(self, table: Table) -> str:
        """The name of known numbers."""
        if table.name not in self.tables:
            numbers = [constant(table.kind.element, n) for n in table.numbers] or ["0"]
            head = f"static const {self.type_of(table.kind)} {table.name}[{len(numbers)}] = {{"
            self.tables[table.name] = "\n".join([head, wrap(f"    {', '.join(numbers)}"), "};\n"])
        return table.name


class Text:
    """The C text of one function while it is written."""

    def __init__(self, function: Function, shared: Shared) -> None:
        self.function, self.shared = function, shared
        self.scopes: Scopes = scopes_of(function)
        self.changed = shared.changed.setdefault(function.name, changed_rows(function, shared.changed))
        self.needs = shared.needs
        self.own = shared.needs[function.name]
        self.lines: list[str] = []
        self.rooms: list[str] = []  # arrays of known size, which live as long as the function
        self.optional: set[str] = set()  # names that are not declared if nothing reads them
        self.depth = 1
        self.loops: list[str] = []  # what notes that a loop was left; empty where nothing asks
        self.hoisted = True  # whether an array may have its room at the beginning of the function
        self.parameters = set(function.parameters)
        self._names: dict[Variable, str] = {}
        self._taken: set[str] = set(shared.names.values())
        for each in function.parameters:
            self.name(each)

    def name(self, variable: Variable) -> str:
        """The name of a variable."""
        if variable not in self._names:
            own = variable.name if variable in self.parameters else re.sub(r"(?<=.)_\d+_?$", "", variable.name)
            name = self.new_name(own)
            self._names[variable] = name
            if isinstance(variable.kind, Row):
                self._taken.update(length_names(name, variable.kind))
        return self._names[variable]

    def new_name(self, like: str) -> str:
        """A name that nothing has yet."""
        found = identifier(like, self._taken)
        self._taken.add(found)
        return found

    def put(self, line: str) -> None:
        """Writes a line."""
        self.lines.append("    " * self.depth + line)

    def row_type(self, variable: Variable) -> str:
        """The C type of the address of an array."""
        kind = self.shared.type_of(variable.kind)
        return f"{kind} *" if variable in self.changed else f"const {kind} *"

    def is_fixed(self, variable: Variable) -> bool:
        """Whether a variable never changes."""
        return variable not in self.scopes.again

    def by_address(self, variable: Variable) -> bool:
        """Whether a name is that of the address of a record."""
        return variable in self.parameters and isinstance(variable.kind, Record)


WIDTH = 116


def wrap(line: str) -> str:
    """A line in several where it is long, broken behind commas or else at spaces, each after the first further in."""
    indent = len(line) - len(line.lstrip())
    found = []
    while len(line) > WIDTH:
        place = max(line.rfind(", ", indent + 40, WIDTH - 1) + 1, 0) or line.rfind(" ", indent + 12, WIDTH)
        if place <= 0:
            break
        found.append(line[:place])
        line = " " * (indent + 8) + line[place + 1 :]
    return "\n".join([*found, line])
