"""Closed forms beside a run: there where they describe it, left out with a sentence where they do not."""

import pytest
from tests.words import wording

from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.bench_overview import ANALYTIC
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.bench_validity import load_swing
from vvdp.systems.system import load_system

BENCH = "prototype-constant-load"
OVERRIDE = "relief_valve.override_pressure=10 bar"
LEAKING = ("pump.displacement=22.8 cc/rev", "pump.leakage_conductance=2.45e-12 m^3/(s*Pa)")
STIFF = ("oil.liquid_bulk_modulus=1e12 Pa", "oil.air_fraction=0")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ((OVERRIDE, "relief_valve.opening_time=5 ms"), wording.systems.opening_time_lag.format(lag="5 ms")),
        ((OVERRIDE, "relief_valve.reseat_drop=12 bar"), wording.systems.reseats_below.format(drop="12 bar")),
        (
            ("operation.duty_ratio=0.25",),
            wording.valve.duty_ratio_outside_range.format(duty=0.25, low=0.3001, high=0.6999),
        ),
        (
            ("operation.duty_ratio=0.75",),
            wording.valve.duty_ratio_outside_range.format(duty=0.75, low=0.3001, high=0.6999),
        ),
    ],
)
def test_left_out_with_a_sentence(ran, changes, sentence):
    found, _ = ran(BENCH, changes, "0.1 s")
    assert not set(ANALYTIC) & set(found)
    said = additions(load_system(BENCH, changes)).warnings(found)
    told = [text for text in said if text.startswith(wording.systems.no_analytic_results)]
    assert len(told) == 1
    assert sentence in told[0]


def test_nothing_is_said_where_they_hold(ran):
    found, _ = ran(BENCH, (OVERRIDE, *LEAKING), "0.1 s")
    assert set(ANALYTIC) <= set(found)
    own = additions(load_system(BENCH, (OVERRIDE, *LEAKING)))
    assert not any("analytic" in text for text in own.warnings(found))


@pytest.mark.parametrize(
    "changes",
    [
        (OVERRIDE,),
        (OVERRIDE, "relief_valve.rated_flow=60 lpm"),
        (*LEAKING, OVERRIDE),
        (OVERRIDE, "valve.lap_ratio=0.8"),
        (OVERRIDE, "valve.lap_ratio=0.5"),
    ],
)
def test_override_and_leakage_of_the_pump_are_in_them(ran, changes):
    """Stiff oil without air, the leakage of the valve out of the load's share: what the averages say is what the
    simulation does, and the shares add up to the power that is put in but not given to the load."""
    found, _ = ran(BENCH, [*STIFF, *changes], "1 s")
    assert found["analytic_loss_transition_W"] == pytest.approx(found["loss_transition_W"], rel=5e-3)
    assert found["analytic_loss_full_open_W"] == pytest.approx(found["loss_full_open_W"], rel=2e-3)
    assert found["analytic_loss_pump_W"] == pytest.approx(found["loss_pump_leakage_W"], rel=5e-3, abs=1e-9)
    assert found["analytic_loss_total_W"] == pytest.approx(found["loss_total_W"], rel=5e-3)
    assert found["analytic_pwm_frequency_Hz"] == pytest.approx(found["pwm_frequency_Hz"], rel=5e-3)
    through_valve = found["mean_load_flow_m3_s"] + found["mean_leakage_flow_m3_s"]
    assert found["analytic_load_flow_m3_s"] == pytest.approx(through_valve, rel=3e-3)


def test_left_out_where_the_load_line_is_too_stiff(ran):
    """Without an accumulator 0.4 l of oil and hose take in 4.2e-13 m^3/Pa at 1.34 GPa: 17 of 40 lpm at 71 Hz swing by
    1.64e-4/(71 x 4.2e-13) Pa, 55 bar, of 93. With the accumulator it is 8 bar of 100."""
    found, _ = ran("prototype", ("load_line.gas_volume=0 cc",), "0.3 s")
    assert not set(ANALYTIC) & set(found)
    report = additions(load_system("prototype", ("load_line.gas_volume=0 cc",)))
    assert load_swing(report.bench.values, found) == pytest.approx(0.58, abs=0.03)
    assert any(wording.systems.stiff_load_line in text for text in report.warnings(found))
    shipped, _ = ran("prototype", (), "0.3 s")
    assert load_swing(rotary_bench(load_system("prototype"), "run").values, shipped) == pytest.approx(0.085, abs=0.01)
    assert set(ANALYTIC) <= set(shipped)
