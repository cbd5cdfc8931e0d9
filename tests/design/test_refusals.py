"""Designs that cannot be, questions without an answer, and what is said of them."""

import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.design.infeasibility import InfeasibleError
from vvdp.design.optimise import optimise
from vvdp.design.problem import problem, with_usual_limits
from vvdp.design.proof import doubts
from vvdp.design.quantities import quantities, setup
from vvdp.systems.system import load_system

DROP = "pressure_drop_total"


def conflict(system, limits, bounds, minimise=DROP):
    with pytest.raises(InfeasibleError) as raised:
        optimise(problem(system, minimise, limits, bounds), starts=3, globally=False)
    return str(raised.value)


def test_nozzle_wider_than_a_pitch(prototype):
    """500 mm2 over three nozzles at R = 12.7 mm: d_c = sqrt(A P/(3 L)) = sqrt(500 * 26.6/60.96) = 14.77 mm, twice that
    with the barrier, in 26.6 mm."""
    told = conflict(prototype, [], ["nozzle_area = 500 mm^2", "spool_radius = 12.7 mm"])
    assert wording.design.nozzle_in_pitch.format(nozzle="14.77 mm", barrier="14.77 mm", pitch="26.6 mm") in told
    with pytest.raises(
        ConfigError, match=wording.design.nozzle_and_barrier.format(nozzle="14.8 mm", barrier="14.8 mm")
    ):
        load_system("prototype", ["valve.nozzle_area=500 mm^2"])


def test_clearance_larger_than_the_land(prototype):
    told = conflict(prototype, [], ["radial_clearance = 0.99 mm", "spool_radius = 12.7 mm", "nozzle_area = 36.5 mm^2"])
    assert wording.design.tenth_of_barrier in told
    assert wording.design.clearance_and_land.format(clearance="990 um", land="3991 um") in told


def test_negative_lap_beyond_the_barrier(prototype):
    with pytest.raises(ConfigError, match=wording.design.negative_lap.format(widths=-0.2)):
        problem(prototype, DROP, [], ["lap_ratio >= -0.2"])


def test_no_equilibrium_speed_without_flow():
    still = load_system("prototype", ["operation.pump_speed=0 rpm"])
    with pytest.raises(ConfigError, match=wording.design.no_equilibrium_flow.format(flow=0)):
        problem(still, DROP)


def test_load_below_tank():
    system = load_system("prototype-constant-load", ["load.pressure=1 bar", "operation.tank_pressure=2 bar"])
    with pytest.raises(ConfigError, match=wording.design.load_below_tank.format(load="1 bar", tank="2 bar")):
        problem(system, DROP)


def test_conflict_names_limits_that_fight_and_no_others(prototype):
    """Speed and drop cannot be had together at this clearance; the leakage has nothing to do with it."""
    limits = ["pwm_frequency >= 150 Hz", "leakage_flow <= 2 lpm", "pressure_drop_total <= 3 bar"]
    told = conflict(prototype, limits, ["radial_clearance <= 22.5 um"])
    assert "pwm_frequency >= 150 Hz " + wording.design.all_else_allows in told
    assert "pressure_drop_total <= 3 bar " + wording.design.all_else_allows in told
    assert "radial_clearance <= 22.5 um" in told
    assert "leakage" not in told
    assert "nozzle_area" not in told
    # and without either of the two there is a design
    for dropped in (0, 2):
        rest = [limit for k, limit in enumerate(limits) if k != dropped]
        assert optimise(problem(prototype, DROP, rest, ["radial_clearance <= 22.5 um"]), starts=2, globally=False)


def test_what_all_else_allows_can_be_had(prototype):
    """The number in the message is the furthest value: a little less is feasible, a little more is not."""
    limits = ["pressure_drop_total <= 3 bar", "pwm_frequency >= 150 Hz"]
    told = conflict(prototype, limits, ["radial_clearance <= 22.5 um"])
    reach = float(told.partition("pwm_frequency >= 150 Hz " + wording.design.all_else_allows)[2].split()[0])
    bounds = ["radial_clearance <= 22.5 um"]
    optimise(
        problem(prototype, DROP, [limits[0], f"pwm_frequency >= {0.999 * reach} Hz"], bounds), starts=3, globally=False
    )
    conflict(prototype, [limits[0], f"pwm_frequency >= {1.001 * reach} Hz"], bounds)


