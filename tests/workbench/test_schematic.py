"""The diagram of the page: mean values, and the course of the last periods."""

import re

import numpy as np
import pytest

from vvdp.runs.simulate import run_system
from vvdp.systems.options import lasting
from vvdp.systems.system import load_system, shipped_systems
from vvdp.workbench.schematic import course_of, drawing, mean_texts, means

LITRES_PER_MINUTE = 6e4


def run_of(name, until):
    system = load_system(name)
    return run_system(system.read_from(lasting(system.table, until)))


@pytest.mark.parametrize("name", sorted(shipped_systems())[::4])
def test_every_mean_has_one_place(name):
    system = load_system(name)
    svg = drawing(system)
    found = re.findall(r'data-mean="([^"]+)"', svg)
    inner = {part for each in system.circuit.network.circuits.values() for part in each.names}
    assert sorted(found) == sorted(each.key for each in means(system) if each.part not in inner)
    assert not re.search("[\ue000-\uf8ff]", svg)


def test_mean_values_are_those_of_the_run():
    run = run_of("buck-converter", "0.1 s")
    texts = mean_texts(run.system, run.summary, is_draft=False)
    assert texts["pressure_mean_node_Pa"] == f"mean {run.summary['pressure_mean_node_Pa'] / 1e5:.1f} bar"
    flow = LITRES_PER_MINUTE * run.summary["flow_mean_tube_m3_s"]
    assert texts["flow_mean_tube_m3_s"] == f"mean {flow:.2f} lpm"
    assert set(mean_texts(run.system, run.summary, is_draft=True)) == {"pressure_mean_node_Pa"}
    unknown = {**run.summary, "pressure_mean_node_Pa": float("nan")}
    assert (
        mean_texts(run.system, unknown, is_draft=False)["pressure_mean_node_Pa"] == "mean not known (no whole period)"
    )


def test_what_flows_into_a_volume_over_a_period_leaves_it():
    """Oil is neither made nor lost: over a whole period of a settled run the flows into a node add up to nothing."""
    course = course_of(run_of("buck-converter", "0.4 s"))
    begin, end = course.period
    assert end - begin == pytest.approx(0.01, rel=1e-6)  # the valve switches at 100 Hz
    rows = (course.times >= begin) & (course.times <= end)
    into = {
        key: np.trapezoid(course.flows[key][rows], course.times[rows]) for key in ("valve.b", "check_valve.b", "tube.a")
    }
    assert into["valve.b"] > 0 > into["tube.a"]
    # records are 20 us apart: at each of four edges up to half a step of the 5 ms in which the valve is open is missed
    assert abs(sum(into.values())) < 4 * 0.5 * 20e-6 / 5e-3 * into["valve.b"]


def test_ports_open_and_close():
    course = course_of(run_of("prototype", "0.3 s"))
    load, tank = course.openings["valve.load"], course.openings["valve.tank"]
    assert load.min() == tank.min() == 0.0 and load.max() == tank.max() == 1.0
    assert np.all((load < 0.5) | (tank < 0.5))
    area = course_of(run_of("buck-converter", "0.1 s")).openings
    assert area["valve.a"].max() == 1.0 and np.array_equal(area["valve.a"], area["valve.b"])
