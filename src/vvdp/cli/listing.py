"""`vvdp list`."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from vvdp.cli.options import AsJson

if TYPE_CHECKING:
    from vvdp.systems.library_pages import Described, LibraryPage
    from vvdp.systems.part_files import PartFile


class Listed(NamedTuple):
    """Rows under a title, the name first in each; a cell is a text, or one with a line for each entry."""

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[Any, ...]]

    def having(self, words: Sequence[str]) -> "Listed":
        """The rows with one of `words` in their names."""
        return self._replace(rows=[row for row in self.rows if any(word in row[0] for word in words)])

    @property
    def entries(self) -> dict[str, Any]:
        """The rows by their first column, for a program."""
        return {name: dict(zip(self.columns[1:], cells, strict=True)) for name, *cells in self.rows}


def systems(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...",
            help="List only what has one of these in its name; describe the component or program of this name.",
        ),
    ] = None,
    components: Annotated[
        bool, typer.Option("--components", help="List the component library for drawing circuits.")
    ] = False,
    language: Annotated[
        bool, typer.Option("--language", help="List the functions that your own laws and programs may call.")
    ] = False,
    json: AsJson = False,
) -> None:
    """List systems and circuits, shipped and in this folder."""
    from vvdp.cli.library import pages_of
    from vvdp.cli.screen import print_json

    if language:
        _language(json)
        return
    listed = _system_lists() if words or not components else {}
    listed |= _library_lists() if words or components else {}
    chosen = _having(listed, words) if words else listed
    pages = pages_of(words or ())
    if json:
        print_json(
            {key: each.entries for key, each in chosen.items()} | {"described": [asdict(page) for page in pages]}
        )
        return
    if pages:
        _print_pages(pages, chosen, words or ())
        return
    for each in chosen.values():
        if each.rows:
            _print(each)
    if any(chosen[key].rows for key in LIBRARY if key in chosen):
        _print_hints()


def _print_pages(pages: "Sequence[LibraryPage]", chosen: Mapping[str, Listed], words: Sequence[str]) -> None:
    """Prints pages, then parts that are called the same, and other names with these letters."""
    from vvdp.cli.library import print_page

    for page in pages:
        print_page(page)
    parts = chosen["parts"]
    if named := [row for row in parts.rows if row[0] in words]:
        _print(parts._replace(rows=named))
    _name_others(chosen, {page.type for page in pages})


def _name_others(chosen: Mapping[str, Listed], shown: Collection[str]) -> None:
    """Line with the other names that contain one of the words."""
    from vvdp.cli.screen import tell

    others = dict.fromkeys(str(row[0]) for each in chosen.values() for row in each.rows if row[0] not in shown)
    if others:
        tell(f"\nOther names with these letters: {', '.join(others)}")


def _having(listed: Mapping[str, Listed], words: Sequence[str]) -> dict[str, Listed]:
    """The lists with only what has one of `words` in its name, or else in its description; ConfigError without any."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.tables import suggestion
    from vvdp.cli.library import descriptions

    chosen = {key: each.having(words) for key, each in listed.items()}
    if not any(each.rows for each in chosen.values()):
        described = {kind for kind, text in descriptions().items() if any(word.lower() in text for word in words)}
        rows = {key: [row for row in listed[key].rows if row[0] in described] for key in LIBRARY if key in listed}
        chosen = {key: listed[key]._replace(rows=found) for key, found in rows.items()}
    if not any(each.rows for each in chosen.values()):
        names = [row[0] for each in listed.values() for row in each.rows]
        message = "nothing has this in its name or description"
        raise ConfigError([Fault("list", 0, word, f"{message}{suggestion(word, names)}") for word in words])
    return chosen


def _language(json: bool) -> None:
    from vvdp.cli.screen import print_json
    from vvdp.generator.words import word_names

    names = word_names()
    if json:
        print_json({"functions": names})
    else:
        _print(Listed("Functions of the language", ("function",), [(name,) for name in names]))


def _print(listed: Listed) -> None:
    from vvdp.cli.screen import console, grid

    table = grid(*listed.columns, title=listed.title)
    for row in listed.rows:
        table.add_row(*(cell if isinstance(cell, str) else "\n".join(cell) for cell in row))
    console().print(table)


