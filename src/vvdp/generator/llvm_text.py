"""The LLVM text of one function while it is written: its lines, its registers, and how values are held."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from vvdp.generator.kinds import (
    BOOL,
    FLOAT,
    INT,
    POINTER,
    Address,
    Kind,
    Known,
    Record,
    Row,
    Scalar,
    leaves,
    registers_of,
    size,
)
from vvdp.generator.tree import Function, Table, Variable

TYPES = {FLOAT: "double", INT: "i64", BOOL: "i1", POINTER: "ptr"}
SELDOM = 0
"""The number of the metadata of a branch that is seldom taken."""
Registers = tuple[str, ...]
"""The form in which a value is held: a number, the address of a record, or address and open lengths of an array."""


@dataclass
class Shared:
    """Requirements of the functions of a module besides themselves."""

    declared: dict[str, str] = field(default_factory=dict)
    tables: dict[str, str] = field(default_factory=dict)
    located: dict[str, int] = field(default_factory=dict)  # metadata by its text, for debug locations
    debug: bool = False
    inline: bool = False
    base: int = 0  # of the numbers of failures

    def metadata(self, text: str) -> int:
        """The number of a piece of metadata."""
        return self.located.setdefault(text, len(self.located))


@dataclass(frozen=True)
class Needs:
    """Arguments that a function needs besides its own: room for arrays, a place for its failure."""

    room: bool
    trouble: bool

    @property
    def context(self) -> bool:
        """Whether there is one more argument."""
        return self.room or self.trouble


class Text:
    """Lines of one function."""

    def __init__(self, function: Function, needs: dict[str, Needs], shared: Shared) -> None:
        self.function, self.needs, self.shared = function, needs, shared
        self.lines: list[str] = []
        self.slots: list[str] = []  # lines at the beginning of the function
        self.held: dict[Variable, Registers] = {}
        self.kept: dict[Variable, Registers] = {}  # addresses of variables that are set again
        self.loops: list[tuple[str, str]] = []  # where `break` and `continue` lead
        self.is_open = True  # whether the last line may go on to the next
        self.hoisted = True  # whether an array may have its room at the beginning of the function
        self.location = ""
        self._count = 0

    def name(self, hint: str = "") -> str:
        """A new register."""
        self._count += 1
        return f"%{hint}{self._count}"

    def label(self, hint: str) -> str:
        """A new name of a block."""
        self._count += 1
        return f"{hint}{self._count}"

    def put(self, line: str) -> None:
        """Writes an instruction without a result."""
        self.lines.append(f"  {line}{self.location}")

    def get(self, instruction: str) -> str:
        """Writes an instruction; the register of its result."""
        self._count += 1
        name = f"%{self._count}"
        self.lines.append(f"  {name} = {instruction}{self.location}")
        return name

    def begin(self, label: str) -> None:
        """Begins a block, which the one before goes on to."""
        if self.is_open:
            self.put(f"br label %{label}")
        self.lines.append(f"{label}:")
        self.is_open = True

    def end(self, line: str) -> None:
        """Ends a block."""
        self.put(line)
        self.is_open = False

    def slot(self, count: int, hint: str = "slot") -> str:
        """Room for so many numbers at the beginning of the function."""
        name = self.name(hint)
        kind = "i64" if count == 1 else f"[{max(1, count)} x i64]"
        self.slots.append(f"  {name} = alloca {kind}, align 8")
        return name

    def offset(self, address: str, count: int) -> str:
        """The address so many numbers of 8 bytes behind another."""
        return address if count == 0 else self.get(f"getelementptr inbounds i64, ptr {address}, i64 {count}")

    def load(self, leaf: Scalar | str, address: str) -> str:
        """A number from memory, where a truth takes 8 bytes like all others."""
        if leaf is BOOL:
            return self.get(f"trunc i64 {self.get(f'load i64, ptr {address}, align 8')} to i1")
        return self.get(f"load {TYPES[leaf]}, ptr {address}, align 8")

    def store(self, leaf: Scalar | str, register: str, address: str) -> None:
        """A number to memory."""
        if leaf is BOOL:
            register, leaf = self.get(f"zext i1 {register} to i64"), INT
        self.put(f"store {TYPES[leaf]} {register}, ptr {address}, align 8")

    def load_value(self, kind: Kind, address: str) -> Registers:
        """A value from memory; a record stays there."""
        if isinstance(kind, Record):
            return (address,)
        return tuple(self.load(leaf, self.offset(address, i)) for i, leaf in enumerate(leaves(kind)))

    def store_value(self, kind: Kind, registers: Registers, address: str) -> None:
        """A value to memory; a record is copied."""
        if isinstance(kind, Record):
            copied = f"ptr align 8 {address}, ptr align 8 {registers[0]}, i64 {8 * size(kind)}, i1 false"
            self.call("void", "llvm.memcpy.p0.p0.i64", copied, "ptr, ptr, i64, i1")
            return
        for i, (leaf, register) in enumerate(zip(leaves(kind), registers, strict=True)):
            self.store(leaf, register, self.offset(address, i))

    def call(self, result: str, name: str, arguments: str, types: str) -> str:
        """A call of a function that is declared, not defined, in the module."""
        self.shared.declared.setdefault(name, f"declare {result} @{name}({types})")
        instruction = f"call {result} @{name}({arguments})"
        if result != "void":
            return self.get(instruction)
        self.put(instruction)
        return ""

    def table(self, table: Table) -> Registers:
        """The address of known numbers."""
        if table.name not in self.shared.tables:
            kind = TYPES[table.kind.element]
            numbers = ", ".join(f"{kind} {constant(table.kind.element, n)}" for n in table.numbers)
            whole = f"[{len(table.numbers)} x {kind}]"
            value = f"[{numbers}]" if table.numbers else "zeroinitializer"
            self.shared.tables[table.name] = f"@{table.name} = internal unnamed_addr constant {whole} {value}, align 8"
        return (f"@{table.name}",)


def constant(kind: Scalar | str, value: Any) -> str:
    """A number as LLVM writes it: of a float the bits."""
    if kind is FLOAT:
        return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
    if kind is BOOL:
        return "true" if value else "false"
    return "null" if kind == POINTER else str(int(value))


def open_lengths(registers: Registers, kind: Kind, target: Kind) -> Registers:
    """The arguments for a value of one type where another is wanted that leaves more of its lengths open."""
    if not isinstance(kind, Row) or not isinstance(target, Row) or kind == target:
        return registers
    found, left = [registers[0]], list(registers[1:])
    for length, wanted in zip(kind.shape, target.shape, strict=True):
        number = str(length) if length is not None else left.pop(0)
        if wanted is None:
            found.append(number)
    return tuple(found)


def arguments_text(kinds: Sequence[Kind], values: Sequence[Registers]) -> str:
    """Arguments of a call."""
    pairs = zip(kinds, values, strict=True)
    return ", ".join(f"{TYPES[t]} {r}" for k, v in pairs for t, r in zip(registers_of(k), v, strict=True))


def result_type(kind: Kind) -> str:
    """The type that a function returns; a record is written where its first argument says."""
    return TYPES[kind] if isinstance(kind, Scalar) else "void"


def is_held_in_memory(kind: Kind) -> bool:
    """Whether a result is written to memory of the caller."""
    return not isinstance(kind, Scalar | Known | Address)
