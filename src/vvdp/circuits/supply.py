"""The part that both benches share: pump, inlet volume, relief valve, rotary valve and its spool."""

from typing import Any, NamedTuple

from vvdp.base.books import NOTHING, Nothing
from vvdp.base.kinds import (
    Angle,
    Conductance,
    Density,
    DynamicViscosity,
    Energy,
    Inertia,
    PositionSignal,
    Pressure,
    PressureSignal,
    Ratio,
    Speed,
    SpeedSignal,
    TemperatureSignal,
    Volume,
)
from vvdp.base.params import Params
from vvdp.base.select import minimum, select
from vvdp.base.signal import signal_stop, signal_value
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil, density, dynamic_viscosity
from vvdp.hydraulics.check_valve import CheckPoppet, check_opening, check_opening_rate
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.pump import Pump, pump_flow, pump_friction_power, shaft_power
from vvdp.hydraulics.relief_valve import ReliefValve, relief_flow, relief_opening_rate
from vvdp.hydraulics.spool_drive import SpoolDrive, coupling_loss, drive_power, drive_torque
from vvdp.hydraulics.volume import closed_volume_rate
from vvdp.valve.branch import BranchLaw, branch_law, law_flow
from vvdp.valve.geometry import Openings, PortShape, port_shape, shape_openings
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import pwm_frequency, spool_inertia, spool_torque


class Inlet(Params):
    """The volume between pump, relief valve and nozzles."""

    volume: Volume


class Operation(Params):
    """What is prescribed from outside, each over time."""

    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    axial_position: PositionSignal
    spool_motor_speed: SpeedSignal
    tank_pressure: PressureSignal


class SupplyParams(Params):
    """Everything upstream of the load."""

    oil: Oil
    pump: Pump
    inlet: Inlet
    relief_valve: ReliefValve
    valve: RotaryValve
    spool_drive: SpoolDrive
    check_valve: CheckPoppet
    operation: Operation


class Spool(NamedTuple):
    """The spool's rotation."""

    angle: Angle
    speed: Speed


class SupplyState(NamedTuple):
    """Pressure in front of the valve, how far relief and check valve are open, pump shaft and spool."""

    inlet_pressure: Pressure
    relief_opening: Ratio
    check_opening: Ratio
    shaft_angle: Angle
    spool: Spool


class Conditions(NamedTuple):
    """What depends on oil temperature and tank pressure alone. These are slow: they are read at each sample and held,
    so that the loop does not work them out again at each step."""

    density: Density
    viscosity: DynamicViscosity
    leakage_conductance: Conductance
    inertia: Inertia
    tank_pressure: Pressure
    tank: FluidState
    branch: BranchLaw
    ports: PortShape


class Command(NamedTuple):
    """What a bench is given at each sample: the conditions, and what its program has to show, such as an estimate.

    What is shown is recorded with the run; the circuit does not read it.
    """

    conditions: Conditions
    shown: Any = NOTHING


class Supplied(NamedTuple):
    """Energy that comes in. `tank_oil` is what the oil itself brings out of a tank that is not at the reference
    pressure, net of what it takes back."""

    pump_shaft: Energy
    spool_motor: Energy
    tank_oil: Energy


class ValveSpent(NamedTuple):
    """Energy turned to heat upstream of the load.

    The three drops of the valve are counted whole. What the spool takes from them as shaft work stands against them
    in `to_spool`, negative, and comes back as friction.
    """

    nozzle: Energy
    centre_section: Energy
    outlet_turbine: Energy
    relief_valve: Energy
    valve_leakage: Energy
    pump_leakage: Energy
    pump_friction: Energy
    spool_friction: Energy
    coupling: Energy
    to_spool: Energy


class Supply(NamedTuple):
    """What the supply does at an instant: rates of its state, powers, and the flows at its border [tank volumes]."""

    rates: SupplyState
    supplied: Supplied
    spent: ValveSpent
    pump_flow: float
    pump_leakage: float
    relief_flow: float
    load_flow: float
    tank_flow: float
    leakage: float
    openings: Openings


def conditions(t: float, p: SupplyParams) -> Conditions:
    """The conditions at time `t` [s]."""
    temperature = signal_value(t, p.operation.oil_temperature)
    tank_pressure = signal_value(t, p.operation.tank_pressure)
    rho, mu = density(temperature, p.oil), dynamic_viscosity(temperature, p.oil)
    return Conditions(
        density=rho,
        viscosity=mu,
        leakage_conductance=leakage_conductance(mu, p.valve),
        inertia=spool_inertia(p.valve),
        tank_pressure=tank_pressure,
        tank=fluid_state(tank_pressure, p.oil),
        branch=branch_law(rho, p.valve),
        ports=port_shape(p.valve),
    )


