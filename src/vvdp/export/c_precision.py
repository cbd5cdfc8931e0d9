"""Steps that may be exported in single precision, and their text in it.

A float has 24 digits of two: it resolves the time since the beginning to 2.4e-4 s after an hour, and an angle of a
thousand revolutions to 4.9e-4 rad. A step that works with such numbers is refused. Allowed are steps that state that no
number of theirs grows (`Program.is_bounded`), and those that neither ask for the time nor have a quantity that grows.
"""

import ast
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import TIME
from vvdp.export.c_parts import KEPT, OUT, Block, CPart, Precision
from vvdp.generator.c_single import fits_single, require_single, single_module
from vvdp.generator.source import read_source
from vvdp.simulation.model import Program
from vvdp.simulation.values import leaves


def in_single(part: CPart) -> CPart:
    """The same part in single precision.

    Raises ConfigError for a circuit, for a step whose contract does not allow single precision, and for values that a
    float cannot hold; LanguageError, with file and line, for such a literal.
    """
    if part.program is None:
        raise refusal(part.part, "only the step of a program can be exported in single precision")
    if reason := next(growing(part.program, part.entries[0].blocks), ""):
        raise refusal(part.part, f"its step does not allow single precision: {reason}")
    for block in part.entries[0].arguments:
        for path, number in numbers_of(block.value):
            if not fits_single(number):
                raise refusal(part.part, f"{block.name}.{path}, {number:g}, is no number of single precision")
    require_single(part.module)
    return replace(part, core=single_module(part.core), precision=Precision.SINGLE)


def growing(program: Program, blocks: tuple[Block, ...]) -> Iterator[str]:
    """Reasons, in words, why the step of a program works with numbers that grow with the time for which it runs."""
    if program.is_bounded:
        return
    if asks_for_time(program.step):
        yield "it works with the time since the beginning, t"
    for block in blocks:
        for path, _, kind in leaves(block.value) if block.role in (KEPT, OUT) or block.drawn else ():
            if kind is not None and (kind.accumulates or kind is TIME):
                yield f"{block.name}.{path} is {kind.with_article}, which grows with the time for which it runs"


def asks_for_time(step: Any) -> bool:
    """Whether a step reads its first argument."""
    source = read_source(step)
    first = source.node.args.args[0].arg
    return any(isinstance(node, ast.Name) and node.id == first for node in ast.walk(source.node))


def numbers_of(value: Any) -> Iterator[tuple[str, float]]:
    """Path and value of each number of nested values."""
    for path, found, _ in leaves(value):
        numbers = [found] if isinstance(found, float) else list(found.ravel()) if hasattr(found, "ravel") else []
        yield from ((path, float(number)) for number in numbers)


def refusal(part: str, reason: str) -> ConfigError:
    """The error of a part that cannot be exported in single precision."""
    return ConfigError([Fault("--precision", 0, "single", f"{part}: {reason}")])
