"""What is claimed of a rotary PWM valve, each as a function: against throttling, against a linear valve, self-spinning
or driven, and its ripple."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.hydraulics.pump import pump_friction_power
from vvdp.rigs.conditions import LPM, conditions, gauge
from vvdp.rigs.result import Column, RigResult, Sheet
from vvdp.rigs.ripple import line_capacity, power_of, ripple, with_gas
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import SetPoint, Stand
from vvdp.valve.geometry import nozzle_length, transition_fraction
from vvdp.valve.losses import full_open_drop
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import equilibrium_speed, friction_coefficient, pwm_frequency

DUTY_RATIOS = (0.15, 0.25, 0.35, 0.5, 0.65, 0.75, 0.85, 1.0)
PRESSURE_SHARES = (0.4, 0.6, 0.8)
"""Load pressures for the comparison with throttling, over the relief setting."""
FLOW_SHARES = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Flows of the comparison of drives, over the pump flow of the system."""
FREQUENCIES = (5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0)
DRIVEN_SHARE = 0.6
"""Load pressure of the comparison of drives, over the relief setting: ripple must not reach the relief valve."""
LIGHT_MASS = 0.1
"""Moving mass of a light linear spool that the rotary one is compared with, besides one of its own mass [kg]."""
ACTUATION_FREQUENCIES = tuple(float(f) for f in np.round(np.geomspace(5.0, 200.0, 25), 6))
RIPPLE_FREQUENCIES, RIPPLE_SIZES = (20.0, 30.0, 45.0, 60.0, 90.0, 120.0), (0.25, 0.5, 1.0, 2.0, 4.0)


def metered_loss(pump_flow: float, delivered: float, load_rise: float, relief_rise: float) -> float:
    """Power lost when a fixed pump runs at its relief setting and a throttle meters the load's flow [W].

    Q (P_R - P_T) - q (P_L - P_T)

    pump_flow, delivered    Q, q [m^3/s]
    load_rise, relief_rise  of load and relief setting over the tank [Pa]

    Source  wang2017, chapter 1
    """
    return pump_flow * relief_rise - delivered * load_rise


def bled_off_loss(pump_flow: float, delivered: float, load_rise: float) -> float:
    """Power lost when a fixed pump runs at load pressure and a throttle sends what is too much to the tank [W].

    (Q - q) (P_L - P_T): the best that throttling can do, without any drop on the way to the load.

    pump_flow, delivered  Q, q [m^3/s]
    load_rise             of the load over the tank [Pa]

    Source  ours, docs/rigs.md
    """
    return (pump_flow - delivered) * load_rise


def rotary_actuation_power(pwm_frequency: float, sections: float, friction: float) -> float:
    """Power that turns a rotary spool against its viscous friction [W]: k_f (2 pi f / N)^2.

    pwm_frequency  [Hz]
    friction       torque over speed [N m s]

    Source  wang2017, chapter 1 and eq. 2.9
    """
    speed = 2.0 * np.pi * pwm_frequency / sections
    return friction * speed * speed


def linear_actuation_power(pwm_frequency: float, mass: float, stroke: float, transition: float) -> float:
    """Power that moves a linear spool to and fro [W]: 4 m x^2 f^3 / kappa^2.

    Constant acceleration over the first half of a stroke, constant braking over the second, within the share kappa of a
    period: the highest speed is 2 x f / kappa, and its kinetic energy is spent in each of two strokes per period.

    pwm_frequency  [Hz]
    mass           moved [kg]
    stroke         [m]
    transition     time of a stroke over the period [1]

    Source  wang2017, chapter 1, f^3; the factor is ours, docs/rigs.md
    """
    highest = 2.0 * stroke * pwm_frequency / transition
    return mass * highest * highest * pwm_frequency


def equal_power_frequency(sections: float, friction: float, mass: float, stroke: float, transition: float) -> float:
    """PWM frequency above which the linear spool takes more power than the rotary one [Hz].

    k_f (2 pi/N)^2 kappa^2 / (4 m x^2)

    Source  ours, docs/rigs.md
    """
    rotary = rotary_actuation_power(1.0, sections, friction)
    return rotary / linear_actuation_power(1.0, mass, stroke, transition)


