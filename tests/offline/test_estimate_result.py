"""The file of an estimation on a disk that fails: told as such at any moment, and HDF5 is none the wiser."""

import resource

import h5py
import numpy as np
import pytest

from vvdp.base.errors import WriteError
from vvdp.offline import estimate_result
from vvdp.offline.estimate_result import Store

NAMED = {"time": ("s", "time"), "speed": ("rad/s", "spool speed")}
ROWS = 40_000


@pytest.fixture
def small_files():
    """Has every file of this process end at so many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def fill(path):
    rows = np.random.default_rng(1).normal(size=(2, ROWS))
    with Store(path) as store:
        store.columns("", NAMED)
        for part in np.split(rows, 8, axis=1):
            store.append("", {"time": part[0], "speed": part[1]})
    return rows


def test_rows_come_back_as_they_were_appended(tmp_path, monkeypatch):
    monkeypatch.setattr(estimate_result, "ROWS_IN_CHUNK", 4096)
    rows = fill(tmp_path / "result.h5")
    with h5py.File(tmp_path / "result.h5") as file:
        assert np.array_equal([file["time"][:], file["speed"][:]], rows)
        assert file["speed"].attrs["units"] == "rad/s"
    assert [path.name for path in tmp_path.iterdir()] == ["result.h5"]


@pytest.mark.parametrize("size", [0, 90, 2000, 5000, 40_000, 100_000, 300_000, 600_000])
def test_a_disk_that_fails_after_any_number_of_bytes_is_told(tmp_path, monkeypatch, small_files, size):
    monkeypatch.setattr(estimate_result, "ROWS_IN_CHUNK", 4096)
    small_files(size)
    with pytest.raises(WriteError, match=r"result\.h5: cannot be written \(File too large\)"):
        fill(tmp_path / "result.h5")
