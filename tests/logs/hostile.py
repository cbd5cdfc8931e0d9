"""Files that were made to do harm: bombs, circles, lies about sizes, links to other files, unfit names.

Each is written by one function of the path that it gets. Nothing here is larger than a few megabytes.
"""

import itertools
import struct
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import h5py
import numpy as np


def with_datasets(path: Path, fill: Callable[[h5py.File], None]) -> Path:
    """An HDF5 file with a clock, a wave, and what `fill` adds."""
    with h5py.File(path, "w") as file:
        file["time"], file["v"] = np.arange(1000) * 1e-3, np.sin(np.arange(1000) * 0.1)
        fill(file)
    return path


def to_parent(file: h5py.File) -> None:
    above = file.create_group("a")
    above.create_group("b")["up"] = above


def soft_to_root(file: h5py.File) -> None:
    file.create_group("a")["root"] = h5py.SoftLink("/")


def nested(file: h5py.File) -> None:
    group = file
    for _ in range(1200):
        group = group.create_group("g")
    group["v"] = np.arange(10.0)


def fans(file: h5py.File) -> None:
    """Thirty groups, each with ten names for the next: 10^30 paths."""
    groups = [file.create_group(f"g{k}") for k in range(30)]
    for group, following in itertools.pairwise(groups):
        for k in range(10):
            group[f"n{k}"] = following


def external_storage(file: h5py.File) -> None:
    file.create_dataset("other", (100,), "u1", external=[("/etc/hostname", 0, 100)])


def external_link(file: h5py.File) -> None:
    file["other"] = h5py.ExternalLink("/etc/hostname", "/")
    file["more"] = h5py.ExternalLink("elsewhere.h5", "/v")


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((100,), "f8")
    layout[:] = h5py.VirtualSource("elsewhere.h5", "v", (100,))
    file.create_virtual_dataset("other", layout)


def huge_chunk(file: h5py.File) -> None:
    held = file.create_dataset("other", (400_000_000,), "f8", chunks=(400_000_000,), compression="gzip")
    held.id.write_direct_chunk((0,), zlib.compress(bytes(1 << 20)))


def empty_giant(file: h5py.File) -> None:
    file.create_dataset("other", (10**15,), "f8", chunks=(1000,))


def many(file: h5py.File) -> None:
    for k in range(11_000):
        file.create_dataset(f"d{k}", (1,), "f8")


def matlab(path: Path, fill: Callable[[h5py.File], None]) -> Path:
    """A MATLAB file of version 7.3 with what `fill` adds."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file["time"], file["v"] = np.arange(1000)[None, :] * 1e-3, np.sin(np.arange(1000) * 0.1)[None, :]
        for name in ("time", "v"):
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        fill(file)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")
    return path


def _struct(group: h5py.Group) -> h5py.Group:
    group.attrs["MATLAB_class"] = np.bytes_("struct")
    return group


def of_itself(file: h5py.File) -> None:
    group = _struct(file.create_group("s"))
    group["field"] = np.array([[group.ref]], h5py.ref_dtype)


def tree_of_structs(file: h5py.File) -> None:
    """Twelve levels of ten references each: 10^12 nodes."""
    leaf = file.create_dataset("#refs#/leaf", data=np.ones((1, 2)))
    below = leaf
    for k in range(12):
        group = _struct(file.create_group(f"#refs#/{k}" if k < 11 else "s"))
        group["field"] = np.array([[below.ref] * 10], h5py.ref_dtype)
        below = group


def long_text(file: h5py.File) -> None:
    held = file.create_dataset("name", (1, 3_000_000_000), "u2", chunks=(1, 1_000_000))
    held.attrs["MATLAB_class"] = np.bytes_("char")


def packed_matlab(path: Path, size: int = 1 << 29) -> Path:
    """A file of version 5 whose only variable unpacks to `size` bytes."""
    packer, parts = zlib.compressobj(1), []
    numbers = (size - 64) // 8
    parts.append(packer.compress(struct.pack("<2I 4I 4I 2I 2I", 14, size - 8, 6, 8, 6, 0, 5, 8, numbers, 1,
                                             0x00010001, 0x76, 9, numbers * 8)))  # fmt: skip
    zeros = bytes(1 << 24)
    for _ in range(size >> 24):
        parts.append(packer.compress(zeros))
    parts.append(packer.flush())
    packed = b"".join(parts)
    head = b"A file of level 5".ljust(124) + b"\0\1IM"
    path.write_bytes(head + struct.pack("<2I", 15, len(packed)) + packed)
    return path


def many_columns(path: Path) -> Path:
    """A table with more columns than any log has."""
    path.write_text(",".join(f"c{k}" for k in range(30_000)) + "\n" + ",".join("1" * 30_000) + "\n")
    return path


def long_field(path: Path) -> Path:
    """A table with a quoted field that is longer than Python's reader takes."""
    path.write_text('time,v\n0,1\n1,2\n2,"' + "1" * 140_000 + '"\n')
    return path


