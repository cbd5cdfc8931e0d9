"""The same data in every format come out the same; every channel keeps its clock; what is wrong is said clearly."""

import re
import subprocess
import sys
from collections import defaultdict

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.extras import MissingExtraError
from vvdp.base.kinds import PRESSURE_LEVEL, SPEED
from vvdp.logs.quantity import to_si
from vvdp.logs.source import open_log

RATE = 1e4
N = 1000


@pytest.fixture(scope="module")
def data():
    random = np.random.default_rng(3)
    times = np.arange(N) * 1e-4
    return times, {"v": random.normal(size=N), "w": random.normal(size=N) * 1e5}


UNITS = defaultdict(str, {"v": "V", "w": "bar"})


def write_csv(path, times, channels):
    rows = zip(times.tolist(), *(values.tolist() for values in channels.values()), strict=True)
    heading = ",".join(["time [s]", *(f"{name} [{UNITS[name]}]" for name in channels)])
    path.write_text("\n".join([heading, *(",".join(map(repr, row)) for row in rows)]) + "\n")


def write_semicolons(path, times, channels):
    rows = zip(times.tolist(), *(values.tolist() for values in channels.values()), strict=True)
    lines = [";".join(map(repr, row)).replace(".", ",") for row in rows]
    path.write_text("\n".join(["Zeit;" + ";".join(channels), "s;" + ";".join(UNITS.values()), *lines]) + "\n")


def write_tdms(path, times, channels, split=300):
    import nptdms

    with nptdms.TdmsWriter(path) as file:
        for begin in range(0, times.size, split):
            part = slice(begin, begin + split)
            file.write_segment(
                [
                    nptdms.ChannelObject("g", name, values[part], {"wf_increment": 1e-4, "unit_string": UNITS[name]})
                    for name, values in channels.items()
                ]
            )


def write_tdms_with_times(path, times, channels):
    import nptdms

    with nptdms.TdmsWriter(path) as file:
        file.write_segment(
            [nptdms.ChannelObject("g", "Time", times, {"unit_string": "s"})]
            + [nptdms.ChannelObject("g", name, x, {"unit_string": UNITS[name]}) for name, x in channels.items()]
        )


def write_mdf(path, times, channels, compression=0):
    import asammdf

    with asammdf.MDF() as file:
        file.append([asammdf.Signal(x, times, unit=UNITS[name], name=name) for name, x in channels.items()])
        file.save(path, overwrite=True, compression=compression)


def write_packed_mdf(path, times, channels):
    write_mdf(path, times, channels, compression=2)


def write_old_mdf(path, times, channels):
    import asammdf

    with asammdf.MDF(version="3.30") as file:
        file.append([asammdf.Signal(x, times, unit=UNITS[name], name=name) for name, x in channels.items()])
        file.save(path, overwrite=True)


def write_mat(path, times, channels):
    import scipy.io

    scipy.io.savemat(path, {"time": times, **channels})


def write_mat_struct(path, times, channels):
    import scipy.io

    scipy.io.savemat(path, {"log": {"t": times[:, None], **{k: x[:, None] for k, x in channels.items()}}})


