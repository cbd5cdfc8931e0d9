"""A valve's shape as a result: its lengths, formula against mesh, volumes of oil, and openings of the nozzles."""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    COUNT,
    DUTY_RATIO,
    EFFICIENCY,
    FRACTION,
    INERTIA,
    LENGTH,
    MASS,
    POSITION,
    VOLUME,
)
from vvdp.base.tables import Sourced
from vvdp.geometry.mesh import Floats
from vvdp.geometry.product import Order, Product
from vvdp.geometry.shape import sleeve_half_length, sleeve_radius, spool_volume, stations, stroke
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Listing, Number, Result, Row, Section, Table, numbers_of
from vvdp.valve.geometry import nozzle_length, nozzle_width, pitch, port_openings, transition_fraction

LEAD = (
    "Spool, sleeve and the oil between them, built from the parameters of the hydraulic model. The table compares what "
    "the finished meshes measure with what the formulas say; where they differ, facets stand for curves."
)
ORIGINS = (
    "No hydraulic formula uses these. They are assumed, so that the shape holds together and reproduces published "
    "areas, volume and drops as noted."
)
VOLUMES = {"rail": "inlet rail", "centre": "centre section", "turbine": "outlet turbine", "valve": "whole valve"}
MEASURED = {"without-spool": "sleeve without spool"}
"""Volumes of oil that are not on the way to the load, but in which a drop is measured."""
QUANTITIES = {
    "duty_ratio": (DUTY_RATIO, "duty ratio"),
    "axial_position_m": (POSITION, "axial position of the spool"),
    "spool_angle_rad": (ANGLE, "spool angle"),
    "fineness": (COUNT, "mesh edges per spool radius"),
    "pitch_m": (LENGTH, "pitch of the nozzles"),
    "nozzle_width_m": (LENGTH, "width of a nozzle"),
    "nozzle_length_m": (LENGTH, "length of a nozzle"),
    "transition_fraction": (FRACTION, "share of a PWM period in one transition"),
    "stroke_m": (LENGTH, "axial stroke"),
    "spool_diameter_m": (LENGTH, "diameter of the spool"),
    "spool_length_m": (LENGTH, "length of the spool"),
    "sleeve_diameter_m": (LENGTH, "diameter of the sleeve"),
    "sleeve_length_m": (LENGTH, "length of the sleeve"),
    "spool_mass_kg": (MASS, "mass of the spool"),
    "spool_inertia_kg_m2": (INERTIA, "moment of inertia of the spool"),
}
PLACED = ("duty_ratio", "axial_position_m", "spool_angle_rad", "fineness")
"""Numbers that say where the spool stands and how fine the meshes are."""


def geometry_result(order: Order, product: Product) -> Result:
    """Result of an order; the sections name drawings that the page has: view, solids, unwrapped, film, oil."""
    numbers = numbers_of(_lengths(order, product), QUANTITIES)
    openings = {"openings": _openings(product.openings, order)} if product.openings is not None else {}
    numbers |= dict(_measured_numbers(product))
    if openings:
        numbers["openings_difference"] = Number(_worst(openings["openings"]), FRACTION, "largest difference")
    listings = {"sizes": _sizes(numbers)}
    if openings:
        listings["comparison"] = _comparison(product, numbers["openings_difference"].value)
    return Result(
        verb="geometry",
        title="Shape of the valve",
        system=order.name,
        manner="Solids are cut and joined as closed meshes and then measured, independently of the formulas.",
        references=tuple(dict.fromkeys(each.source for each in order.rows if each.source)),
        conditions={QUANTITIES[key][1]: with_unit(numbers[key].value, QUANTITIES[key][0]) for key in PLACED},
        left_out=("Radial clearance in the volumes of oil: lands touch the sleeve.", "Leakage.", "Fillets and seals."),
        numbers=numbers,
        listings={**listings, "lengths": Listing(title="", heads=("value",), rows=origin_rows(order.rows))},
        tables={**openings, "bodies": _bodies(product), "patches": _patches(product)},
        charts={"openings-over-angle": _chart(openings["openings"])} if openings else {},
        findings=tuple(_findings(product, numbers)),
        sections=tuple(_sections(product)),
        seconds=product.seconds,
        finished=product.finished,
    )


