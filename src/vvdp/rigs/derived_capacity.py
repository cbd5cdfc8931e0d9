"""Derived capacity of the VVDP over the duty ratio, based on ISO 8426: flow per angle without pressure difference."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base import kinds
from vvdp.base.arrays import Array
from vvdp.base.display import percent, plain, with_unit
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Finding, Result, Table, numbers_of
from vvdp.rigs.capacity import (
    PRESSURES,
    averaged_flows,
    capacity_points,
    capacity_pressures,
    derived_capacities,
)
from vvdp.rigs.conditions import axis_words, conditions, limit_findings, validity_findings, within_validity
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import SetPoint, Stand

DUTY_RATIOS = (0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0)
SPEED_SHARES = (0.6, 0.7, 0.8, 0.9, 1.0)
"""Pump speeds of the averages, over that of the system."""
MANNER = (
    "Derived capacity, based on ISO 8426-2, the zero-pressure intercept: at one speed and setting the delivered flow "
    f"is taken at {PRESSURES} evenly spaced pressure differences, and the straight line that comes closest is followed "
    "to no pressure difference; the flow there over the speed is the capacity. A setting is a duty ratio. Flows are "
    "simulated, periodic steady states, and beside them quasi-steady averages, these at several speeds. They count "
    "volumes at the tank's pressure, which is that of the outlet where there is no difference."
)
LEFT_OUT = (
    "ISO 8426-1, the two-step method: it takes the slope of the flow over the speed for the displacement. What goes "
    "over the relief valve in the transitions grows with the square of the pump flow, so that this slope is no volume "
    "that anything displaces; the table has it beside the other, from the averages.",
    "Flow meters, hoses and their drops, uncertainty of instruments, thermal settling.",
    "The actuator that sets the spool's axial position: the duty ratio is held exactly.",
)
CAPACITIES: Mapping[str, tuple[kinds.Kind, str]] = {
    "commanded_capacity_m3_rad": (kinds.DISPLACEMENT, "commanded capacity, duty ratio times displacement"),
    "derived_capacity_m3_rad": (kinds.DISPLACEMENT, "derived capacity, simulated"),
    "averaged_capacity_m3_rad": (kinds.DISPLACEMENT, "derived capacity, averages"),
    "two_step_capacity_m3_rad": (kinds.DISPLACEMENT, "two-step method, averages"),
    "derived_over_commanded": (kinds.EFFICIENCY, "derived over commanded capacity, simulated"),
    "averaged_over_commanded": (kinds.EFFICIENCY, "derived over commanded capacity, averages"),
}
QUANTITIES = {"duty_ratio": (kinds.DUTY_RATIO, "duty ratio"), **CAPACITIES}


class Flows(NamedTuple):
    """Delivered flows: simulated over duty ratio and pressure at the system's speed, averages also over the speed."""

    duty_ratios: tuple[float, ...]
    speeds: tuple[float, ...]
    points: list[SetPoint]
    states: list[Steady]
    averaged_points: list[SetPoint]
    averaged: Array

    @property
    def simulated_flow(self) -> Array:
        """Mean flow to the load at each point, leakage taken off; nan without a state [m^3/s]."""
        return np.array([float(state.summary.get("mean_load_flow_m3_s", np.nan)) for state in self.states])

    @property
    def at_own_speed(self) -> Array:
        """The averaged flows at the points of the simulated ones [m^3/s]."""
        own: Array = self.averaged.reshape(len(self.speeds), -1)[-1]
        return own


