"""The numbers of a run as listings, and its recorded series as one table, for any circuit."""

from collections.abc import Iterator, Mapping

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import key_suffix, plain
from vvdp.base.kinds import (
    COUNT,
    DURATION,
    FLOW,
    GAUGE_PRESSURE,
    MEAN_POWER,
    NUMBER,
    POSITION,
    SPEED,
    TIME,
    VELOCITY,
    Kind,
)
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.overview import (
    circuit_loss_lines,
    circuit_power_lines,
    flow_lines,
    loss_lines,
    node_lines,
    power_lines,
)
from vvdp.evaluation.valve_forms import placed_form_quantities
from vvdp.evaluation.valve_numbers import valve_quantities
from vvdp.network.nodes import DrivenShaft, HydraulicNode, Rod, Shaft
from vvdp.results.result import Column, Listing, Row, Table
from vvdp.runs.run import RecordedRun
from vvdp.simulation.balance import LIMIT
from vvdp.simulation.record import Record
from vvdp.systems.extras import Extras

ROUNDING = 1e-9
"""A value counts as nothing below this share of the largest of its kind; for gauge pressures that is at least the
reference pressure."""
GAUGE = "Pressures are gauge."
MEANS = "Means over the averaging window; lowest and highest over the whole run, its start included."


def overview(run: RecordedRun, extras: Extras) -> Listing:
    """The lines that a system brings along, simulated and analytic; those of which nothing is known are left out."""

    def total(keys: tuple[str, ...]) -> float | None:
        known = [run.number(key) for key in keys if key in run.summary]
        return sum(known) if known and len(known) == len(keys) else None

    values = [(line, (total(line.keys), total(line.closed_form))) for line in extras.OVERVIEW]
    columns = 2 if any(analytic is not None for _, (_, analytic) in values) else 1
    rows = tuple(
        Row(line.label, line.kind, found[:columns], line.group) for line, found in values if found != (None, None)
    )
    note = " ".join(filter(None, (MEANS, GAUGE, extras.OVERVIEW_NOTE)))
    return Listing(
        title="" if extras.IS_ALL else "Programs", heads=("simulated", "analytic")[:columns], rows=rows, note=note
    )


def without_dust(value: float, largest: float) -> float:
    """A value, or zero where it is nothing but rounding beside the largest of its kind."""
    return 0.0 if abs(value) < ROUNDING * abs(largest) else value


def screen_listings(run: RecordedRun) -> tuple[Listing, ...]:
    """Tables on the screen: the overview that the system brings along; else nodes, components, losses, programs."""
    extras = additions(run.system)
    own = (overview(run, extras),) if extras is not None and extras.OVERVIEW else ()
    if own and extras is not None and extras.IS_ALL:
        return own
    listings = node_listing(run), component_listing(run), loss_listing(run), *circuit_loss_listings(run).values()
    return (*listings, *valve_listings(run).values(), *own)


def valve_listings(run: RecordedRun) -> dict[str, Listing]:
    """The table of the rotary valves of a drawn circuit; empty if it has none."""
    numbers, forms = dict(valve_quantities(run.system)), dict(placed_form_quantities(run.system))
    shown = numbers | {key: forms[key] for key in forms if key in run.summary}
    rows = tuple(Row(label, kind, (run.number(key),)) for key, (kind, label) in shown.items())
    return {"valves": Listing(title="Rotary valves", heads=("mean",), rows=rows)} if rows else {}


def node_listing(run: RecordedRun) -> Listing:
    """Means and extremes of every node."""
    lines, nodes = list(node_lines(run.system, run.summary)), run.network.nodes.values()
    references = [node.oil.reference_pressure for node in nodes if isinstance(node, HydraulicNode)]
    largest = {GAUGE_PRESSURE: max(references, default=0.0)}
    for line in lines:
        largest[line.kind] = max(largest.get(line.kind, 0.0), abs(line.low), abs(line.high))
    rows = []
    for line in lines:
        mean = None if line.mean is None else without_dust(line.mean, largest[line.kind])
        low, high = (without_dust(value, largest[line.kind]) for value in (line.low, line.high))
        rows.append(Row(f"{line.name.replace('_', ' ')}, {line.quantity}", line.kind, (mean, low, high)))
    note = f"{MEANS} {GAUGE}"
    return Listing(title="Nodes", heads=("mean", "lowest", "highest"), rows=tuple(rows), note=note)


