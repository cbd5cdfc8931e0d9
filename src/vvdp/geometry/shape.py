"""What the solids of a rotary valve need beyond its hydraulic model, and the lengths that follow."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import LENGTH, Area, Count, Kind, Length, Position, Ratio, Volume
from vvdp.base.params import Params, field_kinds
from vvdp.base.tables import Sourced, Table, build, parsed_table, read_table, with_settings
from vvdp.geometry.kernel import Floats
from vvdp.valve.geometry import barrier_width, helix_slope, nozzle_length, nozzle_width
from vvdp.valve.rotary import RotaryValve

FixedAngle = Annotated[float, Kind("angle", "rad", 0.0, 2.0 * np.pi, "60 deg", units=("deg", "rad"))]
MaterialDensity = Annotated[float, Kind("density of a material", "kg/m^3", 500.0, 25000.0, "7850 kg/m^3")]

PROTOTYPE_RADIUS = 12.7e-3
"""The spool radius [m] that the shipped lengths belong to."""


class ValveShape(Params):
    """Dimensions of spool and sleeve that no hydraulic formula uses.

    Along the spool, from the barriers' tips outwards on either side: `pocket_gap`, a land of `window_length` with as
    many windows as sections, each `window_half_angle` to either side, `ring_length`, then the annular chamber of the
    outlet turbine, whose shell carries `outlet_blades` straight channels. Channels and nozzles are tangent to circles
    of radius `outlet_arm` and `nozzle_arm`; their tapers are entry over mouth, for nozzles at the rail's centre line.
    `stroke_ratio` is the axial travel that the outlet grooves allow, over the helix length.
    """

    hub_radius: Length
    pocket_gap: Length
    window_length: Length
    window_half_angle: FixedAngle
    ring_length: Length
    chamber_inner_radius: Length
    chamber_outer_radius: Length
    outlet_blades: Count
    outlet_height: Length
    outlet_arm: Length
    outlet_entry_taper: Ratio
    stroke_ratio: Ratio
    seal_length: Length
    groove_depth: Length
    groove_margin: Length
    collector_radius: Length
    collector_diameter: Length
    collector_port_diameter: Length
    nozzle_arm: Length
    nozzle_taper: Ratio
    rail_radius: Length
    rail_diameter: Length
    rail_lead: FixedAngle
    rail_tail: FixedAngle
    rail_port_diameter: Length
    port_length: Length
    sleeve_wall: Length
    spool_density: MaterialDensity

    def check(self) -> None:
        """Refuse lengths that are not there, and blades that are no number of blades."""
        for name in (field.name for field in fields(self)):
            if name not in ("stroke_ratio", "rail_tail") and not getattr(self, name) > 0.0:
                raise ParameterError(f"ValveShape.{name} must be greater than zero")
        if self.outlet_blades != round(self.outlet_blades):
            raise ParameterError(f"ValveShape.outlet_blades = {self.outlet_blades:g}; expected a whole number")


class Stations(NamedTuple):
    """Axial positions of the load side along the spool [m]; apexes of the barriers' centre lines at 0 and L."""

    tip: Position
    pocket_end: Position
    window_end: Position
    ring_end: Position
    channel_start: Position
    chamber_end: Position
    spool_end: Position


def stations(shape: ValveShape, valve: RotaryValve) -> Stations:
    """Axial positions of the load side along the spool [m]; the tank side is its mirror image about L/2.

    Chamber and end land are as long as the stroke asks: pocket and outlet groove stay apart by the sealing length,
    and the end land of `land_length` stays whole.

    Source  ours, docs/models/geometry.md
    """
    tip = valve.helix_length + 0.5 * barrier_width(valve) * helix_slope(valve)
    pocket_end = tip + shape.pocket_gap
    window_end = pocket_end + shape.window_length
    ring_end = window_end + shape.ring_length
    travel = stroke(shape, valve) + shape.groove_margin
    channel_start = ring_end + travel + shape.seal_length
    chamber_end = channel_start + shape.outlet_height
    spool_end = chamber_end + travel + valve.land_length
    return Stations(
        tip=float(tip),
        pocket_end=float(pocket_end),
        window_end=float(window_end),
        ring_end=float(ring_end),
        channel_start=float(channel_start),
        chamber_end=float(chamber_end),
        spool_end=float(spool_end),
    )


