"""Additions of a run of a test rig of the rotary valve to those of any run."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    DURATION,
    DUTY_RATIO,
    FLOW,
    FRACTION,
    FREQUENCY,
    GAUGE_PRESSURE,
    MEAN_POWER,
    NUMBER,
    SIGNED_PRESSURE,
    SPEED,
    Kind,
)
from vvdp.base.signal import signal_value
from vvdp.estimation.estimator import Estimate
from vvdp.evaluation.bench import BenchSeries, RotaryBench
from vvdp.evaluation.bench_report import BenchReport
from vvdp.numerics.spectrum import line_spectrum
from vvdp.programs.estimate_report import STATED, UNITS, ShaftWatch, estimate_errors, of_what
from vvdp.results.result import Column, Finding, Grade, Listing, Row, Table
from vvdp.runs.run import RecordedRun
from vvdp.runs.tables import without_dust
from vvdp.sensing.encoder import Shaft

COMPONENTS = {
    "nozzle": "nozzles",
    "centre_section": "centre section",
    "outlet_turbine": "outlet turbine",
    "relief_valve": "relief valve",
    "valve_leakage": "valve leakage",
    "pump_leakage": "pump leakage",
    "pump_friction": "pump friction",
    "pump_compression": "pump filling",
    "coupling": "spool coupling",
}
PUMP_AND_COUPLING = frozenset({"pump_leakage", "pump_friction", "pump_compression", "coupling"})
FEWEST_SAMPLES = 64
"""Fewest samples from which a spectrum is drawn."""
SAME = 1e-9
"""Relative difference below which two losses are the same."""
HARMONICS = 10


class Loss(NamedTuple):
    """A mean power lost [W]; `analytic` is nan where there is no formula."""

    name: str
    simulated: float
    analytic: float = np.nan


def _loss_names(run: RecordedRun) -> dict[str, str]:
    """Those of the losses that the run's books have: a pump has one more where its values ask for it."""
    absent = {"pump_compression"} if "loss_pump_compression_W" not in run.summary else set()
    return {key: name for key, name in COMPONENTS.items() if key not in absent}


def components(run: RecordedRun) -> tuple[Loss, ...]:
    """Simulated losses by component. The spool's friction is fed from the valve's drops and not a loss beside them."""
    return tuple(Loss(name, run.number(f"loss_{key}_W")) for key, name in _loss_names(run).items())


def causes(run: RecordedRun) -> tuple[Loss, ...]:
    """The losses as the analytic formulas divide them.

    In the simulation, compressing the inlet volume costs throttling power: it is part of the transition there.
    """

    def analytic(key: str) -> float:
        return run.number(f"analytic_loss_{key}_W")

    other = sum(run.number(f"loss_{key}_W") for key in _loss_names(run) if key in PUMP_AND_COUPLING)
    both = analytic("transition") + analytic("compressibility")
    return (
        Loss("fully open valve", run.number("loss_full_open_W"), analytic("full_open")),
        Loss("transition and compression", run.number("loss_transition_W"), both),
        Loss("valve leakage", run.number("loss_valve_leakage_W"), analytic("leakage")),
        Loss("pump and coupling", other, analytic("pump")),
    )


def bench_loss_listings(run: RecordedRun) -> dict[str, Listing]:
    """Losses by component, and by cause beside the analytic ones, with shares of the input power."""
    whole = run.number("input_power_W") + run.number("spool_motor_power_W")
    total = run.number("loss_total_W")
    spool = run.number("loss_spool_friction_W") - run.number("spool_shaft_power_W")
    parts = (*components(run), Loss("spool friction not covered by the flow", spool))
    stored = Loss("stored in oil and spool", total - sum(part.simulated for part in parts))
    both = Loss("input power minus load power", total, run.number("analytic_loss_total_W"))

    def row(loss: Loss, *values: float, is_sum: bool = False, is_part: bool = False) -> Row:
        share = f"{100.0 * loss.simulated / whole:.2f} %" if whole > 0.0 and np.isfinite(loss.simulated) else ""
        shown = tuple(None if np.isnan(value) else without_dust(value, whole) for value in values)
        return Row(loss.name, MEAN_POWER, shown, note=share, is_sum=is_sum, is_part=is_part)

    by_component = [*(row(loss, loss.simulated) for loss in (*parts, stored)), row(both, both.simulated, is_sum=True)]
    by_cause = []
    for loss in causes(run):
        by_cause.append(row(loss, loss.simulated, loss.analytic, _difference(loss)))
        if loss.name.startswith("transition"):
            for name, key in (("of which transition", "transition"), ("of which compression", "compressibility")):
                analytic = run.number(f"analytic_loss_{key}_W")
                by_cause.append(row(Loss(name, np.nan), np.nan, analytic, np.nan, is_part=True))
    by_cause.append(row(both, both.simulated, both.analytic, _difference(both), is_sum=True))
    heads = ("simulated", "analytic", "difference")
    note = "Shares are of the input power."
    return {
        "losses_by_component": Listing(title="By component", heads=("mean",), rows=tuple(by_component), note=note),
        "losses_by_cause": Listing(title="By cause", heads=heads, rows=tuple(by_cause)),
    }


