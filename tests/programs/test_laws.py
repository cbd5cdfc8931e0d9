"""Laws of the programs for any quantity, against numbers worked out by hand and closed forms."""

from math import exp

import pytest

from vvdp.base.kinds import FLOW, PRESSURE_LEVEL, SPEED
from vvdp.control.pid import PidGains, Sample, pid_start, pid_step
from vvdp.control.reference import Reference, reference_step
from vvdp.programs.arithmetic import Factors, Grid, Looked, Summands, Weights, product_step, sum_step, table_step
from vvdp.programs.filters import (
    Led,
    LedReference,
    Limits,
    LowPass,
    RateLimit,
    Read,
    last_value_start,
    limit_step,
    low_pass_step,
    rate_limit_step,
    smooth_start,
    smooth_step,
)
from vvdp.programs.library import PROGRAMS
from vvdp.programs.pulses import Cycle, Duty, Now, Pulses, cycle_step, pulse_command, pulse_count

GAINS = PidGains(
    gain=2.0, reset_time=1.0, derivative_time=0.0, filter_time=0.0, setpoint_weight=1.0, tracking_time=0.0,
    lowest=-1e9, highest=1e9, start=0.0,
)  # fmt: skip


def commands(gains, *samples, interval=0.1):
    """The commands of samples (measured, reference), one after the other."""
    memory, found = pid_start(), []
    for number, (measured, reference) in enumerate(samples):
        memory, command = pid_step(number * interval, memory, Sample(measured, reference, 0.0), gains)
        found.append(command)
    return found


def test_pi_begins_at_its_start_and_integrates():
    """K h/T_i e = 2 x 0.1 x 1 for each sample after the first."""
    assert commands(GAINS, *[(0.0, 1.0)] * 4) == pytest.approx([0.0, 0.2, 0.4, 0.6])
    assert commands(GAINS._replace(start=5.0), *[(0.0, 1.0)] * 2) == pytest.approx([5.0, 5.2])


def test_pi_answers_a_step_with_its_gain():
    assert commands(GAINS, (0.0, 0.0), (0.0, 1.0)) == pytest.approx([0.0, 2.2])


def test_a_start_beyond_a_limit_is_held_there():
    assert commands(GAINS._replace(start=5.0, highest=3.0), (0.0, 0.0)) == [3.0]


def test_a_clamped_integral_leaves_the_limit_at_once():
    """After 50 samples at the limit 1 the error changes its sign: 2 x (-1) - 0.2 below the last free value."""
    gains = GAINS._replace(highest=1.0)
    found = commands(gains, (0.0, 0.0), *[(0.0, 1.0)] * 50, (2.0, 1.0))
    assert found[1:51] == [1.0] * 50
    assert found[51] == pytest.approx(-2.2)


def test_without_a_limit_the_same_integral_winds_up():
    assert commands(GAINS, (0.0, 0.0), *[(0.0, 1.0)] * 50, (2.0, 1.0))[51] == pytest.approx(10.0 - 2.2)


def test_back_calculation():
    """Asked 2.2 and let through 1: the integral 0.2 is led back by h/T_t x 1.2 = 0.6 to -0.4; then 2 + 0.2 - 0.4."""
    gains = GAINS._replace(highest=1.9, tracking_time=0.2)
    found = commands(gains._replace(highest=1.0), (0.0, 0.0), (0.0, 1.0), (0.5, 1.0))
    assert found == pytest.approx([0.0, 1.0, 0.7])


def test_a_negative_gain_is_clamped_the_same_way():
    gains = GAINS._replace(gain=-2.0, highest=1.0)
    assert commands(gains, (0.0, 0.0), *[(1.0, 0.0)] * 50, (-1.0, 0.0))[51] == pytest.approx(-2.2)


