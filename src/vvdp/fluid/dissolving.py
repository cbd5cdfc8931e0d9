"""Air that dissolves and comes out of solution: Henry's law, neared at one rate each way.

Source  ours, docs/models/fluid.md, where a function names no other.
"""

from typing import Annotated

from vvdp.base.kinds import Kind
from vvdp.base.select import clip, select
from vvdp.fluid.oil import Oil

FREE_AIR = Kind("free air per tank volume", "1", 0.0, 1.0, "1 %", scale=1e-2)
FreeAir = Annotated[float, FREE_AIR]


def dissolves(oil: Oil) -> bool:
    """Whether the free air of an oil changes."""
    return oil.bunsen_coefficient > 0.0


def equilibrium_air(pressure: float, oil: Oil) -> float:
    """Free air at which no more dissolves, per tank volume [1]: phi + (1 - phi) B (1 - P/P0), none to all.

    The oil is saturated at the reference pressure, where phi of it is free air.  pressure: P, absolute [Pa].

    Source  pan2025, Henry's law
    Holds   at rest, after many times the time constants of the oil

    >>> from dataclasses import replace
    >>> saturated = replace(oil, bunsen_coefficient=0.09, dissolving_time=1.0, release_time=0.1)
    >>> print(*[round(equilibrium_air(p, saturated), 4) for p in (0.5 * 101325.0, 101325.0, 2e5)])
    0.0546 0.01 0.0
    """
    soluble = (1.0 - oil.air_fraction) * oil.bunsen_coefficient
    return clip(oil.air_fraction + soluble * (1.0 - pressure / oil.reference_pressure), 0.0, oil.air_fraction + soluble)


def free_air_rate(pressure: float, free_air: float, oil: Oil) -> float:
    """Rate at which the free air of oil at rest changes [1/s]: (phi_eq - phi_f)/tau; none at tau 0.

    The time constant is that of release or of dissolving.

    pressure  absolute [Pa]
    free_air  phi_f, volume at the reference pressure per tank volume [1]

    Source  pan2025, first-order release; the same law for dissolving ours, docs/models/fluid.md
    """
    missing = equilibrium_air(pressure, oil) - free_air
    tau = select(missing > 0.0, oil.release_time, oil.dissolving_time)
    return select(tau > 0.0, missing / select(tau > 0.0, tau, 1.0), 0.0)
