"""Result directories that were made to do harm, each from a sound one; `outside` is what they reach for.

`signed` are those whose list of files has been made to fit again, as whoever makes one would: the sums do not protect
against malice, only the other checks do.
"""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from vvdp.base.files import HOST, list_all
from vvdp.base.manifest import LIST, entry_of

FOREIGN = 4242.125
"""A number that lies outside, and must not be shown."""
PAYLOAD = "from pathlib import Path\nPath({marker!r}).write_text('ran')\ndef network(): pass\n"


class Place(NamedTuple):
    """A directory to be spoiled, and the folder outside of it whose content is to stay as it is."""

    directory: Path
    outside: Path

    @property
    def marker(self) -> Path:
        """What code writes that runs."""
        return self.outside / "ran"

    def edit(self, name: str, change: Callable[[Any], Any]) -> None:
        """Changes the content of a JSON file."""
        path = self.directory / name
        path.write_text(json.dumps(change(json.loads(path.read_text()))))

    def circuit(self, name: str) -> None:
        """Puts another circuit into the saved system."""
        path = self.directory / "system.toml"
        rest = [line for line in path.read_text().splitlines() if not line.startswith("circuit =")]
        path.write_text(f'circuit = "{name}"\n' + "\n".join(rest) + "\n")

    def module(self, folder: Path, name: str = "payload.py") -> Path:
        """Puts code that leaves a marker into a folder."""
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(PAYLOAD.format(marker=str(self.marker)))
        return folder / name

    def link(self, name: str, *, folder: bool = False) -> None:
        """Moves a file or folder outside and leaves a link, so that all sums still fit."""
        (self.directory / name).rename(self.outside / name)
        (self.directory / name).symlink_to(self.outside / name, target_is_directory=folder)

    def record(self, change: Callable[[h5py.File], None]) -> None:
        """Changes the record of a run."""
        with h5py.File(self.directory / "result.h5", "a") as file:
            change(file)


def sign(directory: Path) -> None:
    """Makes the list of files fit what is there."""
    (directory / LIST).unlink()
    list_all(directory)


def _module_in_directory(place: Place) -> None:
    place.module(place.directory)
    place.circuit("payload:network")


def _package_in_directory(place: Place) -> None:
    place.module(place.directory, "payload/__init__.py")
    place.circuit("payload:network")


def _module_on_record(folder: Callable[[Place], Path]) -> Callable[[Place], None]:
    def spoil(place: Place) -> None:
        path = place.module(folder(place))
        place.circuit("payload:network")
        module = {"name": "payload", "path": str(path), "sha256": entry_of(path).sha256}
        place.edit("meta.json", lambda meta: meta | {"module": module})

    return spoil


def _circuit(name: str) -> Callable[[Place], None]:
    def spoil(place: Place) -> None:
        place.module(place.outside)
        place.circuit(name.format(outside=place.outside))

    return spoil


def _meta(**values: Any) -> Callable[[Place], None]:
    return lambda place: place.edit("meta.json", lambda meta: meta | values)


def _summary(text: str) -> Callable[[Place], None]:
    return lambda place: (place.directory / "summary.json").write_text(text) and None


def _first(file: h5py.File) -> tuple[str, int]:
    name = next(iter(file["outputs"]))
    return name, len(file["time"])


def _external_link(place: Place) -> None:
    def change(file: h5py.File) -> None:
        name, rows = _first(file)
        with h5py.File(place.outside / "other.h5", "w") as other:
            other.create_dataset("x", data=np.full(rows, FOREIGN)).attrs.update(dict(file["outputs"][name].attrs))
        del file["outputs"][name]
        file["outputs"][name] = h5py.ExternalLink(str(place.outside / "other.h5"), "x")

    place.record(change)


def _external_storage(place: Place) -> None:
    def change(file: h5py.File) -> None:
        name, rows = _first(file)
        (place.outside / "raw").write_bytes(np.full(rows, FOREIGN).tobytes())
        kept = {key: file["outputs"][name].attrs[key] for key in ("units", "long_name")}
        del file["outputs"][name]
        external = [(str(place.outside / "raw"), 0, 8 * rows)]
        file["outputs"].create_dataset(name, (rows,), "f8", external=external).attrs.update(kept)

    place.record(change)


def _virtual(place: Place) -> None:
    def change(file: h5py.File) -> None:
        name, rows = _first(file)
        with h5py.File(place.outside / "other.h5", "w") as other:
            other["x"] = np.full(rows, FOREIGN)
        kept = {key: file["outputs"][name].attrs[key] for key in ("units", "long_name")}
        del file["outputs"][name]
        layout = h5py.VirtualLayout((rows,), "f8")
        layout[:] = h5py.VirtualSource(str(place.outside / "other.h5"), "x", (rows,))
        file["outputs"].create_virtual_dataset(name, layout).attrs.update(kept)

    place.record(change)