@dataclass(frozen=True)
class Throttling:
    """Losses of the PWM valve and of throttling the same pump at the same delivered flow and load pressure."""

    load_pressure: Array  # gauge [Pa]
    duty_ratio: Array
    delivered: Array  # [m^3/s]
    share: Array  # of the pump flow [1]
    switched: Array  # [W]
    metered: Array  # [W]
    bled_off: Array  # [W]


def against_throttling(
    stand: Stand,
    duty_ratios: Sequence[float] = DUTY_RATIOS,
    pressure_shares: Sequence[float] = PRESSURE_SHARES,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> Throttling:
    """Loss of the PWM valve, simulated, beside two ways of throttling the same pump to the same flow.

    The pump turns as fast in all three, so its friction T_f |omega| is in all of them.

    Source  wang2017, chapter 1
    """
    here = stand.set_point
    rise = stand.relief_pressure - stand.tank_pressure
    points = [
        here._replace(duty_ratio=float(d), load_pressure=float(stand.tank_pressure + share * rise))
        for share in pressure_shares
        for d in duty_ratios
    ]
    states = _solved(steady_states([(stand, p) for p in points], cores=cores, cache=cache, say=say))
    flow, friction = stand.pump_flow(here), pump_friction_power(here.pump_speed, stand.bench.pump)
    delivered = np.array([float(state.summary["mean_load_flow_m3_s"]) for state in states])
    load = np.array([state.point.load_pressure - stand.tank_pressure for state in states])
    loss = np.array([float(state.summary["loss_total_W"]) for state in states])
    return Throttling(
        load_pressure=np.array([state.point.load_pressure - stand.reference for state in states]),
        duty_ratio=np.array([state.point.duty_ratio for state in states]),
        delivered=delivered,
        share=delivered / flow,
        switched=loss,
        metered=np.array([metered_loss(flow, q, p, rise) for q, p in zip(delivered, load, strict=True)]) + friction,
        bled_off=np.array([bled_off_loss(flow, q, p) for q, p in zip(delivered, load, strict=True)]) + friction,
    )


def _solved(states: Sequence[Steady]) -> list[Steady]:
    """Those that have a periodic state. Raises ParameterError where none has."""
    found = [state for state in states if state.reason is None]
    if not found:
        raise ParameterError(f"no set point has a steady state; the first: {states[0].reason}")
    return found


@dataclass(frozen=True)
class Driving:
    """A self-spinning spool beside one that a motor turns, at several pump flows.

    Rows of `self_*` are flows; those of the grids are flows and PWM frequencies, nan where there is no steady state.
    A motor that brakes the spool gives nothing back.
    """

    flows: Array
    self_frequency: Array
    self_loss: Array
    self_ripple: Array
    frequencies: Array
    drive_power: Array  # (flows, frequencies)
    friction_power: Array
    loss: Array
    ripple: Array
    limit: float
    best_frequency: Array
    best_loss: Array
    best_drive_power: Array


def self_spinning(stand: Stand) -> Stand:
    """The same stand with nothing that turns the spool but the flow."""
    return stand.changed(spool_drive={"coupling": 0.0})


def driving_point(stand: Stand, flow: float) -> SetPoint:
    """Where drives are compared at a pump flow [m^3/s]."""
    pressure = stand.tank_pressure + DRIVEN_SHARE * (stand.relief_pressure - stand.tank_pressure)
    speed = float(flow) / stand.bench.pump.displacement
    return stand.set_point._replace(pump_speed=speed, load_pressure=float(pressure))


def self_against_driven(
    stand: Stand,
    flows: Sequence[float] | None = None,
    frequencies: Sequence[float] = FREQUENCIES,
    ripple_limit: float | None = None,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> Driving:
    """Drive power and total loss over flow, and the PWM frequency that loses least within a limit of the ripple.

    The load's ripple is what asks for a frequency: without a limit the slowest spool loses least. By default the limit
    is the ripple of the self-spinning spool at the largest flow, and the pump flows [m^3/s] are `FLOW_SHARES` of the
    stand's own. Raises ParameterError without a load line.

    Source  wang2017, section 2.1, after tu2011; ours, docs/rigs.md
    """
    if not stand.makes_pressure:
        raise ParameterError(f"{stand.name}: expected a system with a load line, whose pressure can ripple")
    if flows is None:
        flows = [share * stand.pump_flow(stand.set_point) for share in FLOW_SHARES]
    at = [driving_point(stand, q) for q in flows]
    stands: list[tuple[Stand, SetPoint]] = [(self_spinning(stand), point) for point in at]
    stands += [(stand.driven(float(f)), point) for point in at for f in frequencies]
    states = steady_states(stands, cores=cores, cache=cache, say=say)
    rows = [_driven_row(state) for state in states]
    alone, grid = np.array(rows[: len(at)]), np.array(rows[len(at) :]).reshape(len(at), len(frequencies), 5)
    limit = float(ripple_limit if ripple_limit is not None else alone[-1, 2])
    asked = np.array(list(frequencies), float)
    best = np.array([best_frequency(asked, row[:, 1], row[:, 2], row[:, 3], limit) for row in grid])
    return Driving(
        flows=np.array(list(flows), float),
        self_frequency=alone[:, 0],
        self_loss=alone[:, 1],
        self_ripple=alone[:, 2],
        frequencies=asked,
        drive_power=grid[:, :, 3],
        friction_power=grid[:, :, 4],
        loss=grid[:, :, 1],
        ripple=grid[:, :, 2],
        limit=limit,
        best_frequency=best[:, 0],
        best_loss=best[:, 1],
        best_drive_power=best[:, 2],
    )


def _driven_row(state: Steady) -> tuple[float, float, float, float, float]:
    """PWM frequency, total loss, ripple of the load, drive power, spool friction."""
    if state.reason is not None:
        return (np.nan,) * 5
    s = state.summary
    motor = float(s["spool_motor_power_W"])
    loss = float(s["input_power_W"]) + max(motor, 0.0) - float(s["load_power_W"])
    swing = float(s["pressure_max_load_line_Pa"]) - float(s["pressure_min_load_line_Pa"])
    return float(s["pwm_frequency_Hz"]), loss, swing, motor, float(s["loss_spool_friction_W"])


def best_frequency(
    frequencies: Array, loss: Array, swing: Array, drive: Array, limit: float
) -> tuple[float, float, float]:
    """The PWM frequency [Hz] that loses least with a ripple within `limit`, the loss [W] and drive power [W] there.

    Between the given frequencies losses go in straight lines and the ripple with a power. nan where none is within.

    Source  ours, docs/rigs.md
    """
    known = np.isfinite(loss) & np.isfinite(swing)
    if np.count_nonzero(known) < 2:
        return np.nan, np.nan, np.nan
    f = np.geomspace(frequencies[known][0], frequencies[known][-1], 2001)
    swings = np.exp(np.interp(np.log(f), np.log(frequencies[known]), np.log(swing[known])))
    losses = np.interp(f, frequencies[known], loss[known])
    allowed = np.where(swings <= limit, losses, np.inf)
    if not np.isfinite(allowed).any():
        return np.nan, np.nan, np.nan
    place = int(np.argmin(allowed))
    return float(f[place]), float(losses[place]), float(np.interp(f[place], frequencies[known], drive[known]))


def annular_stroke(valve: RotaryValve) -> float:
    """Stroke of a linear spool of the same diameter that opens the same area all round, to one side and the other [m].

    2 A_in / (2 pi R): the shortest that there can be.

    Source  ours, docs/rigs.md
    """
    return valve.nozzle_area / (np.pi * valve.spool_radius)


def same_ports_stroke(valve: RotaryValve) -> float:
    """Stroke with which a barrier of the same lap opens the same nozzles axially, from side to side [m].

    (1 + lap) d_a

    Source  ours, docs/rigs.md
    """
    return (1.0 + valve.lap_ratio) * nozzle_length(valve)


def area_scale(flow: float, wanted: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Factor on all nozzle and outlet areas with which the open valve spins itself at a wanted PWM frequency [1].

    The turbines' torque goes with one over the areas, friction and swirl do not know them: f / f_wanted.

    flow       [m^3/s]
    wanted     PWM frequency [Hz]
    density    [kg/m^3]
    viscosity  dynamic [Pa s]

    Source  wang2017, eqs. 2.6, 2.7 and 2.9 in balance
    """
    return pwm_frequency(equilibrium_speed(flow, density, viscosity, valve), valve) / wanted


def scaled_open_loss(scale: float, flow: float, density: float, valve: RotaryValve) -> float:
    """Power throttled by the open valve with all its nozzle and outlet areas scaled [W].

    flow     [m^3/s]
    density  [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5
    """
    drops = full_open_drop(flow, density, valve)
    return flow * ((drops.nozzle + drops.outlet_turbine) / (scale * scale) + drops.centre_section)


def claims(
    stand: Stand,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> RigResult:
    """All claims for one system; those that need a load line are left out, and said to be, where there is none.
    So is a driven spool beside a self-spinning one where the flow cannot turn it.

    Ctrl-C leaves out those that are not yet worked out; before the first of them is, it is raised. Raises
    ParameterError where the spool does not turn.

    Source  wang2017, chapters 1, 2 and 5
    """
    if stuck := stand.standstill(stand.set_point.oil_temperature, stand.means(stand.set_point)):
        raise ParameterError(f"{stand.name}: {stuck}")
    began = time.perf_counter()
    say("against throttling")
    throttled = against_throttling(stand, cores=cores, cache=cache, say=say)
    sheets = {"throttling": Sheet("PWM valve and throttling", _throttling_columns(throttled))}
    numbers, findings = _throttling_words(throttled)
    left_out = [
        "Pump and motor losses beyond the parameters, the same for both ways of control.",
        "What the throttling valve itself adds: its lowest drop and its actuation.",
        "Stiction, flow forces and springs of the linear valve; energy put into its braking is not recovered.",
        "Seals and bearings of a driven spool's shaft, and the efficiency of its motor.",
    ]
    finished = True
    if stand.makes_pressure:
        alone, largest = self_spinning(stand), driving_point(stand, stand.pump_flow(stand.set_point))
        if stuck := alone.standstill(largest.oil_temperature, alone.means(largest)):
            left_out.append(f"Self-spinning against driven: left to itself {stuck}.")
        try:
            if not stuck:
                say("self-spinning against driven")
                driving = self_against_driven(stand, cores=cores, cache=cache, say=say)
                sheets |= {
                    "driving": Sheet("Spool driven by a motor", _driving_columns(driving)),
                    "best": Sheet("Self-spinning, and driven at the best frequency", _best_columns(stand, driving)),
                }
                more, words = _driving_words(stand, driving)
                numbers, findings = numbers | more, findings + words
            say("ripple")
            here = [stand.set_point.duty_ratio]
            try:
                waves = ripple(stand, here, RIPPLE_FREQUENCIES, RIPPLE_SIZES, cores=cores, cache=cache)
            except ParameterError as problem:
                left_out.append(f"Ripple: {problem}.")
            else:
                sheets |= {
                    "ripple_frequency": replace(waves.sheets["frequency"], title="Ripple over PWM frequency"),
                    "ripple_volume": replace(waves.sheets["accumulator"], title="Ripple over gas volume"),
                }
                more, words = _ripple_words(stand, sheets)
                numbers, findings = numbers | more, findings + words
        except KeyboardInterrupt:
            finished = False
            missing = "Ripple" if stuck or "driving" in sheets else "Self-spinning against driven, and ripple"
            left_out.append(f"{missing}: interrupted before.")
    else:
        left_out.append(
            "Self-spinning against driven, and ripple: both need a load line, and here a source is the load."
        )
    sheets["actuation"] = Sheet("Actuation power", _actuation_columns(stand))
    more, words = _actuation_words(stand)
    numbers, findings = numbers | more, findings + words
    point, valve = stand.set_point, stand.bench.valve
    said = conditions(stand) | {
        "duty ratio": f"{point.duty_ratio:.4g} unless varied",
        "load pressure": f"{gauge(point.load_pressure)} bar unless varied",
        "linear valves": f"{valve.spool_mass:g} kg moved by {1e3 * same_ports_stroke(valve):.3g} mm, and "
        f"{LIGHT_MASS:g} kg by {1e3 * annular_stroke(valve):.3g} mm, in {100.0 * transition_fraction(valve):.3g} % of "
        "a period (assumed)",
    }
    return RigResult(
        rig="claims",
        title="What is claimed of the rotary PWM valve",
        system=stand.name,
        manner="Claims of chapters 1, 2 and 5 of the source, each worked out for this system: losses and ripple from "
        "periodic steady states of the PWM-resolved circuit, actuation powers in closed form.",
        references=("wang2017", "tu2011"),
        conditions=said,
        left_out=tuple(left_out),
        sheets=sheets,
        numbers=numbers,
        findings=tuple(findings),
        seconds=time.perf_counter() - began,
        finished=finished,
    )


def _throttling_columns(t: Throttling) -> dict[str, Column]:
    return {
        "load_pressure_Pa": Column(t.load_pressure, "Pa gauge", "load pressure"),
        "duty_ratio": Column(t.duty_ratio, "", "duty ratio"),
        "delivered_flow_m3_s": Column(t.delivered, "m^3/s", "delivered flow"),
        "delivered_share": Column(t.share, "", "over pump flow"),
        "loss_switched_W": Column(t.switched, "W", "loss, PWM valve"),
        "loss_metered_W": Column(t.metered, "W", "loss, metered at relief setting"),
        "loss_bled_off_W": Column(t.bled_off, "W", "loss, bled off at load pressure"),
    }


def break_even_share(share: Array, switched: Array, throttled: Array) -> float:
    """Delivered share above which the PWM valve loses more than throttling [1]; nan where it never does.

    By straight lines between rows; 0 where it always loses more.
    """
    gain = throttled - switched
    if gain[-1] >= 0.0:
        return np.nan
    better = np.flatnonzero(gain > 0.0)
    if not better.size:
        return 0.0
    k = int(better[-1])
    return float(share[k] + (share[k + 1] - share[k]) * gain[k] / (gain[k] - gain[k + 1]))


def _throttling_words(t: Throttling) -> tuple[dict[str, float], list[str]]:
    numbers = {
        "least_saving_over_metering": float(np.min(1.0 - t.switched / t.metered)),
        "largest_saving_over_metering": float(np.max(1.0 - t.switched / t.metered)),
    }
    words = [
        f"Against metering at the relief setting the PWM valve loses "
        f"{100.0 * numbers['least_saving_over_metering']:.0f} to "
        f"{100.0 * numbers['largest_saving_over_metering']:.0f} % less, over all points."
    ]
    for pressure in np.unique(t.load_pressure):
        rows = t.load_pressure == pressure
        even = break_even_share(t.share[rows], t.switched[rows], t.bled_off[rows])
        level = round(pressure / 1e5)
        numbers[f"break_even_share_at_{level}_bar"] = even
        if even == 0.0:
            words.append(f"At {level} bar it loses more than bleeding off at load pressure would, at every flow.")
        elif np.isfinite(even):
            words.append(
                f"At {level} bar it loses less than bleeding off at load pressure up to {100.0 * even:.0f} % of the "
                "pump flow, more above."
            )
        else:
            words.append(f"At {level} bar it loses less than bleeding off at load pressure at every flow.")
    return numbers, words


def _driving_columns(d: Driving) -> dict[str, Column]:
    count = d.frequencies.size
    return {
        "pump_flow_m3_s": Column(np.repeat(d.flows, count), "m^3/s", "pump flow"),
        "pwm_frequency_Hz": Column(np.tile(d.frequencies, d.flows.size), "Hz", "PWM frequency"),
        "drive_power_W": Column(d.drive_power.ravel(), "W", "drive power"),
        "friction_power_W": Column(d.friction_power.ravel(), "W", "spool friction"),
        "loss_total_W": Column(d.loss.ravel(), "W", "total loss"),
        "load_ripple_Pa": Column(d.ripple.ravel(), "Pa", "load, peak to peak"),
    }


def redesigned(stand: Stand, d: Driving) -> tuple[float, Array, Array]:
    """A self-spinning valve that keeps the ripple limit from the lowest flow on, and what its drop costs.

    Factor on its areas, and the open valve's loss at every flow, as it is and with scaled areas [W]. nan where no
    frequency keeps the limit.
    """
    here, valve = stand.set_point, stand.bench.valve
    rho = float(density(here.oil_temperature, stand.bench.oil))
    mu = float(dynamic_viscosity(here.oil_temperature, stand.bench.oil))
    scale = float(area_scale(float(d.flows[0]), float(d.best_frequency[0]), rho, mu, valve))
    losses = [(scaled_open_loss(1.0, q, rho, valve), scaled_open_loss(scale, q, rho, valve)) for q in d.flows.tolist()]
    as_it_is, scaled = np.array(losses).T
    return scale, as_it_is, scaled


def _best_columns(stand: Stand, d: Driving) -> dict[str, Column]:
    _, as_it_is, scaled = redesigned(stand, d)
    return {
        "pump_flow_m3_s": Column(d.flows, "m^3/s", "pump flow"),
        "self_pwm_frequency_Hz": Column(d.self_frequency, "Hz", "PWM frequency, self-spinning"),
        "self_loss_W": Column(d.self_loss, "W", "loss, self-spinning"),
        "self_ripple_Pa": Column(d.self_ripple, "Pa", "ripple, self-spinning"),
        "best_pwm_frequency_Hz": Column(d.best_frequency, "Hz", "best PWM frequency, driven"),
        "best_loss_W": Column(d.best_loss, "W", "loss, driven"),
        "best_drive_power_W": Column(d.best_drive_power, "W", "drive power"),
        "open_loss_W": Column(as_it_is, "W", "loss of the open valve"),
        "open_loss_redesigned_W": Column(scaled, "W", "the same, areas for self-spinning at the lowest flow"),
    }


def _driving_words(stand: Stand, d: Driving) -> tuple[dict[str, float], list[str]]:
    known = np.isfinite(d.self_frequency)
    numbers = {
        "ripple_limit_Pa": d.limit,
        "self_frequency_exponent": power_of(d.flows, d.self_frequency),
    }
    if not known.any():
        return numbers, ["Left to itself the spool has no steady state at any of these flows."]
    words = [
        f"Left to itself the spool switches at {d.self_frequency[known][0]:.3g} Hz with "
        f"{d.flows[known][0] / LPM:.3g} lpm and at {d.self_frequency[known][-1]:.3g} Hz with "
        f"{d.flows[known][-1] / LPM:.3g} lpm, with the flow to the power {numbers['self_frequency_exponent']:.2g}; the "
        f"load's ripple then goes from {d.self_ripple[known][0] / 1e5:.3g} to {d.self_ripple[known][-1] / 1e5:.3g} bar."
    ]
    if np.isfinite(d.best_frequency).any():
        found = np.flatnonzero(np.isfinite(d.best_frequency))
        first, last = int(found[0]), int(found[-1])
        numbers["largest_drive_power_W"] = float(np.nanmax(d.best_drive_power))
        words.append(
            f"Within a ripple of {d.limit / 1e5:.3g} bar a driven spool loses least at {d.best_frequency[first]:.3g} "
            f"Hz with {d.flows[first] / LPM:.3g} lpm and at {d.best_frequency[last]:.3g} Hz with "
            f"{d.flows[last] / LPM:.3g} lpm; that takes at most {max(numbers['largest_drive_power_W'], 0.0):.3g} W of "
            "drive power."
        )
        scale, as_it_is, scaled = redesigned(stand, d)
        if np.isfinite(scale):
            numbers["self_spinning_area_scale"] = scale
            words.append(
                f"To switch as fast at {d.flows[0] / LPM:.3g} lpm by itself the spool would need {100.0 * scale:.0f} % "
                f"of its areas; open, the valve would then lose {scaled[-1]:.4g} W instead of {as_it_is[-1]:.4g} W at "
                f"{d.flows[-1] / LPM:.3g} lpm."
            )
    return numbers, words


def _actuation_columns(stand: Stand) -> dict[str, Column]:
    f: Any = np.array(ACTUATION_FREQUENCIES)
    valve = stand.bench.valve
    kappa = transition_fraction(valve)
    rotary: Any = rotary_actuation_power(f, valve.sections, spool_friction(stand))
    same: Any = linear_actuation_power(f, valve.spool_mass, same_ports_stroke(valve), kappa)
    light: Any = linear_actuation_power(f, LIGHT_MASS, annular_stroke(valve), kappa)
    return {
        "pwm_frequency_Hz": Column(f, "Hz", "PWM frequency"),
        "rotary_power_W": Column(rotary, "W", "rotary spool"),
        "linear_same_power_W": Column(same, "W", "linear, same spool and ports"),
        "linear_light_power_W": Column(light, "W", "linear, light spool, annular port"),
    }


def spool_friction(stand: Stand) -> float:
    """Torque over speed of the spool's viscous friction at the stand's temperature [N m s]."""
    viscosity = float(dynamic_viscosity(stand.set_point.oil_temperature, stand.bench.oil))
    return friction_coefficient(viscosity, stand.bench.valve)


def _actuation_words(stand: Stand) -> tuple[dict[str, float], list[str]]:
    columns = _actuation_columns(stand)
    f, rotary, same = (
        np.asarray(columns[name].values, float)
        for name in ("pwm_frequency_Hz", "rotary_power_W", "linear_same_power_W")
    )
    valve, friction = stand.bench.valve, spool_friction(stand)
    kappa = transition_fraction(valve)
    even = [
        float(equal_power_frequency(valve.sections, friction, mass, stroke, kappa))
        for mass, stroke in ((valve.spool_mass, same_ports_stroke(valve)), (LIGHT_MASS, annular_stroke(valve)))
    ]
    numbers = {
        "rotary_power_exponent": power_of(f, rotary),
        "linear_power_exponent": power_of(f, same),
        "equal_power_same_spool_Hz": even[0],
        "equal_power_light_spool_Hz": even[1],
    }
    words = [
        "The actuation power of the rotary spool goes with the PWM frequency to the power "
        f"{numbers['rotary_power_exponent']:.3g}, that of a linear one to the power "
        f"{numbers['linear_power_exponent']:.3g}. Where they meet is a matter of mass and stroke: the same spool moved "
        f"to and fro past the same nozzles takes more from {even[0]:.3g} Hz on, a light one with a port all round only "
        f"from {even[1]:.4g} Hz on."
    ]
    return numbers, words


def _ripple_words(stand: Stand, sheets: dict[str, Sheet]) -> tuple[dict[str, float], list[str]]:
    f, v = sheets["ripple_frequency"], sheets["ripple_volume"]
    pressure = stand.set_point.load_pressure
    share = 1.0 - line_capacity(pressure, with_gas(stand, 0.0)) / line_capacity(pressure, with_gas(stand, 1.0))
    numbers = {
        "ripple_frequency_exponent": power_of(f["pwm_frequency_Hz"], f["load_ripple_Pa"]),
        "ripple_gas_volume_exponent": power_of(v["gas_volume_m3"], v["load_ripple_Pa"]),
        "gas_share_of_line_capacity": float(share),
    }
    words = [
        f"The ripple goes with the PWM frequency to the power {numbers['ripple_frequency_exponent']:.3g} and with the "
        f"gas volume to the power {numbers['ripple_gas_volume_exponent']:.3g}; the gas is {100.0 * share:.0f} % of "
        "what the line takes in."
    ]
    return numbers, words
