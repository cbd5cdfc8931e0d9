"""Runs a study: the cases that are missing, in compiled batches, each kept where it was run as soon as it is done."""

import functools
import hashlib
import math
import signal
import threading
import time
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from types import FrameType

import numpy as np

from vvdp.base.display import value_text
from vvdp.base.errors import ConfigError, Fault, RunError
from vvdp.base.kinds import NUMBER, Kind
from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced, Table, copy_tables, nearest, with_settings
from vvdp.base.version import VERSION
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.overview import warnings
from vvdp.evaluation.quantities import quantities
from vvdp.evaluation.summary import simulated_summary
from vvdp.network.nodes import DrivenShaft
from vvdp.results.result import Column
from vvdp.simulation.batch import case_shape, simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.layout import case_form
from vvdp.simulation.link import link, quiet
from vvdp.simulation.outcome import Outcome, Window
from vvdp.simulation.run import compiled_loop
from vvdp.simulation.values import flat, form, leaf_paths
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.results import Doubt, Failure, StudyResults
from vvdp.studies.store import Finished, finished_cases, opened_store
from vvdp.studies.study import Settings, Study
from vvdp.studies.work import Batching, check_same, kept_batches
from vvdp.systems.drawn_parts import setting_path
from vvdp.systems.options import lasting
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import System, load_system


def silent(done: int, total: int) -> None:
    """Says nothing: the default listener to progress."""


@dataclass(frozen=True)
class _Planned:
    """A case of a study that fits its system: its key, what may share a batch with it, and its inputs."""

    number: int
    settings: Settings
    key: str
    group: str
    digest: str
    inputs: Mapping[str, tuple[float | str, Kind]]


def run_study(
    study: Study,
    directory: Path | str,
    *,
    engine: Engine = HERE,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
) -> StudyResults:
    """The results of all cases of `study`; those that `directory` already has are not run again.

    A case is known by its resolved values, stepping, equations and the version of vvdp: where one of these has
    changed, it is run again. `engine` says where: in this process, by default. A worker keeps a batch
    when it is done, here if it does not see `directory`, and `progress` is informed of it (cases done, of all). Ctrl-C
    ends the study after the current batches, at once the second time; running it again resumes it.

    Raises ConfigError, before anything is run, with every setting that does not fit, every unknown output, and a
    directory that cannot be used; RunError where a worker has another vvdp, or none is left.
    """
    began = time.perf_counter()
    directory = Path(directory)
    base = _base(study)
    planned = _plan(study, base, say)
    _check_outputs(study, base)
    describing = {"vvdp": VERSION, "system": resolved_text(base), "cases": len(planned)}
    finished = opened_store(directory, describing)
    pending = list({case.key: case for case in planned if case.key not in finished}.values())
    pending.sort(key=lambda case: case.group)
    if len(pending) < len(planned):
        say(f"{len(planned) - len(pending)} of {len(planned)} cases are finished already")
    progress(len(planned) - len(pending), len(planned))
    ran = 0
    if pending:
        compiled_loop(say)  # here, so that workers find it compiled
    task = functools.partial(_finished_batch, base, VERSION)
    batching = Batching(group=attrgetter("group"))
    with hold_interrupts() as interrupted:
        for done in kept_batches(task, pending, directory, engine, interrupted, batching):
            finished |= {case.key: case for case in done}
            ran += len(done)
            progress(len(planned) - len(pending) + ran, len(planned))
    results = _results(study, base, directory, planned, finished)
    return replace(results, ran=ran, seconds=time.perf_counter() - began)


def read_study(study: Study, directory: Path | str) -> StudyResults:
    """Results of `study` in `directory`, without running anything."""
    base = _base(study)
    planned = _plan(study, base, quiet)
    _check_outputs(study, base)
    return _results(study, base, Path(directory), planned, finished_cases(Path(directory)))


def _base(study: Study) -> System:
    if isinstance(study.system, str):
        return load_system(study.system, study.settings, study.until)
    if not study.settings and study.until is None:
        return study.system
    table = with_settings(study.system.table, list(study.settings))
    return study.system.read_from(table if study.until is None else lasting(table, study.until, study.settings))


