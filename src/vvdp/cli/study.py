"""`vvdp study`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.engines import HERE, Cores, On, Sbatch, Workers, chosen_engine
from vvdp.cli.options import AsJson, Restart, out_option

if TYPE_CHECKING:
    from vvdp.studies.results import StudyResults

INTERRUPTED = 130


def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The study, a TOML file.")],
    out: Annotated[Path | None, out_option("results/FILE")] = None,
    on: On = HERE,
    workers: Workers = None,
    cores: Cores = None,
    sbatch: Sbatch = None,
    force: Restart = False,
    json: AsJson = False,
) -> None:
    """Run many cases of a system; rerun to resume.

    Ctrl-C stops after the current batches. All columns are written to study.csv.
    """
    from vvdp.cli.progress import counted
    from vvdp.cli.screen import print_json, say, warn
    from vvdp.studies.run import run_study
    from vvdp.studies.store import set_aside
    from vvdp.studies.study import load_study

    wanted = load_study(file)
    directory = out if out is not None else Path("results", file.stem)
    engine = chosen_engine(on, workers, cores, sbatch, directory)
    with set_aside(directory, force=force), counted("cases") as progress:
        results = run_study(wanted, directory, engine=engine, progress=progress, say=say)
    results.write_csv(directory / "study.csv")
    if json:
        columns = {**results.inputs, **results.outputs}
        print_json({name: column.values.tolist() for name, column in columns.items()} | {"out": str(directory)})
    else:
        _print(results)
        for failure in results.failures:
            warn(f"case {failure.case} failed: {failure.reason}")
        typer.echo(f"results: {directory / 'study.csv'}")
    if not results.finished:
        say(f"interrupted with {len(results.missing)} cases to go; the same command goes on from here")
        raise typer.Exit(INTERRUPTED)


def _print(results: "StudyResults") -> None:
    """Extremes of every column: what a person looks at before opening the table."""
    import numpy as np

    from vvdp.cli.screen import console, grid

    table = grid("quantity", "lowest", "highest", "mean", "unit", right=("lowest", "highest", "mean"))
    for name, column in {**results.inputs, **results.outputs}.items():
        if column.values.dtype.kind != "f":
            table.add_row(name, f"{len(set(column.values.tolist()))} different", "", "", "")
            continue
        values = column.values.astype(float)
        known = values[np.isfinite(values)]
        low, high, mean = (f"{f(known):.5g}" if known.size else "-" for f in (np.min, np.max, np.mean))
        table.add_row(name, low, high, mean, column.unit)
    console().print(table)
    typer.echo(f"{results.ran} cases run in {results.seconds:.2f} s, {len(results.failures)} failed")
