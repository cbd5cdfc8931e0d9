"""Everything that is made of a valve's shape: meshes, STEP files, volumes of oil, pictures, film, and the page.

spool.stl, sleeve.stl, *.glb    the parts, in metres
spool.step, sleeve.step         where asked for, in millimetres
oil/NAME.stl                    volumes of oil, a solid for each patch, in metres
oil/domains.json                of each: patches, areas, a point inside, which patches turn
geometry.toml                   the lengths with their origin
openings.csv                    open shares over a period, by formula and on the meshes
summary.json, meta.json, figures/, period.gif, report.html
"""

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import vvdp
from vvdp.base.errors import ParameterError
from vvdp.base.tables import Sourced
from vvdp.geometry.domains import TURNING, Domain, load_domains, rail_without_port, tank_domains
from vvdp.geometry.files import write_ascii_stl, write_binary_stl, write_glb
from vvdp.geometry.measure import Comparison, comparisons, openings_over_a_period
from vvdp.geometry.mesh import Floats, Mesh, components, genus, polar_moment, volume
from vvdp.geometry.shape import (
    ValveShape,
    shape_text,
    sleeve_half_length,
    sleeve_radius,
    spool_volume,
    stations,
    stroke,
)
from vvdp.geometry.solids import half_sleeve, sleeve, sleeve_part, spool, spool_part
from vvdp.report.drawing import Drawn
from vvdp.report.geometry_figures import (
    animation,
    oil_figure,
    openings_figure,
    patch_colour,
    solids_figure,
    unwrapped_figure,
)
from vvdp.report.geometry_report import FILM, Page, write_geometry_report
from vvdp.valve.geometry import nozzle_length, nozzle_width, pitch, port_openings, transition_fraction
from vvdp.valve.rotary import RotaryValve

ANGLES = 121
"""Spool angles over a period at which the meshes' openings are measured."""
Say = Callable[[str], None]


@dataclass(frozen=True)
class Order:
    """What is to be made."""

    title: str
    name: str
    valve: RotaryValve
    shape: ValveShape
    rows: tuple[Sourced, ...]
    angle: float
    position: float
    fineness: float
    frames: int
    step: bool
    report: bool = True


@dataclass
class Product:
    """What was made so far."""

    summary: dict[str, Any]
    comparisons: tuple[Comparison, ...] = ()
    bodies: list[tuple[str, float, int]] = field(default_factory=list)
    domains: list[Domain] = field(default_factory=list)
    drawn: list[Drawn] = field(default_factory=list)
    shut: list[str] = field(default_factory=list)
    finished: bool = True


def write_product(folder: Path, order: Order, say: Say) -> Product:
    """Makes everything and writes it into a folder; an interruption ends it early and keeps what is made."""
    product = Product(_lengths(order))
    (folder / "geometry.toml").write_text(shape_text(order.rows), encoding="utf-8")
    begun = time.perf_counter()
    try:
        for what, make in _steps(folder, order, product):
            say(what)
            make()
    except KeyboardInterrupt:
        product.finished = False
    s = product.summary
    s["finished"] = product.finished
    s["seconds"] = time.perf_counter() - begun
    (folder / "summary.json").write_text(json.dumps(s, indent=1) + "\n", encoding="utf-8")
    meta = {"vvdp": vvdp.__version__, "written": s["written"], "what": "geometry", "finished": product.finished}
    (folder / "meta.json").write_text(json.dumps(meta, indent=1) + "\n", encoding="utf-8")
    page = Page(
        order.title, s, product.comparisons, product.domains, product.drawn, order.rows, product.shut, product.finished
    )
    if order.report:
        write_geometry_report(folder, page)
    return product


def _lengths(order: Order) -> dict[str, Any]:
    valve, shape = order.valve, order.shape
    at = stations(shape, valve)
    lengths = {
        "duty_ratio": order.position / valve.helix_length,
        "axial_position_m": order.position,
        "spool_angle_rad": order.angle,
        "fineness": order.fineness,
        "pitch_m": pitch(valve),
        "nozzle_width_m": nozzle_width(valve),
        "nozzle_length_m": nozzle_length(valve),
        "transition_fraction": transition_fraction(valve),
        "stroke_m": stroke(shape, valve),
        "spool_diameter_m": 2.0 * valve.spool_radius,
        "spool_length_m": 2.0 * at.spool_end - valve.helix_length,
        "sleeve_diameter_m": 2.0 * sleeve_radius(shape),
        "sleeve_length_m": 2.0 * sleeve_half_length(shape, valve),
        "spool_mass_kg": shape.spool_density * spool_volume(shape, valve),
    }
    found: dict[str, Any] = {"system": order.name, "vvdp": vvdp.__version__}
    found["written"] = time.strftime("%Y-%m-%dT%H:%M:%S")
    return found | {key: float(value) for key, value in lengths.items()}