def backwards(path: Path) -> Path:
    """A clock that runs backwards."""
    path.write_text("time [s],v\n" + "".join(f"{k * 1e-3:g},{k % 7}\n" for k in range(3000, 0, -1)))
    return path


def unsorted(path: Path) -> Path:
    """Times of edges in no order."""
    path.write_text("v [s]\n" + "".join(f"{x:.6f}\n" for x in np.random.default_rng(1).uniform(0, 10, 20_000)))
    return path


@cache
def _zeros(size: int) -> bytes:
    """Zeros, packed."""
    zeros, packer = bytes(1 << 24), zlib.compressobj(9)
    return b"".join([*(packer.compress(zeros) for _ in range(size >> 24)), packer.flush()])


# HDF5: datasets


def odd_kinds(file: h5py.File) -> None:
    """What is no plain number: text, objects, references, enumerations, opaque bytes, nested records."""
    file["other"] = np.array(["a", "b"], object)
    file.create_dataset("ragged", (2,), h5py.vlen_dtype(np.float64))
    file.create_dataset("reference", data=np.array([file.ref], h5py.ref_dtype))
    file.create_dataset("enum", (3,), h5py.enum_dtype({"off": 0, "on": 1}))
    file["opaque"] = np.array([b"12345678"], "V8")
    file["records"] = np.zeros(3, [("inner", [("x", "f8"), ("y", "f8")]), ("z", "f8", (2,)), ("n", "S4")])
    file["none"] = h5py.Empty("f8")
    file["long"], file["short"] = np.ones(1000, np.longdouble), np.ones(1000, np.float16)


def bad_names(file: h5py.File) -> None:
    """Names that are no UTF-8, hold escape sequences, or are longer than a screen."""
    for name in (b"other\xff\xfe", b"\x1b[2Jgone", b"x" * 60_000, b"a\nb\rc"):
        h5py.h5d.create(file.id, name, h5py.h5t.IEEE_F64LE, h5py.h5s.create_simple((5,)))


def odd_attributes(file: h5py.File) -> None:
    """A clock, a scale and a unit that are nonsense."""
    held = file.create_dataset("other", data=np.arange(1000.0))
    held.attrs.update({"dt": np.array([np.nan, 1.0]), "t0": "early", "sample_rate": "-1", "fs": np.float64(1e-320)})
    held.attrs.update({"units": np.arange(3), "scale_factor": "twice", "_FillValue": np.zeros(0)})


def cyclic_scale(file: h5py.File) -> None:
    """A time axis that points to nothing."""
    held = file.create_dataset("other", data=np.arange(1000.0))
    file["axis"] = np.arange(1000.0)
    file["axis"].make_scale("axis")
    held.dims[0].attach_scale(file["axis"])
    del file["axis"]


