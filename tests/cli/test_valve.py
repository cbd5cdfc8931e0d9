"""`vvdp valve` against the table of closed forms, and its output for people and programs."""

import json

import pytest
from tests.words import wording

pytestmark = pytest.mark.heavy

# Prototype at 40 degC: flow [lpm]; drops of nozzle, centre section and outlet turbine, and their sum [bar]
DROPS = [
    (10.0, 0.2454, 0.0574, 0.1212, 0.4240),
    (20.0, 0.9817, 0.2157, 0.4848, 1.6822),
    (26.7, 1.7496, 0.3745, 0.8640, 2.9881),
    (30.0, 2.2089, 0.4678, 1.0908, 3.7675),
    (40.0, 3.9269, 0.8105, 1.9392, 6.6765),
    (60.0, 8.8355, 1.7582, 4.3632, 14.9568),
    (80.0, 15.7075, 3.0458, 7.7568, 26.5101),
]


ANSWERS: dict[tuple[str, ...], str] = {}
"""What was printed, by the words of the command: each is run once."""


def asked(vvdp, *arguments, system="prototype"):
    words = ("valve", system, "--json", *arguments)
    if words not in ANSWERS:
        answer = vvdp(*words)
        assert answer.code == 0, answer.err
        ANSWERS[words] = answer.out
    return json.loads(ANSWERS[words])


def flows(*lpm):
    return [word for each in lpm for word in ("--flow", f"{each} lpm")]


def test_drops_over_flow(vvdp):
    lpm, *published = zip(*DROPS, strict=True)
    found = asked(vvdp, *flows(*lpm))
    half_digit = 0.5e-4 * 1e5
    for part, bar in zip(("nozzle", "centre_section", "outlet_turbine", "total"), published, strict=True):
        assert found[f"pressure_drop_{part}_Pa"] == pytest.approx([1e5 * each for each in bar], abs=1.01 * half_digit)


def test_point_of_the_prototype(vvdp):
    """Drops, torques and the frequency of the fully open valve are the published ones; an override of 10 bar and oil
    that pressure thickens move transitions and leakage."""
    found = asked(vvdp, "--flow", "40 lpm")
    assert found["pressure_drop_total_Pa"] == pytest.approx(667_650.0, rel=1e-3)
    assert found["pwm_frequency_Hz"] == pytest.approx(72.0, rel=1e-3)
    assert found["torque_inlet_N_m"] == pytest.approx(0.13547, rel=1e-4)
    assert found["torque_outlet_N_m"] == pytest.approx(0.06580, rel=1e-3)
    assert found["loss_full_open_W"] == pytest.approx(445.1, rel=1e-4)
    assert found["loss_leakage_W"] == pytest.approx(26.3 / 1.1033, rel=2e-3)
    relief, tight = "relief_valve.override_pressure=0 bar", "pump.leakage_conductance=0 m^3/(s*Pa)"
    ideal = (relief, tight, "oil.pressure_viscosity=0 1/Pa")
    both = asked(vvdp, *flows(40, 60), *(word for each in ideal for word in ("--set", each)))
    alone = {key: both[key][0] for key in ("loss_transition_W", "loss_leakage_W")}
    assert alone["loss_transition_W"] == pytest.approx(1333.2, rel=1e-4)
    assert alone["loss_leakage_W"] == pytest.approx(26.3, rel=2e-3)
    assert alone["loss_transition_W"] < found["loss_transition_W"] < 1.03 * alone["loss_transition_W"]
    # 38.1 W at 72 Hz; the loss counts the frequency that the switching valve settles at
    assert found["loss_compressibility_W"] == pytest.approx(38.1 * found["pwm_frequency_averaged_Hz"] / 72.0, rel=5e-3)
    assert found["spool_friction_power_W"] == pytest.approx(30.35, rel=1e-3)


def test_frequency_over_temperature(vvdp):
    """At 40 lpm, the valve fully open. The viscosity away from 40 degC rests on assumed values, hence a per cent."""
    published = {30: 45.3, 40: 72.0, 45: 88.2, 50: 106.3}
    oil = [word for celsius in published for word in ("--temperature", f"{celsius} degC")]
    assert asked(vvdp, *flows(40), *oil)["pwm_frequency_Hz"] == pytest.approx([*published.values()], rel=0.01)


def test_frequency_over_flow(vvdp):
    published = {20: 18.6, 26.7: 32.8, 30: 41.2, 40: 72.0, 50: 110.7}
    assert asked(vvdp, *flows(*published))["pwm_frequency_Hz"] == pytest.approx([*published.values()], abs=0.051)


