"""Notebooks as pages: their text, their code, and what it printed when the notebook was last run."""

import json
from pathlib import Path
from typing import Any


def pages(folder: Path) -> dict[str, str]:
    """The text of a page for each notebook in `folder`, by its path in the site."""
    return {f"notebooks/{path.stem}.md": page(path) for path in sorted(folder.glob("*.ipynb"))}


def page(path: Path) -> str:
    """One notebook as Markdown, its pictures inside."""
    cells = json.loads(path.read_text("utf-8"))["cells"]
    return "\n\n".join(part for cell in cells for part in _parts(cell)) + "\n"


def _parts(cell: dict[str, Any]) -> list[str]:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return [source]
    return [f"```python\n{source}\n```", *(_output(output) for output in cell["outputs"])]


def _output(output: dict[str, Any]) -> str:
    data = output.get("data", {"text/plain": output.get("text", [])})
    if "image/png" in data:
        return f'<img alt="output of the cell above" src="data:image/png;base64,{"".join(data["image/png"]).strip()}">'
    if "text/html" in data:
        return "<div>\n" + "".join(data["text/html"]) + "\n</div>"
    return "```text\n" + "".join(data["text/plain"]).rstrip() + "\n```"