def unknown_filter(file: h5py.File) -> None:
    """Packed by a filter that nobody has."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((1000,))
    properties.set_filter(32_100, h5py.h5z.FLAG_OPTIONAL, (1, 2, 3))
    held = h5py.h5d.create(file.id, b"other", h5py.h5t.IEEE_F64LE, h5py.h5s.create_simple((1000,)), properties)
    held.write_direct_chunk((0,), bytes(50), filter_mask=0)


def lying_chunk(file: h5py.File) -> None:
    """A packed piece that holds less than it should, and one that holds far more."""
    for name, held in (("other", zlib.compress(b"too short")), ("more", _zeros(1 << 29))):
        dataset = file.create_dataset(name, (1000,), "f8", chunks=(1000,), compression="gzip")
        dataset.id.write_direct_chunk((0,), held)


def wide_giant(file: h5py.File) -> None:
    """A matrix with a billion rows and one with a billion columns, neither written."""
    file.create_dataset("other", (10**9, 50), "f8", chunks=(1000, 50))
    file.create_dataset("wide", (2, 10**9), "f8", chunks=(1, 1000))


def circle_of_soft_links(file: h5py.File) -> None:
    file["other"], file["back"] = h5py.SoftLink("/back"), h5py.SoftLink("/other")
    file["self"] = h5py.SoftLink("/self")


# MATLAB 5


def _element(kind: int, held: bytes) -> bytes:
    return struct.pack("<2I", kind, len(held)) + held + bytes(-len(held) % 8)


def _matrix(name: bytes, size: tuple[int, ...], kind: int, *parts: bytes) -> bytes:
    flags, dims = struct.pack("<2I", kind, 0), struct.pack(f"<{len(size)}i", *size)
    return _element(14, b"".join([_element(6, flags), _element(5, dims), _element(1, name), *parts]))


def _matlab5(path: Path, *variables: bytes) -> Path:
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"".join(variables))
    return path


def _vector(name: bytes, values: np.ndarray) -> bytes:
    return _matrix(name, (values.size, 1), 6, _element(9, values.tobytes()))


_SOUND = _vector(b"time", np.arange(1000) * 1e-3) + _vector(b"v", np.sin(np.arange(1000) * 0.1))


def nested_cells(path: Path) -> Path:
    """A cell in a cell, forty thousand times."""
    inner = _vector(b"", np.ones(2))
    about = _element(6, struct.pack("<2I", 1, 0)) + _element(5, struct.pack("<2i", 1, 1)) + _element(1, b"")
    heads = [struct.pack("<2I", 14, len(about) * (k + 1) + 8 * k + len(inner)) + about for k in range(40_000)]
    return _matlab5(path, _SOUND, b"".join(reversed(heads)) + inner)


def lying_sizes(path: Path) -> Path:
    """Sizes below zero, above what there is, and above what a number can hold."""
    bad = [(-5, 1), (2**31 - 1, 2**31 - 1), (10**6, 1), (0, -1), ()]
    return _matlab5(path, _SOUND, *(_matrix(b"v%d" % k, size, 6, _element(9, bytes(80))) for k, size in enumerate(bad)))


def lying_sparse(path: Path) -> Path:
    """A sparse matrix whose places lie far outside of it."""
    places = _element(5, struct.pack("<4i", -1, 2**31 - 1, 5, 7))
    return _matlab5(path, _SOUND, _matrix(b"s", (3, 3), 5, places, places, _element(9, bytes(32))))


def endless_variable(path: Path) -> Path:
    """A variable that says it is four gigabytes long, packed by nothing that unpacks."""
    return _matlab5(path, _SOUND, struct.pack("<2I", 15, 2**32 - 8) + b"no zlib" * 100)


def matlab4_giant(path: Path) -> Path:
    """A matrix of version 4 of 2^31 rows and as many columns, in thirty bytes."""
    path.write_bytes(struct.pack("<5i", 0, 2**31 - 1, 2**31 - 1, 0, 2) + b"v\0" + bytes(64))
    return path


# TDMS


def _tdms(
    path: Path, objects: bytes, number: int, *, raw: bytes = b"", after: int | None = None, times: int = 1
) -> Path:
    held = struct.pack("<I", number) + objects
    length = len(held) + len(raw) if after is None else after
    lead = b"TDSm" + struct.pack("<2I2Q", 0b1110, 4713, length, len(held))
    path.write_bytes((lead + held + raw) * times)
    return path


def _tdms_channel(name: bytes, samples: int, kind: int = 10, properties: int = 0) -> bytes:
    path = b"/'g'/'" + name + b"'"
    return (struct.pack("<I", len(path)) + path + struct.pack("<3IQ", 20, kind, 1, samples)
            + struct.pack("<I", properties))  # fmt: skip


def tdms_lying_count(path: Path) -> Path:
    """2^60 samples in eighty bytes."""
    return _tdms(path, _tdms_channel(b"v", 2**60), 1, raw=bytes(80))


def tdms_endless_objects(path: Path) -> Path:
    """Four billion channels, one of which is there; four billion properties, none of which is."""
    return _tdms(path, _tdms_channel(b"v", 10, properties=2**32 - 1), 2**32 - 1, raw=bytes(80))


def tdms_many_segments(path: Path) -> Path:
    """A hundred thousand segments without anything in them."""
    return _tdms(path, b"", 0, times=100_000)


def tdms_standing_still(path: Path) -> Path:
    """A segment that is followed by itself."""
    return _tdms(path, _tdms_channel(b"v", 10), 1, raw=bytes(80), after=2**64 - 28)


def tdms_odd_kinds(path: Path) -> Path:
    """A kind of number that does not exist, text that is longer than the file, and no samples at all."""
    objects = _tdms_channel(b"v", 10, 0x99) + _tdms_channel(b"w", 10, 0x20) + _tdms_channel(b"\xff\xfe", 0)
    return _tdms(path, objects, 3, raw=bytes(400))


# MDF


def _mdf(path: Path, compression: int = 0) -> bytearray:
    import asammdf

    times = np.arange(5000) * 1e-3
    with asammdf.MDF(version="3.30" if path.suffix == ".mdf" else "4.10") as file:
        file.append([asammdf.Signal(np.sin(100.0 * times), times, name="v")])
        file.save(path, overwrite=True, compression=compression)
    return bytearray(path.read_bytes())


def _mdf_links(*links: tuple[bytes, int]) -> Callable[[Path], Path]:
    """Writes a file in which some link of the first block of a kind leads back to that block."""

    def write(path: Path) -> Path:
        data = _mdf(path)
        for kind, which in links:
            place = data.index(kind, 64)
            at = place + 24 + 8 * which if kind[:2] == b"##" else place + 4 + 4 * which
            struct.pack_into("<Q" if kind[:2] == b"##" else "<I", data, at, place)
        path.write_bytes(data)
        return path

    write.__name__ = "mdf_circle_of_" + "_".join(f"{kind.strip(b'#')[:2].decode()}{which}" for kind, which in links)
    return write


def mdf_lying_count(path: Path) -> Path:
    """A group of 2^60 records."""
    data = _mdf(path)
    struct.pack_into("<Q", data, data.index(b"##CG", 64) + 24 + 6 * 8 + 8, 2**60)
    path.write_bytes(data)
    return path


def mdf_bomb(path: Path) -> Path:
    """A packed block of half a megabyte that says that it holds eighty thousand bytes and holds half a gigabyte."""
    data, packed = _mdf(path, 2), _zeros(1 << 29)
    place, end = data.index(b"##DZ", 64), len(data)
    block = bytearray(data[place : place + 48])
    struct.pack_into("<Q", block, 8, 48 + len(packed))
    struct.pack_into("<Q", block, 40, len(packed))
    end += -end % 8
    path.write_bytes(
        bytes(data).ljust(end, b"\0").replace(struct.pack("<Q", place), struct.pack("<Q", end)) + block + packed
    )
    return path


def mdf_bad_names(path: Path) -> Path:
    """Names and units with escape sequences and bytes that are no UTF-8."""
    import asammdf

    with asammdf.MDF() as file:
        file.append([asammdf.Signal(np.arange(9.0), np.arange(9.0), "NAME\x1b[2J", "vvvvvvvvvv")])
        file.save(path, overwrite=True)
    path.write_bytes(path.read_bytes().replace(b"vvvvvvvvvv", b"\xff\xfe\x1b[2J\xf0\x9f\0"))
    return path


# Parquet


def parquet_claims(path: Path) -> Path:
    """Forty million rows, all alike, in some kilobytes."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    column = pa.array(np.zeros(1_000_000), pa.float64())
    table = pa.table({"time": column, "v": column})
    with pq.ParquetWriter(path, table.schema, compression="zstd") as file:
        for _ in range(40):
            file.write_table(table)
    return path


