"""`vvdp docs`."""

from pathlib import Path
from typing import Annotated

import typer

from vvdp.base.errors import VvdpError
from vvdp.cli.options import AsJson

SITE = Path(__file__).parents[1] / "site"
"""Where `make docs` builds the site, and where a wheel has it."""


def docs(
    word: Annotated[
        str, typer.Argument(metavar="[TYPE]", help="Open the page of this component or program.", show_default=False)
    ] = "",
    only_path: Annotated[bool, typer.Option("--path", help="Print the path of the first page; open nothing.")] = False,
    json: AsJson = False,
) -> None:
    """Open the documentation in the browser.

    It is a folder of pages on this machine and needs no network. Where no browser starts, its path is printed.
    """
    import webbrowser

    from vvdp.cli.screen import print_json

    page = SITE / (_page_of(word) if word else "index.html")
    if not page.is_file():
        raise VvdpError(f"{page}: no such file; `make docs` in a source checkout builds the documentation")
    if json:
        print_json({"page": str(page)})
    elif only_path or not webbrowser.open(page.as_uri()):
        typer.echo(page)


def _page_of(word: str) -> str:
    """Where the site has the page of a component or program. Raises ConfigError where there is none."""
    from vvdp.base.errors import unusable
    from vvdp.base.tables import suggestion
    from vvdp.components.library import COMPONENTS
    from vvdp.programs.library import PROGRAMS

    for folder, library in (("components", COMPONENTS), ("programs", PROGRAMS)):
        if word in library:
            return f"reference/{folder}/{word}.html"
    raise unusable(word, f"is no component or program{suggestion(word, [*COMPONENTS, *PROGRAMS])}")
