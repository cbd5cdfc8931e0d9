"""The report of a run: its result, the circuit, the parameters and their origin on one page."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.base.display import with_unit
from vvdp.base.kinds import DURATION, FLOW, GAUGE_PRESSURE, Kind
from vvdp.base.manifest import open_directory
from vvdp.evaluation.overview import flow_lines, node_lines
from vvdp.report.circuit import Lines, figure_of, graph_of
from vvdp.report.diagram import diagram
from vvdp.report.drawing import Drawn
from vvdp.report.html import text
from vvdp.report.references import bibliography
from vvdp.report.result_page import Page, write_result_page
from vvdp.report.tables import assumed_table, parameter_table
from vvdp.runs.result import run_result
from vvdp.runs.run import RecordedRun, open_run
from vvdp.runs.untold import untold_result
from vvdp.simulation.link import quiet
from vvdp.simulation.results import read_results
from vvdp.systems.own_modules import UntrustedModuleError

DIAGRAM = "circuit"


class ShownValue(NamedTuple):
    """A number of the summary beside a part of a diagram: what it is, its key and its value."""

    words: str
    key: str
    value: float
    kind: Kind

    @property
    def text(self) -> str:
        """As the diagram has it."""
        return f"{self.words} {with_unit(self.value, self.kind)}"


def write_report(
    directory: Path,
    run: RecordedRun | None = None,
    trust: str = "",
    say: Callable[[str], None] = quiet,
    dress: Callable[[RecordedRun, Page], Page] | None = None,
) -> Path:
    """Writes report.html and figures/ into a result directory and gives the path of the page.

    All is made from the files in the directory, or from the `run` that was just written there: the bytes are the same.
    What `dress` makes of the page is written, where it is given. Without a circuit, and `say` is informed why, where
    that needs code that may not be run; `trust` is a module that may be.
    Raises ConfigError where the directory is no result directory or the system in it cannot be read.
    """
    if run is None:
        opened = open_directory(directory)
        try:
            run = open_run(opened, trust)
        except UntrustedModuleError as problem:
            say(str(problem))
            results = read_results(opened)
            return write_result_page(directory, Page(untold_result(results, str(problem)), results.meta))
    ready = {
        "parameters": parameter_table(run.system, bibliography()),
        "assumed": assumed_table(run.system),
        "equations": '<details class="code"><summary>Show the text of the circuit</summary>\n'
        f"<pre>{text(run.system.circuit.text)}</pre></details>",
    }
    drawings = {DIAGRAM: Drawn(DIAGRAM, _caption(run), circuit_svg(run))}
    for part, circuit in run.network.circuits.items():
        words = f"What is in {part.replace('_', ' ')} ({circuit.source})."
        drawings[figure_of(part)] = Drawn(figure_of(part), words, circuit_svg(run, part))
    page = Page(run_result(run), run.meta, ready, drawings)
    return write_result_page(directory, dress(run, page) if dress else page)


def circuit_svg(run: RecordedRun, part: str = "") -> str:
    """The diagram of the circuit, or of a part of it, with mean pressures and flows."""
    title = f"{run.system.title}: {part.replace('_', ' ')}" if part else run.system.title
    return diagram(graph_of(run.network, title, part), lines_of(diagram_values(run)))


def lines_of(values: Mapping[str, Sequence[ShownValue]]) -> dict[str, Lines]:
    """The lines of text of values by name of node or component."""
    return {name: tuple(each.text for each in shown) for name, shown in values.items()}


def diagram_values(run: RecordedRun) -> dict[str, list[ShownValue]]:
    """Values in a diagram by name of node or component: mean pressures and flows."""
    found: dict[str, list[ShownValue]] = {}
    for node in node_lines(run.system, run.summary):
        if node.kind is GAUGE_PRESSURE and (node.low != node.high or node.name in run.volumes):
            found[node.name] = [ShownValue("mean", f"pressure_mean_{node.name}_Pa", node.mean or 0.0, node.kind)]
    for flow in flow_lines(run.system, run.summary):
        key = "_".join(filter(None, ("flow_mean", flow.component, flow.port, "m3_s")))
        found.setdefault(flow.component, []).append(ShownValue(flow.port or "mean", key, flow.flow, FLOW))
    return found


def _caption(run: RecordedRun) -> str:
    begin, end = (with_unit(run.number(f"averaged_{which}_s"), DURATION) for which in ("from", "to"))
    return (
        f"The circuit with the values of this run, and mean pressures (gauge) and flows from {begin} to {end}; flows "
        "are counted in volumes at tank conditions, into a port where one is named."
    )
