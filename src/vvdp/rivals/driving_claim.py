"""Claim: where the flow varies, a spool that a motor turns does better than one that the flow spins."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, plain, with_unit
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import FLOW, FREQUENCY, MEAN_POWER, NUMBER, PRESSURE_DIFFERENCE, RATIO
from vvdp.fluid.oil import density
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Table, numbers_of, sentences
from vvdp.results.verdict import Statement, bound_statement
from vvdp.rigs.map_charts import chosen_places
from vvdp.rigs.ripple import power_of
from vvdp.rivals.claim import Claim
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import SetPoint, Stand
from vvdp.valve.losses import full_open_drop
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import equilibrium_speed, pwm_frequency

FLOW_SHARES = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Pump flows of the comparison, over that of the system."""
FREQUENCIES = (5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0)
DRIVEN_SHARE = 0.6
"""Load pressure of the comparison, over the relief setting: ripple must not reach the relief valve."""
QUANTITIES = {
    "ripple_limit_Pa": (PRESSURE_DIFFERENCE, "ripple that a driven spool may have"),
    "self_frequency_exponent": (NUMBER, "exponent of the flow in the PWM frequency of a self-spinning spool"),
    "largest_drive_power_W": (MEAN_POWER, "largest power of the spool's motor at the best frequencies"),
    "self_spinning_area_scale": (RATIO, "factor on the areas of a self-spinning valve with the same ripple"),
}


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
    return stand.with_tables(spool_drive={"coupling": 0.0})


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
    stands += [(stand.with_motor(float(f)), point) for point in at for f in frequencies]
    states = steady_states(stands, cores=cores, say=say)
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


def redesign(stand: Stand, d: Driving) -> tuple[float, Array, Array]:
    """A self-spinning valve that keeps the ripple limit from the lowest flow on, and what its drop costs.

    Factor on its areas, and the open valve's loss at every flow, as it is and with scaled areas [W]. nan where no
    frequency keeps the limit.
    """
    here, valve = stand.set_point, stand.bench.valve
    rho = float(density(here.oil_temperature, stand.bench.oil))
    mu = float(stand.film_viscosity(here))
    scale = float(area_scale(float(d.flows[0]), float(d.best_frequency[0]), rho, mu, valve))
    as_it_is, scaled = (
        np.array([scaled_open_loss(factor, q, rho, valve) for q in d.flows.tolist()]) for factor in (1.0, scale)
    )
    return scale, as_it_is, scaled


def driving_claim(stand: Stand, *, cores: int | None = None, say: Callable[[str], None] = quiet) -> Claim:
    """A self-spinning spool beside a driven one over flow, and what a self-spinning valve would cost."""
    found = self_against_driven(stand, cores=cores, say=say)
    numbers = {"ripple_limit_Pa": found.limit, "self_frequency_exponent": power_of(found.flows, found.self_frequency)}
    scale, as_it_is, scaled = redesign(stand, found)
    if np.isfinite(found.self_frequency).any() and np.isfinite(found.best_frequency).any():
        numbers["largest_drive_power_W"] = float(np.nanmax(found.best_drive_power))
        if np.isfinite(scale):
            numbers["self_spinning_area_scale"] = scale
    return Claim(
        tables={
            "driving": Table(title="Spool driven by a motor", columns=_driven_columns(found)),
            "best": Table(
                title="Self-spinning, and driven at the best frequency", columns=_best_columns(found, as_it_is, scaled)
            ),
        },
        charts=(_chart(found),),
        numbers=numbers_of(numbers, QUANTITIES),
        findings=tuple(sentences(list(_words(found, numbers, as_it_is, scaled)))),
        statements=tuple(("section-1.4", each) for each in _statements(found, as_it_is, scaled)),
    )


def _statements(d: Driving, as_it_is: Array, scaled: Array) -> Iterator[Statement]:
    """Statements of the source on a driven spool: for this valve, and for one that keeps the same ripple by itself."""
    source = "where the flow varies, driving the spool is more efficient"
    same, kept = d.self_loss / d.best_loss, float(scaled[-1] / as_it_is[-1])
    if np.isfinite(same).any():
        yield bound_statement(
            "loss of the self-spinning spool over that of the driven one, mean over the flows",
            float(np.nanmean(same)),
            RATIO,
            low=1.0,
            source=source,
            other=kept if np.isfinite(kept) else None,
            assumption="one and the same valve; in the second run one that keeps the ripple by itself",
        )
    if np.isfinite(scaled).all():
        yield bound_statement(
            "loss of an open valve that keeps the ripple by itself over that of this one",
            kept,
            RATIO,
            low=1.0,
            source=source,
            other=float(np.nanmean(same)) if np.isfinite(same).any() else None,
            assumption="the same ripple from a quarter of the flow on; in the second run one and the same valve",
        )


def _driven_columns(d: Driving) -> dict[str, Column]:
    count = d.frequencies.size
    return {
        "pump_flow_m3_s": Column(np.repeat(d.flows, count), FLOW, "pump flow"),
        "pwm_frequency_Hz": Column(np.tile(d.frequencies, d.flows.size), FREQUENCY, "PWM frequency"),
        "drive_power_W": Column(d.drive_power.ravel(), MEAN_POWER, "drive power"),
        "friction_power_W": Column(d.friction_power.ravel(), MEAN_POWER, "spool friction"),
        "loss_total_W": Column(d.loss.ravel(), MEAN_POWER, "total loss"),
        "load_ripple_Pa": Column(d.ripple.ravel(), PRESSURE_DIFFERENCE, "load, peak to peak"),
    }