def _build_system(base: System, settings: Settings) -> System:
    """The system of one case."""
    texts = [f"{key}={value}" for key, value in settings.items() if not isinstance(value, Mapping)]
    varied = with_settings(base.table, texts)
    content = copy_tables(varied.content)
    for key, value in settings.items():
        if isinstance(value, Mapping):
            *tables, entry = key.split(".")
            inner = content
            for name in tables:
                inner = inner.setdefault(name, {})
            inner[entry] = dict(value)
    return base.read_from(Table(varied.place, content, varied.lines))


def _plan(study: Study, base: System, say: Callable[[str], None]) -> list[_Planned]:
    """Every case, checked. Raises ConfigError with the faults of all of them, each said once."""
    digests: dict[str, str] = {}
    shapes: dict[Hashable, str] = {}
    planned: list[_Planned] = []
    refused: dict[tuple[str, str], list[int]] = {}
    cases = study.cases
    if not cases:
        raise ConfigError([Fault("study", 0, "", "has no cases; expected values to vary")])
    for number, settings in enumerate(cases):
        try:
            system = _build_system(base, settings)
        except ConfigError as problem:
            for fault in problem.faults:
                refused.setdefault((fault.key, fault.message), []).append(number)
            continue
        alike = (system.circuit.digest, case_form(system.case, {}))
        if alike not in shapes:
            told = repr((system.circuit.digest, case_shape(system.case)))
            shapes[alike] = hashlib.sha256(told.encode()).hexdigest()
        shape = shapes[alike]
        if shape not in digests:
            try:
                digests[shape] = link(system.model, system.case, say=say).digest
            except RunError as problem:
                refused.setdefault(("", str(problem)), []).append(number)
                continue
        planned.append(_planned_case(number, settings, system, shape, digests[shape]))
    if refused:
        raise ConfigError([Fault(_places(numbers), 0, *what) for what, numbers in refused.items()])
    return planned


def _planned_case(number: int, settings: Settings, system: System, shape: str, digest: str) -> _Planned:
    stepping = repr(system.stepping)
    return _Planned(
        number=number,
        settings=settings,
        key=_key(system, digest, stepping),
        group=f"{shape} {stepping}",
        digest=digest,
        inputs=_inputs(system, settings),
    )


def _places(numbers: list[int]) -> str:
    others = f" and {len(numbers) - 1} more" if len(numbers) > 1 else ""
    return f"case {numbers[0]}{others}"


def _key(system: System, digest: str, stepping: str) -> str:
    """The identity of a case: every resolved number, and everything else that its results depend on."""
    found = hashlib.sha256(repr((VERSION, digest, system.circuit.digest, stepping)).encode())
    case = system.case
    programs = (*case.memory.values(), *case.settings.values())
    shafts = (node for node in system.circuit.network.nodes.values() if isinstance(node, DrivenShaft))
    found.update(repr([shaft.rated_power for shaft in shafts]).encode())
    for part in (case.state, case.params, case.command, *programs, *system.tables.values()):
        found.update(_names(form(part, {})))
        found.update(flat(part).tobytes())
    return found.hexdigest()


@functools.lru_cache(maxsize=1000)
def _names(form: Hashable) -> bytes:
    """The names in all values of one form."""
    return repr(list(leaf_paths(form))).encode()


def _inputs(system: System, settings: Settings) -> dict[str, tuple[float | str, Kind]]:
    """Value [SI] and kind of what a case sets; text for a value that changes over time or is none."""
    rows = {f"{row.table}.{row.key}": row for row in system.rows}
    found = {key: rows.get(setting_path(system.content, key)) for key in settings}
    return {key: (str(settings[key]), NUMBER) if row is None else _input(row) for key, row in found.items()}


def _input(row: Sourced) -> tuple[float | str, Kind]:
    value = row.value.base if isinstance(row.value, Signal) and row.value.is_constant else row.value
    return (row.display_text if isinstance(value, Signal | tuple) else value), row.kind


def _check_outputs(study: Study, base: System) -> None:
    """Refuses outputs that no summary of `base` has."""
    state = flat(base.case.state)
    window = Window(begin=0.0, end=1.0, first=state, last=state, periods=1, settled=True)
    still = Outcome(
        model=base.model,
        case=base.case,
        window=window,
        final=state,
        low=state,
        high=state,
        end=1.0,
        steps=0,
        rejected=0,
        evaluations=0,
        stiff=False,
        seconds=0.0,
        finished=True,
        memory=base.case.memory,
    )
    more = additions(base)
    own = () if more is None else (*more.CLOSED_FORMS, *more.QUANTITIES)
    known = [*simulated_summary(still, base), *own]
    unknown = [name for name in study.outputs if name not in known]
    if unknown:
        raise ConfigError([Fault("study", 0, name, f"no such output{nearest(name, known)}") for name in unknown])


