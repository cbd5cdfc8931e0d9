"""`vvdp cfd`."""

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from vvdp.cli.options import AsJson, Cores, NoReport, Restart, Settings, SystemName, Verb, out_option, parsed_option
from vvdp.cli.printing import show_result

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.solve import Progress
    from vvdp.systems.system import System

T = TypeVar("T")

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def cfd() -> None:
    """Compute the flow through the valve with OpenFOAM."""


@app.command(cls=Verb)
def rail(
    system: SystemName,
    grid: Annotated[
        str, typer.Option("--grid", metavar="GRID", help="One of coarse, medium, fine, each 1.4 times as fine.")
    ] = "coarse",
    flow: Annotated[str, typer.Option("--flow", metavar="FLOW", help="Flow (default: that of the pump).")] = "",
    model: Annotated[
        str, typer.Option("--turbulence", metavar="MODEL", help="One of k-epsilon, realizable, sst, laminar.")
    ] = "k-epsilon",
    shape: Annotated[
        str | None,
        typer.Option(
            "--shape",
            metavar="NAME|FILE",
            help="A shipped shape (rail-a to rail-d, rail-final), or a TOML file with a table [geometry].",
        ),
    ] = None,
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-rail-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute drop and flow split of the inlet rail.

    The rail is meshed from the valve's shape and solved to a steady flow. Rerun the same command to resume; what is
    finished is not computed again.
    """
    from vvdp.base.extras import require_solids

    require_solids()
    from vvdp.cfd.rail_result import VERB, rail_result
    from vvdp.cfd.rail_study import make_place, run_rail
    from vvdp.cli.report import CFD, add_report
    from vvdp.cli.screen import say
    from vvdp.results.store import write_result
    from vvdp.studies.engine import all_cores
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    own = [text for text in settings or () if text.strip().startswith("geometry.")]
    loaded = load_system(system, [text for text in settings or () if text not in own])
    order, told = _order(loaded, (shape, own), grid, flow, model)
    directory = out if out is not None else Path("results", f"cfd-rail-{loaded.name}-{grid}")
    make_place(directory, VERB, force=force)
    try:
        with _progress() as hear:
            run = run_rail(order, directory, cores or all_cores(), hear)
    except KeyboardInterrupt:
        say("interrupted; rerun the same command to resume")
        raise
    result = rail_result(order, run, told)
    write_result(directory, result, resolved_text(loaded), ("vvdp", *sys.argv[1:]))
    reported = not no_report and add_report(CFD, directory)
    show_result(result, directory, json=json, reported=reported, names=("found", "flow"))


def _order(
    loaded: "System", shaped: tuple[str | None, list[str]], grid: str, flow: str, model: str
) -> "tuple[RailOrder, Told]":
    """What is to be computed, and what is said of it. `shaped` names a shape, and settings of it."""
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.case import Fluid
    from vvdp.cfd.rail import GRIDS, RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.turbulence import MODELS
    from vvdp.fluid.oil import density, dynamic_viscosity
    from vvdp.geometry.shape_tables import given_shape
    from vvdp.rigs.conditions import fluid
    from vvdp.steady.test_stand import stand

    held = stand(loaded, "cfd")
    oil, temperature, valve = held.bench.oil, held.set_point.oil_temperature, held.bench.valve
    made, rows = given_shape(valve, *shaped, loaded.lengths)
    order = RailOrder(
        valve=valve,
        shape=made,
        fluid=Fluid(float(density(temperature, oil)), float(dynamic_viscosity(temperature, oil))),
        flow=parsed_option("--flow", flow, FLOW) if flow else held.pump_flow(held.set_point),
        grid=_choice("--grid", grid, GRIDS),
        turbulence=_choice("--turbulence", model, MODELS),
    )
    return order, Told(loaded.name, grid, fluid(held), rows)


def _choice(option: str, name: str, known: "Mapping[str, T]") -> "T":
    """What an option names. Raises ConfigError where it is none of those that are known."""
    from vvdp.base.errors import ConfigError, Fault

    if name not in known:
        raise ConfigError([Fault(option, 0, "", f"{name!r}; expected one of {', '.join(known)}")])
    return known[name]


@contextmanager
def _progress() -> "Iterator[Callable[[Progress], None]]":
    """What is told how far a run is: a bar on a terminal, now and then a line elsewhere."""
    from vvdp.cli.progress import report_reach
    from vvdp.cli.screen import say

    with ExitStack() as stack:
        state: dict[str, Any] = {}

        def hear(now: "Progress") -> None:
            state["now"] = now
            if now.judgement is None:
                say(f"mesh: {now.words}")
                return
            if "reach" not in state:
                state["reach"] = stack.enter_context(report_reach(now.most, lambda done: _words(state["now"])))
            state["reach"](now.done)

        yield hear


def _words(now: "Progress") -> str:
    """How a run stands, in words."""
    from vvdp.base.display import percent, with_unit
    from vvdp.base.kinds import SIGNED_PRESSURE

    if now.judgement is None:
        return now.words
    found = now.judgement
    change = f", its mean moves by {percent(found.change, 2)}" if found.change < 1.0 else ""
    drop, balance = with_unit(found.value, SIGNED_PRESSURE), percent(found.imbalance, 3)
    return f"{now.words}: iteration {found.iteration}, {drop}{change}, balance {balance}"
