"""The tables of a report, as HTML."""

from collections.abc import Callable, Iterator

import numpy as np

from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced
from vvdp.report.html import group, row, table, text
from vvdp.report.losses import causes, components, spool_balance
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.references import Reference
from vvdp.report.wording import fixed, number, percent, plain, shown
from vvdp.simulation.balance import LIMIT

RPM = 2.0 * np.pi / 60.0
FORM = ("", "n", "u")


def key_numbers(reading: Reading) -> str:
    """Flows, pressures, speeds and powers in two columns."""
    n = reading.number

    def line(name: str, key: str, scale: float, unit: str, decimals: int) -> str:
        return row([name, fixed(n(key) / scale, decimals), unit], FORM)

    def part(title: str, lines: list[str]) -> str:
        return f"<div><h3>{title}</h3>\n<table><tbody>\n" + "\n".join(lines) + "\n</tbody></table></div>"

    flows = [
        line("Pump flow", "mean_pump_flow_m3_s", LPM, "lpm", 2),
        line("Load flow", "mean_load_flow_m3_s", LPM, "lpm", 2),
        line("Tank flow through the valve", "mean_tank_flow_m3_s", LPM, "lpm", 2),
        line("Relief valve flow", "mean_relief_flow_m3_s", LPM, "lpm", 2),
        line("Valve leakage", "mean_leakage_flow_m3_s", LPM, "lpm", 2),
        line("Load flow over pump flow", "load_flow_fraction", 0.01, "%", 1),
    ]
    pressures = [
        line("Load pressure, mean", "mean_load_pressure_Pa", BAR, "bar", 1),
        *(
            line(f"Load pressure, {word}", f"load_pressure_{key}_Pa", BAR, "bar", 1)
            for key, word in (("min", "lowest"), ("max", "highest"))
            if reading.has_load_line
        ),
        line("Inlet pressure, mean", "mean_inlet_pressure_Pa", BAR, "bar", 1),
        line("Inlet pressure, lowest", "inlet_pressure_min_Pa", BAR, "bar", 1),
        line("Inlet pressure, highest", "inlet_pressure_max_Pa", BAR, "bar", 1),
    ]
    low, high = reading.duty_ratio.extremes
    duty = fixed(low, 3) if reading.duty_ratio.is_constant else f"{fixed(low, 3)} to {fixed(high, 3)}"
    valve = [
        line("PWM frequency, mean", "pwm_frequency_Hz", 1.0, "Hz", 2),
        line("Spool speed, mean", "spool_speed_mean_rad_s", RPM, "rpm", 0),
        line("Spool speed, lowest", "spool_speed_min_rad_s", RPM, "rpm", 0),
        line("Spool speed, highest", "spool_speed_max_rad_s", RPM, "rpm", 0),
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


def balances(reading: Reading) -> str:
    """How the run was computed, and whether its books balance."""
    n, meta = reading.number, reading.results.meta
    ends = "stiff" if reading.has("stiff_method") else "explicit"
    method = reading.system.stepping.method.name.lower()
    lines = [
        ("Energy residual, of the throughput", number(n("energy_residual"), 3), f"limit {plain(LIMIT)}"),
        ("Mass residual, of the throughput", number(n("mass_residual"), 3), f"limit {plain(LIMIT)}"),
        ("Relative tolerance", plain(float(meta["relative_tolerance"])), ""),
        ("Steps accepted", f"{n('steps'):.0f}", ""),
        ("Steps rejected", f"{n('rejected_steps'):.0f}", ""),
        ("Evaluations of the circuit", f"{n('evaluations'):.0f}", ""),
        ("Method", text(method), f"{ends} at the end"),
        ("Sample period", plain(1e3 * float(meta["sample_period_s"])), "ms"),
        ("Simulated time", plain(n("duration_s")), f"s of {plain(float(meta['until_s']))} s"),
        ("Wall time", number(n("wall_time_s"), 3), "s"),
        ("Equations, hash", f'<span class="keys">{text(meta["equations"])}</span>', ""),
        ("vvdp", text(meta["vvdp"]), ""),
        ("Python, NumPy, Numba", ", ".join(text(meta.get(name, "–")) for name in ("python", "numpy", "numba")), ""),
    ]
    return table(["", "", ""], (row(line, FORM) for line in lines), (1,)).replace(
        "<thead><tr><th></th><th class=n></th><th></th></tr></thead>\n", ""
    )


def parameter_table(reading: Reading, known: dict[str, Reference]) -> str:
    """All parameters with their origin, grouped by table."""
    head = ["Parameter", "Value", "Unit", "Status", "Source", "Where", "Note"]
    return table(head, _parameter_rows(reading, known, len(head)), (1,))


def assumed_table(reading: Reading) -> str:
    """The parameters that are merely assumed."""
    rows = (
        row(
            [
                f'<span class="keys">{_breaking(r.table)}.<wbr>{_breaking(r.key)}</span>',
                *_value(reading, r),
                text(r.note),
            ],
            ("", "n", "u", "q"),
        )
        for r in reading.system.assumed
    )
    return table(["Parameter", "Value", "Unit", "Why"], rows, (1,))


def _parameter_rows(reading: Reading, known: dict[str, Reference], columns: int) -> Iterator[str]:
    before = ""
    for r in reading.system.rows:
        if r.table != before:
            yield group(text(r.table.replace("_", " ")), columns)
            before = r.table
        status = f'<span class="assumed">{r.status}</span>' if r.status == "assumed" else text(r.status)
        cells = [
            f'<span class="keys">{_breaking(r.key)}</span>',
            *_value(reading, r),
            status,
            _cited(r.source, known),
            text(r.where),
            text(r.note),
        ]
        yield row(cells, ("", "n", "u", "", "", "q", "q"))


def _breaking(key: str) -> str:
    return text(key).replace("_", "_<wbr>")


def _value(reading: Reading, r: Sourced) -> tuple[str, str]:
    absolute = reading.is_absolute(r)
    if isinstance(r.value, Signal) and not r.value.is_constant:
        (low, unit), (high, _) = (shown(v, r.kind, absolute=absolute) for v in r.value.extremes)
        return f"{text(low)} to {text(high)}", text(unit) + " (changes)"
    value, unit = shown(r.value.base if isinstance(r.value, Signal) else r.value, r.kind, absolute=absolute)
    return text(value), text(unit)


def _cited(key: str, known: dict[str, Reference]) -> str:
    return f'<a href="#ref-{text(key)}">{text(key)}</a>' if key in known else text(key)


def reference_list(reading: Reading, known: dict[str, Reference]) -> str:
    """The literature that the system's values come from."""
    cited = sorted({r.source for r in reading.system.rows if r.source})
    items = [
        f'<li id="ref-{text(key)}"><span class="keys">{text(key)}</span> {text(known[key].authors)}: '
        f"<i>{text(known[key].title)}</i>. {text(known[key].place)}, {text(known[key].year)}.</li>"
        for key in cited
        if key in known
    ]
    unknown = ", ".join(text(key) for key in cited if key not in known)
    listed = f'<ol class="references">\n{chr(10).join(items)}\n</ol>' if items else "<p>No literature is cited.</p>"
    return listed + (
        f'\n<p class="small">Sources named in the system and not in the bibliography: {unknown}.</p>' if unknown else ""
    )


def share_of_assumed(reading: Reading) -> str:
    """How many values are assumed, in words."""
    rows, assumed = len(reading.system.rows), len(reading.system.assumed)
    return f"{assumed} of {rows} values ({percent(assumed / rows, 0)})"