def _system_lists() -> dict[str, Listed]:
    """Systems and circuits, shipped and in this folder."""
    return {
        "systems": Listed("Shipped systems", ("system", "circuit", "title"), list(_shipped_systems("data"))),
        "practice": Listed(
            "Circuits from practice", ("system", "circuit", "title"), list(_shipped_systems("practice"))
        ),
        "measured": Listed("Measured rigs", ("system", "circuit", "title"), list(_shipped_systems("measured"))),
        "circuits": Listed("Circuits", ("circuit", "tables", "title"), list(_circuits())),
        "files": Listed("Systems in this folder", ("file", "circuit", "title"), list(_own_systems(Path.cwd()))),
    }


def _shipped_systems(group: str) -> Iterator[tuple[str, str, str]]:
    """Name, circuit and title of every shipped system of a group."""
    from vvdp.base.tables import parsed_table
    from vvdp.systems.system import shipped_systems

    for name, text in shipped_systems(group).items():
        content = parsed_table(text, name).content
        yield name, _circuit(content), str(content.get("title", ""))


def _circuit(content: Mapping[str, object]) -> str:
    return "drawn" if "nodes" in content else str(content.get("circuit", "drawn"))


def _circuits() -> Iterator[tuple[str, str, str]]:
    """Name, tables and first line of every circuit that an installed package offers."""
    from vvdp.systems.circuits import circuit_names, network_function, table_slots

    for name in circuit_names():
        try:
            function = network_function(name, Path())
            tables = ", ".join(f"[{key}]" if slot.optional else key for key, slot in table_slots(function).items())
        except Exception as problem:  # of someone else's package
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


LIBRARY = ("nodes", "components", "programs", "parts")


def _library_lists() -> dict[str, Listed]:
    """All that a file may draw a circuit from."""
    from vvdp.components.library import COMPONENTS
    from vvdp.programs.library import PROGRAMS
    from vvdp.systems.drawing import NODES
    from vvdp.systems.library_pages import library_page, value_lines
    from vvdp.systems.part_files import shipped_part, shipped_parts

    return {
        "nodes": Listed(
            "Nodes: [nodes] NAME = { type = ... }",
            ("type", "values"),
            [(name, value_lines(node.table)) for name, node in NODES.items()],
        ),
        "components": Listed(
            "Components: [components.NAME] with its type, the node at each port, inputs and values",
            ("type", "ports", "inputs", "values", "outputs", "symbol"),
            [(name, *_component(library_page(name)), part.symbol) for name, part in COMPONENTS.items()],
        ),
        "programs": Listed(
            "Programs: [programs.NAME] with its type, values and what it reads",
            ("type", "reads", "commands", "values"),
            [(name, *_program(library_page(name))) for name in PROGRAMS],
        ),
        "parts": Listed(
            "Parts: [parts.NAME] with its type, the node at each port, and values",
            ("type", "ports", "values", "title"),
            [(name, *_part(shipped_part(name))) for name in shipped_parts()],
        ),
    }


def _print_hints() -> None:
    """How the values of the library are written."""
    from vvdp.cli.library import INPUTS
    from vvdp.cli.screen import console

    out = console()
    out.print("Values are written with their unit, as in the examples; a value in brackets is the default.")
    out.print("Programs of any quantity take the units of their values from what they read; here of a pressure.")
    out.print(INPUTS)


def _component(page: "LibraryPage") -> Sequence[list[str]]:
    """Ports, inputs, values and outputs."""
    ports = [f"{port.name} {port.meaning}".strip() for port in page.ports]
    return ports, _lines(page.inputs), _lines(page.values), [each.name for each in page.outputs]


def _lines(values: Iterable["Described"]) -> list[str]:
    return [each.line for each in values]


def _program(page: "LibraryPage") -> Sequence[list[str]]:
    """The inputs, commands and values of a program."""
    reads = [f"{each.name} [{each.usual}]" if each.usual else each.name for each in page.inputs]
    return reads, [each.name for each in page.outputs], _lines(page.values)


def _part(part: "PartFile") -> tuple[list[str], list[str], str]:
    """Ports, values and title."""
    from vvdp.systems.part_offers import part_ports, part_values

    ports = [f"{port} ({what})" if what not in ("", "oil") else port for port, what in part_ports(part).items()]
    values = []
    for name, offered in part_values(part).items():
        default = f" [{offered.default}]" if offered.default else ""
        values.append(f'{name} = "{offered.kind.example}"{default}' if offered.kind else f"{name}{default}")
    return ports, values, str(part.table.content.get("title", part.name))
