"""Pressure ripple of the load line over duty ratio, PWM frequency and accumulator, based on ISO 10767."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from vvdp.base import kinds
from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, plain, with_unit
from vvdp.base.errors import ParameterError
from vvdp.evaluation.load_ripple import estimated_ripple, vessel_capacity
from vvdp.hydraulics.volume import Vessel
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Result, Table, numbers_of
from vvdp.rigs.conditions import conditions, validity_findings, within_validity
from vvdp.simulation.link import quiet
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import SetPoint, Stand
from vvdp.steady.waveform import Waveform, harmonics, waveform

DUTY_RATIOS = tuple(float(d) for d in np.round(np.linspace(0.15, 0.95, 9), 6))
FREQUENCIES = (20.0, 30.0, 40.0, 60.0, 80.0, 120.0, 160.0)
SIZES = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0)
"""Gas volumes of the accumulator, over that of the system."""
NO_ACCUMULATOR = 50e-6
"""Gas volume that sizes are taken of where the system has no accumulator [m^3]."""
HARMONICS = 20
MANNER = (
    "Pressure ripple, based on ISO 10767: amplitudes of the harmonics of the PWM frequency in the load line and "
    "in the delivered flow, with peak-to-peak and root mean square values. Every point is a periodic steady state "
    "found by shooting, recorded over one period, so that the harmonics are exact. The load orifice is sized again to "
    "hold the mean load pressure."
)
LEFT_OUT = (
    "The source impedance: the standard finds source flow and impedance from two lines; here one lumped line is there.",
    "Waves in the line: it is one volume, right for frequencies whose wave length is far above its length.",
    "The pump's own flow ripple.",
    "The lag of the relief valve, unless it has an opening time.",
)


SET = ("duty_ratio", "gas_volume_m3")
SWEEPS = {
    "duty": "Ripple over duty ratio, spool as the system has it",
    "frequency": "Ripple over PWM frequency, spool driven by a motor",
    "accumulator": "Ripple over the accumulator's gas volume",
}
"""The tables of the sweeps and their titles."""
COLUMNS = {
    "duty_ratio": (kinds.DUTY_RATIO, "duty ratio"),
    "pwm_frequency_Hz": (kinds.FREQUENCY, "PWM frequency"),
    "gas_volume_m3": (kinds.VOLUME, "gas volume"),
    "pressure_mean_load_line_Pa": (kinds.GAUGE_PRESSURE, "mean load pressure"),
    "delivered_flow_m3_s": (kinds.FLOW, "delivered flow"),
    "load_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "load, peak to peak"),
    "load_ripple_rms_Pa": (kinds.PRESSURE_DIFFERENCE, "load, rms"),
    "load_first_harmonic_Pa": (kinds.PRESSURE_DIFFERENCE, "load, first harmonic"),
    "estimated_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "estimated, peak to peak"),
    "inlet_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "inlet, peak to peak"),
}
QUANTITIES = {
    "load_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "ripple of the load pressure, peak to peak"),
    "load_ripple_rms_Pa": (kinds.PRESSURE_DIFFERENCE, "ripple of the load pressure, rms"),
    "estimated_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "estimated ripple of the load pressure, peak to peak"),
    "inlet_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "ripple of the inlet pressure, peak to peak"),
    "pwm_frequency_Hz": (kinds.FREQUENCY, "PWM frequency"),
    "first_harmonic_share": (kinds.EFFICIENCY, "share of the ripple's power in the first harmonic"),
    "worst_duty_ratio": (kinds.DUTY_RATIO, "duty ratio with the largest ripple"),
    "worst_load_ripple_Pa": (kinds.PRESSURE_DIFFERENCE, "largest ripple of the load pressure"),
    "frequency_exponent": (kinds.NUMBER, "exponent of the PWM frequency in the ripple"),
    "gas_volume_exponent": (kinds.NUMBER, "exponent of the gas volume in the ripple"),
}


def line_capacity(pressure: float, stand: Stand) -> float:
    """Tank volume that the load line takes in over the pressure that it gains [m^3/Pa].

    pressure  absolute [Pa]

    Source  ours, docs/rigs.md
    """
    return vessel_capacity(pressure, load_line(stand), stand.bench.oil)


def load_line(stand: Stand) -> Vessel:
    """The load line of a stand. Raises ParameterError where it has none whose pressure could ripple."""
    if stand.bench.load_line is None:
        raise ParameterError(
            f"{stand.name}: a source holds the load pressure, so it does not ripple; expected a system with a "
            "load line, such as prototype"
        )
    return stand.bench.load_line


def with_gas(stand: Stand, size: float) -> Stand:
    """The stand with an accumulator of `size` times its own gas volume [1].

    Where it has none, `NO_ACCUMULATOR` is taken for that, and half the load pressure for a precharge that is missing.
    """
    line = load_line(stand)
    gas, precharge = line.gas_volume or NO_ACCUMULATOR, line.precharge_pressure or 0.5 * stand.set_point.load_pressure
    return stand.with_tables(load_line={"gas_volume": size * gas, "precharge_pressure": precharge})


def ripple(
    stand: Stand,
    duty_ratios: Sequence[float] = DUTY_RATIOS,
    frequencies: Sequence[float] = FREQUENCIES,
    sizes: Sequence[float] = SIZES,
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Result:
    """Ripple over duty ratio, over PWM frequency [Hz] with a driven spool, and over the accumulator's gas volume.

    Raises ParameterError where the system has no load line whose pressure could ripple.

    Source  ours, docs/rigs.md, based on iso10767
    """
    began = time.perf_counter()
    load_line(stand)
    points = _points(stand, duty_ratios, frequencies, sizes)
    asked = [*(item for group in points for item in group), (stand, stand.set_point)]
    states = steady_states(asked, cores=cores, say=say)
    waves = [waveform(state) if state.reason is None else None for state in states]
    centre, wave = states[-1], waves[-1]
    if wave is None:
        raise ParameterError(f"{stand.name}: no periodic state at the system's own operating point: {centre.reason}")
    tables, place = {}, 0
    for (name, title), group in zip(SWEEPS.items(), points, strict=True):
        part = slice(place, place + len(group))
        tables[name] = Table(title=title, columns=_columns(states[part], waves[part]), axes=SET)
        place += len(group)
    tables |= {"spectrum": _spectrum(wave), "waveform": _wave(wave)}
    numbers = _numbers(_row(centre, wave), wave, tables)
    return Result(
        verb="rig ripple",
        title="Pressure ripple",
        system=stand.name,
        manner=MANNER,
        references=("iso10767",),
        conditions=_conditions(stand),
        left_out=LEFT_OUT,
        tables=tables,
        charts={each.name: each for each in (_sweep_chart(), _spectrum_chart())},
        numbers=numbers_of(numbers, QUANTITIES),
        findings=(*_findings(numbers), *validity_findings(within_validity(states))),
        seconds=time.perf_counter() - began,
    )


def _points(
    stand: Stand, duty_ratios: Sequence[float], frequencies: Sequence[float], sizes: Sequence[float]
) -> list[list[tuple[Stand, SetPoint]]]:
    """Stands and operating points of the three sweeps."""
    here = stand.set_point
    return [
        [(stand, here._replace(duty_ratio=float(d))) for d in duty_ratios],
        [(stand.with_motor(float(f)), here) for f in frequencies],
        [(with_gas(stand, size), here) for size in sizes],
    ]


def _conditions(stand: Stand) -> dict[str, str]:
    here = stand.set_point
    return conditions(stand) | {
        "duty ratio": f"{plain(here.duty_ratio, 4)} unless varied",
        "load pressure": f"{with_unit(here.load_pressure, kinds.PRESSURE_LEVEL)}, mean, held by the orifice",
    }


def _columns(states: Sequence[Steady], waves: Sequence[Waveform | None]) -> dict[str, Column]:
    rows = [_row(state, wave) for state, wave in zip(states, waves, strict=True)]
    columns = {name: Column(np.array([row.get(name, np.nan) for row in rows]), *what) for name, what in COLUMNS.items()}
    columns["remark"] = Column(np.array([state.reason or "" for state in states]), None, "note")
    return columns


def _row(state: Steady, wave: Waveform | None) -> dict[str, float]:
    found = {"duty_ratio": state.point.duty_ratio, "gas_volume_m3": load_line(state.stand).gas_volume}
    if wave is None:
        return found
    summary = state.summary
    delivered, frequency = float(summary["mean_load_flow_m3_s"]), float(summary["pwm_frequency_Hz"])
    mean = float(summary["pressure_mean_load_line_Pa"])
    capacity = line_capacity(mean + state.stand.reference, state.stand)
    return found | {
        "pwm_frequency_Hz": frequency,
        "pressure_mean_load_line_Pa": mean,
        "delivered_flow_m3_s": delivered,
        "load_ripple_Pa": float(np.ptp(wave.load_pressure)),
        "load_ripple_rms_Pa": float(np.std(wave.load_pressure)),
        "load_first_harmonic_Pa": float(harmonics(wave.load_pressure, 1)[0]),
        "estimated_ripple_Pa": estimated_ripple(delivered, float(summary["mean_pump_flow_m3_s"]), frequency, capacity),
        "inlet_ripple_Pa": float(np.ptp(wave.inlet_pressure)),
    }


def _spectrum(wave: Waveform) -> Table:
    order = np.arange(1.0, HARMONICS + 1.0)
    load, inlet, flow = (
        harmonics(values, HARMONICS) for values in (wave.load_pressure, wave.inlet_pressure, wave.load_flow)
    )
    return Table(
        title="Harmonics at the system's operating point",
        columns={
            "harmonic": Column(order, kinds.COUNT, "harmonic of the PWM frequency"),
            "frequency_Hz": Column(order / wave.period, kinds.FREQUENCY, "frequency"),
            "load_pressure_Pa": Column(load, kinds.PRESSURE_DIFFERENCE, "load pressure"),
            "inlet_pressure_Pa": Column(inlet, kinds.PRESSURE_DIFFERENCE, "inlet pressure"),
            "load_flow_m3_s": Column(flow, kinds.FLOW, "flow to the load"),
        },
    )


def _wave(wave: Waveform) -> Table:
    swing = wave.load_pressure - float(np.mean(wave.load_pressure))
    return Table(
        title="One period at the system's operating point",
        columns={
            "time_s": Column(wave.times, kinds.TIME, "time"),
            "load_pressure_swing_Pa": Column(swing, kinds.SIGNED_PRESSURE, "load pressure less its mean"),
            "load_flow_m3_s": Column(wave.load_flow, kinds.FLOW, "flow to the load"),
        },
        is_data=True,
    )


def ripple_panel(table: str, x: str, label: str = "") -> Lines:
    """The ripple in a table of a sweep over its column `x`, simulated and estimated."""
    return Lines(
        table=table,
        lines=(
            Line(x=x, y="estimated_ripple_Pa", label="estimate", colour=Colour.FAINT, stroke=Stroke.DASHED, width=1.8),
            Line(x=x, y="load_ripple_Pa", label="simulated", colour=Colour.LOAD, stroke=Stroke.MARKED),
        ),
        label=label,
        low=0.0,
        left=0.0,
    )


def _sweep_chart() -> Chart:
    over = {"duty": "duty_ratio", "frequency": "pwm_frequency_Hz", "accumulator": "gas_volume_m3"}
    return Chart(
        name="ripple",
        caption="Peak-to-peak ripple of the load pressure over duty ratio, PWM frequency (spool driven by a motor) and "
        "gas volume of the accumulator. Dashed: the estimate q (1 - q/Q) / (f C).",
        table="duty",
        panels=tuple(ripple_panel(table, x, "load, peak to peak") for table, x in over.items()),
        side_by_side=True,
        height=2.6,
    )


def _spectrum_chart() -> Chart:
    inlet, load = (
        Line(x="harmonic", y=f"{name}_pressure_Pa", label=name, colour=colour, stroke=Stroke.POINTS)
        for name, colour in (("inlet", Colour.INLET), ("load", Colour.LOAD))
    )
    wave = Line(x="time_s", y="load_pressure_swing_Pa", colour=Colour.LOAD)
    return Chart(
        name="harmonics",
        caption="One period at the system's operating point, and the harmonics of the pressures there.",
        table="spectrum",
        panels=(
            Lines(table="waveform", lines=(wave,)),
            Lines(lines=(inlet, load), label="amplitude", y_log=True, left=0.0, right=HARMONICS + 1.0),
        ),
        side_by_side=True,
        height=2.6,
    )


def power_of(x: Array, y: Array) -> float:
    """Exponent n of the law y = c x^n that comes closest, in logarithms [1]; nan for fewer than two points."""
    known = np.isfinite(x) & np.isfinite(y) & (x > 0.0) & (y > 0.0)
    if np.count_nonzero(known) < 2:
        return np.nan
    return float(np.polyfit(np.log(x[known]), np.log(y[known]), 1)[0])


def _numbers(row: Mapping[str, float], wave: Waveform, tables: Mapping[str, Table]) -> dict[str, float]:
    """Numbers of the system's own operating point (`row`) and of the sweeps."""
    duty, frequency, size = (tables[name] for name in SWEEPS)
    first = harmonics(wave.load_pressure, HARMONICS)
    found = {name: row[name] for name in (
        "load_ripple_Pa", "load_ripple_rms_Pa", "estimated_ripple_Pa", "inlet_ripple_Pa", "pwm_frequency_Hz"
    )}  # fmt: skip
    found["first_harmonic_share"] = float(first[0] ** 2 / np.sum(first**2))
    if np.isfinite(duty["load_ripple_Pa"]).any():
        worst = int(np.nanargmax(duty["load_ripple_Pa"]))
        found["worst_duty_ratio"] = float(duty["duty_ratio"][worst])
        found["worst_load_ripple_Pa"] = float(duty["load_ripple_Pa"][worst])
    found["frequency_exponent"] = power_of(frequency["pwm_frequency_Hz"], frequency["load_ripple_Pa"])
    fitted = size["gas_volume_m3"] > 0.0
    found["gas_volume_exponent"] = power_of(size["gas_volume_m3"][fitted], size["load_ripple_Pa"][fitted])
    return found


def _findings(n: Mapping[str, float]) -> Iterator[Finding]:
    swing, estimate = (
        with_unit(n[key], kinds.PRESSURE_DIFFERENCE, 3) for key in ("load_ripple_Pa", "estimated_ripple_Pa")
    )
    yield Finding(
        text=f"At the system's operating point the load pressure swings by {swing} from peak to peak at "
        f"{with_unit(n['pwm_frequency_Hz'], kinds.FREQUENCY)}; {percent(n['first_harmonic_share'])} of its power is in "
        f"the first harmonic. The estimate q (1 - q/Q) / (f C) gives {estimate}."
    )
    if "worst_duty_ratio" in n:
        largest = with_unit(n["worst_load_ripple_Pa"], kinds.PRESSURE_DIFFERENCE, 3)
        yield Finding(text=f"It is largest, {largest}, at duty ratio {n['worst_duty_ratio']:.3g}.")
    frequency, volume = (number(n[f"{name}_exponent"], 3) for name in ("frequency", "gas_volume"))
    yield Finding(
        text=f"It goes with the PWM frequency to the power {frequency} and with the gas volume to the power {volume}."
    )