def test_relief_setting_below_the_load(prototype):
    told = conflict(prototype, ["pwm_frequency >= 72 Hz"], ["relief_pressure = 101 bar"], "loss_total")
    assert "relief_pressure = 101 bar" in told
    assert wording.design.relief_shut + "-" in told


def test_all_faults_at_once(prototype):
    with pytest.raises(ConfigError) as raised:
        problem(
            prototype, "presure_drop_total",
            ["pwm_frequency > 72 Hz", "spool_radius >= 1 mm", "pwm_frequency >= 72 bar"],
            ["radial_clearance <= 22.5", "clearance <= 3 um", "spool_radius >= 30 mm", "spool_radius <= 20 mm",
             "spool_motor_speed <= 100 rpm"],
        )  # fmt: skip
    told = [str(fault) for fault in raised.value.faults]
    for part in (
        wording.files.did_you_mean.format(name="pressure_drop_total"),
        wording.design.name_sign_value,
        wording.design.use_bound,
        "'72 bar' " + wording.files.is_not_a.format(quantity="a frequency"),
        wording.files.has_no_unit,
        wording.design.unknown_variable,
        wording.design.nothing_between,
        wording.design.spins_by_itself,
    ):
        assert sum(part in text for text in told) == 1, part
    assert len(told) == 8


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", wording.files.is_empty),
        ("points = 3\n", wording.design.no_operating_points),
        ("[[points]]\nweight = -1\n", "point 1: weight: " + wording.design.weight_above_zero.format(weight=-1)),
        ('[[points]]\n"valve.spool_radius" = "10 mm"\n', wording.design.no_operating_setting),
        ('[[points]]\n"operation.pump_speed" = "10 bar"\n', "point 1: operation.pump_speed"),
        ('[[points]]\n"operation.pump_speed" = "0 rpm"\n', wording.design.no_equilibrium),
    ],
)
def test_cycle_files_that_cannot_be_used(prototype, tmp_path, text, said):
    file = tmp_path / "cycle.toml"
    file.write_text(text)
    with pytest.raises(ConfigError) as raised:
        problem(prototype, DROP, [], [], file)
    assert said in str(raised.value)


def test_a_helix_of_another_length_needs_a_duty_ratio():
    system = load_system("prototype", ["operation.axial_position=10.16 mm"])
    with pytest.raises(ConfigError, match=wording.design.duty_ratio_instead):
        problem(system, DROP, [], ["helix_length <= 30 mm"])


def test_no_equilibrium_speed_over_a_cycle():
    """At duty ratio 1.4 the tank port never opens, and the load of 130 bar is above the relief valve's 120 bar: all
    flow goes over that, and no jet turns the spool."""
    stalled = load_system("prototype-constant-load", ["operation.duty_ratio=1.4", "load.pressure=130 bar"])
    found = optimise(problem(stalled, DROP, ["pwm_frequency >= 72 Hz"]), starts=1, globally=False)
    with pytest.raises(ConfigError, match=wording.design.no_equilibrium_torque):
        doubts(found.problem, found.values)


def test_parameter_class_refuses_what_cannot_be_made(prototype):
    import dataclasses

    valve = prototype.case.params.valve
    with pytest.raises(ParameterError, match="lap_ratio: " + wording.files.must_be_greater_than_zero.format(value="0")):
        dataclasses.replace(valve, lap_ratio=0.0)


def test_closest_is_the_closest():
    """Load 130 bar, relief valve at 120 bar: -10 bar, less the least drop within the usual bounds, 0.73 bar."""
    loaded = load_system("prototype-constant-load", ["load.pressure=130 bar"])
    told = conflict(loaded, [], [], "loss_total")
    assert float(told.partition("leaves ")[2].split()[0]) == pytest.approx(-10.73, abs=0.01)


