"""Everything that is known of the valve at one flow and temperature."""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Frequency, Power, PressureDifference, Ratio, Speed
from vvdp.fluid.mixture import mean_bulk_modulus
from vvdp.fluid.oil import Oil, density, dynamic_viscosity
from vvdp.valve.flow_map import CycleMean, averaged_spool_speed, quasi_steady_mean
from vvdp.valve.geometry import nozzle_hydraulic_diameter, transition_fraction
from vvdp.valve.losses import (
    TransitionLoss,
    compressibility_loss,
    compression_regime,
    friction_loss,
    full_open_drop,
    full_open_loss,
    leakage_loss,
    range_warnings,
    transition_loss,
)
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import (
    Torque,
    equilibrium_speed,
    friction_coefficient,
    inlet_torque,
    outlet_torque,
    pwm_frequency,
)

TURBULENT = 2300.0  # Reynolds number


class OperatingPoint(NamedTuple):
    """The valve at one flow and temperature.

    Drops, torques, `spool_speed` and `full_open_pwm_frequency` are those of the fully open valve;
    `averaged_pwm_frequency` is the one that the same valve settles at while it switches. The losses add up to
    `total_loss`; `friction_loss` is part of the full-open loss and is not added. `transition` and the total hold
    where `warnings` is empty; `cycle` holds at any duty ratio.
    """

    nozzle_drop: PressureDifference
    centre_drop: PressureDifference
    outlet_drop: PressureDifference
    total_drop: PressureDifference
    inlet_torque: Torque
    outlet_torque: Torque
    friction_torque: Torque
    spool_speed: Speed
    full_open_pwm_frequency: Frequency
    averaged_pwm_frequency: Frequency
    transition_fraction: Fraction
    full_open_loss: Power
    transition_loss: Power
    leakage_loss: Power
    compressibility_loss: Power
    total_loss: Power
    friction_loss: Power
    compression_regime: Ratio
    nozzle_reynolds_number: Ratio
    transition: TransitionLoss
    cycle: CycleMean
    warnings: tuple[str, ...]


def nozzle_reynolds_number(flow: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Reynolds number of the fully open nozzles, rho (Q / A_in) d_h / mu [1].

    flow       [m^3/s]
    density    [kg/m^3]
    viscosity  dynamic [Pa s]

    Source  ours, docs/models/rotary-valve.md
    """
    return density * flow / valve.nozzle_area * nozzle_hydraulic_diameter(valve) / viscosity


def operating_point(
    flow: float,
    temperature: float,
    duty_ratio: float,
    load_pressure: float,
    relief_pressure: float,
    inlet_volume: float,
    oil: Oil,
    valve: RotaryValve,
) -> OperatingPoint:
    """Drops, torques, speeds, losses and warnings at one operating point; the tank is at the oil's reference pressure.

    flow                            of the pump, > 0 [m^3/s]
    temperature                     of the oil [K]
    duty_ratio                      axial position over helix length [1]
    load_pressure, relief_pressure  absolute [Pa]
    inlet_volume                    between pump and ports [m^3]

    Source  ours, docs/models/rotary-valve.md
    """
    Q, rho, mu, tank = flow, density(temperature, oil), dynamic_viscosity(temperature, oil), oil.reference_pressure
    drops = full_open_drop(Q, rho, valve)
    omega = equilibrium_speed(Q, rho, mu, valve)
    k_f = friction_coefficient(mu, valve)
    averaged = pwm_frequency(
        averaged_spool_speed(duty_ratio, load_pressure, relief_pressure, 0.0, tank, Q, rho, mu, valve), valve
    )
    transition = transition_loss(Q, load_pressure, relief_pressure, tank, rho, valve)
    losses = (
        full_open_loss(Q, rho, valve),
        transition.loss,
        leakage_loss(load_pressure - tank, mu, valve),
        compressibility_loss(averaged, inlet_volume, load_pressure, tank, oil),
    )
    regime = compression_regime(
        averaged, inlet_volume, load_pressure - tank, mean_bulk_modulus(load_pressure, oil), Q, valve
    )
    reynolds = nozzle_reynolds_number(Q, rho, mu, valve)
    warnings = range_warnings(duty_ratio, Q, load_pressure, relief_pressure, tank, rho, valve)
    if reynolds < TURBULENT:
        warnings += (
            f"the Reynolds number of the nozzles is {reynolds:.4g}: a discharge coefficient from a turbulent model is "
            f"uncertain",
        )
    return OperatingPoint(
        drops.nozzle,
        drops.centre_section,
        drops.outlet_turbine,
        drops.nozzle + drops.centre_section + drops.outlet_turbine,
        inlet_torque(Q, 1.0, rho, valve),
        outlet_torque(Q, omega, rho, valve),
        k_f * omega,
        omega,
        pwm_frequency(omega, valve),
        averaged,
        transition_fraction(valve),
        *losses,
        sum(losses),
        friction_loss(omega, k_f),
        regime,
        reynolds,
        transition,
        quasi_steady_mean(duty_ratio, load_pressure, relief_pressure, 0.0, tank, Q, rho, valve),
        warnings,
    )
