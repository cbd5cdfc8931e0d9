"""A circuit diagram as PNG: the few elements that `diagram` writes, drawn with Matplotlib."""

import io
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

if TYPE_CHECKING:
    from matplotlib.patches import Patch
    from matplotlib.transforms import Transform

POINTS = 0.72
"""Of a pixel of the drawing, a hundredth of an inch [pt]."""
DOTS, ICON_DOTS = 150, 40
NUMBERS = re.compile(r"-?\d+(?:\.\d+)?")
INHERITED = ("fill", "stroke", "stroke-width", "stroke-dasharray", "font-size", "text-anchor", "font-weight")
TRANSFORMS = re.compile(r"(translate|scale)\(([^)]*)\)")
Styles = Mapping[str, str]
Point = tuple[float, float]


def icon_png(svg: str) -> bytes:
    """The diagram as a small picture of 16 colours, 0.4 dots a pixel."""
    from PIL import Image

    content = io.BytesIO()
    picture = Image.open(io.BytesIO(diagram_png(svg, ICON_DOTS))).convert("RGB")
    picture.quantize(16).save(content, "png", optimize=True)
    return content.getvalue()


def diagram_png(svg: str, dots: int = DOTS) -> bytes:
    """The diagram as a picture of so many dots per 100 pixels of the drawing; 150 by default."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.transforms import Affine2D

    root = ElementTree.fromstring(svg[svg.index("<svg") :])
    left, top, width, height = _numbers(root.attrib["viewBox"])
    figure = Figure(figsize=(0.01 * width, 0.01 * height))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(left, left + width), ylim=(top + height, top))
    axes.axis("off")
    for order, (element, styles, place) in enumerate(_leaves(root, {"font-size": "13"}, Affine2D())):
        _draw(axes, element, styles, place, order)
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=dots, metadata={"Software": None})
    return content.getvalue()


def _numbers(text: str) -> list[float]:
    return [float(each) for each in NUMBERS.findall(text)]


def _leaves(node: ElementTree.Element, styles: Styles, place: "Transform") -> Iterator[tuple[Any, Styles, "Transform"]]:
    """Everything that is drawn, in its order, with what it inherits and where its own coordinates lie."""
    own = {**styles, **{key: node.attrib[key] for key in INHERITED if key in node.attrib}}
    for name, numbers in TRANSFORMS.findall(node.attrib.get("transform", "")):
        place = _placement(name, _numbers(numbers), place)
    if _tag(node) not in ("a", "g", "svg"):
        yield node, own, place
        return
    for child in node:
        yield from _leaves(child, own, place)


def _placement(name: str, numbers: list[float], place: "Transform") -> "Transform":
    """Coordinates that lie shifted, or scaled and mirrored, in others."""
    from matplotlib.transforms import Affine2D

    own = Affine2D()
    (own.translate if name == "translate" else own.scale)(*numbers)
    return own + place


def _tag(node: ElementTree.Element) -> str:
    return node.tag.rpartition("}")[2]


def _draw(axes: Any, node: ElementTree.Element, styles: Styles, place: "Transform", order: int) -> None:
    tag = _tag(node)
    if tag == "text":
        _write(axes, node, styles, place, order)
    elif tag != "title":
        patch = _patch(tag, {key: node.attrib[key] for key in node.attrib})
        patch.set(
            facecolor=styles.get("fill", "none"),
            edgecolor=styles.get("stroke", "none"),
            linewidth=POINTS * float(styles.get("stroke-width", "1")),
            linestyle=_dashes(styles),
            capstyle="round",
            joinstyle="round",
            snap=False,
            zorder=order,
            transform=place + axes.transData,
        )
        axes.add_patch(patch)


def _dashes(styles: Styles) -> Any:
    lengths = _numbers(styles.get("stroke-dasharray", ""))
    return (0, [POINTS * each for each in lengths]) if lengths else "-"


def _patch(tag: str, of: Mapping[str, str]) -> "Patch":
    """One shape in its own coordinates."""
    from matplotlib.patches import Circle, FancyBboxPatch, PathPatch, Polygon, Rectangle
    from matplotlib.path import Path

    if tag == "circle":
        return Circle((float(of["cx"]), float(of["cy"])), float(of["r"]))
    if tag == "rect":
        x, y, width, height = (float(of[key]) for key in ("x", "y", "width", "height"))
        if "rx" in of:
            return FancyBboxPatch((x, y), width, height, boxstyle=f"round,pad=0,rounding_size={of['rx']}")
        return Rectangle((x, y), width, height)
    if tag == "path":
        return PathPatch(_path(of["d"]))
    points = np.reshape(_numbers(of["points"]), (-1, 2))
    # A line that comes back to its first point would lose its last piece as an open polygon.
    return Polygon(points) if tag == "polygon" else PathPatch(Path(points))


def _path(text: str) -> Any:
    """A path of M, H, Q and circular A."""
    from matplotlib.path import Path

    points: list[tuple[float, float]] = []
    codes: list[Any] = []
    for letter, rest in re.findall(r"([MHQA])([^MHQA]*)", text):
        n = _numbers(rest)
        if letter == "M":
            points.append((n[0], n[1]))
            codes.append(Path.MOVETO)
        elif letter == "H":
            points.append((n[0], points[-1][1]))
            codes.append(Path.LINETO)
        elif letter == "Q":
            points += [(n[0], n[1]), (n[2], n[3])]
            codes += [Path.CURVE3, Path.CURVE3]
        else:
            arc = _arc(points[-1], (n[5], n[6]), n[0], is_large=bool(n[3]), is_rising=bool(n[4]))
            points += arc
            codes += [Path.LINETO] * len(arc)
    return Path(points, codes)


def _arc(begin: Point, end: Point, radius: float, *, is_large: bool, is_rising: bool) -> list[tuple[float, float]]:
    """Points of a circle's arc, of which two are possible on each side: more than half of the circle where it
    `is_large`, with the angle growing from the first axis to the second where it `is_rising`.
    """
    a, b = complex(*begin), complex(*end)
    half, away = 0.5 * (b - a), np.sqrt(max(radius**2 - abs(0.5 * (b - a)) ** 2, 0.0))
    centre = a + half + (1.0 if is_large != is_rising else -1.0) * away * 1j * half / abs(half)
    first, last = np.angle(a - centre), np.angle(b - centre)
    turn = (last - first) % (2.0 * np.pi) if is_rising else -((first - last) % (2.0 * np.pi))
    around = centre + abs(a - centre) * np.exp(1j * (first + turn * np.linspace(0.0, 1.0, 24)[1:]))
    return [(float(point.real), float(point.imag)) for point in around]


def _write(axes: Any, node: ElementTree.Element, styles: Styles, place: "Transform", order: int) -> None:
    """A text of one line, or of lines one below the other."""
    anchors = {"start": "left", "middle": "center", "end": "right"}
    x, y = place.transform((float(node.attrib["x"]), float(node.attrib["y"])))
    for line in [node, *node]:
        if not line.text:
            continue
        own = {**styles, **line.attrib}
        y += float(line.attrib.get("dy", 0.0))
        axes.text(
            x,
            y,
            line.text,
            color=own.get("fill", "black"),
            fontsize=POINTS * float(own["font-size"]),
            fontweight="bold" if own.get("font-weight") == "600" else "normal",
            horizontalalignment=anchors[own.get("text-anchor", "start")],
            zorder=order,
        )
