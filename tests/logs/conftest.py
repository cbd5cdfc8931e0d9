"""Samples for the readers of logs, files that others wrote, fetched and never kept in the repository."""

import os
import subprocess
import sys
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def sample_files(request, not_tested) -> Callable[[str, str, str], Path]:
    """Unpacks what ends in `suffix` of a source distribution into the cache of pytest: `(name, version, suffix)`."""

    def folder(name: str, version: str, suffix: str) -> Path:
        place = Path(request.config.cache.mkdir(f"{name}-{version}"))
        if not any(place.glob(f"*{suffix}")):
            command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--no-binary", ":all:"]
            try:
                subprocess.run(
                    [*command, "--dest", str(place), f"{name}=={version}"],
                    check=True, capture_output=True, timeout=300, env={**os.environ, "PIP_NO_INPUT": "1"},
                )  # fmt: skip
            except (subprocess.SubprocessError, OSError):
                not_tested(f"samples of {name} {version} could not be fetched", "samples")
            (archive,) = place.glob("*.tar.gz")
            with tarfile.open(archive) as packed:
                for member in packed:
                    if member.name.endswith(suffix) and (content := packed.extractfile(member)):
                        (place / Path(member.name).name).write_bytes(content.read())
            archive.unlink()
        return place

    return folder
