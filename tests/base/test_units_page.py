"""The page on how values are written: its code runs and prints what stands there."""

import contextlib
import io
import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "units.md").read_text("utf-8")


def test_the_page_says_what_happens() -> None:
    names: dict[str, object] = {"__name__": "units_page"}
    for code, shown in re.findall(r"```python\n(.*?)```\n((?:\n    [^\n]+(?:\n    [^\n]+)*\n)?)", PAGE, re.DOTALL):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(compile(code, "units.md", "exec"), names)
        assert said.getvalue() == "".join(line[4:] + "\n" for line in shown.split("\n") if line)
