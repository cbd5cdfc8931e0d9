"""docs/programs.md: its table is that of the library, its example runs and gives the numbers of the page."""

import re
from pathlib import Path

from vvdp.programs.generic import GenericProgram
from vvdp.programs.library import PROGRAMS
from vvdp.systems.library_pages import library_page

PAGE = (Path(__file__).parents[2] / "docs" / "programs.md").read_text("utf-8")


def row(name, program):
    own = program.type if isinstance(program, GenericProgram) else program
    page = library_page(name)
    reads = [f"({each.name})" if each.name in own.defaults else each.name for each in page.inputs]
    does = re.split(r"[.;:]( |\n|$)", page.description, maxsplit=1)[0].replace("\n", " ").strip()
    values = [
        f"`{each.name}` {each.example.replace(chr(34), '')}" + (f" ({each.usual})" if each.usual else "")
        for each in page.values
        if "." not in each.name
    ]
    tables = dict.fromkeys(each.name.partition(".")[0] for each in page.values if "." in each.name)
    values += [f"`[{table}]`" for table in tables]
    cells = [does, ", ".join(reads), ", ".join(type(own.command)._fields), ", ".join(values)]
    return re.sub(" +", " ", f"| `{name}` | " + " | ".join(cells) + " |")


def test_the_table_is_that_of_the_library():
    found = re.findall(r"^\|---.*\n((?:\|.*\n)+)", PAGE, re.MULTILINE)[0].splitlines()
    assert found == [row(name, program) for name, program in PROGRAMS.items()]


def test_the_python_of_the_page_runs():
    left = {}
    exec(re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1], left)
    assert left["settings"].highest == 1.0 and left["kind"].defaults == {"feedforward": 0.0}


def test_the_example_runs(tmp_path, monkeypatch, capsys):
    from vvdp.cli.main import main

    (tmp_path / "hold.toml").write_text(re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1])
    monkeypatch.chdir(tmp_path)
    try:
        main(["run", "hold.toml", "--no-report"])
    except SystemExit as ended:
        assert not ended.code
    printed = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    shown = re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1].splitlines()
    assert shown and {" ".join(line.split()) for line in shown} <= set(printed)
