"""`vvdp cfd`."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.base.extras import require_solids
from vvdp.cli.cfd_place import (
    Flow,
    Grid,
    Model,
    Place,
    Shape,
    Stub,
    Where,
    centre_order,
    rail_order,
    stretch,
    turbine_order,
    workplace,
    write_and_report,
    write_fitted,
)
from vvdp.cli.engines import HERE, Cores, On, Sbatch, Workers
from vvdp.cli.options import AsJson, NoReport, Restart, Settings, SystemName, Verb, out_option, parsed_option
from vvdp.cli.printing import show_result

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vvdp.base.kinds import Kind
    from vvdp.cfd.grids_result import OnGrids
    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.rail_result import Told

USUAL_SHARES = (0.25, 0.5, 1.0, 1.5)
"""Of the pump's flow."""
LEAST_FLOW = 1e-6
"""A flow [m^3/s] that is worth a run."""

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def cfd() -> None:
    """Compute the flow through the valve with OpenFOAM."""


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
    flow: Flow = "",
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
    out: Annotated[Path | None, out_option("results/cfd-rail-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute drop and flow split of the inlet rail.

    The rail is meshed from the valve's shape and solved to a steady flow. Rerun the same command to resume; what is
    finished is not computed again.
    """
    require_solids()
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.rail_result import VERB, rail_result
    from vvdp.cfd.rail_study import run_rails

    loaded, order, told = rail_order(system, settings, shape, grid, model)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"rail-{loaded.name}-{grid}", where, force=force) as place:
        (run,) = run_rails({"": order}, *place)
    reported = write_and_report(place.directory, loaded, rail_result(order, run, told), no_report=no_report)
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("found", "flow"))


@app.command(cls=Verb)
def sweep(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Flows = None,
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
    out: Annotated[Path | None, out_option("results/cfd-sweep-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Fit laws to the drop of the inlet rail over the flow.

    One mesh is solved at every flow. The file fitted.toml is the system with the discharge coefficient that was found.
    Rerun the same command to resume; what is finished is not computed again.
    """
    require_solids()
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.rail_study import run_rails
    from vvdp.cfd.sweep_result import VERB, fitted_settings, sweep_result

    loaded, order, told = rail_order(system, settings, shape, grid, model)
    flows = stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * order.flow for share in USUAL_SHARES)
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"sweep-{loaded.name}-{grid}", where, force=force) as place:
        orders = {with_unit(each, FLOW): order._replace(flow=each) for each in flows}
        runs = run_rails(orders, *place)
    reported = write_and_report(place.directory, loaded, sweep_result(order, runs, told), no_report=no_report)
    write_fitted(place.directory, system, shape, [*(settings or ()), *fitted_settings(reported.result)])
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("fits", "sweep"))


class Part(StrEnum):
    """A part of the valve that is computed by itself."""

    RAIL = "rail"
    CENTRE = "centre"
    TURBINE = "turbine"


@app.command(cls=Verb)
def grids(
    system: SystemName,
    part: Annotated[Part, typer.Option("--part", metavar="PART", help="One of rail, centre, turbine.")] = Part.RAIL,
    grid: Annotated[
        str,
        typer.Option(
            "--grid", metavar="GRID", help="The finest of the three, each 1.4 times as fine: a name, or a number."
        ),
    ] = "fine",
    flow: Flow = "",
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
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
    require_solids()
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.grids_result import VERB, grids_result
    from vvdp.cfd.rail import three_grids

    loaded, order, about = rail_order(system, settings, shape, grid, model)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    orders = {name: order._replace(grid=cells) for name, cells in three_grids(order.grid).items()}
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"grids-{loaded.name}", where, force=force) as place:
        found = _on_grids(part, orders, about, place)
    result = grids_result(order, found, tuple(orders), about)
    reported = write_and_report(place.directory, loaded, result, no_report=no_report)
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("convergence", "grids"))


def _on_grids(
    part: Part,
    orders: "Mapping[str, RailOrder]",
    about: "Told",
    place: Place,
) -> "OnGrids":
    from vvdp.cfd.centre_study import run_centre
    from vvdp.cfd.grids_result import centre_on_grids, rail_on_grids, turbine_on_grids
    from vvdp.cfd.rail_study import run_rails
    from vvdp.cfd.turbine_study import run_turbine

    match part:
        case Part.RAIL:
            return rail_on_grids(run_rails(orders, *place), about)
        case Part.CENTRE:
            found = {name: centre_order(order, 0.0) for name, order in orders.items()}
            return centre_on_grids(run_centre(found, *place), about)
        case Part.TURBINE:
            still = {name: turbine_order(order) for name, order in orders.items()}
            return turbine_on_grids(run_turbine(still, *place), about)


