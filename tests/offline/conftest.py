"""Estimations of logs that a test makes."""

import h5py
import pytest
from tests.offline.records import Kept

from vvdp.offline.config import Option, load_estimation
from vvdp.offline.estimate import estimate, open_for_estimate


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
