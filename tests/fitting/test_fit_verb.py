"""`vvdp fit`: what a table was made of comes back, with intervals, in a system that runs; bad tables are refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.fluid.oil import density, film_viscosity
from vvdp.systems.spool_travel import rotary_valves
from vvdp.systems.system import load_system
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.torque import inlet_torque

SYSTEM = load_system("prototype")
VALVE, OIL = SYSTEM.case.params.valve, SYSTEM.case.params.oil
WARM, TANK = 313.15, 101325.0
RHO = float(density(WARM, OIL))
LPM = 1.0 / 60e3


def rows(head, *lines):
    return "\n".join([head, *(",".join(f"{cell:.12g}" if isinstance(cell, float) else cell for cell in line)
                              for line in lines)]) + "\n"  # fmt: skip


def drops_of(valve, place, flows=(10.0, 20.0, 40.0, 60.0)):
    drops = [turbulent_drops(q * LPM, 1.0, RHO, valve)[place] for q in flows]
    return rows("flow [lpm],pressure drop [bar]", *((q, dp / 1e5) for q, dp in zip(flows, drops, strict=True)))


def valve_of(told):
    return load_system(f"{told['out']}/fitted.toml").case.params.valve


def test_the_centre_section_of_another_valve_comes_back(fit, write):
    other = replace(VALVE, centre_flow_exponent=1.85, centre_coefficient=3e-6)
    told = fit(write(drops_of(other, 1)), "--law", "drop", "--on", "prototype")
    assert told["exponent"] == pytest.approx(1.85, rel=1e-9)
    assert told["coefficient"] == pytest.approx(1.0 / (3e-6 * 0.0254**3.22), rel=1e-8)
    assert told["confidence_95"]["exponent"] == pytest.approx([1.85, 1.85], rel=1e-8)
    fitted = valve_of(told)
    assert fitted.centre_flow_exponent == pytest.approx(1.85, rel=1e-8)
    assert fitted.centre_coefficient == pytest.approx(3e-6, rel=1e-7)


def test_several_diameters_give_their_exponent(fit, write):
    lines = []
    for radius in (10e-3, 12.7e-3, 16e-3):
        for q in (15.0, 30.0, 60.0):
            other = replace(VALVE, spool_radius=radius, inlet_radius=9e-3, outlet_radius=9e-3)
            lines.append((q, turbulent_drops(q * LPM, 1.0, RHO, other).centre_section, 2e3 * radius))
    told = fit(write(rows("flow [lpm],pressure_drop_Pa,diameter [mm]", *lines)), "--law", "drop", "--on", "prototype")
    assert told["diameter_exponent"] == pytest.approx(3.22, rel=1e-8)
    assert told["centre_coefficient"] == pytest.approx(1.45e-6, rel=1e-6)


@pytest.mark.parametrize(("part", "place", "key"), [("nozzle", 0, "nozzle"), ("outlet", 2, "outlet")])
def test_a_discharge_coefficient_comes_back(fit, write, part, place, key):
    name = f"{key}_discharge_coefficient"
    other = replace(VALVE, rail_coefficient=0.0, **{name: 0.7})
    told = fit(write(drops_of(other, place)), "--law", "drop", "--part", part, "--on", "prototype")
    assert told[name] == pytest.approx(0.7, rel=1e-8)
    assert told["exponent"] == pytest.approx(2.0, rel=1e-9)
    assert getattr(valve_of(told), name) == pytest.approx(0.7, rel=1e-8)
    assert told["warnings"] == []


def test_the_drop_of_a_rail_is_taken_off_the_outlet(fit, write):
    other = replace(VALVE, rail_coefficient=2e10, outlet_discharge_coefficient=0.65)
    words = ("--law", "drop", "--part", "outlet", "--on", "prototype")
    told = fit(write(drops_of(other, 2)), *words, "--set", "valve.rail_coefficient=2e10 Pa*s^2/m^6")
    assert told["outlet_discharge_coefficient"] == pytest.approx(0.65, rel=1e-8)


def test_jets_while_closing_and_opening_come_back(fit, write):
    other = replace(VALVE, jet_exponent=0.5, jet_asymmetry=0.6)
    lines = [("", 1.0, 40.0, inlet_torque(40.0 * LPM, 1.0, RHO, other))]
    for a, q in ((0.75, 40.0), (0.5, 40.0), (0.25, 20.0)):
        for word, side in (("closing", 1.0), ("opening", -1.0)):
            skew = side * other.jet_asymmetry * a * (1.0 - a)
            lines.append((word, a, q, inlet_torque(q * LPM / a, a, RHO, other, skew)))
    told = fit(write(rows("port,opening,flow [lpm],torque [N*m]", *lines)), "--law", "jet", "--on", "prototype")
    assert (told["exponent"], told["asymmetry"]) == pytest.approx((0.5, 0.6), rel=1e-8)
    assert told["coefficient"] == pytest.approx(inlet_torque(40.0 * LPM, 1.0, RHO, VALVE), rel=1e-8)
    assert (valve_of(told).jet_exponent, valve_of(told).jet_asymmetry) == pytest.approx((0.5, 0.6), rel=1e-8)


def test_a_clearance_comes_back_through_warm_and_cold_oil(fit, write):
    """Q = G(mu) dp with the viscosity of the film at each pressure and temperature."""
    other = replace(VALVE, radial_clearance=15e-6)
    lines = []
    for celsius in (30.0, 40.0, 55.0):
        for bar in (40.0, 80.0, 160.0):
            mu = film_viscosity(celsius + 273.15, TANK + bar * 1e5, TANK, OIL)
            lines.append((bar, 60e3 * leakage_conductance(mu, other) * bar * 1e5, celsius))
    table = write(rows("pressure drop [bar],leakage [lpm],temperature [degC]", *lines))
    told = fit(table, "--law", "leakage", "--on", "prototype")
    assert told["exponent"] == pytest.approx(1.0, rel=1e-9)
    assert told["radial_clearance_m"] == pytest.approx(15e-6, rel=1e-8)
    assert valve_of(told).radial_clearance == pytest.approx(15e-6, rel=1e-8)


def test_the_jets_of_flow_simulation_give_what_the_system_has(fit, write):
    """The torques from which the system's 0.65 and 0.85 were read by eye."""
    table = write(
        "opening,port,flow [lpm],torque [N*m]\n1,,40,0.132\n0.75,closing,40,0.202\n0.75,opening,40,0.121\n"
        "0.5,closing,40,0.285\n0.5,opening,40,0.122\n0.25,closing,20,0.148\n0.25,opening,20,0.033\n"
    )
    told = fit(table, "--law", "jet", "--on", "prototype")
    low, high = told["confidence_95"]["exponent"]
    assert low < VALVE.jet_exponent < high
    low, high = told["confidence_95"]["asymmetry"]
    assert low < VALVE.jet_asymmetry < high


