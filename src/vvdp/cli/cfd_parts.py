"""`vvdp cfd sleeve` and `valve`: parts of the valve beside the whole; `vvdp cfd period`: a spool that turns."""

from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.base.extras import require_solids
from vvdp.cli.cfd_place import Flow, Method, Valve, Work, centre_order, rail_order, turbine_order
from vvdp.cli.options import flat, parsed_option

if TYPE_CHECKING:
    from vvdp.base.kinds import Kind
    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.section import Plane


@flat("results/cfd-sleeve-SYSTEM-GRID")
def sleeve(
    *,
    valve: Valve,
    flow: Flow = "",
    method: Method,
    work: Work,
) -> None:
    """Compute the sleeve without its spool beside the inlet rail alone.

    That is how the drop of rail and nozzles is measured. Rerun the same command to resume; what is finished is not
    computed again.
    """
    require_solids()
    from vvdp.cfd.parts_result import SLEEVE, sleeve_parts, sleeve_result
    from vvdp.cfd.parts_study import run_parts

    loaded, order, told = rail_order(valve, method, flow)
    with work.place(SLEEVE, f"sleeve-{loaded.name}-{valve.grid}") as place:
        runs = run_parts(sleeve_parts(order), _middle(order), *place)
    work.finish(place, loaded, sleeve_result(order, runs, told), "found", "parts")


@flat("results/cfd-valve-SYSTEM-GRID")
def valve(
    *,
    valve: Valve,
    flow: Flow = "",
    speed: Annotated[str, typer.Option("--speed", metavar="SPEED", help="Speed of the spool.")] = "1440 rpm",
    method: Method,
    work: Work,
) -> None:
    """Compute the whole way of the oil to the load beside its sections.

    Drop and torque of the valve as one, of rail, centre section and outlet turbine, and by the system's laws. Rerun the
    same command to resume; what is finished is not computed again.
    """
    require_solids()
    from vvdp.base.kinds import SPEED
    from vvdp.cfd.parts_result import VALVE, valve_parts, valve_result
    from vvdp.cfd.parts_study import run_parts

    loaded, rail, told = rail_order(valve, method, flow)
    turbine = turbine_order(rail)._replace(speed=parsed_option("--speed", speed, SPEED))
    centre = centre_order(rail, 0.0)._replace(speed=turbine.speed)
    with work.place(VALVE, f"valve-{loaded.name}-{valve.grid}") as place:
        parts = valve_parts(rail, centre, turbine)
        runs = run_parts(parts, _middle(rail), *place)
    work.finish(place, loaded, valve_result(turbine, runs, told), "found", "parts")


@flat("results/cfd-period-SYSTEM-GRID")
def period(
    *,
    valve: Valve,
    speed: Annotated[str, typer.Option("--speed", metavar="SPEED", help="Speed of the spool.")] = "1440 rpm",
    drop: Annotated[
        str,
        typer.Option(
            "--drop", metavar="DROP", help="Total drop that is held (default: by the laws at the pump's flow)."
        ),
    ] = "",
    method: Method,
    work: Work,
) -> None:
    """Compute a PWM period of the turning spool.

    The mesh of the spool's oil slides along the nozzles, which its barriers open and closed: effective area and torque
    over the angle. Where meshes slide, convection is of first order; the option --scheme is not used. Rerun the same
    command to resume; what is finished is not computed again.
    """
    require_solids()
    from vvdp.base.kinds import PRESSURE_DIFFERENCE, SPEED
    from vvdp.cfd.period import PeriodOrder, law_drop, run_period
    from vvdp.cfd.period_result import VERB, period_result

    loaded, rail, told = rail_order(valve, method)
    centre = centre_order(rail, 0.0)._replace(speed=_above_zero("--speed", speed, SPEED))
    held = _above_zero("--drop", drop, PRESSURE_DIFFERENCE) if drop else law_drop(centre)
    with work.place(VERB, f"period-{loaded.name}-{valve.grid}") as place:
        run = run_period(PeriodOrder(centre, held), *place)
    work.finish(place, loaded, period_result(run, told), "found")


def _above_zero(option: str, text: str, kind: "Kind") -> float:
    """The value of an option. Raises ConfigError where it is not above zero."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.rules import POSITIVE

    value = parsed_option(option, text, kind)
    if not value > 0.0:
        raise ConfigError([Fault(option, 0, text, POSITIVE)])
    return value


def _middle(rail: "RailOrder") -> "Plane":
    """The plane of the nozzles; a hair off it, where their corners lie."""
    from vvdp.cfd.section import Plane

    return Plane((0.0, 0.0, 1e-3 * rail.valve.spool_radius), (0.0, 0.0, 1.0))