@pytest.mark.parametrize(("clearance", "hertz"), [("10 um", 57.5), ("15 um", 84.0), ("20 um", 109.2)])
def test_frequency_over_clearance(vvdp, clearance, hertz):
    found = asked(vvdp, *flows(40, 60), "--set", f"valve.radial_clearance={clearance}")
    assert found["pwm_frequency_Hz"][0] == pytest.approx(hertz, abs=0.051)


def test_what_must_add_up(vvdp):
    found = asked(vvdp)
    drops = sum(found[f"pressure_drop_{part}_Pa"] for part in ("nozzle", "centre_section", "outlet_turbine"))
    losses = sum(found[f"loss_{part}_W"] for part in ("full_open", "transition", "compressibility", "leakage"))
    assert found["pressure_drop_total_Pa"] == pytest.approx(drops, rel=1e-12)
    assert found["loss_total_W"] == pytest.approx(losses, rel=1e-12)
    turning = found["torque_inlet_N_m"] + found["torque_outlet_N_m"]
    assert found["torque_friction_N_m"] == pytest.approx(turning, rel=1e-12)


@pytest.mark.thorough
def test_flow_and_temperature_come_from_the_system(vvdp):
    """22.8 cc at 900 rpm are 20.52 lpm; the pump leaks 2.45e-12 m^3/(s Pa) at the mean pressure of its outlet."""
    found = asked(vvdp, "--set", "operation.pump_speed=900 rpm", "--set", "operation.oil_temperature=50 degC")
    assert found["flow_m3_s"] == pytest.approx((20.52 - 0.97) / 60e3, rel=5e-3)
    tight = ["--set", "pump.leakage_conductance=0 m^3/(s*Pa)"]
    assert asked(vvdp, *tight)["flow_m3_s"] == pytest.approx(41.04 / 60e3, rel=1e-8)
    assert found["temperature_K"] == pytest.approx(323.15)


@pytest.mark.thorough
def test_units_of_the_option_do_not_matter(vvdp):
    one, other = asked(vvdp, "--flow", "60 lpm"), asked(vvdp, "--flow", "1e-3 m^3/s")
    numbers = [key for key, value in one.items() if isinstance(value, float)]
    assert [one[key] for key in numbers] == pytest.approx([other[key] for key in numbers], rel=1e-12)


@pytest.mark.thorough
def test_several_points_give_one_list_per_key(vvdp):
    found = asked(vvdp, "--flow", "20 lpm", "--flow", "40 lpm", "--temperature", "30 degC", "--temperature", "40 degC")
    whole = ("verb", "system", "finished")
    rows = {key: value for key, value in found.items() if key not in whole}
    assert all(isinstance(value, list) and len(value) == 4 for value in rows.values())
    assert rows["warnings"] == [[], [], [], []]
    whole = (*whole, "ranges")
    single = asked(vvdp, "--flow", "40 lpm", "--temperature", "30 degC")
    assert {key: value[2] for key, value in rows.items()} == {k: v for k, v in single.items() if k not in whole}


def test_one_point_gives_plain_numbers(vvdp):
    found = asked(vvdp, "--flow", "40 lpm")
    assert (found.pop("verb"), found.pop("system"), found.pop("finished")) == ("valve", "prototype", True)
    assert found.pop("warnings") == []
    assert found.pop("ranges").keys() == found.keys()
    assert all(isinstance(value, float) for value in found.values())


@pytest.mark.thorough
def test_the_load_pressure_used_is_said(vvdp):
    assert wording.valve.initial_load_pressure.format(pressure="100 bar") in vvdp("valve", "prototype").out
    constant = vvdp("valve", "prototype-constant-load", "--set", "load.pressure=80 bar")
    assert wording.valve.prescribed_load_pressure.format(pressure="80 bar") in constant.out


def test_table_for_people(vvdp):
    one = vvdp("valve", "prototype", "--flow", "40 lpm")
    assert "6.677" in one.out
    assert "1381" in one.out
    assert "warning" not in one.out
    several = vvdp("valve", "prototype", "--flow", "40 lpm", "--flow", "60 lpm")
    assert "6.677" in several.out
    assert "14.96" in several.out


def test_a_duty_ratio_out_of_range_warns(vvdp):
    found = asked(vvdp, *flows(40, 60), "--set", "operation.duty_ratio=0.1")
    (warning,) = found["warnings"][0]
    assert wording.valve.duty_ratio_outside.format(duty=0.1) in warning


