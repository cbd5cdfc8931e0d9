"""Compensators of a variable pump: pressure, flow or load sensing, and power, in one control of its setting.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Displacement, FrictionTorque
from vvdp.base.rules import require_positive
from vvdp.base.select import maximum, minimum
from vvdp.hydraulics.variable_pump import PumpControl, swivel_share, wanted_swivel


class PumpCompensator(PumpControl):
    """A pressure control with a margin over its pilot, and a limit of the torque of a pump of full `displacement`.

    `largest_torque` at a shaft of constant speed is a largest power; the usual value limits nothing.
    """

    displacement: Displacement
    largest_torque: FrictionTorque = 1e6

    def check(self) -> None:
        require_positive(self, "displacement", "largest_torque")


def torque_share(pressure_rise: float, compensator: PumpCompensator) -> float:
    """Share of its displacement at which a pump takes the largest torque [1], not above 1: min(T_max/(D dp), 1).

    pressure_rise  dp, outlet less inlet [Pa]

    >>> compensator = PumpCompensator(margin=2e6, highest_pressure=3e7, proportional_band=1e6, reset_time=0.1,
    ...                               displacement=1e-5, largest_torque=100.0)
    >>> print(round(torque_share(2e7, compensator), 9), torque_share(-1e5, compensator))
    0.5 1.0
    """
    full = compensator.displacement * maximum(pressure_rise, 0.0)
    return compensator.largest_torque / maximum(full, compensator.largest_torque)


def compensated_share(shortfall: float, pressure_rise: float, swivel: float, compensator: PumpCompensator) -> float:
    """Share of its displacement that a compensator demands of a pump [1]: that of its pressure, or of its torque.

    shortfall      P_set - P [Pa]
    pressure_rise  outlet minus inlet [Pa]
    swivel         state of the pressure control [1]
    """
    return minimum(swivel_share(shortfall, swivel, compensator), torque_share(pressure_rise, compensator))


def torque_distance(shortfall: float, pressure_rise: float, swivel: float, compensator: PumpCompensator) -> float:
    """Share demanded by the pressure minus the share allowed by the torque [1]; negative where the pressure decides.

    shortfall, pressure_rise, swivel  as in `compensated_share`
    """
    return wanted_swivel(shortfall, swivel, compensator) - torque_share(pressure_rise, compensator)
