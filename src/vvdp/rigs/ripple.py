"""Pressure ripple of the load line over duty ratio, PWM frequency and accumulator, in the manner of ISO 10767."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.volume import Vessel, pressure_rate
from vvdp.rigs.conditions import BAR, conditions, gauge
from vvdp.rigs.result import Column, RigResult, Sheet
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
    "Pressure ripple in the manner of ISO 10767: amplitudes of the harmonics of the PWM frequency in the load line and "
    "in the delivered flow, with peak-to-peak and root mean square values. Every point is a periodic steady state "
    "found by shooting, recorded over one period, so that the harmonics are exact. The load orifice is sized anew to "
    "hold the mean load pressure."
)
LEFT_OUT = (
    "The source impedance: the standard finds source flow and impedance from two lines; here one lumped line is there.",
    "Waves in the line: it is one volume, right for frequencies whose wave length is far above its length.",
    "The pump's own flow ripple.",
    "The lag of the relief valve, unless it has an opening time.",
)


def line_capacity(pressure: float, stand: Stand) -> float:
    """Tank volume that the load line takes in over the pressure that it gains [m^3/Pa].

    pressure  absolute [Pa]

    Source  ours, docs/rigs.md
    """
    oil, line = stand.bench.oil, load_line(stand)
    rate = pressure_rate(1.0, 0.0, pressure, fluid_state(pressure, oil), line, oil.reference_pressure)
    return float(1.0 / rate)


def load_line(stand: Stand) -> Vessel:
    """The load line of a stand. Raises ParameterError where it has none whose pressure could ripple."""
    if stand.bench.load_line is None:
        raise ParameterError(
            f"{stand.name}: a source holds the load pressure, so it does not ripple; expected a system with a "
            "load line, such as prototype"
        )
    return stand.bench.load_line


def estimated_ripple(delivered: float, pump_flow: float, pwm_frequency: float, capacity: float) -> float:
    """Peak-to-peak pressure of a line that is filled in pulses and emptied evenly, q (1 - q/Q) / (f C) [Pa].

    Pulses of the pump flow Q last q/(Q f), and more than the load takes flows in by Q - q meanwhile.

    delivered, pump_flow  mean [m^3/s]
    pwm_frequency         [Hz]
    capacity              of the line [m^3/Pa]

    Source  ours, docs/rigs.md
    """
    return delivered * (1.0 - delivered / pump_flow) / (pwm_frequency * capacity)


def with_gas(stand: Stand, size: float) -> Stand:
    """The stand with an accumulator of `size` times its own gas volume [1].

    Where it has none, `NO_ACCUMULATOR` is taken for that, and half the load pressure for a precharge that is missing.
    """
    line = load_line(stand)
    gas, precharge = line.gas_volume or NO_ACCUMULATOR, line.precharge_pressure or 0.5 * stand.set_point.load_pressure
    return stand.changed(load_line={"gas_volume": size * gas, "precharge_pressure": precharge})


def ripple(
    stand: Stand,
    duty_ratios: Sequence[float] = DUTY_RATIOS,
    frequencies: Sequence[float] = FREQUENCIES,
    sizes: Sequence[float] = SIZES,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> RigResult:
    """Ripple over duty ratio, over PWM frequency [Hz] with a driven spool, and over the accumulator's gas volume.

    Raises ParameterError where the system has no load line whose pressure could ripple.

    Source  ours, docs/rigs.md, in the manner of iso10767
    """
    began = time.perf_counter()
    load_line(stand)
    here = stand.set_point
    groups: dict[str, list[tuple[Stand, SetPoint]]] = {
        "duty": [(stand, here._replace(duty_ratio=float(d))) for d in duty_ratios],
        "frequency": [(stand.driven(float(f)), here) for f in frequencies],
        "accumulator": [(with_gas(stand, size), here) for size in sizes],
        "set point": [(stand, here)],
    }
    flat = [item for group in groups.values() for item in group]
    states = steady_states(flat, cores=cores, cache=cache, say=say)
    waves = [waveform(state, cache=cache) if state.reason is None else None for state in states]
    sheets, place = {}, 0
    titles = {
        "duty": "Ripple over duty ratio, spool as the system has it",
        "frequency": "Ripple over PWM frequency, spool driven by a motor",
        "accumulator": "Ripple over the accumulator's gas volume",
    }
    for name, group in groups.items():
        part = slice(place, place + len(group))
        place += len(group)
        if name in titles:
            sheets[name] = Sheet(titles[name], _columns(states[part], waves[part]))
    centre, wave = states[-1], waves[-1]
    if wave is None:
        raise ParameterError(f"{stand.name}: no periodic state at the system's own set point: {centre.reason}")
    sheets["spectrum"] = Sheet("Harmonics at the system's set point", _spectrum(wave))
    sheets["waveform"] = Sheet("One period at the system's set point", _wave(wave))
    numbers = _numbers(centre, wave, sheets)
    said = conditions(stand) | {
        "duty ratio": f"{here.duty_ratio:.4g} unless varied",
        "load pressure": f"{gauge(here.load_pressure)} bar, mean, held by the orifice",
    }
    return RigResult(
        rig="ripple",
        title="Pressure ripple",
        system=stand.name,
        manner=MANNER,
        references=("iso10767",),
        conditions=said,
        left_out=LEFT_OUT,
        sheets=sheets,
        numbers=numbers,
        findings=_findings(numbers),
        seconds=time.perf_counter() - began,
    )


def _columns(states: Sequence[Steady], waves: Sequence[Waveform | None]) -> dict[str, Column]:
    rows = [_row(state, wave) for state, wave in zip(states, waves, strict=True)]
    names = {
        "duty_ratio": ("", "duty ratio"),
        "pwm_frequency_Hz": ("Hz", "PWM frequency"),
        "gas_volume_m3": ("m^3", "gas volume"),
        "pressure_mean_load_line_Pa": ("Pa gauge", "mean load pressure"),
        "delivered_flow_m3_s": ("m^3/s", "delivered flow"),
        "load_ripple_Pa": ("Pa", "load, peak to peak"),
        "load_ripple_rms_Pa": ("Pa", "load, rms"),
        "load_first_harmonic_Pa": ("Pa", "load, first harmonic"),
        "estimated_ripple_Pa": ("Pa", "estimated, peak to peak"),
        "inlet_ripple_Pa": ("Pa", "inlet, peak to peak"),
    }
    columns = {name: Column(np.array([row.get(name, np.nan) for row in rows]), *words) for name, words in names.items()}
    columns["remark"] = Column(np.array([state.reason or "" for state in states]), "", "remark")
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


def _spectrum(wave: Waveform) -> dict[str, Column]:
    order = np.arange(1.0, HARMONICS + 1.0)
    return {
        "harmonic": Column(order, "", "harmonic"),
        "frequency_Hz": Column(order / wave.period, "Hz", "frequency"),
        "load_pressure_Pa": Column(harmonics(wave.load_pressure, HARMONICS), "Pa", "load pressure"),
        "inlet_pressure_Pa": Column(harmonics(wave.inlet_pressure, HARMONICS), "Pa", "inlet pressure"),
        "load_flow_m3_s": Column(harmonics(wave.load_flow, HARMONICS), "m^3/s", "flow to the load"),
    }


def _wave(wave: Waveform) -> dict[str, Column]:
    mean: Any = np.mean(wave.load_pressure)
    return {
        "time_s": Column(wave.times, "s", "time"),
        "load_pressure_swing_Pa": Column(wave.load_pressure - mean, "Pa", "load pressure less its mean"),
        "load_flow_m3_s": Column(wave.load_flow, "m^3/s", "flow to the load"),
    }


def power_of(x: Array, y: Array) -> float:
    """Exponent n of the law y = c x^n that comes closest, in logarithms [1]; nan for fewer than two points."""
    known = np.isfinite(x) & np.isfinite(y) & (x > 0.0) & (y > 0.0)
    if np.count_nonzero(known) < 2:
        return np.nan
    return float(np.polyfit(np.log(x[known]), np.log(y[known]), 1)[0])


def _numbers(centre: Steady, wave: Waveform, sheets: dict[str, Sheet]) -> dict[str, float]:
    duty, frequency, size = (sheets[name] for name in ("duty", "frequency", "accumulator"))
    row = _row(centre, wave)
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


def _findings(numbers: dict[str, float]) -> tuple[str, ...]:
    sentences = [
        f"At the system's set point the load pressure swings by {numbers['load_ripple_Pa'] / BAR:.3g} bar from peak to "
        f"peak at {numbers['pwm_frequency_Hz']:.4g} Hz; {100.0 * numbers['first_harmonic_share']:.3g} % of its power "
        f"is in the first harmonic. The estimate q (1 - q/Q) / (f C) gives "
        f"{numbers['estimated_ripple_Pa'] / BAR:.3g} bar."
    ]
    if "worst_duty_ratio" in numbers:
        sentences.append(
            f"It is largest, {numbers['worst_load_ripple_Pa'] / BAR:.3g} bar, at duty ratio "
            f"{numbers['worst_duty_ratio']:.3g}."
        )
    sentences.append(
        f"It goes with the PWM frequency to the power {numbers['frequency_exponent']:.3g} and with the gas volume to "
        f"the power {numbers['gas_volume_exponent']:.3g}."
    )
    return tuple(sentences)
