"""Arguments and options that several verbs share, and how their help is laid out."""

import inspect
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer
from typer.core import TyperCommand

from vvdp.base.memory import require_memory
from vvdp.cli.completion import setting_keys, system_names

if TYPE_CHECKING:
    from vvdp.base.kinds import Kind
    from vvdp.systems.system import System


class Verb(TyperCommand):
    """A command whose help names its arguments as the guide does, without braces and Python types.

    Raises MemoryLimitError, before anything is loaded, where the process may not have enough memory for it.
    """

    least_memory = 700_000_000
    """Address space that compiling a circuit needs [bytes]: 600 MB for the smallest, measured."""

    def invoke(self, ctx: Any) -> Any:
        """Runs the command."""
        require_memory(self.least_memory)
        return super().invoke(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The words of the usage line."""
        return [re.sub(r"[{}]", "", piece) for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Writes arguments and options, each with its help."""
        for title, what in (("Arguments", "argument"), ("Options", "option")):
            records = [param.get_help_record(ctx) for param in self.get_params(ctx) if param.param_type_name == what]
            rows = [_plain_record(*record) for record in records if record]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


class LightVerb(Verb):
    """A command that simulates nothing."""

    least_memory = 0


def _plain_record(name: str, text: str) -> tuple[str, str]:
    """Name and help of a parameter without Python types, and with its range in words."""
    if not name.startswith("-"):
        text = text.removesuffix("  [required]")
    text = re.sub(r"(\d+)<=x<=(\d+)\]$", r"\1 to \2]", text)
    return name.partition(" <")[0], re.sub(r"x>=(\d+)\]$", r"at least \1]", text)


SystemName = Annotated[
    str,
    typer.Argument(
        metavar="SYSTEM",
        help="A shipped system (see `vvdp list`) or the path of a TOML file.",
        autocompletion=system_names,
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="TABLE.KEY=VALUE",
        help="Set a value, for example operation.duty_ratio=0.4 (repeatable).",
        autocompletion=setting_keys,
    ),
]
ValveName = Annotated[
    str, typer.Option("--part", metavar="NAME", help="Rotary valve, or part with one, if there are several.")
]
OwnCycles = Annotated[
    list[Path] | None,
    typer.Option(
        "--own-cycle",
        metavar="FILE",
        help="Run a cycle of your own: CSV with the columns time, position, force in s, m, N (repeatable).",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units and nothing else.")]
Bounds = Annotated[
    list[str] | None,
    typer.Option(
        "--bound",
        metavar="STATEMENT",
        help='Bound of a variable, for example "radial_clearance <= 22.5 um" (repeatable).',
    ),
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--subject-to", metavar="STATEMENT", help='Constraint, for example "pwm_frequency >= 72 Hz" (repeatable).'
    ),
]
Cycle = Annotated[
    Path | None,
    typer.Option("--cycle", metavar="FILE", help="Weighted operating points, a TOML file."),
]
Cores = Annotated[int | None, typer.Option("--cores", metavar="N", min=1, help="Number of cores (default: all).")]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing result.")]
Restart = Annotated[bool, typer.Option("--force", help="Start over and discard what an earlier call has finished.")]
Trust = Annotated[
    str,
    typer.Option(
        "--trust",
        metavar="MODULE",
        help="Run this module of your own, by name or file, where a saved circuit needs its code.",
        show_default=False,
    ),
]
NoReport = Annotated[bool, typer.Option("--no-report", help="Do not write a report.")]
Seed = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Random seed.")]


@dataclass(frozen=True)
class Case:
    """Options: a system with settings."""

    system: SystemName
    settings: Settings = None

    def load(self) -> "System":
        """The system. Raises ConfigError with all its faults."""
        from vvdp.systems.system import load_system

        return load_system(self.system, self.settings or ())


@dataclass(frozen=True)
class RigCase(Case):
    """Options: a system with settings, whose pump unit is tested on a rig."""

    part: ValveName = ""

    def on_rig(self, verb: str) -> "System":
        """The test rig with its pump unit. Raises ConfigError, which names `verb`, if it has none."""
        from vvdp.evaluation.unit_rig import unit_on_rig

        return unit_on_rig(self.load(), verb, self.part)


@dataclass(frozen=True)
class Output:
    """Options: the directory to write to, and what is shown of a result."""

    out: Path | None = None
    force: Force = False
    json: AsJson = False
    no_report: NoReport = False

    def directory(self, name: str) -> Path:
        """Where to write; without --out a new directory under `results` whose name begins with `name`."""
        return self.out if self.out is not None else default_directory(name)


def flat(out: str = "") -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Spread the records of options that a verb takes into the options of its command line.

    A parameter of the verb whose class is a dataclass stands for one option per field, in its place. A further
    parameter with the name of a field replaces this option; the record then has its default. `out` is the directory
    that the help of the option --out names; empty for an option --out of its own.
    """

    def spread(verb: Callable[..., None]) -> Callable[..., None]:
        given = _parameters(verb, out)
        records: dict[str, Any] = {
            name: each.annotation for name, each in given.items() if is_dataclass(each.annotation)
        }
        own = {name: _parameters(record, out).keys() - given.keys() for name, record in records.items()}
        options: dict[str, inspect.Parameter] = {}
        for name, parameter in given.items():
            beside = _parameters(records[name], out) if name in records else {name: parameter}
            options |= {key: each for key, each in beside.items() if name not in records or key in own[name]}

        def call(**values: Any) -> None:
            for name, record in records.items():
                values[name] = record(**{key: values.pop(key) for key in own[name]})
            verb(**values)

        call.__name__, call.__doc__ = verb.__name__, verb.__doc__
        call.__signature__ = inspect.Signature(list(options.values()))  # type: ignore[attr-defined]
        call.__annotations__ = {name: option.annotation for name, option in options.items()}
        return call

    return spread


def _parameters(function: Callable[..., Any], out: str) -> dict[str, inspect.Parameter]:
    """The parameters of a verb or a record, by keyword, with annotations; if `out` is not empty, --out names it."""
    kinds = get_type_hints(function, include_extras=True)
    if out:
        kinds["out"] = Annotated[Path | None, out_option(out)]
    return {
        name: each.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=kinds[name])
        for name, each in inspect.signature(function).parameters.items()
    }


def out_option(default: str) -> Any:
    """The option --out of a verb that writes to `default` if it is not given."""
    return typer.Option("--out", metavar="DIR", parser=_directory, help=f"Output directory (default: {default}).")


def _directory(text: str) -> Path:
    if not str(text).strip():
        raise typer.BadParameter("it is empty; expected a directory to write to")
    return Path(text)


def default_directory(name: str) -> Path:
    """A directory under `results` that does not exist yet: where a command writes by default."""
    stem = f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    directory, number = Path("results", stem), 1
    while directory.exists():
        number += 1
        directory = Path("results", f"{stem}-{number}")
    return directory


def parsed_option(option: str, text: str, kind: "Kind") -> float:
    """The SI value of an option. Raises ConfigError that names the option."""
    from vvdp.base.errors import ConfigError, Fault, ParameterError
    from vvdp.base.units import parse

    try:
        return parse(text, kind)
    except ParameterError as problem:
        raise ConfigError([Fault(option, 0, "", str(problem))]) from None
