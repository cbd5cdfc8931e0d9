"""Opening a log: the format by its first bytes, which must agree with the extension."""

from pathlib import Path

from vvdp.base.errors import unusable
from vvdp.base.extras import require
from vvdp.logs.channel import Log
from vvdp.logs.clock import ClockChoice

FORMATS = {
    ".csv": "text", ".tsv": "text", ".txt": "text", ".tab": "text", ".asc": "text", ".dat": "text or MDF",
    ".tdms": "TDMS", ".mf4": "MDF", ".mdf": "MDF", ".mat": "MATLAB",
    ".h5": "HDF5", ".hdf5": "HDF5", ".hdf": "HDF5", ".nc": "HDF5", ".parquet": "Parquet", ".pq": "Parquet",
}  # fmt: skip
_HDF5 = b"\x89HDF\r\n\x1a\n"


def open_log(path: Path, *, time: str | None = None, rate: float | None = None, time_unit: str | None = None) -> Log:
    """The log in the file `path`.

    time       name of the channel that is the clock, where the file does not say which
    rate       samples per second [Hz] of channels that have no clock; refused where they have one
    time_unit  unit of the clock where the file has none written
    Raises ConfigError where the file is unknown, unreadable or damaged, MissingExtraError where the library that reads
    it is not installed, ParameterError for options that contradict each other.
    """
    path = Path(path)
    choice = ClockChoice(time, rate, time_unit)
    choice.check()
    head = _head(path)
    found = _detect_format(path, head)
    expected = FORMATS.get(path.suffix.lower())
    if expected is None:
        is_one = f" (its content is {found})" if found != "text" else ""
        raise unusable(path, f"has the extension {path.suffix!r}{is_one}; expected one of {', '.join(FORMATS)}")
    if not _agree(expected, found):
        raise unusable(path, f"is {found} by its content, not {expected} as its extension {path.suffix!r} says")
    if found == "text":
        from vvdp.logs.text import text_log

        return text_log(path, choice)
    if found == "TDMS":
        require("nptdms", "daq", f"{path} ({found})")
        from vvdp.logs.tdms import tdms_log

        return tdms_log(path, choice)
    if found == "MDF":
        require("asammdf", "daq", f"{path} ({found})")
        from vvdp.logs.mdf import mdf_log

        return mdf_log(path, choice)
    if found == "Parquet":
        require("pyarrow", "data", f"{path} ({found})")
        from vvdp.logs.parquet import parquet_log

        return parquet_log(path, choice)
    if found == "HDF5":
        from vvdp.logs.hdf5 import hdf5_log

        return hdf5_log(path, choice)
    from vvdp.logs.mat import mat73_log, mat_log

    return mat73_log(path, choice) if found == "MATLAB 7.3" else mat_log(path, choice)


def _head(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise unusable(path, "is a directory; expected a log")
        if path.exists() and not path.is_file():  # a device or pipe may never end
            raise unusable(path, "is not a regular file")
        with path.open("rb") as file:
            head = file.read(1024)
    except FileNotFoundError:
        raise unusable(path, "no such file") from None
    except OSError as problem:
        raise unusable(path, f"cannot be read ({problem.strerror})") from None
    if not head:
        raise unusable(path, "is empty")
    return head


def _detect_format(path: Path, head: bytes) -> str:
    """What the file is by its content."""
    if head[:4] in (b"TDSm", b"TDSh"):
        return "TDMS" if head[:4] == b"TDSm" else "a TDMS index without its data"
    if (head[:3] == b"MDF" and not head[3:8].strip()) or head[:8] == b"UnFinMF ":
        return "MDF"
    if head[:4] == b"PAR1":
        return "Parquet"
    if head[:4] == b"PARE":
        return "encrypted Parquet"
    if head[:2] == b"\x1f\x8b":
        return "gzip (unpack it first)"
    if head[:2] == b"PK":
        return "a ZIP archive or a spreadsheet (export it as CSV)"
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "UTF-16 text (save it as UTF-8)"
    if any(head[place : place + 8] == _HDF5 for place in (0, 512)):
        return "MATLAB 7.3" if head[:10] == b"MATLAB 7.3" or path.suffix.lower() == ".mat" else "HDF5"
    if head[:6] == b"MATLAB" or path.suffix.lower() == ".mat":
        return "MATLAB"
    return "text" if b"\0" not in head else "neither text nor a format that is known here"


def _agree(expected: str, found: str) -> bool:
    if expected == "MATLAB":
        return found in ("MATLAB", "MATLAB 7.3")
    return found in expected.split(" or ")