def test_filtered_derivative():
    """-K T_d dy/(T_f + h) = -2 x 0.5/0.15, then T_f/(T_f + h) of it, beside P = -2 and the integral -0.2, -0.4."""
    gains = GAINS._replace(derivative_time=0.5, filter_time=0.05)
    found = commands(gains, (0.0, 0.0), (1.0, 0.0), (1.0, 0.0))
    first = -1.0 / 0.15
    assert found == pytest.approx([0.0, -2.2 + first, -2.4 + first / 3.0])


def test_setpoint_weight_and_feedforward():
    _, first = pid_step(0.0, pid_start(), Sample(0.0, 0.0, 0.0), GAINS)
    memory, _ = pid_step(0.0, pid_start(), Sample(0.0, 0.0, 0.0), GAINS)
    _, command = pid_step(0.1, memory, Sample(0.0, 1.0, 3.0), GAINS._replace(setpoint_weight=0.0))
    assert first == 0.0 and command == pytest.approx(0.2 + 3.0)


@pytest.mark.parametrize("times", [(0.1,), (0.01, 0.03, 0.1)])
def test_low_pass_is_exact_for_a_held_input(times):
    memory, _ = low_pass_step(0.0, last_value_start(None), Read(0.0), LowPass(time_constant=0.05))
    for t in times:
        memory, found = low_pass_step(t, memory, Read(1.0), LowPass(time_constant=0.05))
    assert found.value == pytest.approx(1.0 - exp(-2.0), rel=1e-14)


def test_rate_limit():
    limits, found = RateLimit(rise=2.0, fall=5.0), []
    memory = last_value_start(limits)
    for t, value in ((0.0, 1.0), (0.1, 9.0), (0.2, 1.3), (0.3, -9.0)):
        memory, given = rate_limit_step(t, memory, Read(value), limits)
        found.append(given.value)
    assert found == pytest.approx([1.0, 1.2, 1.3, 0.8])


def test_limit():
    limits = Limits(lowest=-1.0, highest=2.0)
    assert [limit_step(0.0, None, Read(x), limits)[1].value for x in (-3.0, 0.5, 7.0)] == [-1.0, 0.5, 2.0]


def test_reference_is_the_filter_of_the_control():
    """Of the input that was held until now."""
    law = LedReference(filter_rate=30.0)
    memory, first = smooth_step(0.0, smooth_start(law), Led(1.0), law)
    assert first == (1.0, 0.0, 0.0, 0.0)
    memory, still = smooth_step(0.1, memory, Led(3.0), law)
    memory, found = smooth_step(0.15, memory, Led(3.0), law)
    assert still == (1.0, 0.0, 0.0, 0.0)
    assert tuple(found) == tuple(reference_step(Reference(1.0, 0.0, 0.0, 0.0), 3.0, 0.15 - 0.1, law))


def test_a_leading_reference_is_a_sample_earlier():
    """It moves over the interval before a sample by what is read there."""
    law = LedReference(filter_rate=30.0, leads=1.0)
    memory, _ = smooth_step(0.0, smooth_start(law), Led(1.0), law)
    _, found = smooth_step(0.05, memory, Led(3.0), law)
    assert tuple(found) == tuple(reference_step(Reference(1.0, 0.0, 0.0, 0.0), 3.0, 0.05, law))


def test_sum_and_product():
    weights = Weights(second_weight=-2.0)
    assert sum_step(0.0, None, Summands(5.0, 1.5), weights)[1].value == 2.0
    assert product_step(0.0, None, Factors(3.0, -4.0), None)[1].value == -12.0


def test_table_of_one_and_of_two_inputs():
    one = Grid(places=(0.0, 1.0, 3.0), values=(0.0, 10.0, 30.0))
    assert [table_step(0.0, None, Looked(x), one)[1].value for x in (-1.0, 0.5, 2.0, 9.0)] == [0.0, 5.0, 20.0, 30.0]
    two = Grid(places=(0.0, 1.0), second_places=(0.0, 2.0, 4.0), values=(0.0, 1.0, 10.0, 11.0, 40.0, 41.0))
    places = ((0.5, 1.0), (0.25, 3.0), (1.0, 9.0), (0.0, -1.0))
    assert [table_step(0.0, None, Looked(*at), two)[1].value for at in places] == [5.5, 25.25, 41.0, 0.0]


