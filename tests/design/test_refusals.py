"""Designs that cannot be, questions without an answer, and what is said of them."""

import pytest

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.design.optimise import InfeasibleError, optimised
from vvdp.design.problem import problem
from vvdp.design.proof import doubts
from vvdp.systems.system import load_system

DROP = "pressure_drop_total"


def conflict(system, limits, bounds, minimise=DROP):
    with pytest.raises(InfeasibleError) as raised:
        optimised(problem(system, minimise, limits, bounds), starts=3, globally=False)
    return str(raised.value)


def test_nozzle_wider_than_a_pitch(prototype):
    """500 mm2 over three nozzles at R = 12.7 mm: d_c = sqrt(A P/(3 L)) = sqrt(500 * 26.6/60.96) = 14.77 mm, twice that
    with the barrier, in 26.6 mm."""
    told = conflict(prototype, [], ["nozzle_area = 500 mm^2", "spool_radius = 12.7 mm"])
    assert "nozzle 14.77 mm and barrier 14.77 mm wide in a pitch of 26.6 mm" in told
    with pytest.raises(ConfigError, match=r"nozzle width 14\.8 mm and barrier width 14\.8 mm do not fit"):
        load_system("prototype", ["valve.nozzle_area=500 mm^2"])


def test_clearance_larger_than_the_land(prototype):
    told = conflict(prototype, [], ["radial_clearance = 0.99 mm", "spool_radius = 12.7 mm", "nozzle_area = 36.5 mm^2"])
    assert "tenth of the barrier" in told
    assert "clearance 990 um, land 3991 um" in told


def test_negative_lap_beyond_the_barrier(prototype):
    with pytest.raises(ConfigError, match=r"negative lap beyond the barrier, which would be -0\.2 nozzle widths wide"):
        problem(prototype, DROP, [], ["lap_ratio >= -0.2"])


def test_no_equilibrium_speed_without_flow():
    still = load_system("prototype", ["operation.pump_speed=0 rpm"])
    with pytest.raises(ConfigError, match="no equilibrium speed: the pump delivers 0"):
        problem(still, DROP)


def test_load_below_tank():
    system = load_system("prototype-constant-load", ["load.pressure=1 bar", "operation.tank_pressure=2 bar"])
    with pytest.raises(ConfigError, match="load at 1 bar is not above the tank at 2 bar"):
        problem(system, DROP)


def test_conflict_names_limits_that_fight_and_no_others(prototype):
    """Speed and drop cannot be had together at this clearance; the leakage has nothing to do with it."""
    limits = ["pwm_frequency >= 150 Hz", "leakage_flow <= 2 lpm", "pressure_drop_total <= 3 bar"]
    told = conflict(prototype, limits, ["radial_clearance <= 22.5 um"])
    assert "pwm_frequency >= 150 Hz (all else allows " in told
    assert "pressure_drop_total <= 3 bar (all else allows " in told
    assert "radial_clearance <= 22.5 um" in told
    assert "leakage" not in told
    assert "nozzle_area" not in told
    # and without either of the two there is a design
    for dropped in (0, 2):
        rest = [limit for k, limit in enumerate(limits) if k != dropped]
        assert optimised(problem(prototype, DROP, rest, ["radial_clearance <= 22.5 um"]), starts=2, globally=False)


def test_what_all_else_allows_can_be_had(prototype):
    """The number in the message is the furthest value: a little less is feasible, a little more is not."""
    limits = ["pressure_drop_total <= 3 bar", "pwm_frequency >= 150 Hz"]
    told = conflict(prototype, limits, ["radial_clearance <= 22.5 um"])
    reach = float(told.partition("pwm_frequency >= 150 Hz (all else allows ")[2].split()[0])
    bounds = ["radial_clearance <= 22.5 um"]
    optimised(
        problem(prototype, DROP, [limits[0], f"pwm_frequency >= {0.999 * reach} Hz"], bounds), starts=3, globally=False
    )
    conflict(prototype, [limits[0], f"pwm_frequency >= {1.001 * reach} Hz"], bounds)


def test_relief_setting_below_the_load(prototype):
    told = conflict(prototype, ["pwm_frequency >= 72 Hz"], ["relief_pressure = 101 bar"], "loss_total")
    assert "relief_pressure = 101 bar" in told
    assert "the relief valve is shut while the load port is open (closest: the open valve leaves -" in told


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
        "did you mean 'pressure_drop_total'",
        "expected a name, a sign and a value",
        "it is a variable, use --bound",
        "'72 bar' is not a frequency",
        "has no unit",
        "unknown variable",
        "leaves nothing between",
        "the spool spins by itself",
    ):
        assert sum(part in text for text in told) == 1, part
    assert len(told) == 8


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("points = 3\n", "has no operating points"),
        ("[[points]]\nweight = -1\n", "point 1: weight: -1; expected a number above zero"),
        ('[[points]]\n"valve.spool_radius" = "10 mm"\n', "no setting of an operating point"),
        ('[[points]]\n"operation.pump_speed" = "10 bar"\n', "point 1: operation.pump_speed"),
        ('[[points]]\n"operation.pump_speed" = "0 rpm"\n', "no equilibrium speed"),
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
    with pytest.raises(ConfigError, match=r"operation\.duty_ratio instead"):
        problem(system, DROP, [], ["helix_length <= 30 mm"])


def test_no_equilibrium_speed_over_a_cycle():
    """At duty ratio 1.4 the tank port never opens, and the load of 130 bar is above the relief valve's 120 bar: all
    flow goes over that, and no jet turns the spool."""
    stalled = load_system("prototype-constant-load", ["operation.duty_ratio=1.4", "load.pressure=130 bar"])
    found = optimised(problem(stalled, DROP, ["pwm_frequency >= 72 Hz"]), starts=1, globally=False)
    with pytest.raises(ConfigError, match="no equilibrium speed: over a cycle the torques balance at "):
        doubts(found.problem, found.values)


def test_parameter_class_refuses_what_cannot_be_made(prototype):
    import dataclasses

    valve = prototype.case.params.supply.valve
    with pytest.raises(ParameterError, match="lap_ratio must be greater than zero"):
        dataclasses.replace(valve, lap_ratio=0.0)