def _best_columns(d: Driving, as_it_is: Array, scaled: Array) -> dict[str, Column]:
    return {
        "pump_flow_m3_s": Column(d.flows, FLOW, "pump flow"),
        "self_pwm_frequency_Hz": Column(d.self_frequency, FREQUENCY, "PWM frequency, self-spinning"),
        "self_loss_W": Column(d.self_loss, MEAN_POWER, "loss, self-spinning"),
        "self_ripple_Pa": Column(d.self_ripple, PRESSURE_DIFFERENCE, "ripple, self-spinning"),
        "best_pwm_frequency_Hz": Column(d.best_frequency, FREQUENCY, "best PWM frequency, driven"),
        "best_loss_W": Column(d.best_loss, MEAN_POWER, "loss, driven"),
        "best_drive_power_W": Column(d.best_drive_power, MEAN_POWER, "drive power"),
        "open_loss_W": Column(as_it_is, MEAN_POWER, "loss of the open valve"),
        "open_loss_redesigned_W": Column(
            scaled, MEAN_POWER, "loss of the open valve with areas for self-spinning at the lowest flow"
        ),
    }


def _words(d: Driving, numbers: dict[str, float], as_it_is: Array, scaled: Array) -> Iterator[str]:
    known = np.flatnonzero(np.isfinite(d.self_frequency))
    if not known.size:
        yield "Left to itself the spool has no steady state at any of these flows."
        return
    first, last = (
        f"{with_unit(d.self_frequency[row], FREQUENCY, 3)} with {with_unit(d.flows[row], FLOW, 3)}"
        for row in (known[0], known[-1])
    )
    swings = [with_unit(d.self_ripple[row], PRESSURE_DIFFERENCE, 3) for row in (known[0], known[-1])]
    yield (
        f"Left to itself the spool switches at {first} and at {last}, with the flow to the power "
        f"{number(numbers['self_frequency_exponent'], 2)}; the load's ripple then goes from {swings[0]} to {swings[1]}."
    )
    if "largest_drive_power_W" not in numbers:
        return
    best = np.flatnonzero(np.isfinite(d.best_frequency))
    first, last = (
        f"{with_unit(d.best_frequency[row], FREQUENCY, 3)} with {with_unit(d.flows[row], FLOW, 3)}"
        for row in (best[0], best[-1])
    )
    power = with_unit(max(numbers["largest_drive_power_W"], 0.0), MEAN_POWER, 3)
    yield (
        f"Within a ripple of {with_unit(d.limit, PRESSURE_DIFFERENCE, 3)} a driven spool loses least at {first} and at "
        f"{last}; that takes at most {power} of drive power."
    )
    if "self_spinning_area_scale" in numbers:
        lowest, highest = (with_unit(d.flows[row], FLOW, 3) for row in (0, -1))
        yield (
            f"To switch as fast at {lowest} by itself the spool would need "
            f"{percent(numbers['self_spinning_area_scale'], 0)} of its areas; open, the valve would then lose "
            f"{with_unit(scaled[-1], MEAN_POWER)} instead of {with_unit(as_it_is[-1], MEAN_POWER)} at {highest}."
        )


def _chart(d: Driving) -> Chart:
    count = d.frequencies.size
    places = chosen_places(count, 5)
    speeds = (
        Line(x="pump_flow_m3_s", y=f"{name}_pwm_frequency_Hz", label=label, colour=colour, stroke=Stroke.MARKED)
        for name, label, colour in (
            ("self", "self-spinning", Colour.LOAD),
            ("best", "driven, best", Colour.INLET),
        )
    )
    powers = (
        Line(
            x="pump_flow_m3_s",
            y="drive_power_W",
            label=f"{plain(d.frequencies[place], 3)} Hz",
            rows=tuple(range(place, d.flows.size * count, count)),
            colour=colour,
        )
        for place, colour in zip(places, shades(len(places)), strict=True)
    )
    ripple = Line(x="pump_flow_m3_s", y="self_ripple_Pa", colour=Colour.LOAD, stroke=Stroke.MARKED)
    limit = (Level(value=d.limit, colour=Colour.INLET, stroke=Stroke.SOLID),) if np.isfinite(d.limit) else ()
    zero = Level(value=0.0, stroke=Stroke.SOLID)
    return Chart(
        name="driven-spool",
        caption="Left: PWM frequency of a self-spinning spool, and the best one of a driven spool whose load ripple is "
        "no larger than that of the self-spinning one at the largest flow. Middle: ripple. Right: power that drives "
        "the spool at fixed PWM frequencies; below zero the flow drives the motor.",
        table="best",
        panels=(
            Lines(lines=tuple(speeds), label="PWM frequency", low=0.0),
            Lines(lines=(ripple,), label="load, peak to peak", levels=limit, low=0.0),
            Lines(table="driving", lines=tuple(powers), label="drive power", levels=(zero,), legend="driven at"),
        ),
        side_by_side=True,
        height=2.7,
    )
