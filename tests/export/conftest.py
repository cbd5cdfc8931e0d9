"""The folder of the binaries that these tests share."""

import os

import pytest
from tests.export.builds import FOLDERS


@pytest.fixture(scope="session", autouse=True)
def _binaries(tmp_path_factory: pytest.TempPathFactory) -> None:
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "fmu-binaries"
    folder.mkdir(exist_ok=True)
    FOLDERS.append(folder)
