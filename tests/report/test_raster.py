"""A diagram as pixels: what is drawn is where the SVG has it."""

import io

import numpy as np
import pytest
from PIL import Image

from vvdp.report.raster import diagram_png

SPACE = "http://www.w3.org/2000/svg"
HEAD = f'<svg xmlns="{SPACE}" viewBox="-10 0 100.0 60.0"><g fill="none" stroke="#000000" stroke-width="2">'


def pixels(body):
    """Grey values, a row for each line of 1/1.5 units."""
    picture = Image.open(io.BytesIO(diagram_png(f"{HEAD}{body}</g></svg>")))
    assert picture.size == (150, 90)
    return np.array(picture.convert("L"))


def at(grey, x, y):
    """Whether there is something dark at a place of the drawing."""
    row, column = round(1.5 * y), round(1.5 * (x + 10.0))
    return grey[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].min() < 128


@pytest.mark.parametrize(
    ("body", "dark", "light"),
    [
        ('<polyline points="0,10 40,10"/>', (20, 10), (20, 14)),
        ('<g transform="translate(5 20)"><polyline points="0,10 40,10"/></g>', (25, 30), (25, 10)),
        (
            '<g transform="translate(5 40)"><g transform="scale(1 -1)"><path d="M 0 10 H 40"/></g></g>',
            (25, 30),
            (25, 50),
        ),
        ('<g transform="translate(40 20) scale(-1 1)"><path d="M 0 10 H 30"/></g>', (25, 30), (50, 30)),
        ('<polyline points="10,10 30,10 20,30 10,10"/>', (15, 20), (20, 17)),
        ('<polygon points="10,10 30,10 20,30" fill="#000000" stroke="none"/>', (20, 15), (12, 25)),
        ('<circle cx="20" cy="20" r="10"/>', (30, 20), (20, 20)),
        ('<rect x="10" y="10" width="20" height="15"/>', (10, 18), (20, 18)),
        ('<path d="M 10 30 H 40"/>', (25, 30), (25, 26)),
        ('<path d="M 10 30 A 15 15 0 0 1 40 30"/>', (25, 15), (25, 45)),
        ('<path d="M 10 30 A 15 15 0 0 0 40 30"/>', (25, 45), (25, 15)),
        ('<path d="M 20 30 A 10 10 0 1 1 30 30"/>', (25, 11), (25, 31)),
        ('<path d="M 20 30 A 10 10 0 1 0 30 30"/>', (25, 49), (25, 29)),
        ('<path d="M 10 30 Q 25 10 40 30"/>', (25, 20), (25, 30)),
    ],
)
def test_shapes_are_where_they_belong(body, dark, light):
    """An arc with sweep 1 goes clockwise on the screen: from left to right above the line."""
    grey = pixels(body)
    assert at(grey, *dark)
    assert not at(grey, *light)


def test_text_stands_at_its_anchor():
    place = 'x="40" y="30" text-anchor="end" font-size="13"'
    grey = pixels(f'<text {place} fill="#000000" stroke="none"><tspan x="40">MMM</tspan></text>')
    assert (grey[:, : 75 + 3] < 128).any()
    assert not (grey[:, 75 + 3 :] < 128).any()
