"""`vvdp estimate`."""

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vvdp.cli.options import Output, flat

if TYPE_CHECKING:
    from vvdp.base.errors import ConfigError
    from vvdp.logs.channel import Log
    from vvdp.offline.config import Estimation, Option
    from vvdp.results.result import Result

INTERRUPTED = 130


@dataclass(frozen=True)
class Named:
    """Options: channels of a log and settings, which override those of a config file."""

    edges: Annotated[
        str | None, typer.Option("--edges", metavar="COLUMN", help="Column of edge times, one row per edge.")
    ] = None
    falling: Annotated[
        str | None, typer.Option("--falling", metavar="COLUMN", help="Column of the falling edges, if separate.")
    ] = None
    counts: Annotated[str | None, typer.Option("--counts", metavar="COLUMN", help="Column of an edge counter.")] = None
    wave: Annotated[str | None, typer.Option("--wave", metavar="COLUMN", help="Column of a photodiode signal.")] = None
    sectors: Annotated[
        int | None, typer.Option("--sectors", metavar="N", help="Number of sectors, bright plus dark (default: 8).")
    ] = None
    index_shift: Annotated[
        float | None, typer.Option("--index-shift", metavar="SHARE", help="Offset of the index edge in sectors.")
    ] = None
    sample_rate: Annotated[
        str | None,
        typer.Option(
            "--sample-rate", metavar="RATE", help='Sample rate if the log has no time channel, for example "10 kHz".'
        ),
    ] = None
    clock: Annotated[str | None, typer.Option("--time", metavar="COLUMN", help="Time channel of the log.")] = None
    pressure: Annotated[
        str | None,
        typer.Option("--pressure", metavar="COLUMN", help="Column of the inlet pressure, which gives the duty ratio."),
    ] = None
    fuse: Annotated[bool, typer.Option("--fuse", help="Fuse inlet-pressure edges into the estimate.")] = False
    sections: Annotated[
        int | None, typer.Option("--sections", metavar="N", help="PWM periods per revolution of a rotary valve.")
    ] = None
    output_rate: Annotated[
        str | None, typer.Option("--output-rate", metavar="RATE", help="Output sample rate (default: 1 kHz).")
    ] = None
    smooth: Annotated[bool, typer.Option("--smooth", help="Add the fixed-interval smoothed estimate.")] = False
    fit: Annotated[
        bool, typer.Option("--fit", help="Fit the noise settings of the filter to the start of the log.")
    ] = False

    def options(self) -> "list[Option]":
        """Those that are given, by the key of the config file."""
        from vvdp.offline.config import Option

        given = {
            "sensor.edges": ("--edges", self.edges),
            "sensor.falling": ("--falling", self.falling),
            "sensor.counts": ("--counts", self.counts),
            "sensor.wave": ("--wave", self.wave),
            "sensor.sectors": ("--sectors", self.sectors),
            "sensor.index_shift": ("--index-shift", self.index_shift),
            "log.sample_rate": ("--sample-rate", self.sample_rate),
            "log.time": ("--time", self.clock),
            "pressure.channel": ("--pressure", self.pressure),
            "pressure.fuse": ("--fuse", self.fuse or None),
            "valve.sections": ("--sections", self.sections),
            "output.rate": ("--output-rate", self.output_rate),
            "output.smooth": ("--smooth", self.smooth or None),
            "filter.fit": ("--fit", self.fit or None),
        }
        return [Option(key, option, value) for key, (option, value) in given.items() if value is not None]


@dataclass(frozen=True)
class Files:
    """Options: the config file that is read, or written."""

    config: Annotated[
        Path | None, typer.Option("--config", metavar="FILE", help="Settings, a TOML file; options override it.")
    ] = None
    write_config: Annotated[
        Path | None,
        typer.Option("--write-config", metavar="FILE", help="Write a config file to start from, without estimating."),
    ] = None


