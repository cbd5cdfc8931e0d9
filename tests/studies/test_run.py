"""Running a study: columns, resuming, being killed, changed inputs, failures."""

import csv
import dataclasses
import json
import os
import signal
import time
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, RunError
from vvdp.base.kinds import DUTY_RATIO, FLAG, PRESSURE_LEVEL
from vvdp.evaluation.summary import summary
from vvdp.results.store import table_text
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.run import simulate
from vvdp.studies import run as running
from vvdp.studies.engine import ThisProcess
from vvdp.studies.results import study_result
from vvdp.studies.run import read_study, run_study
from vvdp.studies.study import Random, Study, Uniform
from vvdp.systems.system import load_system

GRID = {"operation.duty_ratio": ["0.4", "0.6"], "relief_valve.cracking_pressure": ["110 bar", "120 bar"]}
OUTPUTS = ("efficiency", "mean_load_flow_m3_s", "analytic_loss_total_W", "trusted")
STUDY = Study("prototype", GRID, OUTPUTS, until="0.1 s")
FAILING = {
    "operation.pump_speed": "-1800 rpm",
    "oil.air_fraction": "0",
    "check_valve.reverse_opening": "0",
    "pump.leakage_conductance": "0 m^3/(s*Pa)",
}


def test_columns_are_those_of_single_runs(tmp_path: Path) -> None:
    heard: list[tuple[int, int]] = []
    found = run_study(STUDY, tmp_path / "s", progress=lambda done, of: heard.append((done, of)))
    assert heard == [(0, 4), (4, 4)]
    assert found.is_finished and found.ran == 4 and not found.failures
    duty, pressure = found.inputs.values()
    assert duty.values.tolist() == [0.4, 0.4, 0.6, 0.6] and duty.kind is DUTY_RATIO
    assert pressure.values.tolist() == [11101325.0, 12101325.0] * 2 and pressure.kind is PRESSURE_LEVEL
    kinds = [column.kind for column in found.outputs.values()]
    assert [kind and kind.unit for kind in kinds] == ["1", "m^3/s", "W", "1"] and kinds[-1] is FLAG
    settings = [f"{key}={value}" for key, value in STUDY.cases[2].items()]
    system = load_system("prototype", settings, until="0.1 s")
    alone = summary(system, simulate(system.model, system.case, system.stepping))
    columns = {name: column.values[2] for name, column in found.outputs.items()}
    assert columns == pytest.approx({name: float(alone.get(name, np.nan)) for name in OUTPUTS}, rel=1e-5, nan_ok=True)


def test_a_study_is_resumed_and_grows_without_running_anything_twice(tmp_path: Path) -> None:
    first = run_study(STUDY, tmp_path)
    again = run_study(STUDY, tmp_path)
    assert (first.ran, again.ran) == (4, 0)
    more = {**GRID, "operation.duty_ratio": ["0.4", "0.5", "0.6"]}
    grown = Study("prototype", more, ("load_power_W",), until="0.1 s")
    assert read_study(grown, tmp_path).missing == (2, 3)
    third = run_study(grown, tmp_path)
    assert third.ran == 2 and third.is_finished
    for name, column in first.outputs.items():
        assert np.array_equal(column.values, again.outputs[name].values, equal_nan=True)


@pytest.mark.parametrize(
    "changed",
    [
        Study("prototype", GRID, OUTPUTS, until="0.11 s"),
        Study("prototype", GRID, OUTPUTS, ("oil.density=870 kg/m^3",), until="0.1 s"),
        Study("prototype", GRID, OUTPUTS, ("run.relative_tolerance=1e-5",), until="0.1 s"),
        Study("prototype", GRID, OUTPUTS, ("motor.rated_power=5 kW",), until="0.1 s"),
        Study("prototype", GRID, OUTPUTS, ("run.method=stiff",), until="0.1 s"),
    ],
)
def test_whatever_changes_the_result_is_run_anew(changed: Study, tmp_path: Path) -> None:
    run_study(STUDY, tmp_path)
    assert len(read_study(changed, tmp_path).missing) == 4


def test_the_same_value_in_other_words_is_the_same_case(tmp_path: Path) -> None:
    run_study(STUDY, tmp_path)
    grid = {"operation.duty_ratio": [0.4, "60 %"], "relief_valve.cracking_pressure": ["11 MPa", "121.01325 bara"]}
    assert read_study(Study("prototype", grid, OUTPUTS, until="100 ms"), tmp_path).is_finished
    loaded = load_system("prototype", until="0.1 s")
    assert read_study(Study(loaded, GRID, OUTPUTS), tmp_path).is_finished


