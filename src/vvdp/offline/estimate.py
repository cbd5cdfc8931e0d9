"""From a measured log to angle and speed, in one pass and in bounded memory.

The record goes by in portions, through five stages: clock, edges, debounce, filter, writer (`passes`). A smoother,
where asked for, is a second pass over the edges that were written.
"""

import hashlib
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from vvdp.base.display import readable
from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.base.files import write_whole
from vvdp.logs.channel import Log
from vvdp.logs.source import open_log
from vvdp.offline.beginning import Beginning, apply_verdict, at_pace, beginning, edges_looked_at
from vvdp.offline.config import Estimation, Stamps, Wave, source_channels
from vvdp.offline.config_text import config_text
from vvdp.offline.course import Explanation
from vvdp.offline.diagnostics import SHARE_MISSED, numbers_in_doubt, settings_of, summary
from vvdp.offline.estimate_result import SMOOTHED, Store
from vvdp.offline.facts import ripple_words
from vvdp.offline.findings import explain_no_result, findings
from vvdp.offline.hindsight import View, count_deviation, look_back
from vvdp.offline.interrupt import catch_interrupt
from vvdp.offline.lost_sensor import settle_silences, silences
from vvdp.offline.noise_fit import Explained, fit_noise, fitted_filter
from vvdp.offline.passed_edges import longest_pieces
from vvdp.offline.passes import FilteringPass, GatheringPass, pascals
from vvdp.offline.result import Outcome, estimate_result
from vvdp.offline.second_pass import SecondPass
from vvdp.offline.speed_doubt import Doubt, doubt_of
from vvdp.offline.sums import RowSums, Sums, Tally, edge_sums, has_rows, row_sums, standstills
from vvdp.results.result import Result
from vvdp.results.store import write_result
from vvdp.sensing.wheel import TURN
from vvdp.simulation.link import quiet

CONFIG = "estimate.toml"
"""Every setting, also the defaults; a config for the next estimation."""
FITTED_EDGES = 20_000
"""The settings of the filter are fitted to so many edges at the beginning of the log."""


def open_for_estimate(path: Path, wanted: Estimation) -> Log:
    """The log, opened with the clock that was named; columns of edge times need none.

    Raises ConfigError where it cannot be read, or lacks a channel that is asked for.
    """
    if isinstance(wanted.source, Stamps):
        return _opened_stamps(path, wanted)
    log = open_log(path, time=wanted.time, rate=wanted.sample_rate, time_unit=wanted.time_unit)
    check_channels(log, wanted)
    return log


def _opened_stamps(path: Path, wanted: Estimation) -> Log:
    faults = [
        Fault("log", 0, word, "edge times are a clock themselves; leave it out")
        for word, value in (("time", wanted.time), ("sample_rate", wanted.sample_rate))
        if value is not None
    ]
    if wanted.pressure is not None:
        faults.append(
            Fault("pressure", 0, "", "a pressure needs a clock of its own, which a table of edge times does not have")
        )
    if faults:
        raise ConfigError(faults)
    log = open_log(path, rate=1.0)  # rows are counted, their times are of no use
    check_channels(log, wanted)
    try:
        log.portions(source_channels(wanted), 1)
    except ConfigError:
        log.close()
        log = open_log(path)  # a file whose channels have a clock
    return log


def check_channels(log: Log, wanted: Estimation) -> None:
    """Raises ConfigError for every channel that the log does not have, and for units that are none; the log is closed
    then."""
    faults: list[Fault] = []
    for name in source_channels(wanted):
        try:
            log.channel(name)
        except ConfigError as problem:
            faults.extend(problem.faults)
    if wanted.pressure is not None:
        try:
            pascals(log, wanted.pressure)
        except ConfigError as problem:
            faults.extend(problem.faults)
    if faults:
        log.close()
        raise ConfigError(faults)


