"""docs/programs.md: its table is that of the library, its example runs and gives the numbers of the page."""

import re
from pathlib import Path
from typing import get_origin

from vvdp.base.display import value_text
from vvdp.base.params import default_values, field_kinds, field_types
from vvdp.programs.generic import GenericProgram
from vvdp.programs.library import PROGRAMS
from vvdp.programs.quantities import LARGEST

PAGE = (Path(__file__).parents[2] / "docs" / "programs.md").read_text("utf-8")


def values(cls):
    """Each value with an example, and with the one that holds where none is given."""
    usual = default_values(cls) if cls else {}
    for name, kind in field_kinds(cls).items() if cls else ():
        value = usual.get(name)
        shown = "none" if value in (-LARGEST, LARGEST) else value_text(value, kind) if isinstance(value, float) else ""
        example = f"[{kind.example}, ...]" if get_origin(field_types(cls)[name]) is tuple else kind.example
        yield f"`{name}` {example}" + (f" ({shown})" if shown else "")


def row(name, program):
    own = program.type if isinstance(program, GenericProgram) else program
    reads = [f"({each})" if each in own.defaults else each for each in own.reading._fields if each != "time"]
    does = re.split(r"[.;:]( |\n|$)", own.step.__doc__, maxsplit=1)[0].replace("\n    ", " ").strip()
    cells = [does, ", ".join(reads), ", ".join(type(own.command)._fields), ", ".join(values(own.settings))]
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
