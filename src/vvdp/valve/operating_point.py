"""Everything that is known of the valve at one flow and temperature.

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import (
    Conductance,
    Flow,
    Fraction,
    Frequency,
    Power,
    Pressure,
    PressureDifference,
    Ratio,
    Speed,
    Temperature,
)
from vvdp.fluid.mixture import mean_bulk_modulus
from vvdp.fluid.oil import Oil, density, dynamic_viscosity, film_viscosity
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import CycleMean, mean_of_cycle, quasi_steady_cycle, quasi_steady_mean, speed_of_cycle
from vvdp.valve.geometry import nozzle_hydraulic_diameter, transition_fraction
from vvdp.valve.losses import (
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

LEAKAGE_TRIALS, SETTLED = 5, 1e-7
"""Times that a pump's leakage is found again, and the part of the flow by which it then changes no more: each divides
the error by 100 or more, as the mean inlet pressure changes little with the flow."""


class SetPoint(NamedTuple):
    """Operating condition of the valve: pump flow, oil temperature, duty ratio, absolute pressures; relief valve and
    pump as in `Condition`."""

    flow: Flow
    temperature: Temperature
    duty_ratio: Fraction
    load_pressure: Pressure
    relief_pressure: Pressure
    tank_pressure: Pressure
    relief_override: PressureDifference = 0.0
    relief_rated_flow: Flow = 0.0
    pump_leakage: Conductance = 0.0

    def condition(self, oil: Oil) -> Condition:
        """The conditions under which the valve switches."""
        return Condition(
            flow=self.flow,
            load_pressure=self.load_pressure,
            relief_pressure=self.relief_pressure,
            tank_pressure=self.tank_pressure,
            density=density(self.temperature, oil),
            relief_override=self.relief_override,
            relief_rated_flow=self.relief_rated_flow,
            pump_leakage=self.pump_leakage,
            vapour_pressure=oil.vapour_pressure,
        )

    def delivering(self, flow: float, oil: Oil, valve: RotaryValve) -> "SetPoint":
        """The same with a pump that delivers `flow` > 0 [m^3/s]: it displaces as much more as its leakage takes."""
        point, change = self._replace(flow=flow), self.pump_leakage * self.load_pressure
        for _ in range(LEAKAGE_TRIALS):
            if change <= SETTLED * flow:
                break
            mean = quasi_steady_mean(point.duty_ratio, point.condition(oil), valve)
            change = abs(flow + mean.pump_leakage_flow - point.flow)
            point = point._replace(flow=flow + mean.pump_leakage_flow)
        return point


class OperatingPoint(NamedTuple):
    """The valve at one flow and temperature.

    `flow` is delivered by the pump at its mean pressure, the pump flow minus its leakage. Drops, torques, `spool_speed`
    and `full_open_pwm_frequency` are those of the fully open valve; `averaged_pwm_frequency` is the one that the same
    valve settles at while it switches. The losses add up to `total_loss`; `friction_loss` is part of the full-open loss
    and is not added. `transition_loss` and the total hold where `warnings` is empty; `cycle` holds at any duty ratio.
    The transition loss is a closed form for a pump without leakage, else the loss of `cycle` minus those of the pump
    and of the fully open valve.
    """

    flow: Flow
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
    cycle: CycleMean
    warnings: tuple[str, ...]


def nozzle_reynolds_number(flow: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Reynolds number of the fully open nozzles, rho (Q / A_in) d_h / mu [1].

    flow       [m^3/s]
    density    [kg/m^3]
    viscosity  dynamic [Pa s]
    """
    return density * flow / valve.nozzle_area * nozzle_hydraulic_diameter(valve) / viscosity


def operating_point(set_point: SetPoint, inlet_volume: float, oil: Oil, valve: RotaryValve) -> OperatingPoint:
    """Drops, torques, speeds, losses and warnings at one operating point.

    set_point     with a flow > 0, and more than the pump's leakage takes
    inlet_volume  between pump and ports [m^3]
    """
    T, duty_ratio = set_point.temperature, set_point.duty_ratio
    load_pressure, tank = set_point.load_pressure, set_point.tank_pressure
    rho, mu = density(T, oil), film_viscosity(T, load_pressure, tank, oil)
    supplied = set_point.condition(oil)
    course = quasi_steady_cycle(duty_ratio, supplied, valve)
    cycle = mean_of_cycle(course, supplied)
    Q = set_point.flow - cycle.pump_leakage_flow
    at = supplied._replace(flow=Q, pump_leakage=0.0)
    full_open = _full_open(Q, rho, mu, valve)
    averaged = pwm_frequency(speed_of_cycle(course, rho, mu, valve), valve)
    open_loss, is_tight = full_open["full_open_loss"], set_point.pump_leakage == 0.0
    transition = transition_loss(at, valve).loss if is_tight else _mean_transition_loss(cycle, open_loss)
    leakage = leakage_loss(load_pressure - tank, mu, valve)
    compression = compressibility_loss(averaged, inlet_volume, load_pressure, tank, oil)
    regime = compression_regime(
        averaged, inlet_volume, load_pressure - tank, mean_bulk_modulus(load_pressure, oil), Q, valve
    )
    return OperatingPoint(
        flow=Q,
        **full_open,
        averaged_pwm_frequency=averaged,
        transition_fraction=transition_fraction(valve),
        transition_loss=transition,
        leakage_loss=leakage,
        compressibility_loss=compression,
        total_loss=open_loss + transition + leakage + compression,
        compression_regime=regime,
        nozzle_reynolds_number=nozzle_reynolds_number(Q, rho, dynamic_viscosity(T, oil), valve),
        cycle=cycle,
        warnings=range_warnings(duty_ratio, at, valve),
    )


def _full_open(flow: float, density: float, viscosity: float, valve: RotaryValve) -> dict[str, float]:
    """What an operating point says of the fully open valve, by its fields."""
    drops = full_open_drop(flow, density, valve)
    omega = equilibrium_speed(flow, density, viscosity, valve)
    k_f = friction_coefficient(viscosity, valve)
    return {
        "nozzle_drop": drops.nozzle,
        "centre_drop": drops.centre_section,
        "outlet_drop": drops.outlet_turbine,
        "total_drop": drops.nozzle + drops.centre_section + drops.outlet_turbine,
        "inlet_torque": inlet_torque(flow, 1.0, density, valve),
        "outlet_torque": outlet_torque(flow, omega, density, valve),
        "friction_torque": k_f * omega,
        "spool_speed": omega,
        "full_open_pwm_frequency": pwm_frequency(omega, valve),
        "full_open_loss": full_open_loss(flow, density, valve),
        "friction_loss": friction_loss(omega, k_f),
    }


def _mean_transition_loss(cycle: CycleMean, open_loss: float) -> float:
    """Mean loss over a PWM period beyond the pump's leakage and the fully open valve [W].

    open_loss  of the fully open valve [W]
    """
    return cycle.loss - cycle.pump_loss - open_loss


def average_transition(point: OperatingPoint) -> OperatingPoint:
    """The same with the transition loss from the mean over a PWM period, which holds where its closed form does not."""
    transition = _mean_transition_loss(point.cycle, point.full_open_loss)
    total = point.total_loss - point.transition_loss + transition
    return point._replace(transition_loss=transition, total_loss=total)
