"""The duty ratio from the wave of the inlet pressure, and the excess by the valve's own throttling.

Derived and measured in docs/models/pressure-fusion.md, "Where the wave crosses a level".

Source  ours, docs/models/pressure-fusion.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Density, Flow, Pressure, Speed, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, maximum
from vvdp.estimation.pressure_edges import PressureReading
from vvdp.valve.branch import centre_resistance, nozzle_resistance, outlet_resistance
from vvdp.valve.geometry import PortShape, port_shape, wedge_opening
from vvdp.valve.rotary import RotaryValve

HALVINGS = 40


class DutyWave(Params):
    """Model for the estimate of the duty ratio from the wave: the valve, and the pump flow at the valve's tank side."""

    valve: RotaryValve
    flow: Flow
    density: Density
    tank_pressure: Pressure

    def check(self) -> None:
        require_positive(self, "flow")


class DutyReading(NamedTuple):
    """A reading of the pressure's edges, with the spool's unwrapped angle and its speed as estimated at its time; speed
    0: neither is known."""

    pressure: PressureReading
    angle: Angle
    speed: Speed


class DutyEstimate(NamedTuple):
    """The duty ratio of the last complete pulse, corrected and as the wave has it, and how far off the edges' time
    resolution alone may put it (standard deviation). NaN before the first pulse."""

    duty_ratio: float
    wave_duty_ratio: float
    deviation: float


class RisingEdge(NamedTuple):
    """A rising edge, with the time of the one before it. Before the first, all of it is NaN."""

    time: Time
    angle: Angle
    interval: Time
    level: Pressure
    before: Time


class DutyWaveMemory(NamedTuple):
    """The last rising edge, 1 while no falling edge has followed, and the last duty ratio."""

    rise: RisingEdge
    within_pulse: float
    found: DutyEstimate


def wave_duty_ratio(rise_angle: float, fall_angle: float, sections: float) -> float:
    """Share of a PWM period between two crossings [1]: (theta_fall - theta_rise) N / (2 pi).

    rise_angle, fall_angle  of the spool at the crossings [rad]
    sections                N [1]
    """
    share: float = (fall_angle - rise_angle) * sections / (2.0 * np.pi)
    return share


def crossing_opening(level_drop: float, flow: float, density: float, valve: RotaryValve) -> float:
    """Open fraction of the tank ports at which the whole flow takes `level_drop` to get to the tank [1].

    a = sqrt(R_n Q^2 / (dP - R_c Q^m - R_o Q^2)), at most 1.

    level_drop  crossing level less tank pressure [Pa]
    flow        of the pump [m^3/s]
    density     [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5, solved for the opening; docs/models/pressure-fusion.md
    """
    Q = flow
    nozzle = nozzle_resistance(density, valve) * Q * Q
    rest = centre_resistance(valve) * Q**valve.centre_flow_exponent + outlet_resistance(density, valve) * Q * Q
    opening: float = np.sqrt(nozzle / maximum(level_drop - rest, nozzle))
    return opening


def duty_excess(level_drop: float, flow: float, density: float, valve: RotaryValve) -> float:
    """Excess of the duty ratio of the wave over that of the spool, while the ports still open fully [1].

    The pressure rises while the tank ports close, before the middle of the transition, and falls while they open,
    after it: b/P_c + (2 a - 1) d_c/P_c with the crossing's opening a.

    level_drop  crossing level less tank pressure [Pa]
    flow        of the pump [m^3/s]
    density     [kg/m^3]
    """
    shape = port_shape(valve)
    a = crossing_opening(level_drop, flow, density, valve)
    return shape.barrier_width + (2.0 * a - 1.0) * shape.nozzle_width


