"""Functions that are compiled together: their hash, their code from the cache, and their entries in this process.

The hash is that of their texts, of all functions and constants that these reach, and of what compiles them: a changed
formula anywhere is never served from an old cache, and what has not changed is not compiled again.
"""

import hashlib
import json
import platform
from collections.abc import Callable, Mapping, Sequence
from functools import cache as remembered
from pathlib import Path

import numpy as np

from vvdp.base.errors import RunError
from vvdp.base.interrupts import interruptible
from vvdp.generator.calls import Entry
from vvdp.generator.kinds import External, Known
from vvdp.generator.source import LanguageError
from vvdp.simulation.cache import is_kept, keep, one_at_a_time, quiet, read_kept
from vvdp.simulation.exchange import outside_symbols
from vvdp.simulation.parts import Part
from vvdp.simulation.reach import Functions, reachable, words
from vvdp.simulation.values import names

WRITERS = ("assembly", "dialect", "exchange", "flat", "in_place", "lane_math", "lane_values", "lane_vectors", "queue")
BASE = ("powers", "select", "signal")
"""Modules by which, or with which, code is made, whatever the model; the generator itself is one more."""
SECONDS_EACH, SECONDS_PER_BYTE = 0.02, 4e-5
"""About how long functions take to compile, and each byte of the bytecode that they reach, on a core of 2024 [s]."""
MOST_WRITTEN_OUT = 3000
"""Statements up to which calls are copied to their place; larger circuits than the shipped ones compile far longer."""
_LOADED: dict[str, "Assembled"] = {}


def about(seconds: float) -> str:
    """A time to wait in words."""
    return f"about {max(1.0, seconds):.0f} s"


class Assembled:
    """Compiled functions in this process, by name."""

    def __init__(self, entries: Mapping[str, Entry]) -> None:
        self.entries = entries

    def __getitem__(self, name: str) -> Entry:
        return self.entries[name]


class Compiling(str):
    """Notice that something is compiled; `seconds` is about how long that takes [s]."""

    seconds: float

    def __new__(cls, what: str, seconds: float) -> "Compiling":
        made = super().__new__(cls, f"compiling {what} (first use only): {about(seconds)}")
        made.seconds = seconds
        return made


class Assembly:
    """Functions over flat vectors that are compiled together; `digest` is the hash of all of their text.

    inline   whether calls are copied to their place, which suits formulas; not where that would be too much
    checked  whether bounds, divisions, whole numbers and assertions are checked while the code runs

    Raises RunError where a function cannot be hashed, with its name.
    """

    def __init__(self, parts: Sequence[Part], title: str = "", *, inline: bool = False, checked: bool = False) -> None:
        self.parts, self.title, self.inline, self.checked = tuple(parts), title, inline, checked
        self.functions: Functions = {}
        found = [f"{inline} {checked}", _versions()]
        for part in parts:
            for function in part.called.values():
                if isinstance(function, External):
                    found.append(function.name)
                else:
                    reachable(function, self.functions)
            classes = [(cls.__module__, cls.__qualname__, names(cls)) for cls in part.classes.names]
            found += [part.source, repr(classes)]
        found += words(self.functions)
        self.digest = hashlib.sha256("\n".join(found).encode()).hexdigest()[:16]

    @property
    def seconds(self) -> float:
        """About how long it takes to compile [s]."""
        return SECONDS_EACH + SECONDS_PER_BYTE * sum(len(f.__code__.co_code) for f, _ in self.functions.values())

    def is_at_hand(self, cache: Path) -> bool:
        """Whether nothing has to be compiled."""
        return self.digest in _LOADED or is_kept(self.digest, cache)

    def symbol(self, name: str) -> str:
        """The name under which other modules call a function of this one."""
        return f"{name}_{self.digest}"

    def failure_number(self, place: int) -> int:
        """The number by which its code shows a failure, from the place of its reason."""
        return self._base + place + 1

    def load(
        self,
        cache: Path,
        say: Callable[[str], None] = quiet,
        symbols: Mapping[str, Entry] | None = None,
        *,
        announced: bool = False,
    ) -> Assembled:
        """The compiled functions, from the cache or compiled into it.

        symbols    what the functions call in other modules, by symbol; it stays in memory with them
        announced  whether it is known already that this is compiled
        """
        with one_at_a_time:
            if self.digest not in _LOADED:
                code = read_kept(self.digest, cache)
                if code is None:
                    if is_kept(self.digest, cache):
                        say(f"compiled code in {cache} is damaged; compiling it again")
                    elif self.title and not announced:
                        say(Compiling(self.title, self.seconds))
                    code = self._compile()
                    keep(self.digest, code, cache)
                _LOADED[self.digest] = self._entries(code, symbols)
            return _LOADED[self.digest]

    def llvm_text(self, *, debug: bool = False, fused: bool | None = None) -> tuple[str, tuple[str, ...]]:
        """The LLVM text, and the reasons of its failures. Raises RunError where the language lacks something.

        fused  whether powers multiply and add with one rounding; by default where this processor does
        """
        from vvdp.generator.llvm_writer import (  # what reads and writes is loaded where it is needed
            write_llvm,
            written_out,
        )
        from vvdp.generator.unit import Unit
        from vvdp.generator.verify import verify
        from vvdp.simulation.dialect import model_options

        unit = Unit(model_options(checked=self.checked, fused=fused))
        try:
            for part in self.parts:
                unit.add(part.function(), part.kinds, part.name)
        except LanguageError as problem:
            raise RunError(str(problem)) from None
        module = verify(unit.module())
        inline = self.inline and written_out(module) <= MOST_WRITTEN_OUT
        return write_llvm(module, inline=inline, base=self._base, debug=debug), module.reasons

    @property
    def _base(self) -> int:
        """Offset of the numbers of failures, so that those of other modules differ."""
        return int(self.digest[:10], 16) << 16

    def _compile(self) -> bytes:
        from vvdp.generator import binding

        text, reasons = self.llvm_text()
        return json.dumps(reasons).encode() + b"\n" + interruptible(lambda: binding.compile_text(text))

    def _entries(self, code: bytes, symbols: Mapping[str, Entry] | None) -> Assembled:
        from vvdp.generator import binding  # llvmlite is loaded here, and only here

        reasons, _, code = code.partition(b"\n")
        called = dict(symbols or {})
        addresses = outside_symbols() | {name: int(entry) for name, entry in called.items()}
        loaded = binding.load_code(code, [part.name for part in self.parts], addresses)
        found = {}
        add_reasons(self._base, json.loads(reasons))
        for part in self.parts:
            result = part.result or Known(None)
            found[part.name] = Entry(loaded.addresses[part.name], part.kinds, result, reason_of, (loaded, called))
        return Assembled(found)


_REASONS: dict[int, Sequence[str]] = {}


def add_reasons(base: int, reasons: Sequence[str]) -> None:
    """Note why code may fail whose failures are numbered from `base` + 1 on."""
    _REASONS[base >> 16] = reasons


def reason_of(number: int) -> str:
    """Why code failed: file, line and reason."""
    return _REASONS[number >> 16][(number & 0xFFFF) - 1]


@remembered
def _versions() -> str:
    """Versions that compiled code depends on besides the model."""
    from vvdp.generator import binding

    found, here = hashlib.sha256(), Path(__file__).parent
    own = [here / f"{name}.py" for name in WRITERS] + [here.parent / "base" / f"{name}.py" for name in BASE]
    for path in [*own, *sorted((here.parent / "generator").glob("*.py"))]:
        found.update(path.read_bytes())
    return f"{platform.python_version()} {np.__version__} {binding.version()} {found.hexdigest()}"
