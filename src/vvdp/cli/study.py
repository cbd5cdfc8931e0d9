"""`vvdp study`."""

from pathlib import Path
from typing import Annotated

import typer

from vvdp.cli.engines import Resumable
from vvdp.cli.options import flat
from vvdp.cli.printing import show_result, write_with_report

INTERRUPTED = 130


@flat("results/FILE")
def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The study, a TOML file.")],
    work: Resumable,
) -> None:
    """Run many cases of a system; rerun to resume.

    Ctrl-C stops after the current batches. All columns are written to study.csv.
    """
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.studies.results import study_result
    from vvdp.studies.run import run_study
    from vvdp.studies.store import set_aside
    from vvdp.studies.study import load_study
    from vvdp.systems.resolved import resolved_text

    wanted = load_study(file)
    directory = work.directory(file.stem)
    engine = work.engine(directory)
    with set_aside(directory, force=work.force), count_lines("cases") as progress:
        results = run_study(wanted, directory, engine=engine, progress=progress, say=say)
    result = study_result(results)
    reported = write_with_report(directory, result, resolved_text(results.system), no_report=work.no_report)
    if not work.json:
        say(f"{results.ran} cases run in {results.seconds:.2f} s, {len(results.failures)} failed")
    show_result(result, directory, json=work.json, reported=reported)
    if not results.is_finished:
        say(f"interrupted with {len(results.missing)} cases to go; rerun the same command to resume")
        raise typer.Exit(INTERRUPTED)
