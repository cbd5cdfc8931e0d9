"""`vvdp cfd`."""

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer

from vvdp.cli.options import AsJson, Cores, NoReport, Restart, Settings, SystemName, Verb, out_option, parsed_option
from vvdp.cli.printing import show_result

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.solve import Progress
    from vvdp.results.result import Result
    from vvdp.systems.system import System

T = TypeVar("T")
LEAST_FLOWS = 3

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def cfd() -> None:
    """Compute the flow through the valve with OpenFOAM."""


Grid = Annotated[
    str, typer.Option("--grid", metavar="GRID", help="One of coarse, medium, fine, each 1.4 times as fine.")
]
Model = Annotated[
    str, typer.Option("--turbulence", metavar="MODEL", help="One of k-epsilon, realizable, sst, laminar.")
]
Shape = Annotated[
    str | None,
    typer.Option(
        "--shape",
        metavar="NAME|FILE",
        help="A shipped shape (rail-a to rail-d, rail-final), or a TOML file with a table [geometry].",
    ),
]


@app.command(cls=Verb)
def rail(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Annotated[str, typer.Option("--flow", metavar="FLOW", help="Flow (default: that of the pump).")] = "",
    model: Model = "k-epsilon",
    shape: Shape = None,
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
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.rail_result import VERB, rail_result
    from vvdp.cfd.rail_study import run_rail

    loaded, order, told = _order(system, settings, shape, grid, model)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    with _place(VERB, out, f"rail-{loaded.name}-{grid}", force=force) as (directory, hear):
        run = run_rail(order, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, rail_result(order, run, told), no_report=no_report)
    show_result(reported.result, directory, json=json, reported=reported.page, names=("found", "flow"))


@app.command(cls=Verb)
def sweep(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Annotated[
        tuple[str, str, int] | None,
        typer.Option(
            "--flow", metavar="FROM TO COUNT", help="Flows, 3 or more (default: 4, to 1.5 times that of the pump)."
        ),
    ] = None,
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-sweep-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Fit laws to the drop of the inlet rail over the flow.

    One mesh is solved at every flow. The file fitted.toml is the system with the discharge coefficient that was found.
    Rerun the same command to resume; what is finished is not computed again.
    """
    from vvdp.base.files import write_whole
    from vvdp.cfd.rail_study import run_sweep
    from vvdp.cfd.sweep_result import VERB, fitted_setting, sweep_result
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    loaded, order, told = _order(system, settings, shape, grid, model)
    flows = _flows(flow, order.flow)
    with _place(VERB, out, f"sweep-{loaded.name}-{grid}", force=force) as (directory, hear):
        runs = run_sweep(order, flows, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, sweep_result(order, runs, told), no_report=no_report)
    kept = [text for text in settings or () if not text.strip().startswith("geometry.")]
    fitted = load_system(system, [*kept, fitted_setting(reported.result)])
    write_whole(directory / "fitted.toml", resolved_text(fitted))
    show_result(reported.result, directory, json=json, reported=reported.page, names=("fits", "sweep"))


class _Reported(NamedTuple):
    """A result that was written, and whether its page is there."""

    result: "Result"
    page: bool


def _write(directory: Path, loaded: "System", result: "Result", *, no_report: bool) -> _Reported:
    from vvdp.cli.report import CFD, add_report
    from vvdp.results.store import write_result
    from vvdp.systems.resolved import resolved_text

    write_result(directory, result, resolved_text(loaded), ("vvdp", *sys.argv[1:]))
    return _Reported(result, not no_report and add_report(CFD, directory))


@contextmanager
def _place(
    verb: str, out: Path | None, name: str, *, force: bool
) -> "Iterator[tuple[Path, Callable[[Progress], None]]]":
    """The directory of a run, and what hears how far it is."""
    from vvdp.cfd.series import make_place
    from vvdp.cli.screen import say

    directory = out if out is not None else Path("results", f"cfd-{name}")
    make_place(directory, verb, force=force)
    try:
        with _progress() as hear:
            yield directory, hear
    except KeyboardInterrupt:
        say("interrupted; rerun the same command to resume")
        raise


def _all_cores() -> int:
    from vvdp.studies.engine import all_cores

    return all_cores()


def _flows(given: tuple[str, str, int] | None, usual: float) -> tuple[float, ...]:
    """Evenly spaced flows [m^3/s], by default up to one and a half times the `usual` one."""
    import numpy as np

    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.kinds import FLOW

    if given is None:
        return tuple(float(share * usual) for share in (0.25, 0.5, 1.0, 1.5))
    low, high = (parsed_option("--flow", text, FLOW) for text in given[:2])
    if not (0.0 < low < high and given[2] >= LEAST_FLOWS):
        words = f"expected two flows above zero, the lower first, and at least {LEAST_FLOWS} of them"
        raise ConfigError([Fault("--flow", 0, " ".join(map(str, given)), words)])
    return tuple(float(flow) for flow in np.linspace(low, high, given[2]))


def _order(
    system: str, settings: list[str] | None, shape: str | None, grid: str, model: str
) -> "tuple[System, RailOrder, Told]":
    """A system, what is to be computed of it at the flow of its pump, and what is said of it."""
    from vvdp.base.extras import require_solids

    require_solids()
    from vvdp.cfd.case import Fluid
    from vvdp.cfd.rail import GRIDS, RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.turbulence import MODELS
    from vvdp.fluid.oil import density, dynamic_viscosity
    from vvdp.geometry.shape_tables import given_shape
    from vvdp.rigs.conditions import fluid
    from vvdp.steady.test_stand import stand
    from vvdp.systems.system import load_system

    own = [text for text in settings or () if text.strip().startswith("geometry.")]
    loaded = load_system(system, [text for text in settings or () if text not in own])
    held = stand(loaded, "cfd")
    oil, temperature, valve = held.bench.oil, held.set_point.oil_temperature, held.bench.valve
    made, rows = given_shape(valve, shape, own, loaded.lengths)
    order = RailOrder(
        valve=valve,
        shape=made,
        fluid=Fluid(float(density(temperature, oil)), float(dynamic_viscosity(temperature, oil))),
        flow=held.pump_flow(held.set_point),
        grid=_choice("--grid", grid, GRIDS),
        turbulence=_choice("--turbulence", model, MODELS),
    )
    return loaded, order, Told(loaded.name, grid, fluid(held), rows)


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
