"""The page about a computed flow: its result, the geometry with its patches, and sections through the flow."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.manifest import open_directory, refuse_links
from vvdp.cfd.section import Section, read_frames, read_section
from vvdp.cfd.series import CASE, MIDDLE
from vvdp.cfd.snapping import SURFACE
from vvdp.cfd.streamlines import Streamline, read_streamlines
from vvdp.geometry.files import read_stl
from vvdp.geometry.mesh import Floats, Mesh
from vvdp.report.drawing import INK, Drawn, draw_figure
from vvdp.report.geometry_figures import draw_solids, patches_figure
from vvdp.report.result_page import Page, write_result_page
from vvdp.report.shading import view_frame
from vvdp.results.store import read_meta, read_result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MM = 1e3
PICTURE, DOTS = 4.0, 170
"""Width of a painted field [inch], and its points per inch."""
SPEEDS, PALE = "viridis", 0.25
"""Colours of speeds; how strong the oil is behind its streamlines."""
FRAMES_ACROSS, LEAST_SPEED = 4, 0.2
"""Pictures of a flow over time: how many side by side; share of the highest speed below which one is left out."""
WINDOW = 4e-3
"""How far from the middle of their picture cells are shown [m]."""


def write_cfd_report(directory: Path) -> Path:
    """Writes report.html and figures/ into the directory of a computed flow and gives the path of the page.

    All is made from the files in the directory; made again, it has the same bytes.
    Raises ConfigError where the directory holds no result.
    """
    opened, case = open_directory(directory), directory / CASE
    result = read_result(opened)
    refuse_links(case)
    drawings = [patches_figure(read_stl(case / SURFACE))]
    if lines := read_streamlines(case):
        drawings.append(streamlines_figure(read_stl(case / SURFACE), lines))
    if section := read_section(case, MIDDLE):
        drawings.append(section_figure(section, result.numbers["density_kg_m3"].value))
    if frames := read_frames(case, MIDDLE):
        begin, speed = (result.numbers[key].value for key in ("begin_angle_rad", "spool_speed_rad_s"))
        drawings.append(frames_figure({begin + speed * time: each for time, each in frames.items()}))
    return write_result_page(directory, Page(result, read_meta(opened), {}, {each.name: each for each in drawings}))


def streamlines_figure(mesh: Mesh, lines: Sequence[Streamline]) -> Drawn:
    """Streamlines from where the oil enters, coloured by speed, in the pale volume of oil."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    norm = Normalize(0.0, float(np.quantile(np.concatenate([each.speed for each in lines]), 0.99)))

    def draw(figure: "Figure") -> None:
        both = figure.subplots(1, 2)
        for axes, azimuth in zip(both, (30.0, 210.0), strict=True):
            frame = view_frame(azimuth, 38.0)
            draw_solids(axes, [mesh], frame)
            axes.images[0].set_alpha(PALE)
            _paths(axes, lines, frame, norm)
        figure.colorbar(ScalarMappable(norm, SPEEDS), ax=both, location="bottom", label="speed [m/s]", shrink=0.5)

    caption = "Streamlines from where the oil enters, from both sides; colours are the speed."
    return draw_figure("streamlines", caption, 3.6, draw)


def _paths(axes: "Axes", lines: Sequence[Streamline], frame: Floats, norm: Any) -> None:
    """Streamlines as the eye of a frame sees them, those behind first."""
    from matplotlib.collections import LineCollection

    pieces, values = [], []
    for line in lines:
        seen = MM * line.points @ frame.T
        pieces.append(np.stack([seen[:-1], seen[1:]], axis=1))
        values.append(0.5 * (line.speed[:-1] + line.speed[1:]))
    segments = np.concatenate(pieces)
    order = np.argsort(segments[:, :, 2].mean(1))
    drawn = LineCollection(list(segments[order][:, :, :2]), cmap=SPEEDS, norm=norm, linewidth=0.6, rasterized=True)
    drawn.set_array(np.concatenate(values)[order])
    axes.add_collection(drawn)


