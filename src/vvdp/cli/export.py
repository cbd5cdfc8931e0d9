"""`vvdp export`: results for other programs, models as C and as FMUs, systems as pages."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.options import AsJson, Force, Settings, SystemName, Verb, default_directory, flat, out_option

if TYPE_CHECKING:
    from vvdp.export.fmu_extras import Extras
    from vvdp.export.fmu_model import FmuModel

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

Csv = Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write a CSV file.")]
Parquet = Annotated[
    Path | None, typer.Option("--parquet", metavar="FILE", help="Write a Parquet file (needs the extra `data`).")
]


@app.callback()
def export() -> None:
    """Export tables, C code, an FMU, or a page that runs."""


@app.command("data", cls=Verb)
def data(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Result directory.")],
    csv: Csv = None,
    parquet: Parquet = None,
    table: Annotated[
        list[str] | None, typer.Option("--table", metavar="NAME", help="Export this table only (repeatable).")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False,
    json: AsJson = False,
) -> None:
    """Export the recorded series of a run, or the tables of any other result.

    All values are in SI; the name of each column ends with its unit. Several tables are written to one file each.
    """
    from vvdp.base.errors import unusable
    from vvdp.base.manifest import as_damaged
    from vvdp.cli.screen import print_json, tell
    from vvdp.export.data import export_tables, result_tables

    if csv is None and parquet is None:
        raise unusable("export data", "no file is given; expected --csv FILE or --parquet FILE")
    with as_damaged(directory):
        tables = result_tables(directory, tuple(table or ()))
    written: list[str] = []
    for path, as_parquet in ((csv, False), (parquet, True)):
        if path is not None:
            written += map(str, export_tables(tables, path, as_parquet=as_parquet, force=force))
    if json:
        print_json({"files": written})
    else:
        tell("\n".join(written))


@dataclass(frozen=True)
class Part:
    """Options: what of a system is exported."""

    system: SystemName
    part: Annotated[
        str,
        typer.Option("--part", metavar="NAME", help="Program to export, `circuit`, or `machine` (all, with the loop)."),
    ] = "circuit"


class Precision(StrEnum):
    """The precision of exported numbers."""

    DOUBLE = "double"
    SINGLE = "single"


@dataclass(frozen=True)
class Target:
    """Options: for which processor a part is exported."""

    precision: Annotated[
        Precision,
        typer.Option(
            "--precision", metavar="PRECISION", help="Numbers are `double` or, where a step allows it, `single`."
        ),
    ] = Precision.DOUBLE
    clock: Annotated[
        str | None,
        typer.Option(
            "--clock",
            metavar="FREQUENCY",
            help='Clock of a microcontroller, for example "168 MHz": count instructions and state its load.',
        ),
    ] = None
    samples: Annotated[
        int, typer.Option("--samples", metavar="N", min=1, max=10_000, help="Number of samples with expected bits.")
    ] = 100


@app.command("c", cls=Verb)
@flat("results/c-NAME-TIME")
def write_c_folder(
    *,
    chosen: Part,
    target: Target,
    settings: Settings = None,
    out: Annotated[Path | None, out_option("results/c-NAME-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
) -> None:
    """Export a circuit, a sampled program, or a whole system with its simulation loop as C99.

    The directory holds the functions with structs and units, test vectors with the expected bits, a Makefile and a
    README. `make test` in it compares every bit.
    """
    from vvdp.base.files import result_directory, write_whole
    from vvdp.cli.options import parsed_option
    from vvdp.cli.screen import print_json, say, tell
    from vvdp.export.c_folder import exported_folder
    from vvdp.export.c_parts import Precision as Numbers
    from vvdp.export.c_target import CLOCK
    from vvdp.systems.system import load_system

    clock = None if target.clock is None else parsed_option("--clock", target.clock, CLOCK)
    precision = Numbers[target.precision.name]
    system = load_system(chosen.system, settings or ())
    made = exported_folder(system, chosen.part, target.samples, precision, clock, say)
    found = made.facts
    directory = out if out is not None else default_directory(f"c-{made.name}")
    with result_directory(directory, force=force) as folder:
        for name, text in made.files.items():
            write_whole(folder / name, text)
    if json:
        print_json({**found, "out": str(directory)})
    else:
        samples = found["samples"]
        tell(f"{found['functions']} functions, {found['lines']} lines of C, {samples} samples with expected bits")
        tell(f"memory: {found['memory_bytes']} bytes, settings: {found['settings_bytes']} bytes")
        for load in found.get("loads", ()):
            share = load["most"] / found["clock_Hz"] / found["period_s"]
            tell(
                f"{load['core']}: {load['code']} bytes of code, at most {load['most']} instructions per sample (sample "
                f"{load['sample']}): {share:.3g} of the period at {target.clock}, at one instruction per cycle"
            )
        tell(f"results: {directory}\ntest: make -C {directory} test")


@dataclass(frozen=True)
class Variables:
    """Options: which FMU of a system is exported."""

    system: SystemName
    fmi: Annotated[int, typer.Option("--fmi", metavar="N", min=2, max=3, help="Version of FMI: 2 or 3.")] = 3
    kind: Annotated[
        str,
        typer.Option(
            "--kind", metavar="KIND", help="Kind of FMU: `cs` (co-simulation), `me` (model exchange), `both`."
        ),
    ] = "cs"
    input: Annotated[
        list[str] | None,
        typer.Option(
            "--input", metavar="KEY[=NAME]", help="Input of the FMU (repeatable; default: all signals of the file)."
        ),
    ] = None
    output: Annotated[
        list[str] | None,
        typer.Option(
            "--output", metavar="PATH[=NAME]", help="Output of the FMU (repeatable; default: all that can be shown)."
        ),
    ] = None
    books: Annotated[
        bool, typer.Option("--books", help="Model exchange: carry the energy and mass balance as states, too.")
    ] = False
    platform: Annotated[
        list[str] | None,
        typer.Option(
            "--platform",
            metavar="NAME",
            help="Machine with a binary in the FMU, for example x86_64-windows (repeatable; default: this one).",
        ),
    ] = None


@app.command("fmu", cls=Verb)
@flat()
def write_fmu(
    *,
    chosen: Variables,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The FMU, FILE.fmu.")],
    settings: Settings = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    json: AsJson = False,
) -> None:
    """Export a system as an FMU, for co-simulation with its simulation loop or for model exchange.

    The file holds the sources in C99 and, if a C compiler or the package ziglang is found, the binary of this machine.
    Binaries for other machines (`--platform`) need the extra `fmi-cross`.
    """
    from vvdp.base.errors import unusable
    from vvdp.base.files import write_whole
    from vvdp.cli.screen import print_json, tell
    from vvdp.export.fmu import fmu, require_kind
    from vvdp.export.fmu_binary import platforms_named
    from vvdp.export.fmu_model import Guest, fmu_model
    from vvdp.systems.system import load_system

    require_kind(chosen.kind)
    platforms = platforms_named(chosen.platform or (), chosen.fmi)
    if out.exists() and not force:
        raise unusable(out, "exists already; --force replaces it")
    system = load_system(chosen.system, settings or ())
    guest = None if chosen.kind == "cs" else Guest(has_books=chosen.books)
    model = fmu_model(system, chosen.input or (), chosen.output or (), guest)
    made = fmu(model, chosen.fmi, platforms, _extras(model), is_solved=chosen.kind != "me")
    write_whole(out, made.content)
    facts = made.facts
    if json:
        print_json({**facts, "out": str(out)})
        return
    tell(
        f"FMI {made.fmi}: {len(facts['inputs'])} inputs, {len(facts['outputs'])} outputs, "
        f"{len(facts['free_parameters'])} free parameters, {len(facts['fixed_parameters'])} fixed values"
    )
    if made.compiler:
        tell(f"{facts['bytes']} bytes; binaries for {', '.join(facts['platforms'])} by {made.compiler}")
    else:
        tell("no C compiler was found: the FMU has sources only; install one, or the extra `fmi-cross`")
    tell(f"FMU: {out}")


def _extras(model: "FmuModel") -> "Extras":
    """The diagram, icon and reference result of an FMU."""
    from vvdp.export.fmu_extras import Extras, reference_text
    from vvdp.report.circuit import graph_of
    from vvdp.report.diagram import diagram
    from vvdp.report.raster import icon_png

    drawn = diagram(graph_of(model.system.circuit.network, model.system.title))
    return Extras(drawn, icon_png(drawn), reference_text(model))


@app.command("web", cls=Verb)
def write_web_page(
    system: SystemName,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The page, FILE.html.")],
    settings: Settings = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="TIME", help='Time to simulate, for example "2 s".')
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    json: AsJson = False,
) -> None:
    """Export a system as one HTML file that runs it in a browser, without a network.

    Its values have sliders; charts, numbers and warnings follow. Needs the extra `web`.
    """
    from vvdp.base.errors import unusable
    from vvdp.base.files import write_whole
    from vvdp.cli.screen import print_json, run_command, say, tell
    from vvdp.systems.system import load_system
    from vvdp.web.page import web_page

    if out.exists() and not force:
        raise unusable(out, "exists already; --force replaces it")
    page = web_page(load_system(system, settings or (), until), run_command(system, settings, until), say)
    write_whole(out, page.html)
    if json:
        print_json({**page.facts, "out": str(out)})
    else:
        facts = page.facts
        tell(
            f"{facts['bytes']} bytes, {facts['module_bytes']} of them the module; {facts['values']} values with sliders"
        )
        tell(f"page: {out}")
