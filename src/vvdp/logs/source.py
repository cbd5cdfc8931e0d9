"""Opening a log: the format by its first bytes, which must agree with the extension."""

from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from vvdp.base.errors import unusable
from vvdp.base.extras import require
from vvdp.logs.budget import reading
from vvdp.logs.channel import Log
from vvdp.logs.clock import ClockChoice
from vvdp.logs.content import Content

FORMATS = {
    ".csv": "text", ".tsv": "text", ".txt": "text", ".tab": "text", ".asc": "text", ".dat": "text or MDF",
    ".tdms": "TDMS", ".mf4": "MDF", ".mdf": "MDF", ".mat": "MATLAB",
    ".h5": "HDF5", ".hdf5": "HDF5", ".hdf": "HDF5", ".nc": "HDF5", ".parquet": "Parquet", ".pq": "Parquet",
}  # fmt: skip
_HDF5 = b"\x89HDF\r\n\x1a\n"
_BEGINNINGS = {
    b"TDSm": "TDMS", b"TDSh": "a TDMS index without its data", b"UnFinMF ": "MDF", b"PAR1": "Parquet",
    b"PARE": "encrypted Parquet", b"MATLAB": "MATLAB", b"\x1f\x8b": "gzip (unpack it first)",
    b"PK": "a ZIP archive or a spreadsheet (export it as CSV)", b"\xff\xfe": "UTF-16 text (save it as UTF-8)",
    b"\xfe\xff": "UTF-16 text (save it as UTF-8)",
}  # fmt: skip


_LIBRARIES = {
    "text": ("pandas", ""), "TDMS": ("nptdms", "daq"), "MDF": ("asammdf", "daq"), "Parquet": ("pyarrow", "data"),
    "HDF5": ("h5py", ""), "MATLAB": ("scipy", ""), "MATLAB 7.3": ("h5py", ""),
}  # fmt: skip
"""Reader of a format, and the extra that brings it."""


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
    found = _detect_format(path, _head(path))
    expected = FORMATS.get(path.suffix.lower())
    if expected is None:
        is_one = f" (its content is {found})" if found != "text" else ""
        raise unusable(path, f"has the extension {path.suffix!r}{is_one}; expected one of {', '.join(FORMATS)}")
    if found not in _LIBRARIES or found.removesuffix(" 7.3") not in expected.split(" or "):
        raise unusable(path, f"is {found} by its content, not {expected} as its extension {path.suffix!r} says")
    library, extra = _LIBRARIES[found]
    if extra:
        require(library, extra, f"{path} ({found})")
    content = Content(path, choice, library=f"{library} {version(library)}")
    try:
        with reading(path, f"the {found} file", content.library):
            _reader(found)(content)
        return Log(content)
    except BaseException:
        content.close()
        raise


def _reader(found: str) -> Callable[[Content], None]:
    """Reader of the content of a format; its library is imported for it alone."""
    match found:
        case "text":
            from vvdp.logs.text import read_text as read
        case "TDMS":
            from vvdp.logs.tdms import read_tdms as read
        case "MDF":
            from vvdp.logs.mdf import read_mdf as read
        case "Parquet":
            from vvdp.logs.parquet import read_parquet as read
        case "HDF5":
            from vvdp.logs.hdf5 import read_hdf5 as read
        case "MATLAB 7.3":
            from vvdp.logs.mat import read_mat73 as read
        case _:
            from vvdp.logs.mat import read_mat as read
    return read


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
    """The format of the file by its content."""
    is_mat = path.suffix.lower() == ".mat"
    if any(head[place : place + 8] == _HDF5 for place in (0, 512)):
        return "MATLAB 7.3" if head[:10] == b"MATLAB 7.3" or is_mat else "HDF5"
    if head[:3] == b"MDF" and not head[3:8].strip():
        return "MDF"
    for beginning, found in _BEGINNINGS.items():
        if head.startswith(beginning):
            return found
    if is_mat:
        return "MATLAB"
    return "text" if b"\0" not in head else "neither text nor a format that is known here"
