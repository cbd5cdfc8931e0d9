"""Linear valves in the place of the rotary one: the source's data by hand, their loss by quasi-steady integration."""

import numpy as np
import pytest

from vvdp.base.signal import constant
from vvdp.hydraulics.orifice import orifice_area_for
from vvdp.hydraulics.switching_valve import SpoolState, SwitchingValve, port_areas, spool_frequency, spool_rate
from vvdp.report.plot import new_figure
from vvdp.rivals.linear_valve_claim import linear_valve_claim
from vvdp.rivals.linear_valves import (
    EDGE,
    VALVES,
    equal_loss_frequency,
    highest_frequency,
    rotary_drop,
    switched_loss,
    valves_for,
)

LPM = 1e-3 / 60.0
KAJIMA, LU, CUI = VALVES[:3]


def test_how_many_valves_by_hand():
    """60 lpm at 60 bar are 20 lpm at 6.67 bar: two for 40 lpm. Of 8 lpm at 100 bar it takes 19.4."""
    assert valves_for(KAJIMA, 40 * LPM, 60e5 / 9.0) == pytest.approx(2.0, rel=1e-12)
    assert valves_for(LU, 40 * LPM, 60e5 / 9.0) == pytest.approx(5.0 * np.sqrt(15.0), rel=1e-12)
    assert highest_frequency(KAJIMA) == pytest.approx(500.0) and highest_frequency(CUI) == pytest.approx(250.0)


def test_a_spool_is_over_in_its_switching_time():
    """By small steps: from rest at one end it comes to the other one in 1 ms."""
    values = SwitchingValve(
        natural_frequency=spool_frequency(1e-3, 0.7), damping_ratio=0.7, stroke=1e-3, full_area=1e-5
    )
    spool, step, time = SpoolState(0.0, 0.0), 1e-7, 0.0
    while spool.position < 1e-3:
        time += step
        rate = spool_rate(1.0, spool, 0.0, 0.0, values)
        half = SpoolState(spool.position + 0.5 * step * rate.position, spool.velocity + 0.5 * step * rate.velocity)
        rate = spool_rate(1.0, half, 0.0, 0.0, values)
        spool = SpoolState(spool.position + step * rate.position, spool.velocity + step * rate.velocity)
    assert time == pytest.approx(1e-3, rel=1e-3)


def hand_loss(stand, switching_time, frequency):
    """Mean loss at duty ratio 0.5 with stiff oil and an ideal relief valve, by the areas of a spool on its way."""
    point, rho = stand.set_point, 876.0
    flow, relief = stand.pump_flow(point), stand.relief_pressure - stand.tank_pressure
    load = point.load_pressure - stand.tank_pressure
    area = orifice_area_for(flow, rotary_drop(stand), rho, EDGE)
    values = SwitchingValve(
        natural_frequency=spool_frequency(switching_time, 0.7), damping_ratio=0.7, stroke=1e-3, full_area=area
    )
    w, z = 2.0 * np.pi * values.natural_frequency, 0.7
    v, time = w * np.sqrt(1.0 - z * z), np.linspace(0.0, switching_time, 20_001)
    travel = 1.0 - np.exp(-z * w * time) * (np.cos(v * time) + z * w / v * np.sin(v * time))

    def lost(to_load, to_tank):
        """Power lost at an instant: at the pressure that the one open port needs, at most that of the relief valve."""
        opened, behind = (to_load, load) if to_load > 0.0 else (to_tank, 0.0)
        drop = 0.5 * rho * (flow / (0.61 * opened)) ** 2 if opened > 0.0 else np.inf
        inlet = min(behind + drop, relief)
        through = 0.61 * opened * np.sqrt(2.0 * (inlet - behind) / rho)
        return flow * inlet - (through * load if to_load > 0.0 else 0.0)

    areas = [port_areas(1e-3 * float(x), values) for x in travel]
    opening = np.trapezoid([lost(each.first, each.second) for each in areas], time)
    shutting = np.trapezoid([lost(each.second, each.first) for each in areas], time)
    rest = (0.5 / frequency - switching_time) * (lost(area, 0.0) + lost(0.0, area))
    return frequency * (opening + shutting + rest)


@pytest.mark.parametrize(("switching_time", "frequency"), [(1e-3, 50.0), (2e-3, 100.0)])
def test_loss_by_quasi_steady_integration(source_stand, switching_time, frequency):
    """An ideal relief valve, no leakage, hardly any oil in the inlet."""
    stiff = source_stand.with_tables(
        relief_valve={"override_pressure": 0.0}, pump={"leakage_conductance": 0.0}, inlet={"volume": 1e-7},
        oil={"air_fraction": 0.0, "liquid_bulk_modulus": 2e10, "thermal_expansion": 0.0},
    )  # fmt: skip
    found = switched_loss(stiff, switching_time, frequency)
    assert found.loss == pytest.approx(hand_loss(stiff, switching_time, frequency), rel=5e-3)


def test_loss_grows_evenly_with_the_frequency(source_stand):
    """What is lost in a transition is lost as often as there are any; the open valve loses the same."""
    losses = [switched_loss(source_stand, 1e-3, f).loss for f in (50.0, 100.0, 200.0)]
    assert losses[2] - losses[1] == pytest.approx(2.0 * (losses[1] - losses[0]), rel=0.02)
    open_ = 2.0 * losses[0] - losses[1]
    assert open_ == pytest.approx(source_stand.pump_flow(source_stand.set_point) * rotary_drop(source_stand), rel=0.3)


def test_equal_loss_by_hand():
    assert equal_loss_frequency([10.0, 20.0, 40.0], [100.0, 200.0, 400.0], 300.0) == pytest.approx(30.0)
    assert np.isnan(equal_loss_frequency([10.0, 20.0], [100.0, 200.0], 90.0))


def test_the_claim(source_stand, monkeypatch):
    monkeypatch.setattr("vvdp.rivals.linear_valve_claim.FREQUENCIES", (50.0, 100.0, 300.0))
    claim = linear_valve_claim(source_stand.with_tables(operation={"duty_ratio": constant(0.3)}))
    table, swept = claim.tables["linear_valves"], claim.tables["linear_switching"]
    assert table.rows == len(VALVES) and swept.rows == 3 + 3 + 2
    known = np.isfinite(table["loss_W"])
    assert known.tolist() == [np.isfinite(valve.drop) for valve in VALVES]
    rotary = claim.numbers["rotary_valve_loss_W"].value
    assert np.all(table["loss_W"][known] < rotary)
    assert np.all(np.diff(table["loss_W"][known]) > 0.0)  # the slower, the more
    (figure,) = (new_figure(chart, claim.tables) for chart in claim.charts)
    assert len(figure.axes) == 1
