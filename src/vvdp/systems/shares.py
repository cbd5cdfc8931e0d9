"""An input of a drawn component that is what is read, per a value: `{ from = "loop.flow", per = "40 lpm" }`."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from vvdp.base.display import signal_with_unit
from vvdp.base.errors import NetworkError
from vvdp.base.kinds import PRESSURE_DIFFERENCE, PRESSURE_LEVEL, Kind
from vvdp.base.signal import Signal
from vvdp.network.nodes import Connection
from vvdp.network.paths import Places
from vvdp.programs.quantities import dimension


class Share(NamedTuple):
    """A quantity read at `source`, per a `whole`, for an input of the quantity `of`; `path` is where it stands."""

    path: str
    source: str
    whole: Kind
    of: Kind


def whole_quantity(written: Kind) -> Kind:
    """The quantity of a whole, as it is written: of pressures a difference, so that 100 bar are 1e7 Pa."""
    return PRESSURE_DIFFERENCE if written is PRESSURE_LEVEL else written


def share(value: float, whole: float) -> float:
    """A value as a share of a whole."""
    return value / whole


def check_share(places: Places, given: Share) -> None:
    """Raises NetworkError if its source leads nowhere, its unit is not that of the input, or its whole becomes 0."""
    _, component, key = given.path.split(".")
    read = places.quantity(given.source, component).kind
    if dimension(read.unit) != dimension(given.whole.unit).times(dimension(given.of.unit)):
        raise NetworkError(f"{given.source!r} in {read.unit} per {given.whole.unit} gives no {given.of.name}")
    net = places.network
    pieces = net.groups[component].parts if component in net.groups else (component,)
    for inputs in (net.parts[piece].inputs for piece in pieces):
        for whole in wholes((inputs[key],) if key in inputs else inputs.values(), given.source):
            if whole.may_be(0.0):
                raise NetworkError(f"per = {signal_with_unit(whole, given.whole)}; must not pass through 0")


def wholes(inputs: Iterable[object], source: str) -> Iterator[Signal]:
    """The signals by which a source is divided in inputs, however deep in functions of several."""
    for each in inputs:
        if isinstance(each, Connection):
            if each.function is share and each.sources[0] == source:
                yield from (inner for inner in each.sources[1:] if isinstance(inner, Signal))
            yield from wholes(each.sources, source)
