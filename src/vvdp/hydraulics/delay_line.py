"""A long line without losses by the method of characteristics: what leaves an end arrives at the other a delay later.

Waves are taken in the root of power, w = (h + Z q)/(2 root(Z)), so that w^2 is the power that they carry. A sample of a
wave is its mean since the sample before; what its swing about that mean carried is counted as a loss where it arrives.

Source  wylie1993, ch. 3 (characteristics); waves in the root of power, samples: ours, docs/models/components.md
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Count, Energy, Flow, Kind, Length, Power, TankVolume
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive

SOUND_SPEED = Kind("speed of sound", "m/s", 50.0, 3000.0, "1260 m/s")
SoundSpeed = Annotated[float, SOUND_SPEED]
WAVE = Kind("power wave", "W^0.5", -1e6, 1e6, "100 W^0.5", scale=1.0)
Wave = Annotated[float, WAVE]
WAVE_TIME = Kind("power wave over time", "W^0.5*s", -1e12, 1e12, "1 W^0.5*s", scale=1e-2, accumulates=True)
WaveTime = Annotated[float, WAVE_TIME]


class DelayLine(Params):
    """A line whose waves run at `sound_speed` and keep their shape; its delay l/c is divided into `samples`."""

    length: Length
    diameter: Length
    sound_speed: SoundSpeed
    samples: Count = 100.0

    def check(self) -> None:
        require_positive(self, "length", "diameter")
        if self.samples < 1.0 or self.samples % 1.0:
            refuse(self, "samples", "must be a whole number of at least 1")


class DelayState(NamedTuple):
    """Energy and oil in a line, and what has left its ends so far: the waves over time, and their energy."""

    energy: Energy
    volume: TankVolume
    left_a: WaveTime
    left_b: WaveTime
    sent_a: Energy
    sent_b: Energy


class Arriving(NamedTuple):
    """The waves that arrive at both ends, and the root mean square of their swings since the sample before."""

    wave_a: Wave
    wave_b: Wave
    swing_a: Wave
    swing_b: Wave


class DelayEnds(NamedTuple):
    """Flows into a line at both ends [tank volumes], its loss, and the rates of its state."""

    a: Flow
    b: Flow
    loss: Power
    rates: DelayState


def line_delay(line: DelayLine) -> float:
    """Time of a wave from end to end [s]: l/c."""
    return line.length / line.sound_speed


def wave_impedance(density: float, line: DelayLine) -> float:
    """Pressure over flow in a single wave [Pa s/m^3]: rho c/A.

    density  of the oil at the tank [kg/m^3]

    Source  merritt1967, ch. 2

    >>> line = DelayLine(length=10.0, diameter=0.02, sound_speed=1250.0)
    >>> print(round(wave_impedance(880.0, line) * 1e-3 * 1e-5, 1))  # bar at 1 l/s
    35.0
    """
    return density * line.sound_speed / (0.25 * np.pi * line.diameter**2)


def delay_ends(enthalpy_a: float, enthalpy_b: float, arriving: Arriving, density: float, line: DelayLine) -> DelayEnds:
    """Flows and leaving waves at the ends of a line: q = (h - 2 root(Z) w)/Z goes in where w arrives, and h/root(Z) - w
    leaves.

    enthalpy_a, enthalpy_b  per tank volume, at the ends [J/m^3]
    density                 of the oil at the tank [kg/m^3]
    """
    Z = wave_impedance(density, line)
    root = np.sqrt(Z)
    wa, wb = arriving.wave_a, arriving.wave_b
    a, b = (enthalpy_a - 2.0 * root * wa) / Z, (enthalpy_b - 2.0 * root * wb) / Z
    out_a, out_b = enthalpy_a / root - wa, enthalpy_b / root - wb
    loss = arriving.swing_a * arriving.swing_a + arriving.swing_b * arriving.swing_b
    energy = out_a * out_a + out_b * out_b - wa * wa - wb * wb - loss
    rates = DelayState(
        energy=energy,
        volume=a + b,
        left_a=out_a,
        left_b=out_b,
        sent_a=out_a * out_a,
        sent_b=out_b * out_b,
    )
    return DelayEnds(a, b, loss, rates)


def delay_at_rest(enthalpy: float, density: float, line: DelayLine) -> DelayState:
    """State of a line without flow at one pressure: half its wave runs either way.

    enthalpy  per tank volume [J/m^3]
    density   of the oil at the tank [kg/m^3]
    """
    rest, T = rest_wave(enthalpy, density, line), line_delay(line)
    content = 0.25 * np.pi * line.diameter**2 * line.length
    compressed = enthalpy * T / wave_impedance(density, line)
    return DelayState(
        energy=2.0 * rest * rest * T,
        volume=content + compressed,
        left_a=0.0,
        left_b=0.0,
        sent_a=0.0,
        sent_b=0.0,
    )


def rest_wave(enthalpy: float, density: float, line: DelayLine) -> float:
    """The wave that runs either way in a line without flow [W^0.5]: h/(2 root(Z)).

    enthalpy  per tank volume [J/m^3]
    density   of the oil at the tank [kg/m^3]
    """
    wave: float = 0.5 * enthalpy / np.sqrt(wave_impedance(density, line))
    return wave


def delay_stored(state: DelayState) -> Stored:
    """Energy [J] and oil [tank volumes, m^3] in a line."""
    return Stored(state.energy, state.volume)
