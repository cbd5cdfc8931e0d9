"""`vvdp docs`."""

from pathlib import Path
from typing import Annotated

import typer

from vvdp.base.errors import VvdpError
from vvdp.cli.options import AsJson

SITE = Path(__file__).parents[1] / "site"
"""Where `make docs` builds the site, and where a wheel has it."""


def docs(
    only_path: Annotated[bool, typer.Option("--path", help="Print the path of the first page; open nothing.")] = False,
    json: AsJson = False,
) -> None:
    """Open the documentation in the browser.

    It is a folder of pages on this machine and needs no network. Where no browser starts, its path is printed.
    """
    import webbrowser

    from vvdp.cli.screen import print_json

    page = SITE / "index.html"
    if not page.is_file():
        raise VvdpError(f"{page}: no such file; `make docs` in a source checkout builds the documentation")
    if json:
        print_json({"page": str(page)})
    elif only_path or not webbrowser.open(page.as_uri()):
        typer.echo(page)