def stroke(shape: ValveShape, valve: RotaryValve) -> float:
    """Axial travel of the spool that the sleeve allows [m], to equal parts on both sides of duty ratio 1/2.

    Source  ours, docs/models/geometry.md
    """
    return shape.stroke_ratio * valve.helix_length


def collector_position(shape: ValveShape, valve: RotaryValve) -> float:
    """Distance of either outlet collector from the plane of the nozzles [m].

    Source  ours, docs/models/geometry.md
    """
    at = stations(shape, valve)
    return 0.5 * (at.channel_start + at.chamber_end - valve.helix_length)


def groove_length(shape: ValveShape, valve: RotaryValve) -> float:
    """Axial length of an outlet groove [m].

    Source  ours, docs/models/geometry.md
    """
    return shape.outlet_height + stroke(shape, valve) + 2.0 * shape.groove_margin


def sleeve_half_length(shape: ValveShape, valve: RotaryValve) -> float:
    """Half the length of the sleeve [m].

    Source  ours, docs/models/geometry.md
    """
    return collector_position(shape, valve) + 0.5 * groove_length(shape, valve) + valve.land_length


def sleeve_radius(shape: ValveShape) -> float:
    """Outer radius of the sleeve [m].

    Source  ours, docs/models/geometry.md
    """
    return shape.sleeve_wall + max(
        shape.rail_radius + 0.5 * shape.rail_diameter, shape.collector_radius + 0.5 * shape.collector_diameter
    )


def outlet_width(shape: ValveShape, valve: RotaryValve) -> float:
    """Width of one outlet channel at its mouth, perpendicular to its jet, A_out/(N_b h) [m].

    Source  ours, docs/models/geometry.md
    """
    return valve.outlet_area / (shape.outlet_blades * shape.outlet_height)


def nozzle_reach(shape: ValveShape, valve: RotaryValve) -> float:
    """Length of a nozzle's axis from bore to the rail's centre line, sqrt(R_r^2 - e^2) - sqrt(R^2 - e^2) [m].

    Source  ours, docs/models/geometry.md
    """
    arm = shape.nozzle_arm
    reach: float = np.sqrt(shape.rail_radius**2 - arm**2) - np.sqrt(valve.spool_radius**2 - arm**2)
    return reach


def nozzle_lag(shape: ValveShape, valve: RotaryValve) -> float:
    """Angle by which a nozzle's mouth lies ahead of its root on the rail's centre line [rad].

    Source  ours, docs/models/geometry.md
    """
    lag: float = np.arccos(shape.nozzle_arm / shape.rail_radius) - np.arccos(shape.nozzle_arm / valve.spool_radius)
    return lag


def perpendicular_area(shape: ValveShape, valve: RotaryValve) -> Area:
    """Section of all jets perpendicular to them, A_in sqrt(1 - (e/R)^2) [m^2].

    The nozzle area of the hydraulic model is that of the openings in the bore.

    Source  ours, docs/models/geometry.md
    """
    return float(valve.nozzle_area * np.sqrt(1.0 - (shape.nozzle_arm / valve.spool_radius) ** 2))


def rail_volume(shape: ValveShape, valve: RotaryValve) -> Volume:
    """Volume of inlet rail and nozzles without the port [m^3].

    V = pi r^2 R_r phi + 4/3 pi r^3 + N V_n: arc, both hemispheres, and of each nozzle what lies between bore and rail.
    V_n sums thin pyramids along the jet over the mouth, x = m_0 + t j + (1 + g t) (m - m_0), from t = 0 to the wall:
    V_n = integral of (m_u x m_z) . (j + g (m - m_0)) ((1 + g t)^3 - 1)/(3 g) over the rhombus, by Gauss's rule.

    Source  ours, docs/models/geometry.md
    """
    R, arm, r = valve.spool_radius, shape.nozzle_arm, 0.5 * shape.rail_diameter
    width, length = nozzle_width(valve), nozzle_length(valve)
    growth = (shape.nozzle_taper - 1.0) / nozzle_reach(shape, valve)
    jet = np.array([np.sqrt(1.0 - (arm / R) ** 2), -arm / R, 0.0])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    nozzle = 0.0
    for a, weight_a in zip(0.5 + 0.5 * nodes, 0.5 * weights, strict=True):
        for b, weight_b in zip(0.5 + 0.5 * nodes, 0.5 * weights, strict=True):
            turn, z = 0.5 * width * (a - b) / R, 0.5 * length * (a + b - 1.0)
            off = np.array([R * np.cos(turn) - R, R * np.sin(turn), z])
            out = np.array([np.cos(turn), np.sin(turn), 0.0])  # m_u x m_z of a cylinder
            t = _way_to_rail(np.array([R, 0.0, 0.0]) + off, jet + growth * off, shape.rail_radius, r)
            deep = t if growth == 0.0 else ((1.0 + growth * t) ** 3 - 1.0) / (3.0 * growth)
            nozzle += weight_a * weight_b * 0.5 * width * length * float(out @ (jet + growth * off)) * deep
    arc = np.pi * r**2 * shape.rail_radius * rail_arc(shape, valve)
    return float(arc + 4.0 / 3.0 * np.pi * r**3 + valve.sections * nozzle)


