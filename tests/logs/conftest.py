"""Samples for the readers of logs, files that others wrote, fetched and never kept in the repository; estimations."""

import os
import subprocess
import sys
import tarfile
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
from tests.logs.records import Kept

from vvdp.logs.config import Option, load_estimation
from vvdp.logs.estimate import estimate, open_for_estimate


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


@pytest.fixture
def estimated(tmp_path):
    """Writes channels (name: values, unit, and the sample rate of those without a clock beside them) to a file, runs an
    estimation with a wheel of 8 sectors unless told otherwise, and gives what it kept."""

    def run(channels, progress=lambda done: None, **keys):
        if not keys.keys() & {"sensor__sectors", "sensor__widths"}:
            keys["sensor__sectors"] = 8
        keys = {key: value for key, value in keys.items() if value is not None}
        path = tmp_path / "log.h5"
        with h5py.File(path, "w") as file:
            for name, (values, unit, *rate) in channels.items():
                file[name] = values
                file[name].attrs["units"] = unit
                if rate:
                    file[name].attrs["sample_rate"] = rate[0]
        wanted = load_estimation(None, [Option(key.replace("__", "."), key, value) for key, value in keys.items()])
        folder = tmp_path / f"out{len(list(tmp_path.glob('out*')))}"
        folder.mkdir()
        with open_for_estimate(path, wanted) as log:
            estimate(log, wanted, folder, progress=progress)
        return Kept(folder)

    return run
