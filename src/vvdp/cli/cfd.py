"""`vvdp cfd`."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.base.extras import require_solids
from vvdp.cli.cfd_place import (
    Flow,
    Method,
    Place,
    Stub,
    Valve,
    Work,
    centre_order,
    rail_order,
    stretch,
    turbine_order,
    write_fitted,
)
from vvdp.cli.options import Verb, flat, parsed_option

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
@flat("results/cfd-rail-SYSTEM-GRID")
def rail(
    *,
    valve: Valve,
    flow: Flow = "",
    method: Method,
    work: Work,
) -> None:
    """Compute drop and flow split of the inlet rail.

    The rail is meshed from the valve's shape and solved to a steady flow. Rerun the same command to resume; what is
    finished is not computed again.
    """
    require_solids()
    from vvdp.cfd.rail_result import VERB, rail_result
    from vvdp.cfd.rail_study import run_rails

    loaded, order, told = rail_order(valve, method, flow)
    with work.place(VERB, f"rail-{loaded.name}-{valve.grid}") as place:
        (run,) = run_rails({"": order}, *place)
    work.finish(place, loaded, rail_result(order, run, told), "found", "flow")


@app.command(cls=Verb)
@flat("results/cfd-sweep-SYSTEM-GRID")
def sweep(
    *,
    valve: Valve,
    flow: Flows = None,
    method: Method,
    work: Work,
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

    loaded, order, told = rail_order(valve, method)
    flows = stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * order.flow for share in USUAL_SHARES)
    with work.place(VERB, f"sweep-{loaded.name}-{valve.grid}") as place:
        orders = {with_unit(each, FLOW): order._replace(flow=each) for each in flows}
        runs = run_rails(orders, *place)
    result = sweep_result(order, runs, told)
    write_fitted(place.directory, valve.system, method, fitted_settings(result))
    work.finish(place, loaded, result, "fits", "sweep")


class Part(StrEnum):
    """A part of the valve that is computed by itself."""

    RAIL = "rail"
    CENTRE = "centre"
    TURBINE = "turbine"


@app.command(cls=Verb)
@flat("results/cfd-grids-SYSTEM")
def grids(
    *,
    valve: Valve,
    part: Annotated[Part, typer.Option("--part", metavar="PART", help="One of rail, centre, turbine.")] = Part.RAIL,
    grid: Annotated[
        str,
        typer.Option(
            "--grid", metavar="GRID", help="The finest of the three, each 1.4 times as fine: a name, or a number."
        ),
    ] = "fine",
    flow: Flow = "",
    method: Method,
    work: Work,
) -> None:
    """Compute a part of the valve on three grids and show how far the drop is off.

    Observed order, extrapolation and grid convergence index. With another finest grid, those below it are coarser
    still. Rerun the same command to resume; what is finished is not
    computed again.
    """
    require_solids()
    from vvdp.cfd.grids_result import VERB, grids_result
    from vvdp.cfd.rail import three_grids

    loaded, order, about = rail_order(replace(valve, grid=grid), method, flow)
    orders = {name: order._replace(grid=cells) for name, cells in three_grids(order.grid).items()}
    with work.place(VERB, f"grids-{loaded.name}") as place:
        found = _on_grids(part, orders, about, place)
    result = grids_result(order, found, tuple(orders), about)
    work.finish(place, loaded, result, "convergence", "grids")


@app.command(cls=Verb)
@flat("results/cfd-models-SYSTEM-PART-GRID")
def models(
    *,
    valve: Valve,
    part: Annotated[Part, typer.Option("--part", metavar="PART", help="One of rail, centre, turbine.")] = Part.RAIL,
    flow: Flows = None,
    method: Method,
    work: Work,
) -> None:
    """Compute a part of the valve by several models of turbulence and schemes.

    Standard k-epsilon of second and of first order, k-omega SST and laminar flow, all on one mesh at every flow; the
    options --turbulence and --scheme are not used. Rerun the same command to resume; what is finished is not computed
    again.
    """
    require_solids()
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.models_result import APPROACHES, VERB, models_result

    loaded, order, about = rail_order(valve, method)
    flows = stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * order.flow for share in USUAL_SHARES)
    orders = {
        f"{name}, {with_unit(each, FLOW)}": order._replace(flow=each, **approach._asdict())
        for name, approach in APPROACHES.items()
        for each in flows
    }
    with work.place(VERB, f"models-{loaded.name}-{part}-{valve.grid}") as place:
        found = _on_grids(part, orders, about, place)
    work.finish(place, loaded, models_result(order, found, flows, about), "laws", "runs")


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
@flat("results/cfd-designs-SYSTEM-GRID")
def designs(
    *,
    valve: Valve,
    flow: Flow = "",
    shape: Annotated[
        list[str] | None,
        typer.Option("--shape", metavar="NAME|FILE", help="Shapes, two or more (default: the five published)."),
    ] = None,
    method: Method,
    work: Work,
) -> None:
    """Compute several shapes of the inlet rail side by side.

    Drop, flow split and radial force of each. Rerun the same command to resume; what is finished is not computed
    again.
    """
    require_solids()
    from vvdp.cfd.designs_result import VERB, designs_result
    from vvdp.cfd.rail_study import run_rails

    names = _shapes(shape)
    found = {name: rail_order(valve, replace(method, shape=name), flow) for name in names}
    loaded, _, told = found[names[0]]
    orders = {name: order for name, (_, order, _) in found.items()}
    with work.place(VERB, f"designs-{loaded.name}-{valve.grid}") as place:
        runs = run_rails(orders, *place)
    work.finish(place, loaded, designs_result(orders, runs, told), "designs")


def _shapes(given: list[str] | None) -> tuple[str, ...]:
    """The shapes to be compared. Raises ConfigError where that is one alone."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.geometry.shape_tables import shipped_shapes

    names = tuple(dict.fromkeys(given or (name for name in shipped_shapes() if name.startswith("rail-"))))
    if len(names) < 2:
        raise ConfigError([Fault("--shape", 0, ", ".join(names), "expected two or more different shapes")])
    return names


