"""An hour of log at 10 kHz, photodiode wave and inlet pressure, through `vvdp estimate`: seconds and peak memory."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.measure import report, run_as_command, spread

RATE, HOUR = 10_000.0, 3600.0
SECTORS, SECTIONS = 8, 3
MEAN_SPEED = 2.0 * np.pi * 24.7
SWAY, SLOWLY = 20.0, 0.05
"""By how much the angle goes to and fro beside the mean speed [rad], and how fast [rad/s]."""
PORTION = 1_000_000
ROUNDS = 3
BINARY_TARGET, TEXT_TARGET, MEMORY_TARGET = 30.0, 60.0, 800.0
"""Seconds, seconds, MiB."""
NAMES = ("photodiode", "inlet")
UNITS = ("V", "bar")
Portion = tuple[np.ndarray, np.ndarray, np.ndarray]


def bench(seconds: float) -> Iterator[Portion]:
    """Time, wave and pressure as a bench records them: a speed that wanders, ramps of some samples, noise."""
    random = np.random.default_rng(1)
    for begin in range(0, round(seconds * RATE), PORTION):
        t = np.arange(begin, min(begin + PORTION, round(seconds * RATE))) / RATE
        angle = 0.3 + MEAN_SPEED * t + SWAY * np.sin(SLOWLY * t)
        light = np.clip(0.5 + 1.6 * np.sin(0.5 * SECTORS * angle), 0.0, 1.0)
        inlet = np.clip(50.0 + 300.0 * np.sin(SECTIONS * angle), 5.0, 100.0)
        wave = 0.4 + 3.0 * light + random.normal(0.0, 0.02, t.size)
        yield t, np.round(wave, 4), np.round(inlet + random.normal(0.0, 0.3, t.size), 2)


def tdms(path: Path, portions: Iterator[Portion]) -> None:
    """As LabVIEW streams it: a segment for each portion."""
    import nptdms

    with nptdms.TdmsWriter(path) as file:
        for _, *signals in portions:
            file.write_segment(
                [
                    nptdms.ChannelObject("bench", name, values, {"wf_increment": 1.0 / RATE, "unit_string": unit})
                    for name, unit, values in zip(NAMES, UNITS, signals, strict=True)
                ]
            )


def mdf4(path: Path, portions: Iterator[Portion]) -> None:
    """Single precision, uncompressed, one group with a master."""
    import asammdf

    with asammdf.MDF(version="4.10") as file:
        for place, (t, *signals) in enumerate(portions):
            singles = [values.astype(np.float32) for values in signals]
            if place:
                file.extend(0, [(t, None), *((values, None) for values in singles)])
            else:
                named = zip(NAMES, UNITS, singles, strict=True)
                file.append([asammdf.Signal(values, t, unit, name) for name, unit, values in named])
        file.save(path, overwrite=True)


def hdf5(path: Path, portions: Iterator[Portion]) -> None:
    """Single precision, compressed."""
    import h5py

    with h5py.File(path, "w") as file:
        group = file.create_group("bench")
        group.attrs["dt"] = 1.0 / RATE
        for name, unit in zip(NAMES, UNITS, strict=True):
            dataset = group.create_dataset(name, (0,), "f4", maxshape=(None,), chunks=(65536,), compression="gzip",
                                           compression_opts=1, shuffle=True)  # fmt: skip
            dataset.attrs["units"] = unit
        for _, *signals in portions:
            for name, values in zip(NAMES, signals, strict=True):
                size = group[name].shape[0]
                group[name].resize((size + values.size,))
                group[name][size:] = values


def csv(path: Path, portions: Iterator[Portion]) -> None:
    """Time, wave and pressure, no more digits than were measured."""
    import pyarrow as pa
    from pyarrow import csv as text

    with path.open("wb") as file:
        file.write(b"time [s],photodiode [V],inlet [bar]\n")
        for columns in portions:
            table = pa.table({str(k): column for k, column in enumerate(columns)})
            text.write_csv(table, file, text.WriteOptions(include_header=False))


WRITERS: dict[str, Callable[[Path, Iterator[Portion]], None]] = {
    "hour.tdms": tdms, "hour.mf4": mdf4, "hour.h5": hdf5, "hour.csv": csv,
}  # fmt: skip


def written(folder: Path, names: Iterable[str], seconds: float) -> Iterator[Path]:
    """The logs of these names."""
    for name in names:
        WRITERS[name](folder / name, bench(seconds))
        yield folder / name


def estimated(path: Path) -> tuple[float, float, float, dict[str, object]]:
    """Wall and processor time [s], peak memory [MiB] and summary of the command, in a process of its own."""
    out = path.with_suffix(".result")
    options = ["--wave", "photodiode", "--pressure", "inlet", "--sectors", str(SECTORS)]
    command = [sys.executable, "-m", "vvdp", "estimate", str(path), *options, "--no-report", "--json", "--force"]
    began = time.perf_counter()
    with (
        tempfile.TemporaryFile() as said,
        subprocess.Popen([*command, "--out", str(out)], stdout=subprocess.PIPE, stderr=said) as running,
    ):
        assert running.stdout is not None
        answer = running.stdout.read()
        _, status, used = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - began
        said.seek(0)
        errors = said.read().decode(errors="replace")
    if running.returncode:
        raise SystemExit(f"{path.name}: the command ended with {running.returncode}\n{errors}".rstrip())
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0, json.loads(answer)


def main(short: bool) -> None:
    """Each format in turn, some rounds; the median is held against the target. The short form: two, ten seconds."""
    with tempfile.TemporaryDirectory() as folder:
        seconds, rounds = (10.0, 1) if short else (HOUR, ROUNDS)
        names = list(WRITERS)[2:] if short else list(WRITERS)
        paths = list(written(Path(folder), names, seconds))
        estimated(paths[0])  # compiles what is not compiled yet
        for path in paths:
            tell(path, [estimated(path) for _ in range(rounds)], seconds)


def tell(path: Path, runs: list[tuple[float, float, float, dict[str, object]]], seconds: float) -> None:
    """The figures of a format."""
    target = TEXT_TARGET if path.suffix == ".csv" else BINARY_TARGET
    wall, cpu, memory = ([run[k] for run in runs] for k in range(3))
    mapped = path.stat().st_size / 2.0**20 if path.suffix == ".mf4" else 0.0  # counted, but not held
    name = f"{path.suffix[1:]}, {path.stat().st_size / 1e9:.2f} GB"
    report(name, spread(wall, "s"), f"{target:g}", median(wall) <= target)
    report(f"{name}, processor time", spread(cpu, "s"))
    beside = f", beside {mapped:.0f} MiB of mapped file" if mapped else ""
    own = [peak - mapped for peak in memory]
    report(f"{name}, peak memory", spread(own, "MiB") + beside, f"{MEMORY_TARGET:g}", max(own) <= MEMORY_TARGET)
    found = float(str(runs[0][3]["spool_speed_mean_rad_s"]))
    true = MEAN_SPEED + SWAY * np.sin(SLOWLY * seconds) / seconds
    report(f"{name}, error of the mean speed", f"{found - true:.2g} rad/s")


if __name__ == "__main__":
    run_as_command(main)
