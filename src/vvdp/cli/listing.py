"""`vvdp list`."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from vvdp.base.kinds import Kind
    from vvdp.base.params import Params
    from vvdp.network.assembly import Assembly
    from vvdp.network.component import Component
    from vvdp.network.program import ProgramType


def systems(
    components: Annotated[
        bool, typer.Option("--components", help="List what a file may draw a circuit from: the library.")
    ] = False,
) -> None:
    """List shipped systems, circuits, and systems in this folder."""
    if components:
        _library()
        return
    from vvdp.base.tables import parsed_table
    from vvdp.cli.screen import console, grid
    from vvdp.systems.system import shipped

    table = grid("system", "circuit", "title", title="Shipped systems")
    for name, text in shipped().items():
        content = parsed_table(text, name).content
        table.add_row(name, _circuit(content), str(content.get("title", "")))
    console().print(table)
    table = grid("circuit", "tables", "what it is", title="Circuits")
    for row in _circuits():
        table.add_row(*row)
    console().print(table)
    found = list(_own_systems(Path.cwd()))
    if found:
        table = grid("file", "circuit", "title", title="Systems in this folder")
        for row in found:
            table.add_row(*row)
        console().print(table)


def _circuit(content: Mapping[str, Any]) -> str:
    return str(content.get("circuit", "drawn"))


def _circuits() -> Iterator[tuple[str, str, str]]:
    """Name, tables and first line of every circuit that an installed package offers."""
    from vvdp.systems.circuits import circuit_names, network_function, table_slots

    for name in circuit_names():
        try:
            function = network_function(name, Path())
            tables = ", ".join(f"[{key}]" if slot.optional else key for key, slot in table_slots(function).items())
        except Exception as problem:  # of somebody else's package
            yield name, "", f"cannot be used: {problem}"
            continue
        yield name, tables, (function.__doc__ or "").strip().partition("\n")[0]


def _own_systems(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Name, circuit and title of every TOML file in `folder` that names a circuit or draws one."""
    from vvdp.base.errors import ConfigError
    from vvdp.base.tables import read_table
    from vvdp.systems.circuits import circuit_names

    for path in sorted(folder.glob("*.toml")):
        try:
            content = read_table(path).content
        except ConfigError:
            continue  # some other program's file, or broken; `vvdp show` says what is wrong with it
        circuit = content.get("circuit")
        is_named = isinstance(circuit, str) and (circuit in circuit_names() or ":" in circuit)
        if is_named or (circuit is None and {"components", "nodes"} <= content.keys()):
            yield path.name, _circuit(content), str(content.get("title", ""))


def _library() -> None:
    """Prints all that a file may draw a circuit from."""
    from vvdp.cli.screen import console, grid
    from vvdp.components.library import COMPONENTS, PROGRAMS
    from vvdp.network.assembly import Assembly
    from vvdp.systems.drawn import NODES

    out = console()
    table = grid("type", "values", title="Nodes: [nodes] NAME = { type = ... }")
    for name, node in NODES.items():
        table.add_row(name, "\n".join(_values(node.table)))
    out.print(table)
    title = "Components: [components.NAME] with its type, the node at each port, inputs and values"
    table = grid("type", "ports", "inputs", "values", "outputs", "symbol", title=title)
    for name, component in COMPONENTS.items():
        cells = _assembly(component) if isinstance(component, Assembly) else _component(component)
        table.add_row(name, *("\n".join(cell) for cell in cells), component.symbol)
    out.print(table)
    title = "Programs: [programs.NAME] with its type, values and what it reads"
    table = grid("type", "reads", "commands", "values", title=title)
    for name, program in PROGRAMS.items():
        table.add_row(name, *("\n".join(cell) for cell in _program(program)))
    out.print(table)
    out.print("A value is written with its unit, as in the examples; the one in brackets holds where none is given.")
    out.print('An input is a value, a signal over time, or { from = "NAME.OUTPUT" }.')


def _component(component: "Component") -> Sequence[list[str]]:
    """Ports, inputs, values and outputs."""
    values = [line for cls in component.params for line in _values(cls)]
    return _ports(component), _inputs(component), values, [*component.outputs]


def _assembly(assembly: "Assembly") -> Sequence[list[str]]:
    return [*assembly.ports], [], [*_values(assembly.params), 'start = "100 bar"'], []


def _ports(component: "Component") -> list[str]:
    from vvdp.network.network import JOINS
    from vvdp.network.nodes import kind_of_node

    hydraulic = component.hydraulic_ports
    return [
        port if port in hydraulic else f"{port} ({kind_of_node(JOINS[role][0])})"
        for port, role in component.ports.items()
    ]


def _inputs(component: "Component") -> list[str]:
    return [f"{a.name} = {_example(a.kind, a.default)}" for a in component.inputs]


def _values(cls: "type[Params]") -> list[str]:
    """The fields of a parameter class with an example of each, and its value where it need not be given."""
    from vvdp.base.params import default_values, field_kinds

    usual = default_values(cls)
    return [f"{name} = {_example(kind, usual.get(name))}" for name, kind in field_kinds(cls).items()]


def _example(kind: "Kind | None", usual: Any) -> str:
    from vvdp.base.units import displayed

    if kind is None:
        return "{ ... }"
    example = f'"{kind.example}"'
    return f"{example} [{displayed(usual, kind)}]" if isinstance(usual, float) else example


def _program(program: "ProgramType") -> tuple[list[str], list[str], list[str]]:
    return (
        list(program.reading._fields),  # type: ignore[attr-defined]
        list(type(program.command)._fields),
        _values(program.settings) if program.settings else [],
    )