def test_axial_position_instead_of_duty_ratio(vvdp, here):
    text = vvdp("new", "moved", "--from", "prototype")
    assert text.code == 0
    file = here / "moved.toml"
    file.write_text(file.read_text().replace('duty_ratio = { value = "0.5"', 'axial_position = { value = "10.16 mm"'))
    answer = vvdp("valve", "moved.toml", "--json", *flows(40, 60))
    assert json.loads(answer.out)["duty_ratio"] == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--flow", "40"), wording.files.has_no_unit),
        (("--flow", "40 bar"), wording.files.is_not_a.format(quantity="a volume flow")),
        (("--flow", "0 lpm"), wording.files.greater_than_zero),
        (("--flow", "-40 lpm"), wording.files.greater_than_zero),
        (("--flow", "nan lpm"), wording.files.is_no_number_with_unit),
        (("--temperature", "313"), wording.files.has_no_unit),
        (("--temperature", "500 degC"), "outside"),
        (("--set", "operation.pump_speed=0 rpm"), wording.valve.give_a_flow),
        (("--set", "pump.displacement=0 cc/rev"), wording.valve.give_a_flow),
    ],
)
def test_bad_points_are_refused(vvdp, arguments, said):
    answer = vvdp("valve", "prototype", "--json", *arguments)
    assert answer.code == 2
    assert said in answer.err
    assert not answer.out


def test_all_bad_flows_are_told_at_once(vvdp):
    answer = vvdp("valve", "prototype", "--flow", "40", "--flow", "3 bar")
    assert len(answer.err.splitlines()) == 2


@pytest.fixture
def constant_load(vvdp):
    return asked(vvdp, system="prototype-constant-load")


def test_ranges_hold_each_number_and_each_other(constant_load):
    """Nothing that one value does alone lies outside of what all do together."""
    ranges = constant_load["ranges"]
    assert set(ranges) == {key for key, value in constant_load.items() if isinstance(value, float)}
    for key, each in ranges.items():
        least, most = each["together"]
        assert least <= each["low"] * (1 + 1e-12) and each["high"] <= most * (1 + 1e-12), key
        assert each["low"] <= constant_load[key] <= each["high"], key


@pytest.mark.thorough
def test_the_length_of_the_helix_sets_the_transition_loss(vvdp, constant_load):
    """By an independent program: 1416, 1333, 1245 and 1179 W at 18, 20.32, 23.3 and 26 mm."""
    found = (
        constant_load["loss_transition_W"],
        *constant_load["ranges"]["loss_transition_W"]["by"]["valve.helix_length"],
    )
    assert found == pytest.approx((1333.0, 1416.0, 1179.0), abs=1.0)
    middle = 'valve.helix_length={value="23.3 mm", range=["20.32 mm", "26 mm"]}'
    between = asked(vvdp, "--set", middle, system="prototype-constant-load")
    assert between["loss_transition_W"] == pytest.approx(1245.0, abs=1.0)
    at_ends = between["ranges"]["loss_transition_W"]["by"]["valve.helix_length"]
    assert at_ends == pytest.approx([found[0], found[2]], rel=1e-9)


def test_where_its_closed_form_does_not_hold_the_mean_gives_the_transition_loss(constant_load):
    """A lap of 0.5 joins load and tank for a moment: the closed form stays at 1333 W, the mean over a period falls. A
    lap of 1.2 blocks both for a tenth of the ramps longer, 2 (b - d_c)/pitch Q (P_R - P_T - dP)."""
    joined, blocked = constant_load["ranges"]["loss_transition_W"]["by"]["valve.lap_ratio"]
    assert joined == pytest.approx(800.5, abs=0.5)
    flow, kappa = constant_load["flow_m3_s"], constant_load["transition_fraction"]
    more = 0.2 * kappa * flow * (constant_load["relief_pressure_Pa"] - constant_load["pressure_drop_total_Pa"])
    assert blocked == pytest.approx(constant_load["loss_transition_W"] + more, rel=1e-3)


def test_what_rests_on_no_value_with_a_range_stands_alone(vvdp):
    """Without lap and helix none moves the transition fraction. The drop of the nozzles goes with 1/C^2: 3.927 bar at
    0.61 are 3.568 at 0.64 and 4.344 at 0.58."""
    settings = [f"valve.{name}={value}" for name, value in (("lap_ratio", "1"), ("helix_length", "20.32 mm"))]
    answer = vvdp("valve", "prototype-constant-load", *(word for each in settings for word in ("--set", each)))
    lines = {line.split("  ")[1]: line.split() for line in answer.out.splitlines() if line.startswith("  ")}
    assert lines[wording.valve.transition_fraction][2:] == ["0.3001"]
    assert lines[wording.valve.nozzle_pressure_drop][3:] == ["3.927", "3.567", "4.344", "3.567", "4.344", "bar"]
    assert wording.valve.ranges.format(count=10) in answer.out


def test_a_range_that_does_not_hold_its_value_is_refused(vvdp):
    answer = vvdp("valve", "prototype", "--set", 'valve.lap_ratio={value="1", range=["1.1", "1.2"]}')
    assert answer.code == 2
    assert "valve.lap_ratio: " + wording.files.expected_range_of.format(value=1, low=1.1, high=1.2) in answer.err
