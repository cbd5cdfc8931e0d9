"""`vvdp design robust`: the front of mean loss against size over tolerances, temperature and duty."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from vvdp.cli.constraints import Constraints
from vvdp.cli.options import RigCase, Seed, flat, parsed_option
from vvdp.cli.printing import show_result, write_with_report
from vvdp.cli.rig import Resumed

INTERRUPTED = 130


@dataclass(frozen=True)
class Scenarios:
    """Options: in which oil temperatures and draws of the spreads each design is simulated."""

    spread: Annotated[
        list[str] | None,
        typer.Option("--spread", metavar="STATEMENT", help='For example "radial_clearance: 10 um to 16 um".'),
    ] = None
    coldest: Annotated[str, typer.Option("--from", metavar="TEMP", help="Coldest oil temperature.")] = "30 degC"
    hottest: Annotated[str, typer.Option("--to", metavar="TEMP", help="Hottest oil temperature.")] = "60 degC"
    draws: Annotated[int, typer.Option("--draws", metavar="N", min=1, help="Draws of all spreads.")] = 8


@dataclass(frozen=True)
class Search:
    """Options: how designs are searched for."""

    designs: Annotated[int, typer.Option("--designs", metavar="N", min=2, help="Designs in a generation.")] = 10
    generations: Annotated[int, typer.Option("--generations", metavar="N", min=1, help="Generations.")] = 6
    seed: Seed = 1


@flat("results/robust-SYSTEM")
def robust(
    *,
    case: RigCase,
    limits: Constraints,
    scenarios: Scenarios,
    search: Search,
    work: Resumed,
) -> None:
    """Find valves that lose little over tolerances and duty.

    Every design is simulated in every scenario; the front is mean loss against size. Rerun the same command to resume.
    """
    from vvdp.base.kinds import TEMPERATURE
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.design import robust as study
    from vvdp.design.robust_result import robust_result, write_front
    from vvdp.rigs.maps import STORE, map_directory
    from vvdp.studies.engine import ThisProcess
    from vvdp.systems.resolved import resolved_text

    loaded = case.on_rig("design robust")
    asked = study.robust_problem(loaded, limits.subject_to or (), limits.bound or ())
    effort = study.Effort(
        draws=scenarios.draws, designs=search.designs, generations=search.generations, seed=search.seed
    )
    ends = (
        parsed_option("--from", scenarios.coldest, TEMPERATURE),
        parsed_option("--to", scenarios.hottest, TEMPERATURE),
    )
    met, taken = study.scenarios(asked, limits.cycle, ends, scenarios.spread or (), effort)
    directory = work.out if work.out is not None else Path("results", f"robust-{loaded.name}")
    with map_directory(directory, "design robust", force=work.force):
        with count_lines("runs") as progress:
            runs = study.Runs(directory / STORE, ThisProcess(work.cores), progress, say)
            found = study.robust(asked, met, taken, effort, runs)
        write_front(directory, found)
        result = robust_result(found)
        reported = write_with_report(directory, result, resolved_text(loaded), no_report=work.no_report)
    show_result(result, directory, json=work.json, reported=reported, names=("front",))
    if not result.finished:
        say("interrupted; rerun the same command to resume")
        raise typer.Exit(INTERRUPTED)