def component_listing(run: RecordedRun) -> Listing:
    """Mean flows of the components, and the power that comes from outside."""
    rows = []
    for line in flow_lines(run.system, run.summary):
        what = (f"flow into {line.port}" if line.port else "flow") + (", besides what is swept" if line.sweeps else "")
        rows.append(Row(f"{line.component.replace('_', ' ')}, {what}", FLOW, (line.flow,)))
    rows += [
        Row(f"{name.replace('_', ' ')}, power into the circuit", MEAN_POWER, (power,))
        for name, power in power_lines(run.system, run.summary)
    ]
    return Listing(title="Components", heads=("mean",), rows=tuple(rows))


def loss_listing(run: RecordedRun) -> Listing:
    """Losses of the components, rate of stored energy, and powers from outside."""
    powers = [power for _, power in power_lines(run.system, run.summary)]
    put_in, given = sum(p for p in powers if p > 0.0), -sum(p for p in powers if p < 0.0)
    stored, largest = run.number("stored_power_W"), max(map(abs, powers), default=0.0)

    def row(label: str, power: float, *, is_part: bool = False, is_sum: bool = False) -> Row:
        power = without_dust(power, largest)
        share = f"{100.0 * power / put_in:.2f} %" if put_in > 0.0 else ""
        return Row(label, MEAN_POWER, (power,), note=share, is_part=is_part, is_sum=is_sum)

    rows = []
    for line in loss_lines(run.system, run.summary):
        rows.append(row(line.component.replace("_", " "), line.loss))
        rows += [row(f"of which {name.replace('_', ' ')}", power, is_part=True) for name, power in line.parts]
    rows += [
        row("stored in the circuit", stored),
        row("output power", given),
        row("input power", put_in, is_sum=True),
    ]
    note = "Shares are of the input power."
    return Listing(title="Losses by component", heads=("mean",), rows=tuple(rows), note=note)


def circuit_loss_listings(run: RecordedRun) -> dict[str, Listing]:
    """Losses of the parts that are circuits of their own, by name; none where the circuit has none."""
    rows, powers = [], dict(circuit_power_lines(run.system, run.summary))
    for line in circuit_loss_lines(run.system, run.summary):
        name = line.component.replace("_", " ")
        rows.append(Row(name, MEAN_POWER, (line.loss,)))
        inner = ((f"of which {part.replace('_', ' ')}", loss) for part, loss in line.parts)
        rows += [Row(label, MEAN_POWER, (loss,), is_part=True) for label, loss in inner]
        if line.component in powers:
            rows.append(Row(f"{name}, power into the circuit", MEAN_POWER, (powers[line.component],)))
    return {"circuit-losses": Listing(title="Losses by part", heads=("mean",), rows=tuple(rows))} if rows else {}


def computation(run: RecordedRun) -> Listing:
    """How the run was computed, and whether its books balance."""
    n, meta = run.number, run.meta
    limit = f"limit {plain(LIMIT)}"
    ends = "stiff" if run.has("stiff_method") else "explicit"
    packages = ", ".join(f"{meta.get(name, '–')}" for name in ("python", "numpy", "llvm"))
    rows = [
        Row("energy residual, of the throughput", NUMBER, (n("energy_residual"),), note=limit),
        Row("oil residual, of the throughput", NUMBER, (n("mass_residual"),), note=limit),
        Row("relative tolerance", NUMBER, (float(meta["relative_tolerance"]),)),
        Row("steps accepted", COUNT, (n("steps"),)),
        Row("steps rejected", COUNT, (n("rejected_steps"),)),
        Row("evaluations of the circuit", COUNT, (n("evaluations"),)),
        Row("method", None, (run.system.stepping.method.name.lower(),), note=f"{ends} at the end"),
        Row("sample period", TIME, (float(meta["sample_period_s"]),)),
        Row("simulated time", DURATION, (n("duration_s"),), note=f"of {float(meta['until_s']):g} s"),
        Row("wall time", DURATION, (n("wall_time_s"),)),
        Row("equations, hash", None, (str(meta["equations"]),)),
        Row("Python, NumPy, LLVM", None, (packages,)),
    ]
    return Listing(title="", heads=("",), rows=tuple(rows))


