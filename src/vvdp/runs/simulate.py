"""A system simulated: from values to a run with its summary, and into a directory."""

import hashlib
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from vvdp.base.files import write_listed, write_whole
from vvdp.base.tables import parsed_table, with_settings
from vvdp.evaluation.accuracy import FINER, Move, moves
from vvdp.evaluation.overview import warnings
from vvdp.evaluation.pipe_waves import pipes
from vvdp.evaluation.quantities import quantities, summary_units
from vvdp.evaluation.summary import Summary, closed_forms, summary
from vvdp.hydraulics.pipe import LinePipe
from vvdp.results.result import Number, json_value
from vvdp.runs.run import RecordedRun
from vvdp.simulation.link import quiet
from vvdp.simulation.record import record_of
from vvdp.simulation.results import Results, origin, write_results
from vvdp.simulation.run import Run, simulate
from vvdp.systems.own_modules import OwnModule
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import System, built_system

FLAGS = ("energy_residual", "mass_residual", "second_law", "within_validity", "trusted")
"""Keys of a summary that say whether a run is to be trusted."""


def run_system(
    system: System,
    *,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
    say: Callable[[str], None] = quiet,
    command: Sequence[str] = (),
    checked: bool = False,
) -> RecordedRun:
    """Simulates a system to its end, or to where `stop` or Ctrl-C ends it, which is kept.

    `progress` receives the time reached [s]; `command` is what was typed; `checked` as of `simulate`. Raises RunError
    where the simulation fails.
    """
    done = simulate(system.model, system.case, system.stepping, progress=progress, stop=stop, say=say, checked=checked)
    return recorded_run(system, done, command)


def recorded_run(
    system: System,
    done: Run,
    command: Sequence[str] = (),
    summarise: Callable[[System, Run], Summary] | None = None,
) -> RecordedRun:
    """A simulated run with its summary and origin. Raises KeyboardInterrupt where it was stopped before its first step.

    `command` is what was typed. With `run_summary` to `summarise` it, `with_closed_forms` is still to be called.
    """
    if not done.end > done.stepping.begin:
        raise KeyboardInterrupt  # nothing to keep
    found = (summarise or summary)(system, done)
    balances = {key: found[key] for key in FLAGS if key in found}
    meta: dict[str, Any] = origin(done) | {
        "system": system.name,
        "title": system.title,
        "circuit": system.circuit_name,
        "command": list(command),
        "assumed_values": len(system.assumptions),
        "written": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
    }
    if system.module is not None:
        meta["module"] = system.module.flat
    return RecordedRun(system, record_of(done), found, meta | balances, done=done)


def with_closed_forms(run: RecordedRun) -> RecordedRun:
    """A run of which `run_summary` is known, with its whole summary."""
    return replace(run, summary={**run.summary, **closed_forms(run.system, run.summary)})


def json_summary(run: RecordedRun) -> dict[str, Any]:
    """A run as `vvdp run --json` prints it: its summary with counts as whole numbers, and its warnings."""
    known = quantities(run.system)
    found = {
        key: json_value(Number(value, *known[key])) if key in known and isinstance(value, float) else value
        for key, value in run.summary.items()
    }
    return {"system": run.system.name, **found, "warnings": list(warnings(run.system, run.summary))}


def check_accuracy(run: RecordedRun, progress: Callable[[float], None] | None = None) -> tuple[Move, ...]:
    """How the numbers of a run change at a tenth of its tolerance, the largest change first; empty if interrupted.

    Pipes of a drawn circuit have twice their pieces in the second run; what is within them is left out.
    """
    finer = _with_finer_pipes(run.system)
    stepping = run.system.stepping
    tighter = replace(stepping, relative_tolerance=max(1e-13, FINER * stepping.relative_tolerance))
    done = simulate(finer.model, finer.case, tighter, progress=progress)
    if not done.finished:
        return ()
    inner = [f"_{piece}_" for pipe in pipes(run.system).values() for piece in (*pipe.nodes, *pipe.parts)]
    found = {key: value for key, value in run.summary.items() if not any(each in key for each in inner)}
    return moves(found, summary(finer, done), summary_units(finer))


def _with_finer_pipes(system: System) -> System:
    """The same system with pipes of twice as many pieces, where its file draws them."""
    table = parsed_table(resolved_text(system), system.name)
    drawn = table.content.get("components", {})
    twice = [
        f"components.{name}.pieces={2.0 * pipe.values.pieces:g}"
        for name, pipe in pipes(system).items()
        if isinstance(pipe.values, LinePipe) and name in drawn
    ]
    return built_system(with_settings(table, twice), system.name) if twice else system


def save_run(folder: Path, run: RecordedRun) -> None:
    """Writes a run into `folder`, with a copy of the module that drew its circuit: to be looked at, it is never run."""
    if run.system.module is not None:
        _copy_module(folder, run.system.module)
    write_results(folder, Results(folder, resolved_text(run.system), run.summary, run.meta, run.record))


def _copy_module(folder: Path, module: OwnModule) -> None:
    name, content = f"{module.name.replace('.', '/')}.py", module.path.read_bytes()
    if name.isascii() and hashlib.sha256(content).hexdigest() == module.sha256:
        with write_listed(folder, [name]):
            write_whole(folder / name, content)