def estimate(
    log: Log,
    wanted: Estimation,
    folder: Path,
    *,
    progress: Callable[[float], None] = lambda done: None,
    say: Callable[[str], None] = quiet,
    more: Mapping[str, object] | None = None,
) -> Result:
    """Runs an estimation over a log, writes all of it into `folder`, and gives the result.

    progress  receives the share that is done of the log, or with `smooth` of both passes over it, 0 to 1;
              KeyboardInterrupt raised there, and Ctrl-C, end the pass where it is, and all that was reached is kept
    more      is added to meta.json
    Raises ConfigError where the log has no edges to go by or the file is damaged, KeyboardInterrupt where it ended
    before anything was reached.
    """
    began = time.perf_counter()
    beginning, wanted = _look_at_beginning(log, wanted)
    wanted = _fit_settings(log, wanted, beginning, say)
    with Store(folder / "result.h5") as store:
        run = FilteringPass(log, wanted, store, say, beginning)
        passes = 2.0 if wanted.smooth else 1.0
        run.through(lambda done: progress(done / passes))
        with catch_interrupt():  # the second pass heeds Ctrl-C itself; all else is done to the end, in seconds
            store.flush()
            if not has_rows(store.file):
                if run.tally.interruptions:
                    raise KeyboardInterrupt
                raise unusable(log.path, explain_no_result(run.tally, wanted))
            _report_skipped(run)
            sums = _settle(run)
            if wanted.smooth:
                _smooth(store, sums, wanted, say, lambda done: progress((1.0 + done) / passes))
                look_back(store.file, _view(sums.explained, sums.doubt, wanted), "smoothed_")
            outcome = _outcome(run, sums, wanted, began)
            result = estimate_result(outcome)
            write_whole(folder / CONFIG, outcome.config)
            write_result(folder, result, "", more=_meta(outcome) | dict(more or {}))
            return result


def _settle(run: FilteringPass) -> Sums:
    """Results of the record, all of it known; lost sensors and doubt are written into its rows."""
    file, wanted, tally = run.store.file, run.wanted, run.tally
    lost = silences(file, standstills(file, tally.rate), tally.sectors, wanted.largest_deceleration)
    settle_silences(file, lost, wanted.sections, tally.sectors)
    told = _explain(run.store, wanted)
    doubt = _doubt(file, told, wanted, tally)
    look_back(file, _view(told, doubt, wanted))
    return Sums(
        tally=tally,
        rows=row_sums(file, tally.rate),
        edges=edge_sums(file, tally.sectors),
        explained=told,
        doubt=doubt,
        silences=lost,
    )


def _doubt(file: Any, told: Explained | None, wanted: Estimation, tally: Tally) -> Doubt:
    """What the rows leave out: of the speed, and of the count of edges."""
    many = tally.missed > SHARE_MISSED * (tally.edges + tally.missed)
    miscounted = count_deviation(file, many=many)
    return doubt_of(told, wanted.filter.ripple_order).with_count(miscounted, TURN / tally.sectors)


def _view(told: Explained | None, doubt: Doubt, wanted: Estimation) -> View:
    ripple = wanted.filter.ripple_variance if wanted.filter.ripple_order > 0.0 else 0.0
    return View(_explanation(told, wanted), doubt, ripple, TURN / len(wanted.wheel.edges))


def _explanation(told: Explained | None, wanted: Estimation) -> Explanation | None:
    """What rows are judged with; None if it is not known, or if a row has been made of more than the edges."""
    if told is None or (wanted.pressure is not None and wanted.pressure.fused):
        return None
    offsets, estimated = told.offsets, None
    if told.ripple is not None:
        offsets = offsets + told.ripple.offsets(np.array(wanted.wheel.edges))
        estimated = told.ripple if told.ripple.order == wanted.filter.ripple_order else None
    return Explanation(told.fit.noise, told.used.edge_variance, offsets, estimated)


def _report_skipped(run: FilteringPass) -> None:
    """Notes when isolated edges were ignored; the time base does not reach out to them."""
    times, count = run.tally.left_out_times, run.tally.left_out
    if not times:
        return
    named = ", ".join(f"{time:.6g}" for time in times) + (" s and on" if count > len(times) else " s")
    ignored = "one isolated edge was" if count == 1 else f"{count} isolated edges were"
    run.log.remark(f"{ignored} ignored, at {named}")


