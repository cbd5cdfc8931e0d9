"""A report's page and the files of its figures."""

from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from types import MappingProxyType

from vvdp.base.files import clear_unfinished, discard, write_listed, write_whole
from vvdp.base.manifest import read_list
from vvdp.report.drawing import Drawn

NAME, FIGURES = "report.html", "figures"


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

    `more` are further SVG figures by name. Pictures of an earlier page that are no longer drawn are taken away, as far
    as vvdp has drawn them and they are as it left them. Raises ConfigError where a link, or a file that vvdp did not
    write, stands where the page or a figure belongs.
    """
    page = "\n".join(lines) + "\n"
    files = {f"{FIGURES}/{name}.svg": svg.encode() for name, svg in more.items()}
    files |= {f"{FIGURES}/{each.name}.svg": each.svg.encode() for each in drawn}
    stale = [name for name in read_list(directory) if name.startswith(f"{FIGURES}/") and name not in files]
    with write_listed(directory, [*files, NAME], pages=True):
        for place in (directory, directory / FIGURES):
            clear_unfinished(place)
        for name, content in files.items():
            write_whole(directory / name, content)
        write_whole(directory / NAME, page)
    discard(directory, stale)
    return directory / NAME
