"""Junctions: places without oil, whose pressure is the one at which as much flows in as out."""

import copy
from typing import Any

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.tables import Table
from vvdp.evaluation.summary import summary
from vvdp.hydraulics.junction import HIGHEST, TOLERANCE, begin_search, next_search
from vvdp.network.junction_text import is_found_compiled
from vvdp.simulation.run import Run, simulate
from vvdp.studies.run import run_study
from vvdp.studies.study import Study
from vvdp.systems.system import System, built_system

ORIFICE = {"type": "orifice", "discharge_coefficient": "0.6", "transition_pressure": "1e-4 bar"}
SERIES: dict[str, Any] = {
    "oil": {"air_fraction": "0 %", "liquid_bulk_modulus": "1e4 GPa"},
    "nodes": {
        "supply": {"type": "pressure-source", "pressure": {"ramp": ["0 bar", "200 bar"], "from": "0 s", "to": "1 s"}},
        "middle": {"type": "junction"},
        "tank": {"type": "tank"},
    },
    "components": {
        "first": {**ORIFICE, "a": "supply", "b": "middle", "area": "5 mm^2"},
        "second": {**ORIFICE, "a": "middle", "b": "tank", "area": "10 mm^2"},
    },
    "run": {"until": "1 s"},
}
"""Two orifices in series, as good as incompressible: the joint is at 1/(1 + (10/5)^2) = 1/5 of the supply."""
LINE = {"type": "volume", "volume": "20 cc", "start": "0 bar"}
PUMP = {"type": "flow-source", "a": "tank", "b": "middle", "flow": "30 lpm"}
RELIEF = {
    "type": "relief-valve", "a": "middle", "b": "tank", "cracking_pressure": "100 bar", "override_pressure": "10 bar",
    "rated_flow": "40 lpm",
}  # fmt: skip
CYLINDER = {
    "type": "cylinder", "a": "middle", "b": "tank", "rod": "rod", "area_a": "2000 mm^2", "area_b": "1000 mm^2",
    "moving_mass": "10 kg", "stroke": "50 mm", "leakage_conductance": "0 m^3/(s*Pa)",
}  # fmt: skip


def changed(**changes: Any) -> System:
    """The series with other entries, by path with __ for the dots; None takes one away."""
    content = copy.deepcopy(SERIES)
    for path, value in changes.items():
        *tables, key = path.split("__")
        table = content
        for name in tables:
            table = table.setdefault(name, {})
        if value is None:
            del table[key]
        else:
            table[key] = value
    return built_system(Table("series.toml", content, {}), "series")


def run(system: System) -> Run:
    return simulate(system.model, system.case, system.stepping)


def test_two_orifices_share_the_drop_by_their_areas() -> None:
    found = run(changed())
    middle, supply = found.outputs.middle_pressure - 101325.0, found.outputs.supply_pressure - 101325.0
    late = found.times > 0.01
    np.testing.assert_allclose(middle[late], 0.2 * supply[late], rtol=1e-5)
    # 200 bar over both: 0.6 * sqrt(2 * 160e5 / 876) * 5e-6 m^3/s, with the oil of 40 degC
    density = 876.0 * (1.0 - 7e-4 * 25.0)
    assert found.outputs.first_flow[-1] == pytest.approx(0.6 * (2 * 160e5 / density) ** 0.5 * 5e-6, rel=2e-2)


def test_no_oil_is_lost_and_no_energy() -> None:
    system = changed(components__third={**ORIFICE, "a": "middle", "b": "line", "area": "2 mm^2"}, nodes__line=LINE)
    found = summary(system, run(system))
    assert abs(found["mass_residual"]) < 1e-9
    assert abs(found["energy_residual"]) < 1e-8
    assert found["flow_mean_first_m3_s"] == pytest.approx(
        found["flow_mean_second_m3_s"] + found["flow_mean_third_m3_s"], rel=1e-9
    )
    assert found["trusted"]


