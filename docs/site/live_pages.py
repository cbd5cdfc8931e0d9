"""Interactive pages of the site: circuits that the pages show, to be run in the reader's browser; made at each build.

A circuit of the gallery stands below its picture, any other where a page has `<!-- live: NAME -->`.
"""

import multiprocessing
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

DOCS = Path(__file__).parents[1]
FOLDER, ONLY = "live", "VVDP_LIVE_PAGES"
"""Where the pages lie below the site; names of those that are made where not all are wanted."""
LEFT_OUT = {"displacement-control", "displacement-control-gerotor"}
"""Systems whose runs are so long that their pages would exceed 1 MB."""
PLACE = re.compile(
    r"!\[Circuit of (?P<shown>[\w-]+)\]\(images/systems/(?P=shown)\.svg\)|<!-- live: (?P<named>[\w.-]+) -->"
)
FILE = re.compile(r"`(\w+\.toml)`:\n\n```toml\n(.*?)```\n", re.DOTALL)
"""A whole system file in a page, under its name."""
FRAME = """{before}
<details class="live"><summary>Run this circuit here</summary>
<iframe src="{up}{folder}/{name}.html" loading="lazy" title="{name}, interactive"></iframe>
<p><a href="{up}{folder}/{name}.html">The page by itself</a></p></details>
"""


def names() -> list[str]:
    """The circuits that the pages show: shipped systems, and files that a page writes out."""
    found = {name for page in DOCS.rglob("*.md") for name in _named(page.read_text("utf-8"))}
    only = os.environ.get(ONLY)
    return sorted(found.intersection(only.split(",")) if only else found)


def _named(markdown: str) -> Iterator[str]:
    for place in PLACE.finditer(markdown):
        if place["shown"] not in LEFT_OUT:
            yield place["shown"] or place["named"]


def with_frames(markdown: str, path: str) -> str:
    """The text of a page with a frame for each circuit; `path` is where the page lies below the site."""
    up = "../" * path.count("/")

    def frame(place: re.Match[str]) -> str:
        name = place["shown"] or place["named"]
        if place["shown"] in LEFT_OUT:
            return place[0]
        return FRAME.format(before=place[0] if place["shown"] else "", up=up, folder=FOLDER, name=name)

    return PLACE.sub(frame, markdown)


def pages() -> Iterator[tuple[str, str]]:
    """Path below the site and text of each interactive page; as many at once as there are processors."""
    files = {name: text for page in DOCS.glob("*.md") for name, text in FILE.findall(page.read_text("utf-8"))}
    shown = names()
    sys.path.insert(0, str(Path(__file__).parent))  # MkDocs takes it off; the processes look for this module there
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as processes:
        for name, text in zip(shown, processes.map(_page, shown, map(files.get, shown)), strict=True):
            yield f"{FOLDER}/{name}.html", text


def _page(name: str, text: str | None) -> str:
    """The page of a shipped system, or of the file with this text."""
    from vvdp.systems.system import load_system
    from vvdp.web.page import web_page

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / name
        if text is not None:
            file.write_text(text, "utf-8")
        return web_page(load_system(name if text is None else str(file)), f"vvdp run {name}").html
