"""What docs/logs.md shows about files is what happens."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "logs.md").read_text("utf-8")


def test_the_examples_on_files_run_as_shown(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    section = PAGE.partition("## Files that can be read")[2].partition("\n## ")[0]
    names: dict[str, object] = {}
    shown = re.findall(r"```python\n(.*?)```\n(?:\n((?:    [^\n]*\n)+))?", section, re.DOTALL)
    assert len(shown) >= 3
    for code, output in shown:
        exec(compile(code, "logs.md", "exec"), names)
        assert capsys.readouterr().out == "".join(line[4:] + "\n" for line in output.splitlines())
