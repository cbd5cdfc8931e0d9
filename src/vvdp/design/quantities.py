"""Criteria of a design: drops, speed, losses, size and ripple of a valve in closed form.

One text for floats, for arrays of designs and for CasADi symbols, so that gradients are exact.
"""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Annotated, Any, NamedTuple

import numpy as np

from vvdp.base.display import key_suffix
from vvdp.base.kinds import (
    EFFICIENCY,
    MEAN_POWER,
    SIGNED_PRESSURE,
    Flow,
    Fraction,
    Frequency,
    Kind,
    PressureDifference,
    Ratio,
    Volume,
)
from vvdp.base.params import field_kinds
from vvdp.base.signal import signal_value
from vvdp.evaluation.bench import rotary_bench
from vvdp.fluid.oil import Oil, density, dynamic_viscosity, film_viscosity
from vvdp.simulation.values import names
from vvdp.systems.system import System
from vvdp.valve.condition import Condition
from vvdp.valve.geometry import transition_fraction
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.losses import (
    compressibility_loss,
    friction_loss,
    full_open_drop,
    leakage_loss,
    transition_loss,
)
from vvdp.valve.operating_point import nozzle_reynolds_number
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import driven_speed, friction_coefficient, pwm_frequency

MeanPower = Annotated[float, MEAN_POWER]
SignedPressure = Annotated[float, SIGNED_PRESSURE]
Efficiency = Annotated[float, EFFICIENCY]


class Setup(NamedTuple):
    """A valve and all around it that its closed forms depend on, at one operating point; levels absolute."""

    flow: Any
    temperature: Any
    duty_ratio: Any
    load_pressure: Any
    tank_pressure: Any
    relief_pressure: Any
    relief_override: Any
    relief_rated_flow: Any
    inlet_volume: Any
    spool_motor_speed: Any
    coupling: Any
    oil: Oil
    valve: RotaryValve


class Quantities(NamedTuple):
    """Results of a design at one operating point, with the valve fully open where a cycle is not named.

    `loss_total` adds the five losses above it. `load_pulsation` is the volume that whatever stands behind the load port
    has to store in every PWM period, `spool_volume` that of the switching section and its two end lands,
    `relief_margin` what the relief setting leaves above load and open drop, `input_power` what the pump takes in.
    """

    pressure_drop_total: PressureDifference
    pressure_drop_nozzle: PressureDifference
    pressure_drop_centre_section: PressureDifference
    pressure_drop_outlet_turbine: PressureDifference
    pwm_frequency: Frequency
    transition_fraction: Fraction
    loss_full_open: MeanPower
    loss_transition: MeanPower
    loss_leakage: MeanPower
    loss_compressibility: MeanPower
    spool_drive_power: MeanPower
    loss_total: MeanPower
    efficiency: Efficiency
    leakage_flow: Flow
    load_flow: Flow
    load_pulsation: Volume
    spool_volume: Volume
    relief_margin: SignedPressure
    input_power: MeanPower
    nozzle_reynolds_number: Ratio
    spool_friction_power: MeanPower


KINDS: Mapping[str, Kind] = {name: kind for name, kind in field_kinds(Quantities).items() if kind}


LABELS: Mapping[str, str] = {
    "pressure_drop_total": "pressure drop",
    "pressure_drop_nozzle": "pressure drop, nozzles",
    "pressure_drop_centre_section": "pressure drop, centre section",
    "pressure_drop_outlet_turbine": "pressure drop, outlet turbine",
    "pwm_frequency": "PWM frequency, fully open",
    "transition_fraction": "transition fraction",
    "loss_full_open": "loss, fully open",
    "loss_transition": "loss, transitions",
    "loss_leakage": "loss, leakage",
    "loss_compressibility": "loss, compressibility",
    "spool_drive_power": "power of the spool's motor",
    "loss_total": "total loss",
    "efficiency": "efficiency",
    "leakage_flow": "leakage flow",
    "load_flow": "load flow",
    "load_pulsation": "load pulsation",
    "spool_volume": "spool volume",
    "relief_margin": "relief margin",
    "input_power": "input power",
    "nozzle_reynolds_number": "Reynolds number of the nozzles",
    "spool_friction_power": "viscous friction of the spool",
}
"""Words of a user for each quantity."""


def key(name: str, kind: Kind) -> str:
    """The flat key of a value of `kind`, with its SI unit at the end."""
    return name + key_suffix(kind)


