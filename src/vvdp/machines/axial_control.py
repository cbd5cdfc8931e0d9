"""The control of an axial drive as a part of a network: the program with its values, from the tables of a system."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.signal import Signal
from vvdp.components.axial_drive import ChamberDrive as DriveParts
from vvdp.components.axial_drive import PilotJoints, add_chamber_drive, check_stroke
from vvdp.control.backstepping import BacksteppingGains, refuse_flow_gain
from vvdp.control.chamber import ChamberDrive
from vvdp.control.orifice import ChamberValve
from vvdp.control.passivity import PassivityGains
from vvdp.control.reference import ReferenceFilter
from vvdp.estimation.chamber_observer import ChamberObserver, SpringDrive
from vvdp.machines.axial_tables import PilotSupply
from vvdp.machines.chamber_feedback import (
    RawFeedback,
    raw_backstepping_step,
    raw_passive_step,
    raw_printed_step,
)
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.axial_loop import PROGRAM, UNKNOWN, AxialObserverTable, AxialPlace, AxialSequence
from vvdp.programs.axial_sensor import AxialSensorTable, axial_sensor_of
from vvdp.programs.chamber_loop import (
    BacksteppingLoop,
    ChamberLoop,
    PassiveLoop,
    backstepping_step,
    chamber_loop_start,
    passive_step,
    printed_step,
)
from vvdp.programs.chamber_observer import observer_of

Step = Callable[..., Any]


class Laws(NamedTuple):
    """A law's programs: with the observer's estimate, or with what the sensor shows."""

    observed: Step
    raw: Step


PASSIVE = Laws(passive_step, raw_passive_step)
PRINTED = Laws(printed_step, raw_printed_step)
BACKSTEPPING = Laws(backstepping_step, raw_backstepping_step)


@dataclass(frozen=True)
class ChosenLaw:
    """The one law that a system gives gains for, and by which table."""

    laws: Laws
    gains: PassivityGains | BacksteppingGains


def chosen_law(
    passivity: PassivityGains | None = None,
    printed_passivity: PassivityGains | None = None,
    backstepping: BacksteppingGains | None = None,
) -> ChosenLaw:
    """The law whose gains are given. Raises ParameterError where that is none, or more than one."""
    pairs = ((PASSIVE, passivity), (PRINTED, printed_passivity), (BACKSTEPPING, backstepping))
    given = [ChosenLaw(laws, gains) for laws, gains in pairs if gains is not None]
    if len(given) != 1:
        raise ParameterError("expected one table of gains: [passivity], [printed_passivity] or [backstepping]")
    return given[0]


@dataclass(frozen=True)
class AxialControl:
    """The tables of the control of an axial drive, and the `wanted` position [m].

    The law receives what the observer estimates, unless a `feedback` says otherwise. `asked_by` is the value that asks
    for the position.
    """

    sensor: AxialSensorTable
    observer: AxialObserverTable
    law: ChosenLaw
    reference: ReferenceFilter
    sequence: AxialSequence
    helix_length: float
    wanted: Signal
    feedback: RawFeedback | None = None
    asked_by: str = "operation.duty_ratio"


def known_drive(parts: DriveParts, pilot: PilotSupply) -> ChamberDrive:
    """The drive as its controller knows it: all values are those of the drive itself, the supply at its lowest."""
    valve = ChamberValve(
        conductance=parts.valve.discharge_coefficient * parts.valve.full_area * np.sqrt(2.0 / parts.oil.density),
        supply_pressure=pilot.supply_pressure.extremes[0],
        tank_pressure=pilot.tank_pressure.extremes[1],
    )
    spring = parts.spring
    return ChamberDrive(
        area=parts.piston.area_a,
        moving_mass=parts.piston.moving_mass,
        stiffness=spring.stiffness,
        preload=spring.preload - spring.stiffness * spring.rest_position,
        oil_volume=parts.chamber.volume,
        oil=parts.oil,
        valve=valve,
    )


def chamber_observer(control: AxialControl, drive: ChamberDrive, friction: float, stop: float) -> ChamberObserver:
    """The observer of a table, for a drive with viscous `friction` [N s/m] whose stop lies at a position [m]."""
    plant = SpringDrive(
        moving_mass=drive.moving_mass,
        stiffness=drive.stiffness,
        preload=drive.preload,
        viscous_friction=friction,
        area=drive.area,
        reference_pressure=drive.oil.reference_pressure,
    )
    return observer_of(control.observer, plant, stop, control.helix_length)


def chamber_loop(control: AxialControl, parts: DriveParts, pilot: PilotSupply) -> ChamberLoop:
    """The values of the loop. Raises ParameterError where an end stop lies below the position that is wanted."""
    check_stroke(control.asked_by, control.wanted.extremes[1], parts.stops)
    drive = known_drive(parts, pilot)
    gains = control.law.gains
    values: dict[str, Any] = {
        "sensor": axial_sensor_of(control.sensor),
        "observer": chamber_observer(control, drive, parts.friction.viscous_friction, parts.stops.lower_end),
        "drive": drive,
        "reference": control.reference,
        "sequence": control.sequence,
        "wanted": control.wanted,
    }
    if control.feedback is not None:
        values["velocity_rate"] = control.feedback.velocity_rate
    if isinstance(gains, PassivityGains):
        period = control.observer.sample_period
        if gains.flow_hold not in (0.0, period):
            raise ParameterError(
                f"passivity.flow_hold: {gains.flow_hold:g} s must be 0 or the sample_period, {period:g} s"
            )
        return PassiveLoop(gains=gains, **values)
    try:
        refuse_flow_gain(gains, drive)
    except ParameterError as problem:
        raise ParameterError(f"backstepping.{problem}") from None
    return BacksteppingLoop(gains=gains, **values)


def add_drive(net: Network, parts: DriveParts, pilot: PilotSupply) -> str:
    """Add a chamber drive whose valve the program `PROGRAM` commands; returns the path of the spool's position."""
    return add_chamber_drive(net, parts, PilotJoints(pilot.supply_pressure, pilot.tank_pressure, f"{PROGRAM}.drive"))


def add_chamber_control(net: Network, control: AxialControl, loop: ChamberLoop, spool: str) -> None:
    """Add the program that controls a chamber drive whose spool turns with the shaft `spool`, its angle known."""
    laws = control.law.laws
    step = laws.observed if control.feedback is None else laws.raw
    kind = ProgramType(step, AxialPlace, UNKNOWN, type(loop), chamber_loop_start)
    net.program(PROGRAM, kind, loop, reads=_reads(spool), period=loop.observer.sample_period)


def _reads(spool: str) -> dict[str, str]:
    """Where each field of an `AxialPlace` is read."""
    return {
        "time": "t",
        "angle": f"{spool}.angle",
        "speed": f"{spool}.speed",
        "position": "slide.position",
        "pressure": "pilot_chamber.pressure",
    }
