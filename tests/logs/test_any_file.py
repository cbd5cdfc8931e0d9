"""Whatever a file holds, `vvdp estimate` gives a result or says in a line why not; it does not fail, hang or swell."""

import subprocess
import sys
import time
import zlib

import h5py
import numpy as np
import pytest
from tests.logs import files, hostile
from tests.words import wording

from vvdp.cli.main import main
from vvdp.logs.hdf5 import Parts

pytestmark = pytest.mark.thorough

LONGEST = 10.0
"""Processor time that a file may take [s]."""
SOURCES = (("--wave", "v"), ("--counts", "w"), ("--edges", "time"))


def estimate(path, out, capsys, *options):
    """Exit code and what was said; processor time is within its limit."""
    began = time.process_time()
    with pytest.raises(SystemExit) as ended:
        main(["estimate", str(path), *options, "--sectors", "8", "--out", str(out), "--no-report"])
    code = int(ended.value.code or 0)
    assert time.process_time() - began < LONGEST
    said = capsys.readouterr()
    assert "Traceback" not in said.err and "Warning" not in said.err
    assert code in (0, 1, 2) and wording.logs.mistake_of_vvdp not in said.err
    assert code == 0 or said.err.strip()
    return code, said.err


def mutated(seed, folder, capsys):
    random = np.random.default_rng(seed)
    path = files.write_log(seed, folder)
    path.write_bytes(files.mutate(path.read_bytes(), random))
    return estimate(path, folder / "out", capsys, *SOURCES[int(random.integers(3))])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(50))
def test_a_damaged_log_is_read_or_refused(seed, tmp_path, capsys):
    mutated(seed, tmp_path, capsys)


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(50, 400))
def test_more_damaged_logs_are_read_or_refused(seed, tmp_path, capsys):
    mutated(seed, tmp_path, capsys)


HOSTILE = [
    pytest.param(f"a{suffix}", write, id=write.__name__) for suffix, made in hostile.ALL.items() for write in made
]
REFUSED = (hostile.many_columns, hostile.long_field, hostile.backwards, hostile.endless_line, hostile.standing_clock)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("name", "write"), HOSTILE)
def test_a_file_made_to_harm_is_refused_or_read_without_that(name, write, tmp_path, capsys):
    code, said = estimate(write(tmp_path / name), tmp_path / "out", capsys, "--wave", "v")
    assert code == 2 or write not in REFUSED
    assert "\x1b" not in said
    if name == "a.h5":  # what does harm goes by that name
        code, said = estimate(tmp_path / name, tmp_path / "more", capsys, "--wave", "other")
        assert code == 2 and said


def test_a_chunk_that_is_too_short_is_never_filled_up(tmp_path):
    """HDF5 itself returns numbers for it, those that its memory held before."""
    path = tmp_path / "short.h5"
    with h5py.File(path, "w") as file:
        whole = file.create_dataset("whole", (2000,), "f8", data=np.ones(2000), chunks=(1000,), compression="gzip")
        whole.id.write_direct_chunk((1000,), zlib.compress(np.ones(999).tobytes()))
        parts = Parts(whole)
        assert np.array_equal(parts[slice(0, 1000),], np.ones(1000))
        with pytest.raises(ValueError, match="holds 7992 bytes, its shape needs 8000"):
            parts[slice(999, 1001),]
        unwritten = file.create_dataset("unwritten", (2000,), "f8", chunks=(1000,), compression="gzip", fillvalue=7.0)
        assert np.array_equal(Parts(unwritten)[slice(0, 2000),], np.full(2000, 7.0))


def test_there_are_forty_files_made_to_harm():
    assert len({write.id for write in HOSTILE}) >= 40


def test_edge_times_in_no_order_are_refused(tmp_path, capsys):
    code, said = estimate(hostile.unsorted(tmp_path / "a.csv"), tmp_path / "out", capsys, "--edges", "v")
    assert code == 2 and wording.logs.not_forward.format(count=1000) in " ".join(said.split())


BOMBS = """
import sys, time
from pathlib import Path
from vvdp.base.errors import ConfigError
from vvdp.logs.source import open_log
for name in sys.argv[1:]:
    began = time.process_time()
    try:
        with open_log(Path(name)) as log:
            for info in log.channels():
                try:
                    for portion in log.portions([info.name], 100_000):
                        pass
                except ConfigError as problem:
                    print(problem)
    except ConfigError as problem:
        print(problem)
    print(f"took {time.process_time() - began:.3f}", file=sys.stderr)
# What a process is told to have used at most holds what its parent had when it was started; this does not.
(most,) = (line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(float(most) / 1024)
"""


@pytest.mark.parametrize("formats", [(".h5", ".mat"), (".tdms", ".mf4", ".mdf", ".parquet", ".csv")])
def test_bombs_are_refused_soon_and_within_half_a_gigabyte(formats, tmp_path):
    # A quiet core takes up to two seconds, a shared one twice as long; what is not bounded takes hours.
    made = [write(tmp_path / f"{write.__name__}{suffix}") for suffix in formats for write in hostile.ALL[suffix]]
    done = subprocess.run(
        [sys.executable, "-c", BOMBS, *map(str, made)], capture_output=True, text=True, timeout=120, check=True
    )
    times = [float(line.split()[1]) for line in done.stderr.splitlines() if line.startswith("took")]
    assert len(times) == len(made) and max(times) < 20.0
    assert float(done.stdout.splitlines()[-1]) < 500.0
    assert (
        wording.logs.holds_more_than.format(count=10000) in done.stdout and wording.logs.claims_to_hold in done.stdout
    )
