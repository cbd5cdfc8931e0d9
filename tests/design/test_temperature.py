"""From cold to hot oil, and the warnings on the way."""

import json

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.design.quantities import quantities, setup
from vvdp.design.temperature import over_temperature
from vvdp.design.temperature_result import temperature_result
from vvdp.systems.system import load_system
from vvdp.valve.operating_point import SetPoint, operating_point


@pytest.fixture(scope="module")
def warmed(prototype):
    return over_temperature(prototype, step=5.0)


def column(found, name, celsius):
    return found.columns[name][np.argmin(np.abs(found.temperatures - 273.15 - celsius))]


def test_published_frequencies(warmed):
    """45.3, 72.0, 88.2, 106.3 Hz at 30, 40, 45, 50 degC."""
    for celsius, frequency in ((30, 45.3), (40, 72.0), (45, 88.2), (50, 106.3)):
        assert column(warmed, "pwm_frequency", celsius) == pytest.approx(frequency, abs=0.06)


def test_rows_are_the_operating_point(prototype, warmed):
    at = setup(prototype)
    for celsius in (10, 60, 80):
        temperature = celsius + 273.15
        set_point = SetPoint(
            flow=at.flow,
            temperature=temperature,
            duty_ratio=at.duty_ratio,
            load_pressure=at.load_pressure,
            relief_pressure=at.relief_pressure,
            tank_pressure=at.tank_pressure,
            relief_override=at.relief_override,
            relief_rated_flow=at.relief_rated_flow,
        )
        point = operating_point(set_point, at.inlet_volume, at.oil, at.valve)
        assert column(warmed, "pwm_frequency", celsius) == pytest.approx(point.full_open_pwm_frequency)
        assert column(warmed, "pwm_frequency_averaged", celsius) == pytest.approx(point.averaged_pwm_frequency)
        assert column(warmed, "loss_transition", celsius) == pytest.approx(point.transition_loss)
        assert column(warmed, "nozzle_reynolds_number", celsius) == pytest.approx(point.nozzle_reynolds_number)


def test_warmer_oil_is_thinner_and_lighter(warmed):
    assert warmed.temperatures[0] == pytest.approx(283.15)
    assert warmed.temperatures[-1] == pytest.approx(353.15)
    for name, sign in (("viscosity", -1), ("pressure_drop_total", -1), ("pwm_frequency", 1), ("loss_leakage", 1)):
        assert np.all(sign * np.diff(warmed.columns[name]) > 0.0), name


def test_eccentricity_bears_the_jets(prototype, warmed):
    """1.752 N at 40 degC on two lands of 459.5 N each: for a small one W = 2 * 459.5 eps pi/4, eps = 2.43e-3."""
    assert column(warmed, "radial_force", 40) == pytest.approx(1.752, abs=2e-3)
    assert column(warmed, "eccentricity", 40) == pytest.approx(1.752 / (2.0 * 459.5 * np.pi / 4.0), rel=2e-3)
    assert np.all(warmed.columns["bearing_capacity"] > 1e3 * warmed.columns["radial_force"])


def test_cavitation_numbers_by_hand(warmed):
    """Tank port open: behind the nozzles the tank's 1.013 bar and 2.750 bar of drop, less 0.3 bar, over 3.927 bar:
    0.8818. Closing: (1.013 - 0.3)/120 = 0.00594."""
    assert column(warmed, "cavitation_number_open", 40) == pytest.approx(0.8818, rel=1e-3)
    assert column(warmed, "cavitation_number_closing", 40) == pytest.approx(0.00594, rel=1e-2)