def test_a_small_volume_comes_to_the_same_pressure() -> None:
    """What the junction leaves out falls with the volume in its place."""
    source = {"type": "pressure-source", "pressure": {"sine": "100 bar", "amplitude": "50 bar", "frequency": "20 Hz"}}
    usual = {"nodes__supply": source, "oil": {"air_fraction": "0.5 %"}}
    exact = run(changed(**usual))
    misses = []
    for volume in ("40 cc", "20 cc", "10 cc"):
        near = run(changed(**usual, nodes__middle={"type": "volume", "volume": volume, "start": "20 bar"}))
        times = np.linspace(0.2, 0.9, 500)
        apart = np.interp(times, near.times, near.state.middle) - np.interp(
            times, exact.times, exact.outputs.middle_pressure
        )
        misses.append(np.sqrt(np.mean(apart**2)))
    assert misses[0] / misses[1] == pytest.approx(2.0, rel=0.1)
    assert misses[1] / misses[2] == pytest.approx(2.0, rel=0.1)


def test_a_pump_pushes_beyond_all_pressures_around() -> None:
    """30 lpm over a relief valve that needs 10 bar for 40 lpm: 100 + 7.5 bar at its inlet."""
    system = changed(components={"pump": PUMP, "relief": RELIEF}, nodes__supply=None)
    found = summary(system, run(system))
    assert found["pressure_mean_middle_Pa"] == pytest.approx(107.5e5, rel=2e-3)
    assert found["flow_mean_relief_m3_s"] == pytest.approx(5e-4, rel=1e-9)
    assert abs(found["mass_residual"]) < 1e-9


def test_a_pump_against_a_shut_valve_is_not_trusted() -> None:
    shut = {**RELIEF, "cracking_pressure": "5000 bar"}
    system = changed(components={"pump": PUMP, "relief": shut}, nodes__supply=None)
    found = summary(system, run(system))
    assert not found["trusted"]
    assert found["pressure_max_middle_Pa"] > 4999e5


def test_lanes_find_the_same_pressure(tmp_path) -> None:
    """Cases side by side have no early end of the search, and the same pressures."""
    system = changed(nodes__line=LINE, components__third={**ORIFICE, "a": "middle", "b": "line", "area": "2 mm^2"})
    keys = ("pressure_mean_middle_Pa", "flow_mean_first_m3_s", "mass_residual")
    areas = ["4 mm^2", "5 mm^2", "6 mm^2"]
    found = run_study(Study(system, {"components.first.area": areas}, keys), tmp_path)
    for case, area in enumerate(areas):
        single = changed(
            nodes__line=LINE, components__third={**ORIFICE, "a": "middle", "b": "line", "area": "2 mm^2"},
            components__first={**ORIFICE, "a": "supply", "b": "middle", "area": area},
        )  # fmt: skip
        expected = summary(single, run(single))
        assert [found.outputs[key].values[case] for key in keys[:2]] == pytest.approx(
            [expected[key] for key in keys[:2]], rel=1e-9
        )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"components__second": {**RELIEF, "override_pressure": "0 bar"}}, "second.*is ideal.*'middle' holds no oil"),
        ({"components__second": CYLINDER, "nodes__rod": {"type": "rod"}}, "moves a wall there.*'middle' holds no oil"),
        (
            {"nodes__next": {"type": "junction"}, "components__second__b": "next",
             "components__third": {**ORIFICE, "a": "next", "b": "tank", "area": "1 mm^2"}},
            "joins the junctions 'middle' and 'next'",
        ),
        ({"heat": {"start_temperature": "40 degC"}}, "middle.*needs oil"),
        ({"nodes__middle": {"type": "volume", "volume": "0 cc", "start": "0 bar"}}, 'a node of type "junction"'),
    ],
    ids=["ideal", "walls", "two", "heat", "zero volume"],
)  # fmt: skip
def test_what_needs_oil_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        changed(**changes)


@pytest.mark.parametrize("root", [0.0, 1.0, 3.7e5, 2.0e7, 9.9e8])
@pytest.mark.parametrize("exponent", [0.2, 1.0, 5.0])
def test_every_search_ends_within_its_rounds(root: float, exponent: float) -> None:
    """Roots within and beyond the pressures around, for flat, straight and steep laws."""
    search, rounds = begin_search(1e5, 2e7), 0
    while not is_found_compiled(search):
        asked = search.guess
        search = next_search(search, np.sign(root - asked) * (abs(root - asked) / 1e7) ** exponent)
        rounds += 1
    assert rounds < 54
    assert asked == pytest.approx(root, abs=2.0 * TOLERANCE)
    assert search.high <= HIGHEST
