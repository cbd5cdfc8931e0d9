"""The command line called in this process: exit code, stdout and stderr."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from vvdp.cli.main import main


class Answer(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def vvdp(capsys: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """Runs `vvdp` with the given arguments. Anything but an exit is an error of the program."""

    def call(*arguments: str) -> Answer:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main(list(arguments))
        code = ended.value.code
        out, err = capsys.readouterr()
        return Answer(code if isinstance(code, int) else 0, out, err)

    return call


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder as the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


VARYING = re.compile(
    r"\d+ steps in [\d.]+ s|in [\d.]+ s, 0 failed|-?\d\.\de-\d\d|t = [\d.]+ s|\(\d+ times\)|-\d{8}-\d{6}"
)
"""What need not come out alike on another machine."""


def _lines(text):
    """Lines without what varies, without the widths that follow from it, and without empty ones."""
    return [" ".join(VARYING.sub("~", line).split()) for line in text.splitlines() if line.strip()]


def _is_shown(shown, said):
    """Whether the lines of a page are those that were said, in order, with gaps only at "..."."""
    parts = [part.splitlines() for part in "\n".join(_lines(shown)).split("...")]
    at, found = 0, _lines(said)
    for number, part in enumerate(parts):
        part = [line for line in part if line]
        places = range(at, len(found)) if number else [0]
        begin = next((i for i in places if found[i : i + len(part)] == part), None)
        if begin is None:
            return False
        at = begin + len(part)
    return not parts[-1] or at == len(found)


def _changed(text: str, block: str) -> str:
    """`text` after a block of a page: tables and entries that it has already are replaced, others are added.

    A block of one line is an entry; any other consists of whole tables, or is the whole file.
    """
    if "\n" not in block.strip():
        key = block.partition(" = ")[0]
        changed, count = re.subn(rf"^{key} = .*$", lambda _: block.strip(), text, flags=re.MULTILINE)
        assert count == 1, block
        return changed
    for table in re.split(r"^(?=\[)", block, flags=re.MULTILINE):
        header = table.partition("\n")[0]
        before, found, after = text.partition(f"{header}\n") if header.startswith("[") else ("", "", "")
        if found:
            rest = re.search(r"^\[", after, re.MULTILINE)
            text = f"{before}{table.strip()}\n\n{after[rest.start() :] if rest else ''}"
        else:
            text += f"{table.strip()}\n\n"
    return text


@pytest.fixture
def is_shown() -> Callable[[str, str], bool]:
    """Whether a block of a page shows what was said, but for what varies, with gaps only at "..."."""
    return _is_shown


@pytest.fixture
def changed() -> Callable[[str, str], str]:
    """The text of a file after a block of a page that draws it step by step."""
    return _changed


def _run(directory: Path, name: str, settings: list[str]) -> Path:
    from vvdp.runs.simulate import run_system, save_run
    from vvdp.systems.system import load_system

    directory.mkdir()
    save_run(directory, run_system(load_system(name, settings, "0.1 s")))
    return directory


@pytest.fixture(scope="session")
def two_runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Result directories of two runs of the prototype: 1200 rpm at a duty ratio of 0.4, 1800 rpm at 0.6."""
    folder = tmp_path_factory.mktemp("runs")
    slow = _run(folder / "slow", "prototype", ["operation.pump_speed=1200 rpm", "operation.duty_ratio=0.4"])
    fast = _run(folder / "fast", "prototype", ["operation.pump_speed=1800 rpm", "operation.duty_ratio=0.6"])
    return slow, fast


@pytest.fixture(scope="session")
def other_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Result directory of a run of the buck converter."""
    return _run(tmp_path_factory.mktemp("other") / "buck", "buck-converter", [])