def parquet_odd_kinds(path: Path) -> Path:
    """Lists, structs, maps, text and columns of one name."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = [
        pa.array([0.0, 1.0]),
        pa.array([[1.0], [2.0, 3.0]]),
        pa.array([{"a": 1}, {"a": 2}]),
        pa.array(["x", None]),
    ]
    arrays += [pa.array([1.0, 2.0]), pa.array([3.0, 4.0])]
    pq.write_table(pa.table(arrays, ["time", "list", "struct", "text", "v", "v"]), path)
    return path


def parquet_lying_foot(path: Path) -> Path:
    """A foot of four gigabytes."""
    path.write_bytes(b"PAR1" + bytes(100) + struct.pack("<I", 2**32 - 1) + b"PAR1")
    return path


def parquet_many_columns(path: Path) -> Path:
    """Eleven thousand columns."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({f"c{k}": [1.0] for k in range(11_000)}), path)
    return path


# Text


def _table(*rows: bytes) -> Callable[[Path], Path]:
    def write(path: Path) -> Path:
        path.write_bytes(b"time [s],v\n" + b"".join(b"%d,%d\n" % (k, k % 7) for k in range(400)) + b"\n".join(rows))
        return path

    return write


def endless_line(path: Path) -> Path:
    """A line of six megabytes after a sound beginning."""
    return _table(b"400," + b"1" * 6_000_000)(path)


