"""The report of a run: its result, the circuit, the parameters and their origin on one page."""

from collections.abc import Callable
from pathlib import Path

from vvdp.base.display import with_unit
from vvdp.base.kinds import DURATION, FLOW, GAUGE_PRESSURE
from vvdp.base.manifest import open_directory
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
from vvdp.systems.overview import flow_lines, node_lines
from vvdp.systems.own_modules import UntrustedModuleError

DIAGRAM = "circuit"


def write_report(
    directory: Path, run: RecordedRun | None = None, trust: str = "", say: Callable[[str], None] = quiet
) -> Path:
    """Writes report.html and figures/ into a result directory and gives the path of the page.

    All is made from the files in the directory, or from the `run` that was just written there: the bytes are the same.
    Without a circuit, and `say` hears why, where that needs code that may not be run; `trust` is a module that may be.
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
    return write_result_page(directory, Page(run_result(run), run.meta, ready, drawings))


def circuit_svg(run: RecordedRun, part: str = "") -> str:
    """The diagram of the circuit, or of a part of it, with mean pressures and flows."""
    title = f"{run.system.title}: {part.replace('_', ' ')}" if part else run.system.title
    return diagram(graph_of(run.network, title, part), _values(run))


def _values(run: RecordedRun) -> dict[str, Lines]:
    """Lines of text in the diagram by name of node or component: mean pressures and flows."""
    lines: dict[str, list[str]] = {}
    for node in node_lines(run.system, run.summary):
        if node.kind is GAUGE_PRESSURE and (node.low != node.high or node.name in run.volumes):
            lines[node.name] = [f"mean {with_unit(node.mean or 0.0, node.kind)}"]
    for flow in flow_lines(run.system, run.summary):
        words = with_unit(flow.flow, FLOW)
        lines.setdefault(flow.component, []).append(f"{flow.port} {words}" if flow.port else f"mean {words}")
    return {name: tuple(texts) for name, texts in lines.items()}


def _caption(run: RecordedRun) -> str:
    begin, end = (with_unit(run.number(f"averaged_{which}_s"), DURATION) for which in ("from", "to"))
    return (
        f"The circuit with the values of this run, and mean pressures (gauge) and flows from {begin} to {end}; flows "
        "are counted in volumes at tank conditions, into a port where one is named."
    )
