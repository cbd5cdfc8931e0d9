"""Up to where the laws of a test rig of the rotary valve hold, and which of its numbers mean something."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import DUTY_RATIO, MEAN_POWER, NUMBER, RATIO, TEMPERATURE_DIFFERENCE
from vvdp.evaluation.bench_values import BenchValues
from vvdp.evaluation.load_ripple import estimated_ripple, vessel_capacity
from vvdp.fluid.mixture import mean_bulk_modulus
from vvdp.fluid.oil import Oil, density, dynamic_viscosity
from vvdp.systems.bound import Bound
from vvdp.systems.spool_travel import duty_travel
from vvdp.valve.gap_flow import sheared_temperature_rise, taylor_number
from vvdp.valve.geometry import barrier_width
from vvdp.valve.losses import compression_regime
from vvdp.valve.operating_point import nozzle_reynolds_number
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.validity import (
    CURVATURE,
    ECCENTRICITY,
    LAMINAR,
    SHEAR_WARMING,
    SLOT_LENGTH,
    TAYLOR_NUMBER,
    WAVE_TRANSITS,
    wave_transits,
)

STORED = 0.02
"""Stored power, over the input power, above which there is no efficiency: given to the load instead, or saved at the
input, it would change the efficiency by as much."""
DUST = 1e-6
"""Share of the input power by which an efficiency may miss 0 and 1, and a loss 0: the limit of the balances."""
FILLING = 0.5
"""Time to fill the inlet, over that in which a port opens, from which on the analytic losses and frequency are a tenth
off those of the simulation."""
RIPPLE = 0.2
"""Amplitude of the pump's flow, over its mean, up to which that moves losses and frequency by less than 3 %."""
LOAD_SWING = 0.3
"""Swing of the load pressure within a period, over its mean, from which on it moves the frequency by a tenth."""
FREE_AIR = 0.03
"""Free air from which on counting volumes instead of masses puts the analytic losses a tenth off."""
STOP_ROOM = 0.05
"""Share of the helix length by which a spool may go beyond the ends of the duty ratio, to its stops: 1 mm here."""
HEAT_CONDUCTION = 0.13
"""Thermal conductivity of mineral oil [W/(m K)]."""


class ValveReading(NamedTuple):
    """Arguments at which a run used the laws of a rotary valve.

    temperature     of the oil at the start [K]
    flow            mean, that comes to it [m^3/s]
    pwm_frequency   mean [Hz]
    inlet_pressure  mean, absolute [Pa]
    fastest         largest speed of its spool either way [rad/s]
    """

    valve: RotaryValve
    oil: Oil
    temperature: float
    flow: float
    pwm_frequency: float
    inlet_pressure: float
    fastest: float


def efficiency(load_power: float, put_in: float, stored: float) -> float:
    """Load power over the input power [1]; nan where that means nothing, `efficiency_doubt` says why.

    load_power, put_in  means [W]
    stored              what the input power has left in the circuit, mean [W]
    """
    if efficiency_doubt(load_power, put_in, stored):
        return float("nan")
    return min(max(load_power / put_in, 0.0), 1.0) + 0.0  # no -0


def efficiency_doubt(load_power: float, put_in: float, stored: float) -> str:
    """Why there is no efficiency; empty where there is one. Arguments as those of `efficiency`."""
    if not put_in > 0.0:
        return f"the input power is {with_unit(put_in, MEAN_POWER)}"
    if abs(stored) > STORED * put_in:
        moved = "was stored" if stored > 0.0 else "came from stored energy"
        share = abs(stored) / put_in
        much = f"{percent(share)} of" if share < 1.0 else f"{share:.3g} times"
        return f"{with_unit(abs(stored), MEAN_POWER)}, {much} the input power, {moved} while means were taken"
    if not -DUST * put_in <= load_power <= (1.0 + DUST) * put_in:
        return f"{with_unit(load_power, MEAN_POWER)} reach the load of {with_unit(put_in, MEAN_POWER)} put in"
    return ""