def test_reach_where_several_pairs_fight(prototype):
    """Low drop fights with speed, and so does low leakage: whatever remains, all its limits are told with a number."""
    limits = ["pwm_frequency >= 150 Hz", "pressure_drop_total <= 1 bar", "leakage_flow <= 0.01 lpm"]
    lines = [line for line in conflict(prototype, limits, []).splitlines() if line.strip().partition(" ")[0] in LIMITED]
    assert len(lines) >= 2
    assert all(wording.design.all_else_allows in line for line in lines)


def test_reach_of_a_mean(prototype, tmp_path):
    """Radius and clearance held, the frequency is the larger the smaller both areas are: at their least the mean over
    two points, weighted 3 to 1, is what all else allows; the slower point alone would be less."""
    file = tmp_path / "cycle.toml"
    file.write_text('[[points]]\nweight = 3\n[[points]]\nweight = 1\n"operation.oil_temperature" = "50 degC"\n')
    asked = with_usual_limits(
        problem(prototype, DROP, [], ["spool_radius = 20 mm", "radial_clearance = 6 um"], file), front=False
    )
    corner = {b.variable.name: b.low for b in asked.bounds}
    least, most = sorted(q.pwm_frequency for q in asked.evaluate(corner))
    mean = 0.75 * least + 0.25 * most
    with pytest.raises(InfeasibleError) as raised:
        optimise(asked, starts=1, globally=False)
    told = float(str(raised.value).partition(wording.design.else_allows)[2].split()[0])
    assert told == pytest.approx(mean, rel=1e-5)
    assert told > 1.05 * least


def test_conflict_of_whole_numbers_is_that_of_the_closest(prototype):
    """The frequency is N times that of the spool: five nozzles come closer to 3 kHz than two, and allow what
    they allow with their number held."""
    limits, count = ["pwm_frequency >= 3000 Hz"], wording.design.sections_between.format(low=2, high=5, closest=5)
    told = conflict(prototype, limits, ["sections >= 2", "sections <= 5"])
    assert count in told

    def reach(text):
        return float(text.partition(wording.design.else_allows)[2].split()[0])

    each = [reach(conflict(prototype, limits, [f"sections = {n}"])) for n in (2, 5)]
    assert reach(told) == pytest.approx(each[1], rel=1e-4)
    assert each[1] > 2.0 * each[0]


def test_a_value_demanded_exactly_fights_with_one_of_its_sides(prototype):
    """150 Hz within 3 bar: at least that is too much, at most that no trouble."""
    limits, bounds = ["pwm_frequency = 150 Hz", "pressure_drop_total <= 3 bar"], ["radial_clearance <= 22.5 um"]
    told = conflict(prototype, limits, bounds)
    assert "pwm_frequency >= 150 Hz " + wording.design.all_else_allows in told
    assert "pwm_frequency <=" not in told


LIMITED = ("pwm_frequency", "pressure_drop_total", "leakage_flow")


def test_reach_of_a_negative_quantity(prototype):
    """Relief at 101 bar, load 100 bar: 1 bar less the drop, which is at least 10 bar here."""
    told = conflict(
        prototype, ["relief_margin >= 5 bar", "pressure_drop_total >= 10 bar"], ["relief_pressure = 101 bar"]
    )
    assert "relief_margin >= 5 bar " + wording.design.all_else_allows_at_most.format(reach="-9 bar") in told


def test_usual_bounds_are_values_that_can_be():
    """0.4 times 0.2 um would be below the least length that is read, 0.1 um."""
    tight = load_system("prototype", ["valve.radial_clearance=0.2 um"])
    bound = next(b for b in problem(tight, DROP).bounds if b.variable.name == "radial_clearance")
    assert bound.low == bound.variable.kind.low
    assert bound.high == pytest.approx(0.4e-6)


def test_half_a_nozzle(prototype):
    with pytest.raises(ConfigError, match="sections: " + wording.design.whole_numbers.format(value=2.5)):
        problem(prototype, DROP, [], ["sections = 2.5"])


