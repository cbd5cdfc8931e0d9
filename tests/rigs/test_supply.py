"""Who loses least on the pump's flow and pressure: corners by hand, the averages met where they are known, laws."""

from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.tables import Table
from vvdp.control.duty_cycle import DutyCycle, cycle_demand
from vvdp.fluid.mixture import compression_energy_per_volume
from vvdp.hydraulics.supply_losses import drag_power
from vvdp.machines.duties import known_cylinder, shipped_duties
from vvdp.report.plot import new_figure
from vvdp.rivals.supply_claim import WAYS, cycle_losses, supply_claim
from vvdp.rivals.supply_ways import (
    RANGES,
    RIVALS,
    VARIED,
    Assumed,
    Demand,
    averaged_valve,
    rival_losses,
    spread_of,
    varied_assumptions,
    varied_stands,
)
from vvdp.steady.test_stand import stand
from vvdp.systems.system import load_system
from vvdp.valve.torque import pwm_frequency

pytestmark = pytest.mark.thorough

FLOW, LEAKAGE, BAR = 22.8e-6 * 30.0, 2.45e-12, 1e5
"""Of the prototype's pump at 1800 rpm [m^3/s, m^3/(s Pa)]: 41.04 lpm."""


@pytest.fixture(scope="module")
def prototype():
    return stand(load_system("prototype"))


@pytest.fixture(scope="module")
def claim(prototype):
    return supply_claim(prototype)


def demand(share, rise):
    return Demand(np.array([share * FLOW]), np.array([rise]))


@pytest.mark.parametrize(
    ("share", "rise", "expected"),
    [
        # little flow, little pressure: 20 bar margin hold 34.2 cm3/s at 40 bar
        (
            0.05,
            20 * BAR,
            {"metered": 8208.0 - 68.4, "bled_off": 1299.6, "load_sensing": 68.4 + 39.2, "displacement": 9.8,
             "compensated": 342.0 + 352.8, "shared": 0.05 * FLOW * 96e5 + LEAKAGE * 116e5**2},
        ),
        # nearly all the flow, little pressure
        (
            0.9,
            20 * BAR,
            {"metered": 8208.0 - 1231.2, "bled_off": 136.8, "load_sensing": 1231.2 + 39.2, "displacement": 9.8,
             "compensated": 6156.0 + 352.8, "shared": 0.9 * FLOW * 96e5 + LEAKAGE * 116e5**2},
        ),
        # little flow, much pressure: the margin goes beyond the relief setting, and is cut there
        (
            0.05,
            110 * BAR,
            {"metered": 8208.0 - 376.2, "bled_off": 7147.8, "load_sensing": 34.2 + 352.8, "displacement": 296.45,
             "compensated": 34.2 + 352.8, "shared": 34.2 + 352.8},
        ),
    ],
)  # fmt: skip
def test_corners_by_hand(prototype, share, rise, expected):
    found = rival_losses(demand(share, rise), prototype, Assumed(drag=0.0))
    assert {rival: float(loss[0]) for rival, loss in found.items()} == pytest.approx(expected, rel=1e-5)


def test_winners_at_the_corners(claim):
    """Load sensing with little flow, bleeding off near full flow at little pressure; but metering loses to the PWM
    valve at each of them."""
    table = claim.tables["supply"]
    share, rise = table["delivered_share"], table["load_pressure_Pa"] / (120 * BAR)

    def row(flow, load):
        return int(np.argmin(abs(share - flow) + abs(rise - load)))

    assert table["winner"][row(0.05, 0.2)] == RIVALS["load_sensing"]
    assert table["winner"][row(0.9, 0.2)] == RIVALS["bled_off"]
    assert table["winner"][row(0.05, 0.95)] == RIVALS["load_sensing"]
    for corner in ((0.05, 0.2), (0.9, 0.2), (0.05, 0.9)):
        assert table["gain_over_metered_low_W"][row(*corner)] > 0.0
    # 6.6 kW bled off against two transitions and an open valve; 136.8 W against the same
    assert table["gain_over_bled_off_low_W"][row(0.05, 0.9)] > 4000.0
    assert table["gain_over_bled_off_high_W"][row(0.9, 0.1)] < 0.0


def test_averages_are_those_of_the_valve(prototype):
    """At a duty ratio of the grid: Q P_in - q P_L and the compression of the inlet, by the averages themselves."""
    point = prototype.set_point._replace(duty_ratio=0.5)
    means = prototype.means(point)
    tank, oil = prototype.tank_pressure, prototype.bench.oil
    delivered = means.load_flow - prototype.leakage(point)
    rise = point.load_pressure - tank
    found = averaged_valve(Demand(np.array([delivered]), np.array([rise])), prototype)
    frequency = pwm_frequency(means.spool_speed, prototype.bench.valve)
    compressing = frequency * 12.7e-6 * compression_energy_per_volume(point.load_pressure, tank, oil)
    expected = FLOW * (means.inlet_pressure - tank) - delivered * rise + compressing
    assert found.loss[0] == pytest.approx(expected, rel=1e-6)
    assert found.inlet_rise[0] == pytest.approx(means.inlet_pressure - tank, rel=1e-6)


def test_what_the_valve_does_not_deliver_is_unknown(prototype):
    found = averaged_valve(demand(1.01, 50 * BAR), prototype)
    assert np.isnan(found.loss[0]) and np.isnan(found.inlet_rise[0])