def _way_to_rail(start: Floats, direction: Floats, rail_radius: float, r: float) -> float:
    """The least t at which start + t direction enters the torus, by bisection after the first step within."""

    def outside(t: float) -> bool:
        x, y, z = start + t * direction
        return bool((np.hypot(x, y) - rail_radius) ** 2 + z**2 > r**2)

    low, high, step = 0.0, 0.0, 0.02 * rail_radius
    while outside(high):
        low, high = high, high + step
        if high > 2.0 * rail_radius:
            raise ParameterError("a nozzle does not meet the rail")
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if outside(middle) else (low, middle)
    return high


def spool_volume(shape: ValveShape, valve: RotaryValve) -> Volume:
    """Volume of the spool's material [m^3].

    Flanks and windows are radial, so what they leave open between hub and surface is (R^2 - r_h^2)/2 times an angle
    times a length; with the pocket's end at z_p, the apex of its edges at z_a, on each side
    pockets 2 pi (z_p - z_a - L/2), windows N 2 W l_w, ring 2 pi l_r; then chambers, and channels as wide as half-way.

    Source  ours, docs/models/geometry.md
    """
    R, at, L = valve.spool_radius, stations(shape, valve), valve.helix_length
    apex = at.tip - L
    open_length = at.pocket_end - apex - 0.5 * L + shape.ring_length
    windows = valve.sections * 2.0 * shape.window_half_angle * shape.window_length
    pockets = 0.5 * (R**2 - shape.hub_radius**2) * (2.0 * np.pi * open_length + windows)
    outer, arm = shape.chamber_outer_radius, shape.outlet_arm
    chamber = np.pi * (outer**2 - shape.chamber_inner_radius**2) * (at.chamber_end - at.ring_end)
    wall = np.sqrt(R**2 - arm**2) - np.sqrt(outer**2 - arm**2)
    channels = valve.outlet_area * 0.5 * (1.0 + shape.outlet_entry_taper) * wall
    whole = np.pi * R**2 * (2.0 * at.spool_end - L)
    return float(whole - 2.0 * (pockets + chamber + channels))


def rail_arc(shape: ValveShape, valve: RotaryValve) -> float:
    """Angle from the port to the other end of the rail's centre line [rad].

    Source  ours, docs/models/geometry.md
    """
    return float(shape.rail_lead + (valve.sections - 1.0) * 2.0 * np.pi / valve.sections + shape.rail_tail)


def require_makeable(shape: ValveShape, valve: RotaryValve) -> None:
    """Raises ParameterError with everything that contradicts itself in the two, with numbers."""
    if found := list(contradictions(shape, valve)):
        raise ParameterError("\n".join(found))


