"""`vvdp estimate`, from a log to a result directory, and what a person may get wrong."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from tests.words import wording

import vvdp as package
from vvdp.offline.config import load_estimation
from vvdp.results.store import read_meta, read_result

SPEED = 2.0 * np.pi * 24.7
PITCH = np.pi / 4.0
FIXED_WORDS = {
    "spool_speed_mean_rad_s", "spool_speed_std_rad_s", "sectors", "edges", "index_found", "missed_edges", "nis_mean",
    "warnings", "speed_deviation_rms_rad_s", "sectors_assumed", "polarity", "direction", "standstill_time_s",
}  # fmt: skip


def table(path, **columns):
    """A CSV file; a column is (unit, values)."""
    head = ",".join(f"{name} [{unit}]" if unit else name for name, (unit, _) in columns.items())
    rows = zip(*(values for _, values in columns.values()), strict=True)
    path.write_text(head + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows) + "\n")


def datasets(directory):
    """The long series of an estimation by name."""
    with h5py.File(directory / "result.h5") as file:
        return {name: item[:] for name, item in file.items() if isinstance(item, h5py.Dataset)}


@pytest.fixture
def stamps(here):
    """A log of edge times alone, at 24.7 turns a second."""
    table(here / "edges.csv", edge=("s", 0.2 + np.arange(600) * PITCH / SPEED))
    return "edges.csv"


@pytest.fixture
def bench(here):
    """A log of time, photodiode and inlet pressure, 1 s at 5 kHz."""
    t = np.arange(0.0, 1.5, 2e-4)
    angle = 0.3 + SPEED * t
    light = np.clip(0.5 + 1.6 * np.sin(angle * 4.0), 0.0, 1.0)
    inlet = np.clip(50.0 + 300.0 * np.sin(angle * 3.0), 5.0, 100.0)
    table(here / "bench.csv", time=("s", t), photodiode=("V", 0.4 + 3.0 * light), inlet=("bar", inlet))
    return "bench.csv"


def test_the_words_that_scripts_rely_on(vvdp, stamps, here, keys_as_described):
    done = vvdp("estimate", stamps, "--edges", "edge", "--sectors", "8", "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found.keys() >= FIXED_WORDS
    keys_as_described("estimate", found)
    assert found["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-6)
    assert (found["edges"], found["missed_edges"]) == (600, 0)
    directory = Path(found["out"])
    assert directory.parent == Path("results") and directory.name.startswith("edges-")
    series = datasets(directory)
    assert np.allclose(np.diff(series["time"]), 1e-3, atol=1e-9)
    assert series["angle"].size == series["speed"].size == series["time"].size
    assert (directory / "report.html").is_file() and (directory / "figures" / "speed.svg").is_file()
    assert read_meta(directory)["options"] == {"--edges": "edge", "--sectors": 8}


def test_a_person_is_shown_a_table_and_warnings(vvdp, stamps):
    done = vvdp("estimate", stamps, "--edges", "edge", "--sectors", "8", "--no-report", "--out", "r")
    assert done.code == 0
    assert wording.estimate.mean_speed in done.out and "1482" in done.out
    assert wording.estimate.acceleration_noise in done.out and "0.2500" in done.out and "warning" not in done.out
    assert done.out.rstrip().endswith(wording.run.results_in.format(folder="r"))
    assumed = vvdp("estimate", stamps, "--edges", "edge", "--no-report", "--out", "assumed")
    assert f"warning: {wording.estimate.assumed_title}: {wording.estimate.no_number_given}" in assumed.out
    again = vvdp("estimate", stamps, "--edges", "edge", "--no-report", "--out", "r")
    assert again.code == 2 and wording.files.already_exists in again.err
    assert vvdp("estimate", stamps, "--edges", "edge", "--no-report", "--out", "r", "--force").code == 0


def test_the_report_is_written_anew(vvdp, stamps, here):
    assert vvdp("estimate", stamps, "--edges", "edge", "--no-report", "--out", "r").code == 0
    assert not (here / "r" / "report.html").exists()
    again = vvdp("report", "r")
    assert again.code == 0 and again.out.strip() == str(Path("r", "report.html"))
    assert wording.estimate.title.format(log="edges.csv") in (here / "r" / "report.html").read_text("utf-8")


def test_a_wave_taken_for_a_counter_is_told(vvdp, here):
    t = np.arange(0.0, 1.0, 1e-3)
    angle = SPEED * t
    table(here / "log.csv", time=("s", t), still=("V", 0.2 + 0.1 * np.sin(angle)), slope=("", angle / PITCH))
    refused = vvdp("estimate", "log.csv", "--counts", "still", "--no-report")
    assert refused.code == 2 and wording.estimate.no_counter in refused.err
    done = vvdp("estimate", "log.csv", "--counts", "slope", "--no-report")
    assert done.code == 0 and wording.estimate.counts_not_whole in done.out


@pytest.mark.thorough
def test_a_wave_with_pressure_and_all_options(vvdp, bench, keys_as_described):
    options = ("--wave", "photodiode", "--pressure", "inlet", "--sections", "3", "--output-rate", "500 Hz", "--smooth")
    done = vvdp("estimate", bench, *options, "--json", "--out", "r")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    keys_as_described("estimate", found)
    assert found["output_rate_Hz"] == 500.0 and found["edge_source"] == "wave"
    assert found["duty_ratio_mean"] == pytest.approx(0.5, abs=0.05)
    assert found["threshold"] == pytest.approx(1.9, abs=0.1)
    assert datasets(Path("r")).keys() >= {"smoothed_speed", "inlet_pressure"}


def test_a_config_is_written_and_used(vvdp, bench, here):
    done = vvdp("estimate", bench, "--write-config", "bench.toml")
    assert done.code == 0, done.err
    assert wording.estimate.config_written.format(file="bench.toml", channel="photodiode") in done.out
    text = (here / "bench.toml").read_text()
    assert "#   inlet [bar]\n" in text
    wanted = load_estimation(here / "bench.toml")
    assert wanted.pressure is not None and wanted.pressure.channel == "inlet"
    used = vvdp("estimate", bench, "--config", "bench.toml", "--json", "--no-report", "--out", "r")
    assert used.code == 0, used.err
    assert json.loads(used.out)["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-3)
    assert vvdp("estimate", bench, "--write-config", "bench.toml").code == 2  # it is there already
    assert vvdp("estimate", bench, "--write-config", "bench.toml", "--force").code == 0
    # what was used can be used again
    same = vvdp("estimate", bench, "--config", "r/estimate.toml", "--json", "--no-report", "--out", "s")
    first, second = json.loads(used.out), json.loads(same.out)
    assert {k: v for k, v in first.items() if k not in ("out", "wall_time_s")} == {
        k: v for k, v in second.items() if k not in ("out", "wall_time_s")
    }


@pytest.mark.parametrize("kind", ["counts", "edges"])
def test_a_config_is_guessed_for_other_logs(vvdp, here, kind):
    t = np.arange(0.0, 1.0, 1e-3)
    if kind == "counts":
        table(here / "log.csv", time=("s", t), pulses=("", np.floor(SPEED * t / PITCH)))
    else:
        table(here / "log.csv", edge=("s", 0.2 + np.arange(200) * PITCH / SPEED))
    assert vvdp("estimate", "log.csv", "--write-config", "c.toml").code == 0
    done = vvdp("estimate", "log.csv", "--config", "c.toml", "--json", "--no-report")
    assert done.code == 0, done.err
    assert json.loads(done.out)["edge_source"] == kind


def test_without_a_channel_those_of_the_log_are_named_and_a_way_on(vvdp, bench, here):
    refused = vvdp("estimate", bench)
    assert refused.code == 2 and not refused.out
    lines = refused.err.splitlines()
    assert [line.strip() for line in lines if line.startswith("  ")] == ["time [s]", "photodiode [V]", "inlet [bar]"]
    (probably,) = (line.partition(":  ")[2] for line in lines if line.startswith("probably"))
    assert probably == "vvdp estimate bench.csv --wave photodiode --pressure inlet"
    assert vvdp(*shlex.split(probably)[1:], "--no-report", "--out", "r").code == 0
    (config,) = (line.partition(":  ")[2] for line in lines if line.startswith(wording.estimate.write_config))
    assert vvdp(*shlex.split(config)[1:]).code == 0 and (here / "bench.toml").is_file()


def test_columns_of_seconds_are_edges_and_a_clock_is_none(vvdp, here):
    t = 0.2 + np.arange(400) * PITCH / SPEED
    table(here / "two.csv", down=("s", t[1::2]), up=("s", t[0::2]))
    assert "two.csv --edges up --falling down\n" in vvdp("estimate", "two.csv").err
    assert vvdp("estimate", "two.csv", "--write-config", "two.toml").code == 0
    done = vvdp("estimate", "two.csv", "--config", "two.toml", "--json", "--no-report")
    assert done.code == 0 and json.loads(done.out)["edges"] == 400
    table(here / "row.csv", time=("s", [0.0]), a=("V", [1.0]), b=("V", [2.0]))
    assert "row.csv --wave a\n" in vvdp("estimate", "row.csv").err


def test_columns_in_sec_are_edges_and_not_waves(vvdp, here):
    t = 0.2 + np.arange(400) * PITCH / SPEED
    table(here / "two.csv", rise=("sec", t[0::2]), fall=("sec", t[1::2]))
    assert "two.csv --edges rise --falling fall\n" in vvdp("estimate", "two.csv").err


def test_a_config_for_edges_beside_a_clock_is_written(vvdp, here):
    t = np.arange(0.0, 1.0, 1e-3)
    table(here / "log.csv", t=("s", t), c=("s", t + 0.1))
    done = vvdp("estimate", "log.csv", "--edges", "c", "--time", "t", "--write-config", "c.toml")
    assert done.code == 0, done.err
    assert load_estimation(here / "c.toml").time == "t"


def test_the_settings_are_fitted_on_request(vvdp, stamps):
    done = vvdp("estimate", stamps, "--edges", "edge", "--fit", "--json", "--no-report", "--out", "r")
    assert done.code == 0, done.err
    assert json.loads(done.out)["edge_variance_rad2"] < 1e-9
    wanted = load_estimation(Path("r/estimate.toml"))
    assert wanted.filter.edge_variance == json.loads(done.out)["edge_variance_rad2"] and not wanted.fit


def test_a_clock_is_not_taken_for_a_wave(vvdp, here):
    t = np.arange(0.0, 1.0, 1e-3)
    table(here / "plain.csv", t=("", t), a=("", np.sign(np.sin(4.0 * SPEED * t))), b=("", t * t))
    assert "--wave a\n" in vvdp("estimate", "plain.csv").err


def test_separate_columns_of_rising_and_falling_edges(vvdp, here):
    t = 0.2 + np.arange(400) * PITCH / SPEED
    table(here / "two.csv", up=("s", t[0::2]), down=("s", t[1::2]))
    done = vvdp("estimate", "two.csv", "--edges", "up", "--falling", "down", "--json", "--no-report")
    assert done.code == 0, done.err
    assert json.loads(done.out)["edges"] == 400
    assert json.loads(done.out)["threshold_bias_rad"] == pytest.approx(0.0, abs=1e-6)


def test_a_log_without_a_clock_needs_a_rate(vvdp, here):
    t = np.arange(0.0, 1.0, 1e-3)
    table(here / "bare.csv", n=("", np.floor(SPEED * t / PITCH)), m=("", t))
    refused = vvdp("estimate", "bare.csv", "--counts", "n")
    assert refused.code == 2 and "clock" in refused.err
    done = vvdp("estimate", "bare.csv", "--counts", "n", "--sample-rate", "1 kHz", "--json", "--no-report")
    assert done.code == 0, done.err
    assert json.loads(done.out)["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=5e-3)


GUIDE = Path(__file__).parents[2] / "docs" / "command-line.md"


def shown_after(command):
    """The lines that the guide shows after a command."""
    text = GUIDE.read_text("utf-8").partition(f"    $ {command}\n")[2]
    lines = [line.strip() for line in re.split(r"\n(?=[^ \n])", text, maxsplit=1)[0].splitlines()]
    return [line for line in lines if line]


def test_the_examples_of_the_guide_are_real(vvdp, here):
    jitter = np.random.default_rng(0).normal(0.0, 0.055, 2000)
    t = np.delete(0.2 + (np.arange(2000) * PITCH + jitter) / SPEED, [700, 1200])
    (here / "edges.csv").write_text("edge [s]\n" + "\n".join(f"{x:.7f}" for x in t) + "\n")
    for command in (
        "vvdp estimate edges.csv --edges edge --sectors 8 --out results/edges",
        "vvdp estimate edges.csv --edges edge --write-config edges.toml",
        "vvdp estimate edges.csv",
    ):
        lines = shown_after(command)
        done = vvdp(*shlex.split(command)[1:])
        said = [line.strip() for line in (done.out + done.err).splitlines()]
        assert lines and [line for line in lines if line not in said] == []


BAD = [
    (("--edges", "egde"), wording.files.did_you_mean.format(name="edge")),
    ((), wording.estimate.no_channel_named),
    (("--edges", "edge", "--wave", "edge"), wording.estimate.one_of_them),
    (("--edges", "edge", "--sectors", "7"), "--sectors: " + wording.estimate.sectors.format(count=7)),
    (("--edges", "edge", "--sectors", "0"), "--sectors: " + wording.estimate.whole_number_from.format(value=0, low=2)),
    (("--edges", "edge", "--sectors", "8.5"), "--sectors"),
    (("--edges", "edge", "--index-shift", "1.5"), "--index-shift: " + wording.estimate.index_shift.format(value=1.5)),
    (("--edges", "edge", "--index-shift", "nan"), "--index-shift"),
    (("--edges", "edge", "--falling", "edge"), "--falling:"),
    (("--edges", "edge", "--falling", "none"), wording.estimate.no_channel.format(name="none")),
    (("--edges", "edge", "--sample-rate", "1 kHz"), wording.estimate.leave_it_out),
    (("--edges", "edge", "--time", "edge"), wording.estimate.leave_it_out),
    (("--counts", "edge", "--sample-rate", "10"), "--sample-rate: '10' " + wording.files.has_no_unit),
    (("--counts", "edge", "--sample-rate", "-1 Hz"), "--sample-rate"),
    (("--edges", "edge", "--output-rate", "0 Hz"), "--output-rate"),
    (
        ("--edges", "edge", "--output-rate", "1 m"),
        "--output-rate: '1 m' " + wording.files.is_not_a.format(quantity="a frequency"),
    ),
    (
        ("--edges", "edge", "--sections", "0"),
        "--sections: " + wording.estimate.whole_number_from.format(value=0, low=1) + " to 100",
    ),
    (("--edges", "edge", "--pressure", "edge"), wording.estimate.needs_clock),
    (("--edges", "edge", "--fuse"), "--fuse: " + wording.estimate.belongs_to.format(key="pressure.channel")),
    (("--edges", "edge", "--config", "none.toml"), "none.toml: " + wording.files.no_file),
    (("--edges", ""), wording.estimate.name_in_quotes),
    (("--edges", "edge", "--out", ""), "--out': " + wording.estimate.out_is_empty),
]


@pytest.mark.parametrize(("options", "piece"), BAD)
def test_bad_options_are_told_and_nothing_is_left(vvdp, stamps, here, options, piece):
    refused = vvdp("estimate", stamps, *options)
    assert refused.code == 2, refused
    assert piece in refused.err and "Traceback" not in refused.err
    assert not refused.out
    assert [p.name for p in here.iterdir()] == ["edges.csv"] or list((here / "results").iterdir()) == []


def test_several_faults_are_told_together(vvdp, stamps, here):
    (here / "c.toml").write_text('[sensor]\nedges = "edge"\nsectors = 5\n[output]\nrate = "fast"\n')
    refused = vvdp("estimate", stamps, "--config", "c.toml", "--sections", "0")
    assert refused.code == 2
    lines = refused.err.splitlines()
    assert any(line.startswith("c.toml:3: sensor.sectors:") for line in lines)
    assert any(line.startswith("c.toml:5: output.rate:") for line in lines)
    assert any(line.startswith("--sections:") for line in lines)


@pytest.mark.parametrize(
    ("name", "content", "piece"),
    [
        ("none.csv", None, wording.files.no_file),
        ("empty.csv", b"", wording.files.is_empty),
        ("log.xyz", b"a\n1\n", "extension"),
        ("text.csv", b"edge [s]\nhello\n", ""),
        ("few.csv", b"edge [s]\n1.0\n1.1\n", wording.estimate.edges_found.format(count=2)),
        ("unit.csv", b"edge [bar]\n1.0\n1.1\n1.2\n", wording.estimate.edge_unit.format(channel="edge", unit="bar")),
        ("same.csv", b"edge [s]\n1.0\n1.0\n1.0\n1.0\n", wording.estimate.needs),
    ],
)
def test_bad_logs_are_refused(vvdp, here, name, content, piece):
    if content is not None:
        (here / name).write_bytes(content)
    refused = vvdp("estimate", name, "--edges", "edge", "--no-report")
    assert refused.code == 2, refused
    assert piece in refused.err and "Traceback" not in refused.err


def test_ctrl_c_keeps_what_was_reached(here):
    h5py = pytest.importorskip("h5py")
    n = 15_000_000
    with h5py.File(here / "long.h5", "w") as file:
        t = file.create_dataset("time", (n,), "f8", chunks=(1 << 16,), compression="gzip", compression_opts=1)
        counts = file.create_dataset("count", (n,), "f4", chunks=(1 << 16,), compression="gzip", compression_opts=1)
        t.attrs["units"], counts.attrs["units"] = "s", "1"
        for begin in range(0, n, 3_000_000):
            place = np.arange(begin, begin + 3_000_000)
            t[begin : begin + place.size] = place * 1e-4
            counts[begin : begin + place.size] = np.floor(place * 1e-4 * SPEED / PITCH)
    environment = {**os.environ, "PYTHONPATH": str(Path(package.__file__).parents[1])}
    # Each portion tells how far it is, so that the signal comes in the middle however fast the machine is.
    program = "from vvdp.cli import main, progress; progress.LINE_INTERVAL = 0.0; main.main()"
    arguments = ["estimate", "long.h5", "--counts", "count", "--no-report", "--out", "r"]
    command = [sys.executable, "-c", program, *arguments]
    with subprocess.Popen(command, cwd=here, env=environment, stderr=subprocess.PIPE, stdout=subprocess.PIPE,
                          text=True) as running:  # fmt: skip
        assert running.stderr is not None
        for line in running.stderr:
            if wording.estimate.of_the_log in line:
                break
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=60)
    assert running.returncode == 130, err
    assert wording.progress.reached_kept in err
    assert re.search(wording.estimate.stopped_after + r"[\d.]+ s", out)
    kept = read_result(here / "r")
    assert not kept.finished
    assert 0.0 < kept.numbers["duration_s"].value < n * 1e-4
    assert sorted(p.name for p in here.iterdir()) == ["long.h5", "r"]
