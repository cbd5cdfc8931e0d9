"""What a run leaves on disk, by program and by name, and what of it comes back."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from tests.words import wording

import vvdp
from vvdp.base.errors import ConfigError
from vvdp.base.files import list_all, result_directory
from vvdp.simulation.record import record_bytes, record_of
from vvdp.simulation.results import Results, origin, read_results, write_results
from vvdp.simulation.run import Stepping, simulate


@pytest.fixture(scope="module")
def run(switching):
    model, case = switching
    return simulate(model, case(), Stepping(until=0.1))


def write(directory, run, **more):
    meta = origin(run) | more
    with result_directory(directory) as folder:
        write_results(folder, Results(folder, "[oil]\n", {"mean_bar": 1.0}, meta, record_of(run)))
    return directory


@pytest.fixture
def written(run, tmp_path):
    return write(tmp_path / "out", run, more=2, system="switching", title="A title")


def test_everything_that_was_recorded_comes_back_by_name(run, written):
    found = read_results(written)
    assert np.array_equal(found.record.times, run.times)
    assert np.array_equal(found.record.states["inlet_pressure"].values, run.states[:, 0])
    assert np.array_equal(found.record.outputs["load_flow"].values, run.outputs.load_flow)
    assert set(found.record.commands) == {
        "held.tank_pressure",
        "modes.first_side",
        "modes.second_side",
        "modes.at_first",
        "modes.at_second",
        "controller.frequency",
        "controller.duty_ratio",
        "display.mean",
        "display.samples",
    }
    assert np.array_equal(found.record.commands["display.mean"].values, run.command.display.mean)
    assert np.array_equal(found.record.memory["controller.duty_ratio"].values, run.memory["controller"].duty_ratio)
    assert np.array_equal(found.record.readings["display.load_pressure"].values, run.state.load_pressure)
    assert np.array_equal(found.record.mark_times, run.mark_times)
    assert found.summary == {"mean_bar": 1.0} and found.meta["more"] == 2 and found.system == "[oil]\n"


def test_each_has_a_unit_and_a_name_in_words(written):
    found = read_results(written)
    mean = found.record.commands["display.mean"]
    assert (mean.unit, mean.long_name) == ("Pa", "display, mean (absolute)")
    assert found.record.memory["controller.duty_ratio"].unit == "1"
    assert found.record.readings["controller.load_pressure"].long_name == "load pressure (absolute)"


def test_remarks_of_the_run_are_told(run, written):
    assert read_results(written).meta.get("remarks", []) == list(run.remarks)


def test_results_of_an_earlier_format_are_refused_with_what_to_do(written):
    meta = json.loads((written / "meta.json").read_text())
    (written / "meta.json").write_text(json.dumps(meta | {"format": 1}))
    list_all(written)
    with pytest.raises(ConfigError, match=r"was written in format 1; this version reads format 2: run its system.toml"):
        read_results(written)


@pytest.mark.parametrize("text", ["", "[]", "{"])
def test_a_damaged_directory_is_told_as_such(written, text):
    (written / "meta.json").write_text(text)
    with pytest.raises(ConfigError, match="meta.json: " + wording.directories.has_changed):
        read_results(written)
    list_all(written)
    with pytest.raises(ConfigError, match="is damaged"):
        read_results(written)


def test_a_stopped_run_is_written_as_far_as_it_went(run, tmp_path):
    part = replace(
        run, times=run.times[:3], states=run.states[:3], commands=run.commands[:3], memories=run.memories[:3]
    )
    assert read_results(write(tmp_path / "part", part)).record.memory["display.mean"].values.shape == (3,)


def test_every_recorded_dataset_has_the_dimension_time_and_marks_have_their_own(written):
    """As netCDF has it: by scales, which xarray and others read as dimensions."""
    firsts = {}

    def look(name, item):
        if isinstance(item, h5py.Dataset) and not item.is_scale:
            firsts[name] = item.dims[0][0].name
            assert all(len(axis) == 1 for axis in item.dims), name
            assert name.rpartition("/")[2] != "time" or name == "marks/time"  # else it would pass for the dimension

    with h5py.File(written / "result.h5") as file:
        file.visititems(look)
        assert file["time"].is_scale and file["time"].attrs["units"] == "s"
    assert {"states/inlet_pressure", "commands/display/mean", "readings/display/load_pressure"} <= firsts.keys()
    assert {name: scale for name, scale in firsts.items() if not name.startswith("marks/")} == {
        name: "/time" for name in firsts if not name.startswith("marks/")
    }
    assert {scale for name, scale in firsts.items() if name.startswith("marks/")} == {"/marks/mark"}


def test_the_file_says_what_it_is(written):
    with h5py.File(written / "result.h5") as file:
        said = dict(file.attrs)
    assert said == {
        "Conventions": "CF-1.11",
        "title": "A title",
        "system": "switching",
        "vvdp": vvdp.__version__,
        "format": 2,
    }


def test_the_same_run_is_written_as_the_same_bytes(run):
    assert record_bytes(record_of(run), {"format": 2}) == record_bytes(record_of(run), {"format": 2})


def test_xarray_opens_every_group_with_the_dimension_time(run, written):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    with xarray.open_datatree(written / "result.h5", engine="h5netcdf") as tree:
        assert tree["states"].to_dataset().inlet_pressure.dims == ("time",)
        assert tree["states"].to_dataset().inlet_pressure.attrs["units"] == "Pa"
        assert np.array_equal(tree["states"].to_dataset().time, run.times)
        assert tree["marks/states"].to_dataset().inlet_pressure.dims == ("mark",)
