"""Scatter and Sobol indices against closed forms."""

import json

import numpy as np
import pytest

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.design.quantities import quantities, setup
from vvdp.design.tolerance import spreads, tolerance, with_inputs
from vvdp.valve.branch import centre_resistance, nozzle_resistance, outlet_resistance


@pytest.fixture(scope="module")
def study(prototype):
    return tolerance(prototype, spreads(prototype), samples=1024, seed=3)


def mean_and_variance(power: int, low: float, high: float) -> tuple[float, float]:
    """Of x^-power for x evenly between two values: E[x^-n] = (low^(1-n) - high^(1-n))/((n-1)(high-low)), n = 2: 1/(ab);
    n = 1: ln(b/a)/(b-a)."""
    moment = [
        np.log(high / low) if n == 1 else (low ** (1 - n) - high ** (1 - n)) / (n - 1) for n in (power, 2 * power)
    ]
    first, second = (m / (high - low) for m in moment)
    return first, second - first**2


def test_drop_is_a_sum_of_independent_parts(study, prototype):
    """k_n/C_n^2 + k_c/k + k_o/C_o^2: mean and variance of each part in closed form, and the index of an input is its
    part of the variance. The sampled indices lie within their own 95 % confidence, doubled to be safe in six cases."""
    at = setup(prototype)
    rho, Q, valve = 876.0, at.flow, at.valve
    parts = {
        "nozzle_discharge_coefficient": (2, nozzle_resistance(rho, valve) * Q**2, 0.05),
        "outlet_discharge_coefficient": (2, outlet_resistance(rho, valve) * Q**2, 0.05),
        "centre_coefficient": (1, centre_resistance(valve) * Q**1.91, 0.06),
    }
    moments = {}
    for name, (power, drop, share) in parts.items():
        mean, variance = mean_and_variance(power, 1.0 - share, 1.0 + share)
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


def test_frequency_is_the_closed_form_of_its_two_inputs(study, prototype):
    """omega = T/(k mu/c + d): variance by a fine grid over clearance and viscosity, and first indices from its
    conditional means."""
    at = setup(prototype)
    c, nu = (next(each for each in study.spreads if each.name == name) for name in ("radial_clearance", "viscosity"))
    share = (np.arange(400) + 0.5) / 400
    grid = quantities(
        with_inputs(at, {"radial_clearance": c.quantile(share)[:, None], "viscosity": nu.quantile(share)[None, :]})
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
        if spread.logarithmic:
            assert np.median(column) == pytest.approx(np.sqrt(spread.low * spread.high), rel=0.02)


def test_same_seed_same_study(prototype):
    first, again, other = (tolerance(prototype, spreads(prototype), samples=64, seed=s) for s in (5, 5, 6))
    assert first.scatter == again.scatter != other.scatter


def test_viscosity_keeps_the_ratio_of_its_two_temperatures(prototype):
    at = setup(prototype)
    oil = with_inputs(at, {"viscosity": 1.1 * at.oil.viscosity_40}).oil
    assert oil.viscosity_100 == pytest.approx(1.1 * at.oil.viscosity_100)


def test_every_usual_spread_has_a_source_or_is_assumed(prototype, root_of_docs):
    known = (root_of_docs / "references.bib").read_text("utf-8")
    for each in spreads(prototype):
        assert each.note
        assert each.status == "assumed" or f"{{{each.source}," in known, each.source


def test_own_spread(prototype):
    found = {each.name: each for each in spreads(prototype, ["radial_clearance: 10 um to 16 um"])}
    assert (found["radial_clearance"].low, found["radial_clearance"].high) == pytest.approx((10e-6, 16e-6))
    assert found["radial_clearance"].status == "given"


def test_faults_of_spreads_are_told_together(prototype):
    texts = ["clearance: 1 um to 2 um", "viscosity", "air_fraction: 5 % to 1 %", "viscosity: 1 bar to 2 bar"]
    with pytest.raises(ConfigError) as raised:
        spreads(prototype, texts)
    assert len(raised.value.faults) == 4
    with pytest.raises(ParameterError, match="100 samples; expected a power of two"):
        tolerance(prototype, spreads(prototype), samples=100)


def test_command(designing, tmp_path, keys_as_described):
    code, out, err = designing("tolerance", "prototype", "--samples", "256", "--json", "--out", "there")
    assert code == 0, err
    found = json.loads(out)
    keys_as_described("design tolerance", found)
    place = found["shares_input"].index("radial_clearance")
    assert found["shares_pwm_frequency_total_index"][place] == pytest.approx(0.85, abs=0.1)
    assert sum(found["distribution_pwm_frequency_count"]) == 4096
    assert found["pressure_drop_total_Pa"] == pytest.approx(6.677e5, rel=1e-3)
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert "spreads are assumptions" in page
    assert "mostly through the radial clearance" in page
    rows = (tmp_path / "there" / "draws.csv").read_text("utf-8").splitlines()
    assert len(rows) == 4097
    assert rows[0].endswith("pressure_drop_total_Pa,pwm_frequency_Hz,efficiency")


def test_command_for_a_person(designing):
    code, out, _ = designing("tolerance", "prototype", "--samples", "64", "--spread", "air_fraction: 1 % to 2 %")
    assert code == 0
    assert "Share of the variance" in out
    assert any(line.split()[5:9] == ["1", "%", "2", "%"] for line in out.splitlines())


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        # kappa 0.30
        ("operation.duty_ratio=0.15", "duty ratio 0.15 lies outside 0.3001 to 0.6999: the load port is never fully op"),
        # 118 bar and 6.68 bar of open drop above a setting of 120 bar
        ("load.pressure=118 bar", "the relief setting of 120 bar does not exceed the 124.7 bar that the load and the"),
    ],
)
def test_closed_forms_out_of_their_range_are_told(designing, tmp_path, setting, told):
    arguments = ("tolerance", "prototype-constant-load", "--set", setting, "--samples", "1024", "--out", "there")
    code, out, err = designing(*arguments, "--json")
    assert code == 0, err
    assert json.loads(out)["warnings"][0].startswith(told[:1].upper() + told[1:])
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert "In doubt" in page
    assert told[:1].upper() + told[1:] in page


def test_no_efficiency_where_nothing_is_delivered(designing):
    """Prototype: the transitions cost the load 0.0689 of the pump's flow, leakage and compression the rest to 0.0786:
    26 W + 38 W of 40 lpm times 100 bar, 6667 W, are 0.0097."""
    for duty in ("0", "0.078"):
        code, _, err = designing("tolerance", "prototype", "--set", f"operation.duty_ratio={duty}", "--samples", "16")
        assert code == 2
        assert f"operation.duty_ratio: {duty}: analytically, transitions, leakage and compression take all" in err
        assert "expected more than 0.07862" in err
    code, _, _ = designing("tolerance", "prototype", "--set", "operation.duty_ratio=0.079", "--samples", "16")
    assert code == 0


def test_few_samples_are_told(designing):
    code, out, _ = designing("tolerance", "prototype", "--samples", "16")
    assert code == 0
    assert "warning: In doubt: With 16 samples the shares of the variance are uncertain by up to " in out
    code, out, _ = designing("tolerance", "prototype", "--samples", "1024", "--json")
    assert code == 0
    assert json.loads(out)["warnings"] == []
