"""Scenarios of the controllers: the reference, the sensor, and a drive that may be another than they know.

Values stand here as in a system file.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vvdp.control.reference import Pauses, trapezoid

USUAL, CLEAN = "nominal", "noise-free"
"""Names of the usual scenario, and of that with a sensor without noise."""
UNTIL = 3.0
"""End of a run [s]: errors count from 1.3 s on, over two periods of the trapezoid."""
LOW, HIGH = 0.25e-3, 5.25e-3
"""Between which positions the spool is moved [m]: 190 psi hold 6.3 mm."""
PAUSE, RAMP = 0.35, 0.05
"""Of the trapezoid [s]."""
FILTER_RATE = "250 1/s"
"""Of the four poles behind the reference."""
PERIOD = 1e-3
"""Of a sample where nothing else is stated [s]."""
SWING = 1.6
"""Of the periodic sensor error to either side, over its scale."""
BEGIN, END = "1.9 s", "2.1 s"
"""When the sensor fails in the scenarios in which it does, over a ramp of the trapezoid."""
KNOWN_AIR = 0.1
"""Air per oil as the controllers know it [1]."""
UNKNOWN_FRICTION = "20 N*s/m"
"""Viscous friction that the controllers do not know."""

Entries = Mapping[str, Any]
"""Values as a file gives them."""


@dataclass(frozen=True)
class LoopScenario:
    """The position that is wanted, values of the sensor, the time [s] between two samples, and values of the circuit
    that its controllers do not know."""

    name: str
    title: str
    wanted: Entries
    sensor: Entries = field(default_factory=lambda: _swing(0.2))
    period: float = PERIOD
    unknown: Entries = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """Values of the circuit by their paths. What drifts does so over time, noise is that of a sample."""
        share = np.sqrt(self.period / PERIOD)
        every = f"{self.period!r} s"
        return {
            "programs.drive.reference.reads": self.wanted,
            "programs.drive.reference.filter_rate": FILTER_RATE,
            "programs.drive.reference.leads": "1",
            **{f"programs.drive.sensor.{key}": value for key, value in self.sensor.items()},
            "programs.drive.observer.sample_period": every,
            "programs.drive.observer.position_drift": f"{share} um",
            "programs.drive.observer.velocity_drift": f"{2.0 * share} mm/s",
            "programs.drive.observer.coefficient_drift": f"{0.6 * share} um",
            "run.sample_period": every,
            "run.record_interval": every,
            "run.until": f"{UNTIL} s",
            **self.unknown,
        }


def _swing(amplitude: float) -> Entries:
    """A sensor whose periodic error swings by an amplitude [mm]."""
    return {"pollution_scale": f"{amplitude / SWING} mm"}


def _trapezoid() -> Entries:
    """The trapezoid, until the end of a run."""
    periods = int(np.ceil(UNTIL / (2.0 * (PAUSE + RAMP))))
    points = trapezoid(LOW, HIGH, Pauses(PAUSE, PAUSE), RAMP, periods)
    return {"table": [[f"{time!r} s", f"{position!r} m"] for time, position in points]}


def loop_scenarios() -> tuple[LoopScenario, ...]:
    """All scenarios."""
    usual = LoopScenario(USUAL, "trapezoid of 5 mm, sensor off by 0.2 mm and 20 um of noise", _trapezoid())
    return (usual, *_sensors(usual), *_plants(usual), *_periods(usual))


def _sensors(usual: LoopScenario) -> Iterator[LoopScenario]:
    """Another reference, and sensors that are better, worse and faulty."""
    middle = {"sine": "2.75 mm", "amplitude": "1.5 mm", "frequency": "5 Hz"}
    yield replace(usual, name="sine", title="sine of 1.5 mm and 5 Hz instead", wanted=middle)
    when = f"from {BEGIN.removesuffix(' s')} to {END}"
    faults: tuple[tuple[str, str, Entries], ...] = (
        (CLEAN, "a sensor without periodic sensor error and noise", {"pollution_scale": "0 mm", "noise": "0 um"}),
        ("polluted", "the sensor is off by 1 mm", _swing(1.0)),
        ("lost-sensor", f"the sensor shows nothing {when}", {"dropout_begin": BEGIN, "dropout_end": END}),
        ("frozen-sensor", f"the sensor stands still {when}", {"freeze_begin": BEGIN, "freeze_end": END}),
    )
    for name, title, changes in faults:
        yield replace(usual, name=name, title=title, sensor={**usual.sensor, **changes})


def _plants(usual: LoopScenario) -> Iterator[LoopScenario]:
    """Drives that the controllers do not know."""
    for name, ratio in (("air-trace", 0.001), ("air-low", 0.01), ("air-high", 0.3)):
        title = f"{100.0 * ratio:g} % of air in the oil, {100.0 * KNOWN_AIR:g} % known"
        mixed = {"oil.air_fraction": f"{ratio / (1.0 + ratio)}"}
        yield replace(usual, name=name, title=title, unknown=mixed)
    title = f"viscous friction of {UNKNOWN_FRICTION.replace('*', ' ')} that is not known"
    rough = {"components.drive.axial_friction.viscous_friction": UNKNOWN_FRICTION}
    yield replace(usual, name="friction", title=title, unknown=rough)


def _periods(usual: LoopScenario) -> Iterator[LoopScenario]:
    """Other sample periods."""
    for name, period in (("sampled-fast", 0.5e-3), ("sampled-slow", 2e-3), ("sampled-slowest", 3e-3)):
        yield replace(usual, name=name, title=f"a sample every {1e3 * period:g} ms", period=period)
