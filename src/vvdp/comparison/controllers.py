"""The controllers that are compared: a law of the chamber drive with its gains, and what it receives.

Values stand here as in a system file.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from vvdp.comparison.loop_scenarios import HIGH, LOW
from vvdp.control.backstepping import best_pressure_weight
from vvdp.control.chamber import ChamberDrive, volume_compliance
from vvdp.machines.drive_loop import drawn_loop, law_of

FLOW_GAIN = "4e-10 m^3/(s*Pa)"
PUBLISHED = {"type": "printed-passivity", "flow_gain": FLOW_GAIN, "pressure_rate": "0 1/s"}
BACKSTEPPING = {
    "type": "backstepping",
    "error_rate": "50 1/s",
    "position_gain": "550 N/m",
    "velocity_gain": "45 N*s/m",
    "pressure_weight": "3e-12 m^3/Pa",
    "flow_gain": FLOW_GAIN,
}
"""Gains of wang2017, table 5.1. The shipped drive has them too, but for its `pressure_rate`: half of what samples of
1 ms allow."""
SLOPE = {"type": "derivative", "reads": "drive.sensor.position", "time_constant": f"{1.0 / 377.0!r} s"}
"""The slope of the raw signal behind a filter of 60 Hz."""


@dataclass(frozen=True)
class Controller:
    """A law: what a file gives of its program other than the shipped drive has it, and `programs` that it reads."""

    name: str
    title: str
    law: Mapping[str, str] = field(default_factory=dict)
    programs: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """Values of the circuit by their paths."""
        added = {f"programs.{name}": table for name, table in self.programs.items()}
        return {"programs.drive.law": self.law, **added} if self.law else added


def middle_compliance(drive: ChamberDrive) -> float:
    """V/beta [m^3/Pa] where the drive rests in the middle of the travel."""
    middle = 0.5 * (LOW + HIGH)
    pressure = drive.oil.reference_pressure + (drive.preload + drive.stiffness * middle) / drive.area
    return volume_compliance(middle, pressure, drive)


def best_backstepping() -> dict[str, str]:
    """The published law with the lambda_2 that takes the measured velocity out of the flow, in mid travel."""
    law = law_of(drawn_loop({"programs.drive.law": BACKSTEPPING}))
    best = best_pressure_weight(middle_compliance(law.drive), law.gains, law.gains.flow_gain, law.drive)
    return {**BACKSTEPPING, "pressure_weight": f"{float(best)!r} m^3/Pa"}


def controllers() -> tuple[Controller, ...]:
    """All controllers."""
    return (
        Controller("passivity", "passivity, exact feedforward, gain scheduled with V/beta"),
        Controller("printed", "the same with the feedforward as printed", {"type": "printed-passivity"}),
        Controller("published", "passivity, feedforward and gains as printed", PUBLISHED),
        Controller("backstepping", "backstepping, gains as printed", BACKSTEPPING),
        Controller("best-backstepping", "the same with the best lambda_2", best_backstepping()),
        Controller(
            "raw",
            "passivity law, unfiltered position, velocity filter 60 Hz",
            {"position": "drive.sensor.position", "velocity": "slope.rate"},
            {"slope": SLOPE},
        ),
    )