def transition_loss(beyond_open: float, put_in: float) -> float:
    """Loss beyond that of the fully open valve [W]; nan where it is negative, as a loss cannot be.

    Where the barriers are far narrower than the nozzles, both ports share the flow, and it drops less than in one open
    port: then there is no fully open valve to compare with.

    beyond_open  [W]
    put_in       [W]
    """
    return beyond_open if beyond_open >= -DUST * abs(put_in) else float("nan")


def bench_bounds(bench: BenchValues, found: Mapping[str, float]) -> Iterator[Bound]:
    """The bounds of the laws of valve and spool at what a run has `found`."""
    where = f" (operation.{'axial_position' if bench.is_placed else 'duty_ratio'})"
    yield duty_bound("duty ratio", *bench.duty_ratio.extremes, bench.valve, where)
    yield from valve_bounds(_bench_reading(bench, found))


def duty_bound(label: str, low: float, high: float, valve: RotaryValve, where: str = "") -> Bound:
    """The bound of the lowest and highest duty ratio [1] of a valve, and `where` the file gives it."""
    travel, length = duty_travel(valve), valve.helix_length
    return _bound(
        label,
        high,
        f"the spool stands beyond the helix{where}",
        low=low,
        least=travel.low / length - STOP_ROOM,
        most=travel.high / length + STOP_ROOM,
        kind=DUTY_RATIO,
    )


def _bench_reading(bench: BenchValues, found: Mapping[str, float]) -> ValveReading:
    return ValveReading(
        valve=bench.valve,
        oil=bench.oil,
        temperature=bench.temperature,
        flow=float(found["mean_pump_flow_m3_s"]),
        pwm_frequency=float(found["pwm_frequency_Hz"]),
        inlet_pressure=float(found["pressure_mean_inlet_Pa"]) + bench.reference,
        fastest=max(abs(float(found[f"speed_{end}_spool_rad_s"])) for end in ("min", "max")),
    )


def valve_bounds(reading: ValveReading, name: str = "") -> Iterator[Bound]:
    """The bounds of the laws of a rotary valve and its spool; with a `name` where there may be several."""
    rho, mu = (law(reading.temperature, reading.oil) for law in (density, dynamic_viscosity))
    of = f" of {name}" if name else ""
    yield from _flow_bounds(reading, rho, mu, of)
    yield from _clearance_bounds(reading.valve, of)
    yield _bound(
        f"Taylor number of the clearance{of}",
        taylor_number(reading.fastest, rho, mu, reading.valve),
        "vortices brake the spool more than the linear law of friction",
        most=TAYLOR_NUMBER,
    )
    yield _bound(
        f"warming of the film{of} by its shear",
        sheared_temperature_rise(reading.fastest, mu, HEAT_CONDUCTION, reading.valve),
        "friction is less than that of oil at its temperature",
        most=SHEAR_WARMING,
        kind=TEMPERATURE_DIFFERENCE,
    )


def _flow_bounds(reading: ValveReading, rho: float, mu: float, of: str) -> Iterator[Bound]:
    """Of the nozzles where oil flows, and of the volumes where the valve switches."""
    frequency = abs(reading.pwm_frequency)
    if reading.flow > 0.0:
        reynolds = float(nozzle_reynolds_number(reading.flow, rho, mu, reading.valve))
        yield _bound(
            f"Reynolds number of the nozzles{of}",
            reynolds,
            "the drop of their flow is no longer quadratic",
            least=LAMINAR,
        )
    if frequency > 0.0:
        yield _bound(
            f"pressure waves across the valve{of} during a transition",
            wave_transits(frequency, reading.inlet_pressure, rho, reading.oil, reading.valve),
            f"at {frequency:.4g} Hz its oil is not under one pressure",
            least=WAVE_TRANSITS,
        )


def _clearance_bounds(valve: RotaryValve, of: str) -> Iterator[Bound]:
    yield _bound(
        f"clearance over radius{of}",
        valve.radial_clearance / valve.spool_radius,
        "leakage and friction are those of a thin film",
        most=CURVATURE,
        kind=RATIO,
    )
    yield _bound(
        f"breadth of the barriers{of} over the clearance",
        barrier_width(valve) / valve.radial_clearance,
        "the leakage past them is that of a long slot",
        least=SLOT_LENGTH,
        kind=RATIO,
    )
    yield _bound(f"eccentricity of the spool{of}", valve.eccentricity, "it touches the sleeve", most=ECCENTRICITY)