def _lengths(order: Order, product: Product) -> dict[str, float]:
    valve, shape = order.valve, order.shape
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
        "spool_length_m": 2.0 * stations(shape, valve).spool_end - valve.helix_length,
        "sleeve_diameter_m": 2.0 * sleeve_radius(shape),
        "sleeve_length_m": 2.0 * sleeve_half_length(shape, valve),
        "spool_mass_kg": shape.spool_density * spool_volume(shape, valve),
    }
    return lengths if product.inertia is None else {**lengths, "spool_inertia_kg_m2": product.inertia}


def _measured_numbers(product: Product) -> Iterator[tuple[str, Number]]:
    """Compared quantities, by formula and as the meshes have them, and what the files enclose."""
    for each in product.comparisons:
        stem, _, unit = each.key.rpartition("_")
        yield each.key, Number(each.formula, each.kind, each.title)
        yield f"{stem}_measured_{unit}", Number(each.measured, each.kind, f"{each.title}, on the mesh")
    for body in product.bodies:
        stem, _, form = body.file.replace("/", "_").replace("-", "_").rpartition(".")
        if form == "step":
            yield f"{stem}_step_volume_m3", Number(body.volume, VOLUME, f"volume of {body.file}")
        elif stem.startswith("oil_"):
            yield f"{stem}_volume_m3", Number(body.volume, VOLUME, f"volume of {body.file}")
        else:
            yield f"{stem}_triangles", Number(float(body.triangles or 0), COUNT, f"triangles of {body.file}")


def _sizes(numbers: dict[str, Number]) -> Listing:
    rows = (
        Row(label, kind, (numbers[key].value,))
        for key, (kind, label) in QUANTITIES.items()
        if key not in PLACED and key in numbers
    )
    return Listing(title="Sizes", heads=("value",), rows=tuple(rows))


def _comparison(product: Product, worst: float) -> Listing:
    rows = [
        Row(each.title, each.kind, (each.formula, each.measured, _with_sign(each.difference)))
        for each in product.comparisons
    ]
    rows.append(Row("open fraction over a period, largest difference", FRACTION, ("", "", percent(worst, 3))))
    return Listing(title="", heads=("formula", "mesh", "difference"), rows=tuple(rows))


def _with_sign(share: float) -> str:
    return f"{'+' if share > 0.0 else ''}{percent(share, 3)}"


def _openings(over: Floats, order: Order) -> Table:
    """Open fractions of the nozzles over a period, by formula and on the meshes."""
    formula = np.array([port_openings(float(angle), order.position, order.valve) for angle in over[:, 0]])
    columns = {"spool_angle_rad": Column(over[:, 0], ANGLE, "spool angle")}
    for place, side in enumerate(("load", "tank")):
        columns[f"{side}_formula"] = Column(formula[:, place], FRACTION, f"{side}, formula")
        columns[f"{side}_mesh"] = Column(over[:, place + 1], FRACTION, f"{side}, mesh")
        difference = over[:, place + 1] - formula[:, place]
        columns[f"{side}_difference"] = Column(difference, EFFICIENCY, f"difference, {side}")
    return Table(title="Open fractions over a period", columns=columns, axes=("spool_angle_rad",), is_data=True)


def _worst(openings: Table) -> float:
    return float(max(abs(openings[f"{side}_difference"]).max() for side in ("load", "tank")))


