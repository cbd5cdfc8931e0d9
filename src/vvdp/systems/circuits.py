"""Circuits that a system file may name: an entry point, or a function in a module of your own."""

import importlib
import inspect
import types
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, get_type_hints

from vvdp.base.errors import ParameterError
from vvdp.base.params import Params
from vvdp.base.slots import TableSlot, slot_of
from vvdp.base.tables import nearest
from vvdp.network.network import Network
from vvdp.systems.own_modules import local_file, module_name, run_local_module

GROUP = "vvdp.systems"
"""Group of the entry points under which packages offer circuits."""

NetworkFunction = Callable[..., Network]


def circuit_names() -> list[str]:
    """Names of the circuits that installed packages offer."""
    return sorted({point.name for point in _entry_points()})


@cache
def _entry_points() -> tuple[EntryPoint, ...]:
    """The entry points of all installed packages; reading them takes longer than drawing a circuit."""
    return tuple(entry_points(group=GROUP))


def _load(point: EntryPoint) -> Any:
    """The object that an entry point names. Raises ParameterError if its package does not load."""
    try:
        return point.load()
    except Exception as problem:  # code of another package
        reason = f"{type(problem).__name__}: {problem}"
        raise ParameterError(
            f"{point.name!r} of an installed package cannot be loaded from {point.value!r} ({reason})"
        ) from None


def network_function(name: str, folder: Path) -> NetworkFunction:
    """The function that draws a circuit, by the name of an entry point or as "module:function".

    A module is looked for in `folder` first. Raises ParameterError where there is none.
    """
    found: Any
    if ":" in name:
        function = name.partition(":")[2]
        module = load_module(module_name(name), folder)
        found = getattr(module, function, None)
        if found is None:
            public = [n for n, value in vars(module).items() if inspect.isfunction(value) and not n.startswith("_")]
            raise ParameterError(f"{module_name(name)} has no function {function!r}{nearest(function, public)}")
    else:
        points = [point for point in _entry_points() if point.name == name]
        if not points:
            message = f"{name!r} is not a circuit; expected {' or '.join((*circuit_names(), 'module:function'))}"
            raise ParameterError(message)
        found = _load(points[0])
    if not inspect.isfunction(found):
        raise ParameterError(f"{name} is no function; expected one that takes tables and returns a Network")
    return found


def load_module(name: str, folder: Path) -> types.ModuleType:
    """The module of that name, in `folder` or installed. Raises ParameterError where there is none."""
    path = local_file(name, folder)
    if path is not None:
        return run_local_module(name, path)
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as problem:
        if problem.name and (name == problem.name or name.startswith(f"{problem.name}.")):
            raise ParameterError(f"no module {name!r}, neither {folder / name}.py nor installed") from None
        raise ParameterError(f"{name} needs the module {problem.name!r}, which is not installed") from None


@cache
def tables_record(function: NetworkFunction) -> Any:
    """The dataclass that is the only argument of a circuit, one field for each table; None if each is an argument."""
    hints = [get_type_hints(function).get(name) for name in inspect.signature(function).parameters]
    record = hints[0] if len(hints) == 1 else None
    return record if isinstance(record, type) and is_dataclass(record) and not issubclass(record, Params) else None


def draw(function: NetworkFunction, tables: Mapping[str, object]) -> Network:
    """The network that a circuit makes of tables by their names."""
    record = tables_record(function)
    return function(**tables) if record is None else function(record(**tables))


@cache
def table_slots(function: NetworkFunction) -> dict[str, TableSlot]:
    """The tables that a circuit takes, by name: the arguments of its function, or the fields of its only one.

    Raises ParameterError where one is not annotated with a parameter class.
    """
    holder = tables_record(function) or function
    hints = get_type_hints(holder)
    return {name: _slot(function.__qualname__, name, hints.get(name)) for name in inspect.signature(holder).parameters}


def _slot(function: str, name: str, hint: Any) -> TableSlot:
    slot = slot_of(hint)
    if slot is None:
        raise ParameterError(
            f"{function}: the table {name!r} is annotated as {hint!r}; expected a subclass of vvdp.base.params.Params"
        )
    return slot