def _bound(label: str, value: float, otherwise: str, **ends: Any) -> Bound:
    """A bound of a number that is one value, or goes up to it."""
    given: dict[str, Any] = {"low": value, "high": value, "kind": NUMBER} | ends
    return Bound(label=label, otherwise=otherwise, **given)


def switching_limits(bench: BenchValues, found: Mapping[str, float]) -> Iterator[str]:
    """Effects of switching, pump and air in a run that no quasi-steady average contains, a sentence each."""
    if found["averaged_periods"] < 1:
        yield "the valve does not switch"
    elif (share := filling_share(bench, found)) > FILLING:
        yield (
            f"the inlet volume takes {share:.3g} times as long to fill as a port to open, above {FILLING:g}: its "
            "pressure lags behind the ports, which is in no quasi-steady average"
        )
    if (swing := load_swing(bench, found)) > LOAD_SWING:
        yield (
            f"the load line is so stiff that its pressure swings by about {percent(swing)} within a period, above "
            f"{percent(LOAD_SWING)}, where quasi-steady averages take it as constant"
        )
    if bench.ripple_amplitude > RIPPLE:
        yield f"the pump's flow pulsates by {percent(bench.ripple_amplitude)}, which is in no quasi-steady average"
    if bench.oil.air_fraction > FREE_AIR:
        air = percent(bench.oil.air_fraction)
        yield f"the oil has {air} of free air, whose compression is in no quasi-steady average"


def load_swing(bench: BenchValues, found: Mapping[str, float]) -> float:
    """Estimated swing of the load pressure within a period, over its mean above the tank's [1]; 0 against a source."""
    pressure = float(found["pressure_mean_load_line_Pa"]) + bench.reference
    delivered, frequency = float(found["mean_load_flow_m3_s"]), float(found["pwm_frequency_Hz"])
    if bench.load_line is None or not (delivered > 0.0 and frequency > 0.0 and pressure > bench.tank_pressure):
        return 0.0
    capacity = vessel_capacity(pressure, bench.load_line, bench.oil)
    swing = estimated_ripple(delivered, float(found["mean_pump_flow_m3_s"]), frequency, capacity)
    return swing / (pressure - bench.tank_pressure)


def filling_share(bench: BenchValues, found: Mapping[str, float]) -> float:
    """Time that filling the inlet up to the load takes over the time in which a port opens, of a run [1]."""
    pressure = float(found["pressure_mean_load_line_Pa"]) + bench.reference
    return compression_regime(
        abs(float(found["pwm_frequency_Hz"])),
        bench.inlet_volume,
        pressure - bench.tank_pressure,
        mean_bulk_modulus(pressure, bench.oil),
        float(found["mean_pump_flow_m3_s"]),
        bench.valve,
    )


def bench_warnings(bench: BenchValues, found: Mapping[str, float], limits: Iterable[str]) -> Iterator[str]:
    """Warnings to read before the numbers of a bench, in sentences: what they leave out, what the motor takes.

    limits  why the closed forms do not describe the run, a sentence each
    """
    if found["averaged_periods"] < 1:
        yield "no whole PWM period lies in the averaging window: the means are over plain time"
    put_in = found["input_power_W"] + found["spool_motor_power_W"]
    if doubt := efficiency_doubt(found["load_power_W"], put_in, found["stored_power_W"]):
        yield f"no efficiency: {doubt}"
    if found["loss_transition_W"] != found["loss_transition_W"]:
        yield "no transition loss: the valve loss is below that of one fully open port"
    if found["motor_overloaded"]:
        power, rated = found["input_power_W"], found["motor_rated_power_W"]
        yield f"the input power of {power:.4g} W exceeds the motor's {rated:.4g} W"
    for limit in limits:
        yield f"no analytic results: {limit}"
