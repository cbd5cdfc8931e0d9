"""Soft switching of a three-way valve beside its check valve: a chamber that is locked while the tank port is closed.

Source  ours, docs/models/soft-switching.md, where a function names no other.
"""

from vvdp.base.kinds import Area, Compliance, Fraction, Polytropic, Volume
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.volume import Vessel


class SwitchChamber(Vessel):
    """A small accumulator that takes the pump flow while the tank port is partly open, and gives it back through the
    tank port once that is fully open.

    The defaults are assumed.
    """

    oil_volume: Volume = 1e-6
    hose_compliance: Compliance = 0.0
    gas_volume: Volume = 5e-5
    gas_exponent: Polytropic = 1.4

    def check(self) -> None:
        require_positive(self, "gas_volume", why="without gas nothing gives way to the oil")


class Mouth(Orifice):
    """An orifice that is closed with a port, and fully open from `release_opening` of that port on. The defaults are
    assumed.
    """

    mouth_area: Area = 1e-4
    release_opening: Fraction = 0.01

    def check(self) -> None:
        require_positive(self, "release_opening")


def released_area(opening: float, mouth: Mouth) -> float:
    """Open area of a mouth [m^2]: none while the port is closed.

    opening  open fraction of the port [1]
    """
    return mouth.mouth_area * clip(opening / mouth.release_opening, 0.0, 1.0)