def section_figure(section: Section, density: float) -> Drawn:
    """Speed and pressure in a plane section across the axis, and the cells of the mesh at the narrowest place."""
    speed = np.linalg.norm(section.velocity, axis=1)

    def draw(figure: "Figure") -> None:
        left, middle, right = figure.subplots(1, 3)
        _field(figure, left, section, (speed, "speed [m/s]", SPEEDS))
        _field(figure, middle, section, (1e-5 * density * section.pressure, "pressure [bar]", "cividis"))
        _cells(right, section, section.points[int(speed.argmax()), :2])

    caption = (
        "Section across the axis: speed, static pressure above that where the oil leaves, and cells of the mesh where "
        "the oil is fastest."
    )
    return draw_figure("sections", caption, 2.9, draw)


def frames_figure(frames: Mapping[float, Section]) -> Drawn:
    """Speed in sections across the axis at several angles of the spool [rad], as far as oil flows fast."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    speeds = {angle: np.linalg.norm(each.velocity, axis=1) for angle, each in frames.items()}
    highest = {angle: float(np.quantile(speed, 0.99)) for angle, speed in speeds.items()}
    fast = sorted(angle for angle in frames if highest[angle] > LEAST_SPEED * max(highest.values()))
    norm, rows = Normalize(0.0, max(highest.values())), -(-len(fast) // FRAMES_ACROSS)

    def draw(figure: "Figure") -> None:
        grid = list(figure.subplots(rows, FRAMES_ACROSS, squeeze=False).flat)
        for axes in grid:
            axes.set_axis_off()
        for axes, angle in zip(grid, fast, strict=False):
            picture, extent = _field_picture(frames[angle], speeds[angle], norm, SPEEDS)
            axes.imshow(picture, extent=extent, interpolation="none")
            axes.set_title(f"{np.degrees(angle):+.1f}°", loc="left")
        figure.colorbar(ScalarMappable(norm, SPEEDS), ax=grid, location="bottom", label="speed [m/s]", shrink=0.5)

    caption = (
        "Speed in the section across the axis: nozzles open at negative angles of the spool, close at positive ones."
    )
    return draw_figure("frames", caption, 2.1 * rows + 0.6, draw)


def _field(figure: "Figure", axes: "Axes", section: Section, shown: tuple[Array, str, str]) -> None:
    """A field with its scale: values at the points, words, colours. Of the values 1 % at either end are cut off."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    values, words, colours = shown
    low, high = np.quantile(values, (0.01, 0.99))
    norm = Normalize(float(low), float(high))
    picture, extent = _field_picture(section, values, norm, colours)
    axes.imshow(picture, extent=extent, interpolation="none")
    axes.set_axis_off()
    figure.colorbar(ScalarMappable(norm, colours), ax=axes, location="bottom", label=words, shrink=0.9)


def _field_picture(
    section: Section, values: Array, norm: Any, colours: str
) -> tuple[Any, tuple[float, float, float, float]]:
    """A field as a picture, and its edges [mm]: as vectors, so many triangles would make the page slow."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.tri import Triangulation

    x, y = MM * section.points[:, :2].T
    extent = (float(x.min()), float(x.max()), float(y.min()), float(y.max()))
    height = PICTURE * (extent[3] - extent[2]) / (extent[1] - extent[0])
    figure = Figure(figsize=(PICTURE, height), dpi=DOTS)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.tripcolor(Triangulation(x, y, section.triangles), values, norm=norm, cmap=colours, shading="gouraud")
    axes.set(xlim=extent[:2], ylim=extent[2:])
    axes.set_axis_off()
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba()).copy(), extent  # type: ignore[no-untyped-call]


def _cells(axes: "Axes", section: Section, at: Array) -> None:
    """The cells round a point [m]."""
    from matplotlib.collections import PolyCollection

    near = [each for each in section.polygons if (abs(section.points[each, :2] - at) < WINDOW).all()]
    outlines = [MM * section.points[each, :2] for each in near]
    axes.add_collection(PolyCollection(outlines, facecolor="none", edgecolor=INK, linewidth=0.35))
    axes.set_aspect("equal")
    axes.autoscale()
    axes.grid(False)
    axes.set_title("cells [mm]", loc="left")
