"""Measured logs: those that were damaged, and those that were made to do harm."""

import io
import json
import shutil
import zipfile
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from tests.attack.cage import Reading
from tests.attack.fields import command, seeded
from tests.logs import files, hostile

SOURCES = (("--wave", "v"), ("--counts", "w"), ("--edges", "time"))
SHARE = 0.02
"""By how much a speed may be off without a warning."""
SPEED = "spool_speed_mean_rad_s"


def estimated(path: Path, folder: Path, *source: str) -> tuple[int, dict[str, object]]:
    """Exit code of `vvdp estimate` and what it found."""
    shutil.rmtree(folder / "out", ignore_errors=True)
    out = io.StringIO()
    with redirect_stdout(out):
        code = command("estimate", str(path), *source, "--sectors", "8", "--out", str(folder / "out"),
                       "--no-report", "--json")  # fmt: skip
    return code, json.loads(out.getvalue()) if code == 0 else {}


@dataclass(frozen=True)
class DamagedLogs:
    """Logs of nine writers with one to four accidents: refused, right to 2 %, or with a warning."""

    name: str = "damaged logs"
    files: int = 500
    truths: dict[tuple[int, int], float] = field(default_factory=dict)

    def warm(self, folder: Path) -> None:
        """Takes the speeds from the sound logs."""
        for writer in range(len(files.WRITERS)):
            path = files.write_log(writer, folder)
            for number, source in enumerate(SOURCES):
                code, found = estimated(path, folder, *source)
                self.truths[writer, number] = float(str(found[SPEED])) if code == 0 else np.nan

    def attack(self, seed: int, folder: Path) -> Reading:
        """Estimates the speed from a damaged log."""
        random = seeded(seed, self.name)
        writer, number = seed % len(files.WRITERS), int(random.integers(len(SOURCES)))
        path = files.write_log(writer, folder)
        path.write_bytes(files.mutate(path.read_bytes(), random))
        code, found = estimated(path, folder, *SOURCES[number])
        truth = self.truths[writer, number]
        if code or found["warnings"] or np.isnan(truth) or found[SPEED] is None:
            return Reading(code)
        off = abs(float(str(found[SPEED])) / truth - 1.0)
        return Reading(0, f"{100.0 * off:.1f} % off without a warning" if off > SHARE else "")


@dataclass(frozen=True)
class HostileLogs:
    """Files made to do harm, each by its own trick: refused, or read without the harm."""

    name: str = "hostile logs"

    @property
    def files(self) -> int:
        """How many tricks there are."""
        return len(TRICKS)

    def warm(self, folder: Path) -> None:
        """Loads the readers and the filter."""
        for writer in range(len(files.WRITERS)):
            estimated(files.write_log(writer, folder), folder, *SOURCES[0])

    def attack(self, seed: int, folder: Path) -> Reading:
        """Estimates the speed from a sound channel beside the trick, and from the trick itself."""
        suffix, write = TRICKS[seed]
        path = folder / f"a{suffix}"
        for each in folder.glob("a.*"):
            shutil.rmtree(each) if each.is_dir() else each.unlink()
        write(path)
        codes = [estimated(path, folder, "--wave", name)[0] for name in ("v", "other")]
        return Reading(max(codes, key=lambda code: (code not in (0, 1, 2, 3), code)))


def _rows(*lines: bytes, head: bytes = b"time [s],v\n") -> Callable[[Path], Path]:
    """A sound beginning and what comes after it."""

    def write(path: Path) -> Path:
        path.write_bytes(
            head + b"".join(b"%.3f,%.4f\n" % (k * 1e-3, k % 41 / 41) for k in range(600)) + b"".join(lines)
        )
        return path

    return write


def zip_in_disguise(path: Path) -> Path:
    """An archive whose members lead out of it."""
    with zipfile.ZipFile(path, "w") as file:
        for name in ("../../outside.csv", "/tmp/outside.csv", "a.csv"):
            file.writestr(name, "time,v\n0,1\n1,2\n")
    return path


def pickle_in_disguise(path: Path) -> Path:
    """A pickle that calls a function when it is loaded."""
    path.write_bytes(b"cos\nsystem\n(S'touch pickled'\ntR.")
    return path


def link_to_itself(path: Path) -> Path:
    """A link that leads to itself."""
    path.symlink_to(path.name)
    return path


def a_folder(path: Path) -> Path:
    """A folder with the name of a log."""
    path.mkdir()
    return path


def endless_device(path: Path) -> Path:
    """A device that never ends."""
    path.symlink_to("/dev/zero")
    return path


def sparse_giant(path: Path) -> Path:
    """A sound beginning and a hole of four gigabytes."""
    _rows()(path)
    with path.open("r+b") as file:
        file.truncate(1 << 32)
    return path


def scale_offset_overflow(path: Path) -> Path:
    """Scales that make every number infinite."""

    def fill(file: h5py.File) -> None:
        held = file.create_dataset("other", data=np.arange(1000.0))
        held.attrs.update({"scale_factor": 1e308, "add_offset": -1e308, "dt": 1e-320})

    return hostile.with_datasets(path, fill)


def times_from_text(path: Path) -> Path:
    """A time axis of text, and one of a thousand dimensions of length one."""

    def fill(file: h5py.File) -> None:
        file["other"] = np.ones((1,) * 30)
        del file["time"]
        file["time"] = np.array([b"soon"] * 1000)

    return hostile.with_datasets(path, fill)


OWN = [
    (".csv", zip_in_disguise), (".h5", pickle_in_disguise), (".mat", pickle_in_disguise), (".csv", link_to_itself),
    (".csv", a_folder), (".csv", endless_device), (".csv", sparse_giant), (".h5", scale_offset_overflow),
    (".h5", times_from_text),
    (".csv", _rows(b"\r" * 200_000)),
    (".csv", _rows(b"0.6,1\n" * 20_000)),
    (".csv", _rows(b"0.600;0,5\n0.601;0,5\n" * 2000)),
    (".csv", _rows(b"0.6,=cmd|' /C calc'!A0\n" * 50)),
    (".csv", _rows(b"0.6,\xef\xbc\x91\n0.601,\xd9\xa3\n" * 50)),
    (".csv", _rows(b"1e-400,1e-400\n" * 500)),
    (".csv", _rows(head=b"\xef\xbb\xbf\xef\xbb\xbftime [s],v,v,v\n")),
    (".csv", _rows(head=b"time [" + b"s" * 100_000 + b"],v\n")),
    (".csv", _rows(head=b"# " + b"x" * 3_000_000 + b"\ntime [s],v\n")),
    (".tdms", _rows()), (".mf4", _rows()), (".parquet", _rows()), (".mat", _rows()),
]  # fmt: skip
TRICKS = [*((suffix, write) for suffix, made in hostile.ALL.items() for write in made), *OWN]