def _difference(loss: Loss) -> float:
    """Simulated less analytic [W]; none where it is rounding alone."""
    difference = loss.simulated - loss.analytic
    return 0.0 if abs(difference) < SAME * abs(loss.simulated) else difference


def analytic_words(run: RecordedRun, bench: BenchReport) -> Iterator[str]:
    """Notes on the analytic losses beside the simulated ones."""
    if "analytic_loss_total_W" not in run.summary:
        needs = (
            "they need a running pump, a load pressure above the tank's, a spool that the flow alone turns, and "
            "nothing prescribed that changes"
        )
        yield f"There are no analytic losses here: {'; '.join(bench.closed_form_limits(run.summary)) or needs}."
        return
    yield (
        "The analytic formulas count volumes (the oil keeps its volume under pressure), with ideal conditions: "
        "constant load pressure, a relief valve without lag, ports that open at constant speed. Differences of a few "
        "per cent are to be expected. Their sum is an upper estimate, because part of the compression happens while "
        "flow would be lost over the relief valve anyway. In the simulation compression shows as throttling, so it is "
        "part of the transition."
    )


def limit_findings(run: RecordedRun, bench: BenchReport) -> Iterator[Finding]:
    """Why there are no analytic results beside the simulated ones, where one would expect some."""
    for limit in bench.closed_form_limits(run.summary):
        text = f"They do not hold here: {limit}."
        yield Finding(grade=Grade.WARNING, title="No analytic results beside the simulated ones", text=text)


def bench_series(run: RecordedRun, bench: RotaryBench) -> Table:
    """What a bench does over the recorded rows; means of each PWM period are held over it."""
    series = bench.series(run.state, run.output)
    sections, area = bench.valve.sections, bench.valve.nozzle_area
    marks = run.record.mark_times
    frequency = 1.0 / np.diff(marks) if marks.size > 1 else np.zeros(0)
    at: Any = run.times  # the formula is written for floats and works on arrays too
    duty = np.zeros(run.times.size) + signal_value(at, bench.duty_ratio)
    columns = {
        "time_s": Column(run.times, DURATION, "time", "t"),
        **_pressures_and_flows(series, bench, area),
        "pwm_frequency_Hz": Column(series.spool_speed * sections / (2.0 * np.pi), FREQUENCY, "PWM frequency", "f"),
        "pwm_frequency_mean_Hz": Column(
            run.record.over_periods(frequency), FREQUENCY, "PWM frequency, mean of each period"
        ),
        "load_flow_mean_m3_s": _mean(run, bench.LOAD_FLOW_TOTAL, 0.0, FLOW, "to load, mean of each period"),
        "inlet_pressure_mean_Pa": _mean(
            run, bench.INLET_TOTAL, bench.reference, GAUGE_PRESSURE, "inlet, mean of each period"
        ),
        "duty_ratio": Column(duty, DUTY_RATIO, "duty ratio", "d"),
    }
    if bench.watch:
        columns |= _estimate(run, bench.watch, series)
    return Table(title="Recorded series", columns=columns, is_data=True)


def _pressures_and_flows(series: BenchSeries, bench: RotaryBench, area: float) -> dict[str, Column]:
    return {
        "inlet_pressure_Pa": Column(series.inlet_pressure - bench.reference, GAUGE_PRESSURE, "inlet"),
        "load_pressure_Pa": Column(series.load_pressure - bench.reference, GAUGE_PRESSURE, "load"),
        "pump_flow_m3_s": Column(series.pump_flow, FLOW, "pump"),
        "load_flow_m3_s": Column(series.load_flow, FLOW, "to load"),
        "tank_flow_m3_s": Column(series.tank_flow, FLOW, "to tank"),
        "relief_flow_m3_s": Column(series.relief_flow, FLOW, "relief valve"),
        "load_port_m2": Column(area * series.load_opening, AREA, "load port"),
        "tank_port_m2": Column(area * series.tank_opening, AREA, "tank port"),
    }


def _mean(run: RecordedRun, total: str, datum: float, kind: Kind, label: str) -> Column:
    means = run.record.period_means(total) - datum if run.record.mark_times.size > 1 else np.zeros(0)
    return Column(run.record.over_periods(means), kind, label)


