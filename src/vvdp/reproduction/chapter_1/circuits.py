"""The circuits of chapter 1, drawn from the networks that simulate them; boost and buck, and their electrical kin."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

import vvdp
from vvdp.base.arrays import Array
from vvdp.base.kinds import DUTY_RATIO, FLOW, GAUGE_PRESSURE, NUMBER, RATIO, TIME
from vvdp.base.units import ATMOSPHERE
from vvdp.reproduction.chapter_2.shapes import solids, surface_drawing
from vvdp.reproduction.drawings import circuit_drawing, solid_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction, over
from vvdp.results.chart import Chart, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, number_statement
from vvdp.runs.run import RecordedRun

DUTIES = (0.1, 0.3, 0.5)
SUPPLY, TUBE_LENGTH, TUBE_DIAMETER, PULSES = 50e5, 3.0, 8e-3, 50.0
"""Of the shipped boost converter."""
DENSITY, PRECHARGED_GAS, PRECHARGE, GAS_EXPONENT = 876.0, 50e-6, 40e5, 1.3
STEP, LONG = 2e-5, 3.0
"""Step and end of the electrical circuit's integration [s]."""
SHOWN = 0.2
"""Time at the end of both runs that is compared: ten pulses [s]."""


@cache
def converter_run(name: str, duty: float) -> RecordedRun:
    """A shipped converter at a duty ratio."""
    return vvdp.load(name, **{"components.valve": {"duty_ratio": duty}}).run()


def converter_table() -> Table:
    """Load pressure of the boost converter and flow of the buck converter over the duty ratio."""
    boost, buck = ([converter_run(f"{name}-converter", d) for d in DUTIES] for name in ("boost", "buck"))
    columns = {
        "duty_ratio": Column(np.array(DUTIES), DUTY_RATIO, "duty ratio"),
        "boost_Pa": Column(
            np.array([run.number("pressure_mean_load_Pa") - ATMOSPHERE for run in boost]), GAUGE_PRESSURE, "boost: load"
        ),
        "buck_m3_s": Column(
            np.array([run.number("flow_mean_tube_m3_s") for run in buck]), FLOW, "buck: flow to the load"
        ),
    }
    return Table(title="Boost and buck converter", columns=columns, axes=("duty_ratio",))


def figure_1_4() -> Reproduction:
    """Boost and buck: what the duty ratio makes of pressure and flow."""
    table = converter_table()
    ideal = SUPPLY / (1.0 - np.array(DUTIES))
    off = float(np.max(np.abs(table["boost_Pa"] / ideal - 1.0)))
    rising = "the average load flow follows the duty ratio"
    statements = (
        bound_statement(
            "boost: least growth of the load's pressure from one duty ratio to the next",
            float(np.min(np.diff(table["boost_Pa"]))),
            GAUGE_PRESSURE,
            low=0.0,
            source=rising,
        ),
        bound_statement(
            "boost: load over supply, from 1/(1 − d)",
            off,
            NUMBER,
            high=0.15,
            source="a DC-DC boost converter",
            because="drops, and the oil that is compressed before the check valve opens",
        ),
        bound_statement(
            "buck: least growth of the flow from one duty ratio to the next",
            float(np.min(np.diff(table["buck_m3_s"]))),
            FLOW,
            low=0.0,
            source=rising,
        ),
    )
    panels = tuple(over("duty_ratio", key, stroke=Stroke.MARKED, low=0.0) for key in ("boost_Pa", "buck_m3_s"))
    caption = "Mean load pressure of the boost converter, and flow of the buck converter, over the duty ratio."
    chart = Chart(name="figure-1.4c", caption=caption, table="duty", panels=panels, side_by_side=True, height=2.3)
    made = circuit_drawing("switch mode circuits", "figure-1.4", "boost-converter", "buck-converter")
    return Reproduction(
        statements=(*made.statements, *statements), tables={"duty": table}, charts=(chart,), pictures=made.pictures
    )


def electrical_boost(duty: float, inductance: float, capacitance: float, resistance: float) -> tuple[Array, Array]:
    """Time [s] and output voltage of a boost converter with ideal switch and diode, from its supply on.

    The supply is that of the hydraulic one; pressure stands for voltage, flow for current [SI].
    """
    count = round(LONG / STEP)
    current, voltage, shown = 0.0, SUPPLY, np.empty(count)
    for place in range(count):
        charging = (place * STEP * PULSES) % 1.0 < duty
        across = SUPPLY if charging else SUPPLY - voltage
        current = max(current + STEP * across / inductance, 0.0)
        voltage += STEP * ((0.0 if charging else current) - voltage / resistance) / capacitance
        shown[place] = voltage
    time: Array = STEP * np.arange(float(count))
    return time, shown


class Analogue(NamedTuple):
    """The hydraulic boost converter's last pulses, and the values of its electrical kin."""

    time: Array  # from the first of the last pulses on [s]
    load: Array  # gauge [Pa]
    inductance: float  # [Pa s^2/m^3]
    capacitance: float  # [m^3/Pa]
    resistance: float  # [Pa s/m^3]