def test_cycle_repeats_its_points():
    triangle = Cycle(times=(0.0, 1.0, 2.0), values=(0.0, 10.0, 0.0))
    found = [cycle_step(t, None, Now(t), triangle)[1].value for t in (0.0, 0.25, 1.5, 2.0, 7.25)]
    assert found == pytest.approx([0.0, 2.5, 5.0, 0.0, 7.5])


@pytest.mark.parametrize(
    ("duty", "expected"), [(0.25, [1, 1, 0, 0, 1]), (0.0, [0] * 5), (1.0, [1] * 5), (-1.0, [0] * 5), (2.0, [1] * 5)]
)
def test_pulses(duty, expected):
    """At 10 Hz: 0, 20, 30, 90, 110 ms."""
    found = [pulse_command(Duty(t, duty), Pulses(frequency=10.0)) for t in (0.0, 0.02, 0.03, 0.09, 0.11)]
    assert found == expected


def test_the_count_of_pulses_changes_its_floor_at_edges_alone():
    counts = [int(pulse_count(Duty(1e-4 * i + 5e-5, 0.3), Pulses(frequency=10.0))) for i in range(3000)]
    edges = [i for i in range(1, 3000) if counts[i] != counts[i - 1]]
    assert edges == [300, 1000, 1300, 2000, 2300]


# Units


def test_a_gain_has_the_unit_of_the_command_per_unit_of_what_is_read():
    kind = PROGRAMS["pi"].for_quantities([PRESSURE_LEVEL, PRESSURE_LEVEL], FLOW)
    from vvdp.base.params import field_kinds
    from vvdp.base.units import parse

    gain = field_kinds(kind.settings)["gain"]
    assert parse("3 lpm/bar", gain) == pytest.approx(3e-3 / 60 / 1e5)
    assert field_kinds(type(kind.command))["value"] == FLOW
    assert field_kinds(kind.reading)["reference"] is PRESSURE_LEVEL


@pytest.mark.parametrize(
    ("gain", "read", "name"),
    [
        ("0.1 1/bar", PRESSURE_LEVEL, "plain number"),
        ("0.1 1/rpm", SPEED, "plain number"),
        ("2", SPEED, "rotational speed"),
        ("3 rpm/bar", PRESSURE_LEVEL, "rotational speed"),
        ("0.1 lpm/rpm", SPEED, "volume flow"),
        ("1 N*m/rpm", SPEED, "torque"),
        ("2 bar/rpm", SPEED, "pressure level"),
    ],
)
def test_the_quantity_of_a_command_follows_from_the_gain(gain, read, name):
    pi = PROGRAMS["pi"]
    assert pi.output([read], {"gain": gain}).name == name


def test_the_power_of_a_flow_is_a_product():
    assert PROGRAMS["product"].output([PRESSURE_LEVEL, FLOW], {}).unit == "W"


def test_a_mean_of_pressures_is_a_level_and_a_difference_is_none():
    summed = PROGRAMS["sum"].output
    pressures = [PRESSURE_LEVEL, PRESSURE_LEVEL]
    assert (
        summed(pressures, {"first": "", "second": "", "first_weight": "0.5", "second_weight": "0.5"}) is PRESSURE_LEVEL
    )
    assert summed(pressures, {"first": "", "second": "", "second_weight": "-1"}).name == "signed pressure difference"


@pytest.mark.parametrize("name", PROGRAMS)
def test_no_input_has_the_name_of_a_value(name):
    own = getattr(PROGRAMS[name], "type", PROGRAMS[name])
    values = set() if own.settings is None else set(own.settings.__dataclass_fields__)
    assert not values & {*own.reading._fields, "period", "phase", "latency", "previous", "sensors", "type"}
