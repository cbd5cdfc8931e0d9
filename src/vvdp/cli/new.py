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
            help="The shipped system, component, program or TOML file to copy; of a component its example.",
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
    from vvdp.systems.library_examples import example_text
    from vvdp.systems.part_files import shipped_parts
    from vvdp.systems.system import load_system, shipped_systems, source_text

    parts = shipped_parts()
    shown = parts.get(source) or (None if source in shipped_systems() else example_text(source))
    if shown is None:
        load_system(source)  # a copy of something broken helps no one
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not path.stem.isprintable() or path.name == ".toml":
        raise unusable(path, "is no name for a system; use letters, digits and hyphens")
    text = shown or source_text(source)
    copied = _copied_parts(text, Path(source).parent, path.parent, force=force)
    write_new(path, _with_title(text, path.stem), force=force)
    if json:
        print_json({"system": path.stem, "out": str(path), "parts": [str(each) for each in copied]})
    elif source in parts:
        typer.echo(f'{path} written; use it in a circuit: [parts.NAME] file = "{path}"')
    else:
        beside = f" with {', '.join(map(str, copied))}" if copied else ""
        typer.echo(f"{path} written{beside}; run it with: vvdp run {path}")


def _copied_parts(text: str, folder: Path, target: Path, *, force: bool) -> list[Path]:
    """The files of parts that the text of a system in `folder` needs, copied to where one in `target` finds them."""
    from vvdp.base.tables import parsed_table, write_new
    from vvdp.systems.part_files import used_files

    found = []
    for named, path in dict(used_files(parsed_table(text, str(folder)).content, folder)).items():
        copy = target / named
        if copy.resolve() != path.resolve():
            copy.parent.mkdir(parents=True, exist_ok=True)
            write_new(copy, path.read_text("utf-8"), force=force)
            found.append(copy)
    return found


def _with_title(text: str, title: str) -> str:
    """`text` of a system with another title; unchanged where its title takes several lines."""
    from vvdp.base.tables import parsed_table

    quoted = title.replace("\\", "\\\\").replace('"', '\\"')
    line = f'title = "{quoted}"'
    if "title" not in parsed_table(text, title).content:
        return f"{line}\n{text}"
    return re.sub(_TITLE_LINE, lambda _: line, text, count=1)
