"""`vvdp cfd`."""

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer

from vvdp.cli.options import AsJson, Cores, NoReport, Restart, Settings, SystemName, Verb, out_option, parsed_option
from vvdp.cli.printing import show_result

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vvdp.base.kinds import Kind
    from vvdp.cfd.centre import CentreOrder
    from vvdp.cfd.grids_result import OnGrids
    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.solve import Progress
    from vvdp.cfd.turbine import TurbineOrder
    from vvdp.results.result import Result
    from vvdp.systems.system import System

T = TypeVar("T")
USUAL_SHARES = (0.25, 0.5, 1.0, 1.5)
"""Of the pump's flow."""
LEAST_RUNS, LEAST_FLOW = 3, 1e-6
"""Runs to which a law with its confidence can be fitted, and a flow [m^3/s] that is worth a run."""

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


Flows = Annotated[
    tuple[str, str, int] | None,
    typer.Option(
        "--flow", metavar="FROM TO COUNT", help="Flows, 3 or more (default: 4, to 1.5 times that of the pump)."
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
    from vvdp.cfd.rail_study import run_rails

    loaded, order, told = _order(system, settings, shape, grid, model)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    with _place(VERB, out, f"rail-{loaded.name}-{grid}", force=force) as (directory, hear):
        (run,) = run_rails({"": order}, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, rail_result(order, run, told), no_report=no_report)
    show_result(reported.result, directory, json=json, reported=reported.page, names=("found", "flow"))


@app.command(cls=Verb)
def sweep(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Flows = None,
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
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.rail_study import run_rails
    from vvdp.cfd.sweep_result import VERB, fitted_settings, sweep_result

    loaded, order, told = _order(system, settings, shape, grid, model)
    flows = _stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * order.flow for share in USUAL_SHARES)
    with _place(VERB, out, f"sweep-{loaded.name}-{grid}", force=force) as (directory, hear):
        orders = {with_unit(each, FLOW): order._replace(flow=each) for each in flows}
        runs = run_rails(orders, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, sweep_result(order, runs, told), no_report=no_report)
    _write_fitted(directory, system, [*(settings or ()), *fitted_settings(reported.result)])
    show_result(reported.result, directory, json=json, reported=reported.page, names=("fits", "sweep"))


class Part(StrEnum):
    """A part of the valve that is computed by itself."""

    RAIL = "rail"
    CENTRE = "centre"
    TURBINE = "turbine"


@app.command(cls=Verb)
def grids(
    system: SystemName,
    part: Annotated[Part, typer.Option("--part", help="Part of the valve.")] = Part.RAIL,
    grid: Annotated[
        str, typer.Option("--grid", metavar="GRID", help="The finest of the three, each 1.4 times as fine.")
    ] = "fine",
    flow: Annotated[str, typer.Option("--flow", metavar="FLOW", help="Flow (default: that of the pump).")] = "",
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-grids-SYSTEM")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute a part of the valve on three grids and tell how far the drop is off.

    Observed order, extrapolation and grid convergence index. With another finest grid, those below it are coarser
    still. Rerun the same command to resume; what is finished is not
    computed again.
    """
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.grids_result import VERB, grids_result
    from vvdp.cfd.rail import three_grids

    loaded, order, about = _order(system, settings, shape, grid, model)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    orders = {name: order._replace(grid=cells) for name, cells in three_grids(order.grid).items()}
    with _place(VERB, out, f"grids-{loaded.name}", force=force) as (directory, hear):
        found = _on_grids(part, orders, about, (directory, cores or _all_cores(), hear))
    reported = _write(directory, loaded, grids_result(order, found, tuple(orders), about), no_report=no_report)
    show_result(reported.result, directory, json=json, reported=reported.page, names=("convergence", "grids"))


def _on_grids(
    part: Part,
    orders: "Mapping[str, RailOrder]",
    about: "Told",
    place: "tuple[Path, int, Callable[[Progress], None]]",
) -> "OnGrids":
    from vvdp.cfd.centre_study import run_centre
    from vvdp.cfd.grids_result import centre_on_grids, rail_on_grids, turbine_on_grids
    from vvdp.cfd.rail_study import run_rails
    from vvdp.cfd.turbine_study import run_turbine

    match part:
        case Part.RAIL:
            return rail_on_grids(run_rails(orders, *place), about)
        case Part.CENTRE:
            found = {name: _centre_order(order, 0.0) for name, order in orders.items()}
            return centre_on_grids(run_centre(found, *place), about)
        case Part.TURBINE:
            still = {name: _turbine_order(order) for name, order in orders.items()}
            return turbine_on_grids(run_turbine(still, *place), about)


@app.command(cls=Verb)
def designs(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Annotated[str, typer.Option("--flow", metavar="FLOW", help="Flow (default: that of the pump).")] = "",
    shape: Annotated[
        list[str] | None,
        typer.Option("--shape", metavar="NAME|FILE", help="Shapes, two or more (default: the five published)."),
    ] = None,
    model: Model = "k-epsilon",
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-designs-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute several shapes of the inlet rail side by side.

    Drop, flow split and radial force of each. Rerun the same command to resume; what is finished is not computed
    again.
    """
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.designs_result import VERB, designs_result
    from vvdp.cfd.rail_study import run_rails

    names = _shapes(shape)
    found = {name: _order(system, settings, name, grid, model) for name in names}
    loaded, first, told = found[names[0]]
    rate = parsed_option("--flow", flow, FLOW) if flow else first.flow
    orders = {name: order._replace(flow=rate) for name, (_, order, _) in found.items()}
    with _place(VERB, out, f"designs-{loaded.name}-{grid}", force=force) as (directory, hear):
        runs = run_rails(orders, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, designs_result(orders, runs, told), no_report=no_report)
    show_result(reported.result, directory, json=json, reported=reported.page, names=("designs",))


def _shapes(given: list[str] | None) -> tuple[str, ...]:
    """The shapes to be compared. Raises ConfigError where that is one alone."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.geometry.shape_tables import shipped_shapes

    names = tuple(dict.fromkeys(given or (name for name in shipped_shapes() if name.startswith("rail-"))))
    if len(names) < 2:
        raise ConfigError([Fault("--shape", 0, ", ".join(names), "expected two or more different shapes")])
    return names


@app.command(cls=Verb)
def centre(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Flows = None,
    angle: Annotated[
        str, typer.Option("--angle", metavar="ANGLE", help="Spool angle; at 0 the nozzles are open.")
    ] = "0 deg",
    diameter: Annotated[
        list[str] | None,
        typer.Option("--diameter", metavar="D", help="Spool diameters, lengths along it as they are (repeatable)."),
    ] = None,
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-centre-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Fit laws to the drop of the centre section over the flow.

    One mesh of each diameter is solved at every flow, the spool at rest half-way along its stroke. The file fitted.toml
    is the system with the exponents and the coefficient that were found. Rerun the same command to resume; what is
    finished is not computed again.
    """
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import ANGLE, FLOW, LENGTH
    from vvdp.cfd.centre import scale_radially
    from vvdp.cfd.centre_result import VERB, centre_result, fitted_settings
    from vvdp.cfd.centre_study import run_centre

    loaded, rail, told = _order(system, settings, shape, grid, model)
    order = _centre_order(rail, parsed_option("--angle", angle, ANGLE))
    flows = _stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * rail.flow for share in USUAL_SHARES)
    diameters = [parsed_option("--diameter", text, LENGTH) for text in diameter or ()]
    wide = [scale_radially(order, each) for each in diameters] or [order]
    orders = {
        f"{with_unit(2.0 * each.valve.spool_radius, LENGTH)}, {with_unit(rate, FLOW)}": each._replace(flow=rate)
        for each in wide
        for rate in flows
    }
    with _place(VERB, out, f"centre-{loaded.name}-{grid}", force=force) as (directory, hear):
        runs = run_centre(orders, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, centre_result(runs, told), no_report=no_report)
    _write_fitted(directory, system, [*(settings or ()), *fitted_settings(reported.result)])
    show_result(reported.result, directory, json=json, reported=reported.page, names=("fits", "runs"))


@app.command(cls=Verb)
def openings(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Annotated[str, typer.Option("--flow", metavar="FLOW", help="Flow (default: that of the pump).")] = "",
    angle: Annotated[
        list[str] | None,
        typer.Option("--angle", metavar="ANGLE", help="Spool angle, two or more (default: 16.5 deg and 21 deg)."),
    ] = None,
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-openings-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute effective area and torque of partly open nozzles.

    The centre section is solved with open nozzles and, at each angle, with nozzles that close and that open; the spool
    stands still. Rerun the same command to resume; what is finished is not computed again.
    """
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import ANGLE, FLOW
    from vvdp.cfd.centre_study import run_centre
    from vvdp.cfd.openings_result import VERB, both_ways, openings_result

    loaded, rail, told = _order(system, settings, shape, grid, model)
    order = _centre_order(rail, 0.0)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    angles = both_ways(_two_or_more("--angle", angle or ["16.5 deg", "21 deg"], ANGLE))
    with _place(VERB, out, f"openings-{loaded.name}-{grid}", force=force) as (directory, hear):
        orders = {with_unit(each, ANGLE): order._replace(angle=each) for each in angles}
        runs = run_centre(orders, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, openings_result(runs, told), no_report=no_report)
    show_result(reported.result, directory, json=json, reported=reported.page, names=("fits", "angles"))


def _two_or_more(option: str, given: list[str], kind: "Kind") -> list[float]:
    """Values of an option above zero. Raises ConfigError where there are too few for a law."""
    from vvdp.base.errors import ConfigError, Fault

    found = sorted({parsed_option(option, text, kind) for text in given})
    if len(found) < 2 or not found[0] > 0.0:
        raise ConfigError([Fault(option, 0, ", ".join(given), "expected two or more different values above zero")])
    return found


def _centre_order(rail: "RailOrder", angle: float) -> "CentreOrder":
    """The centre section to a rail, the spool half-way along its stroke."""
    from vvdp.cfd.centre import CentreOrder

    return CentreOrder(
        valve=rail.valve,
        shape=rail.shape,
        fluid=rail.fluid,
        flow=rail.flow,
        angle=angle,
        position=0.5 * rail.valve.helix_length,
        grid=rail.grid,
        turbulence=rail.turbulence,
    )


@app.command(cls=Verb)
def turbine(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Annotated[
        list[str] | None,
        typer.Option("--flow", metavar="FLOW", help="Flow (repeatable; default: that of the pump)."),
    ] = None,
    speed: Annotated[
        tuple[str, str, int],
        typer.Option("--speed", metavar="FROM TO COUNT", help="Spool speeds, 3 or more."),
    ] = ("0 rpm", "1500 rpm", 3),
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    out: Annotated[Path | None, out_option("results/cfd-turbine-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute torque and drop of the outlet turbine over the speed.

    One mesh is solved at every flow and speed, in the frame of the spool. The file fitted.toml is the system with the
    effective area, the discharge coefficient and the drop of the outlet rail that were found. Rerun the same command to
    resume; what is finished is not computed again.
    """
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import FLOW, SPEED
    from vvdp.cfd.turbine_result import VERB, fitted_settings, turbine_result
    from vvdp.cfd.turbine_study import run_turbine

    loaded, rail, told = _order(system, settings, shape, grid, model)
    order = _turbine_order(rail)
    flows = [parsed_option("--flow", text, FLOW) for text in flow or ()] or [rail.flow]
    speeds = _stretch("--speed", speed, SPEED, 0.0)
    orders = {
        f"{with_unit(rate, FLOW)}, {with_unit(each, SPEED)}": order._replace(flow=rate, speed=each)
        for rate in flows
        for each in speeds
    }
    with _place(VERB, out, f"turbine-{loaded.name}-{grid}", force=force) as (directory, hear):
        runs = run_turbine(orders, directory, cores or _all_cores(), hear)
    reported = _write(directory, loaded, turbine_result(runs, told), no_report=no_report)
    _write_fitted(directory, system, [*(settings or ()), *fitted_settings(reported.result)])
    show_result(reported.result, directory, json=json, reported=reported.page, names=("fits", "runs"))


def _turbine_order(rail: "RailOrder") -> "TurbineOrder":
    """The outlet turbine to a rail, the spool at rest half-way along its stroke."""
    from vvdp.cfd.turbine import TurbineOrder

    return TurbineOrder(
        valve=rail.valve,
        shape=rail.shape,
        fluid=rail.fluid,
        flow=rail.flow,
        speed=0.0,
        position=0.5 * rail.valve.helix_length,
        grid=rail.grid,
        turbulence=rail.turbulence,
    )


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


def _write_fitted(directory: Path, system: str, settings: list[str]) -> None:
    """Writes the system with what was found."""
    from vvdp.base.files import write_whole
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    kept = [text for text in settings if not text.strip().startswith("geometry.")]
    write_whole(directory / "fitted.toml", resolved_text(load_system(system, kept)))


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


def _stretch(option: str, given: tuple[str, str, int], kind: "Kind", least: float) -> tuple[float, ...]:
    """Evenly spaced values of an option. Raises ConfigError where they are too few for a law, or out of order."""
    import numpy as np

    from vvdp.base.display import with_unit
    from vvdp.base.errors import ConfigError, Fault

    low, high = (parsed_option(option, text, kind) for text in given[:2])
    if not (least <= low < high and given[2] >= LEAST_RUNS):
        words = f"expected the lower value first, {with_unit(least, kind)} or more, and at least {LEAST_RUNS} values"
        raise ConfigError([Fault(option, 0, " ".join(map(str, given)), words)])
    return tuple(float(value) for value in np.linspace(low, high, given[2]))


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
