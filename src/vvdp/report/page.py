"""A report's page and the files of its figures."""

from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from types import MappingProxyType

from vvdp.base.files import clear_unfinished, write_whole
from vvdp.report.drawing import Drawn

NAME = "report.html"


def opening(title: str, style: str = "", head: str = "") -> str:
    """The beginning of a page up to its body; `title` and `head` are ready HTML, `style` adds to that of all."""
    common = resources.files("vvdp.report").joinpath("style.css").read_text("utf-8")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n{head}<title>{title}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>\n{common}{style}</style>\n</head>\n<body>"
    )


def write_page(
    directory: Path, lines: Iterable[str], drawn: Sequence[Drawn], more: Mapping[str, str] = MappingProxyType({})
) -> Path:
    """Writes report.html and figures/ into `directory` and gives the path of the page.

    `more` are further SVG figures by name. Pictures of an earlier page that are no longer drawn are taken away.
    """
    page = "\n".join(lines) + "\n"
    folder = directory / "figures"
    folder.mkdir(exist_ok=True)
    for place in (directory, folder):
        clear_unfinished(place)
    files = {f"{name}.svg": svg.encode() for name, svg in more.items()}
    files |= {f"{each.name}.svg": each.svg.encode() for each in drawn}
    for stale in sorted(folder.iterdir()):
        if stale.name not in files and stale.suffix in (".svg", ".png"):
            stale.unlink()
    for name, content in files.items():
        write_whole(folder / name, content)
    write_whole(directory / NAME, page)
    return directory / NAME
