"""The circuit diagram of the page: places for mean values in it, and what each part of it did in the last periods."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import key_suffix, with_unit
from vvdp.base.kinds import AREA, FLOW, FRACTION, GAUGE_PRESSURE, POSITION, SPEED, VELOCITY, Kind
from vvdp.evaluation.overview import flow_ports, inside
from vvdp.network.network import Part
from vvdp.network.nodes import HydraulicNode, Junction, OilVolume
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
from vvdp.report.drawing import INK
from vvdp.report.interactive import Placed
from vvdp.report.shown import column_unit
from vvdp.results.result import Column, Table
from vvdp.runs.run import RecordedRun
from vvdp.runs.tables import series_table
from vvdp.systems.system import System

FIRST_MARK = 0xE000
"""The first character for private use: so many of one stand in the layout for a number that is not yet known."""
ROOM = 13
"""Characters that a mean value takes beside its word."""
UNKNOWN = "not known (no whole period)"


class Mean(NamedTuple):
    """A mean value in the diagram: the part beside which it stands, its key in the summary, its word."""

    part: str
    key: str
    word: str
    kind: Kind


def means(system: System) -> Iterator[Mean]:
    """The mean values that the diagram shows: pressures of volumes, flows of components."""
    network = system.circuit.network
    hidden = inside(network)
    for name, node in network.nodes.items():
        if isinstance(node, OilVolume | Junction) and name not in hidden:
            yield Mean(name, f"pressure_mean_{name}_Pa", "mean", GAUGE_PRESSURE)
    for part in network.parts.values():
        for flow, port in flow_ports(part).items() if part.name not in hidden else ():
            yield Mean(part.name, f"flow_mean_{flow.removesuffix('_flow')}_m3_s", port or "mean", FLOW)
    for name in network.groups:
        yield Mean(name, f"flow_mean_{name}_m3_s", "mean", FLOW)


def drawing(system: System) -> str:
    """The diagram as SVG in the colour of the text around it; each mean value has an element `data-mean`."""
    wanted = list(means(system))
    places: dict[str, tuple[str, ...]] = {}
    for number, mean in enumerate(wanted):
        mark = chr(FIRST_MARK + number) * (len(mean.word) + ROOM)
        places[mean.part] = (*places.get(mean.part, ()), mark)
    made = diagram(graph_of(system.circuit.network, system.title), places, named=True)
    for number, mean in enumerate(wanted):
        mark = chr(FIRST_MARK + number) * (len(mean.word) + ROOM)
        made = made.replace(mark, f'<tspan data-mean="{mean.key}">\N{EN DASH}</tspan>')
    return made[made.index("<svg") :].replace(f'"{INK}"', '"currentColor"')


def mean_texts(system: System, summary: Mapping[str, float | bool], *, is_draft: bool) -> dict[str, str]:
    """The mean values of a run as the diagram shows them; of a draft the pressures alone."""
    found = {}
    for mean in means(system):
        if is_draft and mean.kind is not GAUGE_PRESSURE:
            continue
        value = summary.get(mean.key)
        known = isinstance(value, float | int) and bool(np.isfinite(value))
        words = with_unit(float(value), mean.kind) if known and value is not None else UNKNOWN
        found[mean.key] = f"{mean.word} {words}"
    return found


class Course(NamedTuple):
    """The last periods of a run [units as shown]: what a part shows when it is pointed at, and what moves the diagram.

    curves    part -> columns with their kinds and labels
    nodes     gauge pressure of each hydraulic node
    flows     "part.port" -> flow out of the component there
    openings  "part.port" -> open fraction of the port, 0 to 1
    """

    times: Array
    period: tuple[float, float]
    curves: Mapping[str, list[Column]]
    nodes: Mapping[str, Array]
    flows: Mapping[str, Array]
    openings: Mapping[str, Array]

    def describe(self, columns: Placed) -> dict[str, Any]:
        """Description of the course for the page, with the places of the columns."""

        def places(found: Mapping[str, Array], scale: float = 1.0) -> dict[str, int]:
            return {name: columns.place(scale * values) for name, values in found.items()}

        def curve(each: Column) -> dict[str, Any]:
            unit = column_unit(each)
            return {"label": each.label, "unit": unit.symbol, "y": columns.place(unit.from_si(each.values))}

        curves = {part: list(map(curve, found)) for part, found in self.curves.items()}
        return {
            "times": columns.place(self.times),
            "period": list(self.period),
            "curves": curves,
            "nodes": places(self.nodes, 1e-5),
            "flows": places(self.flows, 6e4),
            "openings": places(self.openings),
        }


def course_of(run: RecordedRun) -> Course:
    """The last periods of a run, or its end if it has no periods."""
    part = run.detail()
    rows, network = part.rows, run.network
    hidden = inside(network)
    held = [name for name, node in network.nodes.items() if isinstance(node, HydraulicNode) and name not in hidden]
    nodes = {name: run.pressure(name)[rows] for name in held}
    begin, end = part.marks[-2:] if part.periods else run.times[rows[[0, -1]]]
    parts = [each for each in network.parts.values() if each.name not in hidden]
    return Course(
        times=run.times[rows],
        period=(float(begin), float(end)),
        curves=_curves(run, series_table(run), rows),
        nodes=nodes,
        flows={key: values[rows] for each in parts for key, values in _outward(run, each)}
        | {f"{name}.": run.output(f"{group.parts[-1]}_flow")[rows] for name, group in network.groups.items()},
        openings={key: values[rows] for each in parts for key, values in _openings(run, each)},
    )


def _curves(run: RecordedRun, series: Table, rows: Any) -> dict[str, list[Column]]:
    """Recorded series of each part."""
    keys = [(name, f"pressure_{name}{key_suffix(GAUGE_PRESSURE)}") for name in run.volumes]
    keys += [(name, f"flow_{name}_{port}".rstrip("_") + key_suffix(FLOW)) for name, port, _ in run.flows()]
    motions = (("speed", SPEED), ("position", POSITION), ("velocity", VELOCITY))
    keys += [(name, f"{word}_{name}{key_suffix(kind)}") for name in run.network.nodes for word, kind in motions]
    found: dict[str, list[Column]] = {}
    for name, key in keys:
        if key in series.columns:
            column = series.columns[key]
            found.setdefault(name, []).append(Column(column.values[rows], column.kind, column.label))
    return found


def _outward(run: RecordedRun, part: Part) -> Iterator[tuple[str, Array]]:
    """The flow out of a component at each port: what passes through it leaves at the second."""
    ports = part.component.hydraulic_ports
    for output, port in flow_ports(part).items():
        flow = run.output(output)
        if port:
            yield f"{part.name}.{port}", flow
        elif len(ports) == 2:
            yield f"{part.name}.{ports[0]}", -flow
            yield f"{part.name}.{ports[1]}", flow


def _openings(run: RecordedRun, part: Part) -> Iterator[tuple[str, Array]]:
    """The open fraction of the ports of a valve that opens and closes: an area as a share of its maximum."""
    ports = part.component.hydraulic_ports
    for output, kind in part.component.outputs.items():
        name, _, word = output.rpartition("_")
        if kind not in (AREA, FRACTION) or word not in ("opening", "area"):
            continue
        values = run.output(f"{part.name}_{output}")
        largest = float(np.max(values, initial=0.0)) if kind is AREA else 1.0
        for port in ports if not name else (name,) if name in ports else ():
            yield f"{part.name}.{port}", values / (largest or 1.0)
