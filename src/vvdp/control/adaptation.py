"""Load force, moving mass and compressibility of the oil, learned from the errors that they cause.

Each follows the gradient that takes its own term out of the rate of the storage, is held within bounds, and stands
still while the valve is at an end or the direction has just changed.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Compliance, Force, Kind, Length, Mass, Time, Velocity
from vvdp.base.params import Params, without_effect
from vvdp.base.rules import require_less
from vvdp.base.select import clip
from vvdp.control.cylinder_force import ForceRate
from vvdp.control.reference import SignedAcceleration

LOAD_GAIN = Kind("adaptation gain of a load force", "N/m", 0.0, 1e12, "4e4 N/m")
MASS_GAIN = Kind("adaptation gain of a mass", "kg*s^2/m^2", 0.0, 1e12, "2e4 kg*s^2/m^2")
COMPLIANCE_GAIN = Kind("adaptation gain of a compressibility", "m/(N^2*Pa)", 0.0, 1.0, "1e-19 m/(N^2*Pa)")

LoadGain = Annotated[float, LOAD_GAIN]
MassGain = Annotated[float, MASS_GAIN]
ComplianceGain = Annotated[float, COMPLIANCE_GAIN]


class Adaptation(Params):
    """Gains, 0 for parameters that are not adapted, the bounds of the others, and the `pause` after a change of
    direction.

    Raises `ParameterError` for bounds that leave nothing between them.
    """

    load_gain: LoadGain = 0.0
    mass_gain: MassGain = 0.0
    compliance_gain: ComplianceGain = 0.0
    lowest_load: Annotated[Force, without_effect("load_gain")] = -5e3
    highest_load: Annotated[Force, without_effect("load_gain")] = 5e3
    lowest_mass: Annotated[Mass, without_effect("mass_gain")] = 20.0
    highest_mass: Annotated[Mass, without_effect("mass_gain")] = 600.0
    lowest_compliance: Annotated[Compliance, without_effect("compliance_gain")] = 3e-10
    highest_compliance: Annotated[Compliance, without_effect("compliance_gain")] = 5e-9
    pause: Annotated[Time, without_effect("load_gain", "mass_gain", "compliance_gain")] = 0.3

    def check(self) -> None:
        for name in ("load", "mass", "compliance"):
            require_less(self, f"lowest_{name}", f"highest_{name}")


class AdaptationMemory(NamedTuple):
    """Adapted parameters: correction added to the load as estimated otherwise, the mass, and the compressibility
    1/beta."""

    load_correction: Force
    moving_mass: Mass
    compliance: Compliance


class Excitation(NamedTuple):
    """Signals that the parameters are adapted from: the load as estimated otherwise, e_v, r', F_H - F_v, F_v' and L =
    S/beta.
    """

    load_force: Force
    velocity_error: Velocity
    reference_acceleration: SignedAcceleration
    force_error: Force
    force_rate: ForceRate
    slenderness: Length


def adaptation_start(moving_mass: float, bulk_modulus: float) -> AdaptationMemory:
    """Adapted parameters before the first sample.  moving_mass: [kg]; bulk_modulus: [Pa]."""
    return AdaptationMemory(0.0, moving_mass, 1.0 / bulk_modulus)


def adaptation_step(
    memory: AdaptationMemory, seen: Excitation, interval: float, settings: Adaptation
) -> AdaptationMemory:
    """Adapted parameters a sample later: F_L' = g_F e_v, m' = -g_m e_v r', (1/beta)' = -g_b (F_H - F_v) F_v'/L, held
    within their bounds. A parameter without a gain stays unchanged, within bounds or not.

    interval  since the last sample [s]

    Source  wang2017, section 7.3, which asks for it; the law is ours, docs/models/displacement-control.md
    """
    s, load, mass, compliance = settings, memory.load_correction, memory.moving_mass, memory.compliance
    if s.load_gain > 0.0:
        moved = seen.load_force + load + interval * s.load_gain * seen.velocity_error
        load = clip(moved, s.lowest_load, s.highest_load) - seen.load_force
    if s.mass_gain > 0.0:
        moved = mass - interval * s.mass_gain * seen.velocity_error * seen.reference_acceleration
        mass = clip(moved, s.lowest_mass, s.highest_mass)
    if s.compliance_gain > 0.0:
        moved = compliance - interval * s.compliance_gain * seen.force_error * seen.force_rate / seen.slenderness
        compliance = clip(moved, s.lowest_compliance, s.highest_compliance)
    return AdaptationMemory(load, mass, compliance)
