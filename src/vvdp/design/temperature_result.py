"""The valve from cold to hot oil, as a result: columns, checks, charts."""

from collections.abc import Iterator

import numpy as np

from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import (
    DYNAMIC_VISCOSITY,
    FORCE,
    FREQUENCY,
    MEAN_POWER,
    NUMBER,
    RATIO,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    Kind,
)
from vvdp.base.params import field_kinds
from vvdp.design.conditions import LEFT_OUT, conditions, sentence
from vvdp.design.quantities import KINDS, LABELS, key
from vvdp.design.temperature import ORIGINS, QUANTITIES, OverTemperature, RangeLimits, temperature_spans
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Row, Section, Table

MANNER = (
    "All values are analytic: the valve of the system at the start of a run, with its oil at one temperature after "
    "another. A check says whether a number stays on the side of its limit on which the model holds."
)
OTHERS: dict[str, tuple[Kind, str]] = {
    "pwm_frequency_averaged": (FREQUENCY, "PWM frequency, averaged"),
    "viscosity": (DYNAMIC_VISCOSITY, "dynamic viscosity"),
    "input_power": (MEAN_POWER, "input power"),
    "nozzle_reynolds_number": (NUMBER, "Reynolds number of the nozzles"),
    "cavitation_number_open": (NUMBER, "cavitation number, tank port open"),
    "cavitation_number_closing": (NUMBER, "cavitation number, tank port closing"),
    "gap_reynolds_number": (NUMBER, "Reynolds number of the clearance"),
    "taylor_number": (NUMBER, "Taylor number of the clearance"),
    "sheared_temperature_rise": (TEMPERATURE_DIFFERENCE, "warming of the film by its shear"),
    "carried_temperature_rise": (TEMPERATURE_DIFFERENCE, "warming of the leaking oil, at most"),
    "radial_force": (FORCE, "radial force of the jets"),
    "bearing_capacity": (FORCE, "bearing capacity of the lands"),
    "eccentricity": (NUMBER, "eccentricity"),
}
COLUMNS = {name: (KINDS[name], LABELS[name]) for name in QUANTITIES} | OTHERS
SHOWN = (
    "temperature_K", "viscosity_Pa_s", "pwm_frequency_Hz", "pwm_frequency_averaged_Hz", "pressure_drop_total_Pa",
    "loss_total_W", "loss_leakage_W", "efficiency", "eccentricity",
)  # fmt: skip
LIMITS = {
    "reynolds_number": "Reynolds number of the nozzles, at least",
    "cavitation_number": "cavitation number, at least",
    "taylor_number": "Taylor number, at most",
    "temperature_rise": "warming, at most",
    "eccentricity": "eccentricity, at most",
    "excess_share": "what the strongest nozzle has more than its share",
    "specific_heat": "specific heat of the oil",
    "thermal_conductivity": "thermal conductivity of the oil",
}


def temperature_result(found: OverTemperature) -> Result:
    """The study as a result."""
    table = _table(found)
    charts = (_valve_chart(table), _losses_chart(table), _clearance_chart(), _range_chart(found))
    return Result(
        verb="design temperature",
        title="The valve from cold to hot oil",
        system=found.system.name,
        manner=MANNER,
        references=("taylor1923", "ocvirk1952", "wang2017"),
        conditions=conditions(found.system),
        left_out=LEFT_OUT,
        tables={"temperature": table},
        listings={"checks": _checks(found), "limits": _limits(found.limits)},
        charts={each.name: each for each in charts},
        findings=tuple(_findings(found)),
        sections=(
            Section(title="Figures", shows=tuple(each.name for each in charts)),
            Section(title="Where the model holds", shows=("checks",)),
            Section(title="What was taken", shows=("limits",)),
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
            Section(title="Values", shows=("temperature",), starts_page=True),
        ),
    )


def _table(found: OverTemperature) -> Table:
    columns = {"temperature_K": Column(found.temperatures, TEMPERATURE, "oil temperature")}
    columns |= {key(name, COLUMNS[name][0]): Column(values, *COLUMNS[name]) for name, values in found.columns.items()}
    ratio = found.columns["bearing_capacity"] / found.columns["radial_force"]
    columns["bearing_ratio"] = Column(ratio, RATIO, "bearing capacity over force of the jets")
    columns |= {f"{each.name}_usage": Column(each.usage, NUMBER, each.label) for each in found.checks}
    return Table(title="Values over the oil's temperature", columns=columns, shown=SHOWN, axes=("temperature_K",))