def test_intervals_hold_the_truth_as_often_as_they_say():
    """Drops with 2 % of scatter, 400 tables of five flows: a binomial of 0.95 has a deviation of 1.1 %."""
    from vvdp.fitting.drop import fit_centre

    rng, flows = np.random.default_rng(17), np.array([10.0, 20.0, 30.0, 40.0, 60.0]) * LPM
    inside = np.zeros(2)
    for _ in range(400):
        drops = 1e11 * flows**1.91 * np.exp(rng.normal(0.0, 0.02, 5))
        found = fit_centre({"flow": flows, "pressure_drop": drops}, None).coefficients
        for k, (key, truth) in enumerate((("coefficient", 1e11), ("exponent", 1.91))):
            inside[k] += found[key].interval.low < truth < found[key].interval.high
    assert inside / 400 == pytest.approx([0.95, 0.95], abs=0.035)


def test_the_band_of_the_chart_is_the_interval_of_the_law(fit, write):
    """At the geometric middle of the flows the band is that of a mean: t s / sqrt(n) of the logarithm."""
    flows = np.array([10.0, 20.0, 40.0, 80.0])
    drops = 1e-3 * flows**1.9 * np.array([1.02, 0.97, 1.03, 0.98])
    table = write(rows("flow [lpm],pressure_drop [bar]", *zip(flows.tolist(), drops.tolist(), strict=True)))
    told = fit(table, "--law", "drop")
    middle = np.exp(np.log(flows * LPM).mean())
    width = np.interp(middle, told["curve_flow_m3_s"], np.log(told["curve_high_Pa"]) - np.log(told["curve_low_Pa"]))
    s = told["scatter"] * np.sqrt(4.0 / 2.0)
    assert width == pytest.approx(2.0 * 4.3027 * s / 2.0, rel=2e-3)