def supply_program(t: float, memory: Nothing, measured: object, settings: SupplyParams) -> tuple[Nothing, Command]:
    """The program of a bench: nothing is controlled, the conditions are read."""
    return memory, Command(conditions(t, settings), NOTHING)


def supply(t: float, s: SupplyState, u: Conditions, load_pressure: float, load: FluidState, p: SupplyParams) -> Supply:
    """The supply working against `load_pressure` (absolute [Pa], oil there in state `load`) at time `t` [s]."""
    tank_pressure, tank = u.tank_pressure, u.tank
    shaft_speed = signal_value(t, p.operation.pump_speed)
    motor_speed = signal_value(t, p.operation.spool_motor_speed)
    inlet = fluid_state(s.inlet_pressure, p.oil)

    pump = pump_flow(s.shaft_angle, shaft_speed, s.inlet_pressure - tank_pressure, p.pump)
    pump_leak = passage(pump.leakage, inlet, tank)

    ports = shape_openings(s.spool.angle, signal_value(t, p.operation.axial_position), u.ports)
    load_drop = s.inlet_pressure - load_pressure
    check = p.check_valve
    lift = select(check.opening_time > 0.0, s.check_opening, check_opening(load_drop, check))
    openings = Openings(ports.load * lift, ports.tank)
    load_branch = law_flow(load_drop, openings.load, u.branch)
    tank_branch = law_flow(s.inlet_pressure - tank_pressure, openings.tank, u.branch)
    to_load, to_tank = passage(load_branch.flow, inlet, load), passage(tank_branch.flow, inlet, tank)
    leak = passage(u.leakage_conductance * (load_pressure - tank_pressure), load, tank)

    surplus = pump.ideal - pump_leak.flow - to_load.flow - to_tank.flow
    relief = passage(
        relief_flow(s.inlet_pressure, tank_pressure, s.relief_opening, inlet.volume_ratio * surplus, p.relief_valve),
        inlet,
        tank,
    )

    torque = spool_torque(load_branch, tank_branch, openings, s.spool.speed, u.density, u.viscosity, p.valve)
    drive = drive_torque(motor_speed, s.spool.speed, p.spool_drive)
    rates = SupplyState(
        inlet_pressure=closed_volume_rate(surplus - relief.flow, 0.0, p.inlet.volume, inlet),
        relief_opening=relief_opening_rate(s.inlet_pressure, s.relief_opening, p.relief_valve),
        check_opening=check_opening_rate(load_drop, s.check_opening, check),
        shaft_angle=shaft_speed,
        spool=Spool(s.spool.speed, (torque.turbine - torque.friction + drive) / u.inertia),
    )
    spent = ValveSpent(
        nozzle=to_load.loss * load_branch.nozzle_share + to_tank.loss * tank_branch.nozzle_share,
        centre_section=to_load.loss * load_branch.centre_share + to_tank.loss * tank_branch.centre_share,
        outlet_turbine=to_load.loss * load_branch.outlet_share + to_tank.loss * tank_branch.outlet_share,
        relief_valve=relief.loss,
        valve_leakage=leak.loss,
        pump_leakage=pump_leak.loss,
        pump_friction=pump_friction_power(shaft_speed, p.pump),
        spool_friction=torque.friction * s.spool.speed,
        coupling=coupling_loss(motor_speed, s.spool.speed, p.spool_drive),
        to_spool=-torque.turbine * s.spool.speed,
    )
    supplied = Supplied(
        pump_shaft=shaft_power(pump.ideal, shaft_speed, tank, inlet, p.pump),
        spool_motor=drive_power(motor_speed, s.spool.speed, p.spool_drive),
        tank_oil=tank.enthalpy * pump.ideal,
    )
    return Supply(
        rates=rates,
        supplied=supplied,
        spent=spent,
        pump_flow=pump.ideal,
        pump_leakage=pump_leak.flow,
        relief_flow=relief.flow,
        load_flow=to_load.flow,
        tank_flow=to_tank.flow,
        leakage=leak.flow,
        openings=openings,
    )


def pwm_periods(t: float, s: SupplyState, p: SupplyParams) -> float:
    """PWM periods since the spool's angle was zero [1]."""
    return pwm_frequency(s.spool.angle, p.valve)


def supply_stop(t: float, p: SupplyParams) -> float:
    """The next corner of anything prescribed [s]."""
    prescribed = p.operation
    return minimum(
        minimum(signal_stop(t, prescribed.pump_speed), signal_stop(t, prescribed.oil_temperature)),
        minimum(
            minimum(signal_stop(t, prescribed.axial_position), signal_stop(t, prescribed.spool_motor_speed)),
            signal_stop(t, prescribed.tank_pressure),
        ),
    )
