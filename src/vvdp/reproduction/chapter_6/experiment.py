"""Section 6.5: the cylinder follows a triangle; its pressures, and what the three actuators do."""

from typing import Any

import numpy as np

from vvdp.api.run import Run
from vvdp.base.arrays import Array
from vvdp.base.kinds import (
    AREA,
    COUNT,
    FLOW,
    FRACTION,
    FREQUENCY,
    GAUGE_PRESSURE,
    POSITION,
    RATIO,
    TIME,
)
from vvdp.base.units import ATMOSPHERE
from vvdp.control.capacities import CircuitPressures, capacities, return_flow, sides
from vvdp.control.cylinder_force import FORCE_RATE
from vvdp.control.flow_split import authority
from vvdp.reproduction.chapter_6.cylinder import (
    MACHINE,
    MODEL,
    PERIOD,
    as_drawn,
    at_samples,
    machine_run,
    model_run,
    nominal_settings,
    printed_run,
)
from vvdp.reproduction.drawings import circuit_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, digit_statement, exact_statement, number_statement

LARGEST_ERROR = 5e-3
REVERSALS = 3
"""Within the 16 s of a run."""
ASSUMED = "hoses, bulk modulus, mass, load, pump lag and gains are in no table of the text"


def figure_6_1() -> Reproduction:
    """Pump, directional valve, throttling valve and cylinder."""
    return circuit_drawing("direct displacement control open circuit", "figure-6.1", MODEL)


def figure_6_4() -> Reproduction:
    """The same with the switched pump."""
    return circuit_drawing("circuit with the virtually variable displacement pump", "figure-6.4", MACHINE)


def _error(run: Run, who: str) -> Statement:
    return bound_statement(
        f"largest tracking error, {who}",
        run.number("tracking_error_max_m"),
        POSITION,
        high=LARGEST_ERROR,
        source="less than 0.5 cm",
        note=f"from 1 s on; {ASSUMED}",
    )


def figure_6_5() -> Reproduction:
    """The triangle, and how far the piston is off."""
    statements = (_error(model_run(), "chapter 6 alone"), _error(machine_run(), "whole machine"))
    return as_drawn(model_run(), "displacement-motion", statements, "figure-6.5")


def _extremes(run: Run) -> tuple[float, float]:
    """Lowest and highest pressure of both chambers from 1 s on [Pa, gauge]."""
    both = np.concatenate([at_samples(run, f"states.chamber_{side}_Pa") for side in "ab"]) - ATMOSPHERE
    return float(both.min()), float(both.max())


def figure_6_6() -> Reproduction:
    """Both chambers stay within their bounds, and no mode acts."""
    bounds = nominal_settings().bounds
    lowest, highest = _extremes(model_run())
    statements = (
        bound_statement(
            "lowest pressure of a chamber",
            lowest,
            GAUGE_PRESSURE,
            low=bounds.lowest_pressure - ATMOSPHERE,
            source="within bounds",
            because="bounds of 1 and 80 bar are assumed",
        ),
        bound_statement(
            "highest pressure of a chamber",
            highest,
            GAUGE_PRESSURE,
            high=bounds.highest_pressure - ATMOSPHERE,
            source="within bounds",
        ),
        number_statement(
            "share of the time in mode 1",
            1.0,
            model_run().number("mode_1_share"),
            FRACTION,
            source="no pressure mode is activated",
        ),
    )
    return as_drawn(model_run(), "displacement-pressures", statements, "figure-6.6")


def middle_frequency(values: Array) -> float:
    """The frequency below which half of the variance lies [Hz]."""
    power: Any = np.abs(np.fft.rfft(values - values.mean())) ** 2
    share = np.cumsum(power) / power.sum()
    return float(np.fft.rfftfreq(values.size, PERIOD)[np.searchsorted(share, 0.5)])


def _mean_openings(run: Run, printed: Run) -> tuple[Statement, ...]:
    return (
        digit_statement(
            "mean opening of the throttling valve",
            0.8,
            run.number("return_opening_mean"),
            FRACTION,
            tolerance=0.05,
            source="the nominal opening is 80 %",
        ),
        digit_statement(
            "the same, law as printed",
            0.8,
            printed.number("return_opening_mean"),
            FRACTION,
            tolerance=0.05,
            source="the same, with (6.28) as printed",
            inconsistency="(6.28) leaves out the expected flow that (6.30) has",
            contradiction=("(6.28): −λ_Q Q̂", "(6.30): with the expected flow"),
        ),
    )


def figure_6_7() -> Reproduction:
    """Direction, opening and flow: one switch per reversal, a quick valve beside a slow pump."""
    run, printed = model_run(), printed_run()
    valve, pump = (middle_frequency(at_samples(run, f"commands.control.{name}")) for name in ("opening", "flow_m3_s"))
    statements = (
        number_statement(
            "switches of the directional valve",
            REVERSALS,
            run.number("directional_switches"),
            COUNT,
            source="clear switching instead of chattering: one at each reversal",
        ),
        number_statement(
            "switches with the law as printed",
            REVERSALS,
            printed.number("directional_switches"),
            COUNT,
            source="the same, with (6.25) as printed",
            inconsistency="on a switch the delivered flow changes sides and moves U*: a hysteresis is missing",
        ),
        bound_statement(
            "middle frequency of the valve's opening over that of the pump's flow",
            valve / pump,
            RATIO,
            low=2.0,
            source="the valve has a high bandwidth, the pump a low one",
            because="an octave (ours)",
            note=f"half of the variance lies below {valve:.2g} Hz and {pump:.2g} Hz",
        ),
        *_mean_openings(run, printed),
    )
    return as_drawn(run, "displacement-actuation", statements, "figure-6.7")


