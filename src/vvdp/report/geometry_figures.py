"""Drawings of the valve's shape: the unwrapped spool below its nozzles, solids, oil, and one PWM period as a film."""

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.display import plain, with_unit
from vvdp.base.kinds import ANGLE, VOLUME
from vvdp.geometry.files import patch_colour
from vvdp.geometry.mesh import Floats, Mesh, volume
from vvdp.geometry.shape import ValveShape, stations
from vvdp.geometry.unrolled import Points, nozzle_outline, open_parts
from vvdp.report.drawing import INK, INLET, LOAD, PAGE_WIDTH, STYLE, TANK, Drawn, draw_figure, legend
from vvdp.report.shading import lying_frame, shade, view_frame
from vvdp.valve.geometry import (
    barrier_width,
    helix_slope,
    nozzle_length,
    nozzle_width,
    pitch,
    port_openings,
    transition_fraction,
)
from vvdp.valve.rotary import RotaryValve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MM = 1e3
METAL, EDGE, PALE_LOAD, PALE_TANK = "#aab1b8", "#6b747d", "#d3dce8", "#e4f1f9"
FILM_DOTS = 110
LARGEST_PICTURE = 1100


def unwrapped_figure(shape: ValveShape, valve: RotaryValve, position: float) -> Drawn:
    """The spool's surface rolled out below the nozzles while these close, with the lengths that name it."""
    duty, angle = position / valve.helix_length, telling_angle(valve, position)

    def draw(figure: "Figure") -> None:
        axes = figure.subplots()
        _surface(axes, shape, valve, angle)
        _nozzles(axes, valve, angle, position)
        _lengths(axes, valve, _shift(valve, angle), position)

    caption = (
        f"The spool's surface, rolled out, below the {valve.sections:g} nozzles at duty ratio {plain(duty, 3)} and a "
        f"spool angle of {with_unit(angle, ANGLE, 3)}. Barriers (dark grey) part pockets that lead to the load from "
        "pockets that lead to the tank; the spool turns to the right and moves up or down to set the duty ratio."
    )
    return draw_figure("unwrapped", caption, 3.9, draw)


def telling_angle(valve: RotaryValve, position: float) -> float:
    """A spool angle [rad] at which the nozzles are closing: something to see of load, barrier and motion."""
    turn = 0.5 * position / valve.helix_length - 0.25 * transition_fraction(valve)
    return float(2.0 * np.pi / valve.sections * np.clip(turn, 0.0, 0.5))


def solids_figure(spool: Mesh, half_sleeve: Mesh) -> Drawn:
    """Spool and cut sleeve, shaded."""

    def draw(figure: "Figure") -> None:
        above, below = figure.subplots(2, 1, height_ratios=(0.45, 1.0))
        draw_solids(above, [spool], lying_frame(20.0, 30.0))
        draw_solids(below, [half_sleeve], lying_frame(30.0, 30.0))
        above.set_title("spool", loc="left")
        below.set_title("sleeve, cut in half", loc="left")

    caption = (
        "Spool: zig-zag barriers in the middle; on either side windows (sand), the outlet turbine's chamber (light "
        "blue) under its shell, and the turbine's channels. Sleeve: inlet rail and nozzles (orange), outlet collectors "
        "(blue)."
    )
    return draw_figure("solids", caption, 5.2, draw)


