"""The tables of a result directory as CSV or Parquet."""

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.base.extras import require
from vvdp.base.files import write_whole
from vvdp.base.tables import nearest
from vvdp.results.result import Table
from vvdp.results.store import is_result, read_result, table_text
from vvdp.runs.tables import record_table
from vvdp.simulation.results import read_results


def result_tables(directory: Path, names: tuple[str, ...] = ()) -> Mapping[str, Table]:
    """The tables of a result; of a run, all that it recorded. `names` choose some, all without.

    Raises ConfigError where `directory` holds no result, or it has no table of such a name, or none at all.
    """
    if is_result(directory):
        found = read_result(directory).tables
    else:
        found = {"record": record_table(read_results(directory).record)}
    if not found:
        raise unusable(directory, "its result has no table")
    if faults := [Fault("--table", 0, name, f"unknown{nearest(name, found)}") for name in names if name not in found]:
        raise ConfigError(faults)
    return {name: found[name] for name in names or found}


def export_tables(tables: Mapping[str, Table], path: Path, *, as_parquet: bool, force: bool = False) -> list[Path]:
    """Writes tables, one into `path`, several into files beside it with their names, and gives the paths.

    Raises ConfigError, before any is written, where a file is there already (without `force`); MissingExtraError where
    Parquet is asked for without pyarrow.
    """
    if as_parquet:
        require("pyarrow", "data", "a Parquet file")
    files = {path if len(tables) == 1 else path.with_stem(f"{path.stem}-{name}"): t for name, t in tables.items()}
    for each in files:
        if each.is_dir():
            raise unusable(each, "is a directory; expected a file to write to")
        if each.exists() and not force:
            raise unusable(each, "already exists; choose another name or use --force")
    for each, table in files.items():
        write_whole(each, parquet_bytes(table) if as_parquet else table_text(table))
    return list(files)


def parquet_bytes(table: Table) -> bytes:
    """A table as a Parquet file; each column has its label, kind and SI unit as metadata."""
    import pyarrow as pa
    from pyarrow import parquet

    fields, arrays = [], []
    for key, column in table.columns.items():
        metadata = {"label": column.label}
        if column.kind is not None:
            metadata |= {"unit": column.kind.unit, "kind": column.kind.name}
        array = pa.array(np.asarray(column.values).tolist() if column.kind is None else column.values)
        fields.append(pa.field(key, array.type, metadata=metadata))
        arrays.append(array)
    content = io.BytesIO()
    parquet.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), content)
    return content.getvalue()