@dataclass(frozen=True)
class Section:
    """Options: the centre section that is computed."""

    angle: Annotated[str, typer.Option("--angle", metavar="ANGLE", help="Spool angle; at 0 the nozzles are open.")] = (
        "0 deg"
    )
    diameter: Annotated[
        list[str] | None,
        typer.Option("--diameter", metavar="D", help="Spool diameters, lengths along it as they are (repeatable)."),
    ] = None
    stub: Stub = ""


@app.command(cls=Verb)
@flat("results/cfd-centre-SYSTEM-GRID")
def centre(
    *,
    valve: Valve,
    flow: Flows = None,
    section: Section,
    method: Method,
    work: Work,
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

    loaded, rail, told = rail_order(valve, method)
    order = centre_order(rail, parsed_option("--angle", section.angle, ANGLE), section.stub)
    flows = stretch("--flow", flow, FLOW, LEAST_FLOW) if flow else tuple(share * rail.flow for share in USUAL_SHARES)
    diameters = [parsed_option("--diameter", text, LENGTH) for text in section.diameter or ()]
    wide = [scale_radially(order, each) for each in diameters] or [order]
    orders = {
        f"{with_unit(2.0 * each.valve.spool_radius, LENGTH)}, {with_unit(rate, FLOW)}": each._replace(flow=rate)
        for each in wide
        for rate in flows
    }
    with work.place(VERB, f"centre-{loaded.name}-{valve.grid}") as place:
        runs = run_centre(orders, *place)
    result = centre_result(runs, told)
    write_fitted(place.directory, valve.system, method, fitted_settings(result))
    work.finish(place, loaded, result, "fits", "runs")


@app.command(cls=Verb)
@flat("results/cfd-openings-SYSTEM-GRID")
def openings(
    *,
    valve: Valve,
    flow: Flow = "",
    angle: Annotated[
        list[str] | None,
        typer.Option("--angle", metavar="ANGLE", help="Spool angle, two or more (default: 16.5 deg and 21 deg)."),
    ] = None,
    stub: Stub = "",
    method: Method,
    work: Work,
) -> None:
    """Compute effective area and torque of partly open nozzles.

    The centre section is solved with open nozzles and, at each angle, with nozzles that close and that open; the spool
    stands still. Rerun the same command to resume; what is finished is not computed again.
    """
    require_solids()
    from vvdp.base.display import with_unit
    from vvdp.base.kinds import ANGLE
    from vvdp.cfd.centre_study import run_centre
    from vvdp.cfd.openings_result import VERB, both_ways, openings_result

    loaded, rail, told = rail_order(valve, method, flow)
    order = centre_order(rail, 0.0, stub)
    angles = both_ways(_two_or_more("--angle", angle or ["16.5 deg", "21 deg"], ANGLE))
    with work.place(VERB, f"openings-{loaded.name}-{valve.grid}") as place:
        orders = {with_unit(each, ANGLE): order._replace(angle=each) for each in angles}
        runs = run_centre(orders, *place)
    work.finish(place, loaded, openings_result(runs, told), "fits", "angles")


def _two_or_more(option: str, given: list[str], kind: "Kind") -> list[float]:
    """Values of an option above zero. Raises ConfigError where there are too few for a law."""
    from vvdp.base.errors import ConfigError, Fault

    found = sorted({parsed_option(option, text, kind) for text in given})
    if len(found) < 2 or not found[0] > 0.0:
        raise ConfigError([Fault(option, 0, ", ".join(given), "expected two or more different values greater than 0")])
    return found


@app.command(cls=Verb)
@flat("results/cfd-turbine-SYSTEM-GRID")
def turbine(
    *,
    valve: Valve,
    flow: Annotated[
        list[str] | None,
        typer.Option("--flow", metavar="FLOW", help="Flow (repeatable; default: that of the pump)."),
    ] = None,
    speed: Annotated[
        tuple[str, str, int],
        typer.Option("--speed", metavar="FROM TO COUNT", help="Spool speeds, 3 or more."),
    ] = ("0 rpm", "1500 rpm", 3),
    method: Method,
    work: Work,
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

    loaded, rail, told = rail_order(valve, method)
    order = turbine_order(rail)
    flows = [parsed_option("--flow", text, FLOW) for text in flow or ()] or [rail.flow]
    speeds = stretch("--speed", speed, SPEED, 0.0)
    orders = {
        f"{with_unit(rate, FLOW)}, {with_unit(each, SPEED)}": order._replace(flow=rate, speed=each)
        for rate in flows
        for each in speeds
    }
    with work.place(VERB, f"turbine-{loaded.name}-{valve.grid}") as place:
        runs = run_turbine(orders, *place)
    result = turbine_result(runs, told)
    write_fitted(place.directory, valve.system, method, fitted_settings(result))
    work.finish(place, loaded, result, "fits", "runs")
