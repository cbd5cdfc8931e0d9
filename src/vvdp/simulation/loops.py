"""The stepping loops as compiled code: one of all circuits, compiled once and kept like the code of a circuit."""

from collections.abc import Callable
from typing import Any, NamedTuple

from vvdp.generator.calls import Entry
from vvdp.generator.kinds import INT, Kind, Scalar
from vvdp.simulation import loop
from vvdp.simulation.assembly import Assembly
from vvdp.simulation.cache import default_cache, quiet
from vvdp.simulation.parts import Part
from vvdp.simulation.text import Classes


class Given(Part):
    """A plain function as it stands."""

    def function(self) -> Callable[..., Any]:
        """The function."""
        found: Callable[..., Any] = self.called[self.name]
        return found


def plain_part(function: Callable[..., Any], kinds: tuple[Kind, ...], result: Scalar | None = None) -> Given:
    """A plain function for arguments of these types."""
    name = function.__name__
    return Given(name=name, source="", called={name: function}, classes=Classes(), kinds=kinds, result=result)


class Loop(NamedTuple):
    """The compiled loop for one case, and for the cases of a batch one after the other."""

    run: Entry
    batch: Entry


def compiled_loop(say: Callable[[str], None] = quiet, *, checked: bool = False) -> Loop:
    """The loop, from the cache or compiled into it; `checked` as of `link`."""
    parts = (plain_part(loop.run, loop.RUN, INT), plain_part(loop.batch, loop.BATCH))
    found = _assembly(parts, "the simulation loop", checked=checked).load(default_cache(), say)
    return Loop(found["run"], found["batch"])


def compiled_lane_loop(say: Callable[[str], None] = quiet) -> Entry:
    """The loop for many cases at once, from the cache or compiled into it."""
    from vvdp.simulation import lane_loop

    parts = (plain_part(lane_loop.run_lanes, lane_loop.RUN_LANES),)
    return _assembly(parts, "the loop for many cases at once").load(default_cache(), say)["run_lanes"]


_ASSEMBLIES: dict[tuple[str, bool], Assembly] = {}


def _assembly(parts: tuple[Given, ...], title: str, *, checked: bool = False) -> Assembly:
    """Hashed once in a process: the loops are vvdp's own, and do not change."""
    key = parts[0].name, checked
    if key not in _ASSEMBLIES:
        _ASSEMBLIES[key] = Assembly(parts, title, checked=checked)
    return _ASSEMBLIES[key]