def _estimate(run: RecordedRun, watch: ShaftWatch, series: BenchSeries) -> dict[str, Column]:
    """The spool as its encoder sees it, its errors, and two stated standard deviations around none."""
    shown = {name: run.command(f"{watch.filter}.{name}") for name in Estimate._fields}
    sampled = {name: run.memory(f"{watch.encoder}.{name}") for name in Shaft._fields}
    pitch = watch.pitch
    errors = estimate_errors(shown, sampled, pitch)
    found = {"spool_speed_rad_s": Column(series.spool_speed, SPEED, f"true speed{of_what(0.0)}")}
    if pitch > 0.0:
        found["spool_speed_mean_rad_s"] = Column(errors.true_speed, SPEED, f"true speed{of_what(pitch)}")
    found["estimated_speed_rad_s"] = Column(shown["speed"], SPEED, f"estimated speed{of_what(pitch)}")
    for name, words, error in (("angle", "angle", errors.angle), ("speed", f"speed{of_what(pitch)}", errors.speed)):
        kind, unit = UNITS[name]
        found[f"{name}_error_{unit}"] = Column(error, kind, f"error of the {words}")
        for end, sign in (("low", -STATED), ("high", STATED)):
            band: Array = sign * shown[f"{name}_deviation"]
            found[f"{name}_band_{end}_{unit}"] = Column(band, kind, f"two stated standard deviations of the {words}")
    found["standstill"] = Column(shown["standstill"], FRACTION, "probability that the spool stands")
    return found


def cycle_table(run: RecordedRun, bench: RotaryBench, series: Table) -> Table | None:
    """The last whole periods over the spool's angle within one; None where there is none. Lines are broken between."""
    part = run.detail()
    if not part.periods:
        return None
    pitch = 2.0 * np.pi / bench.valve.sections
    angle = np.mod(bench.series(run.state, run.output).spool_angle[part.rows], pitch)
    breaks = np.flatnonzero(np.abs(np.diff(angle)) > 0.5 * pitch) + 1
    shown = ("inlet_pressure_Pa", "load_pressure_Pa", "pump_flow_m3_s", "load_flow_m3_s", "tank_flow_m3_s",
             "relief_flow_m3_s", "load_port_m2", "tank_port_m2")  # fmt: skip
    columns = {"angle_rad": Column(np.insert(angle, breaks, np.nan), ANGLE, "spool angle within the PWM period")}
    for key in shown:
        column = series.columns[key]
        values = np.insert(np.asarray(column.values, float)[part.rows], breaks, np.nan)
        columns[key] = Column(values, column.kind, column.label)
    return Table(title="The last PWM periods over the spool angle", columns=columns, is_data=True)


def spectrum_table(run: RecordedRun, series: Table, bench: RotaryBench) -> Table | None:
    """Amplitudes of the load pressure, or the inlet's where the load is held, over whole PWM periods; None without."""
    part = run.fine()
    if part.rows.size < FEWEST_SAMPLES or not run.is_fine or not part.periods:
        return None
    name = "load" if bench.makes_pressure else "inlet"
    samples = 2 ** int(np.ceil(np.log2(part.rows.size)))
    begin, end = part.marks[0], part.marks[-1]
    even = begin + (end - begin) * np.arange(samples) / samples
    pressure = np.interp(even, run.times, series[f"{name}_pressure_Pa"])
    found = line_spectrum(pressure, float(end - begin) / samples)
    shown = slice(1, min((HARMONICS + 1) * part.periods, found.frequencies.size))
    order = np.arange(1, shown.stop) / part.periods
    columns = {
        "frequency_Hz": Column(found.frequencies[shown], FREQUENCY, "frequency"),
        "amplitude_Pa": Column(found.amplitudes[shown], SIGNED_PRESSURE, f"amplitude of the {name} pressure"),
        "order": Column(order, NUMBER, "order"),
    }
    return Table(title="Spectrum", columns=columns, is_data=True)


def harmonic_listing(spectrum: Table) -> Listing:
    """The amplitudes at the multiples of the PWM frequency."""
    whole = np.flatnonzero(spectrum["order"] % 1.0 == 0.0)
    rows = tuple(
        Row(f"{spectrum['order'][i]:.0f} × PWM frequency", SIGNED_PRESSURE, (float(spectrum["amplitude_Pa"][i]),),
            note=f"{spectrum['frequency_Hz'][i]:.4g} Hz")
        for i in whole
    )  # fmt: skip
    return Listing(title=f"Harmonics: {spectrum.columns['amplitude_Pa'].label}", heads=("amplitude",), rows=rows)


def loss_table_columns(losses: tuple[Loss, ...]) -> Mapping[str, tuple[float, ...]]:
    """Simulated and, where there are any, analytic powers by column."""
    found = {"simulated": tuple(loss.simulated for loss in losses)}
    if any(np.isfinite(loss.analytic) for loss in losses):
        found["analytic"] = tuple(loss.analytic for loss in losses)
    return found