def _circle(place: Place) -> None:
    place.record(lambda file: file["outputs"].__setitem__("again", file["outputs"]))


def _broken_link(place: Place) -> None:
    place.record(lambda file: file["outputs"].__setitem__("gone", h5py.SoftLink("/nowhere")))


def _half(place: Place) -> None:
    def change(file: h5py.File) -> None:
        name, rows = _first(file)
        values, kept = file["outputs"][name][: rows // 2], dict(file["outputs"][name].attrs)
        del file["outputs"][name]
        new = file["outputs"].create_dataset(name, data=values)
        new.attrs.update({key: kept[key] for key in ("units", "long_name")})

    place.record(change)


def _huge(place: Place) -> None:
    def change(file: h5py.File) -> None:
        new = file["outputs"].create_dataset("huge", (10_000_000_000_000,), "f8", chunks=(1_000_000,))
        new.attrs.update({"units": "1", "long_name": "huge"})

    place.record(change)


def _texts(place: Place) -> None:
    def change(file: h5py.File) -> None:
        del file["time"]
        file["time"] = ["text"]

    place.record(change)


def _listing(name: str, **entry: Any) -> Callable[[Place], None]:
    """An entry of the list for something outside, which a page that no longer needs it would delete."""

    def spoil(place: Place) -> None:
        path = name.format(outside=place.outside)
        told = {"bytes": 4, "sha256": entry_of(place.outside / "keep.svg").sha256, "page": True} | entry
        place.edit(LIST, lambda content: content | {"files": content["files"] | {path: told}})

    return spoil


def _list_text(text: str) -> Callable[[Place], None]:
    return lambda place: (place.directory / LIST).write_text(text) and None


def _pipe(place: Place) -> None:
    (place.directory / "meta.json").unlink()
    os.mkfifo(place.directory / "meta.json")


def _page_is_a_folder(place: Place) -> None:
    (place.directory / "report.html").unlink(missing_ok=True)
    (place.directory / "report.html").mkdir()


def _figures_are_a_link(place: Place) -> None:
    for path in (place.directory / "figures").iterdir():
        path.unlink()
    (place.directory / "figures").rmdir()
    (place.directory / "figures").symlink_to(place.outside, target_is_directory=True)


def _left_by_the_dead(kind: str) -> Callable[[Place], None]:
    """A name that a process which died would have left, as a link to what is outside."""

    def spoil(place: Place) -> None:
        name = f".report.html.{HOST}-999999999-0123456789abcdef.{kind}"
        (place.directory / name).symlink_to(place.outside, target_is_directory=True)

    return spoil


def _content(change: Callable[[dict[str, Any]], Any]) -> Callable[[Place], None]:
    def spoil(place: Place) -> None:
        path = place.directory / "result.json"
        content = json.loads(path.read_text())
        change(content)
        path.write_text(json.dumps(content))

    return spoil


def _table_named(name: str) -> Callable[[Place], None]:
    def spoil(place: Place) -> None:
        (place.outside / "secret.csv").write_text(f"x_m\n{FOREIGN}\n")
        column = {"kind": "length", "label": "x", "symbol": ""}
        table = {"title": "", "columns": {"x_m": column}, "shown": [], "axes": [], "note": "", "is_data": False}
        named = name.format(outside=place.outside)
        _content(lambda content: content["tables"].__setitem__(named, table))(place)

    return spoil


def _chart_named(name: str, key: str = "") -> Callable[[Place], None]:
    def spoil(place: Place) -> None:
        named = name.format(outside=place.outside)

        def change(content: dict[str, Any]) -> None:
            (chart,) = content["charts"].values()
            content["charts"] = {key or named: chart | {"name": named}}

        _content(change)(place)

    return spoil


def _cut(place: Place) -> None:
    text = (place.directory / "curve.csv").read_text()
    (place.directory / "curve.csv").write_text(text[: len(text) // 2])


def _foreign_kind(place: Place) -> None:
    (place.directory / "geometry.toml").write_text("[geometry]\n")


def _ragged(place: Place) -> None:
    (place.directory / "curve.csv").write_text("x_m,y_m\n1,2\n3\n")


def _wide_cell(place: Place) -> None:
    (place.directory / "curve.csv").write_text('x_m,y_m\n1,"' + "9" * 200_000 + '"\n')


def nothing(place: Place) -> None:
    """Leaves a directory as it is."""


class Hostile(NamedTuple):
    """How a directory is spoiled, whether its list then fits, and whether `report` refuses it."""

    spoil: Callable[[Place], None]
    signed: bool = True
    refused: bool = True


DEEP = '{"a": ' * 100_000 + "1" + "}" * 100_000
RUNS = {
    "code beside": Hostile(_module_in_directory, refused=False),
    "package beside": Hostile(_package_in_directory, refused=False),
    "code on record in it": Hostile(_module_on_record(lambda place: place.directory), refused=False),
    "code on record outside": Hostile(_module_on_record(lambda place: place.outside), refused=False),
    "code by an absolute path": Hostile(_circuit("{outside}/payload:network")),
    "code by a path upwards": Hostile(_circuit("../outside/payload:network")),
    "code by dots": Hostile(_circuit("..outside.payload:network")),
    "an installed function": Hostile(_circuit("webbrowser:main"), refused=False),
    "a built-in function": Hostile(_circuit("os:system"), refused=False),
    "no such entry point": Hostile(_circuit("payload")),
    "external link": Hostile(_external_link),
    "external storage": Hostile(_external_storage),
    "virtual dataset": Hostile(_virtual),
    "group in itself": Hostile(_circle),
    "broken link": Hostile(_broken_link),
    "half a series": Hostile(_half),
    "80 TB": Hostile(_huge),
    "texts for times": Hostile(_texts),
    "no HDF5": Hostile(lambda place: (place.directory / "result.h5").write_text("none") and None),
    "record is a link": Hostile(lambda place: place.link("result.h5"), signed=False),
    "meta.json is a link": Hostile(lambda place: place.link("meta.json"), signed=False),
    "meta.json is a pipe": Hostile(_pipe, signed=False),
    "list is a link": Hostile(lambda place: place.link(LIST), signed=False),
    "page is a link": Hostile(lambda place: place.link("report.html"), signed=False),
    "page is a folder": Hostile(_page_is_a_folder, signed=False),
    "figures are a link": Hostile(_figures_are_a_link, signed=False),
    "list names a file above": Hostile(_listing("../outside/keep.svg"), signed=False),
    "list names figures above": Hostile(_listing("figures/../../outside/keep.svg"), signed=False),
    "list names an absolute file": Hostile(_listing("{outside}/keep.svg"), signed=False),
    "list with texts for numbers": Hostile(_listing("figures/x.svg", bytes="4"), signed=False),
    "list is no list": Hostile(_list_text('{"vvdp_files": 1, "files": []}'), signed=False),
    "list of another format": Hostile(_list_text('{"vvdp_files": 99, "files": {}}'), signed=False),
    "list nested deeply": Hostile(_list_text(DEEP), signed=False),
    "list is empty": Hostile(_list_text('{"vvdp_files": 1, "files": {}}'), signed=False),
    "text for a number": Hostile(_meta(relative_tolerance="<script>")),
    "flag for a number": Hostile(_meta(until_s=True)),
    "numbers for words": Hostile(_meta(command=[1, {}])),
    "ranges of another kind": Hostile(_meta(ranges=[1, 2])),
    "text in the summary": Hostile(_summary('{"duration_s": "<b>"}')),
    "infinite number": Hostile(_summary('{"trusted": Infinity}')),
    "summary nested deeply": Hostile(_summary(DEEP)),
    "changed system": Hostile(lambda place: place.circuit("buck"), signed=False),
    "file gone": Hostile(lambda place: (place.directory / "summary.json").unlink(), signed=False),
    "folder left by the dead": Hostile(_left_by_the_dead("new"), signed=False, refused=False),
    "folder moved by the dead": Hostile(_left_by_the_dead("old"), signed=False, refused=False),
}
RESULTS = {
    "chart above": Hostile(_chart_named("../../outside/evil")),
    "chart at an absolute path": Hostile(_chart_named("{outside}/evil")),
    "chart of two names": Hostile(_chart_named("../../outside/evil", "curve")),
    "hidden chart": Hostile(_chart_named(".evil")),
    "table above": Hostile(_table_named("../outside/secret")),
    "table at an absolute path": Hostile(_table_named("{outside}/secret")),
    "table is a link": Hostile(lambda place: place.link("curve.csv"), signed=False),
    "result.json is a link": Hostile(lambda place: place.link("result.json"), signed=False),
    "cut table": Hostile(_cut, signed=False),
    "cut table, signed": Hostile(_ragged),
    "wide cell": Hostile(_wide_cell),
    "number for a flag": Hostile(_content(lambda content: content.update(finished=-1))),
    "no charts": Hostile(_content(lambda content: content.update(charts=3))),
    "chart of no column": Hostile(
        _content(lambda content: content["charts"]["line"]["panels"][0]["lines"][0].update(x="none"))
    ),
    "kind of another verb": Hostile(_foreign_kind, signed=False, refused=False),
}