def _steps(folder: Path, order: Order, product: Product) -> Iterator[tuple[str, Callable[[], None]]]:
    """What is done, in words, and what does it."""
    valve, shape, fine, at = order.valve, order.shape, order.fineness, (order.angle, order.position)
    parts: dict[str, Mesh] = {}

    def unwrapped() -> None:
        product.drawn.append(unwrapped_figure(shape, valve, _telling_angle(order), order.position))

    def body(name: str, make: Callable[[ValveShape, RotaryValve, float], Mesh]) -> None:
        parts[name] = mesh = make(shape, valve, fine)
        _write_body(folder, name, mesh, product)

    def measured() -> None:
        spool_mesh, sleeve_mesh = parts["spool"], parts["sleeve"]
        s = product.summary
        s["spool_inertia_kg_m2"] = shape.spool_density * polar_moment(spool_mesh)
        product.comparisons = comparisons(shape, valve, spool_mesh, sleeve_mesh, rail_without_port(shape, valve, fine))
        for each in product.comparisons:
            stem, _, unit = each.key.rpartition("_")
            s[each.key], s[f"{stem}_measured_{unit}"] = each.formula, each.measured
        over = openings_over_a_period(spool_mesh, sleeve_mesh, order.position, valve, ANGLES)
        s["openings_difference"] = _write_openings(folder / "openings.csv", over, order)
        product.drawn.append(openings_figure(valve, order.position, over))

    def solids() -> None:
        product.drawn.append(solids_figure(parts["spool"], half_sleeve(shape, valve, fine)))

    yield "unwrapped surface", unwrapped
    yield "spool", lambda: body("spool", spool)
    yield "sleeve", lambda: body("sleeve", sleeve)
    yield "measuring", measured
    yield "pictures of the parts", solids
    for name, build in {**load_domains(shape, valve, *at, fine), **tank_domains(shape, valve, *at, fine)}.items():
        yield f"oil: {name}", partial(_oil, folder / "oil", name, build, product)
    yield "pictures of the oil", lambda: _draw_oil(product)
    if order.step:
        yield "STEP: spool", lambda: _write_step(folder, "spool", spool_part, order, product)
        yield "STEP: sleeve", lambda: _write_step(folder, "sleeve", sleeve_part, order, product)
    if order.frames:
        yield f"film of {order.frames} frames", lambda: _write_film(folder, order)


def _telling_angle(order: Order) -> float:
    """An angle at which the nozzles are closing: something to see of load, barrier and motion."""
    turn = 0.5 * order.position / order.valve.helix_length - 0.25 * transition_fraction(order.valve)
    return float(2.0 * np.pi / order.valve.sections * np.clip(turn, 0.0, 0.5))


def _write_body(folder: Path, name: str, mesh: Mesh, product: Product) -> None:
    write_binary_stl(folder / f"{name}.stl", mesh)
    write_glb(folder / f"{name}.glb", mesh, name, {patch: patch_colour(patch) for patch in mesh.names})
    product.bodies.append((name, volume(mesh), len(mesh.triangles)))
    product.summary[f"{name}_triangles"] = len(mesh.triangles)


def _write_openings(path: Path, over: Floats, order: Order) -> float:
    """Writes the table; the largest difference between formula and meshes."""
    formula = np.array([port_openings(float(angle), order.position, order.valve) for angle in over[:, 0]])
    head = "spool_angle_rad,load_formula,tank_formula,load_mesh,tank_mesh"
    rows = np.column_stack([over[:, 0], formula, over[:, 1:]])
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.9g")
    return float(abs(formula - over[:, 1:]).max())


def _oil(folder: Path, name: str, build: Callable[[], Domain], product: Product) -> None:
    try:
        domain = build()
    except ParameterError:
        if name.startswith("turbine") or name == "rail":
            raise  # these do not depend on the nozzles being open
        product.shut.append(name)
        return
    folder.mkdir(exist_ok=True)
    write_ascii_stl(folder / f"{name}.stl", domain.mesh)
    product.domains.append(domain)
    product.bodies.append((f"oil: {name}", domain.volume, len(domain.mesh.triangles)))
    product.summary[f"oil_{name.replace('-', '_')}_volume_m3"] = domain.volume
    described = {each.name: _described(each) for each in product.domains}
    (folder / "domains.json").write_text(json.dumps(described, indent=1) + "\n", encoding="utf-8")


def _described(domain: Domain) -> dict[str, Any]:
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


def _draw_oil(product: Product) -> None:
    if shown := [domain for domain in product.domains if not domain.name.endswith("-tank")]:
        product.drawn.append(oil_figure(shown))


def _write_step(folder: Path, name: str, make: Callable[..., Any], order: Order, product: Product) -> None:
    from vvdp.geometry.exact import Exact, write_step

    exact = write_step(folder / f"{name}.step", make(order.shape, order.valve, Exact()))
    product.summary[f"{name}_step_volume_m3"] = exact
    product.bodies.append((f"{name}, STEP", exact, 0))


def _write_film(folder: Path, order: Order) -> None:
    (folder / FILM).write_bytes(animation(order.shape, order.valve, order.position, order.frames))
