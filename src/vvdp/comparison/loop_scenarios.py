"""Scenarios of the controllers: the reference, the sensor, and a drive that may be another than they know."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from vvdp.base.signal import Signal, sine
from vvdp.control.passivity import PassivityGains
from vvdp.control.reference import Pauses, ReferenceFilter, trapezoid
from vvdp.machines.axial_control import AxialControl, chosen_law
from vvdp.machines.chamber_bench import ChamberBench, chamber_bench
from vvdp.programs.axial_loop import AxialObserverTable, AxialSequence
from vvdp.systems.system import load_system

USUAL, CLEAN = "nominal", "noise-free"
"""Names of the usual scenario, and of that with a sensor without noise."""
UNTIL = 3.0
"""End of a run [s]: errors count from 1.3 s on, over two periods of the trapezoid."""
LOW, HIGH = 0.25e-3, 5.25e-3
"""Between which positions the spool is moved [m]: 190 psi hold 6.3 mm."""
PAUSE, RAMP = 0.35, 0.05
"""Of the trapezoid [s]."""
SINE_AMPLITUDE, SINE_FREQUENCY = 1.5e-3, 5.0
"""Of the sine about the middle [m, Hz]."""
FILTER_RATE = 250.0
"""Of the four poles behind the reference [1/s]."""
PERIOD = 1e-3
"""Of a sample where nothing else is stated [s]."""
POLLUTION, STRONG_POLLUTION = 0.2e-3 / 1.6, 1e-3 / 1.6
"""Scale of the periodic sensor error, usual and strong [m]; it swings by 1.6 times that to either side."""
FAULT = (1.9, 2.1)
"""When the sensor fails in the scenarios in which it does, over a ramp of the trapezoid [s]."""
KNOWN_AIR = 0.1
"""Air per oil as the controllers know it [1]."""
UNKNOWN_FRICTION = 20.0
"""Viscous friction that the controllers do not know [N s/m]."""

GAINS = PassivityGains(error_rate=50.0, position_gain=55.0, velocity_gain=4.0, pressure_rate=500.0)
"""Those of wang2017, table 5.1, but for the pressure's: half of what samples of 1 ms allow."""


@dataclass(frozen=True)
class LoopScenario:
    """A drive, the one that its controllers know, and reference, sensor and sample period in `control`."""

    name: str
    title: str
    plant: ChamberBench
    known: ChamberBench
    control: AxialControl

    @property
    def period(self) -> float:
        """Between two samples [s]."""
        return self.control.observer.sample_period


@cache
def known_bench() -> ChamberBench:
    """The drive as the controllers know it: the shipped one, the spool without friction, as the source has it."""
    return with_friction(with_air(chamber_bench(load_system("axial-chamber")), KNOWN_AIR), 0.0)


def with_air(bench: ChamberBench, ratio: float) -> ChamberBench:
    """The drive with another share of air per oil [1]; of the mixture it is R/(1 + R)."""
    oil = replace(bench.parts.oil, air_fraction=ratio / (1.0 + ratio))
    return replace(bench, parts=replace(bench.parts, oil=oil))


def with_friction(bench: ChamberBench, friction: float) -> ChamberBench:
    """The drive with another viscous friction [N s/m]."""
    found = replace(bench.parts.friction, viscous_friction=friction)
    return replace(bench, parts=replace(bench.parts, friction=found))


def usual_reference() -> Signal:
    """The trapezoid, until the end of a run."""
    periods = int(np.ceil(UNTIL / (2.0 * (PAUSE + RAMP))))
    return trapezoid(LOW, HIGH, Pauses(PAUSE, PAUSE), RAMP, periods)


def observer_table(period: float) -> AxialObserverTable:
    """The observer sampled every `period` [s]: what drifts does so over time, noise is that of a sample."""
    share = np.sqrt(period / PERIOD)
    return AxialObserverTable(
        sample_period=period,
        harmonics=5.0,
        sensor_deviation=30e-6,
        position_drift=1e-6 * share,
        velocity_drift=2e-3 * share,
        coefficient_drift=0.6e-6 * share,
        coefficient_deviation=1e-3,
    )


def loop_scenarios() -> tuple[LoopScenario, ...]:
    """All scenarios."""
    known = known_bench()
    control = AxialControl(
        sensor=replace(known.sensor, pollution_scale=POLLUTION),
        observer=observer_table(PERIOD),
        law=chosen_law(passivity=GAINS),
        reference=ReferenceFilter(filter_rate=FILTER_RATE),
        sequence=AxialSequence(home_time=0.02, learn_time=0.3),
        helix_length=known.helix_length,
        wanted=usual_reference(),
    )
    usual = LoopScenario(USUAL, "trapezoid of 5 mm, sensor off by 0.2 mm and 20 um of noise", known, known, control)
    return (usual, *_sensors(usual), *_plants(usual), *_periods(usual))


def _sensors(usual: LoopScenario) -> Iterator[LoopScenario]:
    """Another reference, and sensors that are better, worse and faulty."""
    middle = sine(0.5 * (LOW + HIGH), SINE_AMPLITUDE, SINE_FREQUENCY)
    begin, end = FAULT
    when = f"from {begin:g} to {end:g} s"
    yield replace(
        usual, name="sine", title="sine of 1.5 mm and 5 Hz instead", control=replace(usual.control, wanted=middle)
    )
    faults: tuple[tuple[str, str, Mapping[str, Any]], ...] = (
        (CLEAN, "a sensor without periodic sensor error and noise", {"pollution_scale": 0.0, "noise": 0.0}),
        ("polluted", "the sensor is off by 1 mm", {"pollution_scale": STRONG_POLLUTION}),
        ("lost-sensor", f"the sensor shows nothing {when}", {"dropout_begin": begin, "dropout_end": end}),
        ("frozen-sensor", f"the sensor stands still {when}", {"freeze_begin": begin, "freeze_end": end}),
    )
    for name, title, changes in faults:
        sensor = replace(usual.control.sensor, **changes)
        yield replace(usual, name=name, title=title, control=replace(usual.control, sensor=sensor))


def _plants(usual: LoopScenario) -> Iterator[LoopScenario]:
    """Drives that the controllers do not know."""
    for name, ratio in (("air-trace", 0.001), ("air-low", 0.01), ("air-high", 0.3)):
        title = f"{100.0 * ratio:g} % of air in the oil, {100.0 * KNOWN_AIR:g} % known"
        yield replace(usual, name=name, title=title, plant=with_air(usual.plant, ratio))
    title = f"viscous friction of {UNKNOWN_FRICTION:g} N s/m that is not known"
    yield replace(usual, name="friction", title=title, plant=with_friction(usual.plant, UNKNOWN_FRICTION))


def _periods(usual: LoopScenario) -> Iterator[LoopScenario]:
    """Other sample periods."""
    for name, period in (("sampled-fast", 0.5e-3), ("sampled-slow", 2e-3), ("sampled-slowest", 3e-3)):
        control = replace(usual.control, observer=observer_table(period))
        yield replace(usual, name=name, title=f"a sample every {1e3 * period:g} ms", control=control)
