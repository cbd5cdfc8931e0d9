"""The controllers that are compared: a law of the chamber drive, its gains, and what it receives."""

from dataclasses import dataclass, replace

from vvdp.comparison.loop_scenarios import GAINS, HIGH, LOW, LoopScenario, known_bench
from vvdp.control.backstepping import BacksteppingGains, best_pressure_weight
from vvdp.control.chamber import ChamberDrive, volume_compliance
from vvdp.control.passivity import PassivityGains
from vvdp.machines.axial_control import AxialControl, ChosenLaw, chosen_law, known_drive
from vvdp.machines.chamber_feedback import RawFeedback

PUBLISHED = PassivityGains(error_rate=50.0, position_gain=55.0, velocity_gain=4.0, flow_gain=4e-10)
PUBLISHED_BACKSTEPPING = BacksteppingGains(
    error_rate=50.0, position_gain=550.0, velocity_gain=45.0, pressure_weight=3e-12, flow_gain=4e-10
)
"""Gains of wang2017, table 5.1."""
RAW = RawFeedback(velocity_rate=377.0)
"""The slope of the raw signal behind a filter of 60 Hz."""


@dataclass(frozen=True)
class Controller:
    """A law with its gains, shown what the observer estimates unless a `feedback` says otherwise."""

    name: str
    title: str
    law: ChosenLaw
    feedback: RawFeedback | None = None

    def control(self, scenario: LoopScenario) -> AxialControl:
        """The control of a scenario with this law."""
        return replace(scenario.control, law=self.law, feedback=self.feedback)


def best_backstepping() -> BacksteppingGains:
    """The published gains with the lambda_2 that takes the measured velocity out of the flow, in mid travel."""
    gains = PUBLISHED_BACKSTEPPING
    bench = known_bench()
    drive = known_drive(bench.parts, bench.pilot)
    return replace(gains, pressure_weight=best_pressure_weight(middle_compliance(drive), gains, gains.flow_gain, drive))


def middle_compliance(drive: ChamberDrive) -> float:
    """V/beta [m^3/Pa] where the drive rests in the middle of the travel."""
    middle = 0.5 * (LOW + HIGH)
    pressure = drive.oil.reference_pressure + (drive.preload + drive.stiffness * middle) / drive.area
    return volume_compliance(middle, pressure, drive)


def controllers() -> tuple[Controller, ...]:
    """All controllers."""
    passive, backstepping = chosen_law(passivity=GAINS), chosen_law(backstepping=PUBLISHED_BACKSTEPPING)
    best = chosen_law(backstepping=best_backstepping())
    return (
        Controller("passivity", "passivity, exact feedforward, gain scheduled with V/beta", passive),
        Controller("printed", "the same with the feedforward as printed", chosen_law(printed_passivity=GAINS)),
        Controller("published", "passivity, feedforward and gains as printed", chosen_law(printed_passivity=PUBLISHED)),
        Controller("backstepping", "backstepping, gains as printed", backstepping),
        Controller("best-backstepping", "the same with the best lambda_2", best),
        Controller("raw", "passivity law, unfiltered position, velocity filter 60 Hz", passive, RAW),
    )