def corrected_duty_ratio(wave_duty: float, opening: float, shape: PortShape) -> float:
    """Duty ratio of the spool whose wave has `wave_duty` at the level where the tank ports are `opening` open [1].

    Solves a_T(wave_duty/2, d) = a for d. While both ports open fully this subtracts `duty_excess`; at duty ratios
    near 0 and 1, where one never does, it follows the product of the two ramps.
    """
    distance = clip(0.5 * wave_duty, 0.0, 0.5)
    low, high = -shape.nozzle_width - shape.barrier_width, 1.0 + shape.nozzle_width + shape.barrier_width
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        load_side = wedge_opening(distance, 0.5 * (middle + shape.barrier_width), shape.nozzle_width)
        if load_side < 1.0 - opening:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def pressure_lag(
    level_drop: float, flow: float, density: float, inlet_volume: float, bulk_modulus: float, valve: RotaryValve
) -> float:
    """Delay of the pressure at the crossing, because the inlet volume has to be filled or emptied [s].

    V/beta dP/dQ with dP/dQ = (2 R_n Q^2/a^2 + m R_c Q^m + 2 R_o Q^2)/Q at the crossing's opening a: the same for both
    edges, so that it shifts the wave and leaves its duty ratio alone.

    level_drop    crossing level less tank pressure [Pa]
    flow          of the pump [m^3/s]
    density       [kg/m^3]
    inlet_volume  between pump and ports [m^3]
    bulk_modulus  of the oil there, at the crossing level [Pa]
    """
    Q, m = flow, valve.centre_flow_exponent
    centre = centre_resistance(valve) * Q**m
    outlet = outlet_resistance(density, valve) * Q * Q
    nozzle = maximum(level_drop - centre - outlet, nozzle_resistance(density, valve) * Q * Q)
    resistance: float = (2.0 * nozzle + m * centre + 2.0 * outlet) / Q
    return inlet_volume / bulk_modulus * resistance


def duty_start() -> DutyWaveMemory:
    """The memory before the first edge."""
    return DutyWaveMemory(
        rise=RisingEdge(time=np.nan, angle=np.nan, interval=np.nan, level=np.nan, before=np.nan),
        within_pulse=0.0,
        found=DutyEstimate(duty_ratio=np.nan, wave_duty_ratio=np.nan, deviation=np.nan),
    )


def duty_step(memory: DutyWaveMemory, reading: DutyReading, settings: DutyWave) -> tuple[DutyWaveMemory, DutyEstimate]:
    """The memory after a sample, and the duty ratio of the last pulse that is complete.

    Where the speed is unknown, shares of the time between the last two rising edges stand for shares of the angle.

    Source  wang2017, section 7.3, for the idea; docs/models/pressure-fusion.md
    """
    edge, N = reading.pressure, settings.valve.sections
    rise, within, found = memory.rise, memory.within_pulse, memory.found
    moving = reading.speed > 0.0
    angle = reading.angle - reading.speed * (edge.time - edge.pressure_edge_time) if moving else np.nan
    if edge.pressure_edges > 0.0 and edge.pressure_polarity > 0.0:
        rise = RisingEdge(
            time=edge.pressure_edge_time,
            angle=angle,
            interval=edge.pressure_edge_interval,
            level=edge.level,
            before=rise.time,
        )
        within = 1.0
    falling = edge.pressure_edges > 0.0 and edge.pressure_polarity < 0.0
    known = moving and rise.angle > -np.inf  # NaN while the speed was unknown
    if falling and within > 0.0 and (known or rise.time > rise.before):
        frequency = reading.speed * N / (2.0 * np.pi) if known else 1.0 / (rise.time - rise.before)
        wave = wave_duty_ratio(rise.angle, angle, N) if known else frequency * (edge.pressure_edge_time - rise.time)
        spread = rise.interval * rise.interval + edge.pressure_edge_interval * edge.pressure_edge_interval
        drop = 0.5 * (rise.level + edge.level) - settings.tank_pressure
        opening = crossing_opening(drop, settings.flow, settings.density, settings.valve)
        found = DutyEstimate(
            duty_ratio=corrected_duty_ratio(wave, opening, port_shape(settings.valve)),
            wave_duty_ratio=wave,
            deviation=frequency * np.sqrt(spread / 12.0),
        )
    within = 0.0 if falling else within
    return DutyWaveMemory(rise=rise, within_pulse=within, found=found), found