@pytest.mark.parametrize("duty", ["0", "1"])
def test_a_valve_that_never_switches_has_no_transition_loss(duty):
    still = load_system("prototype-constant-load", [f"operation.duty_ratio={duty}"])
    for minimise, limits, beside in (
        ("loss_total", [], []), (DROP, ["efficiency >= 0.5"], []), (DROP, [], ["load_flow"]),
    ):  # fmt: skip
        with pytest.raises(ConfigError, match="duty_ratio: " + wording.design.never_switches.format(duty=duty)):
            problem(still, minimise, limits, [], beside=beside)
    assert problem(still, DROP)


@pytest.mark.parametrize("question", ["temperature", "tolerance", "optimum", "pareto"])
def test_no_flow_is_refused_by_every_question(designing, question):
    code, _, err = designing(question, "prototype", "--set", "operation.pump_speed=0 rpm")
    assert code == 2
    assert err.count(wording.design.no_equilibrium_flow.format(flow="0 lpm")) == 1
    assert "Traceback" not in err


def test_usual_limits_stand_where_nothing_of_their_sort_is_asked(prototype):
    def told(minimise, limits=(), front=False, beside=()):
        asked = with_usual_limits(problem(prototype, minimise, limits, beside=beside), front=front)
        return [str(limit) for limit in asked.limits if limit.usual]

    base = "pwm_frequency >= 71.9917 Hz"
    assert told("loss_total") == [base]
    assert told(DROP, ["transition_fraction <= 0.5"]) == [base]
    assert told(DROP, ["pwm_frequency >= 20 Hz"]) == told(DROP, ["load_pulsation <= 9 cc"]) == []
    assert told("load_pulsation") == told("loss_total", front=False, beside=["pwm_frequency"]) == []
    on_fronts = [base, "transition_fraction <= 0.5", "relief_margin >= 0 bar", "input_power <= 5600 W"]
    assert told("loss_total", front=True, beside=["pwm_frequency", "transition_fraction"]) == on_fronts
    assert told("loss_total", ["input_power <= 4 kW"], front=True) == on_fronts[:3]
    assert told("loss_total", ["load_pulsation <= 9 cc", "transition_fraction <= 0.4"], front=True) == on_fronts[2:]


def test_a_usual_limit_does_not_refuse_the_system_as_it_is():
    """With nozzles of three times the area a transition takes more than half a period."""
    slow = load_system("prototype", ["valve.nozzle_area=110 mm^2"])
    now = quantities(setup(slow)).transition_fraction
    assert now > 0.5
    limits = with_usual_limits(problem(slow, "loss_total"), front=True).limits
    assert next(limit.value for limit in limits if limit.quantity == "transition_fraction") == now


def test_limits_and_bounds_in_words(prototype):
    asked = problem(prototype, DROP, ["pwm_frequency >= 72 Hz", "efficiency = 0.6"], ["radial_clearance <= 22.5 um"])
    assert [limit.words for limit in asked.limits] == [
        wording.design.frequency_limit.format(frequency="72 Hz"),
        "efficiency = 60 %",
    ]
    assert [str(limit) for limit in asked.limits] == ["pwm_frequency >= 72 Hz", "efficiency = 0.6"]
    upper, lower = next(b for b in asked.bounds if b.variable.name == "radial_clearance").sides
    assert (upper.words, str(upper)) == ("radial clearance ≤ 22.5 µm", "radial_clearance <= 22.5 um")
    assert (upper.is_given, lower.is_given) == (True, False)


def test_a_usual_limit_that_cannot_be_met_is_told_as_such(designing):
    code, _, err = designing("prototype", "--bound", "spool_radius = 20 mm", "--bound", "radial_clearance = 6 um",
                             "--no-simulation", "--starts", "2")  # fmt: skip
    assert code == 1
    assert "pwm_frequency >= 72.0012 Hz " + wording.design.all_else_allows in err
    assert wording.design.usual_limit in err
