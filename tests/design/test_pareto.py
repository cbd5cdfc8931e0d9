"""The front: nothing beats it, gradients of one objective at a time agree, every design is a system."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.design.infeasibility import InfeasibleError
from vvdp.design.optimise import optimise
from vvdp.design.pareto import USUAL, Objective, front, is_undominated, objectives
from vvdp.design.pareto_result import front_result, write_designs
from vvdp.design.problem import problem
from vvdp.design.proof import Simulated, simulated_designs
from vvdp.design.quantities import quantities, setup
from vvdp.design.solver import Traced
from vvdp.evaluation.summary import summary
from vvdp.report.result_page import write_result_report
from vvdp.results.store import write_result
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

pytestmark = pytest.mark.heavy

LIMITS, BOUNDS = ["pwm_frequency >= 50 Hz", "transition_fraction <= 0.5"], ["radial_clearance <= 25 um"]


@pytest.fixture(scope="module")
def four(prototype):
    return front(problem(prototype, "loss_total", LIMITS, BOUNDS), points=24, generations=20)


@pytest.fixture(scope="module")
def two(prototype):
    """Drop against frequency: a curve."""
    wanted = (Objective("pressure_drop_total", False), Objective("pwm_frequency", True))
    return front(problem(prototype, "pressure_drop_total", LIMITS, BOUNDS), wanted, points=16, generations=15)


def test_undominated_by_hand():
    """(1, 3), (2, 2), (3, 1) stand; (2, 3) is beaten by both first, (3, 3) by all; the twin of (2, 2) stays."""
    costs = np.array([[1, 3], [2, 2], [3, 1], [2, 3], [3, 3], [2, 2]], float)
    assert is_undominated(costs).tolist() == [True, True, True, False, False, True]


def test_nothing_on_the_front_is_beaten(four, two):
    for found in (four, two):
        assert len(found.values) >= 12
        assert np.all(is_undominated(found.costs))
        assert np.all(np.diff(found.costs[:, 0]) >= 0.0)


def test_front_is_within_limits_and_bounds(four):
    for values, row in zip(four.values, four.quantities, strict=True):
        assert row["pwm_frequency"] >= 50.0 * (1.0 - 1e-5)
        assert row["transition_fraction"] <= 0.5 * (1.0 + 1e-5)
        assert all(b.low <= values[b.variable.name] <= b.high for b in four.problem.bounds)


def test_ends_are_the_optima_of_one_objective(four, prototype):
    """With the loss among the objectives, all designs keep the relief valve shut."""
    limits = [*LIMITS, "relief_margin >= 0 bar"]
    for k, each in enumerate(four.objectives):
        if each.large:
            continue
        alone = optimise(problem(prototype, each.quantity, limits, BOUNDS), starts=2, globally=False).objective
        assert four.costs[:, k].min() == pytest.approx(alone, rel=2e-4), each.quantity


def test_a_curve_is_what_single_optima_with_a_moved_limit_give(two, prototype):
    """Drop against frequency is the optimum of drop with that frequency demanded, within the room given when moving."""
    rows = two.quantities[1 :: max(1, len(two.quantities) // 5)]
    for row in rows:
        limit = f"pwm_frequency >= {row['pwm_frequency']!r} Hz"
        alone = optimise(
            problem(prototype, "pressure_drop_total", [limit, LIMITS[1]], BOUNDS), starts=2, globally=False
        )
        assert row["pressure_drop_total"] == pytest.approx(alone.objective, rel=5e-4)


def test_no_random_design_beats_the_front(two):
    """100000 designs: none is better than a design of the curve in both."""
    asked, rng = two.problem, np.random.default_rng(5)
    values = {b.variable.name: np.exp(rng.uniform(np.log(b.low), np.log(b.high), 100_000)) for b in asked.bounds}
    q = asked.evaluate(values)[0]
    fine = (q.pwm_frequency >= 50.0) & (q.transition_fraction <= 0.5)
    for row in two.quantities:
        better = (q.pressure_drop_total < row["pressure_drop_total"] * (1 - 1e-3)) & (
            q.pwm_frequency > row["pwm_frequency"] * (1 + 1e-3)
        )
        assert not np.any(fine & better)


def test_every_design_is_a_system(four, tmp_path):
    write_designs(tmp_path, four)
    names = sorted(path.name for path in (tmp_path / "systems").iterdir())
    assert names[0] == "point-001.toml"
    assert len(names) == len(four.values)
    for number in (0, len(names) // 2, len(names) - 1):
        system = load_system(str(tmp_path / "systems" / names[number]))
        found = quantities(setup(system))
        for each in four.objectives:
            assert getattr(found, each.quantity) == pytest.approx(four.quantities[number][each.quantity], rel=1e-8)


def test_whole_numbers_stay_whole(prototype):
    asked = problem(prototype, "loss_total", LIMITS, [*BOUNDS, "sections >= 2", "sections <= 4"])
    found = front(asked, points=12, generations=5)
    assert {values["sections"] for values in found.values} <= {2.0, 3.0, 4.0}


def test_what_nobody_can_meet(prototype):
    with pytest.raises(InfeasibleError, match=wording.design.no_design):
        front(problem(prototype, "loss_total", ["pwm_frequency >= 5000 Hz"], BOUNDS), points=8, generations=2)


def test_objectives_in_words():
    assert objectives((), ()) == USUAL
    assert objectives(["loss_total"], ["efficiency"]) == (Objective("loss_total", False), Objective("efficiency", True))
    with pytest.raises(ConfigError) as raised:
        objectives(["loss_totl", "spool_volume", "spool_volume"], ["pwm"])
    assert len(raised.value.faults) == 3
    with pytest.raises(ConfigError, match=wording.design.two_objectives):
        objectives(["loss_total"], [])


def test_command_for_a_front(designing, tmp_path, keys_as_described):
    code, out, err = designing(
        "pareto", "prototype", "--minimise", "loss_total", "--maximise", "pwm_frequency", "--points", "10",
        "--generations", "4", "--subject-to", "transition_fraction <= 0.4", "--json", "--out", "there",
    )  # fmt: skip
    assert code == 0, err
    found = json.loads(out)
    keys_as_described("design pareto", found)
    count, refused = len(found["front_loss_total_W"]), len(found["refused_loss_total_W"])
    assert count == found["designs"] == found["confirmed_designs"] == len(found["front_design"])
    assert count + refused == len(list((tmp_path / "there" / "systems").iterdir()))
    assert wording.design.front in (tmp_path / "there" / "report.html").read_text("utf-8")
    assert (tmp_path / "there" / "figures" / "trade-offs.svg").is_file()
    assert len((tmp_path / "there" / "front.csv").read_text("utf-8").splitlines()) == count + 1


@pytest.mark.thorough
def test_command_for_a_front_and_a_person(designing):
    code, out, err = designing("pareto", "prototype", "--points", "8", "--generations", "2")
    assert code == 0
    assert "point-001" in out
    assert wording.design.on_a_bound in out
    assert wording.design.generations in err


@pytest.mark.thorough
def test_a_front_over_a_cycle(designing, tmp_path):
    """The usual frequency is one demand on the mean; transition, shut relief valve and motor are demanded at each of
    two points: 7 numbers, and 2 of the geometry."""
    (tmp_path / "cycle.toml").write_text(
        '[[points]]\nweight = 3\n[[points]]\nweight = 1\n"operation.oil_temperature" = "50 degC"\n'
    )
    code, out, err = designing(
        "pareto", "prototype", "--minimise", "loss_total", "--minimise", "spool_volume", "--cycle", "cycle.toml",
        "--points", "8", "--generations", "3", "--no-simulation", "--json",
    )  # fmt: skip
    assert code == 0, err
    found = json.loads(out)
    assert len(found["front_loss_total_W"]) >= 4
    # 0.75 of 71.99 Hz and 0.25 of 106.3 Hz
    assert min(found["front_pwm_frequency_Hz"]) == pytest.approx(0.75 * 71.99 + 0.25 * 106.3, rel=1e-3)


def test_a_front_at_an_exact_frequency(prototype):
    wanted = (Objective("loss_total", False), Objective("spool_volume", False))
    asked = problem(prototype, "loss_total", ["pwm_frequency = 72 Hz"], ["radial_clearance <= 22.5 um"])
    found = front(asked, wanted, points=16, generations=12)
    assert len(found.values) >= 6
    assert [row["pwm_frequency"] for row in found.quantities] == pytest.approx([72.0] * len(found.values), rel=1e-5)


def test_interrupted_in_an_optimum_of_one_objective_leaves_nothing(designing, tmp_path, monkeypatch):
    """The first optimum is found from its second point, then comes Ctrl-C."""
    calls, solved = [], Traced.solve

    def stopped(traced, start):
        calls.append(start)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return solved(traced, start)

    monkeypatch.setattr(Traced, "solve", stopped)
    code, out, _ = designing("pareto", "prototype", "--points", "8", "--generations", "2", "--out", "there")
    assert (code, out) == (130, "")
    assert not (tmp_path / "there").exists()


def test_interrupted_front_keeps_its_designs(prototype):
    asked = problem(prototype, "loss_total", LIMITS, BOUNDS)

    def stopping_at(number):
        def heard(done, total):
            if done == number:
                raise KeyboardInterrupt

        return heard

    for number in (3, 7):  # in the evolution, and while designs are moved onto the front
        found = front(asked, points=12, generations=5, progress=stopping_at(number))
        assert not found.finished
        assert len(found.values) >= 4
        assert np.all(is_undominated(found.costs))


@pytest.mark.thorough
def test_only_what_the_simulation_confirms_is_on_the_front(designing, tmp_path):
    """The front of loss, ripple, size and frequency keeps the usual limits, and what is refused stands apart."""
    arguments = ("pareto", "prototype", "--points", "12", "--generations", "6")
    code, out, err = designing(*arguments, "--json", "--out", "there")
    assert code == 0, err
    found = json.loads(out)
    for designs in ("front", "refused"):
        assert min(found[f"{designs}_pwm_frequency_Hz"]) >= 71.99 * (1.0 - 1e-4)
        assert max(found[f"{designs}_transition_fraction"]) <= 0.5 * (1.0 + 1e-5)
        assert min(found[f"{designs}_relief_margin_Pa"]) >= -10.0
        assert max(found[f"{designs}_input_power_W"]) <= 5600.0 * (1.0 + 1e-5)
        # each is simulated, and stands where its simulation puts it
        columns = (
            found[f"{designs}_{name}"] for name in ("loss_total_W", "simulated_loss_total_W", "simulated_settled")
        )
        for claimed, loss, settled in zip(*columns, strict=True):
            doubted = loss is None or abs(loss / claimed - 1.0) > 0.1 or not settled
            assert doubted is (designs == "refused")
    refused = len(found["refused_design"])
    assert refused == found["refused_designs"] > 0
    assert found["confirmed_designs"] > 0
    (warning,) = found["warnings"]
    assert warning.startswith(wording.design.not_on_front.format(count=refused, all=refused + found["designs"]))
    assert all("simulated" in reason or "settled" in reason for reason in found["refused_reason"])
    assert len((tmp_path / "there" / "refused.csv").read_text("utf-8").splitlines()) == refused + 1
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.refused_by_simulation in page
    assert wording.design.relief_margin_limit.format(margin="0 bar") + wording.design.usual in page


@pytest.mark.thorough
def test_without_simulation_nothing_is_confirmed(designing, tmp_path):
    arguments = ("--points", "12", "--generations", "6", "--no-usual-limits", "--no-simulation", "--out", "there")
    code, out, err = designing("pareto", "prototype", *arguments, "--json")
    assert code == 0, err
    found = json.loads(out)
    assert max(found["front_input_power_W"]) > 5600.0
    assert found["warnings"] == [wording.design.nothing_simulated]
    assert found["confirmed_designs"] == found["refused_designs"] == 0
    assert not any("_simulated" in key for key in found)
    assert wording.design.nothing_confirmed in (tmp_path / "there" / "report.html").read_text("utf-8")


def simulated(*doubts):
    return [Simulated(1.0, 50.0, 0.6, settled=True, doubts=each) for each in doubts]


def test_refused_designs_and_those_on_a_bound_by_hand(two):
    """Three of the curve's designs, of which the simulation refuses the second; the first alone lies on a bound."""
    low = {b.variable.name: b.low for b in two.problem.bounds}
    inside = {name: 1.1 * value for name, value in low.items()}
    on_bound = inside | {"spool_radius": low["spool_radius"] * 1.001}
    doubts = ((), (), ("it turns too slowly",), ())
    found = replace(
        two, values=(on_bound, on_bound, inside), quantities=two.quantities[:3], simulated=tuple(simulated(*doubts))
    )
    assert (found.front_designs, found.rejects, found.on_a_bound) == ((0, 2), (1,), (0,))
    result = front_result(found, finished=True)
    assert result.tables["front"]["design"].tolist() == ["point-001", "point-002"]
    assert result.tables["refused"]["reason"].tolist() == ["it turns too slowly"]
    assert result.tables["before"]["pwm_frequency_Hz"] == pytest.approx([71.99], abs=0.01)
    drawn = [line.table for line in result.charts["trade-offs"].panels[0].lines]
    assert drawn == ["front", "refused", "before"]
    assert any(wording.design.variable_on_bound.format(count=1, all=2) in each.text for each in result.findings)


