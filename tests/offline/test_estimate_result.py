"""The file of an estimation on a disk that fails: told as such at any moment, and HDF5 is none the wiser."""

import re
import resource

import h5py
import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import WriteError
from vvdp.offline import estimate_result
from vvdp.offline.estimate_result import Store, piece_rows

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
    with pytest.raises(WriteError, match=re.escape("result.h5: " + wording.files.cannot_write + " (File too large)")):
        fill(tmp_path / "result.h5")


def test_rows_that_nobody_wrote_are_nan(tmp_path):
    with Store(tmp_path / "a.h5") as store:
        store.columns("", NAMED, 3)
        store.append("", {"time": np.array([1.0, 2.0])})
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["time"][:], [np.nan, np.nan, np.nan, 1.0, 2.0], equal_nan=True)
        assert np.isnan(file["speed"][:]).all() and file["speed"].shape == (3,)


@pytest.mark.parametrize("at_once", [1, 2, 3, 100])
def test_pieces_are_found_wherever_the_portions_end(tmp_path, monkeypatch, at_once):
    monkeypatch.setattr(estimate_result, "AT_ONCE", at_once)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["edges/piece"] = np.array([1.0, 1.0, 1.0, 2.0, 4.0, 4.0])
        assert piece_rows(file, "edges/") == {1.0: (0, 3), 2.0: (3, 4), 4.0: (4, 6)}
        assert piece_rows(file, "") == {}