def oil_figure(volumes: Mapping[str, Mesh]) -> Drawn:
    """The volumes of oil by their names, a shaded picture each, four at most."""

    def draw(figure: "Figure") -> None:
        grid = figure.subplots(2, 2).flat
        for axes, (name, mesh) in zip(grid, volumes.items(), strict=False):
            draw_solids(axes, [mesh], view_frame(30.0, 28.0), LARGEST_PICTURE // 2)
            axes.set_title(f"{name}, {with_unit(volume(mesh), VOLUME, 3)}", loc="left")
        for axes in figure.axes[len(volumes) :]:
            axes.axis("off")

    caption = (
        "What the oil fills on its way to the load, not to one scale. Colours are patches: inlet rail and nozzles "
        "(orange), walls of spool and sleeve (grey), windows (sand), chamber and channels of the outlet turbine, "
        "collector (blue)."
    )
    return draw_figure("oil", caption, 6.4, draw)


def patches_figure(mesh: Mesh) -> Drawn:
    """A volume of oil from both sides, with a name for the colour of each patch."""
    from matplotlib.patches import Patch

    def draw(figure: "Figure") -> None:
        for axes, azimuth in zip(figure.subplots(1, 2), (30.0, 210.0), strict=True):
            draw_solids(axes, [mesh], view_frame(azimuth, 38.0), LARGEST_PICTURE // 2)
        groups = dict.fromkeys(name.rstrip("0123456789") for name in mesh.names)
        marks = [Patch(facecolor=patch_colour(name), edgecolor=EDGE, label=name) for name in groups]
        figure.legend(handles=marks, loc="outside lower center", ncols=len(marks))

    caption = f"The oil, {with_unit(volume(mesh), VOLUME, 3)}, from both sides; colours are patches of its surface."
    return draw_figure("geometry", caption, 3.2, draw)


def film(shape: ValveShape, valve: RotaryValve, position: float, frames: int) -> Iterator[Any]:
    """Pictures of one PWM period, one after the other, as Pillow images."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    period = 2.0 * np.pi / valve.sections
    style: Any = dict(STYLE)
    with mpl.rc_context(style):
        figure = Figure(figsize=(PAGE_WIDTH, 5.2), dpi=FILM_DOTS, layout="constrained")
        canvas = FigureCanvasAgg(figure)
        above, below = figure.subplots(2, 1, height_ratios=(2.6, 1.0))
        _openings(below, valve, position)
        below.set_xlim(-np.degrees(0.5 * period), np.degrees(0.5 * period))
        now = below.axvline(0.0, color=INLET, linewidth=1.2)
        for number in range(frames):
            angle = (number / frames - 0.5) * period
            above.clear()
            _surface(above, shape, valve, angle)
            _nozzles(above, valve, angle, position)
            now.set_xdata([np.degrees(angle)] * 2)
            canvas.draw()  # type: ignore[no-untyped-call]
            if number == 0:
                figure.set_layout_engine("none")  # or the picture would tremble
            yield Image.frombytes("RGBA", canvas.get_width_height(), bytes(canvas.buffer_rgba())).convert("RGB")  # type: ignore[no-untyped-call]


def animation(
    shape: ValveShape, valve: RotaryValve, position: float, frames: int, heard: Callable[[int], None] | None = None
) -> bytes:
    """One PWM period as an endless GIF of 4 s; `heard` is given how many frames are done."""
    from PIL import Image

    pictures: list[Any] = []
    for number, picture in enumerate(film(shape, valve, position, frames), 1):
        # One palette for all: colours that change from frame to frame would flicker.
        if pictures:
            pictures.append(picture.quantize(palette=pictures[0], dither=Image.Dither.NONE))
        else:
            pictures.append(picture.quantize(64, method=Image.Quantize.MEDIANCUT))
        if heard:
            heard(number)
    stream = io.BytesIO()
    each = max(20, round(4000 / frames))
    pictures[0].save(stream, "GIF", save_all=True, append_images=pictures[1:], duration=each, loop=0, optimize=False)
    return stream.getvalue()


def _edges(valve: RotaryValve, shift: float, upper: bool) -> Points:
    """One edge of the barriers over more than a turn, as a line of corners [m]."""
    P, slope, half = pitch(valve), helix_slope(valve), 0.5 * barrier_width(valve)
    offset = half * slope if upper else -half * slope
    corners = np.arange(-4, 2 * round(valve.sections) + 5)
    return np.column_stack([0.5 * P * corners + shift, np.where(corners % 2, valve.helix_length, 0.0) + offset])


def _shift(valve: RotaryValve, angle: float) -> float:
    """How far the spool's surface has moved along the sleeve, to the nearest pitch [m]."""
    turn = angle / (2.0 * np.pi) * valve.sections
    return float(pitch(valve) * (turn - np.round(turn)))


def _surface(axes: "Axes", shape: ValveShape, valve: RotaryValve, angle: float) -> None:
    """Barriers, pockets, windows and shells on the unwrapped spool, seen from the sleeve; heights on the spool."""
    at, R, P, L = stations(shape, valve), valve.spool_radius, pitch(valve), valve.helix_length
    shift = _shift(valve, angle)
    left, right = -0.5 * P, (valve.sections - 0.5) * P
    margin = 0.6 * shape.ring_length
    bottom, top = L - at.ring_end - margin, at.ring_end + margin
    axes.fill_between([MM * left, MM * right], MM * bottom, MM * top, color=METAL, linewidth=0.0)
    upper, lower = _edges(valve, shift, True), _edges(valve, shift, False)
    for edge, far, near, pale, mirrored in (
        (upper, at.pocket_end, at.ring_end, PALE_LOAD, 0.0),
        (lower, L - at.pocket_end, L - at.ring_end, PALE_TANK, 0.5),
    ):
        axes.fill_between(MM * edge[:, 0], MM * edge[:, 1], MM * far, color=pale, linewidth=0.0)
        ring = sorted((near, near + np.sign(far - near) * shape.ring_length))
        axes.fill_between([MM * left, MM * right], MM * ring[0], MM * ring[1], color=pale, linewidth=0.0)
        for number in range(-2, round(valve.sections) + 2):
            middle, half = (number + mirrored) * P + shift, shape.window_half_angle * R
            low, high = sorted((far, far + np.sign(near - far) * shape.window_length))
            axes.fill_between(
                [MM * (middle - half), MM * (middle + half)], MM * low, MM * high, color=pale, linewidth=0.0
            )
        axes.plot(MM * edge[:, 0], MM * edge[:, 1], color=EDGE, linewidth=0.8)
    axes.fill_between(MM * upper[:, 0], MM * lower[:, 1], MM * upper[:, 1], color="#7d868f", linewidth=0.0)
    axes.set_aspect("equal")
    axes.set(xlim=(MM * left, MM * right), ylim=(MM * bottom, MM * top))
    axes.set(xlabel="arc along the sleeve [mm]", ylabel="height on the spool [mm]")
    axes.grid(False)
    _words(axes, shape, valve)


def _nozzles(axes: "Axes", valve: RotaryValve, angle: float, position: float) -> None:
    """The nozzles' mouths and what they see."""
    from matplotlib.patches import Polygon

    P, shift = pitch(valve), _shift(valve, angle)
    for number in range(round(valve.sections)):
        seen = nozzle_outline(valve, number * P - shift, position)
        for parts, colour in zip(open_parts(seen, valve), (LOAD, TANK), strict=True):
            for part in parts:
                if len(part) > 2:
                    axes.add_patch(Polygon(MM * (part + (shift, 0.0)), facecolor=colour, linewidth=0.0, zorder=3))
        outline = MM * (seen + (shift, 0.0))
        axes.add_patch(Polygon(outline, facecolor="none", edgecolor=INLET, linewidth=1.6, zorder=4))


def _lengths(axes: "Axes", valve: RotaryValve, shift: float, position: float) -> None:
    """Names of the lengths, with lines between arrows."""
    P, L = pitch(valve), valve.helix_length
    width, length, barrier = nozzle_width(valve), nozzle_length(valve), barrier_width(valve)

    def measure(start: tuple[float, float], end: tuple[float, float], name: str, off: tuple[float, float]) -> None:
        (u0, z0), (u1, z1) = start, end
        arrow = {"arrowstyle": "<|-|>", "color": INK, "linewidth": 0.7, "mutation_scale": 6, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (MM * u0, MM * z0), (MM * u1, MM * z1), arrowprops=arrow, zorder=6)
        middle = MM * (0.5 * (u0 + u1) + off[0]), MM * (0.5 * (z0 + z1) + off[1])
        box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.8}
        axes.text(*middle, name, ha="center", va="center", fontsize=7.5, zorder=7, bbox=box)

    low, high, side = position - 0.5 * length, position + 0.5 * length, -0.5 * width - 0.6e-3
    measure((-0.5 * width, low - 0.5e-3), (0.5 * width, low - 0.5e-3), f"$d_c$ {MM * width:.2f}", (0.0, -1.2e-3))
    measure((side, low), (side, high), f"$d_a$ {MM * length:.2f}", (-2.9e-3, 0.0))
    flank = 1.5 * P + shift - 0.5 * P * 0.75  # on the rising flank, three quarters down
    measure(
        (flank - 0.5 * barrier, 0.25 * L), (flank + 0.5 * barrier, 0.25 * L), f"$b$ {MM * barrier:.2f}", (0.0, 1.2e-3)
    )
    measure((shift, 0.0), (P + shift, 0.0), f"pitch {MM * P:.2f}", (0.0, 0.0))
    measure((1.5 * P + shift, 0.0), (1.5 * P + shift, L), f"$L$ {MM * L:.2f}", (0.0, 0.0))
    measure((2.0 * P, 0.0), (2.0 * P, position), f"$x$ {MM * position:.2f}", (0.0, -0.1 * L))


def _words(axes: "Axes", shape: ValveShape, valve: RotaryValve) -> None:
    """Where the oil goes, and which way the spool turns."""
    at, P, L = stations(shape, valve), pitch(valve), valve.helix_length
    end = (valve.sections - 0.52) * P
    heights = 0.5 * (at.window_end + at.ring_end), L - 0.5 * (at.window_end + at.ring_end)
    for z, name in zip(heights, ("to the load", "to the tank"), strict=True):
        axes.text(MM * end, MM * z, name, ha="right", va="center", color=LOAD, fontsize=7.5, zorder=7)
    arrow = {"arrowstyle": "-|>", "color": INLET, "linewidth": 1.2}
    start = -0.48 * P
    axes.annotate("", (MM * start + 3.0, MM * heights[0]), (MM * start, MM * heights[0]), arrowprops=arrow, zorder=6)
    words = "jets and rotation"
    axes.text(MM * start + 3.5, MM * heights[0], words, color=INLET, va="center", fontsize=7.5, zorder=7)


def _openings(axes: "Axes", valve: RotaryValve, position: float) -> None:
    """Openings by formula over one turn and half a period beyond either end."""
    angles = np.linspace(-np.pi / valve.sections, 2.0 * np.pi + np.pi / valve.sections, 2401)
    load, tank = port_openings(angles, position, valve)  # type: ignore[arg-type]
    axes.plot(np.degrees(angles), load, color=LOAD, label="load")
    axes.plot(np.degrees(angles), tank, color=TANK, label="tank")
    axes.set(xlabel="spool angle [deg]", ylabel="open fraction", ylim=(-0.04, 1.04))
    axes.set_xlim(0.0, 360.0)
    axes.xaxis.set_major_locator(_every(30.0))
    legend(axes, 2)


def _every(step: float) -> Any:
    from matplotlib.ticker import MultipleLocator

    return MultipleLocator(step)


def draw_solids(axes: "Axes", meshes: Sequence[Mesh], frame: Floats, width: int = LARGEST_PICTURE) -> None:
    """Shaded solids as the eye of a frame sees them, and 10 mm to compare; the picture has `width` pixels."""
    colours = {name: patch_colour(name) for mesh in meshes for name in mesh.names}
    picture, (left, right, low, high) = shade(meshes, colours, frame, width)
    axes.imshow(picture, extent=(MM * left, MM * right, MM * low, MM * high), interpolation="antialiased")
    axes.grid(False)
    axes.set_axis_off()
    size = 10.0
    foot = MM * low + 0.02 * MM * (high - low)
    axes.plot([MM * left, MM * left + size], [foot, foot], color=INK, linewidth=1.2)
    axes.text(MM * left + 0.5 * size, foot, "10 mm", ha="center", va="bottom", fontsize=7.0, color=INK)
