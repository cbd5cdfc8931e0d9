"""Arguments and options that several verbs share."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from vvdp.base.kinds import Kind

SystemName = Annotated[
    str, typer.Argument(metavar="SYSTEM", help="A shipped system (see `vvdp list`) or the path of a TOML file.")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="TABLE.KEY=VALUE",
        help="Replace a value, for example operation.duty_ratio=0.4; may be repeated.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one flat JSON object in SI units, and nothing else.")]
Cores = Annotated[int | None, typer.Option("--cores", min=1, help="How many; by default all.")]
Force = Annotated[bool, typer.Option("--force", help="Replace what is there.")]


def out_option(told: str) -> Any:
    """The option --out of a verb, the directory that it writes to."""
    return typer.Option("--out", metavar="DIR", parser=_directory, help=told)


def _directory(text: str) -> Path:
    if not str(text).strip():
        raise typer.BadParameter("it is empty; expected a directory to write to")
    return Path(text)


def default_directory(name: str) -> Path:
    """A directory under `results` that does not exist yet: where a command writes that is not told."""
    stem = f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    directory, number = Path("results", stem), 1
    while directory.exists():
        number += 1
        directory = Path("results", f"{stem}-{number}")
    return directory


def parsed_option(option: str, text: str, kind: "Kind") -> float:
    """The SI value of an option. Raises ConfigError that names the option."""
    from vvdp.base.errors import ConfigError, Fault, ParameterError
    from vvdp.base.units import parsed

    try:
        return parsed(text, kind)
    except ParameterError as problem:
        raise ConfigError([Fault(option, 0, "", str(problem))]) from None
