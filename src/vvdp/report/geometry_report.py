"""The page about a valve's shape: its result, and drawings of the solids in its directory."""

import base64
from collections.abc import Iterator
from pathlib import Path

from vvdp.base.manifest import Directory, open_directory
from vvdp.geometry.files import read_stl
from vvdp.geometry.product import FILM, SHAPE
from vvdp.geometry.result import VOLUMES
from vvdp.geometry.shape import ValveShape
from vvdp.geometry.shape_tables import given_shape
from vvdp.geometry.solids import half_sleeve, spool
from vvdp.report.drawing import Drawn
from vvdp.report.geometry_figures import oil_figure, solids_figure, unwrapped_figure
from vvdp.report.result_page import Page, write_result_page
from vvdp.report.solid_view import solid_view
from vvdp.results.result import Result
from vvdp.results.store import read_meta, read_result
from vvdp.systems.spool_travel import require_rotary_valve
from vvdp.systems.system import saved_system
from vvdp.valve.rotary import RotaryValve


def write_geometry_report(place: Path, trust: str = "") -> Path:
    """Writes report.html and figures/ into the directory of a geometry and gives the path of the page.

    All is made from the files in the directory; made again, it has the same bytes. `trust` is a module that may be run
    to draw its system. Raises ConfigError where the directory holds no result, or the system in it cannot be read.
    """
    directory = open_directory(place)
    result, meta = read_result(directory), read_meta(directory)
    system = saved_system(directory, result.system, meta.get("module"), trust)
    valve = require_rotary_valve(system, "geometry")
    shape = given_shape(valve, str(directory.file(SHAPE)), ()).shape
    angle, position = (result.numbers[key].value for key in ("spool_angle_rad", "axial_position_m"))
    ready = {"view": solid_view(shape, valve, angle, position)}
    if FILM in directory.files:
        ready["film"] = _film_html(directory.file(FILM).read_bytes())
    drawings = {each.name: each for each in _drawings(directory, result, shape, valve)}
    return write_result_page(place, Page(result, meta, ready, drawings))


def _drawings(directory: Directory, result: Result, shape: ValveShape, valve: RotaryValve) -> Iterator[Drawn]:
    position, fineness = (result.numbers[key].value for key in ("axial_position_m", "fineness"))
    yield unwrapped_figure(shape, valve, position)
    yield solids_figure(spool(shape, valve, fineness), half_sleeve(shape, valve, fineness))
    files = {words: f"oil/{name}.stl" for name, words in VOLUMES.items()}
    if oil := {words: read_stl(directory.file(name)) for words, name in files.items() if name in directory.files}:
        yield oil_figure(oil)


def _film_html(film: bytes) -> str:
    data = base64.b64encode(film).decode("ascii")
    return f'<p><img style="max-width:100%" alt="One PWM period" src="data:image/gif;base64,{data}"></p>'