def series_table(run: RecordedRun) -> Table:
    """Everything that a user looks at over time: pressures, flows, motions, commands of programs."""
    columns = {"time_s": Column(run.times, DURATION, "time", "t")}
    for name, values, kind, label in _all_series(run):
        columns[name + key_suffix(kind)] = Column(values, kind, label)
    return Table(title="Recorded series", columns=columns, is_data=True)


def record_table(record: Record) -> Table:
    """All that a run recorded, pressures absolute, a column for each number of a value that has several.

    Columns are called by group and path (`states.load`), with the SI unit at their end.
    """
    columns = {"time_s": Column(record.times, DURATION, "time", "t")}
    for group, members in record.groups.items():
        for path, series in members.items():
            kind = series.kind or NUMBER
            flat = series.values.reshape(record.times.size, -1)
            for place, values in enumerate(flat.T):
                index = f".{place}" if series.values.ndim > 1 else ""
                columns[f"{group}.{path}{index}{key_suffix(kind)}"] = Column(
                    values, kind, series.long_name.removesuffix(" (absolute)") + index
                )
    return Table(title="Record", columns=columns, is_data=True)


def _all_series(run: RecordedRun) -> Iterator[tuple[str, Array, Kind, str]]:
    for name in run.volumes:
        yield f"pressure_{name}", run.pressure(name), GAUGE_PRESSURE, name.replace("_", " ")
    for name, port, values in run.flows():
        words = name.replace("_", " ")
        yield f"flow_{name}_{port}".rstrip("_"), values, FLOW, f"{words}, {port}" if port else words
    for name, node in run.network.nodes.items():
        yield from _motion(run, name, node)
    for path, series in run.record.commands.items():
        program = path.partition(".")[0]
        if program in run.network.programs and series.values.ndim == 1:
            yield f"command_{path.replace('.', '_')}", series.values, series.kind or NUMBER, _words(path)


def _motion(run: RecordedRun, name: str, node: object) -> Iterator[tuple[str, Array, Kind, str]]:
    words = name.replace("_", " ")
    if isinstance(node, Shaft):
        yield f"speed_{name}", run.state(f"{name}.speed"), SPEED, words
    elif isinstance(node, Rod):
        yield f"position_{name}", run.state(f"{name}.position"), POSITION, words
        yield f"velocity_{name}", run.state(f"{name}.velocity"), VELOCITY, words
    elif isinstance(node, DrivenShaft) and name in run.record.states and run.times.size > 2:
        speed = np.gradient(run.state(name), run.times)
        if np.ptp(speed) > 1e-6 * (1.0 + np.max(np.abs(speed))):
            yield f"speed_{name}", speed, SPEED, words


def _words(path: str) -> str:
    return path.partition(".")[2].replace("_", " ").replace(".", ", ")


def bar_table(name: str, columns: Mapping[str, tuple[float, ...]], labels: tuple[str, ...], whole: float) -> Table:
    """Mean powers by `labels`, with the words that stand behind the bars of the first column."""
    first = next(iter(columns.values()))
    words = [f"{p:.0f} W" if p >= 100.0 else f"{p:.1f} W" for p in first]
    if whole > 0.0:
        words = [f"{word}, {100.0 * p / whole:.1f} %" for word, p in zip(words, first, strict=True)]
    found = {name: Column(np.array(labels), None, name), "words": Column(np.array(words), None, "")}
    found |= {f"{key}_W": Column(np.array(each), MEAN_POWER, key.replace("_", " ")) for key, each in columns.items()}
    return Table(title=f"Losses by {name}", columns=found, is_data=True)
