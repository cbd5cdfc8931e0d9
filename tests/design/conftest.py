"""Systems that designs start from, and the command called in this process."""

from collections.abc import Callable
from pathlib import Path

import pytest

from vvdp.cli.main import main
from vvdp.systems.system import System


@pytest.fixture(scope="session")
def prototype(ideal_prototype: System) -> System:
    return ideal_prototype


@pytest.fixture
def designing(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable:
    """Runs `vvdp design` with the given arguments in an empty folder: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main(["design", *arguments])
        code = ended.value.code
        out, err = capsys.readouterr()
        return (code if isinstance(code, int) else 0), out, err

    return call


@pytest.fixture(scope="session")
def root_of_docs() -> Path:
    return Path(__file__).parents[2] / "docs"
