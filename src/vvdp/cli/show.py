"""`vvdp show`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vvdp.cli.options import AsJson, Settings, SystemName

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vvdp.base.tables import Sourced
    from vvdp.cli.table import Grid
    from vvdp.systems.system import System


def show(
    system: SystemName,
    settings: Settings = None,
    json: AsJson = False,
    text: Annotated[bool, typer.Option("--text", help="Print the generated Python text of the circuit.")] = False,
    llvm: Annotated[bool, typer.Option("--llvm", help="Print the LLVM text of the circuit and its programs.")] = False,
) -> None:
    """Show nodes, components and values of a system.

    Each value is shown with its status and source; pressure levels are shown gauge and absolute. Of a foreign FMU
    (FILE.fmu), the description is shown; nothing of it is run.
    """
    if system.endswith(".fmu"):
        from vvdp.cli.show_fmu import show_fmu

        show_fmu(Path(system), json=json)
        return
    from vvdp.cli.screen import print_json
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or ())
    if text:
        typer.echo(loaded.circuit.text, nl=False)
    elif llvm:
        from vvdp.simulation.link import llvm_text

        typer.echo(llvm_text(loaded.model, loaded.case), nl=False)
    elif json:
        print_json(_content(loaded))
    else:
        _print(loaded)


def _content(system: "System") -> dict[str, Any]:
    parameters = {f"{row.table}.{row.key}": _entry(row) for row in system.rows}
    assumed = [f"{row.table}.{row.key}" for row in system.assumptions]
    return {
        "system": system.name,
        "title": system.title,
        "circuit": system.circuit_name,
        "assumed": assumed,
        "parameters": parameters,
    }


def _entry(row: "Sourced") -> dict[str, Any]:
    """A value as a program reads it: SI, a pressure level absolute; `value` is null where it changes over time."""
    from vvdp.base.signal import Signal

    value: Any = row.value
    if isinstance(row.value, tuple):
        low, high = min(row.value, default=None), max(row.value, default=None)
    elif isinstance(row.value, Signal):
        low, high = row.value.extremes
        value = low if low == high else None
    else:
        low = high = row.value
    return {
        "value": value,
        "low": low,
        "high": high,
        "range": None if row.range is None else list(row.range),
        "unit": row.kind.unit,
        "kind": row.kind.name,
        "shown": row.display_text,
        "status": row.status,
        "source": row.source,
        "where": row.where,
        "note": row.note,
    }


def _print(system: "System") -> None:
    from vvdp.cli.screen import console, grid, tell
    from vvdp.systems.assumed import assumed_words

    out = console()
    tell(f"{system.title}\n{system.name}, circuit {system.circuit_name}\n")
    for table in (_nodes(system), _components(system), _programs(system), _parts(system)):
        if table.rows:
            out.print(table)
    tables = dict.fromkeys(row.table for row in system.rows)
    for name in tables:
        table = grid("key", "value", "status", "source", "note", title=f"[{name}]")
        for row in system.rows:
            if row.table == name:
                source = ", ".join(part for part in (row.source, row.where) if part)
                table.add_row(row.key, row.display_text, row.status, source, row.remark)
        out.print(table)
    assumed = system.assumptions
    tell(f"{assumed_words(assumed)}; {len(system.rows)} values in all", style="bold")
    tell(", ".join(f"{row.table}.{row.key}" for row in assumed) or "none")


def _nodes(system: "System") -> "Grid":
    from vvdp.cli.screen import grid
    from vvdp.evaluation.overview import inside
    from vvdp.network.nodes import kind_of_node

    network = system.circuit.network
    hidden = inside(network)
    table = grid("node", "what it is", "joined by", title="Nodes")
    for name, node in network.nodes.items():
        if name not in hidden:
            ports = ", ".join(f"{part}.{port}" for part, port, where in _joints(system) if where == name)
            table.add_row(name, kind_of_node(node), ports)
    return table


def _joints(system: "System") -> "Iterator[tuple[str, str, str]]":
    """Component, port and node of every joint."""
    from vvdp.evaluation.overview import inside

    network = system.circuit.network
    hidden = inside(network)
    whole = {name: part.nodes for name, part in network.parts.items() if name not in hidden}
    whole |= {name: group.ports for name, group in network.groups.items()}
    for name, nodes in whole.items():
        for port, node in nodes.items():
            yield name, port, node


def _components(system: "System") -> "Grid":
    from vvdp.cli.screen import grid
    from vvdp.evaluation.overview import inside
    from vvdp.report.circuit import source_words

    network = system.circuit.network
    hidden = inside(network)
    types = {name: part.component.name for name, part in network.parts.items() if name not in hidden}
    types |= {name: group.assembly.name for name, group in network.groups.items()}
    joints = list(_joints(system))
    table = grid("component", "type", "ports", "inputs", title="Components")
    for name, kind in types.items():
        ports = ", ".join(f"{port}: {node}" for part, port, node in joints if part == name)
        part = network.parts.get(name)
        inputs = {a.name: a.kind for a in part.component.inputs} if part else {}
        given = [f"{key} = {source_words(part.inputs[key], kind)}" for key, kind in inputs.items()] if part else []
        table.add_row(name, kind.replace("_", "-"), ports, ", ".join(given))
    return table


def _parts(system: "System") -> "Grid":
    """The parts that are circuits of their own."""
    from vvdp.cli.screen import grid
    from vvdp.systems.drawn_parts import part_settings

    settings = part_settings(system.content)
    table = grid("part", "circuit", "ports", "values to be set", title="Parts")
    for name, circuit in system.circuit.network.circuits.items():
        ports = ", ".join(f"{port}: {node}" for port, node in circuit.ports.items())
        values = [key for key in settings if key.rpartition(".")[0] == f"parts.{name}"]
        table.add_row(name, circuit.source, ports, "\n".join(values))
    return table


def _programs(system: "System") -> "Grid":
    from vvdp.base.params import field_kinds
    from vvdp.cli.screen import grid
    from vvdp.report.circuit import source_words

    table = grid("program", "reads", "called", title="Programs")
    for name, program in system.circuit.network.programs.items():
        period = program.period or system.stepping.sample_period
        called = "at events" if program.type.level else f"every {1e3 * period:g} ms"
        kinds = field_kinds(program.type.reading)
        reads = (f"{key}: {source_words(source, kinds[key])}" for key, source in program.reads.items())
        table.add_row(name, ", ".join(reads), called)
    return table