def write_mat73(path, times, channels):
    """As MATLAB writes it: a block of 512 bytes before, column vectors as one row, classes as attributes."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"time": times, **channels}.items():
            file.create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_("double")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as file:
        file.write(head)


def write_hdf5(path, times, channels):
    import h5py

    with h5py.File(path, "w") as file:
        file["time"] = times
        file["time"].attrs["units"] = "s"
        for name, values in channels.items():
            file.create_dataset(name, data=values, chunks=(128,), compression="gzip").attrs["units"] = UNITS[name]


def write_hdf5_rate(path, times, channels):
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in channels.items():
            file[name] = values
            file[name].attrs.update({"dt": 1e-4, "unit": UNITS[name]})


def write_parquet(path, times, channels):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {"time [s]": times, **{f"{name} [{UNITS[name]}]": values for name, values in channels.items()}}
    pq.write_table(pa.table(columns), path, row_group_size=300)


WRITERS = [
    ("a.csv", write_csv), ("b.csv", write_semicolons), ("a.tdms", write_tdms), ("b.tdms", write_tdms_with_times),
    ("a.mf4", write_mdf), ("b.mf4", write_packed_mdf), ("a.mdf", write_old_mdf), ("a.mat", write_mat),
    ("b.mat", write_mat_struct), ("c.mat", write_mat73), ("a.h5", write_hdf5), ("b.h5", write_hdf5_rate),
    ("a.parquet", write_parquet),
]  # fmt: skip


def read(log, names, samples=128):
    """All portions joined: times and values by name, and the sizes of the portions."""
    parts = list(log.portions(names, samples))
    joined = {
        name: (np.concatenate([p[name].times for p in parts]), np.concatenate([p[name].values for p in parts]))
        for name in names
    }
    return joined, [max(portion.values.size for portion in p.values()) for p in parts]


@pytest.mark.parametrize(("name", "write"), WRITERS, ids=[f"{w.__name__}" for _, w in WRITERS])
def test_every_format_gives_the_same_to_the_last_bit(tmp_path, data, name, write):
    times, channels = data
    write(tmp_path / name, times, channels)
    with open_log(tmp_path / name) as log:
        found, sizes = read(log, ["w", "v"])
        for channel, values in channels.items():
            assert np.array_equal(found[channel][0], times)
            assert np.array_equal(found[channel][1], values)
        assert log.done == 1.0
        assert len(sizes) >= 5 and max(sizes) <= 260
        if not name.endswith(".mat"):
            assert {info.name: info.unit for info in log.channels()}["w"] == "bar"
        again, _ = read(log, ["v"], 10 * N)
        assert np.array_equal(again["v"][1], channels["v"])


def test_progress_rises_to_one(tmp_path, data):
    times, channels = data
    for name, write in (("a.csv", write_csv), ("a.tdms", write_tdms), ("a.parquet", write_parquet)):
        write(tmp_path / name, times, channels)
        with open_log(tmp_path / name) as log:
            done = [log.done for _ in log.portions(["v"], 300)]
        assert done == sorted(done) and 0 < done[0] < 1 and done[-1] == pytest.approx(1.0)


def two_rates_tdms(path):
    import nptdms

    start = np.datetime64("2024-05-01T12:00:00.900000")
    with nptdms.TdmsWriter(path) as file:
        fast = {"wf_increment": 0.001, "wf_start_time": start}
        slow = {"wf_increment": 0.01, "wf_start_time": start + np.timedelta64(250, "ms"), "wf_start_offset": 0.5}
        file.write_segment([nptdms.ChannelObject("g", "fast", np.arange(500.0), fast)])
        file.write_segment([nptdms.ChannelObject("h", "slow", np.arange(50.0), slow)])
    # 0.25 s later by the start, and half a second by the offset.
    return 0.75 + 0.01 * np.arange(50)


def two_rates_mdf(path):
    import asammdf

    slow = 0.75 + 0.01 * np.arange(50)
    with asammdf.MDF() as file:
        file.append(asammdf.Signal(np.arange(500.0), 0.001 * np.arange(500), name="fast"))
        file.append(asammdf.Signal(np.arange(50.0), slow, name="slow"))
        file.save(path, overwrite=True)
    return slow


def two_rates_hdf5(path):
    import h5py

    slow = 0.75 + 0.01 * np.arange(50)
    with h5py.File(path, "w") as file:
        file["fast"] = np.arange(500.0)
        file["fast"].attrs["sample_rate"] = 1000.0
        file["h/time"], file["h/slow"] = slow * 1e3, np.arange(50.0)
        file["h/time"].attrs["units"] = "ms"
    return slow


def two_rates_mat(path):
    import scipy.io

    slow = 0.75 + 0.01 * np.arange(50)
    fast = {"time": 0.001 * np.arange(500), "signals": {"values": np.arange(500.0)[:, None], "label": "fast"}}
    scipy.io.savemat(path, {"f": fast, "s": {"Time": slow, "Data": np.arange(50.0), "Name": "slow"}})
    return slow


@pytest.mark.parametrize(
    ("name", "write", "fast", "slow"),
    [
        ("a.tdms", two_rates_tdms, "fast", "slow"),
        ("a.mf4", two_rates_mdf, "fast", "slow"),
        ("a.h5", two_rates_hdf5, "fast", "h/slow"),
        ("a.mat", two_rates_mat, "f.fast", "s.Data"),
    ],
)
def test_two_channels_keep_their_clocks(tmp_path, name, write, fast, slow):
    expected = write(tmp_path / name)
    with open_log(tmp_path / name) as log:
        found, _ = read(log, [fast, slow], 100)
    assert np.allclose(found[fast][0], 0.001 * np.arange(500), rtol=0, atol=1e-12)
    assert np.allclose(found[slow][0], expected, rtol=0, atol=1e-12)
    assert np.array_equal(found[fast][1], np.arange(500.0)) and np.array_equal(found[slow][1], np.arange(50.0))


def test_a_channel_goes_by_its_short_or_its_long_name(tmp_path):
    two_rates_tdms(tmp_path / "a.tdms")
    with open_log(tmp_path / "a.tdms") as log:
        assert log.channel("g/fast") == log.channel("fast")
        assert next(iter(log.portions(["g/fast"], 10))).keys() == {"g/fast"}


def test_own_results_are_a_log(tmp_path):
    """What a run of vvdp writes: states on the time at the top, marks on their own."""
    import h5py

    with h5py.File(tmp_path / "result.h5", "w") as file:
        for path, values in {
            "time": np.arange(8.0),
            "states/p/rail": np.arange(8.0) ** 2,
            "outputs/q": np.ones(8),
        }.items():
            file[path] = values
            file[path].attrs["units"] = "s" if path == "time" else "Pa"
        file["marks/time"], file["marks/states/p/rail"] = np.array([1.0, 5.0]), np.array([1.0, 25.0])
        file["marks/time"].attrs["units"] = "s"
    with open_log(tmp_path / "result.h5") as log:
        found, _ = read(log, ["states/p/rail", "marks/states/p/rail"])
    assert np.array_equal(found["states/p/rail"][0], np.arange(8.0))
    assert np.array_equal(found["marks/states/p/rail"][0], [1.0, 5.0])


def test_hdf5_as_netcdf_writes_it(tmp_path):
    """Dimension scales, packed integers with a fill value, a time counted from a date."""
    import h5py

    with h5py.File(tmp_path / "a.nc", "w") as file:
        file["seconds"] = np.array([0.0, 0.5, 1.0])
        file["seconds"].attrs["units"] = "minutes since 2024-01-01"
        file["seconds"].make_scale("seconds")
        file["p"] = np.array([100, -1, 300], np.int16)
        file["p"].dims[0].attach_scale(file["seconds"])
        file["p"].attrs.update({"scale_factor": 0.5, "add_offset": 10.0, "_FillValue": np.int16(-1), "units": "bar"})
        file["m"] = np.arange(6.0).reshape(3, 2)
        file["m"].dims[0].attach_scale(file["seconds"])
    with open_log(tmp_path / "a.nc") as log:
        found, _ = read(log, ["p", "m[1]"])
    assert np.array_equal(found["p"][0], [0.0, 30.0, 60.0])
    assert np.array_equal(found["p"][1], [60.0, np.nan, 160.0], equal_nan=True)
    assert np.array_equal(found["m[1]"][1], [1.0, 3.0, 5.0])


def test_tdms_in_rows_big_chunks_and_cut_off(tmp_path, data):
    """What is read from its place in the file is what npTDMS makes of it."""
    import nptdms

    times, channels = data
    write_tdms(tmp_path / "whole.tdms", times, channels, split=N)
    content = (tmp_path / "whole.tdms").read_bytes()
    (tmp_path / "cut.tdms").write_bytes(content[:-2500])
    with nptdms.TdmsFile.open(tmp_path / "cut.tdms") as reference, open_log(tmp_path / "cut.tdms") as log:
        for name in channels:
            expected = reference["g"][name][:]
            found, _ = read(log, [name], 77)
            assert np.array_equal(found[name][1], expected)
        assert reference["g"]["w"][:].size == N - 313  # 2500 bytes are 312.5 values
        assert any("incomplete" in remark for remark in log.remarks)


@pytest.mark.parametrize("compression", [0, 2])
def test_a_portion_of_many_blocks_of_mdf(tmp_path, compression):
    """asammdf hands a long stretch over in several fragments, all in the same buffer."""
    count = 900_000
    times, values = np.arange(count) * 1e-4, np.arange(count) * 1.0
    write_mdf(tmp_path / "a.mf4", times, {"v": values, "w": -values}, compression)
    with open_log(tmp_path / "a.mf4") as log:
        found, _ = read(log, ["v", "w"], 700_000)
    assert np.array_equal(found["v"][0], times)
    assert np.array_equal(found["v"][1], values) and np.array_equal(found["w"][1], -values)


def test_invalid_samples_of_mdf_are_nan(tmp_path):
    import asammdf

    invalid = np.random.default_rng(5).random(N) < 0.1
    with asammdf.MDF() as file:
        signal = asammdf.Signal(np.arange(N) * 1.0, np.arange(N) * 1.0, name="v", invalidation_bits=invalid)
        file.append([signal, asammdf.Signal(np.arange(N) * 2.0, np.arange(N) * 1.0, name="w")])
        file.save(tmp_path / "a.mf4", overwrite=True)
    with open_log(tmp_path / "a.mf4") as log:
        found, _ = read(log, ["v", "w"])
    assert np.array_equal(found["v"][1], np.where(invalid, np.nan, np.arange(N)), equal_nan=True)
    assert np.array_equal(found["w"][1], np.arange(N) * 2.0)


def test_parquet_with_instants_and_missing_values(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    stamps = np.datetime64("2024-01-01T00:00:00", "ns") + np.arange(4) * np.timedelta64(100_001, "ns")
    table = pa.table({"stamp": stamps, "v": [1.0, None, 3.0, 4.0], "n": [1, 2, None, 4], "word": list("abcd")})
    pq.write_table(table, tmp_path / "a.parquet", row_group_size=2)
    with open_log(tmp_path / "a.parquet") as log:
        found, _ = read(log, ["v", "n"], 3)
        assert log.unreadable["word"] == wording.logs.holds_text
    assert np.array_equal(found["v"][0], np.arange(4) * 100_001 / 1e9)
    assert np.array_equal(found["v"][1], [1.0, np.nan, 3.0, 4.0], equal_nan=True)
    assert np.array_equal(found["n"][1], [1.0, 2.0, np.nan, 4.0], equal_nan=True)


def test_a_rate_is_the_clock_of_a_file_without_one(tmp_path):
    (tmp_path / "a.csv").write_text("v\n1\n2\n3\n")
    with open_log(tmp_path / "a.csv", rate=4.0) as log:
        found, _ = read(log, ["v"])
    assert np.array_equal(found["v"][0], [0.0, 0.25, 0.5])


def test_columns_of_one_name_are_told_apart_in_parquet(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = [pa.array(np.arange(5.0) * k) for k in (1.0, 2.0, 0.1, 3.0)]
    pq.write_table(pa.table(columns, ["v", "v", "time", "v"]), tmp_path / "a.parquet", row_group_size=2)
    with open_log(tmp_path / "a.parquet") as log:
        for name, k in (("v", 1.0), ("v #2", 2.0), ("v #3", 3.0)):
            found, _ = read(log, [name])
            assert np.array_equal(found[name][0], np.arange(5.0) * 0.1)
            assert np.array_equal(found[name][1], np.arange(5.0) * k)


def test_the_first_of_several_time_columns_is_taken_and_said(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],Time [ms],v\n0,5,1\n1,6,2\n")
    with open_log(tmp_path / "a.csv") as log:
        found, _ = read(log, ["v"])
        assert log.remarks == (wording.logs.several_times.format(names="'t', 'Time'"),)
    assert np.array_equal(found["v"][0], [0.0, 1.0])
    with open_log(tmp_path / "a.csv", time="Time") as log:
        assert np.array_equal(read(log, ["v"])[0]["v"][0], [5 / 1e3, 6 / 1e3])


def test_several_clocks_of_one_length_are_refused_unless_one_is_named(tmp_path):
    import h5py

    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["t"], file["time"], file["v"] = np.arange(4.0), 2 * np.arange(4.0), np.ones(4)
        file["short/time"], file["short/v"] = np.arange(3.0), np.ones(3)
    with open_log(tmp_path / "a.h5") as log:
        with pytest.raises(ConfigError, match=wording.logs.several_clocks.format(channel="v", names="'t', 'time'")):
            log.portions(["v"], 10)
        assert np.array_equal(read(log, ["short/v"])[0]["short/v"][0], np.arange(3.0))
    with open_log(tmp_path / "a.h5", time="time") as log:
        assert np.array_equal(read(log, ["v"])[0]["v"][0], 2 * np.arange(4.0))


def test_an_asammdf_without_what_is_needed_of_it_is_no_damage(tmp_path, data, monkeypatch):
    import asammdf
    from asammdf.blocks.mdf_v4 import MDF4

    write_mdf(tmp_path / "a.mf4", *data)
    monkeypatch.delattr(MDF4, "_load_data")
    with pytest.raises(ConfigError) as caught:
        open_log(tmp_path / "a.mf4")
    assert wording.logs.cannot_be_read_with.format(library=f"asammdf {asammdf.__version__}") in str(caught.value)
    assert "damaged" not in str(caught.value)


def test_what_only_another_version_would_raise_is_told_with_the_version(tmp_path, data, monkeypatch):
    import asammdf

    write_mdf(tmp_path / "a.mf4", *data)
    monkeypatch.setattr(asammdf.MDF, "get", lambda self, **known: known["more"] if "more" in known else self.get_more())
    expected = rf"channel 'v', samples 0 to .*cannot be read with asammdf {asammdf.__version__}, or the file is damaged"
    with open_log(tmp_path / "a.mf4") as log, pytest.raises(ConfigError, match=expected):
        read(log, ["v"])


def test_an_nptdms_that_keeps_its_segments_elsewhere_is_read_all_the_same(tmp_path, data, monkeypatch):
    from vvdp.logs import tdms

    class Elsewhere:
        _reader = None

    times, channels = data
    write_tdms(tmp_path / "a.tdms", times, channels)
    plain = tdms._stretches
    monkeypatch.setattr(tdms, "_stretches", lambda file, channel: plain(Elsewhere(), channel))
    with open_log(tmp_path / "a.tdms") as log:
        assert np.array_equal(read(log, ["v"])[0]["v"][1], channels["v"])


def test_a_chain_of_blocks_of_mdf_that_ends_is_none_that_does_not(tmp_path, data):
    """Many groups and channels in both versions: lists are followed to their ends."""
    from vvdp.logs.mdf_blocks import _following_blocks, check_lists

    times, channels = data
    for name, write in (("a.mf4", write_packed_mdf), ("a.mdf", write_old_mdf)):
        write(tmp_path / name, times, {f"{key}{k}": x for k in range(5) for key, x in channels.items()} | channels)
        check_lists(tmp_path / name)
        listed = [place for place in _following_blocks(tmp_path / name).values() if place]
        assert len(listed) >= 12  # eleven steps from the master to the twelfth channel, and more


def faulty_hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        file["time"], file["v"], file["name"] = np.arange(5.0), np.arange(6.0), "text"


def no_clock_hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        file["pressure"] = np.arange(6.0)


def cells(path):
    import scipy.io

    held = np.empty(2, object)
    held[:] = [np.arange(3.0), "a"]
    scipy.io.savemat(path, {"time": np.arange(3.0), "held": held})


def content(text):
    def write(path):
        path.write_bytes(text)

    return write


def cut(write, name, keep):
    def written(path):
        random = np.random.default_rng(0).normal(size=N)
        write(path, np.arange(N) * 1e-4, {"v": random, "w": random})
        path.write_bytes(path.read_bytes()[:keep])

    return written


BAD = [
    ("a.csv", content(b""), {}, wording.files.is_empty),
    ("a.xlsx", content(b"PK\3\4"), {}, "extension '.xlsx'"),
    ("a.csv", content(b"PK\3\4abc"), {}, "spreadsheet"),
    ("a.csv", content(b"\x1f\x8b\x08"), {}, "gzip"),
    ("a.csv", content("t,v\n0,1\n".encode("utf-16")), {}, "UTF-16"),
    ("a.csv", content(b"\0\1\2\3" * 10), {}, wording.logs.neither_text_nor_format),
    ("a.tdms", content(b"time,v\n0,1\n"), {}, wording.logs.text_by_content.format(format="TDMS")),
    ("a.tdms", content(b"TDSh" + bytes(30)), {}, wording.logs.index_without_data),
    ("a.tdms", content(b"TDSm" + bytes(30)), {}, wording.logs.damaged),
    ("a.mf4", content(b"MDF     4.10    "), {}, wording.logs.damaged_or_cut),
    ("a.parquet", content(b"PAR1" + bytes(30)), {}, wording.logs.damaged_or_cut),
    ("a.h5", content(b"\x89HDF\r\n\x1a\n" + bytes(30)), {}, wording.logs.damaged_or_cut),
    ("a.mat", content(b"MATLAB 5.0 MAT-file" + bytes(200)), {}, wording.logs.damaged),
    ("a.mat", content(b"hello"), {}, wording.logs.damaged),
    ("a.h5", cut(write_hdf5, "a.h5", 3000), {}, wording.logs.damaged_or_cut),
    ("a.mf4", cut(write_mdf, "a.mf4", 3000), {}, wording.logs.damaged),
    ("a.parquet", cut(write_parquet, "a.parquet", 3000), {}, wording.logs.damaged_or_cut),
    ("a.mat", cut(write_mat, "a.mat", 3000), {}, wording.logs.damaged),
    ("a.h5", faulty_hdf5, {}, wording.logs.samples_differ.format(channel="v", samples=6, time="time", times=5)),
    ("a.h5", no_clock_hdf5, {}, wording.logs.no_clock.format(channel="pressure") + wording.logs.name_time),
    ("a.h5", no_clock_hdf5, {"time": "tiem"}, wording.logs.no_time_channel.format(channel="tiem")),
    ("a.mat", cells, {"want": "held"}, wording.logs.cell_array_expected.format(channel="held")),
    (
        "a.csv",
        content(b"time,pressure\n0,1\n1,2\n"),
        {"want": "presure"},
        wording.files.did_you_mean.format(name="pressure"),
    ),
    (
        "a.csv",
        content(b"time [V],v\n0,1\n1,2\n"),
        {"want": "v"},
        wording.logs.time_unit.format(channel="time", unit="V"),
    ),
    (
        "a.csv",
        content(b"time [s],v\n0,1\n1,2\n"),
        {"want": "v", "time_unit": "ms"},
        wording.files.contradicts.format(key="'ms'"),
    ),
    (
        "a.csv",
        content(b"time [s],v\n0,1\n1,2\n"),
        {"want": "v", "rate": 10.0},
        wording.logs.has_clock.format(channel="time"),
    ),
    ("a.csv", content(b"u,v\n0,1\n1,2\n"), {"want": "v"}, wording.logs.no_clock.format(channel="v")),
    (
        "a.csv",
        content(b"time,v\nmorning,1\nnoon,2\n"),
        {"want": "v"},
        wording.logs.time_holds_text.format(channel="time"),
    ),
]


@pytest.mark.parametrize(
    ("name", "write", "options", "expected"), BAD, ids=[f"{k}-{row[0]}" for k, row in enumerate(BAD)]
)
def test_what_is_wrong_is_said(tmp_path, name, write, options, expected):
    write(tmp_path / name)
    options = dict(options)
    want = options.pop("want", None)
    with pytest.raises(ConfigError) as caught, open_log(tmp_path / name, **options) as log:
        wanted = [want] if want else [info.name for info in log.channels()]
        read(log, wanted)
    message = str(caught.value)
    assert expected in message and str(tmp_path / name) in message


def test_options_that_contradict_are_refused(tmp_path):
    for options in ({"rate": 0.0}, {"rate": np.nan}, {"rate": 1.0, "time": "t"}, {"time_unit": "fortnight"}):
        with pytest.raises(ParameterError):
            open_log(tmp_path / "a.csv", **options)
    (tmp_path / "a.csv").write_text("t,v\n0,1\n")
    with pytest.raises(ParameterError, match="0 samples"):
        open_log(tmp_path / "a.csv").portions(["v"], 0)
    for path, reason in ((tmp_path / "b.csv", wording.files.no_file), (tmp_path, wording.files.is_directory)):
        with pytest.raises(ConfigError, match=reason):
            open_log(path)


@pytest.mark.parametrize(("library", "extra", "name", "write"), [
    ("nptdms", "daq", "a.tdms", write_tdms), ("asammdf", "daq", "a.mf4", write_mdf),
    ("pyarrow", "data", "a.parquet", write_parquet),
])  # fmt: skip
def test_a_missing_library_is_named(tmp_path, data, monkeypatch, library, extra, name, write):
    write(tmp_path / name, *data)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == library else object())
    needs = re.escape(wording.export.needs_library.format(library=library, extra=extra))
    expected = rf"{name} \(.*\) {needs}"
    with pytest.raises(MissingExtraError, match=expected):
        open_log(tmp_path / name)


def test_a_channel_as_a_quantity(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],p [bar],n [rpm],q [V],x\n0,1,60,1,1\n")
    with open_log(tmp_path / "a.csv") as log:
        values = np.array([0.0, 1.0])
        # Gauge: 1 bar above the standard atmosphere. 60 rpm is one turn a second.
        assert np.array_equal(to_si(log.path, log.channel("p"), PRESSURE_LEVEL)(values), [101325.0, 201325.0])
        assert to_si(log.path, log.channel("n"), SPEED)(60.0 * values)[1] == pytest.approx(2 * np.pi)
        assert to_si(log.path, log.channel("x"), SPEED, "rad/s")(values)[1] == 1.0
        assert to_si(log.path, log.channel("p"), PRESSURE_LEVEL, "bara")(values)[1] == 1e5
        assert to_si(log.path, log.channel("p"), PRESSURE_LEVEL, "barg")(values)[1] == 201325.0
        for channel, unit, expected in (
            ("q", None, wording.logs.is_in.format(unit="V")),
            ("x", None, wording.files.has_no_unit),
            ("p", "psi", wording.logs.not_in.format(unit="psi")),
        ):
            with pytest.raises(ConfigError, match=expected):
                to_si(log.path, log.channel(channel), PRESSURE_LEVEL, unit)


MEASURE = """
import resource, sys
from vvdp.logs.source import open_log
log = open_log(sys.argv[1])
next(iter(log.portions(["v"], 1000)))
def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("RssAnon"))
before = most = peak()
for part in log.portions(["v"], 50_000):
    most = max(most, peak())
