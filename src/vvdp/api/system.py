"""Systems for scripts and notebooks."""

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vvdp.api.run import Run
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import Kind
from vvdp.base.tables import nearest, parsed_table, with_settings
from vvdp.runs.simulate import run_system
from vvdp.systems import system as systems
from vvdp.systems.changed import quantity_text, setting_text
from vvdp.systems.drawn_parts import setting_path
from vvdp.systems.options import lasting, without_other_position

if TYPE_CHECKING:
    from pint import Quantity

Value = float | str | list[float] | Mapping[str, Any]
"""A number [SI, pressures absolute], a text with its unit, a list of numbers, or a signal as in a file."""

NAMED = ("nodes", "components", "programs", "parts")
"""Tables of a drawn circuit that hold a table for each name."""
TYPED = "text"
"""The name of a system that comes from no file."""
PUBLIC = ("assumptions", "circuit", "name", "rows", "run", "title", "uncertainties", "with_values")
"""The names that `dir()` of a system shows; all others are for the package."""


@dataclass(frozen=True, repr=False)
class System(systems.System):
    """A system: its circuit with values, each with unit and source, ready to run."""

    def with_values(self, **tables: Mapping[str, Value]) -> "System":
        """The same system with other values, by table and key.

        >>> system.with_values(operation={"duty_ratio": 0.4, "oil_temperature": "50 degC"})

        >>> system.with_values(components={"pump": {"displacement": "20 cc/rev"}, "relief.cracking_pressure": "90 bar"})

        A number is SI, and a pressure absolute; a text has its unit, and so has a quantity of pint. A value that a part
        offers is `parts={"supply.displacement": ...}`. A table with its `type` replaces what the file has. Raises
        ConfigError naming every fault.
        """
        known = {row.setting: row.kind for row in self.rows}
        given = {path: value for table, values in tables.items() for path, value in self._paths(table, values)}
        settings = [
            f"{key}={_checked_setting(self.name, key, value, known.get(setting_path(self.content, key)))}"
            for key, value in given.items()
        ]
        try:
            table = with_settings(without_other_position(self.table, settings), settings)
            return _public(self.read_from(table))
        except ConfigError as problem:
            named = (replace(each, place=self.name) if each.place == "--set" else each for each in problem.faults)
            raise ConfigError(list(named)) from None

    def run(
        self,
        until: "str | float | Quantity[float] | None" = None,
        *,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Run:
        """Simulates the system, until a time ("50 ms", a quantity, or a number [s]) or as long as its file says.

        `progress` receives the simulated time [s] now and then. Where `stop` states this, or at Ctrl-C, it stops
        early and keeps what was reached.
        """
        system = self
        if until is not None:
            text = until if isinstance(until, str) else quantity_text(until) or f"{until!r} s"
            system = _public(self.read_from(lasting(self.table, text)))
        done = run_system(system, progress=progress, stop=stop, say=lambda message: print(message, file=sys.stderr))
        return Run(**{each.name: getattr(done, each.name) for each in fields(done)})

    def _paths(self, table: str, values: Mapping[str, Value]) -> Iterator[tuple[str, Value]]:
        """Each value with its path; those of a node, component, program or part may stand in a table of their own."""
        drawn = {**self.table.content.get(table, {}), **self.content.get(table, {})} if table in NAMED else {}
        for key, value in values.items():
            if table not in NAMED or "." in key or not isinstance(value, Mapping) or "type" in value:
                yield f"{table}.{key}", value
            elif key not in drawn:
                raise ConfigError([Fault(self.name, 0, f"{table}.{key}", f"unknown{nearest(key, drawn)}")])
            else:
                yield from ((f"{table}.{key}.{inner}", each) for inner, each in value.items())

    def __dir__(self) -> list[str]:
        return [*PUBLIC]

    def __repr__(self) -> str:
        network = self.circuit.network
        return (
            f"<System {self.name}: {self.title}; {len(network.nodes)} nodes, {len(network.parts)} components, "
            f"{len(self.rows)} values, {len(self.assumptions)} assumed>"
        )

    def _repr_html_(self) -> str:
        from vvdp.report.circuit import graph_of
        from vvdp.report.diagram import diagram

        drawing = diagram(graph_of(self.circuit.network, self.title), {})
        return f"<b>{escape(self.title)}</b><div>{drawing[drawing.index('<svg') :]}</div>"


def load(name: str | Path, **tables: Mapping[str, Value]) -> System:
    """The system called `name`, shipped (`vvdp list` shows all) or the path of a file, with other values where given.

    >>> system = vvdp.load("prototype", operation={"duty_ratio": 0.4})

    Raises ConfigError naming every fault at once.
    """
    return _public(systems.load_system(str(name))).with_values(**tables)


def loads(text: str, folder: str | Path = ".") -> System:
    """The system that the text of a system file describes; files that it names are looked for in `folder`.

    Raises ConfigError naming every fault with its line.
    """
    return _public(systems.built_system(parsed_table(text, TYPED), TYPED, Path(folder)))


def _public(system: systems.System) -> System:
    return System(**{each.name: getattr(system, each.name) for each in fields(system)})


def _checked_setting(name: str, key: str, value: Any, kind: Kind | None) -> str:
    """A value as the text of a setting. Raises ConfigError for what is no number, text, quantity, list or table."""
    try:
        return setting_text(value, kind)
    except (TypeError, ValueError):
        example = f", for example {kind.example!r} or a number in {kind.unit}" if kind else ""
        message = f"{type(value).__name__} is no value; give a text with its unit{example}"
        raise ConfigError([Fault(name, 0, key, message)]) from None
