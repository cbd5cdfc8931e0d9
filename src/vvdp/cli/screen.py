"""What a person or a program sees: tables for one, JSON for the other."""

import json
import math
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

WIDTH_WITHOUT_TERMINAL = 200


def console(*, err: bool = False) -> "Console":
    """A console on stdout or stderr that prints text as it is; wide where no terminal sets a width."""
    from rich.console import Console

    stream = sys.stderr if err else sys.stdout
    width = None if stream.isatty() else WIDTH_WITHOUT_TERMINAL
    return Console(stderr=err, highlight=False, markup=False, emoji=False, soft_wrap=False, width=width)


def grid(*columns: str, title: str = "", right: tuple[str, ...] = ()) -> "Table":
    """A table with plain rules and `columns`, those in `right` aligned to the right."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title) if title else None, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    for column in columns:
        table.add_column(Text(column), justify="right" if column in right else "left", overflow="fold")
    return table


def warn(message: str) -> None:
    """Prints a warning in red on stdout, where the results are."""
    console().print(f"warning: {message}", style="red", soft_wrap=True)


def say(message: str) -> None:
    """Prints a line on stderr."""
    print(message, file=sys.stderr, flush=True)


def plain(content: Mapping[str, Any]) -> dict[str, Any]:
    """`content` as JSON can hold it: a number that is not finite becomes null."""
    return {key: _plain(value) for key, value in content.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return plain(value)
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def print_json(content: Mapping[str, Any]) -> None:
    """Prints one JSON object on stdout."""
    print(json.dumps(plain(content), indent=1, allow_nan=False))


def amount(value: float, unit: str) -> str:
    """`value` [SI] expressed in `unit`, to five digits; a dash where there is none. A pressure is a difference."""
    from vvdp.base import kinds
    from vvdp.base.units import in_unit

    converted = {"bar": kinds.PRESSURE_DIFFERENCE, "lpm": kinds.FLOW, "rpm": kinds.SPEED, "degC": kinds.TEMPERATURE}
    converted["mm"] = kinds.POSITION
    if not math.isfinite(value):
        return "-"
    return f"{in_unit(value, converted[unit], unit) if unit in converted else value:.5g}"
