"""Output for a user or a program: tables for one, JSON for the other."""

import json
import math
import sys
import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from vvdp.cli.table import Grid

WIDTH_WITHOUT_TERMINAL = 200


def console(*, err: bool = False) -> "Console":
    """A console on stdout or stderr that prints text as it is; wide where no terminal sets a width."""
    from rich.console import Console

    stream = sys.stderr if err else sys.stdout
    width = None if stream.isatty() else WIDTH_WITHOUT_TERMINAL
    return Console(stderr=err, highlight=False, markup=False, emoji=False, soft_wrap=False, width=width)


def grid(
    *heads: str, title: str = "", right: Sequence[str] = (), keys: int = 1, ends: int = 0, transpose: bool = False
) -> "Grid":
    """A table with a column for each of `heads`, those in `right` of numbers.

    Where it is too wide for the screen, it is printed in parts that all begin with its first `keys` columns and end
    with its last `ends`, or with `transpose` with its rows as columns, if that is narrow enough.
    """
    from vvdp.cli.table import Grid

    return Grid(heads=heads, title=title, right=right, keys=keys, ends=ends, transpose=transpose)


def tell(text: str, style: str = "") -> None:
    """Prints a text for a user on stdout: on a terminal broken between words, elsewhere on one line."""
    out = console()
    for line in text.split("\n"):
        parts = (
            textwrap.wrap(line, out.width, break_long_words=False, break_on_hyphens=False) if out.is_terminal else []
        )
        out.print("\n".join(parts) or line, style=style, soft_wrap=True)


def warn(message: str) -> None:
    """Prints a warning in red on stdout, where the results are."""
    tell(f"warning: {message}", style="red")


def typed_command() -> tuple[str, ...]:
    """The command line as it was typed, for the origin of a result."""
    from vvdp.base.display import readable

    return ("vvdp", *map(readable, sys.argv[1:]))


def run_command(system: str, settings: Sequence[str] | None = None, until: str | None = None) -> str:
    """The line that runs a system with what was given beside it."""
    import shlex

    given = [word for each in settings or () for word in ("--set", each)] + (["--until", until] if until else [])
    return shlex.join(["vvdp", "run", system, *given])


def say(message: str) -> None:
    """Prints a line on stderr."""
    print(message, file=sys.stderr, flush=True)


def print_json(content: Mapping[str, object]) -> None:
    """Prints one JSON object on stdout."""
    from vvdp.results.store import finite

    print(json.dumps(finite(content), indent=1, allow_nan=False))


def amount(value: float, unit: str) -> str:
    """`value` [SI] expressed in `unit`, to five digits; a dash where there is none. A pressure is a difference."""
    from vvdp.base import kinds
    from vvdp.base.units import in_unit

    converted = {"bar": kinds.PRESSURE_DIFFERENCE, "lpm": kinds.FLOW, "rpm": kinds.SPEED, "degC": kinds.TEMPERATURE}
    converted["mm"] = kinds.POSITION
    if not math.isfinite(value):
        return "-"
    return f"{in_unit(value, converted[unit], unit) if unit in converted else value:.5g}"
