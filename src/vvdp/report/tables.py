"""The tables of a report, as HTML."""

from collections.abc import Callable, Iterator

import numpy as np

from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced
from vvdp.report.html import group, row, table, text
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.references import Reference
from vvdp.report.wording import fixed, number, percent, plain, shown
from vvdp.simulation.balance import LIMIT
from vvdp.systems.overview import flow_lines, loss_lines, node_lines, power_lines

RPM = 2.0 * np.pi / 60.0
FORM = ("", "n", "u")
SHOWN = {"bar": (BAR, 1), "rpm": (RPM, 0), "m/s": (1.0, 3), "mm": (1e-3, 2)}
"""Scale and decimals of the units in which nodes are shown."""


def node_table(reading: Reading) -> str:
    """Means and extremes of every node."""
    rows = []
    for line in node_lines(reading.system, reading.results.summary):
        scale, decimals = SHOWN[line.unit]
        cells = (number_or_blank(value, scale, decimals) for value in (line.mean, line.low, line.high))
        rows.append(row([text(line.name), line.quantity, *cells, line.unit], ("", "", "n", "n", "n", "u")))
    return table(["Node", "Quantity", "mean", "lowest", "highest", "Unit"], rows, (2, 3, 4))


def component_table(reading: Reading) -> str:
    """Mean flows of the components, and the power that comes from outside."""
    found = reading.results.summary
    rows = []
    for line in flow_lines(reading.system, found):
        what = f"flow into {text(line.port)}" if line.port else "flow"
        rows.append(row([text(line.component), what, fixed(line.flow / LPM, 3), "lpm"], ("", "", "n", "u")))
    for name, power in power_lines(reading.system, found):
        rows.append(row([text(name), "power into the circuit", fixed(power, 1), "W"], ("", "", "n", "u")))
    return table(["Component or node", "Quantity", "mean", "Unit"], rows, (2,))


def number_or_blank(value: float | None, scale: float, decimals: int) -> str:
    """A value in the unit of `scale`; nothing where there is none."""
    return "" if value is None else fixed(value / scale, decimals)


def loss_table(reading: Reading) -> str:
    """What the components turn to heat, what is taken into store, and what comes from outside."""
    found = reading.results.summary
    powers = [power for _, power in power_lines(reading.system, found)]
    put_in = sum(power for power in powers if power > 0.0)
    share: Callable[[float], str] = lambda power: fixed(100.0 * power / put_in, 2) if put_in > 0.0 else "–"  # noqa: E731
    form = ("", "n", "n")
    rows = []
    for line in loss_lines(reading.system, found):
        rows.append(row([text(line.component), fixed(line.loss, 1), share(line.loss)], form))
        for name, power in line.parts:
            words = f"&emsp;of it, {text(name.replace('_', ' '))}"
            rows.append(row([words, fixed(power, 1), share(power)], form, "part"))
    stored = reading.number("stored_power_W")
    rows.append(row(["taken into store", fixed(stored, 1), share(stored)], form))
    given = -sum(power for power in powers if power < 0.0)
    rows.append(row(["given to the outside", fixed(given, 1), share(given)], form))
    rows.append(row(["put in", fixed(put_in, 1), share(put_in)], form, "sum"))
    return table(["Component", "W", "% of input"], rows, (1, 2))


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
    if isinstance(r.value, tuple):
        both = [shown(value, r.kind, absolute=absolute) for value in r.value]
        return text(", ".join(value for value, _ in both)), text(both[0][1] if both else "")
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