def contradictions(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Everything for which valve and shape together cannot be made, with numbers."""
    yield from _spool_faults(shape, valve)
    yield from _channel_faults(shape, valve)
    yield from _duct_faults(shape, valve)
    yield from _wall_faults(shape, valve)


def _at_most(name: str, value: float, bound: float, what: str) -> Iterator[str]:
    if not value < bound:
        yield f"{name} = {_mm(value)}; expected less than {_mm(bound)}, {what}"


def _at_least(name: str, value: float, bound: float, what: str) -> Iterator[str]:
    if not value > bound:
        yield f"{name} = {_mm(value)}; expected more than {_mm(bound)}, {what}"


def _spool_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of barriers, pockets, shell and windows."""
    R, N = valve.spool_radius, valve.sections
    pitch = 2.0 * np.pi * R / N
    yield from _at_most("nozzle width", nozzle_width(valve), pitch, "the pitch")
    thickness = barrier_width(valve) * helix_slope(valve) / np.hypot(1.0, helix_slope(valve))
    gap = 2.0 * valve.radial_clearance
    yield from _at_least("barrier width across", thickness, gap, "twice the radial clearance (lap ratio too small)")
    yield from _at_most("hub_radius", shape.hub_radius, R, "the spool radius (no pocket left)")
    yield from _at_most(
        "chamber_inner_radius", shape.chamber_inner_radius, shape.chamber_outer_radius, "its outer radius"
    )
    yield from _at_most(
        "chamber_outer_radius", shape.chamber_outer_radius, R, "the spool radius (the shell has no wall)"
    )
    yield from _at_least("chamber_outer_radius", shape.chamber_outer_radius, shape.hub_radius, "the hub radius")
    if not N * 2.0 * shape.window_half_angle < 0.98 * 2.0 * np.pi:
        total = np.degrees(2.0 * N * shape.window_half_angle)
        yield f"the {N:g} windows together take {total:.3g} deg; expected less than 353 deg"


def _channel_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of nozzles and outlet channels."""
    R = valve.spool_radius
    width = outlet_width(shape, valve) * max(shape.outlet_entry_taper, 1.0)
    yield from _at_most(
        "outlet_arm and half a channel",
        shape.outlet_arm + 0.5 * width,
        shape.chamber_outer_radius,
        "the chamber's outer radius (the jets would miss it)",
    )
    if shape.outlet_arm < shape.chamber_outer_radius:
        slope = np.sqrt(1.0 - (shape.outlet_arm / shape.chamber_outer_radius) ** 2)
        room = 2.0 * np.pi * shape.chamber_outer_radius * slope / shape.outlet_blades
        yield from _at_most("width of an outlet channel", width, 0.95 * room, "what its share of the shell leaves")
    at = stations(shape, valve)
    end = 0.5 * (valve.helix_length + stroke(shape, valve)) + 0.5 * nozzle_length(valve)
    yield from _at_most(
        "upper corner of a nozzle at the end of the stroke",
        end,
        at.pocket_end,
        "the end of the pockets (pocket_gap too small for the stroke)",
    )
    yield from _at_most("nozzle_arm", shape.nozzle_arm, 0.97 * R, "97 % of the spool radius (the jets would miss it)")
    if shape.nozzle_taper < 1.0:
        yield f"nozzle_taper = {shape.nozzle_taper:g}; expected 1 or more, wider at the root"
    root = shape.nozzle_taper * nozzle_length(valve)
    yield from _at_most(
        "length of a nozzle's root", root, shape.rail_diameter, "the rail diameter (it would stick out)"
    )
    yield from _at_most(
        "nozzle width at the root", shape.nozzle_taper * nozzle_width(valve), shape.rail_diameter, "the rail diameter"
    )


def _duct_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of inlet rail and collector."""
    R, rail, collector = valve.spool_radius, 0.5 * shape.rail_diameter, 0.5 * shape.collector_diameter
    yield from _at_least(
        "inside of the rail",
        shape.rail_radius - rail,
        R + 0.05 * R,
        "1.05 spool radii (the rail would open into the spool)",
    )
    ends = 2.0 * np.arcsin(min(rail / shape.rail_radius, 1.0))
    if not rail_arc(shape, valve) + ends < 2.0 * np.pi:
        yield (
            f"the rail spans {np.degrees(rail_arc(shape, valve) + ends):.4g} deg with its ends; expected less than "
            "360 deg (rail_lead and rail_tail too large)"
        )
    yield from _at_most("rail_port_diameter", shape.rail_port_diameter, shape.rail_diameter, "the rail diameter")
    yield from _at_most(
        "collector_port_diameter", shape.collector_port_diameter, shape.collector_diameter, "the collector diameter"
    )
    yield from _at_most(
        "inside of the collector",
        shape.collector_radius - collector,
        R + shape.groove_depth,
        "spool radius and groove_depth (it would not meet the groove)",
    )
    yield from _at_least(
        "collector_radius", shape.collector_radius, R + shape.groove_depth, "spool radius and groove_depth"
    )


def _wall_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of what is left between the hollow spaces, and outside them."""
    rail, collector = 0.5 * shape.rail_diameter, 0.5 * shape.collector_diameter
    apart = collector_position(shape, valve) - collector - rail
    yield from _at_least("wall between inlet rail and collector", apart, 0.0, "zero")
    reach = sleeve_half_length(shape, valve) - collector_position(shape, valve) - collector
    yield from _at_least("wall between collector and end of the sleeve", reach, 0.0, "zero")
    yield from _at_least(
        "rail_radius and port_length",
        shape.rail_radius + shape.port_length,
        sleeve_radius(shape),
        "the sleeve's outer radius (the port would end inside)",
    )
    yield from _at_least(
        "collector_radius and port_length",
        shape.collector_radius + shape.port_length,
        sleeve_radius(shape),
        "the sleeve's outer radius (the port would end inside)",
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


def prototype_table() -> Table:
    """The shipped table of shapes, with the origin of each value."""
    text = (resources.files("vvdp.geometry") / "prototype.toml").read_text("utf-8")
    return parsed_table(text, "prototype.toml")


def valve_shape(
    valve: RotaryValve, given: Mapping[str, Any] | None = None, origin: Table | None = None
) -> tuple[ValveShape, tuple[Sourced, ...]]:
    """The shape for a valve and the origin of its values: those `given` as a table holds them, others as shipped.

    Shipped lengths are in proportion to the spool radius. Raises ConfigError with all faults.
    """
    shipped = prototype_table()
    faults: list[Fault] = []
    given = given or {}
    entries = {**shipped.content["geometry"], **given}
    shape, rows = build(ValveShape, entries, "geometry", origin or shipped, faults)
    if shape is None:
        raise ConfigError(faults)
    factor = valve.spool_radius / PROTOTYPE_RADIUS
    if abs(factor - 1.0) > 1e-12:
        scaled = {key for key, kind in field_kinds(ValveShape).items() if kind is LENGTH and key not in given}
        shape = replace(shape, **{key: factor * getattr(shape, key) for key in scaled})
        rows = [_scale(row, factor) if row.key in scaled else row for row in rows]
    if found := [Fault("geometry", 0, "", message) for message in contradictions(shape, valve)]:
        raise ConfigError(found)
    return shape, tuple(rows)


def _scale(row: Sourced, factor: float) -> Sourced:
    assert isinstance(row.value, float)
    note = f"{row.note}; " if row.note else ""
    return replace(row, value=factor * row.value, note=f"{note}{factor:.4g} times the prototype's")


def given_shape(
    valve: RotaryValve, path: Path | None, settings: Sequence[str]
) -> tuple[ValveShape, tuple[Sourced, ...]]:
    """The shape from a file with a table [geometry] and from settings `geometry.key=value`; both may be absent.

    Raises ConfigError with all faults.
    """
    table = Table("geometry", {}, {}) if path is None else read_table(path)
    if more := sorted(set(table.content) - {"geometry"}):
        raise ConfigError(
            [Fault(table.place, table.lines.get(key, 0), key, "expected [geometry] only") for key in more]
        )
    table = with_settings(table, list(settings))
    given = table.content.get("geometry", {})
    if not isinstance(given, Mapping):
        raise ConfigError([Fault(table.place, table.lines.get("geometry", 0), "geometry", "is not a table")])
    return valve_shape(valve, given, table)


def shape_text(rows: Sequence[Sourced]) -> str:
    """The lengths as a file that `given_shape` reads, with their origin; given thus, none follows the spool radius."""
    lines = ["[geometry]"]
    for each in rows:
        unit = "" if each.kind.unit == "1" else f" {each.kind.unit}"
        words = {word: getattr(each, word) for word in ("status", "source", "where", "note") if getattr(each, word)}
        more = "".join(f", {word} = {json.dumps(text, ensure_ascii=False)}" for word, text in words.items())
        lines.append(f'{each.key} = {{ value = "{each.value!r}{unit}"{more} }}')
    return "\n".join(lines) + "\n"
