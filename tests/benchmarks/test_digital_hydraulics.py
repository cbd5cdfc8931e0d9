"""The benchmark set: what is expected follows from what is given, and vvdp's answers are its own."""

import importlib.util
import itertools
import math
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.benchmarks.hard_references import REFERENCES

from benchmarks import digital_hydraulics as own
from benchmarks import hard_circuits

ROOT = Path(__file__).parents[2]
SET = own.SET
CASES = sorted(path.parent.name for path in SET.glob("*/case.toml"))
QUICK = ("volume-blowdown", "hose-swing", "rotary-valve-2012", "digital-flow-control-unit", *hard_circuits.HARD)


def _checker() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check", SET / "check.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


CHECK = _checker()


def definition(case: str) -> dict:
    return tomllib.loads((SET / case / "case.toml").read_text("utf-8"))


def given(case: str) -> dict[str, float]:
    return {name: value["value"] for name, value in definition(case)["given"].items()}


def expected(case: str) -> dict[str, float]:
    return {row["quantity"]: float(row["expected"] or "nan") for row in CHECK.read_table(SET / case / "expected.csv")}


def answer_of(case: str) -> Path:
    path = own.ANSWERS / f"{case}.csv"
    return path if path.is_file() else path.with_suffix("")


def check(*arguments: object) -> subprocess.CompletedProcess[str]:
    """The checker as another tool's author runs it, without the environment of vvdp."""
    command = [sys.executable, "-I", SET / "check.py", *arguments]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)


@pytest.mark.parametrize("case", CASES)
def test_asked_is_expected_in_the_same_units_and_vvdp_answers_it(case):
    table = CHECK.read_table(SET / case / "expected.csv")
    asked = definition(case)["asked"]
    assert [row["quantity"] for row in table] == list(asked)
    assert all(row["unit"] == asked[row["quantity"]]["unit"] for row in table)
    assert all(row["source"] and (row["lower"] or row["upper"]) for row in table)
    assert f"Status: {definition(case)['status']}" in (SET / case / "source.md").read_text("utf-8")
    assert set(CHECK.read_answer(case, answer_of(case))) == set(asked)
    done = check(case, answer_of(case))
    assert (done.returncode, done.stdout.count("within")) == (0, len(table))


def test_page_lists_every_case():
    page = (ROOT / "docs" / "benchmark-set.md").read_text("utf-8")
    listed = dict(re.findall(r"^\| `([\w-]+)` \| [^|]+ \| ([^|]+) \|", page, re.MULTILINE))
    assert listed == {case: definition(case)["status"] for case in CASES}
    assert check("--list").stdout.split() == CASES


def test_emptied_volume_by_small_steps():
    """Explicit steps of a microsecond, no closed form."""
    g = given("volume-blowdown")
    p, wanted = g["start_pressure"], expected("volume-blowdown")
    stiffness = g["bulk_modulus"] / g["volume"] * g["discharge_coefficient"] * g["orifice_area"]
    for step in range(1, 40001):
        p -= 1e-6 * stiffness * math.sqrt(2.0 * p / g["density"])
        if step in (10000, 20000, 40000):
            assert p == pytest.approx(wanted[f"pressure_{step // 1000}_ms"], rel=1e-4)


def test_hose_swings_at_the_root_of_its_equation():
    g = given("hose-swing")
    held = g["tube_length"] * 0.25 * math.pi * g["tube_diameter"] ** 2
    theta = brentq(lambda x: x * math.tan(x) - 0.5 * held / g["end_volume"], 1e-9, 1.57)
    speed = math.sqrt(g["bulk_modulus"] / g["density"])
    assert expected("hose-swing")["frequency"] == pytest.approx(theta * speed / (math.pi * g["tube_length"]), rel=1e-5)


@pytest.mark.parametrize(
    ("case", "ratio"), [("step-up-limit", lambda d: 1.0 / (1.0 - d)), ("step-down-limit", lambda d: d)]
)
def test_limits_of_the_converters(case, ratio):
    for quantity, value in expected(case).items():
        assert value == pytest.approx(ratio(int(quantity[-2:]) / 100.0), rel=1e-5)


def test_limit_of_the_switched_pump_by_quadrature():
    """The flow through each port at 20001 openings, added up, in place of the closed form."""
    g = given("pwm-pump-limit")
    n, r, a = g["drop_opening"], g["drop_behind"], np.linspace(1e-9, 1.0, 20001)
    excess, missing = 0.0, 0.0
    for end in (g["load_pressure"], 0.0):
        held = g["relief_pressure"] - end
        q = np.clip(np.sqrt(held / (n / a**2 + r)), 0.0, 1.0)
        inlet = np.where(q < 1.0, held, n / a**2 + r)
        lost = q * inlet + (1.0 - q) * g["relief_pressure"]
        excess += 2.0 * g["ramp"] * float(np.trapezoid(lost - (n + r), a))
        missing += 2.0 * g["ramp"] * float(np.trapezoid(1.0 - q, a)) if end else 0.0
    wanted = expected("pwm-pump-limit")
    assert wanted["loss"] == pytest.approx(g["pump_flow"] * (n + r + excess), rel=1e-4)
    assert wanted["load_share"] == pytest.approx(g["duty_ratio"] - missing, rel=1e-4)


