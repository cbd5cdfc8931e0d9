"""Models of turbulence to choose from, and what enters with the flow."""

from typing import NamedTuple

C_MU = 0.09
"""Constant of the k-epsilon model that relates its eddy viscosity to k and epsilon."""
INTENSITY, LENGTH_SHARE = 0.05, 0.07
"""Of the turbulence that enters: its intensity, and its length over the diameter of the duct."""


class Turbulence(NamedTuple):
    """A model as OpenFOAM knows it, and the field it solves beside k: "epsilon", "omega", or none where laminar."""

    model: str
    scale: str


STANDARD = Turbulence("kEpsilon", "epsilon")
REALIZABLE = Turbulence("realizableKE", "epsilon")
SHEAR_STRESS = Turbulence("kOmegaSST", "omega")
LAMINAR = Turbulence("laminar", "")
MODELS = {"k-epsilon": STANDARD, "realizable": REALIZABLE, "sst": SHEAR_STRESS, "laminar": LAMINAR}


class Inflow(NamedTuple):
    """Turbulence that enters: kinetic energy k [m^2/s^2], dissipation epsilon [m^2/s^3], specific one omega [1/s]."""

    k: float
    epsilon: float
    omega: float


def duct_turbulence(velocity: float, diameter: float) -> Inflow:
    """Turbulence of a flow of 5 % intensity, its length 7 % of the diameter.

    k = 3/2 (I v)^2, epsilon = C_mu^(3/4) k^(3/2) / l, omega = epsilon / (C_mu k).

    >>> [round(value, 3) for value in duct_turbulence(8.0, 0.01)]
    [0.24, 27.602, 1277.863]
    """
    k = 1.5 * (INTENSITY * velocity) ** 2
    epsilon = C_MU**0.75 * k**1.5 / (LENGTH_SHARE * diameter)
    return Inflow(k, epsilon, epsilon / (C_MU * k))