def test_a_front_of_which_nothing_is_confirmed_has_a_page(two, tmp_path):
    doubted = replace(two, simulated=tuple(simulated((), *[("it failed",)] * len(two.values))))
    write_result(tmp_path, front_result(doubted, finished=True), "")
    page = write_result_report(tmp_path).read_text("utf-8")
    assert wording.design.confirmed.format(count=0) in page
    assert wording.design.not_on_front.format(count=len(two.values), all=len(two.values)) in page


def test_a_batch_simulates_as_single_runs_do(prototype):
    """The design as it was: 1774 W and 62.2 Hz, as `vvdp run prototype` says; and one that turns too slowly."""
    slow = {"spool_radius": 20.32e-3, "nozzle_area": 120e-6, "outlet_area": 150e-6, "radial_clearance": 5.08e-6}
    as_it_was, crawling = simulated_designs(problem(prototype, "loss_total"), [{}, slow])
    run = summary(prototype, simulate(prototype.model, prototype.case, prototype.stepping))
    assert as_it_was.loss_total == pytest.approx(run["loss_total_W"], rel=1e-3)
    assert as_it_was.pwm_frequency == pytest.approx(run["pwm_frequency_Hz"], rel=1e-3)
    assert as_it_was.settled
    assert not as_it_was.doubts
    assert crawling.doubts


@pytest.mark.thorough
def test_interrupted_in_the_simulation_keeps_the_front(designing, tmp_path, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("vvdp.design.proof.simulate_batch", stopped)
    code, _, err = designing("pareto", "prototype", "--points", "8", "--generations", "2", "--out", "there")
    assert code == 130
    assert wording.progress.found_written in err
    assert len((tmp_path / "there" / "front.csv").read_text("utf-8").splitlines()) > 3