def test_a_newer_version_or_other_equations_run_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_study(STUDY, tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(running, "VERSION", "99")
        assert len(read_study(STUDY, tmp_path).missing) == 4
    monkeypatch.setattr(running, "link", lambda *_, **_options: SimpleNamespace(digest="other equations"))
    assert len(read_study(STUDY, tmp_path).missing) == 4


def test_seeds_are_reproducible(tmp_path: Path) -> None:
    random = Random({"oil.air_fraction": Uniform("0.5 %", "2 %")}, 3, 5)
    one = run_study(Study("prototype", random, ("efficiency",), until="50 ms"), tmp_path / "one")
    two = run_study(Study("prototype", random, ("efficiency",), until="50 ms"), tmp_path / "two", engine=ThisProcess(1))
    for first, second in ((one.inputs, two.inputs), (one.outputs, two.outputs)):
        for name in first:
            assert np.array_equal(first[name].values, second[name].values)
    assert len(set(one.outputs["efficiency"].values)) == 3


def test_failing_cases_are_listed_and_not_tried_again(tmp_path: Path) -> None:
    cases = [{"operation.duty_ratio": "0.4"}, FAILING, {"operation.duty_ratio": "0.6"}]
    study = Study("prototype", cases, ("load_power_W",), until="0.1 s")
    found = run_study(study, tmp_path)
    (failure,) = found.failures
    assert failure.case == 1 and failure.settings == FAILING and "fallen below 0 Pa absolute" in failure.reason
    assert np.isnan(found.outputs["load_power_W"].values).tolist() == [False, True, False]
    # What a case leaves alone stands in its row with the value of the system.
    assert found.inputs["operation.duty_ratio"].values.tolist() == [0.4, 0.5, 0.6]
    assert run_study(study, tmp_path).ran == 0
    result = study_result(found)
    assert result.findings[0].text == wording.study.case_failed.format(case=1, reason=failure.reason)
    assert result.numbers["failed_cases"].value == 1.0 and result.numbers["cases"].value == 3.0
    head, *rows = csv.reader(table_text(result.tables["study"]).splitlines())
    assert head[:2] == ["case", "operation.duty_ratio"] and head[-2:] == ["load_power_W", "failure"]
    assert "operation.pump_speed_rad_s" in head
    assert [float(row[1]) for row in rows] == [0.4, 0.5, 0.6]
    assert float(rows[0][-2]) == found.outputs["load_power_W"].values[0]
    assert rows[1][-2:] == ["", failure.reason]


def test_signals_and_constants_may_be_mixed(tmp_path: Path) -> None:
    step = {"step": ["0.4", "0.6"], "at": "50 ms"}
    cases = [{"operation.duty_ratio": "0.5"}, {"operation.duty_ratio": step}, {"operation.duty_ratio": "0.6"}]
    found = run_study(Study("prototype", cases, ("load_power_W",), until="0.1 s"), tmp_path)
    assert found.is_finished and np.isfinite(found.outputs["load_power_W"].values).all()
    assert found.inputs["operation.duty_ratio"].values.tolist() == [
        "0.5",
        wording.files.corners.format(low=0.4, high=0.6, corners="0.05 s"),
        "0.6",
    ]


def test_a_case_without_whole_periods_gives_what_a_single_run_gives(tmp_path: Path) -> None:
    outputs = ("load_power_W", "averaged_periods")
    study = Study("prototype", [{"operation.duty_ratio": "0.5"}], outputs, until="10 ms")
    found = run_study(study, tmp_path)
    system = load_system("prototype", ["operation.duty_ratio=0.5"], until="10 ms")
    alone = summary(system, simulate(system.model, system.case, system.stepping))
    assert found.outputs["averaged_periods"].values.tolist() == [0.0]
    assert found.outputs["load_power_W"].values == pytest.approx([alone["load_power_W"]], rel=1e-4)


def test_everything_wrong_is_told_before_anything_is_run(tmp_path: Path) -> None:
    grid = {"operation.duty_ratio": ["0.3", "0,5"], "oil.air_friction": ["1 %"]}
    with pytest.raises(ConfigError) as caught:
        run_study(Study("prototype", grid, ("efficiency",)), tmp_path / "s")
    assert [(fault.place, fault.key) for fault in caught.value.faults] == [
        (wording.study.and_more.format(case=0, count=1), "oil.air_friction"),
        ("case 1", "operation.duty_ratio"),
    ]
    with pytest.raises(ConfigError, match="eficiency: " + wording.study.no_such_output + "; did you mean 'efficiency'"):
        run_study(Study("prototype", GRID, ("eficiency",)), tmp_path / "s")
    with pytest.raises(ConfigError, match=wording.study.no_cases):
        run_study(Study("prototype", {"operation.duty_ratio": []}, ("efficiency",)), tmp_path / "s")
    assert not (tmp_path / "s").exists()


def test_a_directory_with_something_else_or_damaged_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ConfigError, match=wording.study.something_else):
        run_study(STUDY, tmp_path)
    run_study(STUDY, tmp_path / "s")
    (tmp_path / "s" / ".cases-1.json.77.tmp").write_text('{"half')  # what a kill may leave
    assert run_study(STUDY, tmp_path / "s").ran == 0
    (path,) = (tmp_path / "s").glob("cases-*.json")
    path.write_text(path.read_text()[:-100])
    with pytest.raises(ConfigError, match=wording.files.is_damaged + " .*; " + wording.study.remove_it):
        run_study(STUDY, tmp_path / "s")
    path.write_text(json.dumps({"format": 99, "cases": []}))
    with pytest.raises(ConfigError, match=wording.study.written_in_format.format(format=99)):
        run_study(STUDY, tmp_path / "s")


