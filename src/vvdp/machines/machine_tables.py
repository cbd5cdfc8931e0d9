"""The tables of the whole machine that are not a component's."""

from vvdp.base.kinds import (
    ForceSignal,
    FractionSignal,
    Position,
    PositionSignal,
    Pressure,
    PressureSignal,
    SignedFractionSignal,
    SpeedSignal,
    TemperatureSignal,
)
from vvdp.base.params import Params
from vvdp.machines.axial_tables import InitialChamber, InitialPosition
from vvdp.systems.bench_tables import InitialSupply, MotorSpeed


class MachineOperation(Params):
    """What is prescribed from outside: the pump's speed while its motor is on, the force on the cylinder's rod in the
    direction of its position, temperature and pressure of the tank."""

    pump_speed: SpeedSignal
    spool_motor_speed: MotorSpeed
    load_force: ForceSignal
    oil_temperature: TemperatureSignal
    tank_pressure: PressureSignal


class PrescribedCommands(Params):
    """The [prescribed] table: what every drive is commanded over time, instead of all control.

    `direction` 1 extends the cylinder, `opening` is that of the return valve, `pump` 1 switches the motor on, `dump` 1
    holds the dump valve closed. `drive` is the command of the axial drive, `spool_position` what an ideal one follows.
    """

    direction: SignedFractionSignal
    opening: FractionSignal
    pump: FractionSignal
    dump: FractionSignal
    drive: SignedFractionSignal
    spool_position: PositionSignal


class InitialMachine(InitialSupply):
    """Where a run starts: at rest."""

    line_pressure: Pressure
    pressure_a: Pressure
    pressure_b: Pressure
    cylinder_position: Position


class InitialSpringMachine(InitialMachine, InitialChamber):
    """Where a run with a pressure chamber at the spool starts."""


class InitialGerotorMachine(InitialMachine, InitialPosition):
    """Where a run with a gerotor drive, or an ideal one, starts."""