def test_a_value_beyond_the_law_is_held_at_its_end_and_said(fit, write):
    table = write(rows("flow [lpm],pressure_drop [bar]", *((q, 1e-3 * q**2.2) for q in (10.0, 20.0, 40.0))))
    told = fit(table, "--law", "drop", "--on", "prototype")
    assert valve_of(told).centre_flow_exponent == 2.0
    assert wording.fit.is_written.format(count=2) in told["warnings"][0]
    middle = turbulent_drops(20.0 * LPM, 1.0, RHO, valve_of(told)).centre_section
    assert middle == pytest.approx(1e2 * 20.0**2.2, rel=1e-6)


def test_a_part_that_is_not_quadratic_and_a_leak_that_is_not_laminar_are_said(fit, write):
    flows = (10.0, 20.0, 40.0, 60.0)
    table = write(rows("flow [lpm],pressure_drop [bar]", *((q, 3e-3 * q**1.8) for q in flows)))
    told = fit(table, "--law", "drop", "--part", "nozzle", "--on", "prototype")
    assert wording.fit.to_the_power.format(low="1.80", high="1.80") in told["warnings"][0]
    table = write(rows("pressure_drop [bar],leakage [lpm]", *((p, 1e-3 * p**0.5) for p in flows)))
    assert wording.fit.to_the_power.format(low="0.500", high="0.500") in fit(table, "--law", "leakage")["warnings"][0]


def test_every_key_of_a_fit_is_described(fit, write, keys_as_described):
    drop, told = write(drops_of(VALVE, 1)), []
    for part in ("centre", "nozzle", "outlet"):
        told.append(fit(drop, "--law", "drop", "--part", part, "--on", "prototype"))
    told.append(fit(write("opening,torque [N*m]\n1,0.1\n0.5,0.15\n0.3,0.2\n"), "--law", "jet", "--on", "prototype"))
    table = write("opening,torque [N*m],port,flow [lpm]\n" + "".join(
        f"{a},{t},{port},40\n" for a, t, port in ((1, 0.1, ""), (0.5, 0.2, "closing"), (0.5, 0.1, "opening"),
                                                 (0.3, 0.3, "closing"), (0.3, 0.1, "opening"))))  # fmt: skip
    told.append(fit(table, "--law", "jet", "--on", "prototype"))
    leaks = write("pressure_drop [bar],leakage [lpm]\n50,0.1\n100,0.2\n150,0.31\n")
    told.append(fit(leaks, "--law", "leakage", "--on", "prototype"))
    lines = [(q, 1e-3 * q**1.9 / d**3, d) for q in (10.0, 20.0, 40.0) for d in (20.0, 30.0)]
    told.append(fit(write(rows("flow [lpm],pressure_drop [bar],diameter [mm]", *lines)), "--law", "drop",
                    "--on", "prototype"))  # fmt: skip
    keys_as_described("fit", *told)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", wording.fit.no_heading),
        ("flow [lpm],pressure drop [bar]\n", wording.fit.no_rows),
        (
            "flow [lpm],drop [bar]\n1,2\n",
            ":1: pressure_drop: " + wording.fit.no_column.format(example="pressure_drop [bar]"),
        ),
        ("flow [lpm],flow [lpm],pressure_drop_Pa\n1,2,3\n", ":1: flow: " + wording.fit.stands_twice.format(count=2)),
        (
            "flow [bar],pressure_drop_Pa\n1,2\n",
            ":2: flow [bar]: '1 bar' " + wording.files.is_not_a.format(quantity="a volume flow"),
        ),
        ("flow,pressure_drop_Pa\n1,2\n", ":2: flow: '1' " + wording.files.has_no_unit),
        ("# rig 3\nflow [lpm],pressure_drop_Pa\n1,2\n3\n", ":4: pressure_drop_Pa: " + wording.fit.empty_cell),
        (
            "flow [lpm],pressure_drop [bar]\n1,2\n0,x\n",
            ":3: flow [lpm]: " + wording.files.must_be_greater_than_zero.format(value="'0'"),
        ),
        (
            "flow [lpm],pressure_drop [bar]\n1,2\n0,x\n",
            ":3: pressure_drop [bar]: " + wording.logs.not_a_number.format(value="x bar"),
        ),
        ("flow [lpm],pressure_drop [bar]\n" + "x,1\n" * 13, wording.fit.more_cells.format(count=3)),
        ("flow [lpm],pressure_drop [bar]\n1,1\n2,2\n", wording.fit.too_few.format(values=2, coefficients=2)),
        ("flow [lpm],pressure_drop [bar]\n1,1\n1,2\n1,3\n", wording.fit.not_told_apart.format(count=2)),
    ],
)
def test_a_bad_table_is_refused_with_row_and_column(vvdp, write, tmp_path, text, words):
    answer = vvdp("fit", str(write(text)), "--law", "drop", "--out", str(tmp_path / "new"))
    assert answer.code == 2
    assert words in answer.err
    assert not (tmp_path / "new").exists()


