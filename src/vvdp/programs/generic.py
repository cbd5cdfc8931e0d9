"""A program for any physical quantity."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from vvdp.base.errors import Fault
from vvdp.base.kinds import Kind
from vvdp.base.params import Params, field_kinds
from vvdp.network.program import ProgramType
from vvdp.programs.quantities import OUTPUT, replacements, with_kinds

Written = Mapping[str, object]
"""The values of a program as a file gives them."""


def as_read(read: Sequence[Kind], values: Written) -> Kind:
    """A command of the quantity that is read."""
    return read[0]


@dataclass(frozen=True)
class GenericProgram:
    """A program that is written with the kinds of `programs.quantities`, and works for any quantity.

    type    the program with these kinds
    output  output(what each input reads, values as a file gives them) -> quantity of the command
    first   first(settings, first reading) -> command before it is called
    made    made(values of the file) -> settings of the step, where these are of another class
    follows what the quantity of the command follows from, for messages
    suited  suited(settings) -> the program that works with them, where it depends on them
    """

    type: ProgramType
    output: Callable[[Sequence[Kind], Written], Kind] = as_read
    first: Callable[[Any, Any], Any] | None = None
    made: Callable[[Any], Params] | None = None
    suited: Callable[[Any], ProgramType] | None = None
    follows: str = ""

    def explain(self, fault: Fault) -> Fault:
        """A fault of a value; of one that has the quantity of the command, with what that follows from."""
        kinds = field_kinds(self.type.settings) if self.type.settings else {}
        if not self.follows or kinds.get(fault.key.rpartition(".")[2]) is not OUTPUT:
            return fault
        return replace(fault, message=f"{fault.message}; the command is {self.follows}")

    def for_quantities(self, read: Sequence[Kind], output: Kind | None = None) -> ProgramType:
        """The program for one circuit, where its first inputs read these quantities and its command is `output`."""
        kinds = replacements(read, output or self.output(read, {}))
        settings = self.type.settings
        return replace(
            self.type,
            reading=with_kinds(self.type.reading, kinds),
            command=with_kinds(type(self.type.command), kinds)(*self.type.command),
            settings=settings and with_kinds(settings, kinds),
        )
