"""TDMS files that LabVIEW and NI-DAQmx wrote: what the library makes of them whole is what comes out in portions."""

import numpy as np
import pytest

from vvdp.logs.source import open_log

FILES = ["Digital_Input.tdms", "raw1.tdms", "big_endian.tdms", "raw_timestamps.tdms"]


@pytest.fixture(scope="module")
def folder(sample_files):
    return sample_files("nptdms", "1.13.0", ".tdms")


@pytest.mark.parametrize("name", FILES)
def test_portions_are_the_whole(folder, name):
    import nptdms

    with nptdms.TdmsFile.open(folder / name) as reference, open_log(folder / name) as log:
        channels = {f"{g.name}/{c.name}": c for g in reference.groups() for c in g.channels()}
        assert len(log.channels()) == len(channels) > 0
        for info in log.channels():
            full = info.name if info.name in channels else f"{info.group}/{info.name}"
            expected = channels[full]
            parts = [part[info.name] for part in log.portions([info.name], 117)]
            assert np.array_equal(np.concatenate([p.values for p in parts]), expected[:])
            times = np.concatenate([p.times for p in parts])
            assert np.allclose(times, np.arange(len(expected)) * expected.properties["wf_increment"], rtol=1e-14)


def test_a_digital_line_of_daqmx(folder):
    """20 000 samples at 2 kHz and two decimated copies; the same name in three groups is told apart."""
    with open_log(folder / "Digital_Input.tdms") as log:
        assert [info.samples for info in log.channels()] == [20_000, 400, 8]
        first = log.channels()[0]
        assert first.name == f"{first.group}/Dev1_port3_line7 - line 0"
        part = next(iter(log.portions([first.name], 20_000)))[first.name]
    assert part.times[-1] == pytest.approx(19_999 * 0.0005)
    assert set(np.unique(part.values)) <= {0.0, 1.0}


def test_scaled_values_and_units_of_labview(folder):
    with open_log(folder / "raw1.tdms") as log:
        assert {info.unit for info in log.channels()} == {"Volts"}
        part = next(iter(log.portions(["First  Channel"], 5000)))["First  Channel"]
    assert part.times[1] == pytest.approx(2e-5)
    # Unscaled integers times a slope: all values are multiples of it.
    ratio = part.values / 0.0003051850947599719
    assert np.allclose(ratio, np.round(ratio), rtol=0, atol=1e-6) and np.ptp(ratio) > 10
