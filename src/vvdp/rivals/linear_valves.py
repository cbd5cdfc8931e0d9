"""Fast linear on/off valves instead of the rotary valve: which PWM frequency they reach, and what they lose there.

Source  wang2017, section 1.2.2
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.signal import constant
from vvdp.components.machines import PUMP
from vvdp.components.self_acting_valves import RELIEF_VALVE
from vvdp.components.switching_valves import PULSED_SWITCHING_VALVE, PulsedThreeWayValve
from vvdp.fluid.oil import density
from vvdp.hydraulics.orifice import Orifice, orifice_area_for
from vvdp.hydraulics.switching_valve import spool_frequency
from vvdp.network.build import build
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.simulation.balance import balance
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Stepping, simulate
from vvdp.steady.test_stand import Stand
from vvdp.valve.losses import full_open_drop

DAMPING, STROKE = 0.7, 1e-3
"""Assumed of all; of the stroke only shares count [1, m]."""
EDGE = Orifice(discharge_coefficient=0.61, transition_pressure=5e4)
STROKE_ENERGY = 300.0 * 30.0 * 1e-3
"""At most, of a stroke of Kajima's valve [J]: 300 V and up to 30 A for up to 1 ms."""
STROKES = 2.0
"""Driven strokes of a four-way spool in a period: there and back."""
SETTLING, AVERAGED = 6, 6
"""Periods before and while means are taken."""


class LinearValve(NamedTuple):
    """A valve as the source shows it: rated flow [m^3/s], drop [Pa], switching time [s]; nan what it does not show."""

    name: str
    flow: float
    drop: float
    switching_time: float


LPM = 1e-3 / 60.0
VALVES = (
    LinearValve("Kajima 1994, solenoid spool", 60.0 * LPM, 6e6, 1e-3),
    LinearValve("Lu, piezo, 3-way", 8.0 * LPM, 10e6, 1.45e-3),
    LinearValve("Cui 1990, moved by a rotary pilot", 18.0 * LPM, 9e6, 2e-3),
    LinearValve("Winkler, stroke amplifier", 100.0 * LPM, np.nan, 1e-3),
    LinearValve("Park, two stages", 9.0 * LPM, np.nan, 2e-3),
    LinearValve("Tsuchiya", 0.23 * LPM, np.nan, 1.5e-3),
    LinearValve("Yokota, piezo poppet", np.nan, np.nan, 1e-4),
)
"""Those of section 1.2.2; of 1.2 and 1.7 ms the mean is taken, of bounds the bound."""


class Switched(NamedTuple):
    """Result of a pulsed valve: mean loss [W] and flow to the load, in tank volumes [m^3/s]."""

    loss: float
    delivered: float


def highest_frequency(valve: LinearValve) -> float:
    """PWM frequency at which a valve just reaches either end within a period of half and half [Hz]."""
    return 0.5 / valve.switching_time


def valves_for(valve: LinearValve, flow: float, drop: float) -> float:
    """How many valves side by side pass a flow at a drop [1]: Q/Q_r root(dp_r/dp), not rounded.

    flow, drop  [m^3/s, Pa]

    >>> round(valves_for(VALVES[0], 40.0 * LPM, 6.68e5), 2)
    2.0
    """
    return flow / valve.flow * float(np.sqrt(valve.drop / drop))


def actuation_power(valves: float, frequency: float, strokes: float = STROKES) -> float:
    """Electrical power of valves of Kajima's kind at most [W]: N s f E.

    valves     N, side by side
    frequency  f, of the pulses [Hz]
    strokes    s, that are driven in a period; 1 where a spring returns the spool

    >>> actuation_power(2.0, 75.0), actuation_power(2.0, 75.0, 1.0)
    (2700.0, 1350.0)
    """
    return valves * strokes * frequency * STROKE_ENERGY


def rotary_drop(stand: Stand) -> float:
    """Drop of the open rotary valve at the flow of its pump [Pa]."""
    point = stand.set_point
    rho = float(density(point.oil_temperature, stand.bench.oil))
    return float(sum(full_open_drop(stand.pump_flow(point), rho, stand.bench.valve)))


def pulsed_valve(stand: Stand, switching_time: float, pwm_frequency: float, duty_ratio: float = 0.5) -> Network:
    """The pump unit of a stand against its load pressure, with linear valves instead of the rotary one.

    Open they drop as much as that does. Their lap is zero.

    switching_time, pwm_frequency  [s, Hz]
    """
    bench, point = stand.bench, stand.set_point
    rho = float(density(point.oil_temperature, bench.oil))
    values = PulsedThreeWayValve(
        natural_frequency=spool_frequency(switching_time, DAMPING),
        damping_ratio=DAMPING,
        stroke=STROKE,
        full_area=orifice_area_for(stand.pump_flow(point), rotary_drop(stand), rho, EDGE),
        discharge_coefficient=EDGE.discharge_coefficient,
        transition_pressure=EDGE.transition_pressure,
        frequency=pwm_frequency,
        duty_ratio=duty_ratio,
    )
    net = Network(bench.oil, temperature=constant(point.oil_temperature))
    net.tank("tank", constant(stand.tank_pressure))
    net.pressure_source("load", point.load_pressure)
    net.volume("inlet", Chamber(volume=bench.inlet_volume), start=point.load_pressure)
    net.driven_shaft("pump_shaft", constant(point.pump_speed))
    net.add("pump", PUMP, bench.pump, inlet="tank", outlet="inlet", shaft="pump_shaft")
    net.add("relief_valve", RELIEF_VALVE, bench.relief_valve, a="inlet", b="tank")
    ports = {"pressure": "inlet", "first": "load", "second": "tank"}
    net.add("valve", PULSED_SWITCHING_VALVE, values, **ports)
    return net


def switched_loss(stand: Stand, switching_time: float, pwm_frequency: float, duty_ratio: float = 0.5) -> Switched:
    """Simulated loss of linear valves instead of the rotary one, over whole periods after the first ones.

    switching_time, pwm_frequency  [s, Hz]
    """
    circuit = build(pulsed_valve(stand, switching_time, pwm_frequency, duty_ratio))
    period = 1.0 / pwm_frequency
    until = (SETTLING + AVERAGED) * period
    stepping = Stepping(until=until, record_interval=period, window=0.0)
    run = simulate(circuit.model, circuit.case, stepping)
    closed = balance(run)
    assert closed is not None and closed.is_trusted
    states, lasts = record_of(run).states, AVERAGED * period

    def mean(begins: str) -> float:
        paths = [path for path in states if path.startswith(begins)]
        return sum(float(states[path].values[-1] - states[path].values[SETTLING]) for path in paths) / lasts

    return Switched(mean("books.spent."), mean("books.totals.valve_first"))


def equal_loss_frequency(frequencies: list[float], losses: list[float], loss: float) -> float:
    """PWM frequency up to which losses stay below another one [Hz], by straight lines; nan where they never are."""
    if not losses[0] < loss:
        return float("nan")
    return float(np.interp(loss, np.fmax.accumulate(losses), frequencies))
