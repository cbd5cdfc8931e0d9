"""Scatter and Sobol indices against closed forms."""

import json
import re

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.design.quantities import key, quantities, setup
from vvdp.design.spreads import bench_with, spreads, usual_spreads, with_inputs
from vvdp.design.tolerance import SIMULATED, WORDS, tolerance
from vvdp.design.tolerance_runs import simulated_draws
from vvdp.evaluation.bench import rotary_bench
from vvdp.runs.simulate import run_system
from vvdp.systems.system import load_system
from vvdp.valve.branch import centre_resistance, nozzle_resistance, outlet_resistance

pytestmark = pytest.mark.heavy

NAME = "prototype-constant-load"


@pytest.fixture(scope="module")
def bench():
    return load_system(NAME)


PARTS = (
    "radial_clearance", "viscosity", "air_fraction", "nozzle_discharge_coefficient", "outlet_discharge_coefficient",
    "centre_coefficient",
)  # fmt: skip


@pytest.fixture(scope="module")
def study(bench):
    """The scatter of parts and oil alone, by closed forms."""
    taken = [each for each in spreads(bench) if each.name in PARTS]
    return tolerance(bench, taken, samples=1024, runs=0, seed=3)


@pytest.fixture(scope="module")
def simulated(bench):
    return tolerance(bench, spreads(bench), samples=256, runs=64, seed=3)


def mean_and_variance(power: int, low: float, high: float) -> tuple[float, float]:
    """Of x^-power for x evenly between two values: E[x^-n] = (low^(1-n) - high^(1-n))/((n-1)(high-low)), n = 2: 1/(ab);
    n = 1: ln(b/a)/(b-a)."""
    moment = [
        np.log(high / low) if n == 1 else (low ** (1 - n) - high ** (1 - n)) / (n - 1) for n in (power, 2 * power)
    ]
    first, second = (m / (high - low) for m in moment)
    return first, second - first**2


def test_drop_is_a_sum_of_independent_parts(study, bench):
    """k_n/C_n^2 + k_c/k + k_o/C_o^2: mean and variance of each part in closed form, and the index of an input is its
    part of the variance. The sampled indices lie within their own 95 % confidence, doubled to be safe in six cases."""
    at = setup(bench)
    rho, Q, valve = 876.0, at.flow, at.valve
    parts = {
        "nozzle_discharge_coefficient": (2, nozzle_resistance(rho, valve) * Q**2),
        "outlet_discharge_coefficient": (2, outlet_resistance(rho, valve) * Q**2),
        "centre_coefficient": (1, centre_resistance(valve) * Q**1.91),
    }
    moments, taken = {}, {each.name: each for each in study.spreads}
    for name, (power, drop) in parts.items():
        each = taken[name]
        mean, variance = mean_and_variance(power, each.low / each.nominal, each.high / each.nominal)
        moments[name] = drop * mean, drop**2 * variance
    found = study.scatter["pressure_drop_total"]
    total = sum(variance for _, variance in moments.values())
    assert found.mean == pytest.approx(sum(mean for mean, _ in moments.values()), rel=1e-4)
    assert found.deviation == pytest.approx(np.sqrt(total), rel=5e-3)
    for name, (_, variance) in moments.items():
        assert found.alone[name] == pytest.approx(variance / total, abs=2.0 * found.alone_error[name] + 1e-3)
        assert found.whole[name] == pytest.approx(variance / total, abs=2.0 * found.whole_error[name] + 1e-3)


def test_an_input_that_does_not_enter_has_no_share(study):
    frequency = study.scatter["pwm_frequency"]
    for name in ("nozzle_discharge_coefficient", "outlet_discharge_coefficient", "centre_coefficient", "air_fraction"):
        assert frequency.whole[name] == frequency.alone[name] == 0.0
    drop = study.scatter["pressure_drop_total"]
    assert drop.whole["radial_clearance"] == drop.whole["viscosity"] == 0.0


def test_frequency_is_the_closed_form_of_its_two_inputs(study, bench):
    """omega = T/(k mu/c + d): variance by a fine grid over clearance and viscosity, and first indices from its
    conditional means."""
    at = setup(bench)
    c, nu = (next(each for each in study.spreads if each.name == name) for name in ("radial_clearance", "viscosity"))
    share = (np.arange(400) + 0.5) / 400
    grid = quantities(
        with_inputs(
            at, {"valve.radial_clearance": c.quantile(share)[:, None], "oil.viscosity_40": nu.quantile(share)[None, :]}
        )
    ).pwm_frequency
    found = study.scatter["pwm_frequency"]
    assert found.deviation == pytest.approx(grid.std(), rel=5e-3)
    assert found.mean == pytest.approx(grid.mean(), rel=1e-3)
    for axis, name in ((1, "radial_clearance"), (0, "viscosity")):
        index = grid.mean(axis=axis).var() / grid.var()
        assert found.alone[name] == pytest.approx(index, abs=2.0 * found.alone_error[name])


