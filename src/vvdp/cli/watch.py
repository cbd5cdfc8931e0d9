"""`vvdp run --watch`: a run again whenever a file of the system is saved, and what changed in its summary."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from vvdp.runs.run import RecordedRun
    from vvdp.systems.system import System

LOOK = 0.1
"""Between two looks at the files [s]."""
SAME = 1e-9
"""A number that changed by less than this share of its size has not changed."""
MOST_ROWS = 20
"""Changed numbers that are printed, the largest change first."""


def watch(name: str, load: Callable[[], "System"], show: Callable[["RecordedRun"], None]) -> None:
    """Run the system that `load` reads, `show` the first run, and print what changes after each save, until Ctrl-C.

    An error in the file is reported, and the file is still watched. Raises ParameterError if `name` is no file.
    """
    from vvdp.base.errors import ParameterError, VvdpError
    from vvdp.cli.screen import say
    from vvdp.runs.simulate import run_system

    if not Path(name).is_file():
        raise ParameterError(f"{name} is not a file that could be saved again; copy it with `vvdp new --from {name}`")
    files, before = [Path(name)], None
    try:
        while True:
            seen, began = _stamps(files), time.monotonic()
            try:
                loaded = load()
                files = [Path(name), *([] if loaded.module is None else [loaded.module.path])]
                seen = _stamps(files)
                done = run_system(loaded, say=say)
                if before is None:
                    show(done)
                else:
                    _print_changes(before, done)
                before = done
            except VvdpError as problem:
                say(str(problem))
            names = " or ".join(map(str, files))
            say(f"{time.monotonic() - began:.2f} s; waiting for {names} to be saved (Ctrl-C ends)")
            while _stamps(files) == seen:
                time.sleep(LOOK)
    except KeyboardInterrupt:
        say("watching ended")


def _stamps(files: Sequence[Path]) -> list[tuple[int, int]]:
    """When each file was written, and its size; zeros for one that is not there, as while an editor replaces it."""
    found = []
    for path in files:
        try:
            state = path.stat()
        except OSError:
            found.append((0, 0))
        else:
            found.append((state.st_mtime_ns, state.st_size))
    return found


def _print_changes(before: "RecordedRun", after: "RecordedRun") -> None:
    from vvdp.base.display import value_text
    from vvdp.base.kinds import NUMBER
    from vvdp.cli.screen import console, grid, tell
    from vvdp.evaluation.accuracy import moves
    from vvdp.evaluation.quantities import quantities, summary_units

    known, units = quantities(after.system), summary_units(after.system)
    changed = [move for move in moves(dict(before.summary), dict(after.summary), units) if move.change > SAME]
    gone = sorted(set(before.summary) ^ set(after.summary))
    if not changed and not gone:
        tell("nothing changed in the summary")
        return
    table = grid("quantity", "before", "now", "change", right=("before", "now", "change"))
    for move in changed[:MOST_ROWS]:
        kind, label = known.get(move.key, (NUMBER, move.key))
        old = float(before.summary[move.key])
        share = f"{100.0 * (move.value - old) / abs(old):+.3g} %" if old else ""
        table.add_row(label, value_text(old, kind), value_text(move.value, kind), share)
    console().print(table)
    if len(changed) > MOST_ROWS:
        tell(f"and {len(changed) - MOST_ROWS} more")
    if gone:
        tell(f"only in one of the two: {', '.join(gone)}")


def refuse_together(**given: bool) -> None:
    """Raise BadParameter if an option that `--watch` cannot serve is given."""
    wrong = [name for name, is_given in given.items() if is_given]
    if wrong:
        raise typer.BadParameter(f"--watch writes no results and takes no --{wrong[0].replace('_', '-')}")
