"""`vvdp export data`."""

import csv
import json
import sys

import h5py
import numpy as np
import pytest
from tests.words import wording


def columns(path):
    with path.open(newline="") as file:
        heads, *rows = csv.reader(file)
    return dict(zip(heads, np.array(rows, float).T, strict=True))


def test_a_run_is_exported_as_it_was_recorded(vvdp, here, two_runs, keys_as_described):
    answer = vvdp("export", "data", str(two_runs[0]), "--csv", "run.csv", "--json")
    assert answer.code == 0, answer.err
    keys_as_described("export data", json.loads(answer.out))
    found = columns(here / "run.csv")
    with h5py.File(two_runs[0] / "result.h5") as file:
        count = sum(len(file[group].keys()) > 0 for group in ("states", "outputs", "commands"))
        assert count == 3
        assert np.array_equal(found["time_s"], file["time"][:])
        assert np.array_equal(found["states.inlet_Pa"], file["states/inlet"][:])  # absolute, as it is in the file
        assert np.array_equal(found["states.spool.speed_rad_s"], file["states/spool/speed"][:])
        assert np.array_equal(found["outputs.pump_flow_m3_s"], file["outputs/pump_flow"][:])
        names = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    recorded = [name for name in names if name.split("/")[0] in ("states", "outputs", "commands", "memory", "readings")]
    assert all(
        any(key.startswith(name.replace("/", ".")) for key in found) for name in recorded if "time_value" not in name
    )


def test_parquet_holds_the_same_with_units(vvdp, here, two_runs):
    parquet = pytest.importorskip("pyarrow.parquet")
    answer = vvdp("export", "data", str(two_runs[0]), "--csv", "run.csv", "--parquet", "run.parquet")
    assert answer.out.split() == ["run.csv", "run.parquet"]
    table = parquet.read_table(here / "run.parquet")
    found = columns(here / "run.csv")
    assert table.column_names == list(found)
    assert all(np.array_equal(table[key].to_numpy(), found[key]) for key in found)
    assert table.schema.field("states.spool.speed_rad_s").metadata[b"unit"] == b"rad/s"


def test_any_result_is_exported(vvdp, here):
    done = vvdp("map", "prototype", "--analytic", "--duty", "0.25", "1", "2", "--no-report", "--out", "map",
                "--pressure", "40 bar", "100 bar", "2")  # fmt: skip
    assert done.code == 0, done.err
    assert vvdp("export", "data", "map", "--csv", "all.csv").out.split() == ["all.csv"]
    assert (here / "all.csv").read_bytes() == (here / "map" / "map.csv").read_bytes()


def test_several_tables_are_several_files(vvdp, here, two_runs):
    assert vvdp("compare", "runs", *map(str, two_runs), "--out", "two", "--no-report").code == 0
    answer = vvdp("export", "data", "two", "--csv", "out.csv")
    assert answer.out.split() == ["out-runs.csv", "out-series-1.csv", "out-series-2.csv"]
    assert vvdp("export", "data", "two", "--csv", "one.csv", "--table", "runs").out.split() == ["one.csv"]
    assert (here / "one.csv").read_bytes() == (here / "out-runs.csv").read_bytes()
    refused = vvdp("export", "data", "two", "--csv", "one.csv", "--table", "run")
    assert refused.code == 2 and wording.files.did_you_mean.format(name="runs") in refused.err
    again = vvdp("export", "data", "two", "--csv", "one.csv", "--table", "runs")
    assert again.code == 2 and wording.files.already_exists in again.err
    assert vvdp("export", "data", "two", "--csv", "one.csv", "--table", "runs", "--force").code == 0


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["{run}"], 2, wording.export.expected_format),
        (["nowhere", "--csv", "a.csv"], 2, "nowhere: " + wording.files.no_directory),
        (["{run}", "--csv", "missing/a.csv"], 1, "missing/a.csv: " + wording.files.cannot_write),
        (["{run}", "--csv", "."], 2, wording.files.is_directory),
    ],
)
def test_what_cannot_be_exported_is_refused(vvdp, here, two_runs, words, code, told):
    answer = vvdp("export", "data", *(word.format(run=two_runs[0]) for word in words))
    assert answer.code == code and told in answer.err
    assert list(here.iterdir()) == []


def test_without_pyarrow_parquet_is_refused_in_one_line(vvdp, here, two_runs, monkeypatch):
    import importlib.util

    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "pyarrow" else find(name, *a))
    monkeypatch.delitem(sys.modules, "pyarrow", raising=False)
    answer = vvdp("export", "data", str(two_runs[0]), "--parquet", "a.parquet")
    assert answer.code == 1 and wording.export.install_extra.format(extra="data") in answer.err
    assert list(here.iterdir()) == []