def test_percentiles_are_in_order_and_draws_inside(study):
    for each in study.scatter.values():
        assert list(each.percentiles.values()) == sorted(each.percentiles.values())
    for spread in study.spreads:
        column = study.inputs[spread.name]
        assert spread.low <= column.min() < column.max() <= spread.high
        if spread.is_logarithmic:
            assert np.median(column) == pytest.approx(np.sqrt(spread.low * spread.high), rel=0.02)


def test_same_seed_same_study(bench):
    first, again, other = (tolerance(bench, spreads(bench), samples=64, runs=0, seed=s) for s in (5, 5, 6))
    assert first.scatter == again.scatter != other.scatter


def test_viscosity_keeps_the_ratio_of_its_two_temperatures(bench):
    at = setup(bench)
    oil = with_inputs(at, {"oil.viscosity_40": 1.1 * at.oil.viscosity_40}).oil
    assert oil.viscosity_100 == pytest.approx(1.1 * at.oil.viscosity_100)


def test_every_usual_spread_has_a_source_or_is_assumed(bench, root_of_docs):
    known = (root_of_docs / "references.bib").read_text("utf-8")
    for each in spreads(bench):
        assert each.note
        assert each.status == "assumed" or f"{{{each.source}," in known, each.source


def test_own_spread(bench):
    found = {each.name: each for each in spreads(bench, ["radial_clearance: 10 um to 16 um"])}
    assert (found["radial_clearance"].low, found["radial_clearance"].high) == pytest.approx((10e-6, 16e-6))
    assert found["radial_clearance"].status == "given"


def test_faults_of_spreads_are_told_together(bench):
    texts = ["clearance: 1 um to 2 um", "viscosity", "air_fraction: 5 % to 1 %", "viscosity: 1 bar to 2 bar"]
    with pytest.raises(ConfigError) as raised:
        spreads(bench, texts)
    assert len(raised.value.faults) == 4
    with pytest.raises(ParameterError, match=wording.design.power_of_two.format(count=100, what="samples")):
        tolerance(bench, spreads(bench), samples=100)
    with pytest.raises(ParameterError, match=wording.design.power_of_two.format(count=100, what="runs")):
        tolerance(bench, spreads(bench), runs=100)


@pytest.mark.thorough
def test_command(designing, tmp_path, keys_as_described):
    code, out, err = designing("tolerance", NAME, "--samples", "256", "--runs", "32", "--json", "--out", "there")
    assert code == 0, err
    found = json.loads(out)
    keys_as_described("design tolerance", found)
    place = found["shares_input"].index("radial_clearance")
    assert found["shares_pwm_frequency_total_index"][place] == pytest.approx(0.85, abs=0.1)
    assert sum(found["distribution_pwm_frequency_count"]) == 4096
    assert found["pressure_drop_total_Pa"] == pytest.approx(6.677e5, rel=1e-3)
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.spreads_assumed in page
    assert wording.design.mostly_through.format(value="radial clearance") in page
    rows = (tmp_path / "there" / "draws.csv").read_text("utf-8").splitlines()
    assert len(rows) == 4097
    outputs = "pressure_drop_total_Pa,pwm_frequency_Hz,efficiency,running_pwm_frequency_Hz,highest_inlet_pressure_Pa"
    assert outputs in rows[0]
    assert 0.0 < found["efficiency_unexplained"] < 1.0
    assert found["runs"] == 32


