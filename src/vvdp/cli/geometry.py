"""`vvdp geometry`."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.options import Output, RigCase, default_directory, flat, out_option, parsed_option
from vvdp.cli.printing import print_result
from vvdp.cli.report import GEOMETRY, add_report

if TYPE_CHECKING:
    from vvdp.geometry.product import Order
    from vvdp.results.result import Result
    from vvdp.systems.system import System

INTERRUPTED = 130


@dataclass(frozen=True)
class Solids:
    """Options: what is built of the valve."""

    shape: Annotated[
        str | None,
        typer.Option(
            "--shape",
            metavar="NAME|FILE",
            help="A shipped shape (full-stroke, rail-a to rail-d, rail-final), or a TOML file whose table [geometry] "
            "replaces lengths.",
        ),
    ] = None
    angle: Annotated[
        str,
        typer.Option(
            "--angle", metavar="ANGLE", help="Spool angle for the oil volumes; at 0 the valve is open to the load."
        ),
    ] = "0 deg"
    fineness: Annotated[
        float, typer.Option("--fineness", metavar="N", min=10, max=200, help="Number of mesh edges per spool radius.")
    ] = 25.0
    frames: Annotated[
        int, typer.Option("--frames", metavar="N", min=0, help="Number of animation frames; 0 for none.")
    ] = 48
    step: Annotated[bool, typer.Option("--step", help="Also write STEP files; needs the extra [cad].")] = False


@flat("results/geometry-SYSTEM-DATE-TIME")
def geometry(
    *,
    case: RigCase,
    out: Annotated[Path | None, out_option("results/geometry-SYSTEM-DATE-TIME")] = None,
    solids: Solids,
    output: Output,
) -> None:
    """Build spool, sleeve and oil volumes as solids.

    The axial position is that of the start of the run. Lengths that only the shape needs are those of the system's own
    table [geometry], replaced by --shape and by --set geometry.KEY=VALUE. Ctrl-C keeps what has been made so far.
    """
    from vvdp.base.extras import require, require_solids

    require_solids()
    if solids.step:
        require("OCP", "cad", "a STEP file")
    from vvdp.cli.screen import print_json, say, tell

    own = [text for text in case.settings or () if text.strip().startswith("geometry.")]
    loaded = _with_one_valve(replace(case, settings=[text for text in case.settings or () if text not in own]))
    order = _order(loaded, solids, own)
    directory = out if out is not None else default_directory(f"geometry-{loaded.name}")
    result = _make(directory, loaded, order, solids.frames, output)
    if output.json:
        print_json({**result.flat, "out": str(directory)})
    else:
        print_result(result, [name for name in ("comparison", "bodies") if name in {*result.listings, *result.tables}])
        tell(f"results: {directory}" + ("" if output.no_report else f"\nreport: {directory / 'report.html'}"))
    if not result.finished:
        say("interrupted; what was made is written")
        raise typer.Exit(INTERRUPTED)


def _with_one_valve(case: RigCase) -> "System":
    """The system; if it has several rotary valves, a test rig with the one that is asked for."""
    from vvdp.evaluation.valve_numbers import placed_valves

    loaded = case.load()
    several = case.part or len([*placed_valves(loaded.circuit.network)]) > 1
    return case.on_rig("geometry") if several else loaded


def _order(loaded: "System", solids: Solids, settings: list[str]) -> "Order":
    """Order of the solids to make. Raises ParameterError if the spool would stand outside its stroke."""
    from vvdp.base.kinds import ANGLE
    from vvdp.geometry.domains import require_within_stroke
    from vvdp.geometry.product import Order
    from vvdp.geometry.shape_tables import given_shape
    from vvdp.systems.spool_travel import first_position, require_rotary_valve

    valve = require_rotary_valve(loaded, "geometry")
    made, rows = given_shape(valve, solids.shape, settings, loaded.lengths)
    told = first_position(loaded)
    position = 0.5 * valve.helix_length if told is None else told
    require_within_stroke(position, made, valve)
    return Order(
        name=loaded.name,
        valve=valve,
        shape=made,
        rows=rows,
        angle=parsed_option("--angle", solids.angle, ANGLE),
        position=position,
        fineness=solids.fineness,
        step=solids.step,
    )


def _make(directory: Path, loaded: "System", order: "Order", frames: int, output: Output) -> "Result":
    """Makes all files of an order and the page; their results."""
    from vvdp.base.files import list_all, result_directory
    from vvdp.cli.screen import say, typed_command
    from vvdp.geometry.product import make_product
    from vvdp.geometry.result import geometry_result
    from vvdp.report.geometry_figures import animation
    from vvdp.results.store import write_result
    from vvdp.systems.resolved import resolved_text

    def film() -> bytes:
        return animation(order.shape, order.valve, order.position, frames)

    with result_directory(directory, force=output.force) as folder:
        product = make_product(folder, order, say, film if frames else None)
        result = geometry_result(order, product)
        write_result(folder, result, resolved_text(loaded), typed_command())
        list_all(folder)
        if not output.no_report:
            say("pictures")
            add_report(GEOMETRY, folder)
    return result
