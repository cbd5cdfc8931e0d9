"""Programs of a user's own in a file that draws its circuit: `type = "my_module:HOLD"`."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from vvdp.base.errors import ParameterError
from vvdp.base.tables import Table, nearest
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.systems.circuits import load_module
from vvdp.systems.own_modules import module_name


def own_code(content: Mapping[str, object]) -> Any:
    """Code of the user that a file names: its circuit, else the type of its first program with a module."""
    return content["circuit"] if "circuit" in content else next(_own_types(content), None)


def named_code(content: Mapping[str, object]) -> dict[str, str]:
    """All code that a run of a file executes, by what the file calls it: what kind of code it is."""
    own, programs = own_code(content), content.get("programs")
    parts = programs.values() if isinstance(programs, Mapping) else ()
    files = [part.get("fmu") for part in parts if isinstance(part, Mapping)]
    found = {own: "Python code"} if isinstance(own, str) else {}
    return found | {str(Path(file)): "an FMU with machine code" for file in files if isinstance(file, str)}


def _own_types(content: Mapping[str, object]) -> Iterator[str]:
    programs = content.get("programs")
    for part in programs.values() if isinstance(programs, Mapping) else ():
        word = part.get("type") if isinstance(part, Mapping) else None
        if isinstance(word, str) and ":" in word:
            yield word


def absolute_fmus(table: Table, folder: Path) -> Table:
    """The table in which the path of each FMU leads there from any place; paths of a file begin in its `folder`."""
    programs = table.content.get("programs")
    if not isinstance(programs, Mapping):
        return table
    foreign = {
        name: {**part, "fmu": str((folder / part["fmu"]).absolute())}
        for name, part in programs.items()
        if isinstance(part, Mapping) and isinstance(part.get("fmu"), str)
    }
    return replace(table, content={**table.content, "programs": {**programs, **foreign}}) if foreign else table


def own_program(word: str, content: Mapping[str, object], folder: Path) -> ProgramType | GenericProgram:
    """The program that `word`, "module:NAME", names; its module is looked for in `folder` first.

    All programs of a file are of one module: it is the one that a saved run may run again. Raises ParameterError.
    """
    name, attribute = module_name(word), word.partition(":")[2]
    if name != (first := module_name(own_code(content))):
        raise ParameterError(f"{word!r}: programs of your own are in one module; {first!r} is named before")
    known = vars(load_module(name, folder))
    found = known.get(attribute)
    if not isinstance(found, ProgramType | GenericProgram):
        programs = [key for key, value in known.items() if isinstance(value, ProgramType | GenericProgram)]
        what = "is no ProgramType" if attribute in known else "is not there"
        raise ParameterError(f"{attribute!r} {what} in {name}{nearest(attribute, programs)}")
    return found