def test_the_spread_holds_what_is_as_it_is(prototype):
    shares, rises = np.array([0.1, 0.5, 0.8]), np.array([20.0, 60.0, 100.0]) * BAR
    found = spread_of(Demand(shares * FLOW, rises), prototype)
    for rival in RIVALS:
        gain = found.gain(rival)
        assert np.all(found.lowest[rival] <= gain + 1e-9) and np.all(gain <= found.highest[rival] + 1e-9)
    # 10 and 30 bar instead of 20: half the pump flow times 10 bar either way, at least
    spread = found.highest["load_sensing"] - found.lowest["load_sensing"]
    assert np.all(spread > 2.0 * 10 * BAR * shares * FLOW)


def test_each_assumption_is_varied_alone():
    plain, *others = varied_assumptions()
    assert plain == Assumed()
    for other in others:
        (name,) = (key for key in RANGES if getattr(other, key) != getattr(plain, key))
        assert getattr(other, name) in RANGES[name]
        low, high = RANGES[name]
        assert low <= getattr(plain, name) <= high


def without_ranges(entry):
    if not isinstance(entry, dict):
        return entry
    return {key: without_ranges(value) for key, value in entry.items() if key != "range"}


def test_each_range_of_the_file_is_gone_through(prototype):
    """Both ends of six values; without ranges there is nothing to vary."""
    known = {row.setting for row in prototype.bench.system.uncertainties}
    assert set(VARIED) <= known
    assert len(list(varied_stands(prototype))) == 1 + 2 * len(VARIED)
    system = prototype.bench.system
    plain = system.read_from(Table(system.name, without_ranges(system.content), {}))
    assert len(list(varied_stands(stand(plain)))) == 1


def test_drag_is_in_every_way(prototype):
    """6 % instead of none of Q/omega times the pressure that the pump is under."""
    here = demand(0.3, 60 * BAR)
    without, dragged = (rival_losses(here, prototype, Assumed(drag=share)) for share in (0.0, 0.06))
    for rival, held in (("bled_off", 60), ("load_sensing", 80), ("compensated", 120), ("displacement", 60)):
        more = float(dragged[rival][0] - without[rival][0])
        assert more == pytest.approx(0.06 * FLOW * held * BAR, rel=1e-3), rival
        speed = prototype.set_point.pump_speed
        assert more == pytest.approx(drag_power(held * BAR, speed, FLOW / speed, 0.0, 0.06), rel=1e-3)


# Duty cycles


def test_demand_of_a_cycle_by_hand():
    """5.4 cm/s out against 1000 N: 109.4 cm3/s at 5.47 bar. Back the load overruns: 58.2 cm3/s at none."""
    triangle = shipped_duties()[0].cycle
    found = cycle_demand(triangle, *known_cylinder())
    half = found.time.size // 2
    assert found.time.sum() == pytest.approx(8.0)
    assert found.flow[:half] == pytest.approx(109.404e-6) and found.flow[half:] == pytest.approx(58.158e-6)
    assert found.rise[:half] == pytest.approx(1108.0 / 20.26e-4) and np.all(found.rise[half:] == 0.0)
    waits = DutyCycle(times=(0.0, 1.0, 3.0, 4.0), positions=(0.1, 0.2, 0.2, 0.1), forces=(-5e3,) * 4)
    found = cycle_demand(waits, *known_cylinder())
    assert np.all(found.flow[8:16] == 0.0) and np.all(found.rise[8:16] == 0.0)
    assert found.time[8:16].sum() == pytest.approx(2.0)


def test_mean_losses_of_the_triangle_by_hand(prototype):
    """Bled off (Q - 109.4 cm3/s) 5.469 bar for half the time; metered Q 60 bar less what arrives; 3 % drag each."""
    found = cycle_losses(prototype, shipped_duties()[:1])
    rise = 1108.0 / 20.26e-4
    assert found.means["bled_off"][0] == pytest.approx(0.5 * (1.03 * FLOW - 109.404e-6) * rise, rel=1e-5)
    assert found.means["metered"][0] == pytest.approx(1.03 * FLOW * 60e5 - 0.5 * 109.404e-6 * rise, rel=1e-5)


def test_a_cycle_beyond_the_pump_is_told(prototype):
    fast = replace(
        shipped_duties()[0],
        name="fast",
        cycle=DutyCycle(times=(0.0, 0.5, 1.0), positions=(0.05, 0.25, 0.05), forces=(-1e3,) * 3),
    )
    claim = supply_claim(prototype, [fast])
    assert any(each.text == wording.rig.too_little_flow.format(duty="fast") for each in claim.findings)


# The claim


def test_every_way_is_told_on_every_cycle(claim):
    words = [finding.text for finding in claim.findings]
    for duty in shipped_duties():
        (told,) = [each for each in words if each.startswith(f"On {duty.name} ")]
        assert all(name in told for name in RIVALS.values())
    assert claim.tables["duty_cycles"].rows == len(shipped_duties())
    for rival in RIVALS:
        low, here, high = (claim.numbers[f"won_over_{rival}{end}"].value for end in ("_low", "", "_high"))
        assert 0.0 <= low <= here <= high <= 1.0


def test_the_shipped_valve_wins_nowhere_over_all(claim):
    """20 bar cost less than its transitions wherever they are not bled off more cheaply still."""
    assert claim.numbers["won_over_all_but_displacement"].value == 0.0
    assert claim.numbers["won_over_displacement_high"].value == 0.0
    assert 0.3 < claim.numbers["won_over_bled_off"].value < 0.6
    assert claim.numbers["won_over_load_sensing"].value < 0.1


def test_pictures_are_drawn(claim):
    gains, winners = (new_figure(chart, claim.tables) for chart in claim.charts)
    assert len(gains.axes) == len(RIVALS)
    assert {text.get_text() for text in winners.axes[0].get_legend().get_texts()} <= set(WAYS.values())
