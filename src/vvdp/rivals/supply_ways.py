"""Losses of the PWM valve and its rivals on one pump's flow and pressure, with the spread of the assumed values.

The PWM valve by its quasi-steady averages, all others by `vvdp.hydraulics.supply_losses`.

Source  ours, docs/when-switching-pays.md
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.select import maximum, minimum
from vvdp.hydraulics.supply_losses import bled_off_loss, drag_power, load_sensing_loss, metered_loss
from vvdp.rigs.maps import averaged_columns
from vvdp.simulation.link import quiet
from vvdp.steady.averages import averages
from vvdp.steady.test_stand import SetPoint, Stand

DUTY_RATIOS = np.linspace(0.0, 1.0, 51)
VARIED = (
    "relief_valve.override_pressure",
    "valve.lap_ratio",
    "valve.helix_length",
    "valve.nozzle_discharge_coefficient",
    "valve.centre_coefficient",
    "valve.outlet_discharge_coefficient",
)
"""Values of the PWM valve and its relief valve that move its averaged loss, where the file gives them a range."""


class Assumed(NamedTuple):
    """Assumed values of the rivals, and of all pumps alike.

    `margin` of load sensing [Pa]; `heavier`, the load of another actuator at the same load-sensing pump over the relief
    setting; `leakage` of a variable pump over that of the fixed one; `drag`, torque of a pump that no oil takes over
    that of its full displacement.
    """

    margin: float = 20e5
    heavier: float = 0.8
    leakage: float = 1.0
    drag: float = 0.03


RANGES: Mapping[str, tuple[float, float]] = {
    "margin": (10e5, 30e5),
    "heavier": (0.5, 0.9),
    "leakage": (1.0, 2.0),
    "drag": (0.0, 0.06),
}
"""Between which ends each of them lies; all are assumed."""


class Demand(NamedTuple):
    """Demand of a load: arrays of one shape."""

    flow: Any  # [m^3/s]
    rise: Any  # over the tank [Pa]


@dataclass(frozen=True)
class Ways:
    """Losses [W] of the PWM valve and of each rival at a demand, by one set of what is assumed."""

    switched: Any
    rivals: Mapping[str, Array]


@dataclass(frozen=True)
class Spread:
    """The ways as they are, and for each rival by how many watts it loses more than the PWM valve: lowest, highest."""

    nominal: Ways
    lowest: Mapping[str, Array]
    highest: Mapping[str, Array]

    def gain(self, rival: str) -> Any:
        """Loss of a rival minus that of the PWM valve, with nothing varied [W]: an array."""
        return self.nominal.rivals[rival] - self.nominal.switched


RIVALS: Mapping[str, str] = {
    "metered": "metered at the relief setting",
    "bled_off": "bled off at load pressure",
    "load_sensing": "load sensing",
    "shared": "load sensing beside a heavier load",
    "compensated": "pressure-compensated pump",
    "displacement": "displacement control",
}
"""Name of each rival. A digital flow control unit is a throttle, and is counted as one."""


def rival_losses(demand: Demand, stand: Stand, assumed: Assumed) -> dict[str, Array]:
    """Loss of each rival at a demand [W], its pump's drag included; nan where it cannot hold the load.

    No pump goes beyond the relief setting, however large the margin.
    """
    flow, rise = demand
    pump, speed = stand.bench.pump, stand.set_point.pump_speed
    relief = stand.relief_pressure - stand.tank_pressure
    fixed = stand.pump_flow(stand.set_point)

    def drag(held: Any) -> Any:
        return drag_power(held, speed, pump.displacement, pump.friction_torque, assumed.drag)

    def variable(held: Any) -> Any:
        lost = load_sensing_loss(flow, rise, held, assumed.leakage * pump.leakage_conductance)
        return np.where(held >= rise, lost, np.nan) + drag(held)

    def pressure_of(load: Any) -> Any:
        return minimum(load + assumed.margin, maximum(relief, rise))

    setting = relief + 0.0 * rise
    return {
        "metered": metered_loss(fixed, flow, rise, setting) + drag(setting),
        "bled_off": bled_off_loss(fixed, flow, rise) + drag(rise),
        "load_sensing": variable(pressure_of(rise)),
        "shared": variable(pressure_of(maximum(assumed.heavier * relief, rise))),
        "compensated": variable(setting),
        "displacement": variable(rise),
    }


class Averaged(NamedTuple):
    """The PWM valve at a demand: hydraulic loss [W], and mean pressure at its pump over the tank [Pa]."""

    loss: Any
    inlet_rise: Any


def averaged_valve(
    demand: Demand,
    stand: Stand,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Averaged:
    """The PWM valve at a demand by its quasi-steady averages: nan where it does not reach it, or does not turn.

    Between the duty ratios it is interpolated. What compressing the oil of the inlet costs is in it.
    """
    levels, place = np.unique(demand.rise, return_inverse=True)
    grid: Any = np.meshgrid(DUTY_RATIOS, levels + stand.tank_pressure)
    d, p = (each.ravel() for each in grid)
    here = stand.set_point
    same: Any = np.ones(d.size)
    points: Any = SetPoint(d, p, here.pump_speed * same, here.oil_temperature * same)
    rows = np.column_stack(np.broadcast_arrays(*stand.cycle_point(points)))
    means = averages(rows, stand.bench.valve, cores=cores, say=say)
    columns = averaged_columns(stand, points, means)
    drag_free = columns["input_power_W"] - stand.bench.pump.friction_torque * here.pump_speed
    compressing = columns["loss_compressibility_W"]
    lost = drag_free + columns["spool_motor_power_W"] - columns["load_power_W"] + compressing
    inlet = columns["pressure_mean_inlet_Pa"] + stand.reference - stand.tank_pressure
    shape = (levels.size, DUTY_RATIOS.size)
    grids = [np.reshape(each, shape) for each in (columns["delivered_flow_m3_s"], lost, inlet)]
    found = np.full((2, demand.rise.size), np.nan)
    for row in range(levels.size):
        here_rows = np.flatnonzero(np.ravel(place) == row)
        delivered = np.fmax.accumulate(grids[0][row])
        for which in (0, 1):
            found[which, here_rows] = np.interp(
                np.ravel(demand.flow)[here_rows], delivered, grids[1 + which][row], right=np.nan
            )
    return Averaged(*found.reshape(2, *demand.rise.shape))


def spread_of(
    demand: Demand,
    stand: Stand,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Spread:
    """Losses at a demand with the spread of what is assumed.

    One value of the PWM valve and one of the rivals at a time stand at an end of their range, in every combination;
    the drag of the pumps is the same for all ways.
    """
    valves = [averaged_valve(demand, each, cores, say) for each in varied_stands(stand)]
    nominal, *_ = found = [
        (_switching_losses(valve, stand, assumed), rival_losses(demand, stand, assumed))
        for assumed in varied_assumptions()
        for valve in valves
    ]
    gains = {rival: np.array([rivals[rival] - switched for switched, rivals in found]) for rival in RIVALS}
    return Spread(
        nominal=Ways(*nominal),
        lowest={rival: _across(np.nanmin, each) for rival, each in gains.items()},
        highest={rival: _across(np.nanmax, each) for rival, each in gains.items()},
    )


def _across(choose: Callable[..., Any], gains: Any) -> Any:
    """The lowest or the highest over all cases; nan where there is none."""
    known = np.any(np.isfinite(gains), axis=0)
    return np.where(known, choose(np.where(known, gains, 0.0), axis=0), np.nan)


def _switching_losses(valve: Averaged, stand: Stand, assumed: Assumed) -> Any:
    pump, speed = stand.bench.pump, stand.set_point.pump_speed
    return valve.loss + drag_power(valve.inlet_rise, speed, pump.displacement, pump.friction_torque, assumed.drag)


def varied_assumptions() -> Iterator[Assumed]:
    """Sets of assumed values: the usual ones, then each value at both ends of its range."""
    yield Assumed()
    for name, ends in RANGES.items():
        yield from (Assumed()._replace(**{name: end}) for end in ends if end != getattr(Assumed(), name))


def varied_stands(stand: Stand) -> Iterator[Stand]:
    """A stand as it is, then with each value of its valves that the file gives a range at both ends of that.

    Ends that contradict other values are left out.
    """
    yield stand
    for row in stand.bench.system.uncertainties:
        for end in row.range or () if row.setting in VARIED else ():
            try:
                yield stand.with_tables(**{row.table: {row.key: end}})
            except ParameterError:
                continue
