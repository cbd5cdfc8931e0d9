"""`vvdp export`."""

from pathlib import Path
from typing import Annotated

import typer

from vvdp.cli.options import AsJson, Verb

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

Csv = Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write a CSV file.")]
Parquet = Annotated[
    Path | None, typer.Option("--parquet", metavar="FILE", help="Write a Parquet file (needs the extra `data`).")
]


@app.callback()
def export() -> None:
    """Export results for other programs."""


@app.command("data", cls=Verb)
def data(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Result directory.")],
    csv: Csv = None,
    parquet: Parquet = None,
    table: Annotated[
        list[str] | None, typer.Option("--table", metavar="NAME", help="Export this table only (repeatable).")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False,
    json: AsJson = False,
) -> None:
    """Export the recorded series of a run, or the tables of any other result.

    All values are in SI; the name of each column ends with its unit. Several tables are written to one file each.
    """
    from vvdp.base.errors import unusable
    from vvdp.base.manifest import as_damaged
    from vvdp.cli.screen import print_json, tell
    from vvdp.export.data import export_tables, result_tables

    if csv is None and parquet is None:
        raise unusable("export data", "no file is given; expected --csv FILE or --parquet FILE")
    with as_damaged(directory):
        tables = result_tables(directory, tuple(table or ()))
    written: list[str] = []
    for path, as_parquet in ((csv, False), (parquet, True)):
        if path is not None:
            written += map(str, export_tables(tables, path, as_parquet=as_parquet, force=force))
    if json:
        print_json({"files": written})
    else:
        tell("\n".join(written))