def test_the_prototype_is_warned_of(warmed):
    told = warmed.warnings
    assert len(told) == 3
    assert any(
        wording.design.reynolds_range.format(lowest=247, cold="10 °C", hot="50 °C", limit=2300) in text for text in told
    )
    assert any(wording.design.tank_port_closing in text and wording.design.at_all_temperatures in text for text in told)
    assert any(wording.design.leaking_oil in text for text in told)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        # 40 lpm at 12 to 13 MPa and duty ratio 0.8 are above 5.6 kW
        (["operation.duty_ratio=0.8"], wording.design.motor_overloaded),
        # at duty ratio 0.2 the load port never opens fully, kappa 0.30
        (["operation.duty_ratio=0.2"], wording.design.never_fully_open),
        # two thousandths of the land length bear a billionth of the force
        (["valve.land_length=0.3 mm"], wording.design.lands_touch),
        # 0.5 mm of clearance and 3000 turns per minute: Re = 876*314*0.0127*5e-4/0.0387 = 45, times sqrt(0.04) = 9;
        # hot oil has a quarter of that viscosity
        (
            ["valve.radial_clearance=0.5 mm", "spool_drive.coupling=100 N*m*s", "operation.spool_motor_speed=6000 rpm"],
            wording.design.vortices,
        ),
        # 20000 turns per minute: 26.6 m/s, mu u^2/(8 lambda) = 26 K
        (
            ["spool_drive.coupling=100 N*m*s", "operation.spool_motor_speed=20000 rpm"],
            wording.design.film_thinner,
        ),
        # 118 bar and 6.68 bar of open drop above a setting of 120 bar
        (["load.pressure=118 bar"], wording.design.relief_margin_down_to + "−4."),
        # nothing behind the nozzles but the tank
        (["valve.outlet_area=2000 mm^2", "valve.centre_coefficient=1e-3 SI"], wording.design.behind_nozzles),
    ],
)  # fmt: skip
def test_every_check_can_be_seen(settings, words):
    found = over_temperature(load_system("prototype-constant-load", settings), step=35.0)
    assert any(words in text for text in found.warnings), found.warnings


def test_a_check_is_kept_on_the_other_side():
    small = load_system("prototype-constant-load", ["operation.duty_ratio=0.5"])
    found = over_temperature(small, step=35.0)
    assert not any("motor" in text for text in found.warnings)
    assert column(found, "input_power", 45) == pytest.approx(4652.0, rel=0.01)


def test_columns_have_units(warmed):
    names = set(temperature_result(warmed).tables["temperature"].columns)
    assert {"temperature_K", "viscosity_Pa_s", "radial_force_N", "carried_temperature_rise_K", "efficiency"} <= names


def test_usage_is_above_one_where_a_check_is_not_kept(prototype):
    """Also a margin, whose limit is zero: 118 bar and 6.66 bar of drop are 1.04 of a setting of 120 bar, absolute."""
    tight = load_system("prototype-constant-load", ["load.pressure=118 bar", "operation.duty_ratio=0.2"])
    for found in (over_temperature(prototype, step=5.0), over_temperature(tight, step=35.0)):
        for check in found.checks:
            assert np.array_equal(check.usage > 1.0, check.outside), check.name
    margin = next(check for check in found.checks if check.name == "relief_margin")
    assert margin.usage[1] == pytest.approx((118.0 + 6.66 + 1.013) / 121.013, abs=1e-3)


def test_a_range_of_temperatures_is_needed(prototype):
    with pytest.raises(ParameterError, match=wording.design.expected_range):
        over_temperature(prototype, coldest=350.0, hottest=300.0)


@pytest.mark.parametrize(
    ("hottest", "expected"),
    [
        # 21 K in steps of at most 2.5 K: 9 of 2.333 K
        (41.0, 20.0 + 21.0 / 9.0 * np.arange(10)),
        (22.0, [20.0, 22.0]),
        (25.0, [20.0, 22.5, 25.0]),
    ],
)
def test_both_ends_are_in_the_range(prototype, hottest, expected):
    found = over_temperature(prototype, coldest=293.15, hottest=hottest + 273.15)
    assert found.temperatures - 273.15 == pytest.approx(expected)
    assert any(wording.design.at_all_temperatures in text for text in found.warnings)


def test_what_is_shown_at_40_degrees_is_the_design(prototype, warmed):
    q = quantities(setup(prototype))
    assert column(warmed, "loss_total", 40) == pytest.approx(q.loss_total, rel=1e-12)


def test_command_over_temperature(designing, tmp_path, keys_as_described):
    code, out, err = designing("temperature", "prototype", "--json", "--out", "there", "--from", "20 degC")
    assert code == 0, err
    found = json.loads(out)
    keys_as_described("design temperature", found)
    assert found["temperature_K"][0] == pytest.approx(293.15)
    assert len(found["pwm_frequency_Hz"]) == len(found["temperature_K"]) == 25
    assert any("Reynolds" in text for text in found["warnings"])
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.model_in_doubt in page
    assert (tmp_path / "there" / "figures" / "range.svg").is_file()


def test_command_over_temperature_for_a_person(designing):
    code, out, _ = designing("temperature", "prototype")
    assert code == 0
    assert f"warning: {wording.design.model_in_doubt}: " in out
    code, _, err = designing("temperature", "prototype", "--from", "80 degC", "--to", "10 degC")
    assert code == 2
    assert wording.design.expected_temperatures in err
    code, _, err = designing("temperature", "prototype", "--from", "80")
    assert code == 2
    assert err.startswith("--from: '80' " + wording.files.has_no_unit)
