"""Soft switching of a three-way valve beside its check valve: a chamber that is locked while the tank port is closed.

Source  ours, docs/models/soft-switching.md, where a function names no other.
"""

from vvdp.base.kinds import Area, Compliance, Fraction, Polytropic, Volume
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.volume import Vessel


class SwitchChamber(Vessel):
    """A small accumulator that takes the pump flow while the tank port is partly open, and gives it back through the
    tank port once that is fully open.

    Its piston is locked while the tank port is closed, and released as that opens to `release_opening`. The defaults
    are assumed.
    """

    oil_volume: Volume = 1e-6
    hose_compliance: Compliance = 0.0
    gas_volume: Volume = 5e-5
    gas_exponent: Polytropic = 1.4
    mouth_area: Area = 1e-4
    release_opening: Fraction = 0.01

    def check(self) -> None:
        require_positive(self, "release_opening")
        require_positive(self, "gas_volume", why="without gas nothing gives way to the oil")


def released_area(tank_opening: float, chamber: SwitchChamber) -> float:
    """Area through which oil enters or leaves the chamber [m^2]: none while the tank port is closed.

    tank_opening  open fraction of the tank port [1]
    """
    return chamber.mouth_area * clip(tank_opening / chamber.release_opening, 0.0, 1.0)
