"""The books that every circuit keeps: what went in, what was spent where, and what is stored."""

from typing import Any, NamedTuple

from vvdp.base.kinds import Energy, TankVolume


class Nothing(NamedTuple):
    """Stands where a circuit has no command, a system no program and so no memory, or books no further totals."""

    unused: float = 0.0


NOTHING = Nothing()


class Books(NamedTuple):
    """Integral states of a circuit, last in its state under the name `books`. Rates never depend on them.

    `supplied` and `spent` are NamedTuples of energies [J] with a name for every source and every sink, `totals` one of
    integrals over time of whatever else is to be averaged exactly. In the rates that a circuit returns, the same
    fields hold powers [W], flows [tank volumes per second] and the averaged quantities themselves. Where there are
    several oils, `taken_in` and `given_out` are NamedTuples with a name for each.
    """

    supplied: Any
    spent: Any
    taken_in: TankVolume
    given_out: TankVolume
    totals: Any = NOTHING


class Stored(NamedTuple):
    """Content of a component or a circuit: energy [J] above the tank's state, and oil [m^3 at tank conditions].

    Where a circuit has several oils, `volume` is a NamedTuple with a name for each.
    """

    energy: Energy
    volume: TankVolume
