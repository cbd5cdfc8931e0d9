"""The result of a comparison of circuits: where the power went, how well the rod followed, charts, findings."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from vvdp.base.display import number
from vvdp.base.kinds import (
    COUNT,
    DURATION,
    EFFICIENCY,
    GAUGE_PRESSURE,
    LENGTH,
    MEAN_POWER,
    NUMBER,
    POSITION,
    RATE,
    Kind,
)
from vvdp.comparison.circuit_trials import CircuitComparison, CircuitRun
from vvdp.comparison.equal_error import EQUAL, is_reached
from vvdp.comparison.score_tables import SCORES
from vvdp.machines.duties import Duty
from vvdp.results.chart import Bars, Chart, Colour, Line, Lines
from vvdp.results.result import Column, Finding, Grade, Number, Result, Section, Table
from vvdp.rivals.rival_account import CircuitScore
from vvdp.rivals.rival_circuits import SINKS
from vvdp.simulation.balance import LIMIT

MARGIN = 2e5
"""By how much a low side may fall below what holds it [Pa]."""
LOST = 5e-3
"""An error beyond which a circuit is stated not to follow [m]."""
MANNER = (
    "Every circuit moves the same cylinder, mass, friction and load through the same duty cycle, behind the same "
    "reference filter, with a position loop of one form: velocity fed forward, a gain on the error that keeps the same "
    "margin by a rule, flows and openings from measured pressures; one law opens every meter-out throttle. All are "
    "brought to the same rms error by the delay of their reference. Pumps turn without friction, so that power "
    "is hydraulic; motors are not counted."
)
DEFINITIONS = (
    "Powers are means over the last of three rounds. Drawn: taken from the drives of all pumps; returned: given back "
    "to them. Delivered: what the oil gives to the rod while it pushes, friction of the rod included; received: what "
    "the rod gives to the oil while the load overruns. Drawn and received together are what is delivered, returned, "
    "lost and stored. Errors are position minus filtered reference, from the first second on. The low side is "
    "the lowest pressure of both chambers over every step."
)
FRONT = (
    "Each circuit is run with the common reference, whose four poles are at 25 1/s, then with other poles before its "
    "loop until its rms error is the one at which all are compared. Every run is a row: what a circuit draws, minus "
    "what it returns, at the error that it has."
)
FIGURES: Mapping[str, tuple[Kind, str, Callable[[CircuitScore], float]]] = {
    "tracking_error_max_m": (LENGTH, "largest error", lambda s: s.tracking_max),
    "tracking_error_rms_m": (LENGTH, "error, rms", lambda s: s.tracking_rms),
    "tracking_error_first_second_m": (LENGTH, "largest error, first second", lambda s: s.tracking_first),
    "power_drawn_W": (MEAN_POWER, "drawn", lambda s: s.drawn),
    "power_returned_W": (MEAN_POWER, "returned", lambda s: s.returned),
    "power_delivered_W": (MEAN_POWER, "delivered", lambda s: s.delivered),
    "power_received_W": (MEAN_POWER, "received", lambda s: s.received),
    "loss_friction_W": (MEAN_POWER, "friction of the rod", lambda s: s.friction),
    "stored_power_W": (MEAN_POWER, "stored", lambda s: s.stored),
    "efficiency": (EFFICIENCY, "delivered over drawn minus returned", lambda s: s.delivered / (s.drawn - s.returned)),
    "pressure_max_Pa": (GAUGE_PRESSURE, "highest", lambda s: s.pressure_max),
    "pressure_min_Pa": (GAUGE_PRESSURE, "low side, lowest", lambda s: s.pressure_min),
    "charge_pressure_Pa": (GAUGE_PRESSURE, "charge pressure", lambda s: s.charge),
    "energy_residual": (NUMBER, "energy residual", lambda s: s.energy_residual),
    "mass_residual": (NUMBER, "oil residual", lambda s: s.mass_residual),
}
"""Kind, label and value of each figure of a score."""
SHOWN = (
    "circuit",
    "tracking_error_rms_m",
    "tracking_error_max_m",
    "power_drawn_W",
    "power_returned_W",
    "power_delivered_W",
    "power_received_W",
    *(sink.key for sink in SINKS),
    "pressure_max_Pa",
    "pressure_min_Pa",
)
PARTS = {"power_delivered_W": "to the load", "power_returned_W": "back to the drive"} | dict(SINKS)
"""Where power goes, and what a user calls it, in the order in which it is drawn."""
COLOURS = (
    Colour.GREEN,
    Colour.OLIVE,
    Colour.RELIEF,
    Colour.INLET,
    Colour.FAINT,
    Colour.RED,
    Colour.PURPLE,
    Colour.TANK,
    Colour.INK,
    Colour.TEAL,
    Colour.LOAD,
)
TRACES = (Colour.LOAD, Colour.INLET, Colour.GREEN, Colour.PURPLE, Colour.RED, Colour.OLIVE, Colour.TANK, Colour.RELIEF)


def circuit_result(found: CircuitComparison) -> Result:
    """The result of a comparison of circuits."""
    scores = _score_table(found)
    charts = {chart.name: chart for chart in _charts(found, scores)}
    return Result(
        verb="compare circuits",
        title="Circuits that move a cylinder",
        system="",
        manner=MANNER,
        conditions={name: _condition(duty) for name, duty in found.duties.items()},
        numbers=_numbers(found),
        tables={
            SCORES: scores,
            "circuits": _circuit_table(found),
            "front": _front_table(found),
            "shares": _share_table(scores),
            **dict(_trace_tables(found)),
        },
        charts=charts,
        findings=tuple(_findings(found)),
        sections=(
            Section(title="Where the power goes", words=(MANNER,), shows=("conditions", *charts)),
            Section(title="Cycle by cycle", words=(DEFINITIONS,), shows=(SCORES,), starts_page=True),
            Section(title="Error versus power", words=(FRONT,), shows=("front",)),
            Section(title="The circuits", shows=("circuits",)),
        ),
        seconds=found.seconds,
        finished=found.finished,
    )


def errors_in_mm(result: Result) -> dict[str, list[float]]:
    """The rms error of each run [mm], to be compared at a glance."""
    return {"error_rms_mm": [1e3 * float(each) for each in result.tables[SCORES]["tracking_error_rms_m"]]}


def _numbers(found: CircuitComparison) -> dict[str, Number]:
    """How many runs were made, and at which error circuits are compared."""
    numbers = {"runs": Number(float(found.runs), COUNT, "runs that were made")}
    if found.error is not None:
        numbers["compared_error_rms_m"] = Number(found.error, LENGTH, "rms error at which all are compared")
    return numbers


def screen_tables(found: CircuitComparison, result: Result) -> dict[str, Table]:
    """Results of each circuit on each duty, in a table of its own, without losses that none has."""
    scores, tables = result.tables[SCORES], {}
    for name, duty in found.duties.items():
        here = scores["cycle"] == name
        if not np.any(here):
            continue
        columns = {
            key: Column(column.values[here], column.kind, column.label, column.symbol)
            for key, column in scores.columns.items()
        }
        shown = tuple(
            key for key in SHOWN if not key.startswith("loss_") or np.any(np.asarray(columns[key].values, float) > 0.0)
        )
        tables[name] = Table(title=f"{name}: {_condition(duty)}", columns=columns, shown=shown)
    return tables


def _condition(duty: Duty) -> str:
    relief = number(1e-5 * duty.relief_pressure, 3)
    return f"{duty.title}; {duty.load}; relief valves at {relief} bar"


def _score_table(found: CircuitComparison) -> Table:
    """A row for each run; of one that broke off all figures are NaN."""
    runs = [(run, run.score) for run in found.found]
    columns = {
        "cycle": Column(np.array([run.duty for run, _ in runs]), None, "cycle"),
        "circuit": Column(np.array([run.circuit for run, _ in runs]), None, "circuit"),
    }
    for key, (kind, label, value) in FIGURES.items():
        columns[key] = Column(np.array([np.nan if s is None else value(s) for _, s in runs]), kind, label)
    rates = [run.tried[run.kept].filter_rate if run.tried else np.nan for run, _ in runs]
    columns["filter_rate_1_s"] = Column(np.array(rates), RATE, "poles before the loop")
    for place, sink in enumerate(SINKS):
        losses = np.array([np.nan if s is None else s.sinks[place] for _, s in runs])
        columns[sink.key] = Column(losses, MEAN_POWER, sink.label)
    columns["account"] = Column(np.array(["" if s is None else _account(s) for _, s in runs]), None, "in")
    return Table(title="Cycle by cycle", columns=columns, shown=("cycle", *SHOWN))


def _front_table(found: CircuitComparison) -> Table:
    """A row for each try of each run."""
    tried = [(run, attempt) for run in found.found for attempt in run.tried]
    columns = {
        "cycle": Column(np.array([run.duty for run, _ in tried]), None, "cycle"),
        "circuit": Column(np.array([run.circuit for run, _ in tried]), None, "circuit"),
        "filter_rate_1_s": Column(np.array([each.filter_rate for _, each in tried]), RATE, "poles before the loop"),
        "error_rms_m": Column(np.array([each.error for _, each in tried]), LENGTH, "error, rms"),
        "power_net_W": Column(np.array([each.power for _, each in tried]), MEAN_POWER, "drawn minus returned"),
    }
    return Table(title="Error versus power", columns=columns)


def _account(score: CircuitScore) -> str:
    """What came in, as it stands behind a bar."""
    came = f"{number(score.drawn, 3)} W drawn"
    return came + (f" + {number(score.received, 3)} W from the load" if score.received > 0.0 else "")


def _circuit_table(found: CircuitComparison) -> Table:
    circuits = found.circuits.values()
    columns = {
        "name": Column(np.array([each.name for each in circuits]), None, "circuit"),
        "title": Column(np.array([each.title for each in circuits]), None, "what it is"),
        "system": Column(np.array([each.system for each in circuits]), None, "system"),
    }
    return Table(title="The circuits", columns=columns)


def _trace_tables(found: CircuitComparison) -> Iterator[tuple[str, Table]]:
    """The last round of each run, a table each."""
    for run in found.found:
        if run.trace is None:
            continue
        trace = run.trace
        columns = {
            "time_s": Column(trace.time, DURATION, "time", "t"),
            "reference_m": Column(trace.reference, POSITION, "reference"),
            "position_m": Column(trace.position, POSITION, "position"),
            "error_m": Column(trace.position - trace.reference, POSITION, "position minus reference"),
            "pressure_a_Pa": Column(trace.pressure_a, GAUGE_PRESSURE, "pressure of chamber A"),
            "pressure_b_Pa": Column(trace.pressure_b, GAUGE_PRESSURE, "pressure of chamber B"),
        }
        yield _trace_name(run.duty, run.circuit), Table(title="Last round", columns=columns, is_data=True)


def _trace_name(duty: str, circuit: str) -> str:
    return f"trace-{duty}-{circuit}"


def _charts(found: CircuitComparison, scores: Table) -> Iterator[Chart]:
    for name, duty in found.duties.items():
        rows = tuple(np.flatnonzero((scores["cycle"] == name) & np.isfinite(scores["power_drawn_W"])).tolist())
        if rows:
            yield from _power_charts(name, duty, scores, rows)
            yield _error_chart(name, duty, [str(scores["circuit"][row]) for row in rows])


def _power_charts(name: str, duty: Duty, scores: Table, rows: tuple[int, ...]) -> Iterator[Chart]:
    """Where the power went, a bar for each circuit: what is useful first, then every loss; in watts, and in shares."""
    used = [key for key in PARTS if np.any(np.asarray(scores[key], float)[list(rows)] > 0.0)]
    watts = Bars(
        names="circuit",
        values=tuple(used),
        labels=tuple(PARTS[key] for key in used),
        colours=tuple(colour for key, colour in zip(PARTS, COLOURS, strict=True) if key in used),
        texts="account",
        label="mean power",
        rows=rows,
        stacked=True,
    )
    shares = replace(watts, values=tuple(map(_share_key, used)), label="share of what came in", texts="sum")
    height = 1.3 + 0.26 * len(rows)
    caption = (
        f"Where the power goes on {name} ({duty.load}), means over a round. Behind a bar stands where what it holds "
        "came from: the drives of the pumps, and the load while it overruns."
    )
    yield Chart(name=f"powers-{name}", caption=caption, table=SCORES, panels=(watts,), height=height)
    caption = f"The same on {name} ({duty.load}) as shares of all that came in."
    yield Chart(name=f"shares-{name}", caption=caption, table="shares", panels=(shares,), height=height)


def _share_key(key: str) -> str:
    return f"share_{key.removesuffix('_W')}"


def _share_table(scores: Table) -> Table:
    """Every part of what came in, over what came in."""
    total = np.asarray(scores["power_drawn_W"], float) + np.asarray(scores["power_received_W"], float)
    columns = {
        "cycle": scores.columns["cycle"],
        "circuit": scores.columns["circuit"],
        "sum": Column(np.array([f"of {number(each, 3)} W" for each in total]), None, "in"),
    }
    for key, label in PARTS.items():
        columns[_share_key(key)] = Column(np.asarray(scores[key], float) / total, EFFICIENCY, label)
    return Table(title="Shares of what came in", columns=columns, is_data=True)


def _error_chart(name: str, duty: Duty, circuits: list[str]) -> Chart:
    """Position error and chamber pressures over the last round."""
    tables = [_trace_name(name, circuit) for circuit in circuits]
    colours = [TRACES[place % len(TRACES)] for place in range(len(circuits))]
    whose = list(zip(tables, circuits, colours, strict=True))
    errors = tuple(Line(x="time_s", y="error_m", table=t, label=c, colour=each) for t, c, each in whose)
    path = Line(x="time_s", y="reference_m", label="reference", colour=Colour.INK)
    panels = (
        Lines(lines=(path,), label="reference", height=0.7),
        Lines(lines=errors, label="position minus reference", height=1.3),
        *(
            Lines(
                lines=tuple(
                    Line(x="time_s", y=f"pressure_{side}_Pa", table=t, label=c, colour=each) for t, c, each in whose
                ),
                label=f"chamber {side.upper()}",
            )
            for side in "ab"
        ),
    )
    caption = f"The last round of {name} ({duty.load}): reference, error of the position, pressures of both chambers."
    return Chart(name=f"course-{name}", caption=caption, table=tables[0], panels=panels, height=6.4)


def _findings(found: CircuitComparison) -> Iterator[Finding]:
    if not found.finished:
        text = f"{found.runs} of {found.all_runs} runs were made"
        if found.untuned:
            text += f", {found.runs - len(found.untuned)} of them at the common error: powers are not yet at one error"
        yield Finding(text=f"{text}.", grade=Grade.WARNING, title="Not all runs were made")
    for run in found.found:
        yield from _warnings(f"{run.circuit} on {run.duty}", run.score, run.failure)
        yield from _other_error(run, found.error)
    for name, duty in found.duties.items():
        scores = {run.circuit: run.score for run in found.found if run.duty == name and run.score is not None}
        if scores:
            yield Finding(text=_summary(name, duty, scores))


def _other_error(run: CircuitRun, wanted: float | None) -> Iterator[Finding]:
    """That a circuit cannot be brought to the error at which all are compared, and the closest that it comes."""
    if wanted is not None and run.tried and not is_reached(run.tried[run.kept].error, wanted, EQUAL):
        reached, asked = (number(1e3 * each, 3) for each in (run.tried[run.kept].error, wanted))
        what = f"{run.circuit} on {run.duty}"
        text = f"{what} comes to an rms error of {reached} mm, not to the {asked} mm of the others."
        yield Finding(text=text, grade=Grade.WARNING, title="The error is another one")


def _warnings(what: str, score: CircuitScore | None, failure: str) -> Iterator[Finding]:
    if score is None:
        yield Finding(text=f"{what}: {failure}", grade=Grade.BAD, title="A run broke off")
        return
    if max(abs(score.energy_residual), abs(score.mass_residual)) > LIMIT:
        text = f"{what}: {score.energy_residual:.1e} of the energy, {score.mass_residual:.1e} of the oil."
        yield Finding(text=text, grade=Grade.BAD, title="The balances do not close")
    if score.tracking_max > LOST:
        text = f"{what} is off by up to {number(1e3 * score.tracking_max, 3)} mm."
        yield Finding(text=text, grade=Grade.WARNING, title="The rod is off")
    if score.pressure_min < score.charge - MARGIN:
        text = (
            f"{what}: {number(1e-5 * score.pressure_min, 3)} bar, where {number(1e-5 * score.charge, 3)} bar are held."
        )
        yield Finding(text=text, grade=Grade.WARNING, title="The low side falls")


def _summary(name: str, duty: Duty, scores: Mapping[str, CircuitScore]) -> str:
    """What each circuit draws on a duty, and gets back, for what it delivers."""
    delivered = number(float(np.mean([score.delivered for score in scores.values()])), 3)
    told = (
        f"{circuit} {number(score.drawn, 4)} W"
        + (f" less {number(score.returned, 3)} W returned" if score.returned > 0.5 else "")
        for circuit, score in scores.items()
    )
    return f"{name[0].upper()}{name[1:]} ({duty.load}): for {delivered} W delivered to the rod, {', '.join(told)}."