def _explain(store: Store, wanted: Estimation) -> Explained | None:
    """What the edges that were written are best explained by; None where they are too few."""
    used = settings_of(wanted)
    passed = longest_pieces(store.file, used.edge_variance)
    return None if passed is None else fit_noise(passed, len(wanted.wheel.edges), used, wanted.sections)


def _smooth(
    store: Store, sums: Sums, wanted: Estimation, say: Callable[[str], None], progress: Callable[[float], None]
) -> None:
    """Adds the smoothed columns; it may be interrupted."""
    store.columns("", SMOOTHED, store.file["piece"].shape[0])
    ripple = None if sums.explained is None else sums.explained.ripple
    told = ripple if ripple is not None and ripple.order == wanted.filter.ripple_order else None
    second = SecondPass(store.file, wanted, told, say)
    with catch_interrupt() as check:
        if stopped := second.through(progress, check):
            sums.tally.interruptions.append(stopped)


def _outcome(run: FilteringPass, sums: Sums, wanted: Estimation, began: float) -> Outcome:
    """What a run came to, with all rows of result.h5 written."""
    log, tally, seconds = run.log, run.tally, time.perf_counter() - began
    covered = tally.rate * tally.measured
    share = min(sums.rows.count / covered, 1.0) if covered > 0.0 else np.nan
    found = summary(sums, wanted) | {"estimated_share": share}
    return Outcome(
        log=log.path,
        wanted=wanted,
        wave_unit=log.channel(wanted.source.channel).unit if isinstance(wanted.source, Wave) else "",
        file=run.store.file,
        sums=sums,
        excerpt=run.excerpt,
        summary=found,
        findings=findings(found, sums, wanted, log),
        config=config_text(wanted, log.channels(), readable(log.path.name)),
        remarks=tuple(log.remarks),
        log_sha256=_hash(log.path),
        seconds=seconds,
    )


def _meta(outcome: Outcome) -> dict[str, Any]:
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "log": str(outcome.log),
        "log_bytes": outcome.log.stat().st_size,
        "log_sha256": outcome.log_sha256,
        "remarks": list(outcome.remarks),
        "finished": not outcome.sums.tally.interruptions,
        "seconds": outcome.seconds,
    }


def _look_at_beginning(log: Log, wanted: Estimation) -> tuple[Beginning, Estimation]:
    """What the first edges of the log say of the wheel and of the clock, and the estimation that takes the wheel so."""
    run = GatheringPass(log, wanted)
    run.through(most_edges=edges_looked_at(wanted.wheel))
    if run.tally.interruptions:
        raise KeyboardInterrupt
    found = beginning(run.found, wanted)
    wanted = apply_verdict(wanted, found.verdict)
    return found, replace(wanted, filter=at_pace(wanted.filter, found.period))


def _fit_settings(log: Log, wanted: Estimation, beginning: Beginning, say: Callable[[str], None]) -> Estimation:
    """The estimation with the settings that the beginning of the log speaks for, if it asks for them."""
    if not wanted.fit:
        return wanted
    with TemporaryDirectory() as place, Store(Path(place) / "first.h5") as store:
        run = FilteringPass(log, wanted, store, say, beginning)
        run.through(most_edges=FITTED_EDGES)
        if run.tally.interruptions:
            raise KeyboardInterrupt
        store.flush()
        told = _explain(store, wanted)
        doubt = _doubt(store.file, told, wanted, run.tally)
        sums = Sums(run.tally, RowSums(), edge_sums(store.file, run.tally.sectors), told, doubt)
    if told is None or numbers_in_doubt(told, sums, wanted):
        why = "the log is too short" if told is None else "which edge is which is in doubt, too much"
        log.remark(f"{why} for a fit of the filter's settings; they were left as they were")
        return replace(wanted, fit=False)
    if told.ripple is not None:
        log.remark(f"{ripple_words(told.ripple, told.candidates)}; taken for ripple")
    return replace(wanted, fit=False, filter=fitted_filter(wanted.filter, told))


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
