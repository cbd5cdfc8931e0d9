"""Load force, moving mass and compressibility of the oil, learned from the errors that they cause.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Compliance, Force, Kind, Mass, Time
from vvdp.base.params import Params
from vvdp.control.cylinder_force import DesiredForce, ForceGains
from vvdp.control.reference import Reference

LOAD_GAIN = Kind("adaptation gain of a load force", "N/m", 0.0, 1e12, "4e4 N/m")
MASS_GAIN = Kind("adaptation gain of a mass", "kg*s^2/m^2", 0.0, 1e12, "2e4 kg*s^2/m^2")
COMPLIANCE_GAIN = Kind("adaptation gain of a compressibility", "1/(N*Pa)", 0.0, 1.0, "1e-19 1/(N*Pa)")

LoadGain = Annotated[float, LOAD_GAIN]
MassGain = Annotated[float, MASS_GAIN]
ComplianceGain = Annotated[float, COMPLIANCE_GAIN]


class Adaptation(Params):
    """Gains, 0 for what is not to be learned, and the bounds of what is; after a switch of direction it pauses."""

    load_gain: LoadGain = 0.0
    mass_gain: MassGain = 0.0
    compliance_gain: ComplianceGain = 0.0
    lowest_load: Force = -5e3
    highest_load: Force = 5e3
    lowest_mass: Mass = 20.0
    highest_mass: Mass = 600.0
    lowest_compliance: Compliance = 3e-10
    highest_compliance: Compliance = 5e-9
    pause: Time = 0.3

    def check(self) -> None:
        for name in ("load", "mass", "compliance"):
            low, high = getattr(self, f"lowest_{name}"), getattr(self, f"highest_{name}")
            if not low <= high:
                raise ParameterError(
                    f"Adaptation.lowest_{name}: {low:g} is above highest_{name} {high:g}; expected it below"
                )


class AdaptationMemory(NamedTuple):
    """What is added to the load as otherwise believed, the mass, and the compressibility 1/beta."""

    load_correction: Force
    moving_mass: Mass
    compliance: Compliance


def adaptation_step(
    memory: AdaptationMemory,
    reference: Reference,
    errors: tuple[DesiredForce, float, float, float],
    interval: float,
    gains: ForceGains,
    settings: Adaptation,
) -> AdaptationMemory:
    """What has been learned a sample later."""
    return memory