def _chart(openings: Table) -> Chart:
    sides = (("load", Colour.LOAD), ("tank", Colour.TANK))
    left, right = (float(openings["spool_angle_rad"][end]) for end in (0, -1))
    lines = [Line(x="spool_angle_rad", y=f"{side}_formula", colour=colour) for side, colour in sides]
    lines += [
        Line(x="spool_angle_rad", y=f"{side}_mesh", colour=colour, stroke=Stroke.POINTS, width=0.8)
        for side, colour in sides
    ]
    below = (Line(x="spool_angle_rad", y=f"{side}_difference", label=side, colour=colour) for side, colour in sides)
    caption = (
        "Open fractions of the nozzle area over one PWM period: formula, and what the unwrapped meshes of spool and "
        f"sleeve leave open. They differ by at most {percent(_worst(openings), 2)} of the nozzle area, as facets "
        "differ from curves."
    )
    return Chart(
        name="openings-over-angle",
        caption=caption,
        table="openings",
        panels=(
            Lines(lines=tuple(lines), label="open fraction", low=-0.04, high=1.04, left=left, right=right, height=2.0),
            Lines(lines=tuple(below), label="difference", left=left, right=right),
        ),
        height=3.4,
    )


def _bodies(product: Product) -> Table:
    triangles = [math.nan if body.triangles is None else float(body.triangles) for body in product.bodies]
    return Table(
        title="Solids and their files",
        columns={
            "body": Column(np.array([_body_name(body.file) for body in product.bodies], str), None, ""),
            "file": Column(np.array([body.file for body in product.bodies], str), None, "file"),
            "volume_m3": Column(np.array([body.volume for body in product.bodies], float), VOLUME, "volume"),
            "triangles": Column(np.array(triangles, float), COUNT, "triangles"),
        },
    )


def _body_name(file: str) -> str:
    """The content of a file, in words."""
    name = file.rpartition(".")[0]
    return f"oil: {_volume_name(name.removeprefix('oil/'))}" if name.startswith("oil/") else name


def _volume_name(name: str) -> str:
    """The name of a volume of oil."""
    return {**VOLUMES, **MEASURED}[name.removesuffix("-tank")] + (" of the tank" if name.endswith("-tank") else "")


def _patches(product: Product) -> Table:
    found = [(each.name, *patch) for each in product.domains for patch in sorted(each.areas.items())]
    names, patches, areas = zip(*found, strict=True) if found else ((), (), ())
    return Table(
        title="Patches of the volumes of oil",
        columns={
            "volume": Column(np.array([_volume_name(name) for name in names], str), None, "volume"),
            "patch": Column(np.array(patches, str), None, "patch"),
            "area_m2": Column(np.array(areas, float), AREA, "area"),
        },
    )


def origin_rows(lengths: Iterable[Sourced]) -> tuple[Row, ...]:
    """A line for each length, with its origin in words."""
    return tuple(
        Row(each.key, each.kind, (each.value,), note=_origin(each)) for each in lengths if isinstance(each.value, float)
    )


def _origin(length: Sourced) -> str:
    source = " ".join(filter(None, (length.source, length.where)))
    return "; ".join(filter(None, (length.status, source, length.note)))


def _findings(product: Product, numbers: dict[str, Number]) -> Iterator[Finding]:
    if product.comparisons:
        worst = max(abs(each.difference) for each in product.comparisons)
        shares = numbers["openings_difference"].value
        yield Finding(
            text=f"The meshes agree with the formulas to {percent(worst, 2)}, and the open fraction of the nozzles to "
            f"{percent(shares, 2)}."
        )
    if product.closed:
        names = " and ".join(_volume_name(name) for name in product.closed)
        yield Finding(text=f"Not made, as the nozzles are closed to this side here: {names}.")


def _sections(product: Product) -> Iterator[Section]:
    compared = ("comparison", "openings-over-angle") if product.comparisons else ()
    yield Section(title="Formula and mesh", words=(LEAD,), shows=compared)
    yield Section(title="Spool and sleeve", shows=("view", "solids", "unwrapped", "sizes"), starts_page=True)
    if product.has_film:
        yield Section(title="One PWM period", shows=("film",))
    if product.domains:
        yield Section(title="Volumes of oil", shows=("oil", "patches"), starts_page=True)
    if product.bodies:
        yield Section(title="Files", shows=("bodies",))
    yield Section(title="Lengths that only the shape needs", words=(ORIGINS,), shows=("lengths",), starts_page=True)
    yield Section(title="How it was done", shows=("conditions",))