@app.command(cls=Verb)
def designs(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Flow = "",
    shape: Annotated[
        list[str] | None,
        typer.Option("--shape", metavar="NAME|FILE", help="Shapes, two or more (default: the five published)."),
    ] = None,
    model: Model = "k-epsilon",
    settings: Settings = None,
    cores: Cores = None,
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
    out: Annotated[Path | None, out_option("results/cfd-designs-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute several shapes of the inlet rail side by side.

    Drop, flow split and radial force of each. Rerun the same command to resume; what is finished is not computed
    again.
    """
    require_solids()
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.designs_result import VERB, designs_result
    from vvdp.cfd.rail_study import run_rails

    names = _shapes(shape)
    found = {name: rail_order(system, settings, name, grid, model) for name in names}
    loaded, first, told = found[names[0]]
    rate = parsed_option("--flow", flow, FLOW) if flow else first.flow
    orders = {name: order._replace(flow=rate) for name, (_, order, _) in found.items()}
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"designs-{loaded.name}-{grid}", where, force=force) as place:
        runs = run_rails(orders, *place)
    reported = write_and_report(place.directory, loaded, designs_result(orders, runs, told), no_report=no_report)
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("designs",))


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
    stub: Stub = "",
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
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
    require_solids()
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import ANGLE, FLOW, LENGTH
    from vvdp.cfd.centre import scale_radially
    from vvdp.cfd.centre_result import VERB, centre_result, fitted_settings
    from vvdp.cfd.centre_study import run_centre

    loaded, rail, told = rail_order(system, settings, shape, grid, model)
    order = centre_order(rail, parsed_option("--angle", angle, ANGLE), stub)
    flows = stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * rail.flow for share in USUAL_SHARES)
    diameters = [parsed_option("--diameter", text, LENGTH) for text in diameter or ()]
    wide = [scale_radially(order, each) for each in diameters] or [order]
    orders = {
        f"{with_unit(2.0 * each.valve.spool_radius, LENGTH)}, {with_unit(rate, FLOW)}": each._replace(flow=rate)
        for each in wide
        for rate in flows
    }
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"centre-{loaded.name}-{grid}", where, force=force) as place:
        runs = run_centre(orders, *place)
    reported = write_and_report(place.directory, loaded, centre_result(runs, told), no_report=no_report)
    write_fitted(place.directory, system, shape, [*(settings or ()), *fitted_settings(reported.result)])
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("fits", "runs"))


@app.command(cls=Verb)
def openings(
    system: SystemName,
    grid: Grid = "coarse",
    flow: Flow = "",
    angle: Annotated[
        list[str] | None,
        typer.Option("--angle", metavar="ANGLE", help="Spool angle, two or more (default: 16.5 deg and 21 deg)."),
    ] = None,
    stub: Stub = "",
    model: Model = "k-epsilon",
    shape: Shape = None,
    settings: Settings = None,
    cores: Cores = None,
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
    out: Annotated[Path | None, out_option("results/cfd-openings-SYSTEM-GRID")] = None,
    force: Restart = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute effective area and torque of partly open nozzles.

    The centre section is solved with open nozzles and, at each angle, with nozzles that close and that open; the spool
    stands still. Rerun the same command to resume; what is finished is not computed again.
    """
    require_solids()
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import ANGLE, FLOW
    from vvdp.cfd.centre_study import run_centre
    from vvdp.cfd.openings_result import VERB, both_ways, openings_result

    loaded, rail, told = rail_order(system, settings, shape, grid, model)
    order = centre_order(rail, 0.0, stub)
    order = order._replace(flow=parsed_option("--flow", flow, FLOW)) if flow else order
    angles = both_ways(_two_or_more("--angle", angle or ["16.5 deg", "21 deg"], ANGLE))
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"openings-{loaded.name}-{grid}", where, force=force) as place:
        orders = {with_unit(each, ANGLE): order._replace(angle=each) for each in angles}
        runs = run_centre(orders, *place)
    reported = write_and_report(place.directory, loaded, openings_result(runs, told), no_report=no_report)
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("fits", "angles"))


def _two_or_more(option: str, given: list[str], kind: "Kind") -> list[float]:
    """Values of an option above zero. Raises ConfigError where there are too few for a law."""
    from vvdp.base.errors import ConfigError, Fault

    found = sorted({parsed_option(option, text, kind) for text in given})
    if len(found) < 2 or not found[0] > 0.0:
        raise ConfigError([Fault(option, 0, ", ".join(given), "expected two or more different values above zero")])
    return found


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
    on: On = HERE,
    workers: Workers = None,
    sbatch: Sbatch = None,
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
    require_solids()
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import FLOW, SPEED
    from vvdp.cfd.turbine_result import VERB, fitted_settings, turbine_result
    from vvdp.cfd.turbine_study import run_turbine

    loaded, rail, told = rail_order(system, settings, shape, grid, model)
    order = turbine_order(rail)
    flows = [parsed_option("--flow", text, FLOW) for text in flow or ()] or [rail.flow]
    speeds = stretch("--speed", speed, SPEED, 0.0)
    orders = {
        f"{with_unit(rate, FLOW)}, {with_unit(each, SPEED)}": order._replace(flow=rate, speed=each)
        for rate in flows
        for each in speeds
    }
    where = Where(on, workers, cores, sbatch)
    with workplace(VERB, out, f"turbine-{loaded.name}-{grid}", where, force=force) as place:
        runs = run_turbine(orders, *place)
    reported = write_and_report(place.directory, loaded, turbine_result(runs, told), no_report=no_report)
    write_fitted(place.directory, system, shape, [*(settings or ()), *fitted_settings(reported.result)])
    show_result(reported.result, place.directory, json=json, reported=reported.page, names=("fits", "runs"))
