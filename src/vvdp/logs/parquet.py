"""Parquet files, through pyarrow: every column of numbers is a channel, units from its metadata or its name."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.logs.channel import Log, unique
from vvdp.logs.clock import ClockChoice, heading, seconds_between
from vvdp.logs.table import Column, TableLog


def parquet_log(path: Path, choice: ClockChoice) -> Log:
    """The log in a Parquet file."""
    try:
        file = pq.ParquetFile(path, pre_buffer=False, buffer_size=1 << 20)
        fields = list(file.schema_arrow)
        rows = file.metadata.num_rows
    except (OSError, pa.ArrowException) as problem:
        raise unusable(path, f"cannot be read as Parquet, the file is damaged or cut off ({problem})") from None
    headings = [_heading(field) for field in fields]
    names = unique([name for name, _ in headings])
    columns = [
        Column(name, unit, _holds(field.type)) for name, (_, unit), field in zip(names, headings, fields, strict=True)
    ]
    return ParquetLog(path, columns, choice, rows, file)


def _heading(field: Any) -> tuple[str, str]:
    for key in (b"units", b"unit"):
        if field.metadata and key in field.metadata:
            return field.name, field.metadata[key].decode("utf-8", "replace")
    return heading(field.name)


def _holds(kind: Any) -> str:
    if pa.types.is_timestamp(kind):
        return "instant"
    numbers = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, pa.types.is_decimal)
    return "number" if any(is_one(kind) for is_one in numbers) else "text"


class ParquetLog(TableLog):
    """A Parquet file, one batch of rows at a time."""

    def __init__(self, path: Path, columns: Sequence[Column], choice: ClockChoice, rows: int, file: Any) -> None:
        super().__init__(path, columns, choice, rows, file)
        self._file = file

    def _rows(self, columns: Sequence[int], samples: int) -> Iterator[tuple[Mapping[int, Array], float]]:
        read, origins = 0, dict[int, Any]()
        try:
            for batch in self._batches(columns, samples):
                arrays = {k: self._array(batch.column(i), k, origins) for i, k in enumerate(columns)}
                read += batch.num_rows
                yield arrays, read / (self._count or 1)
        except (OSError, pa.ArrowException) as problem:
            raise unusable(self.path, f"row {read + 1}: cannot be read, the file is damaged ({problem})") from None

    def _batches(self, columns: Sequence[int], samples: int) -> Iterator[Any]:
        """One group of rows after the other: asked for all of them, pyarrow keeps what it has read."""
        names = [self._file.schema_arrow.field(k).name for k in columns]
        for group in range(self._file.num_row_groups):
            yield from self._file.iter_batches(batch_size=samples, row_groups=[group], columns=names)

    def _array(self, column: Any, k: int, origins: dict[int, Any]) -> Array:
        if self._columns[k].holds == "instant":
            instants = column.cast(pa.timestamp("ns")).to_numpy(zero_copy_only=False)
            known = instants[~np.isnat(instants)]
            if known.size:
                origins.setdefault(k, known[0])
            return seconds_between(instants, origins.get(k, np.datetime64(0, "ns")))
        if not pa.types.is_floating(column.type):
            column = (
                column.cast(pa.float64(), safe=False)
                if not pa.types.is_boolean(column.type)
                else column.cast(pa.uint8())
            )
        return np.asarray(column.to_numpy(zero_copy_only=False), float)
