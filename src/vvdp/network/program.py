"""A program as a component of a network: a step with its sensors' readings, command and settings."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from vvdp.base.params import Params
from vvdp.sensing.instrument import Instrument
from vvdp.simulation.exchange import Partner
from vvdp.simulation.model import no_memory


@dataclass(frozen=True)
class ProgramType:
    """A sampled step that a network can use.

    step     step(t, memory, reading, settings) -> (memory, command)
    reading  NamedTuple of what its sensors see
    command  NamedTuple that holds before it is first called
    settings class of its values
    start    start(settings) -> memory
    level    level(reading, settings) -> float: called where its floor changes instead of at samples
    partner  what its step exchanges values with outside of compiled code
    ramps    fields NAME of its command that go on between samples, from its field `time` on at its field `NAME_rate`
    is_bounded  no number of it grows with the time for which it runs, so that single precision is enough
    is_drawn  whether figures show its commands; not if they are raw material of a program, or its report draws them
    report   report(network, name, sample period [s]) -> what it adds to the results, as `programs.report.ProgramReport`
    instruments  instruments(values of the file) -> the sensors before fields of its reading, by their names
    refuse   refuse(network, name): raises ParameterError("TABLE.NAME.KEY: ...") if the drawn network cannot do what the
             program asks of it; TABLE is nodes, components or programs
    """

    step: Callable[..., Any]
    reading: type
    command: Any
    settings: type[Params] | None = None
    start: Callable[..., Any] = no_memory
    level: Callable[..., Any] | None = None
    report: Callable[[Any, str, float], Any] | None = None
    instruments: Callable[[Any], Mapping[str, Instrument]] | None = None
    refuse: Callable[[Any, str], None] | None = None
    partner: Partner | None = None
    ramps: frozenset[str] = frozenset()
    is_bounded: bool = False
    is_drawn: bool = True

    @property
    def defaults(self) -> Mapping[str, float]:
        """Values of the fields of its reading that need not be given [SI]."""
        return self.reading._field_defaults  # type: ignore[attr-defined, no-any-return]
