"""Small logs in all formats, and what chance makes of them."""

import struct
from pathlib import Path

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
        data = data or bytearray(1)
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