@pytest.mark.thorough
@pytest.mark.parametrize("where", ["here", pytest.param("dask", marks=pytest.mark.slow)])
def test_kill_9_at_any_moment_loses_nothing_that_was_finished(
    begin_study, awaited, kept, long_study, tmp_path: Path, where: str
) -> None:
    """Killed with all its processes as it begins, then alone as the first file appears.

    Its workers are then left behind; they may finish what they are at, which counts, and end by themselves.
    """
    directory = tmp_path / "long"
    before: set[str] = set()
    kills = [lambda: (directory / "study.json").exists(), lambda: kept(directory) > before]
    for together, condition in zip((True, False), kills, strict=True):
        process = begin_study(directory, where)
        awaited(condition, process)
        workers = psutil.Process(process.pid).children(recursive=True)
        if together:
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        assert process.wait() == -signal.SIGKILL
        _, alive = psutil.wait_procs(workers, timeout=60.0)
        assert not alive
        assert before <= kept(directory)
        before = kept(directory)
    assert 16 <= len(before) < 120
    found = run_study(long_study, directory)
    assert found.ran == 120 - len(before) and found.is_finished
    assert before <= kept(directory) and len(kept(directory)) == 120
    assert np.isfinite(found.outputs["efficiency"].values).all()


@pytest.mark.slow
def test_kill_9_of_workers_at_random_moments(begin_study, awaited, kept, long_study, tmp_path: Path) -> None:
    """Again and again while cases are run and written, until all are finished; the numbers are those of one run.

    What is killed without workers is in `tests/resuming`.
    """
    directory = tmp_path / "long"
    random = np.random.default_rng(7)
    before: set[str] = set()
    kills = 0
    longest = 2.0
    for _ in range(40):
        process = begin_study(directory, "dask")
        started = time.time()
        awaited(lambda started=started: begun_since(directory, started), process)
        time.sleep(random.uniform(0.0, longest))
        longest *= 1.2  # a busy machine may finish nothing in less
        kills += process.poll() is None
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        assert before <= kept(directory)
        before = kept(directory)
        if len(before) == 120:
            break
    assert kills >= 2 and len(before) == 120
    found = read_study(long_study, directory)
    assert found.is_finished
    once = run_study(long_study, tmp_path / "once")
    assert np.array_equal(found.outputs["efficiency"].values, once.outputs["efficiency"].values)


def begun_since(directory: Path, moment: float) -> bool:
    path = directory / "study.json"
    return path.exists() and path.stat().st_mtime >= moment


@pytest.mark.parametrize("where", ["here", pytest.param("dask", marks=pytest.mark.slow)])
def test_ctrl_c_keeps_the_batches_at_hand(begin_study, awaited, kept, long_study, tmp_path: Path, where: str) -> None:
    """The keys reach all processes of the terminal."""
    directory = tmp_path / "long"
    process = begin_study(directory, where)
    awaited(lambda: kept(directory), process)
    before = kept(directory)
    os.killpg(process.pid, signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert process.returncode == 0 and out == "end\n" and not errors, errors
    assert before <= kept(directory)
    found = read_study(long_study, directory)
    assert len(found.missing) == 120 - len(kept(directory))


def test_a_second_ctrl_c_does_not_wait(tmp_path: Path) -> None:
    asked: list[int] = []

    class Interrupting:
        workers = 1

        def run_all(self, task, items):
            for item in items:
                asked.append(len(item))
                signal.raise_signal(signal.SIGINT)
                signal.raise_signal(signal.SIGINT)
                yield item, task(item, 1)

    with pytest.raises(KeyboardInterrupt):
        run_study(STUDY, tmp_path, engine=Interrupting())
    assert asked == [4] and len(read_study(STUDY, tmp_path).missing) == 4


def test_other_equations_on_a_worker_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def other(*arguments, **options):
        return dataclasses.replace(simulate_batch(*arguments, **options), digest=wording.study.of_another_version)

    monkeypatch.setattr(running, "simulate_batch", other)
    with pytest.raises(RunError, match=wording.progress.other_machine):
        run_study(STUDY, tmp_path)
    assert len(read_study(STUDY, tmp_path).missing) == 4