print(most - before)
"""


@pytest.mark.sampled(5)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is read from /proc")
@pytest.mark.parametrize("name", ["a.tdms", "a.mf4", "a.h5", "a.parquet", "a.csv"])
def test_memory_is_bounded(tmp_path, name):
    """3 million samples, 24 MB a channel, in one chunk: what a process holds of its own grows by less than half."""
    count = 3_000_000 if name != "a.csv" else 800_000
    times = np.arange(count) * 1e-4
    values = np.round(np.random.default_rng(0).normal(size=count), 9)
    if name == "a.csv":
        with (tmp_path / name).open("w") as file:
            file.write("time [s],v\n")
            file.writelines(f"{k}e-4,{v}\n" for k, v in enumerate(values.tolist()))
        limit = 12_000
    elif name == "a.tdms":
        write_tdms(tmp_path / name, times, {"v": values}, split=count)
        limit = 12_000
    else:
        {"a.mf4": write_mdf, "a.h5": write_hdf5_rate, "a.parquet": write_parquet_whole}[name](
            tmp_path / name, times, {"v": values}
        )
        limit = 60_000 if name == "a.parquet" else 12_000
    done = subprocess.run(
        [sys.executable, "-c", MEASURE, str(tmp_path / name)], capture_output=True, text=True, check=True
    )
    assert int(done.stdout) < limit  # kB


def write_parquet_whole(path, times, channels):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"time [s]": times, **channels}), path)