def setup(system: System) -> Setup:
    """The start of a run of `system`. The load pressure is the prescribed one, or the initial one of a load that makes
    its own. Raises ConfigError where it is no bench of a rotary valve."""
    bench = rotary_bench(system, "design")
    return Setup(
        flow=bench.unit.delivered_flow(bench.load_pressure),
        temperature=float(signal_value(0.0, bench.operation.oil_temperature)),
        duty_ratio=float(signal_value(0.0, bench.duty_ratio)),
        load_pressure=bench.load_pressure,
        tank_pressure=bench.tank_pressure,
        relief_pressure=bench.relief_valve.cracking_pressure,
        relief_override=bench.relief_valve.override_pressure,
        relief_rated_flow=bench.relief_valve.rated_flow,
        inlet_volume=bench.inlet_volume,
        spool_motor_speed=float(signal_value(0.0, bench.operation.spool_motor_speed)),
        coupling=bench.spool_drive.coupling,
        oil=bench.oil,
        valve=bench.valve,
    )


def switching_condition(at: Setup) -> Condition:
    """The conditions under which the valve of a setup switches."""
    return Condition(
        flow=at.flow,
        load_pressure=at.load_pressure,
        relief_pressure=at.relief_pressure,
        tank_pressure=at.tank_pressure,
        density=density(at.temperature, at.oil),
        relief_override=at.relief_override,
        relief_rated_flow=at.relief_rated_flow,
        vapour_pressure=at.oil.vapour_pressure,
    )


def loose_copy(params: Any) -> Any:
    """A copy of parameters whose fields may be changed, to arrays and symbols too; nothing is checked."""
    known = vars(params) if isinstance(params, SimpleNamespace) else names(params)
    return SimpleNamespace(**{name: getattr(params, name) for name in known})


def quantities(at: Setup) -> Quantities:
    """Results of a design at one operating point.

    The spool runs at the speed at which torques and drive balance with the valve fully open. The compressibility loss
    counts that frequency, and the pulsation takes the pump's flow as switched at once: d (1 - d) Q/f.

    Source  ours, docs/design.md
    """
    oil, valve, Q, d = at.oil, at.valve, at.flow, at.duty_ratio
    P_L, P_T = at.load_pressure, at.tank_pressure
    rho, mu = density(at.temperature, oil), film_viscosity(at.temperature, P_L, P_T, oil)
    drops = full_open_drop(Q, rho, valve)
    total = drops.nozzle + drops.centre_section + drops.outlet_turbine
    omega = driven_speed(at.spool_motor_speed, at.coupling, Q, rho, mu, valve)
    f = pwm_frequency(omega, valve)
    drive = at.coupling * (at.spool_motor_speed - omega) * at.spool_motor_speed
    condition = switching_condition(at)
    switching = transition_loss(condition, valve)
    transition, load_flow = switching.loss, Q * d - switching.load_flow_lost
    leakage = leakage_loss(P_L - P_T, mu, valve)
    compression = compressibility_loss(f, at.inlet_volume, P_L, P_T, oil)
    open_loss, passed = Q * total, (P_L - P_T) * load_flow
    return Quantities(
        pressure_drop_total=total,
        pressure_drop_nozzle=drops.nozzle,
        pressure_drop_centre_section=drops.centre_section,
        pressure_drop_outlet_turbine=drops.outlet_turbine,
        pwm_frequency=f,
        transition_fraction=transition_fraction(valve),
        loss_full_open=open_loss,
        loss_transition=transition,
        loss_leakage=leakage,
        loss_compressibility=compression,
        spool_drive_power=drive,
        loss_total=open_loss + transition + leakage + compression + drive,
        efficiency=(passed - leakage - compression) / (passed + open_loss + transition + drive),
        leakage_flow=leakage_conductance(mu, valve) * (P_L - P_T),
        load_flow=load_flow,
        load_pulsation=d * (1.0 - d) * Q / f,
        spool_volume=np.pi * valve.spool_radius * valve.spool_radius * (valve.helix_length + 2.0 * valve.land_length),
        relief_margin=at.relief_pressure - P_L - total,
        input_power=passed + open_loss + transition,
        nozzle_reynolds_number=nozzle_reynolds_number(Q, rho, dynamic_viscosity(at.temperature, oil), valve),
        spool_friction_power=friction_loss(omega, friction_coefficient(mu, valve)),
    )
