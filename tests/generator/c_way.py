"""The entries of a module as C: compiled by the C compiler of this machine, and called from Python."""

import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vvdp.generator.c_text import Shared, length_names
from vvdp.generator.c_writer import CModule, write_c
from vvdp.generator.kinds import BOOL, FLOAT, INT, Address, Kind, Known, Record, Row, Scalar
from vvdp.generator.library import Failure
from vvdp.generator.tree import Function, Module
from vvdp.generator.values import tuple_of

NUMBERS: dict[Kind, Any] = {FLOAT: ctypes.c_double, INT: ctypes.c_int64, BOOL: ctypes.c_bool}
CLEAN = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Wshadow", "-Werror")
"""What a text must pass without a warning."""
ROOM = 1_000_000
"""Numbers in the workspace of a call."""


class Workspace(ctypes.Structure):
    """Free numbers, and how many there are."""

    _fields_ = (
        ("reals", ctypes.c_void_p),
        ("reals_left", ctypes.c_int64),
        ("wholes", ctypes.c_void_p),
        ("wholes_left", ctypes.c_int64),
    )


@cache
def compilers() -> tuple[str, ...]:
    """The C compilers of this machine. Where there is none, says so, or fails if `VVDP_REQUIRE` names cc."""
    clangs = (shutil.which(name) for name in ("clang", *(f"clang-{version}" for version in range(21, 10, -1))))
    found = tuple(filter(None, (shutil.which("gcc") or shutil.which("cc"), next(filter(None, clangs), None))))
    if not found:
        message = "NOT TESTED: the text in C, since there is no C compiler"
        if "cc" in os.environ.get("VVDP_REQUIRE", "").split(","):
            pytest.fail(f"{message}, and VVDP_REQUIRE demands it")
        print(message, file=sys.stderr)
    return found


def compile_c(made: CModule, compiler: str, extra: tuple[str, ...] = ("-O1",)) -> ctypes.CDLL:
    """A module in C as a library in this process. Raises CalledProcessError with what the compiler said."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "m.h").write_text(made.header, "utf-8")
        Path(folder, "m.c").write_text(made.source, "utf-8")
        command = [compiler, *made.flags, *extra, "-fPIC", "-shared", "-o", "m.so", "m.c", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            numbered = "\n".join(f"{i:4} {line}" for i, line in enumerate(made.source.splitlines(), 1))
            raise AssertionError(f"{done.stderr[:4000]}\n{made.header}\n{numbered}"[:20000])
        return ctypes.CDLL(f"{folder}/m.so")


def c_entries(
    module: Module, compiler: str, extra: tuple[str, ...] = ("-O1",), supplied: Mapping[str, str] | None = None
) -> dict[str, Callable[..., Any]]:
    """The entries of a module as functions of Python values."""
    made = write_c(module, "m", supplied)
    library = compile_c(made, compiler, extra)
    return {f.name: _callable(f, library, made, module) for f in module.functions if f.name in module.entries}


@cache
def structure(kind: Record) -> Any:
    """A record as ctypes has it."""
    members: list[tuple[str, Any]] = []
    for name, each in Shared.members(kind):
        members.append((name, _c_type(each)))
        if isinstance(each, Row):
            members += [(length, ctypes.c_int64) for length in length_names(name, each)]
    return type("Struct", (ctypes.Structure,), {"_fields_": members or [("none", ctypes.c_char)]})


def _c_type(kind: Kind) -> Any:
    if isinstance(kind, Record):
        return structure(kind)
    return ctypes.c_void_p if isinstance(kind, Row | Address) else NUMBERS[kind]


def _callable(function: Function, library: ctypes.CDLL, made: CModule, module: Module) -> Any:
    run = getattr(library, made.functions[function.name])
    result, needs = function.result, made.needs[function.name]
    run.restype = NUMBERS[result] if isinstance(result, Scalar) else None

    def call(*values: Any) -> Any:
        handed: list[Any] = []
        for value, parameter in zip(values, function.parameters, strict=True):
            handed += _argument(value, parameter.kind)
        failure, found = ctypes.c_int64(0), structure(result)() if isinstance(result, Record) else None
        if found is not None:
            handed.append(ctypes.byref(found))
        if needs.trouble:
            handed.append(ctypes.byref(failure))
        if needs.room:
            reals, wholes = np.zeros(ROOM), np.zeros(ROOM, np.int64)
            handed.append(ctypes.byref(Workspace(reals.ctypes.data, ROOM, wholes.ctypes.data, ROOM)))
        answer = run(*handed)
        if failure.value:
            raise Failure(module.reasons[failure.value - 1] if failure.value <= len(module.reasons) else "no room")
        if isinstance(result, Known):
            return result.value
        return _record(found, result) if isinstance(result, Record) else answer

    return call


def _argument(value: Any, kind: Kind) -> list[Any]:
    if isinstance(kind, Record):
        return [ctypes.byref(_filled(value, kind))]
    if isinstance(kind, Row):
        address, *lengths = _row(value, kind)
        return [ctypes.c_void_p(address), *map(ctypes.c_int64, lengths)]
    return [ctypes.c_void_p(int(value)) if isinstance(kind, Address) else NUMBERS[kind](value)]


def _row(value: Any, kind: Row) -> list[int]:
    assert value.dtype == kind.element.value and value.flags.c_contiguous
    return [value.ctypes.data, *(n for n, wanted in zip(value.shape, kind.shape, strict=True) if wanted is None)]


def _filled(value: Any, kind: Record) -> Any:
    found, names = structure(kind)(), getattr(kind.cls, "_fields", range(len(kind.fields)))
    members = iter(Shared.members(kind))
    for name, each in zip(names, kind.fields, strict=True):
        if isinstance(each, Known):
            continue
        member, part = next(members)[0], value[name] if isinstance(name, int) else getattr(value, name)
        if isinstance(each, Row):
            address, *lengths = _row(part, each)
            setattr(found, member, address)
            for length, number in zip(length_names(member, each), lengths, strict=True):
                setattr(found, length, number)
        else:
            setattr(found, member, _filled(part, each) if isinstance(each, Record) else part)
    return found


def _record(found: Any, kind: Record) -> Any:
    members, parts = iter(Shared.members(kind)), []
    for each in kind.fields:
        if isinstance(each, Known):
            parts.append(each.value)
            continue
        part = getattr(found, next(members)[0])
        parts.append(_record(part, each) if isinstance(each, Record) else part)
    return tuple_of(kind.cls, parts)
