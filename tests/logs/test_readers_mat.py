"""MATLAB files: structs, Simulink's structures, versions 4 to 7.3, and what is refused."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.logs.source import open_log

T = 0.01 * np.arange(5)


def everything(log):
    """Times and values of all channels that have a clock."""
    found = {}
    for info in log.channels():
        parts = [part[info.name] for part in log.portions([info.name], 3)]
        found[info.name] = tuple(np.concatenate([p[k] for p in parts]) for k in (0, 1))
    return found


def simulink():
    signals = np.zeros((1, 2), [("values", "O"), ("dimensions", "O"), ("label", "O")])
    signals[0, 0] = (T[:, None] * 2, 1.0, "p_s [bar]")
    signals[0, 1] = (np.column_stack([T * 3, T * 4]), 2.0, "")
    return {"time": T[:, None], "signals": signals, "blockName": "model/Scope"}


def test_structure_with_time_of_simulink(tmp_path):
    scipy.io.savemat(tmp_path / "a.mat", {"log": simulink()})
    with open_log(tmp_path / "a.mat") as log:
        found = everything(log)
        assert log.channel("log.p_s").unit == "bar"
        assert log.unreadable["log.blockName"] == wording.logs.is_text
    names = ["log.time", "log.p_s", "log.signals(2).values(:,1)", "log.signals(2).values(:,2)"]
    assert list(found) == names
    for name, factor in zip(names, (1, 2, 3, 4), strict=True):
        assert np.array_equal(found[name][0], T) and np.array_equal(found[name][1], T * factor)


def test_a_timeseries_taken_apart(tmp_path):
    series = {"Time": T, "Data": T * 2, "Name": "speed", "DataInfo": {"Units": "rpm"}, "TimeInfo": {"Units": "seconds"}}
    scipy.io.savemat(tmp_path / "a.mat", {"speed": series}, oned_as="column")
    with open_log(tmp_path / "a.mat") as log:
        assert log.channel("speed.Data").unit == "rpm" and log.channel("speed.Time").unit == "seconds"
        assert np.array_equal(everything(log)["speed.Data"][0], T)
        assert not log.remarks


def test_rows_or_columns_by_the_length_of_the_clock(tmp_path):
    across, down = np.arange(10.0).reshape(2, 5), np.arange(10.0).reshape(5, 2)
    scipy.io.savemat(tmp_path / "a.mat", {"t": T, "across": across, "down": down})
    with open_log(tmp_path / "a.mat") as log:
        found = everything(log)
    assert np.array_equal(found["across(2,:)"][1], across[1]) and np.array_equal(found["down(:,2)"][1], down[:, 1])


def test_a_column_may_be_named_as_the_clock(tmp_path):
    """What Simulink calls an array: time in the first column."""
    scipy.io.savemat(tmp_path / "a.mat", {"simout": np.column_stack([T, T * 2])})
    with open_log(tmp_path / "a.mat", time="simout(:,1)", time_unit="ms") as log:
        assert np.array_equal(everything(log)["simout(:,2)"][0], T / 1e3)


def write_73(path, variables):
    """A file as MATLAB writes it: sizes reversed, classes as attributes, struct arrays as references."""
    with h5py.File(path, "w", userblock_size=512) as file:
        references = file.create_group("#refs#")
        for name, value in variables.items():
            put_73(file, name, value, references)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def put_73(group, name, value, references):
    if isinstance(value, dict):
        inner = group.create_group(name)
        inner.attrs["MATLAB_class"] = np.bytes_("struct")
        for key, item in value.items():
            put_73(inner, key, item, references)
    elif isinstance(value, list):  # a struct array
        inner = group.create_group(name)
        inner.attrs["MATLAB_class"] = np.bytes_("struct")
        for key in value[0]:
            pointers = np.empty((len(value), 1), h5py.ref_dtype)
            for k, element in enumerate(value):
                label = f"r{len(references)}"
                put_73(references, label, element[key], references)
                pointers[k, 0] = references[label].ref
            inner.create_dataset(key, data=pointers)
    elif isinstance(value, str):
        data = np.array([[ord(letter)] for letter in value], np.uint16) if value else np.array([0, 0], np.uint64)
        dataset = group.create_dataset(name, data=data)
        dataset.attrs["MATLAB_class"] = np.bytes_("char")
        if not value:
            dataset.attrs["MATLAB_empty"] = np.uint8(1)
    else:
        array = np.atleast_2d(np.asarray(value))
        group.create_dataset(name, data=array.T).attrs["MATLAB_class"] = np.bytes_(array.dtype.name)


def test_version_73_is_read_as_version_5(tmp_path):
    plain = {
        "log": {"time": T[:, None], "p": (T * 2)[:, None], "unit": "bar", "n": np.arange(5, dtype=np.int16)[None, :]},
        "wide": {"t": T[:, None], "m": np.column_stack([T, T * 5])},
        "b": {"Time": T[:, None], "Data": T[:, None] > 0.02, "name": ""},
        "one": np.array([[3.0]]),
    }
    scope = {
        "time": T[:, None],
        "signals": [
            {"values": T[:, None] * 2, "label": "p_s [bar]", "dimensions": np.array([[1.0]])},
            {"values": np.column_stack([T * 3, T * 4]), "label": "", "dimensions": np.array([[2.0]])},
        ],
    }
    write_73(tmp_path / "new.mat", {**plain, "scope": scope})
    old = simulink()
    del old["blockName"]
    scipy.io.savemat(tmp_path / "old.mat", {**plain, "scope": old})
    with open_log(tmp_path / "new.mat") as new, open_log(tmp_path / "old.mat") as log:
        first, second = everything(new), everything(log)
        assert {(i.name, i.unit, i.samples) for i in new.channels()} == {
            (i.name, i.unit, i.samples) for i in log.channels()
        }
        assert new.unreadable == log.unreadable
    assert "scope.p_s" in first and first.keys() == second.keys()
    for name, (times, values) in first.items():
        assert np.array_equal(times, second[name][0]) and np.array_equal(values, second[name][1])


def test_what_only_matlab_can_read_is_refused(tmp_path):
    held = np.empty((1, 2), object)
    held[0, 0], held[0, 1] = T, "x"
    import scipy.sparse

    content = {
        "time": T,
        "held": held,
        "z": T * 1j,
        "s": scipy.sparse.eye(5),
        "e": np.zeros((0, 0)),
        "c": np.zeros((2, 3, 4)),
    }
    scipy.io.savemat(tmp_path / "a.mat", content)
    with open_log(tmp_path / "a.mat") as log:
        assert log.unreadable == {
            "held": wording.logs.cell_array,
            "z": wording.logs.complex_numbers,
            "s": wording.logs.sparse_matrix,
            "e": wording.files.is_empty,
            "c": wording.logs.array_of.format(size="2 x 3 x 4"),
        }
        with pytest.raises(ConfigError, match=wording.logs.cell_array_expected.format(channel="held")):
            log.portions(["held"], 10)


def test_files_that_matlab_wrote(not_tested):
    """All in SciPy's own tests, MATLAB 4.2 to 7.4, some broken on purpose: channels, or a message."""
    folder = Path(scipy.io.matlab.__file__).parent / "tests" / "data"
    files = sorted(folder.glob("*.mat"))
    if not files:
        not_tested("this SciPy comes without its test data", "samples")
    assert len(files) > 100
    refused = set()
    for path in files:
        try:
            with open_log(path, rate=1.0) as log:
                channels = log.channels()
                assert channels or log.unreadable, path
                for parts in log.portions([info.name for info in channels], 1000):
                    assert all(np.issubdtype(part.values.dtype, np.float64) for part in parts.values())
        except ConfigError as problem:
            assert path.name in str(problem) and "damaged" in str(problem)
            refused.add(path.stem)
    assert refused == {
        "bad_miuint32", "bad_miutf8_array_name", "corrupted_zlib_checksum", "corrupted_zlib_data", "debigged_m4",
        "malformed1",
    }  # fmt: skip
    with open_log(folder / "testdouble_7.4_GLNX86.mat", rate=1.0) as log:  # 0 to 2 pi in steps of pi / 4
        values = everything(log)["testdouble"][1]
    assert np.allclose(values, np.arange(9) * np.pi / 4, rtol=0, atol=1e-15)


@pytest.mark.slow
def test_files_that_matlab_wrote_in_two_versions(sample_files):
    """v7 and v7.3 of the same data, written by MATLAB, have the same channels."""
    folder = sample_files("pymatreader", "1.3.2", ".mat")
    for name in ("v7", "bti_raw_v7", "sparse_v7", "cell_struct_v7", "struct_in_cell_v7"):
        with open_log(folder / f"{name}.mat", rate=1.0) as old, open_log(folder / f"{name}3.mat", rate=1.0) as new:
            first, second = everything(old), everything(new)
        assert first.keys() == second.keys() and (first or name not in ("bti_raw_v7", "sparse_v7"))
        for key, (times, values) in first.items():
            assert np.array_equal(times, second[key][0]) and np.array_equal(values, second[key][1], equal_nan=True)
    for name in ("ft_v7", "ft_v73"):
        with open_log(folder / f"{name}.mat") as log:
            assert log.unreadable == {"data_epoched": wording.logs.cell_array}
    with open_log(folder / "mcos_class_instance_v7.mat") as log:
        assert wording.logs.of_class.format(name="some.Namespace.ClassName") in log.unreadable["a_class_instance"]