def _findings(found: OverTemperature) -> Iterator[Finding]:
    frequency, efficiency = found.columns["pwm_frequency"], found.columns["efficiency"]
    ends = " and ".join(with_unit(float(found.temperatures[k]), TEMPERATURE) for k in (0, -1))
    yield Finding(
        text=f"Between {ends} the PWM frequency of the fully open valve goes from {number(float(frequency[0]), 3)} to "
        f"{with_unit(float(frequency[-1]), FREQUENCY, 3)}, the efficiency from {percent(float(efficiency[0]))} to "
        f"{percent(float(efficiency[-1]))}."
    )
    yield from (
        Finding(text=sentence(text), grade=Grade.WARNING, title="The model is in doubt") for text in found.warnings
    )


def _checks(found: OverTemperature) -> Listing:
    rows = [
        Row(
            each.label,
            each.kind,
            (
                float(np.min(each.values)),
                float(np.max(each.values)),
                each.limit if each.at_least else None,
                None if each.at_least else each.limit,
                temperature_spans(found.temperatures, each.outside) if np.any(each.outside) else "nowhere",
            ),
        )
        for each in found.checks
    ]
    return Listing(title="Checks", heads=("lowest", "highest", "at least", "at most", "in doubt"), rows=tuple(rows))


def _limits(limits: RangeLimits) -> Listing:
    kinds = field_kinds(RangeLimits)
    rows = (Row(LIMITS[name], kinds[name], (getattr(limits, name),), note=origin) for name, origin in ORIGINS.items())
    return Listing(title="Limits and values taken", heads=("value",), rows=tuple(rows))


T = "temperature_K"


def _valve_chart(table: Table) -> Chart:
    speed = (
        Line(x=T, y="pwm_frequency_Hz", label="fully open", colour=Colour.LOAD),
        Line(x=T, y="pwm_frequency_averaged_Hz", label="averaged", colour=Colour.INLET),
    )
    numbers = (
        Line(x=T, y="nozzle_reynolds_number", label="Reynolds number of the nozzles", colour=Colour.LOAD),
        Line(x=T, y="bearing_ratio", label="bearing capacity over force of the jets", colour=Colour.INLET),
    )
    return Chart(
        name="frequency",
        caption="From cold to hot oil: the PWM frequency, and what jets and lands do.",
        table="temperature",
        panels=(Lines(lines=speed, label="PWM frequency"), Lines(lines=numbers, label="ratio", y_log=True)),
        height=3.6,
    )


LOSSES = {
    "loss_total_W": ("total", Colour.INK),
    "loss_full_open_W": ("fully open", Colour.LOAD),
    "loss_transition_W": ("transitions", Colour.INLET),
    "loss_leakage_W": ("leakage", Colour.TANK),
    "loss_compressibility_W": ("compressibility", Colour.RELIEF),
    "spool_drive_power_W": ("spool's motor", Colour.PURPLE),
}


def _losses_chart(table: Table) -> Chart:
    lines = tuple(
        Line(x=T, y=name, label=label, colour=colour)
        for name, (label, colour) in LOSSES.items()
        if np.any(table[name] > 0.0)
    )
    return Chart(
        name="losses",
        caption="Analytic losses over the temperature of the oil.",
        table="temperature",
        panels=(Lines(lines=lines, label="loss", low=0.0),),
        height=2.6,
    )


def _clearance_chart() -> Chart:
    lines = (
        Line(x=T, y="carried_temperature_rise_K", label="leaking oil, at most", colour=Colour.INLET),
        Line(x=T, y="sheared_temperature_rise_K", label="film, by its shear", colour=Colour.LOAD),
    )
    return Chart(
        name="clearance",
        caption="How much warmer than the oil the clearance becomes.",
        table="temperature",
        panels=(Lines(lines=lines, label="warming", y_log=True),),
        height=2.2,
    )


def _range_chart(found: OverTemperature) -> Chart:
    lines = tuple(
        Line(x=T, y=f"{each.name}_usage", width=1.8 if np.any(each.outside) else 1.0)
        for each in found.checks
        if np.any(each.usage > 0.0)
    )
    limit = Level(value=1.0, colour=Colour.RED, stroke=Stroke.DASHED)
    return Chart(
        name="range",
        caption="How much of its limit each check uses: above 1 the model is in doubt.",
        table="temperature",
        panels=(Lines(lines=lines, label="use of the limit", levels=(limit,), y_log=True, low=1e-2, legend="Check"),),
        height=3.0,
    )
