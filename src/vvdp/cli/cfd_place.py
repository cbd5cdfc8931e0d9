"""Common code of the subcommands of `vvdp cfd`: their options, the order of a system's valve, and the place where it is
carried out."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer

from vvdp.cli.engines import Resumable
from vvdp.cli.options import Settings, SystemName, parsed_option
from vvdp.cli.printing import show_result

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from vvdp.base.kinds import Kind
    from vvdp.cfd.centre import CentreOrder
    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.solve import Progress
    from vvdp.cfd.turbine import TurbineOrder
    from vvdp.results.result import Result
    from vvdp.studies.engine import Engine
    from vvdp.systems.system import System

T = TypeVar("T")
COARSEST, FINEST = 4.0, 64.0
"""Cells per spool radius: with fewer, nozzles are two cells wide; more are some ten million."""
LEAST_RUNS = 3
"""Runs to which a law with its confidence can be fitted."""
Grid = Annotated[
    str,
    typer.Option(
        "--grid", metavar="GRID", help="One of coarse, medium, fine (8, 11.3, 16 cells per spool radius), or a number."
    ),
]
Model = Annotated[
    str, typer.Option("--turbulence", metavar="MODEL", help="One of k-epsilon, realizable, sst, laminar.")
]
Scheme = Annotated[
    str,
    typer.Option("--scheme", metavar="ORDER", help="Convection: second-order, or first-order as in the source."),
]
Shape = Annotated[
    str | None,
    typer.Option(
        "--shape",
        metavar="NAME|FILE",
        help="A shipped shape (rail-a to rail-d, rail-final), or a TOML file with a table [geometry].",
    ),
]
Flow = Annotated[str, typer.Option("--flow", metavar="FLOW", help="Flow (default: that of the pump).")]
Stub = Annotated[
    str,
    typer.Option("--stub", metavar="LENGTH", help="Length of the nozzles (default: 0.197 spool radii)."),
]


@dataclass(frozen=True)
class Valve:
    """Options: whose valve is computed, on which grid."""

    system: SystemName
    grid: Grid = "coarse"


@dataclass(frozen=True)
class Method:
    """Options: how the flow is computed, through which shape."""

    model: Model = "k-epsilon"
    scheme: Scheme = "second-order"
    shape: Shape = None
    settings: Settings = None


@dataclass(frozen=True)
class Work(Resumable):
    """Options: where a study is carried out, where it writes, and what is shown of it."""

    @contextmanager
    def place(self, verb: str, name: str) -> Iterator["Place"]:
        """The place of a study of `verb`, for as long as it is at work."""
        from vvdp.cfd.series import SeriesStopped, make_place
        from vvdp.cli.screen import say

        directory = self.directory(f"cfd-{name}")
        engine = self.engine(directory)
        make_place(directory, verb, force=self.force)
        try:
            with _progress() as hear:
                yield Place(directory, engine, hear)
        except SeriesStopped as stopped:
            say(f"interrupted: {stopped.words}; rerun the same command to resume")
            raise

    def finish(self, place: "Place", loaded: "System", result: "Result", *shown: str) -> None:
        """Writes a result, the system that it is of, and the page, and shows it."""
        from vvdp.cfd.solve import used_cores
        from vvdp.cli.report import CFD, add_report
        from vvdp.cli.screen import typed_command
        from vvdp.results.store import write_result
        from vvdp.systems.resolved import resolved_text

        cores = " and ".join(map(str, used_cores(place.directory))) or "not noted"
        result = replace(result, conditions={**result.conditions, "cores for each solver": cores})
        write_result(place.directory, result, resolved_text(loaded), typed_command())
        reported = not self.no_report and add_report(CFD, place.directory)
        show_result(result, place.directory, json=self.json, reported=reported, names=shown)


def write_fitted(directory: Path, system: str, method: Method, found: Iterable[str]) -> None:
    """Writes the system with what was found, and with the shape that it was found of."""
    from vvdp.base.files import write_listed, write_whole
    from vvdp.geometry.shape_tables import shape_settings
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    lengths = shape_settings(method.shape) if method.shape else ()
    settings = [*lengths, *(method.settings or ()), *found]
    with write_listed(directory, ["fitted.toml"]):
        write_whole(directory / "fitted.toml", resolved_text(load_system(system, settings)))


class Place(NamedTuple):
    """The directory of a study, the engine that carries it out, and receives how far it is."""

    directory: Path
    engine: "Engine"
    hear: "Callable[[Progress], None]"


def stretch(option: str, given: tuple[str, str, int], kind: "Kind", least: float) -> tuple[float, ...]:
    """Evenly spaced values of an option. Raises ConfigError where they are too few for a law, or out of order."""
    import numpy as np

    from vvdp.base.display import with_unit
    from vvdp.base.errors import ConfigError, Fault

    low, high = (parsed_option(option, text, kind) for text in given[:2])
    if not (least <= low < high and given[2] >= LEAST_RUNS):
        words = f"expected the lower value first, {with_unit(least, kind)} or more, and at least {LEAST_RUNS} values"
        raise ConfigError([Fault(option, 0, " ".join(map(str, given)), words)])
    return tuple(float(value) for value in np.linspace(low, high, given[2]))


def rail_order(chosen: Valve, method: Method, flow: str = "") -> "tuple[System, RailOrder, Told]":
    """A system, what is to be computed of it at a flow, that of its pump by default, and what is stated of it."""
    from vvdp.base.kinds import FLOW
    from vvdp.cfd.case import Fluid
    from vvdp.cfd.numerics import SCHEMES
    from vvdp.cfd.rail import RailOrder
    from vvdp.cfd.rail_result import Told
    from vvdp.cfd.turbulence import MODELS
    from vvdp.fluid.oil import density, dynamic_viscosity
    from vvdp.geometry.shape_tables import given_shape
    from vvdp.rigs.conditions import fluid
    from vvdp.steady.test_stand import stand
    from vvdp.systems.system import load_system

    own = [text for text in method.settings or () if text.strip().startswith("geometry.")]
    loaded = load_system(chosen.system, [text for text in method.settings or () if text not in own])
    held = stand(loaded, "cfd")
    oil, temperature, valve = held.bench.oil, held.set_point.oil_temperature, held.bench.valve
    made, rows = given_shape(valve, method.shape, own, loaded.lengths)
    order = RailOrder(
        valve=valve,
        shape=made,
        fluid=Fluid(float(density(temperature, oil)), float(dynamic_viscosity(temperature, oil))),
        flow=parsed_option("--flow", flow, FLOW) if flow else held.pump_flow(held.set_point),
        grid=_cells(chosen.grid),
        turbulence=choice("--turbulence", method.model, MODELS),
        phases=choice("--scheme", method.scheme, SCHEMES),
    )
    return loaded, order, Told(loaded.name, chosen.grid, fluid(held), rows)


def choice(option: str, name: str, known: "Mapping[str, T]") -> "T":
    """The value that an option names. Raises ConfigError where it is none of the known ones."""
    from vvdp.base.errors import ConfigError, Fault

    if name not in known:
        raise ConfigError([Fault(option, 0, "", f"{name!r}; expected one of {', '.join(known)}")])
    return known[name]


def _cells(grid: str) -> float:
    """Cells of the background per spool radius. Raises ConfigError for what is neither a grid nor such a number."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.cfd.rail import GRIDS

    with suppress(ValueError):
        if COARSEST <= float(grid) <= FINEST:
            return float(grid)
    if grid not in GRIDS:
        words = f"{grid!r}; expected one of {', '.join(GRIDS)}, or {COARSEST:g} to {FINEST:g} cells per spool radius"
        raise ConfigError([Fault("--grid", 0, "", words)])
    return GRIDS[grid]


@contextmanager
def _progress() -> "Iterator[Callable[[Progress], None]]":
    """Receives how far a run is: a bar on a terminal, now and then a line elsewhere."""
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
            state["reach"].move(now.done)

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


def centre_order(rail: "RailOrder", angle: float, stub: str = "") -> "CentreOrder":
    """The centre section to a rail, its nozzles as long as `--stub` says, the spool half-way along its stroke."""
    from vvdp.base.kinds import LENGTH
    from vvdp.cfd.centre import CentreOrder

    order = CentreOrder(
        valve=rail.valve,
        shape=rail.shape,
        fluid=rail.fluid,
        flow=rail.flow,
        angle=angle,
        position=0.5 * rail.valve.helix_length,
        grid=rail.grid,
        turbulence=rail.turbulence,
        phases=rail.phases,
    )
    return order._replace(stub=parsed_option("--stub", stub, LENGTH) / rail.valve.spool_radius) if stub else order


def turbine_order(rail: "RailOrder") -> "TurbineOrder":
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
        phases=rail.phases,
    )