def derived_capacity(
    stand: Stand,
    duty_ratios: Sequence[float] = DUTY_RATIOS,
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Result:
    """Derived capacity [m^3/rad] at each duty ratio and at that of the system, simulated and by averages.

    Source  ours, docs/rigs.md, based on iso8426
    """
    began = time.perf_counter()
    own = stand.set_point.duty_ratio
    duty_ratios = tuple(sorted({*duty_ratios, own}))
    flows = _measure(stand, duty_ratios, cores=cores, say=say)
    capacity, by_speed, by_flow = _capacity_table(stand, flows), _speed_table(stand, flows), _flow_table(stand, flows)
    numbers = {key: float(capacity[key][duty_ratios.index(own)]) for key in QUANTITIES}
    return Result(
        verb="rig derived-capacity",
        title="Derived capacity over the duty ratio",
        system=stand.name,
        manner=MANNER,
        references=("iso8426",),
        conditions=conditions(stand)
        | {
            "duty ratio": axis_words(duty_ratios, kinds.DUTY_RATIO),
            "load pressure": axis_words(capacity_pressures(stand).tolist(), kinds.PRESSURE_LEVEL),
        },
        left_out=LEFT_OUT,
        tables={"capacity": capacity, "speeds": by_speed, "flows": by_flow},
        charts={each.name: each for each in (_capacity_chart(by_speed), _flow_chart(by_flow))},
        numbers=numbers_of(numbers, QUANTITIES),
        findings=(
            *_findings(numbers),
            *_missing(flows),
            *limit_findings(stand),
            *validity_findings(within_validity(flows.states)),
        ),
        seconds=time.perf_counter() - began,
    )


def _measure(stand: Stand, duty_ratios: tuple[float, ...], *, cores: int | None, say: Callable[[str], None]) -> Flows:
    """The flows at all points of the capacities."""
    here = stand.set_point
    speeds = tuple(share * here.pump_speed for share in SPEED_SHARES)
    points = capacity_points(stand, duty_ratios, (here.pump_speed,), (here.oil_temperature,))
    averaged_points = capacity_points(stand, duty_ratios, speeds, (here.oil_temperature,))
    return Flows(
        duty_ratios=duty_ratios,
        speeds=speeds,
        points=points,
        states=steady_states([(stand, point) for point in points], cores=cores, say=say),
        averaged_points=averaged_points,
        averaged=averaged_flows(stand, averaged_points, cores=cores, say=say),
    )


def _capacity_table(stand: Stand, flows: Flows) -> Table:
    """A row for each duty ratio, at the system's own speed."""
    d, speeds = np.array(flows.duty_ratios), np.array(flows.speeds)
    commanded = d * stand.bench.pump.displacement
    derived = derived_capacities(stand, flows.points, flows.simulated_flow)
    averaged = derived_capacities(stand, flows.points, flows.at_own_speed)
    by_speed = flows.averaged.reshape(speeds.size, -1)
    apart = speeds - speeds.mean()
    slopes = apart @ by_speed / (apart @ apart)
    # The slopes of the flows over the speed, followed to no pressure difference as flows at a speed of 1 would be.
    still = [point._replace(pump_speed=1.0) for point in flows.points]
    values = {
        "duty_ratio": d,
        "commanded_capacity_m3_rad": commanded,
        "derived_capacity_m3_rad": derived,
        "averaged_capacity_m3_rad": averaged,
        "two_step_capacity_m3_rad": derived_capacities(stand, still, slopes),
        "derived_over_commanded": _over(derived, commanded),
        "averaged_over_commanded": _over(averaged, commanded),
    }
    columns = {key: Column(values[key], *QUANTITIES[key]) for key in QUANTITIES}
    return Table(title="Capacity over the duty ratio", columns=columns, axes=("duty_ratio",))


def _over(capacity: Array, commanded: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(commanded > 0.0, capacity / commanded, np.nan)


def _speed_table(stand: Stand, flows: Flows) -> Table:
    """A row for each pump speed and duty ratio, the simulated capacity only at the system's own speed."""
    speed = np.repeat(flows.speeds, len(flows.duty_ratios))
    d = np.tile(flows.duty_ratios, len(flows.speeds))
    commanded = d * stand.bench.pump.displacement
    averaged = derived_capacities(stand, flows.averaged_points, flows.averaged)
    simulated = np.full(d.size, np.nan)
    simulated[-len(flows.duty_ratios) :] = derived_capacities(stand, flows.points, flows.simulated_flow)
    return Table(
        title="Derived over commanded capacity by pump speed",
        columns={
            "pump_speed_rad_s": Column(speed, kinds.SPEED, "pump speed"),
            "duty_ratio": Column(d, kinds.DUTY_RATIO, "duty ratio"),
            "averaged_over_commanded": Column(_over(averaged, commanded), *CAPACITIES["averaged_over_commanded"]),
            "derived_over_commanded": Column(_over(simulated, commanded), *CAPACITIES["derived_over_commanded"]),
        },
        axes=("duty_ratio", "pump_speed_rad_s"),
        is_data=True,
    )


def _flow_table(stand: Stand, flows: Flows) -> Table:
    """A row for each duty ratio and pressure: the flows that the lines are drawn through."""
    d, pressure, _, _ = np.array(flows.points, float).T
    remarks = np.array([state.reason or "" for state in flows.states])
    return Table(
        title="Delivered flow at low pressure differences",
        columns={
            "duty_ratio": Column(d, kinds.DUTY_RATIO, "duty ratio"),
            "pressure_difference_Pa": Column(
                pressure - stand.tank_pressure, kinds.PRESSURE_DIFFERENCE, "pressure difference"
            ),
            "simulated_flow_m3_s": Column(flows.simulated_flow, kinds.FLOW, "delivered flow, simulated"),
            "averaged_flow_m3_s": Column(flows.at_own_speed, kinds.FLOW, "delivered flow, averages"),
            "remark": Column(remarks, None, "note"),
        },
        axes=("pressure_difference_Pa", "duty_ratio"),
        is_data=True,
    )


def _capacity_chart(by_speed: Table) -> Chart:
    """The capacities themselves, and what share of the commanded one they are."""
    capacities = (
        ("commanded", "commanded", Colour.INK, Stroke.DOTTED),
        ("averaged", "averages", Colour.LOAD, Stroke.SOLID),
        ("derived", "simulated", Colour.INLET, Stroke.POINTS),
    )
    lines = tuple(
        Line(x="duty_ratio", y=f"{key}_capacity_m3_rad", label=label, colour=colour, stroke=stroke)
        for key, label, colour, stroke in capacities
    )
    return Chart(
        name="derived-capacity",
        caption="Left: commanded and derived capacity. Right: the second over the first, averages by pump speed and "
        "the simulated one. What is missing goes over the relief valve in the transitions, without any load.",
        table="speeds",
        panels=(
            Lines(table="capacity", lines=lines, label="capacity", low=0.0, left=0.0),
            _share_panel(by_speed),
        ),
        side_by_side=True,
        height=2.9,
    )


def _share_panel(table: Table) -> Lines:
    """Derived over commanded capacity, a line for each pump speed."""
    speeds = np.unique(table["pump_speed_rad_s"])
    rows = [tuple(int(row) for row in np.flatnonzero(table["pump_speed_rad_s"] == speed)) for speed in speeds]
    words = [with_unit(float(speed), kinds.SPEED, 4) for speed in speeds]
    averaged = (
        Line(x="duty_ratio", y="averaged_over_commanded", label=label, rows=those, colour=colour)
        for label, those, colour in zip(words, rows, shades(speeds.size), strict=True)
    )
    simulated = Line(
        x="duty_ratio",
        y="derived_over_commanded",
        label=f"{words[-1]}, simulated",
        rows=rows[-1],
        colour=Colour.INLET,
        stroke=Stroke.POINTS,
    )
    label = "derived over commanded capacity"
    return Lines(lines=(*averaged, simulated), label=label, high=1.0, left=0.0, legend="pump speed")


def _flow_chart(table: Table) -> Chart:
    duties = np.unique(table["duty_ratio"])[::-3]
    lines = (
        Line(
            x="pressure_difference_Pa",
            y="simulated_flow_m3_s",
            label=plain(duty, 3),
            rows=tuple(int(row) for row in np.flatnonzero(table["duty_ratio"] == duty)),
            colour=colour,
            stroke=Stroke.MARKED,
        )
        for duty, colour in zip(duties, shades(duties.size)[::-1], strict=True)
    )
    return Chart(
        name="low-pressure-flow",
        caption="Delivered flow at the pressure differences of the capacity, simulated.",
        table="flows",
        panels=(Lines(lines=tuple(lines), legend="duty ratio", low=0.0, left=0.0),),
        height=2.9,
    )


def _findings(numbers: Mapping[str, float]) -> Iterator[Finding]:
    d = plain(numbers["duty_ratio"], 4)
    averaged, commanded = (
        with_unit(numbers[f"{name}_capacity_m3_rad"], kinds.DISPLACEMENT) for name in ("averaged", "commanded")
    )
    if np.isfinite(numbers["derived_capacity_m3_rad"]):
        derived = with_unit(numbers["derived_capacity_m3_rad"], kinds.DISPLACEMENT)
        yield Finding(
            text=f"At duty ratio {d} the derived capacity is {derived}, {percent(numbers['derived_over_commanded'])} "
            f"of the commanded {commanded}; quasi-steady averages give {averaged}."
        )


def _missing(flows: Flows) -> Iterator[Finding]:
    reasons = [state.reason for state in flows.states if state.reason]
    for reason in dict.fromkeys(reasons):
        yield Finding(text=f"{reasons.count(reason)} of {len(flows.states)} flows are missing: {reason}.")
