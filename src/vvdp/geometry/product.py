"""Everything that is made of a valve's shape as files, and what was found on the way.

spool.stl, sleeve.stl, *.glb    the parts, in metres
spool.step, sleeve.step         where asked for, in millimetres
oil/NAME.stl                    volumes of oil, a solid for each patch, in metres
oil/domains.json                of each: patches, areas, a point inside, which patches turn
geometry.toml                   the lengths with their origin
period.gif                      one PWM period as a film
"""

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.tables import Sourced
from vvdp.geometry.domains import TURNING, Domain, load_domains, rail_without_port, tank_domains
from vvdp.geometry.files import write_ascii_stl, write_binary_stl, write_glb
from vvdp.geometry.measure import Comparison, comparisons, openings_over_a_period
from vvdp.geometry.mesh import Floats, Mesh, components, genus, polar_moment, volume
from vvdp.geometry.shape import ValveShape
from vvdp.geometry.shape_tables import shape_text
from vvdp.geometry.solids import sleeve, sleeve_part, spool, spool_part
from vvdp.valve.rotary import RotaryValve

SHAPE, FILM = "geometry.toml", "period.gif"
ANGLES = 121
"""Spool angles over a period at which the meshes' openings are measured."""


@dataclass(frozen=True, kw_only=True)
class Order:
    """An order: a valve's shape with the origin of its lengths, the spool at `angle` and `position`."""

    name: str
    valve: RotaryValve
    shape: ValveShape
    rows: tuple[Sourced, ...]
    angle: float
    position: float
    fineness: float
    step: bool = False


class Body(NamedTuple):
    """A closed volume [m^3] in a file; a STEP file has no triangles."""

    file: str
    volume: float
    triangles: int | None


@dataclass
class Product:
    """The products made so far."""

    bodies: list[Body] = field(default_factory=list)
    inertia: float | None = None
    comparisons: tuple[Comparison, ...] = ()
    openings: Floats | None = None
    """Spool angle [rad] and what the meshes leave open to load and tank, over a period."""
    domains: list[Domain] = field(default_factory=list)
    closed: list[str] = field(default_factory=list)
    """Volumes that are not there, as the nozzles are closed to their side."""
    has_film: bool = False
    finished: bool = True
    seconds: float = 0.0


def make_product(
    folder: Path, order: Order, say: Callable[[str], None], film: Callable[[], bytes] | None = None
) -> Product:
    """Makes everything and writes it into a folder; an interruption ends it early and keeps what is made.

    `film` gives one PWM period as GIF; `say` receives what is being made.
    """
    product = Product()
    (folder / SHAPE).write_text(shape_text(order.rows), encoding="utf-8")
    begun = time.perf_counter()
    try:
        for what, make in _steps(folder, order, product):
            say(what)
            make()
        if film:
            say("film")
            (folder / FILM).write_bytes(film())
            product.has_film = True
    except KeyboardInterrupt:
        product.finished = False
    product.seconds = time.perf_counter() - begun
    return product


def _steps(folder: Path, order: Order, product: Product) -> Iterator[tuple[str, Callable[[], None]]]:
    """Steps of the work: words for each, and the function that does it."""
    valve, shape, fine, at = order.valve, order.shape, order.fineness, (order.angle, order.position)
    parts: dict[str, Mesh] = {}

    def body(name: str, make: Callable[[ValveShape, RotaryValve, float], Mesh]) -> None:
        parts[name] = mesh = make(shape, valve, fine)
        _write_body(folder, name, mesh, product)

    yield "spool", lambda: body("spool", spool)
    yield "sleeve", lambda: body("sleeve", sleeve)
    yield "measuring", lambda: _measure(parts["spool"], parts["sleeve"], order, product)
    for name, build in {**load_domains(shape, valve, *at, fine), **tank_domains(shape, valve, *at, fine)}.items():
        yield f"oil: {name}", partial(_write_oil, folder / "oil", name, build, product)
    if order.step:
        yield "STEP: spool", lambda: _write_step(folder, "spool", spool_part, order, product)
        yield "STEP: sleeve", lambda: _write_step(folder, "sleeve", sleeve_part, order, product)


def _write_body(folder: Path, name: str, mesh: Mesh, product: Product) -> None:
    write_binary_stl(folder / f"{name}.stl", mesh)
    write_glb(folder / f"{name}.glb", mesh, name)
    product.bodies.append(Body(f"{name}.stl", volume(mesh), len(mesh.triangles)))


def _measure(spool_mesh: Mesh, sleeve_mesh: Mesh, order: Order, product: Product) -> None:
    valve, shape = order.valve, order.shape
    rail = rail_without_port(shape, valve, order.fineness)
    product.inertia = shape.spool_density * polar_moment(spool_mesh)
    product.comparisons = comparisons(shape, valve, spool_mesh, sleeve_mesh, rail)
    product.openings = openings_over_a_period(spool_mesh, sleeve_mesh, order.position, valve, ANGLES)


def _write_oil(folder: Path, name: str, build: Callable[[], Domain], product: Product) -> None:
    try:
        domain = build()
    except ParameterError:
        if not name.startswith(("centre", "valve")):
            raise  # others do not depend on the nozzles being open
        product.closed.append(name)
        return
    folder.mkdir(exist_ok=True)
    write_ascii_stl(folder / f"{name}.stl", domain.mesh)
    product.domains.append(domain)
    product.bodies.append(Body(f"oil/{name}.stl", domain.volume, len(domain.mesh.triangles)))
    described = {each.name: _describe(each) for each in product.domains}
    (folder / "domains.json").write_text(json.dumps(described, indent=1) + "\n", encoding="utf-8")


def _describe(domain: Domain) -> dict[str, Any]:
    low, high = domain.mesh.vertices.min(0), domain.mesh.vertices.max(0)
    return {
        "file": f"{domain.name}.stl",
        "length_unit": "m",
        "inside_m": domain.inside,
        "low_m": low.tolist(),
        "high_m": high.tolist(),
        "volume_m3": domain.volume,
        "components": components(domain.mesh),
        "genus": genus(domain.mesh),
        "patch_area_m2": domain.areas,
        "turning_patches": [name for name in domain.mesh.names if name in TURNING],
    }


def _write_step(folder: Path, name: str, make: Callable[..., Any], order: Order, product: Product) -> None:
    from vvdp.geometry.exact import Exact, write_step

    enclosed = write_step(folder / f"{name}.step", make(order.shape, order.valve, Exact()))
    product.bodies.append(Body(f"{name}.step", enclosed, None))
