"""`vvdp geometry`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vvdp.cli.options import AsJson, Force, NoReport, Settings, SystemName, default_directory, out_option, parsed_option

if TYPE_CHECKING:
    from vvdp.geometry.measure import Comparison
    from vvdp.report.geometry_product import Product
    from vvdp.systems.system import System

INTERRUPTED = 130


def geometry(
    system: SystemName,
    out: Annotated[Path | None, out_option("results/geometry-SYSTEM-DATE-TIME")] = None,
    shape: Annotated[
        Path | None,
        typer.Option("--shape", metavar="FILE", help="TOML file whose table [geometry] replaces shipped lengths."),
    ] = None,
    angle: Annotated[
        str,
        typer.Option(
            "--angle", metavar="ANGLE", help="Spool angle for the oil volumes; at 0 the valve is open to the load."
        ),
    ] = "0 deg",
    fineness: Annotated[
        float, typer.Option("--fineness", metavar="N", min=10, max=200, help="Number of mesh edges per spool radius.")
    ] = 25.0,
    frames: Annotated[
        int, typer.Option("--frames", metavar="N", min=0, help="Number of animation frames; 0 for none.")
    ] = 48,
    step: Annotated[bool, typer.Option("--step", help="Also write STEP files; needs the extra [cad].")] = False,
    settings: Settings = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Build spool, sleeve and oil volumes as solids and draw them.

    The axial position is that of the duty ratio at the start of the run. Lengths that only the shape needs are set with
    --set geometry.KEY=VALUE. Ctrl-C keeps what has been made so far.
    """
    _require_libraries(step)
    from vvdp.base.files import result_directory
    from vvdp.base.kinds import ANGLE
    from vvdp.base.signal import signal_value
    from vvdp.cli.screen import print_json, say
    from vvdp.geometry.domains import require_within_stroke
    from vvdp.geometry.shape import given_shape
    from vvdp.report.geometry_product import Order, write_product
    from vvdp.systems.bench import rotary_bench
    from vvdp.systems.system import load_system

    own = [text for text in settings or () if text.strip().startswith("geometry.")]
    loaded = load_system(system, [text for text in settings or () if text not in own])
    bench = rotary_bench(loaded, "geometry")
    made, rows = given_shape(bench.valve, shape, own)
    position = float(signal_value(0.0, bench.axial_position))
    require_within_stroke(position, made, bench.valve)
    order = Order(
        title=loaded.title,
        name=loaded.name,
        valve=bench.valve,
        shape=made,
        rows=rows,
        angle=parsed_option("--angle", angle, ANGLE),
        position=position,
        fineness=fineness,
        frames=frames,
        step=step,
        report=not no_report,
    )
    directory = out if out is not None else default_directory(f"geometry-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        product = write_product(folder, order, say)
    if json:
        print_json({**product.summary, "out": str(directory)})
    else:
        _print(loaded, product)
        typer.echo(f"results: {directory}" + ("" if no_report else f"\nreport: {directory / 'report.html'}"))
    if not product.finished:
        say("interrupted; what was made is written")
        raise typer.Exit(INTERRUPTED)


def _require_libraries(step: bool) -> None:
    """Raises MissingExtraError where solids, or STEP files of them, cannot be made."""
    from vvdp.base.extras import require

    for library in ("manifold3d", "trimesh"):
        require(library, "geometry", "a valve as solids")
    if step:
        require("OCP", "cad", "a STEP file")


def _print(system: "System", product: "Product") -> None:
    from vvdp.cli.screen import console, grid, tell
    from vvdp.report.geometry_report import shown

    out, s = console(), product.summary
    tell(system.title)
    out.print(f"duty ratio {s['duty_ratio']:.4g}, spool angle {shown(s['spool_angle_rad'], 'rad')}")
    if product.comparisons:
        out.print(_compared(product.comparisons, s.get("openings_difference")))
    table = grid("", "volume", "triangles", right=("volume", "triangles"))
    for name, volume, triangles in product.bodies:
        table.add_row(name, shown(volume, "m^3"), str(triangles) if triangles else "-")
    out.print(table)
    for name in product.shut:
        tell(f"{name}: not made, the nozzles are shut to this side here")


def _compared(comparisons: "Sequence[Comparison]", openings: float | None) -> Any:
    from vvdp.cli.screen import grid
    from vvdp.report.geometry_report import shown

    table = grid("quantity", "formula", "mesh", "difference", right=("formula", "mesh", "difference"))
    for each in comparisons:
        measured = shown(each.measured, each.unit)
        table.add_row(each.title, shown(each.formula, each.unit), measured, f"{100.0 * each.difference:+.3f} %")
    if openings is not None:
        table.add_row("open share over a period, largest", "", "", f"{100.0 * openings:.3f} %")
    return table