def zeros_within(path: Path) -> Path:
    """NUL bytes in a number."""
    return _table(b"400,1\x002", b"401,\0", b"")(path)


def no_utf8(path: Path) -> Path:
    """Bytes that no encoding knows, and escape sequences, in place of a number."""
    return _table(b"400,\xff\xfe\x1b[2J", b"")(path)


def open_quotes(path: Path) -> Path:
    """A quote in every line that none closes."""
    return _table(*(b'%d,"1' % k for k in range(400, 5000)), b"")(path)


def giant_numbers(path: Path) -> Path:
    """Times and values beyond what a float holds, of a hundred thousand digits, and infinite."""
    return _table(
        b"4e2,1e999999999", b"1e308,-1e-999999999", b"1.7e308,2", b"inf,3", b"nan,4", b"1" * 100_000 + b",5", b""
    )(path)


def impossible_dates(path: Path) -> Path:
    """Years beyond the calendar of the machine."""
    rows = [f"{year:04d}-12-31T23:59:59.999999999,{year % 3}" for year in (1, 1677, 2024, 2262, 9999)]
    path.write_text("\n".join(["time,v", *rows]) + "\n")
    return path


def standing_clock(path: Path) -> Path:
    """A clock that never moves."""
    path.write_text("time [s],v\n" + "".join(f"5,{k % 7}\n" for k in range(3000)))
    return path


def nested_brackets(path: Path) -> Path:
    """A heading of a hundred thousand brackets, blanks and words."""
    path.write_text("time [s]," + "a ( [ " * 40_000 + "\n0,1\n1,2\n")
    return path


def wide_utf16(path: Path) -> Path:
    """UTF-16 without a mark at its beginning."""
    path.write_bytes("time,v\n0,1\n1,2\n".encode("utf-16-le"))
    return path


def _named(fill: Callable[[h5py.File], None], frame: Callable[..., Path]) -> Callable[[Path], Path]:
    def write(path: Path) -> Path:
        return frame(path, fill)

    write.__name__ = fill.__name__
    return write


HDF5 = [
    _named(fill, with_datasets)
    for fill in (to_parent, soft_to_root, nested, fans, external_storage, external_link, virtual, huge_chunk,
                 empty_giant, many, odd_kinds, bad_names, odd_attributes, cyclic_scale, unknown_filter, lying_chunk,
                 wide_giant, circle_of_soft_links)
]  # fmt: skip
MATLAB = [
    *(_named(fill, matlab) for fill in (of_itself, tree_of_structs, long_text)),
    packed_matlab, nested_cells, lying_sizes, lying_sparse, endless_variable, matlab4_giant,
]  # fmt: skip
TDMS = [tdms_lying_count, tdms_endless_objects, tdms_many_segments, tdms_standing_still, tdms_odd_kinds]
MDF4 = [
    *(_mdf_links((kind, 0)) for kind in (b"##DG", b"##CG", b"##CN")), _mdf_links((b"##CN", 1)), mdf_lying_count,
    mdf_bomb, mdf_bad_names,
]  # fmt: skip
MDF3 = [_mdf_links((b"DG\x1c\0", 0)), _mdf_links((b"CN\xe4\0", 0))]
PARQUET = [parquet_claims, parquet_odd_kinds, parquet_lying_foot, parquet_many_columns]
TEXT = [
    many_columns, long_field, backwards, endless_line, zeros_within, no_utf8, open_quotes, giant_numbers,
    impossible_dates, standing_clock, nested_brackets, wide_utf16,
]  # fmt: skip
ALL = {
    ".h5": HDF5, ".mat": MATLAB, ".tdms": TDMS, ".mf4": MDF4, ".mdf": MDF3, ".parquet": PARQUET, ".csv": TEXT,
}  # fmt: skip
