"""Small logs in all formats, what chance makes of them, and files that were made to do harm."""

import itertools
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
from tests.logs.test_readers import (
    write_csv,
    write_hdf5,
    write_mat,
    write_mat73,
    write_mdf,
    write_packed_mdf,
    write_parquet,
    write_semicolons,
    write_tdms,
)

WRITERS = (
    ("a.csv", write_csv), ("a.csv", write_semicolons), ("a.tdms", write_tdms), ("a.mf4", write_mdf),
    ("b.mf4", write_packed_mdf), ("a.h5", write_hdf5), ("a.parquet", write_parquet), ("a.mat", write_mat),
    ("b.mat", write_mat73),
)  # fmt: skip
SAMPLES = 1500


def write_log(writer: int, folder: Path) -> Path:
    """A second and a half of a wheel that turns 6 times a second, as wave and as counter."""
    name, write = WRITERS[writer % len(WRITERS)]
    times = np.arange(SAMPLES) * 1e-3
    phase = 2.0 * np.pi * 24.0 * times
    write(folder / name, times, {"v": 2.5 + 2.0 * np.tanh(5.0 * np.sin(phase)), "w": np.floor(phase / np.pi)})
    return folder / name


def mutate(content: bytes, random: np.random.Generator) -> bytes:
    """The bytes after one to four accidents."""
    data = bytearray(content)
    for _ in range(int(random.integers(1, 5))):
        at, length = int(random.integers(len(data))), int(2 ** random.uniform(0, 9))
        piece = data[at : at + length]
        match int(random.integers(7)):
            case 0:
                data[at : at + length] = random.bytes(len(piece))
            case 1:
                data[at] ^= 1 << int(random.integers(8))
            case 2:
                del data[at : at + length]
            case 3:
                data[at:at] = piece
            case 4:
                data[at : at + length] = bytes(len(piece))
            case 5:
                del data[max(at, 64) :]
            case 6:
                data[at : at + 8] = random.choice([b"\xff" * 8, struct.pack("<q", 2**40), struct.pack("<d", 1e300)])
    return bytes(data)


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


HDF5 = (to_parent, soft_to_root, nested, fans, external_storage, external_link, virtual, huge_chunk, empty_giant, many)


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


MATLAB = (of_itself, tree_of_structs, long_text)


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
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"
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


TEXT = (many_columns, long_field, backwards)
