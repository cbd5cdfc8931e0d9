"""The tables of a report on a test bench of the rotary valve, as HTML."""

from collections.abc import Callable, Iterator

from vvdp.report.bench_losses import causes, components, spool_balance
from vvdp.report.html import row, table
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.tables import FORM, RPM
from vvdp.report.wording import fixed
from vvdp.systems.bench import RotaryBench


def key_numbers(reading: Reading, bench: RotaryBench) -> str:
    """Flows, pressures, speeds and powers of a bench in two columns."""
    n = reading.number

    def line(name: str, key: str, scale: float, unit: str, decimals: int) -> str:
        return row([name, fixed(n(key) / scale, decimals), unit], FORM)

    def part(title: str, lines: list[str]) -> str:
        return f"<div><h3>{title}</h3>\n<table><tbody>\n" + "\n".join(lines) + "\n</tbody></table></div>"

    flows = [
        line("Pump flow", "mean_pump_flow_m3_s", LPM, "lpm", 2),
        line("Load flow", "mean_load_flow_m3_s", LPM, "lpm", 2),
        line("Tank flow through the valve", "mean_tank_flow_m3_s", LPM, "lpm", 2),
        line("Relief valve flow", "flow_mean_relief_valve_m3_s", LPM, "lpm", 2),
        line("Valve leakage", "mean_leakage_flow_m3_s", LPM, "lpm", 2),
        line("Load flow over pump flow", "load_flow_fraction", 0.01, "%", 1),
    ]
    pressures = [
        line("Load pressure, mean", "pressure_mean_load_line_Pa", BAR, "bar", 1),
        *(
            line(f"Load pressure, {word}", f"pressure_{key}_load_line_Pa", BAR, "bar", 1)
            for key, word in (("min", "lowest"), ("max", "highest"))
            if bench.makes_pressure
        ),
        line("Inlet pressure, mean", "pressure_mean_inlet_Pa", BAR, "bar", 1),
        line("Inlet pressure, lowest", "pressure_min_inlet_Pa", BAR, "bar", 1),
        line("Inlet pressure, highest", "pressure_max_inlet_Pa", BAR, "bar", 1),
    ]
    low, high = bench.duty_ratio.extremes
    duty = fixed(low, 3) if bench.duty_ratio.is_constant else f"{fixed(low, 3)} to {fixed(high, 3)}"
    valve = [
        line("PWM frequency, mean", "pwm_frequency_Hz", 1.0, "Hz", 2),
        line("Spool speed, mean", "speed_mean_spool_rad_s", RPM, "rpm", 0),
        line("Spool speed, lowest", "speed_min_spool_rad_s", RPM, "rpm", 0),
        line("Spool speed, highest", "speed_max_spool_rad_s", RPM, "rpm", 0),
        row(["Duty ratio, set", duty, ""], FORM),
        line("Load port's open fraction, mean", "mean_load_opening", 1.0, "", 3),
        line("PWM periods averaged", "averaged_periods", 1.0, "", 0),
    ]
    power = [
        line("Input power, pump shaft", "input_power_W", 1.0, "W", 1),
        line("Input power, spool motor", "spool_motor_power_W", 1.0, "W", 1),
        line("Load power", "load_power_W", 1.0, "W", 1),
        line("Input less load power", "loss_total_W", 1.0, "W", 1),
        line("Efficiency", "efficiency", 0.01, "%", 1),
        line("Motor, rated power", "motor_rated_power_W", 1.0, "W", 0),
    ]
    parts = [part("Flows, mean", flows), part("Power, mean", power), part("Pressures", pressures), part("Valve", valve)]
    return '<div class="columns">\n' + "\n".join(parts) + "\n</div>"


def loss_tables(reading: Reading) -> str:
    """Losses by component and by cause, the latter beside the analytic ones."""
    whole = reading.number("input_power_W") + reading.number("spool_motor_power_W")
    share: Callable[[float], str] = lambda power: fixed(100.0 * power / whole, 2) if whole > 0.0 else "–"  # noqa: E731
    total = reading.number("loss_total_W")
    parts, spool = list(components(reading)), spool_balance(reading)
    stored = total - sum(p.simulated for p in parts) - spool.simulated
    rows = [row([p.name, fixed(p.simulated, 1), share(p.simulated)], ("", "n", "n")) for p in (*parts, spool)]
    rows.append(row(["taken into store in oil and spool", fixed(stored, 1), share(stored)], ("", "n", "n")))
    rows.append(row(["input power less load power", fixed(total, 1), share(total)], ("", "n", "n"), "sum"))
    by_component = table(["Component, simulated", "W", "% of input"], rows, (1, 2))
    compared = list(_compared(reading, share))
    by_cause = table(["Cause", "simulated W", "%", "analytic W", "%", "difference W"], compared, (1, 2, 3, 4, 5))
    return f"<h3>By component</h3>\n{by_component}\n<h3>By cause</h3>\n{by_cause}"


def _compared(reading: Reading, share: Callable[[float], str]) -> Iterator[str]:
    n, form = reading.number, ("", "n", "n", "n", "n", "n")

    def line(name: str, simulated: float, analytic: float, kind: str = "") -> str:
        cells = [
            fixed(simulated, 1),
            share(simulated),
            fixed(analytic, 1),
            share(analytic),
            fixed(simulated - analytic, 1),
        ]
        return row([name, *cells], form, kind)

    for cause in causes(reading):
        yield line(cause.name.replace("\n", " "), cause.simulated, cause.analytic)
        if cause.name.startswith("transition"):
            yield line("&emsp;of it, transition", float("nan"), n("analytic_loss_transition_W"))
            yield line("&emsp;of it, compression", float("nan"), n("analytic_loss_compressibility_W"))
    yield line("input power less load power", n("loss_total_W"), n("analytic_loss_total_W"), "sum")
