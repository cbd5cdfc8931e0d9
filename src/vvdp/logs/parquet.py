"""Parquet files, through pyarrow: every column of numbers is a channel, units from its metadata or its name."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vvdp.base.arrays import Array
from vvdp.logs.budget import reading
from vvdp.logs.clock import heading, seconds_between
from vvdp.logs.content import INSTANTS, Column, Content, Leaf, Names


def read_parquet(content: Content) -> None:
    """Finds what a Parquet file holds."""
    content.held = pq.ParquetFile(content.path, pre_buffer=False, buffer_size=1 << 20)
    columns = [_column(field) for field in content.held.schema_arrow]
    content.add_table(columns, content.held.metadata.num_rows, partial(_rows, content))


def _column(field: Any) -> Column:
    numbers = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, pa.types.is_decimal)
    fault = "" if any(is_one(field.type) for is_one in numbers) else "holds text"
    if pa.types.is_timestamp(field.type):
        fault = INSTANTS
    for key in (b"units", b"unit"):
        if field.metadata and key in field.metadata:
            return Column(field.name, field.metadata[key].decode("utf-8", "replace"), fault)
    return Column(*heading(field.name), fault)


def _rows(content: Content, leaves: Sequence[Leaf], samples: int) -> Iterator[tuple[Mapping[Names, Array], float]]:
    """One group of rows after the other: asked for all of them, pyarrow keeps what it has read."""
    file, read, origins = content.held, 0, dict[Names, Any]()
    names, numbers = file.schema_arrow.names, {leaf.path: content.columns.index(leaf.path) for leaf in leaves}
    wanted = list(dict.fromkeys(names[k] for k in numbers.values()))
    for group in range(file.num_row_groups):
        batches = file.iter_batches(batch_size=samples, row_groups=[group], columns=wanted)
        while True:
            with reading(content.path, f"row {read + 1}", content.library):
                if (batch := next(batches, None)) is None:
                    break
                arrays = {path: _array(_column_of(batch, names, k), path, origins) for path, k in numbers.items()}
            read += batch.num_rows
            yield arrays, read / file.metadata.num_rows


def _column_of(batch: Any, names: Sequence[str], k: int) -> Any:
    """Column `k` of the file: pyarrow reads all of one name."""
    return batch.column(batch.schema.get_all_field_indices(names[k])[names[:k].count(names[k])])


def _array(column: Any, path: Names, origins: dict[Names, Any]) -> Array:
    """A part of a column; date-times as seconds from its first one."""
    if pa.types.is_timestamp(column.type):
        instants = column.cast(pa.timestamp("ns")).to_numpy(zero_copy_only=False)
        known = instants[~np.isnat(instants)]
        if known.size:
            origins.setdefault(path, known[0])
        return seconds_between(instants, origins.get(path, np.datetime64(0, "ns")))
    if pa.types.is_boolean(column.type):
        column = column.cast(pa.uint8())
    if not pa.types.is_floating(column.type):
        column = column.cast(pa.float64(), safe=False)
    return np.asarray(column.to_numpy(zero_copy_only=False), float)
