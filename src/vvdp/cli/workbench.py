"""`vvdp workbench`."""

import json as json_text
from pathlib import Path
from typing import Annotated

import typer

from vvdp.cli.options import AsJson


def workbench(
    path: Annotated[
        Path, typer.Argument(metavar="[PATH]", help="A system file, a result directory or a folder.")
    ] = Path(),
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port; 0 takes a free one.")] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Print the address; open nothing.")] = False,
    json: AsJson = False,
) -> None:
    """Open a page in the browser to change values and see curves.

    While a value is dragged the curves follow. This machine serves the page, for itself only. Ctrl-C ends it.
    """
    import webbrowser

    from vvdp.base.errors import VvdpError
    from vvdp.base.extras import require

    for module in ("starlette", "uvicorn", "websockets"):
        require(module, "workbench", "the workbench")
    from vvdp.workbench.guard import Guard
    from vvdp.workbench.offer import offer_at
    from vvdp.workbench.server import listening, serve

    offer = offer_at(path)
    try:
        place = listening(port)
    except OSError as problem:
        raise VvdpError(f"port {port}: {problem.strerror}; --port 0 takes a free one") from None
    guard = Guard(place.getsockname()[1])
    line = json_text.dumps({"url": guard.url, "port": guard.port, "token": guard.token}) if json else guard.url
    print(line, flush=True)
    if not no_browser and not json:
        webbrowser.open(guard.url)
    try:
        serve(offer, guard, place)
    except KeyboardInterrupt:
        raise typer.Exit(0) from None