def hydraulic_boost() -> Analogue:
    """The shipped converter at half a period open, and what its parts are worth as inductance, capacitance, resistance.

    Oil of a tube rho l/A, gas of the load V/(n P), load orifice P/Q at its mean.
    """
    run = converter_run("boost-converter", 0.5)
    load, late = run.pressure("load"), run.times > run.times[-1] - SHOWN
    mean, area = float(np.mean(load[late])), 0.25 * np.pi * TUBE_DIAMETER**2
    gas = PRECHARGED_GAS * ((PRECHARGE + ATMOSPHERE) / mean) ** (1.0 / GAS_EXPONENT)
    return Analogue(
        time=run.times[late] - run.times[late][0],
        load=load[late] - ATMOSPHERE,
        inductance=DENSITY * TUBE_LENGTH / area,
        capacitance=gas / (GAS_EXPONENT * mean),
        resistance=(mean - ATMOSPHERE) / run.number("flow_mean_load_orifice_m3_s"),
    )


def figure_1_5() -> Reproduction:
    """The same case twice: the hydraulic boost converter, and a DC-DC converter of equal L, C and R."""
    hydraulic = hydraulic_boost()
    time, voltage = electrical_boost(0.5, hydraulic.inductance, hydraulic.capacitance, hydraulic.resistance)
    electrical = np.interp(time[-1] - SHOWN + hydraulic.time, time, voltage)
    columns = {
        "time_s": Column(hydraulic.time, TIME, "time"),
        "load_Pa": Column(hydraulic.load, GAUGE_PRESSURE, "pressure of the hydraulic load"),
        "output_Pa": Column(electrical, GAUGE_PRESSURE, "voltage of the electrical one, as a pressure"),
    }
    made = circuit_drawing("boost converter and its hydraulic analogue", "figure-1.5", "boost-converter")
    return Reproduction(
        statements=(*made.statements, *_analogue_statements(hydraulic, float(electrical.mean()))),
        tables={"analogue": Table(title="Both converters", columns=columns, axes=("time_s",), is_data=True)},
        charts=(_analogue_chart(),),
        pictures=made.pictures,
    )


def _analogue_chart() -> Chart:
    lines = tuple(Line(x="time_s", y=key) for key in ("load_Pa", "output_Pa"))
    return Chart(
        name="figure-1.5b",
        caption="Output of the boost converter at a duty ratio of 0.5, hydraulic and electrical, with the same "
        "inductance, capacitance and resistance; the electrical switch and diode are ideal.",
        table="analogue",
        panels=(Lines(lines=lines, label="output", low=0.0, right=0.1),),
        height=2.4,
    )


def _analogue_statements(hydraulic: Analogue, electrical: float) -> tuple[Statement, ...]:
    K = 2.0 * hydraulic.inductance * PULSES / hydraulic.resistance
    ideal = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * 0.5**2 / K))
    return (
        number_statement(
            "electrical converter: output over supply",
            float(ideal),
            electrical / SUPPLY,
            RATIO,
            share=0.02,
            source="a DC-DC boost converter",
            because="2 % (ours): ripple of the output",
            note="its current rests in every period: (1 + √(1 + 4 d²/K))/2 with K = 2 L f/R, not 1/(1 − d)",
        ),
        number_statement(
            "output of the hydraulic converter beside the electrical one",
            electrical,
            float(hydraulic.load.mean()),
            GAUGE_PRESSURE,
            share=0.2,
            source="the hydro-mechanical analogue",
            because="20 % (ours): drops of tube and valves, which the electrical one has not",
        ),
    )


def _circuit(number: str, what: str, system: str) -> Callable[[], Reproduction]:
    def work() -> Reproduction:
        """A circuit, drawn from its network."""
        return circuit_drawing(what, f"figure-{number}", system)

    return work


def figure_1_2() -> Reproduction:
    """Sleeve and spool, rolled out."""
    return solid_drawing("schematic of the rotary valve", "figure-1.2", surface_drawing)


def figure_1_3() -> Reproduction:
    """The spool."""
    return solid_drawing("spool of the rotary valve", "figure-1.3", solids)


DRAWN = (
    ("1.1", "Virtually variable displacement pump circuit", "prototype"),
    ("1.6", "Displacement control, closed circuit with a 3-way shuttle valve", "shuttle-circuit"),
    ("1.7", "Displacement control, closed circuit with pilot check valves", "pilot-check-circuit"),
    ("1.8", "Open circuit, four 2-way valves at a drive", "four-valve-circuit"),
    ("1.9", "Direct displacement control, open circuit with a VVDP", "displacement-control"),
)
ITEMS = (
    *(Item(ItemKind.FIGURE, number, title, _circuit(number, title, system)) for number, title, system in DRAWN),
    Item(ItemKind.FIGURE, "1.2", "Schematic of the rotary 3-way on/off valve", figure_1_2),
    Item(ItemKind.FIGURE, "1.3", "Spool of the rotary 3-way on/off valve", figure_1_3),
    Item(ItemKind.FIGURE, "1.4", "Switch mode hydraulic circuits", figure_1_4),
    Item(ItemKind.FIGURE, "1.5", "DC-DC boost converter and its hydraulic analogue", figure_1_5),
)