def _finished_batch(base: System, version: str, batch: Sequence[_Planned], cores: int) -> list[Finished]:
    """Results of a batch, in the process that runs it."""
    systems = [_build_system(base, case.settings) for case in batch]
    one = systems[0]
    cases = [system.case for system in systems]
    run = simulate_batch(one.model, cases, one.stepping, Crew(cores))
    check_same((VERSION, run.digest), (version, batch[0].digest))
    done: list[Finished] = []
    for number, (planned, system) in enumerate(zip(batch, systems, strict=True)):
        reason, found = run.reasons[number], run.outcome(number)
        summary = simulated_summary(found, system) if found else {}
        done.append(Finished(planned.key, planned.settings, reason, summary))
    return done


def _results(
    study: Study, base: System, directory: Path, planned: Sequence[_Planned], finished: Mapping[str, Finished]
) -> StudyResults:
    rows, doubts = _judged_rows(study, base, planned, finished)
    names = list(dict.fromkeys(key for case in planned for key in case.inputs))
    unset = _inputs(base, dict.fromkeys(names, ""))
    known = quantities(base)
    return StudyResults(
        study=study,
        system=base,
        directory=directory,
        inputs={name: _column(name, [case.inputs.get(name, unset[name]) for case in planned]) for name in names},
        outputs={
            name: Column(
                np.array([float(row.get(name, np.nan)) for row in rows]),
                *known.get(name, (NUMBER, name.replace("_", " "))),
            )
            for name in study.outputs
        },
        failures=tuple(
            Failure(case.number, case.settings, done.failure)
            for case in planned
            if (done := finished.get(case.key)) and done.failure
        ),
        doubts=doubts,
        missing=tuple(case.number for case in planned if case.key not in finished),
    )


def _judged_rows(
    study: Study, base: System, planned: Sequence[_Planned], finished: Mapping[str, Finished]
) -> tuple[list[Mapping[str, float | bool]], tuple[Doubt, ...]]:
    """The numbers of each case, closed forms among them where the study asks for some, and what is to be known of
    them."""
    more = additions(base)
    closed_forms = more is not None and not set(more.CLOSED_FORMS).isdisjoint(study.outputs)
    rows: list[Mapping[str, float | bool]] = []
    doubted: dict[str, tuple[str, list[int]]] = {}
    for case in planned:
        row = finished[case.key].summary if case.key in finished else {}
        system = _build_system(base, case.settings) if row and (closed_forms or _is_doubtful(row)) else None
        if system is not None and _is_doubtful(row):
            for text in warnings(system, row):
                doubted.setdefault(text.partition(":")[0], (text, []))[1].append(case.number)
        if closed_forms and system is not None and (own := additions(system)):
            row = {**row, **own.closed_forms(row)}
        rows.append(row)
    return rows, tuple(Doubt(text, tuple(cases)) for text, cases in doubted.values())


def _is_doubtful(row: Mapping[str, float | bool]) -> bool:
    """Whether something is to be known before the numbers of a case."""
    held = all(row.get(flag, True) for flag in ("trusted", "within_validity", "settled"))
    return not held or any(math.isnan(row.get(key, 0.0)) for key in ("efficiency", "loss_transition_W"))


def _column(name: str, values: Sequence[tuple[float | str, Kind]]) -> Column:
    numbers = [value for value, _ in values if not isinstance(value, str)]
    if len(numbers) == len(values):
        return Column(np.array(numbers, float), values[0][1], name)
    texts = [value if isinstance(value, str) else value_text(value, kind) for value, kind in values]
    return Column(np.array(texts), None, name)


@contextmanager
def hold_interrupts() -> Iterator[threading.Event]:
    """Within the block the first Ctrl-C only sets the event that is handed out: what is at hand is still finished."""
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked
        return

    def hold(number: int, frame: FrameType | None) -> None:
        if asked.is_set():
            raise KeyboardInterrupt
        asked.set()

    before = signal.signal(signal.SIGINT, hold)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