def test_codes_of_the_flow_control_unit_by_counting():
    """Every combination of open valves, and the pulse as the area under the flows of single valves."""
    g, wanted = given("digital-flow-control-unit"), expected("digital-flow-control-unit")
    unit = g["smallest_flow"] * math.sqrt(g["drop"] / g["rated_drop"])
    for kind, sizes in (("binary", (1, 2, 4, 8, 16)), ("equal", (1,) * 5)):
        sums = {sum(chosen) for k in range(6) for chosen in itertools.combinations(sizes, k)}
        assert (wanted[f"{kind}_states"], max(sums) * unit) == (
            len(sums),
            pytest.approx(wanted[f"{kind}_largest"], rel=1e-5),
        )
    t = np.linspace(0.0, 4e-3, 40001)
    opens, shuts = np.clip(t / g["opening_time"], 0.0, 1.0), np.clip(1.0 - t / g["closing_time"], 0.0, 1.0)
    pulse = float(np.trapezoid(unit * (16.0 * opens + 15.0 * shuts - 16.0), t))
    assert wanted["pulse_15_16"] == pytest.approx(pulse, rel=1e-4)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("case", REFERENCES)
def test_hard_circuits_by_closed_form_or_another_integration(case):
    """Within a fiftieth of the bounds: another processor's rounding alone moves an integration by a quarter of that."""
    found, table = REFERENCES[case](given(case)), CHECK.read_table(SET / case / "expected.csv")
    assert {*found} == {row["quantity"] for row in table} and {*REFERENCES} == {*hard_circuits.HARD}
    for row in table:
        bound = 0.5 * (float(row["upper"]) - float(row["lower"]))
        assert float(found[row["quantity"]]) == pytest.approx(float(row["expected"]), abs=0.02 * bound), row["quantity"]


def test_a_circuit_whose_balances_do_not_close_has_no_answer(monkeypatch):
    monkeypatch.setattr(hard_circuits, "CLOSES", 1e-12)
    with pytest.raises(ValueError, match="gas-corner"):
        hard_circuits.ran("gas-corner")


@pytest.mark.parametrize("case", QUICK)
def test_answers_of_vvdp_are_its_own(case):
    now = own.CASES[case]()
    assert now == pytest.approx(CHECK.read_answer(case, answer_of(case)), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("case", sorted(set(own.CASES) - set(QUICK)))
def test_slow_answers_of_vvdp_are_its_own(case):
    now = own.CASES[case]()
    assert now == pytest.approx(CHECK.read_answer(case, answer_of(case)), rel=1e-4)


def test_speeds_follow_from_the_records(tmp_path):
    own.write_speeds(tmp_path)
    now, before = (CHECK.read_answer("event-filter", each) for each in (tmp_path, answer_of("event-filter")))
    assert now == pytest.approx(before, rel=1e-6)


def test_records_can_be_made_again():
    for name, (scenario, record) in own.scenario_records().items():
        kept = np.loadtxt(SET / "event-filter" / f"{name}.csv", delimiter=",", skiprows=1)
        assert kept[:, 1].sum() == record.readings[:, 1].sum() > 0
        truth = np.loadtxt(SET / "event-filter" / f"{name}-truth.csv", delimiter=",", skiprows=1)
        assert truth[:, 1] == pytest.approx(np.abs(scenario.motion.speed(record.truth.time)), abs=1e-6)


def test_wrong_missing_and_unreadable_answers_are_told(tmp_path):
    wrong = tmp_path / "wrong.csv"
    wrong.write_text("quantity,value\nratio_20,0.3\nratio_40,0.4\n")
    done = check("step-down-limit", wrong)
    assert done.returncode == 1
    assert [done.stdout.count(word) for word in ("OUTSIDE", "within", "missing")] == [1, 1, 1]
    for arguments, words in (
        (("no-such-case", wrong), "no case 'no-such-case'"),
        (("step-down-limit", "none.csv"), "no such file: none.csv"),
    ):
        done = check(*arguments)
        assert (done.returncode, done.stdout) == (2, "") and words in done.stderr


def test_a_speed_that_leaves_out_rows_is_infinitely_wrong():
    truth = [{"time_s": "0.6", "speed_rad_s": "3"}, {"time_s": "0.7", "speed_rad_s": "5"}]
    assert CHECK.speed_error(truth, [{"time_s": "0.7", "speed_rad_s": "5"}], 0.5) == math.inf
    assert CHECK.speed_error(truth, [{"time_s": "0.7", "speed_rad_s": "8"}], 0.65) == pytest.approx(3.0)