@pytest.mark.thorough
def test_command_for_a_person(designing):
    code, out, _ = designing(
        "tolerance", NAME, "--no-simulation", "--samples", "64", "--spread", "air_fraction: 1 % to 2 %"
    )
    assert code == 0
    assert wording.design.share_of_variance in out
    assert any(line.split()[5:9] == ["1", "%", "2", "%"] for line in out.splitlines())


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("setting", "told"),
    [
        # kappa 0.30
        (
            "operation.duty_ratio=0.15",
            wording.valve.duty_ratio_outside_range.format(duty=0.15, low=0.3001, high=0.6999)
            + wording.valve.port_never_open,
        ),
        # 118 bar and 6.68 bar of open drop above a setting of 120 bar
        ("load.pressure=118 bar", wording.systems.relief_does_not_exceed.format(setting="120 bar") + " the 124.7 bar"),
    ],
)
def test_closed_forms_out_of_their_range_are_told(designing, tmp_path, setting, told):
    arguments = ("tolerance", NAME, "--no-simulation", "--set", setting, "--samples", "1024", "--out", "there")
    code, out, err = designing(*arguments, "--json")
    assert code == 0, err
    assert json.loads(out)["warnings"][0].startswith(told[:1].upper() + told[1:])
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.in_doubt in page
    assert told[:1].upper() + told[1:] in page


@pytest.mark.thorough
def test_no_efficiency_where_nothing_is_delivered(designing):
    """Prototype: the transitions cost the load 0.0689 of the pump's flow, leakage and compression the rest to 0.0786:
    26 W + 38 W of 40 lpm times 100 bar, 6667 W, are 0.0097."""
    for duty in ("0", "0.078"):
        code, _, err = designing(
            "tolerance", NAME, "--no-simulation", "--set", f"operation.duty_ratio={duty}", "--samples", "16"
        )
        assert code == 2
        assert "operation.duty_ratio: " + wording.design.transitions_take_all.format(duty=duty) in err
        assert wording.files.expected_more_than.format(limit=0.07862) in err
    code, _, _ = designing(
        "tolerance", NAME, "--no-simulation", "--set", "operation.duty_ratio=0.079", "--samples", "16"
    )
    assert code == 0


@pytest.mark.thorough
def test_few_samples_are_told(designing):
    code, out, _ = designing("tolerance", NAME, "--no-simulation", "--samples", "16")
    assert code == 0
    assert f"warning: {wording.design.in_doubt}: {wording.design.uncertain_shares.format(count=16)}" in out
    code, out, _ = designing("tolerance", NAME, "--no-simulation", "--samples", "1024", "--json")
    assert code == 0
    assert json.loads(out)["warnings"] == []


def test_what_is_assumed_is_an_input(bench):
    """Every value of the file that has a range, beside what scatters anyway, with the words of the file."""
    found = {each.setting: each for each in spreads(bench)}
    for row in bench.uncertainties:
        assert (found[row.setting].low, found[row.setting].high) == row.range
        assert found[row.setting].note == row.note
    assert found["valve.lap_ratio"].label == wording.design.lap_ratio
    assert found["valve.lap_ratio"].in_closed_forms


def test_any_value_can_be_an_input(bench):
    texts = ["relief_valve.opening_time: 1 ms to 15 ms", "inlet.volume: 10 cc to 20 cc"]
    found = {each.setting: each for each in spreads(bench, texts)}
    assert found["relief_valve.opening_time"].name == "relief_valve_opening_time"
    assert not found["relief_valve.opening_time"].in_closed_forms
    assert with_inputs(setup(bench), {"inlet.volume": 1.5e-5}).inlet_volume == 1.5e-5


def test_a_user_file_without_ranges_spreads_parts_and_oil():
    plain = load_system("prototype-constant-load", [f"valve.{name}=1" for name in ("lap_ratio", "jet_exponent")])
    assert {"valve.lap_ratio", "valve.jet_exponent"}.isdisjoint(each.setting for each in spreads(plain))
    given = load_system(NAME, ["valve.radial_clearance=20 um"])
    clearance = next(each for each in spreads(given) if each.name == "radial_clearance")
    assert (clearance.low, clearance.high) == pytest.approx((17e-6, 23e-6))
    assert clearance.source == "iso286"


def test_ranges_of_the_file_are_the_usual_spreads_of_its_parts(bench):
    """To the digits that the file writes."""
    given = {each.setting: each for each in spreads(bench)}
    for each in usual_spreads(bench):
        assert (given[each.setting].low, given[each.setting].high) == pytest.approx((each.low, each.high), rel=5e-3)


def test_simulated_outputs_rest_on_lap_and_jet(simulated):
    """The lap decides the efficiency, the clearance the frequency."""
    efficiency, frequency = (simulated.scatter[name] for name in ("efficiency", "running_pwm_frequency"))
    assert max(efficiency.whole, key=efficiency.whole.get) == "lap_ratio"
    assert efficiency.whole["lap_ratio"] > 0.85
    assert max(frequency.whole, key=frequency.whole.get) == "radial_clearance"
    assert simulated.scatter["pwm_frequency"].whole["lap_ratio"] == 0.0
    low, high = efficiency.percentiles["2.5"], efficiency.percentiles["97.5"]
    assert low < efficiency.nominal < high
    assert high - low > 0.1
    assert set(simulated.unexplained) == set(SIMULATED)


