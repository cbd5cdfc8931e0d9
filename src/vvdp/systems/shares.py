"""An input of a drawn component that is what is read, per a value: `{ from = "loop.flow", per = "40 lpm" }`."""

from typing import NamedTuple

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import PRESSURE_DIFFERENCE, PRESSURE_LEVEL, Kind
from vvdp.network.paths import Places
from vvdp.programs.quantities import dimension


class Share(NamedTuple):
    """What is read at `source`, per a `whole`, for an input of the quantity `of`; `path` is where it stands."""

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
    """Raises NetworkError where its source leads nowhere, or its unit is not that of the input."""
    read = places.quantity(given.source, given.path.rpartition(".")[0].rpartition(".")[2]).kind
    if dimension(read.unit) != dimension(given.whole.unit).times(dimension(given.of.unit)):
        raise NetworkError(f"{given.source!r} in {read.unit} per {given.whole.unit} gives no {given.of.name}")
