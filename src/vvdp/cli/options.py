"""Arguments and options that several verbs share."""

from typing import Annotated

import typer

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
Force = Annotated[bool, typer.Option("--force", help="Replace what is there.")]