def test_the_curve_through_runs_meets_another_run(simulated, bench):
    """Of the first draws of the distribution the outputs are those of runs, within three times what is missed."""
    for row in (1, 2):
        values = {each.setting: float(simulated.inputs[each.name][row]) for each in simulated.spreads}
        run = run_system(bench_system(bench, values))
        for name, number in SIMULATED.items():
            within = 3.0 * np.sqrt(simulated.unexplained[name]) * simulated.scatter[name].deviation
            assert simulated.outputs[name][row] == pytest.approx(run.number(number), abs=within), name


def bench_system(system, values):
    """A system with values [SI] by setting."""
    return bench_with(rotary_bench(system, "test"), values).own_system


def test_ends_of_each_input_alone_are_in_the_result(simulated):
    rows = [row.setting for row in simulated.ranges.rows]
    low, high = simulated.ranges.ends["efficiency"][rows.index("valve.lap_ratio")]
    assert (low, high) == pytest.approx((0.684, 0.544), abs=1e-3)
    assert set(simulated.ranges.nominal) == {key(name, WORDS[name][0]) for name in simulated.scatter}


@pytest.mark.thorough
def test_an_input_that_contradicts_the_system_is_told(bench):
    """An ideal relief valve has no opening time, whatever the draw."""
    taken = spreads(
        bench, ["relief_valve.override_pressure: 1 bar to 2 bar", "relief_valve.opening_time: 1 ms to 2 ms"]
    )
    assert tolerance(bench, taken, samples=16, runs=16).failed == ()
    alone = [each for each in taken if each.setting == "relief_valve.opening_time"]
    with pytest.raises(
        ConfigError, match="opening_time: .* " + wording.files.must_be_zero_if.format(key="override_pressure")
    ):
        tolerance(bench, alone, samples=16, runs=16)


@pytest.mark.thorough
def test_without_simulation_what_no_closed_form_knows_is_named(designing, tmp_path):
    code, _, err = designing("tolerance", NAME, "--no-simulation", "--samples", "16", "--out", "there", "--spread",
                             "relief_valve.opening_time: 1 ms to 15 ms")  # fmt: skip
    assert code == 0, err
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert re.search(wording.design.left_out + "[^.]*: [^.]*opening", page)


@pytest.mark.slow
def test_with_a_relief_valve_that_lags_the_efficiency_is_hardly_known():
    """One run after another of 1024 other draws gave 29.6 to 72.2 % and 30.5 to 89.9 Hz in 95 % of the cases."""
    system = load_system(NAME, ["relief_valve.override_pressure=10 bar"])
    texts = ("override_pressure: 0 bar to 20 bar", "opening_time: 0 ms to 15 ms", "reseat_drop: 0 bar to 24 bar")
    found = tolerance(system, spreads(system, [f"relief_valve.{text}" for text in texts]), samples=256)
    assert max(found.unexplained.values()) < 0.02
    efficiency, frequency = (found.scatter[name] for name in ("efficiency", "running_pwm_frequency"))
    ends = [efficiency.percentiles[each] for each in ("2.5", "97.5")]
    assert ends == pytest.approx([0.296, 0.722], abs=0.02)
    assert [frequency.percentiles[each] for each in ("2.5", "97.5")] == pytest.approx([30.5, 89.9], abs=2.0)
    assert max(efficiency.whole, key=efficiency.whole.get) in ("lap_ratio", "relief_valve_opening_time")


def test_a_value_with_a_simpler_form_at_its_end_is_varied_all_the_same():
    """A pump that compresses inside is a simpler one; one that does not loses 0.8 points at 1 % of air and 100 bar."""
    system = load_system("prototype-constant-load", until="0.3 s")
    taken = [each for each in spreads(system, ["pump.precompression: 0 to 1"]) if each.setting == "pump.precompression"]
    drawn = simulated_draws(system, taken, ("efficiency",), 8, 1)
    without, ideal = drawn.ends["efficiency"][0]
    assert ideal == pytest.approx(drawn.nominal["efficiency"], rel=1e-6)
    assert ideal - without == pytest.approx(0.0078, abs=0.001)
    order = np.argsort(drawn.points[:, 0])
    assert np.all(np.diff(drawn.outputs["efficiency"][order]) > 0.0)
