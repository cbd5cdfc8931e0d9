"""How every figure of a report looks, and how it becomes SVG and PNG; drawn again it has the same bytes."""

import io
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INLET, LOAD, TANK, RELIEF, INK, FAINT = "#d9730d", "#0b3c6f", "#6aaed6", "#5a5a5a", "#1b1f24", "#c9ced4"
"""Colours that keep apart for the colour-blind; their lightness differs for print in grey."""

STYLE: Mapping[str, object] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.5,
    "axes.edgecolor": "#6b747d",
    "axes.linewidth": 0.7,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "grid.color": "#e6e9ec",
    "grid.linewidth": 0.6,
    "xtick.color": "#4b545d",
    "ytick.color": "#4b545d",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "legend.handlelength": 2.4,
    "legend.borderaxespad": 0.0,
    "lines.linewidth": 1.3,
    "svg.fonttype": "path",
}
PAGE_WIDTH = 7.1
DOTS = 160


@dataclass(frozen=True)
class Drawn:
    """A figure with the name of its files and the words below it; `draw` has filled it, `height` inches high."""

    name: str
    caption: str
    svg: str
    height: float = 0.0
    draw: Callable[["Figure"], None] | None = field(default=None, repr=False, compare=False)

    @property
    def png(self) -> bytes:
        """The figure as PNG; nothing where it was not drawn with Matplotlib."""
        return image(self.name, self.height, self.draw, "png") if self.draw else b""


def draw_figure(name: str, caption: str, height: float, draw: Callable[["Figure"], None]) -> Drawn:
    """The figure that `draw` fills, as wide as the page and `height` inches high."""
    svg = _with_less_text(image(name, height, draw, "svg").decode())
    return Drawn(name, caption, svg, height, draw)


def _with_less_text(svg: str) -> str:
    """An SVG without indentation and unused names, the lines of its paths to a tenth of a point, which is 0.035 mm."""
    used = set(re.findall(r'#([^")]+)', svg))
    named = re.sub(r' id="([^"]+)"', lambda each: each[0] if each[1] in used else "", re.sub(r"\n\s+", "\n", svg))
    return re.sub(r'\bd="([^"]*)"', lambda path: f'd="{_short_path(path[1])}"', named)


def _short_path(path: str) -> str:
    """A path whose straight lines go on from the point before, and whose curves keep a hundredth of a point.

    Each point is rounded before its distance to the one before is taken, so that no errors add up.
    """
    text, before, at = "", "", (0, 0)
    to = at
    for command, numbers in re.findall(r"([A-Za-z])([^A-Za-z]*)", path):
        values = [float(each) for each in numbers.split()]
        if values:
            to = (round(10.0 * values[-2]), round(10.0 * values[-1]))
        if command == "L":
            text += f"{' ' if before == 'L' else 'l'}{(to[0] - at[0]) / 10:g} {(to[1] - at[1]) / 10:g}"
        else:
            text += command + " ".join(f"{round(each, 1 if command == 'M' else 2):g}" for each in values)
        before, at = command, to
    return re.sub(r"(?<![\d.])0\.", ".", text).replace(" -", "-")


def empty_figure(height: float) -> "Figure":
    """A figure as wide as the page and `height` inches high, in the style of all figures when drawn within it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PAGE_WIDTH, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def image(name: str, height: float, draw: Callable[["Figure"], None], form: str) -> bytes:
    """A figure in the form "svg", "png" or "pdf"."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    style: Any = {**STYLE, "svg.hashsalt": name}
    with mpl.rc_context(style):
        figure = empty_figure(height)
        draw(figure)
        _settle(figure)
        content = io.BytesIO()
        dateless: dict[str, Any] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}
        if form == "svg":  # savefig would draw twice
            figure.dpi = 72
            canvas: Any = FigureCanvasSVG(figure)
            canvas.print_svg(content, metadata={"Date": None, "Creator": None})
        else:
            figure.savefig(content, format=form, dpi=DOTS, metadata=dateless[form])
    return content.getvalue()


def _settle(figure: "Figure") -> None:
    """Lays the figure out once, to a millionth of its size: the solver's last digits differ from time to time."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    if not isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine):
        return
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        left, bottom, width, height = (round(float(edge), 6) for edge in axes.get_position(original=True).bounds)
        axes.set_position((left, bottom, width, height))


def legend(axes: "Axes", columns: int) -> None:
    """A legend above the axes, in `columns` columns."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=columns)