def test_a_word_that_is_no_port_is_refused(vvdp, write):
    answer = vvdp("fit", str(write("opening,torque [N*m],port\n1,0.1,half\n")), "--law", "jet")
    assert ":2: port: " + wording.fit.port.format(port="half") in answer.err


LAWS = "orifice, drop, jet, leakage"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("--law", "duck"),
            "--law: " + wording.fit.unknown_choice.format(value="duck", choices=LAWS),
        ),
        (
            ("--law", "drop", "--part", "duck"),
            "--part: " + wording.fit.unknown_choice.format(value="duck", choices="centre, nozzle, outlet"),
        ),
        (("--law", "drop", "--set", "valve.sections=4"), wording.fit.no_system),
        (("--law", "drop", "--on", "boost-converter"), wording.rig.needs_rotary_valve),
    ],
)
def test_options_that_mean_nothing_are_refused(vvdp, write, words, said):
    answer = vvdp("fit", str(write(drops_of(VALVE, 1))), *words)
    assert answer.code == 2
    assert said in answer.err


def test_one_of_several_valves_takes_the_coefficient(vvdp, fit, write):
    """Twice the drop is 1/sqrt(2) of the discharge coefficient; the other valve keeps its own."""
    halved = replace(VALVE, nozzle_discharge_coefficient=0.61 / np.sqrt(2.0))
    words = ("--law", "drop", "--part", "nozzle", "--on", "two-cylinders")
    told = fit(write(drops_of(halved, 0)), *words, "--component", "lift_unit")
    valves = rotary_valves(load_system(f"{told['out']}/fitted.toml").circuit.network, {})
    assert [each.nozzle_discharge_coefficient for each in valves] == pytest.approx([0.61 / np.sqrt(2.0), 0.61])
    answer = vvdp("fit", str(write(drops_of(VALVE, 0))), *words)
    assert "several: give --component, one of lift_unit, swing_unit" in answer.err


def test_temperatures_without_an_oil_are_refused(vvdp, write):
    table = write("pressure_drop [bar],leakage [lpm],temperature [degC]\n50,0.1,40\n60,0.1,40\n70,0.1,40\n")
    assert wording.fit.system_needed in vvdp("fit", str(table), "--law", "leakage").err


def test_semicolons_and_decimal_commas_are_read(fit, write):
    table = write("flow [lpm];pressure_drop [bar]\n10;0,1\n20;0,4\n40;1,6\n")
    assert fit(table, "--law", "drop")["exponent"] == pytest.approx(2.0)


def test_the_table_of_a_study_is_read_as_it_is(fit, write):
    table = write("flow_m3_s,pressure_drop_Pa,spread_Pa\n1e-4,1e4,3\n2e-4,4e4,\n4e-4,1.6e5,1\n")
    assert fit(table, "--law", "drop")["exponent"] == pytest.approx(2.0)


def test_the_page_has_law_points_and_picture(vvdp, write, tmp_path):
    answer = vvdp("fit", str(write(drops_of(VALVE, 1))), "--law", "drop", "--on", "prototype", "--out",
                  str(tmp_path / "kept"))  # fmt: skip
    assert answer.code == 0, answer.err
    assert wording.fit.exponent in answer.out
    assert f"vvdp run {tmp_path / 'kept' / 'fitted.toml'}" in answer.out
    assert (tmp_path / "kept" / "figures" / "fit.svg").is_file()
    page = (tmp_path / "kept" / "report.html").read_text("utf-8")
    assert wording.fit.centre_exponent in page
    content = json.loads((tmp_path / "kept" / "result.json").read_text("utf-8"))
    assert content["verb"] == "fit"