@flat("results/LOG-DATE-TIME")
def estimate(
    *,
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A CSV, TDMS, MDF4, HDF5, MATLAB or Parquet file.")],
    named: Named,
    files: Files,
    output: Output,
) -> None:
    """Estimate angle and speed of a shaft from a measured log.

    Name the channel with --wave, --counts or --edges, or in a config file. Ctrl-C keeps the results so far.
    """
    from vvdp.base.files import result_directory
    from vvdp.cli.printing import print_result
    from vvdp.cli.progress import report_reach
    from vvdp.cli.report import RESULT, add_report
    from vvdp.cli.screen import print_json, say, tell
    from vvdp.offline.config import SOURCES, load_estimation
    from vvdp.offline.estimate import estimate as estimated
    from vvdp.offline.estimate import open_for_estimate

    options = named.options()
    if files.write_config is not None:
        _write_config(log, files.write_config, files.config, options, output.force)
        return
    if files.config is None and not any(f"sensor.{key}" in {option.key for option in options} for key in SOURCES):
        raise _nothing_named(log, options)
    wanted = load_estimation(files.config, options)
    with open_for_estimate(log, wanted) as source:
        directory = output.directory(log.stem)
        with result_directory(directory, force=output.force) as folder:
            what = "both passes over the log" if wanted.smooth else "the log"
            with report_reach(1.0, lambda share: f"{100.0 * share:.0f} % of {what}") as reach:
                found = estimated(
                    source, wanted, folder, progress=reach.move, say=reach.say, more=_origin(files.config, options)
                )
            if not found.finished:
                say("interrupted; what was reached is kept")
            reported = not output.no_report and add_report(RESULT, folder)
    if output.json:
        print_json({"log": str(log), **_flat(found, wanted), "out": str(directory)})
    else:
        print_result(found, tuple(found.listings))
        tell(f"results: {directory}" + (f"\nreport: {directory / 'report.html'}" if reported else ""))
    if not found.finished:
        raise typer.Exit(INTERRUPTED)


def _write_config(log: Path, target: Path, config: Path | None, options: "list[Option]", force: bool) -> None:
    from vvdp.base.display import readable
    from vvdp.base.tables import write_new
    from vvdp.offline.config import SOURCES, load_estimation
    from vvdp.offline.config_text import config_text
    from vvdp.offline.guess import guessed_options

    given = {option.key for option in options}
    with _looked_at(log, options) as source:
        if config is None and not given & {f"sensor.{key}" for key in SOURCES}:
            options = [*options, *(found for found in guessed_options(source) if found.key not in given)]
        wanted = load_estimation(config, options)
        write_new(target, config_text(wanted, source.channels(), readable(log.name)), force=force)
    channel = wanted.source.channel
    typer.echo(f"{target} written, with the edges from {channel!r}; run it with: vvdp estimate {log} --config {target}")


def _looked_at(log: Path, options: "list[Option]") -> "Log":
    """The log, opened to see what channels it has."""
    from vvdp.base.kinds import FREQUENCY
    from vvdp.base.units import parse
    from vvdp.logs.source import open_log

    text = {option.key: str(option.value) for option in options}
    rate = 1.0 if "sensor.edges" in text and "log.time" not in text else None
    if "log.sample_rate" in text:
        rate = parse(text["log.sample_rate"], FREQUENCY)
    return open_log(log, time=text.get("log.time"), rate=rate)


def _nothing_named(log: Path, options: "list[Option]") -> "ConfigError":
    """The channels that there are, and how to go on with those that are probably meant."""
    from vvdp.base.errors import ConfigError, Fault, unusable
    from vvdp.offline.guess import guessed_options

    with _looked_at(log, options) as source:
        channels, guessed = source.channels(), guessed_options(source)
    if not channels:
        return unusable(log, "has no channels of numbers")
    named = "\n".join(f"  {info.name}{f' [{info.unit}]' if info.unit else ''}" for info in channels)
    words = {"sensor.wave": "--wave", "sensor.counts": "--counts", "sensor.edges": "--edges",
             "sensor.falling": "--falling", "pressure.channel": "--pressure"}  # fmt: skip
    command = shlex.join(["vvdp", "estimate", str(log)])
    probably = shlex.join(part for option in guessed for part in (words[option.key], str(option.value)))
    message = (
        "no channel is named that holds the edges; give --wave, --counts or --edges with one of its channels, which "
        f"are\n{named}\nprobably:  {command} {probably}\n"
        f"or write a config to start from:  {command} --write-config {shlex.quote(f'{log.stem}.toml')}"
    )
    return ConfigError([Fault(str(log), 0, "", message)])


def _origin(config: Path | None, options: "list[Option]") -> dict[str, Any]:
    from vvdp.base.display import readable
    from vvdp.cli.screen import typed_command

    return {
        "command": [*typed_command()],
        "config": readable(str(config)) if config is not None else None,
        "options": {option.name: option.value for option in options},
    }


def _flat(found: "Result", wanted: "Estimation") -> dict[str, Any]:
    """The numbers of an estimation as one flat object."""
    from vvdp.offline.result import SOURCES
    from vvdp.offline.wheel_charts import RIPPLES
    from vvdp.results.result import Grade, json_value, plain_values

    return {
        "verb": found.verb,
        "edge_source": SOURCES[type(wanted.source)][0],
        **{key: json_value(each) for key, each in found.numbers.items()},
        "ripple_orders": plain_values(found.tables[RIPPLES].columns["order"]),
        "finished": found.finished,
        "wall_time_s": found.seconds,
        "warnings": [f"{each.title}: {each.text}" for each in found.findings if each.grade is not Grade.PLAIN],
    }
