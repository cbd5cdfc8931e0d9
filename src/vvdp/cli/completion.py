"""Completions that a shell offers at the tabulator key: systems, and the keys that `--set` takes."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import typer


def system_names(incomplete: str) -> Iterator[str]:
    """Shipped systems and TOML files that begin with what is typed, and folders on the way to such a file."""
    from importlib import resources

    data = resources.files("vvdp.systems") / "data"
    names = [file.name.removesuffix(".toml") for file in data.iterdir() if file.name.endswith(".toml")]
    yield from sorted(name for name in names if name.startswith(incomplete))
    folder, _, stem = incomplete.rpartition("/")
    with suppress(OSError):
        for path in sorted(Path(folder or ("/" if incomplete.startswith("/") else ".")).iterdir()):
            if path.name.startswith(stem) and (path.suffix == ".toml" or (path.is_dir() and stem)):
                yield incomplete[: len(incomplete) - len(stem)] + path.name + ("/" if path.is_dir() else "")


def setting_keys(ctx: typer.Context, incomplete: str) -> list[str]:
    """`TABLE.KEY=` of the system on the line, for all that begin with what is typed; a single one also with its value.

    Two answers keep a shell from adding a space behind the equals sign, and show what is to be replaced.
    """
    rest = [word for word in ctx.args if not word.startswith("-")]  # what an option without its value leaves over
    values = _values(str(ctx.params.get("system") or "".join(rest[:1])))
    found = [key for key in values if key.startswith(incomplete)]
    return [f"{key}=" for key in found] + [f"{key}={values[key]}" for key in found if len(found) == 1 and values[key]]


def _values(system: str) -> dict[str, str]:
    """The values of a system by `TABLE.KEY`, empty where one is no number; none where the system cannot be read."""
    from vvdp.base.errors import VvdpError
    from vvdp.systems.drawn_parts import part_settings
    from vvdp.systems.system import load_system

    with suppress(VvdpError, OSError):
        loaded = load_system(system)
        found = {
            f"{row.table}.{row.key}": row.display_text.partition(" (")[0] if _is_number(row.value) else ""
            for row in loaded.rows
        }
        return {key: found.get(path, "") for key, path in part_settings(loaded.content).items()} | found
    return {}


def _is_number(value: Any) -> bool:
    return isinstance(value, float) or bool(getattr(value, "is_constant", False))


def drawable_names(ctx: typer.Context, incomplete: str) -> list[str]:
    """Charts and series of the result on the line that begin with what is typed."""
    from vvdp.base.errors import VvdpError
    from vvdp.report.chosen import open_drawable, series_names

    rest = [word for word in ctx.args if not word.startswith("-")]
    with suppress(VvdpError, OSError):
        result = open_drawable(Path(str(ctx.params.get("directory") or "".join(rest[:1]))))
        return [name for name in (*result.charts, *series_names(result)) if name.startswith(incomplete)]
    return []
