"""Parameters of the rotary valve."""

from typing import Annotated

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    Area,
    Clearance,
    Count,
    DischargeCoefficient,
    Fraction,
    Kind,
    Length,
    Mass,
    PressureDifference,
    Ratio,
)
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive

CentreCoefficient = Annotated[float, Kind("centre section coefficient", "SI", 1e-12, 1.0, "1.45e-6 SI", units=("SI",))]
FlowExponent = Annotated[
    float, Kind("flow exponent with which the branch law is inverted to rounding", "1", 1.7, 2.0, "1.91")
]
DiameterExponent = Annotated[float, Kind("diameter exponent", "1", 2.0, 4.0, "3.22")]
PowerResistance = Annotated[float, Kind("drop over a power of the flow", "SI", 0.0, 1e30, "1e9 SI", units=("SI",))]
QuadraticResistance = Annotated[float, Kind("quadratic flow resistance", "Pa*s^2/m^6", 0.0, 1e18, "2e10 Pa*s^2/m^6")]


class RotaryValve(Params):
    """Rotary spool with zig-zag barriers, fed by `sections` rhombic nozzles and left through two outlet turbines.

    `nozzle_area` is the area of all nozzles together and `outlet_area` that of one whole outlet turbine;
    `outlet_effective_area` is the one that gives its torque, and `inlet_area_ratio` times `nozzle_area` the one that
    gives the torque of the nozzles' jets. `centre_coefficient` goes with flow in m^3/s, diameter
    in m and drop in Pa. `lap_ratio` is barrier width over nozzle width: 1 is zero lap, more is overlap.
    `jet_exponent` says how far a partly open port concentrates the jet: 0 not at all, 1 as the opening; and
    `jet_asymmetry` by how much more torque it gives while the port closes than while it opens, 0 none.
    `helix_length` is the axial travel that takes the duty ratio from 0 to 1. `rail_coefficient` is the drop of the
    outlet rail over flow squared. Below about `transition_pressure` the drop goes over from quadratic to linear.
    `pressure_recovery` is F_L of IEC 60534: the nozzles choke where their drop reaches its square times the absolute
    inlet pressure; with 0 they never do.
    """

    spool_radius: Length
    sections: Count
    nozzle_area: Area
    nozzle_discharge_coefficient: DischargeCoefficient
    centre_coefficient: CentreCoefficient
    centre_flow_exponent: FlowExponent
    centre_diameter_exponent: DiameterExponent
    outlet_area: Area
    outlet_discharge_coefficient: DischargeCoefficient
    outlet_effective_area: Area
    rail_coefficient: QuadraticResistance
    inlet_radius: Length
    outlet_radius: Length
    helix_length: Length
    lap_ratio: Ratio
    radial_clearance: Clearance
    friction_area: Area
    spool_mass: Mass
    jet_exponent: Fraction
    land_length: Length
    eccentricity: Fraction
    transition_pressure: PressureDifference
    jet_asymmetry: Fraction = 0.0
    pressure_recovery: Fraction = 0.0
    inlet_area_ratio: Ratio = 1.0

    def check(self) -> None:
        """Refuse a valve that cannot be made."""
        require_positive(
            self,
            "spool_radius",
            "sections",
            "nozzle_area",
            "outlet_area",
            "outlet_effective_area",
            "helix_length",
            "lap_ratio",
            "friction_area",
            "spool_mass",
            "land_length",
            "transition_pressure",
            "inlet_area_ratio",
        )
        if not self.eccentricity < 1.0:
            refuse(self, "eccentricity", "must be less than 1: no film is left where the spool touches the sleeve")
        if self.sections != round(self.sections):
            refuse(self, "sections", "must be a whole number")
        radius = field_text(self, "spool_radius")
        if self.radial_clearance > 0.1 * self.spool_radius:
            refuse(self, "radial_clearance", f"must be at most a tenth of spool_radius, {radius}")
        for name in ("inlet_radius", "outlet_radius"):
            if getattr(self, name) > self.spool_radius:
                refuse(self, name, f"must be at most spool_radius, {radius}")
        self._check_circumference()

    def _check_circumference(self) -> None:
        pitch = 2.0 * np.pi * self.spool_radius / self.sections
        # One nozzle is the rhombus of area d_c d_a / 2 whose sides follow the helices, d_a / d_c = 2 L / pitch.
        width = np.sqrt(self.nozzle_area * pitch / (self.sections * self.helix_length))
        barrier = self.lap_ratio * width
        if width + barrier > pitch:
            raise ParameterError(
                f"nozzle width {1e3 * width:.3g} mm and barrier width {1e3 * barrier:.3g} mm do not fit "
                f"into the pitch of {1e3 * pitch:.3g} mm; make the nozzle area or the lap ratio smaller, or the "
                f"helix longer"
            )
