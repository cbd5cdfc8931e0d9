"""An hour of log at 10 kHz, photodiode wave and inlet pressure, through `vvdp estimate`: seconds and peak memory.

The present code and a commit that has landed run in turns, each in a process of its own, so that their ratio holds on
a busy machine as well.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

from benchmarks.measure import HERE, report, run_as_command, spread
from benchmarks.reference import taken_out

COMMIT = "e01da77c"
"""The last one whose deviations leave out what edges cannot tell."""

RATE, HOUR = 10_000.0, 3600.0
SECTORS, SECTIONS = 8, 3
MEAN_SPEED = 2.0 * np.pi * 24.7
SWAY, SLOWLY = 20.0, 0.05
"""By how much the angle goes to and fro beside the mean speed [rad], and how fast [rad/s]."""
PORTION = 1_000_000
ROUNDS = 3
TIME_TARGET, MEMORY_TARGET = 1.2, 800.0
"""Of the time of the earlier commit, and MiB."""
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


def mat(path: Path, portions: Iterator[Portion]) -> None:
    """Version 5, unpacked, single precision beside a clock in double precision."""
    import scipy.io

    times, *signals = (np.concatenate(part) for part in zip(*portions, strict=True))
    singles = {name: values.astype(np.float32) for name, values in zip(NAMES, signals, strict=True)}
    units = {f"{name}Info": {"Units": unit} for name, unit in zip(NAMES, UNITS, strict=True)}
    scipy.io.savemat(path, {"time": times, **singles, **units})


def parquet(path: Path, portions: Iterator[Portion]) -> None:
    """A group of rows for each portion, packed as pyarrow does by itself."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = ["time [s]", *(f"{name} [{unit}]" for name, unit in zip(NAMES, UNITS, strict=True))]
    with pq.ParquetWriter(path, pa.schema([(name, pa.float64()) for name in names])) as file:
        for columns in portions:
            file.write_table(pa.table(dict(zip(names, columns, strict=True))))


WRITERS: dict[str, Callable[[Path, Iterator[Portion]], None]] = {
    "hour.tdms": tdms, "hour.mf4": mdf4, "hour.h5": hdf5, "hour.mat": mat, "hour.parquet": parquet, "hour.csv": csv,
}  # fmt: skip


class Cost(NamedTuple):
    """Wall and processor time [s], peak memory [MiB] and mean speed [rad/s] of an estimate."""

    wall: float
    cpu: float
    memory: float
    speed: float


def write_log(path: Path, seconds: float) -> None:
    """The log of this name."""
    WRITERS[path.name](path, bench(seconds))


def write_apart(path: Path, seconds: float) -> Path:
    """The same in a process of its own: what a process is told to have held at most includes what its parent held."""
    writer = get_context("spawn").Process(target=write_log, args=(path, seconds))
    writer.start()
    writer.join()
    if writer.exitcode:
        raise SystemExit(f"{path.name}: could not be written")
    return path


def estimate(path: Path, source: Path, cache: Path | None) -> Cost:
    """What the command of the code in a folder costs, in a process of its own."""
    out = path.with_suffix(".result")
    options = ["--wave", "photodiode", "--pressure", "inlet", "--sectors", str(SECTORS)]
    command = [sys.executable, "-m", "vvdp", "estimate", str(path), *options, "--no-report", "--json", "--force"]
    environment = {**os.environ, "PYTHONPATH": str(source / "src")} | ({"VVDP_CACHE": str(cache)} if cache else {})
    began = time.perf_counter()
    with (
        tempfile.TemporaryFile() as said,
        subprocess.Popen(
            [*command, "--out", str(out)], stdout=subprocess.PIPE, stderr=said, env=environment
        ) as running,
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
    mapped = path.stat().st_size / 2.0**20 if path.suffix == ".mf4" else 0.0  # counted, but not held
    memory = used.ru_maxrss / 1024.0 - mapped
    return Cost(wall, used.ru_utime + used.ru_stime, memory, float(json.loads(answer)["spool_speed_mean_rad_s"]))


def main(short: bool) -> None:
    """Each format in turn, some rounds of both builds. The short form: two, ten seconds, the present code twice."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        earlier = None if short else stack.enter_context(taken_out(COMMIT))
        builds = {"now": (HERE.parent, None), COMMIT: (HERE.parent, None)}
        if earlier is not None:
            builds[COMMIT] = (earlier, folder / "cache")
        seconds, rounds = (10.0, 1) if short else (HOUR, ROUNDS)
        warm = write_apart(folder / "hour.csv", 10.0)
        for build in builds.values():
            estimate(warm, *build)  # compiles what is not compiled yet
        for name in list(WRITERS)[3:5] if short else WRITERS:
            path = write_apart(folder / name, seconds)
            costs: dict[str, list[Cost]] = {build: [] for build in builds}
            for _ in range(rounds):
                for build, where in builds.items():
                    costs[build].append(estimate(path, *where))
            tell(path, costs["now"], costs[COMMIT], seconds)
            path.unlink()


def tell(path: Path, now: list[Cost], then: list[Cost], seconds: float) -> None:
    """The figures of a format."""
    name = f"{path.suffix[1:]}, {path.stat().st_size / 1e9:.2f} GB"
    report(f"{name}, wall time", spread([cost.wall for cost in now], "s"))
    report(f"{name}, processor time", spread([cost.cpu for cost in now], "s"), listed=True)
    ratio = median(a.cpu / b.cpu for a, b in zip(now, then, strict=True))
    report(f"{name}, processor time over {COMMIT}", f"{ratio:.3g} times", f"{TIME_TARGET:g}", ratio <= TIME_TARGET)
    peak = [cost.memory for cost in now]
    report(f"{name}, peak memory", spread(peak, "MiB"), f"{MEMORY_TARGET:g}", max(peak) <= MEMORY_TARGET)
    share = median(a.memory / b.memory for a, b in zip(now, then, strict=True))
    report(f"{name}, peak memory over {COMMIT}", f"{share:.3g} times", listed=True)
    true = MEAN_SPEED + SWAY * np.sin(SLOWLY * seconds) / seconds
    report(f"{name}, error of the mean speed", f"{now[0].speed - true:.2g} rad/s")


if __name__ == "__main__":
    run_as_command(main)
