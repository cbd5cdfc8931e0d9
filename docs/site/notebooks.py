"""Makes notebooks of the scripts beside them, with what they print and draw. `python docs/site/notebooks.py`

A script is plain Python; `# %%` begins a cell of it, `# %% [markdown]` one of text in comments. Cells run as a
script, so no Jupyter is needed; in Jupyter the notebook runs as well, and looks the same.
"""

import ast
import base64
import contextlib
import io
import json
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vvdp.generator.source import known_text

FOLDER = Path(__file__).parents[1] / "notebooks"
Cell = dict[str, Any]
Output = dict[str, Any]
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def main(folder: Path = FOLDER) -> None:
    """Runs every script in `folder` and writes a notebook with its outputs beside it."""
    for path in sorted(folder.glob("*.py")):
        cells = script_cells(path.read_text("utf-8"))
        with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
            outputs = run(cells)
        for cell, made in zip(cells, outputs, strict=True):
            if cell["cell_type"] == "code":
                cell["outputs"] = made
        notebook = {"cells": cells, "metadata": METADATA, "nbformat": 4, "nbformat_minor": 5}
        path.with_suffix(".ipynb").write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", "utf-8")


def script_cells(text: str) -> list[Cell]:
    """The cells of a script, without outputs."""
    marks = re.split(r"(?m)^# %%( \[markdown\])?\n", text)[1:]
    return [
        _cell(number, bool(mark), body.strip("\n"))
        for number, (mark, body) in enumerate(zip(marks[::2], marks[1::2], strict=True))
    ]


def _cell(number: int, is_text: bool, body: str) -> Cell:
    if is_text:
        body = re.sub(r"(?m)^# ?", "", body)
    source = body.splitlines(keepends=True)
    if is_text:
        return {"cell_type": "markdown", "id": f"cell-{number}", "metadata": {}, "source": source}
    code = {"cell_type": "code", "execution_count": None, "id": f"cell-{number}", "metadata": {}}
    return {**code, "outputs": [], "source": source}


def read(path: Path) -> dict[str, Any]:
    """A notebook as its file holds it."""
    notebook: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return notebook


def run(cells: list[Cell]) -> list[list[Output]]:
    """The outputs of each cell, all run one after the other as one program. Raises what a cell raises."""
    os.environ["MPLBACKEND"] = "Agg"
    names: dict[str, Any] = {"__name__": "__main__"}
    return [_outputs("".join(cell["source"]), names) if cell["cell_type"] == "code" else [] for cell in cells]


def _outputs(source: str, names: dict[str, Any]) -> list[Output]:
    """What a cell prints, what it draws, and the value of its last line."""
    tree, file = ast.parse(source), known_text(source, "cell")
    last = ast.Expression(tree.body.pop().value) if tree.body and isinstance(tree.body[-1], ast.Expr) else None  # type: ignore[attr-defined]
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, file, "exec"), names)
        value = eval(compile(last, file, "eval"), names) if last else None
    outputs: list[Output] = []
    if printed.getvalue():
        outputs.append(
            {"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(keepends=True)}
        )
    outputs.extend(_pictures())
    if value is not None:
        outputs.append({"output_type": "execute_result", "execution_count": None, "metadata": {}, "data": _data(value)})
    return outputs


def _pictures() -> Iterator[Output]:
    """The figures that are open, which are closed."""
    import matplotlib.pyplot as plt

    for number in plt.get_fignums():
        yield {"output_type": "display_data", "metadata": {}, "data": _picture(plt.figure(number))}
        plt.close(number)


def _picture(figure: Any) -> dict[str, Any]:
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=80, metadata={"Software": None})
    return {"image/png": base64.b64encode(out.getvalue()).decode("ascii"), "text/plain": ["<Figure>"]}


def _data(value: object) -> dict[str, Any]:
    from matplotlib.figure import Figure

    if isinstance(value, Figure):
        return _picture(value)
    data = {"text/plain": repr(value).splitlines(keepends=True)}
    if hasattr(value, "_repr_html_"):
        kept = re.sub(r"<iframe.*?</iframe>", "", value._repr_html_(), flags=re.DOTALL)  # live charts: 200 kB each
        data["text/html"] = kept.splitlines(keepends=True)
    return data


def pages(folder: Path = FOLDER) -> dict[str, str]:
    """The text of a page for each notebook in `folder`, by its path in the site."""
    return {f"notebooks/{path.stem}.md": page(path) for path in sorted(folder.glob("*.ipynb"))}


def page(path: Path) -> str:
    """One notebook as Markdown, its pictures inside."""
    return "\n\n".join(part for cell in read(path)["cells"] for part in _parts(cell)) + "\n"


def _parts(cell: Cell) -> list[str]:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return [source]
    return [f"```python\n{source}\n```", *(_shown(output) for output in cell["outputs"])]


def _shown(output: Output) -> str:
    data = output.get("data", {"text/plain": output.get("text", [])})
    if "image/png" in data:
        picture = "".join(data["image/png"]).strip()
        return f'<img alt="Drawn by the cell above" src="data:image/png;base64,{picture}">'
    if "text/html" in data:
        return "<div>\n" + "".join(data["text/html"]) + "\n</div>"
    return "```text\n" + "".join(data["text/plain"]).rstrip() + "\n```"


if __name__ == "__main__":
    main()
