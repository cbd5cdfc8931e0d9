"""`vvdp list`."""

from collections.abc import Iterator
from pathlib import Path


def systems() -> None:
    """List the shipped systems, and those in the current folder."""
    from vvdp.base.tables import parsed_table
    from vvdp.cli.screen import console, grid
    from vvdp.systems.system import shipped

    table = grid("system", "circuit", "title", title="Shipped systems")
    for name, text in shipped().items():
        content = parsed_table(text, name).content
        table.add_row(name, content["circuit"], content["title"])
    console().print(table)
    found = list(_own_systems(Path.cwd()))
    if found:
        table = grid("file", "circuit", "title", title="Systems in this folder")
        for row in found:
            table.add_row(*row)
        console().print(table)


def _own_systems(folder: Path) -> Iterator[tuple[str, str, str]]:
    """Name, circuit and title of every TOML file in `folder` that names a circuit of ours."""
    from vvdp.base.errors import ConfigError
    from vvdp.base.tables import read_table
    from vvdp.systems.benches import BENCHES

    for path in sorted(folder.glob("*.toml")):
        try:
            content = read_table(path).content
        except ConfigError:
            continue  # some other program's file, or broken; `vvdp show` says what is wrong with it
        circuit = content.get("circuit")
        if isinstance(circuit, str) and circuit in BENCHES:
            yield path.name, circuit, str(content.get("title", ""))
