"""`vvdp new`."""

import re
from pathlib import Path
from typing import Annotated

import typer

from vvdp.cli.completion import system_names
from vvdp.cli.options import AsJson, Force

_TITLE_LINE = re.compile(r"""^[ \t]*title[ \t]*=[ \t]*(?:"(?:[^"\\\n]|\\.)+"|'[^'\n]+')""", re.MULTILINE)


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new system, written to NAME.toml.")],
    source: Annotated[
        str,
        typer.Option(
            "--from",
            metavar="SYSTEM",
            help="The shipped system or TOML file to copy.",
            autocompletion=system_names,
        ),
    ],
    force: Force = False,
    json: AsJson = False,
) -> None:
    """Write a system file of your own, a copy of another."""
    from vvdp.base.errors import unusable
    from vvdp.base.tables import write_new
    from vvdp.cli.screen import print_json
    from vvdp.systems.system import load_system, source_text

    load_system(source)  # a copy of something broken helps nobody
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not path.stem.isprintable() or path.name == ".toml":
        raise unusable(path, "is no name for a system; use letters, digits and hyphens")
    text = _with_title(source_text(source), path.stem)
    write_new(path, text, force=force)
    if json:
        print_json({"system": path.stem, "out": str(path)})
    else:
        typer.echo(f"{path} written; run it with: vvdp run {path}")


def _with_title(text: str, title: str) -> str:
    """`text` of a system with another title; unchanged where its title takes several lines."""
    from vvdp.base.tables import parsed_table

    quoted = title.replace("\\", "\\\\").replace('"', '\\"')
    line = f'title = "{quoted}"'
    if "title" not in parsed_table(text, title).content:
        return f"{line}\n{text}"
    return re.sub(_TITLE_LINE, lambda _: line, text, count=1)