def efforts() -> Table:
    """Commanded effort, and the shares of pump and valve in it, at every tenth sample."""
    run, settings = model_run(), nominal_settings()
    series = {
        name: at_samples(run, column, 0.0)[::10]
        for name, column in (
            ("direction", "commands.control.direction"),
            ("position", "states.rod.position_m"),
            ("a", "states.chamber_a_Pa"),
            ("b", "states.chamber_b_Pa"),
            ("flow", "states.pump.flow_m3_s"),
            ("opening", "commands.control.opening"),
            ("asked", "commands.control.effort_N_s"),
        )
    }
    pump: Array = np.zeros(series["asked"].size)
    valve: Array = np.zeros(series["asked"].size)
    for k, way in enumerate(series["direction"]):
        if way != 0.0:
            at = CircuitPressures(float(series["a"][k]), float(series["b"][k]), ATMOSPHERE)
            capacity = capacities(float(way), float(series["position"][k]), ATMOSPHERE, settings.cylinder)
            returned = sides(float(way), at, settings.cylinder).return_pressure
            full = return_flow(returned, settings.split.least_return_flow, settings.cylinder)
            means = authority(capacity, full)
            pump[k], valve[k] = means.per_flow * series["flow"][k], means.per_opening * series["opening"][k]
    columns = {
        "time_s": Column(10.0 * PERIOD * np.arange(float(pump.size)), TIME, "time"),
        "asked_N_s": Column(series["asked"], FORCE_RATE, "asked"),
        "pump_N_s": Column(pump, FORCE_RATE, "pump"),
        "valve_N_s": Column(valve, FORCE_RATE, "throttling valve"),
    }
    return Table(title="Effort", columns=columns, axes=("time_s",), is_data=True)


def figure_6_8() -> Reproduction:
    """How the effort is shared out."""
    table = efforts()
    flow = at_samples(model_run(), "commands.control.flow_m3_s")
    late = table["time_s"] > 1.0
    missing = np.abs(table["asked_N_s"] - table["pump_N_s"] - table["valve_N_s"])[late]
    scale = float(np.abs(table["asked_N_s"]).max())
    statements = (
        bound_statement("lowest flow asked of the pump", flow.min(), FLOW, low=0.0, source="the lowest bound is 0 lpm"),
        bound_statement(
            "median of what pump and valve leave of the effort, over the largest effort",
            float(np.median(missing)) / scale,
            RATIO,
            high=1e-3,
            source="together they give U*",
            because="a tenth of a per cent (ours)",
        ),
        bound_statement(
            "share of the time in which flow or opening is at an end",
            model_run().number("saturated_share"),
            FRACTION,
            high=0.0,
            source="80 % was found so that flow and opening are not saturated",
            assumption=ASSUMED,
            note="at reversals, when the oil on its way still feeds the chamber that empties",
        ),
    )
    return figure_of(
        "figure-6.8",
        "The effort U* that is asked, and what the delivered flow and the opening give of it.",
        {"effort": table},
        statements,
        over("time_s", "asked_N_s", "pump_N_s", "valve_N_s", label="effort", width=0.8),
    )


def section_6_5() -> Reproduction:
    """Areas, stroke and time of the experiment, and whether the pump can do it."""
    cylinder = nominal_settings().cylinder
    speed = 0.216 / 4.0
    machine = machine_run()
    return Reproduction(
        statements=(
            exact_statement("cap area", 20.26e-4, cylinder.area_a, AREA),
            exact_statement(
                "rod side's area, called rod area",
                10.77e-4,
                cylinder.area_b,
                AREA,
                other=cylinder.area_a - 10.77e-4,
                assumption="as the annulus; in the second run as the rod",
            ),
            bound_statement(
                "flow that 21.6 cm in 4 s take on the cap side",
                2.0 * cylinder.area_a * speed,
                FLOW,
                high=40e-3 / 60.0,
                source="within the pump's 40 lpm",
                note="if 4 s are both ways; half of it if they are one way",
            ),
            bound_statement(
                "PWM frequency of the valve in the machine",
                machine.number("pwm_frequency_Hz"),
                FREQUENCY,
                low=70.4,
                high=82.0,
                source="the rotary valve of section 2.5: 70.4 to 82 Hz",
            ),
        ),
    )


ITEMS = (
    Item(ItemKind.FIGURE, "6.1", "Direct displacement control open circuit", figure_6_1),
    Item(ItemKind.FIGURE, "6.4", "Software enabled VVDP circuit", figure_6_4),
    Item(ItemKind.FIGURE, "6.5", "Actuator position reference and tracking error", figure_6_5),
    Item(ItemKind.FIGURE, "6.6", "Chamber pressures", figure_6_6),
    Item(ItemKind.FIGURE, "6.7", "Efforts of directional valve, throttling valve and pump", figure_6_7),
    Item(ItemKind.FIGURE, "6.8", "Distribution of the total effort", figure_6_8),
    Item(ItemKind.SECTION, "6.5", "Measures of the experiment", section_6_5),
)
